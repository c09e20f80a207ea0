//! Glass whose index of refraction differs by colour.

use glam::Vec3;
use midway_scene::{Material, MetallicRoughness, Roughness, Scene, Surface};

use crate::shapes::{Shape, add, camera, diffuse};

/// Index of green, and a dispersion whose Abbe number is 1.25: red's index is 1.3, blue's 1.7.
pub const IOR: f32 = 1.5;
/// See [`IOR`].
pub const DISPERSION: f32 = 16.0;

/// The index of each channel, by the formula of `KHR_materials_dispersion`.
pub fn indices() -> [f32; 3] {
    let spread = (IOR - 1.0) * 0.025 * DISPERSION;
    [IOR - spread, IOR, IOR + spread]
}

fn clear(alpha: f32, sigma_a: f32, ior: f32, dispersion: f32) -> Material {
    Material::new(Surface::Dielectric {
        ior,
        dispersion,
        reflection: Vec3::ONE.into(),
        transmission: Vec3::new(0.7, 0.6, 0.7).into(),
        sigma_a: Vec3::splat(sigma_a),
        thin: false,
        roughness: Roughness::alpha(alpha),
    })
}

/// Mostly glass, otherwise diffuse, under a thin coat.
fn mostly_clear(roughness: f32, sigma_a: f32, ior: f32, dispersion: f32) -> Material {
    Material::new(Surface::MetallicRoughness(Box::new(MetallicRoughness {
        base_color: Vec3::new(0.5, 0.6, 0.7).into(),
        ior,
        dispersion,
        transmission: 0.95.into(),
        thin: false,
        sigma_a: Vec3::splat(sigma_a),
        roughness: roughness.into(),
        clearcoat: 0.1.into(),
        clearcoat_roughness: 0.6.into(),
        ..MetallicRoughness::default()
    })))
}

/// A block and two balls of smooth glass, below a wide lamp in a coloured room.
pub fn smooth_room(ior: f32, dispersion: f32) -> Scene {
    let mut scene = Scene::default();
    let wall = diffuse(Vec3::new(0.4, 0.5, 0.4), Vec3::ZERO);
    add(&mut scene, Shape::cuboid(-Vec3::ONE, Vec3::ONE).inside_out(), wall);
    let lamp = Shape::parallelogram(Vec3::new(-1.0, 0.95, -1.0), 2.0 * Vec3::X, 2.0 * Vec3::Z);
    add(&mut scene, lamp, diffuse(Vec3::ZERO, Vec3::new(1.2, 1.6, 2.0)));
    let block = Shape::cuboid(Vec3::new(-0.75, -0.9, -0.4), Vec3::new(-0.25, 0.0, 0.0));
    add(&mut scene, block, clear(0.0, 1.0, ior, dispersion));
    let ball = Shape::icosphere(2, Vec3::new(0.1, -0.3, 0.2), 0.3);
    add(&mut scene, ball, clear(0.0, 1.0, ior, dispersion));
    let ball = Shape::icosphere(2, Vec3::new(0.6, -0.5, -0.4), 0.35);
    add(&mut scene, ball, mostly_clear(0.0, 1.0, ior, dispersion));
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, 0.95), Vec3::new(0.0, -0.2, 0.0), 85.0));
    scene
}

/// A lamp that shines up at two blocks of dark, rough glass, and a floor that has its light from them alone: by
/// what they reflect, which differs most between channels.
pub fn rough_blocks(ior: f32, dispersion: f32) -> Scene {
    let mut scene = Scene::default();
    let floor = Shape::parallelogram(Vec3::new(-1.0, -0.8, 1.0), 2.0 * Vec3::X, -2.0 * Vec3::Z);
    add(&mut scene, floor, diffuse(Vec3::new(0.7, 0.6, 0.5), Vec3::ZERO));
    let lamp = Shape::parallelogram(Vec3::new(-0.5, -0.6, -0.5), Vec3::Z, Vec3::X);
    add(&mut scene, lamp, diffuse(Vec3::ZERO, Vec3::new(6.0, 4.0, 3.0)));
    let block = Shape::cuboid(Vec3::new(-1.0, 0.0, -1.0), Vec3::new(-0.05, 0.5, 1.0));
    add(&mut scene, block, clear(0.4, 8.0, ior, dispersion));
    let block = Shape::cuboid(Vec3::new(0.05, 0.0, -1.0), Vec3::new(1.0, 0.5, 1.0));
    add(&mut scene, block, mostly_clear(0.6, 8.0, ior, dispersion));
    scene.cameras.push(camera(Vec3::new(0.0, -0.3, 1.9), Vec3::new(0.0, -0.4, 0.0), 60.0));
    scene
}
