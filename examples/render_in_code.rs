//! Builds a scene in code, renders it by two integrators and compares their means.
//!
//! `cargo run --release -p midway-examples --bin render_in_code -- picture.png`

use std::{path::Path, sync::Arc};

use anyhow::{Context, Result, ensure};
use glam::{Mat4, Vec3};
use midway_device::{Device, OpenOptions, open_device};
use midway_film::{Display, Image, Metadata, write_png};
use midway_render::{Integrator, IntegratorSettings, RenderSettings, Renderer};
use midway_scene::{Camera, Instance, Material, Mesh, Scene, Surface};

/// Samples a pixel of each render.
const SAMPLES: u64 = 64;
/// How far the two integrators' means may lie apart: some standard errors at these samples.
const TOLERANCE: f64 = 0.05;

fn main() -> Result<()> {
    let output = std::env::args_os().nth(1).context("give the path of a PNG to write")?;
    let scene = scene();
    scene.validate()?;
    let device = open_device("auto", &OpenOptions::default())?;
    println!("device: {}", device.info().name);

    let path = render(&device, &scene, Integrator::Path)?;
    let bdpt = render(&device, &scene, Integrator::Bdpt)?;
    let ratio = bdpt.mean()[1] / path.mean()[1];
    println!("bdpt over path: {ratio:.4}");
    ensure!((ratio - 1.0).abs() <= TOLERANCE, "the integrators disagree");

    write_png(Path::new(&output), &bdpt, Display::default(), &Metadata::new())?;
    Ok(())
}

fn render(device: &Arc<dyn Device>, scene: &Scene, integrator: Integrator) -> Result<Image> {
    let settings = RenderSettings {
        width: 96,
        height: 64,
        integrator: IntegratorSettings { integrator, ..IntegratorSettings::default() },
        ..RenderSettings::default()
    };
    let mut renderer = Renderer::new(device.clone(), scene, &scene.cameras[0], settings)?;
    while renderer.samples() < SAMPLES {
        renderer.step(SAMPLES - renderer.samples())?;
    }
    Ok(renderer.image()?)
}

/// A floor of 4 m by 4 m with a mirror standing at its far end, under a lamp that shines down.
fn scene() -> Scene {
    let material = |name: &str, surface| Material { name: name.to_owned(), ..Material::new(surface) };
    let grey = |level| Surface::diffuse(Vec3::splat(level));
    let floor = quad("floor", 0, Vec3::ZERO, Vec3::X * 2.0, Vec3::NEG_Z * 2.0);
    let mirror = quad("mirror", 1, Vec3::new(0.0, 1.0, -2.0), Vec3::X * 1.5, Vec3::Y);
    let lamp = quad("lamp", 2, Vec3::new(0.0, 2.0, 0.0), Vec3::X * 0.5, Vec3::Z * 0.5);
    // Looks along -z, a little down.
    let world_from_camera = Mat4::from_translation(Vec3::new(0.0, 1.5, 5.0)) * Mat4::from_rotation_x(-0.15);
    Scene {
        cameras: vec![Camera::perspective(world_from_camera, 0.7)],
        instances: (0..3)
            .map(|mesh| Instance { mesh, world_from_mesh: Mat4::IDENTITY, light_group: None })
            .collect(),
        meshes: vec![floor, mirror, lamp],
        materials: vec![
            material("floor", grey(0.6)),
            material("mirror", Surface::mirror(Vec3::splat(0.9))),
            material("lamp", grey(0.0)).emitting(Vec3::new(8.0, 7.0, 6.0)),
        ],
        ..Scene::default()
    }
}

/// A rectangle about `centre` with these half edges; its front is on the side of `x` cross `y`.
fn quad(name: &str, material: u32, centre: Vec3, x: Vec3, y: Vec3) -> Mesh {
    Mesh {
        name: name.to_owned(),
        positions: vec![centre - x - y, centre + x - y, centre + x + y, centre - x + y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Mesh::default()
    }
}
