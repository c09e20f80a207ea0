//! Instances that share their mesh's geometry against copies of it.

use glam::{EulerRot, Mat4, Quat, Vec3};
use midway_device::DeviceKind;
use midway_render::{Integrator, IntegratorSettings, PackedScene, RenderSettings};
use midway_scene::{Instance, Mesh, Scene};
use midway_tests::{
    estimate::{cpu, render},
    shapes::{Shape, add, camera, diffuse, glass},
};

use crate::support::{in_turn, settings};

/// Of the balls in the room: so many of so many triangles that they are placed, not baked.
const N_BALLS: u32 = 15;

/// A room with a lamp, and balls in it, every other one mirrored and every third one of glass; `shared`:
/// the balls are instances of two meshes, or each one of its own.
fn scene(shared: bool) -> Scene {
    let (lamp, walls) = Shape::cuboid(-Vec3::ONE, Vec3::ONE).inside_out().split(|triangle| triangle / 2 == 3);
    let mut scene = Scene::default();
    add(&mut scene, walls, diffuse(Vec3::splat(0.5), Vec3::ZERO));
    add(&mut scene, lamp, diffuse(Vec3::ZERO, Vec3::ONE));
    scene.materials.extend([diffuse(Vec3::splat(0.7), Vec3::ZERO), glass(1.5)]);
    let ball = |material: u32| {
        let shape = Shape::icosphere(5, Vec3::ZERO, 1.0).smooth(Vec3::ZERO);
        let Shape { positions, normals, triangles } = shape;
        Mesh { positions, normals, triangles, material, ..Mesh::default() }
    };
    let first = scene.meshes.len() as u32;
    if shared {
        scene.meshes.extend([ball(2), ball(3)]);
    }
    for i in 0..2 * N_BALLS {
        let is_glass = i % 2;
        let side = if i % 3 == 1 { -1.0 } else { 1.0 };
        let scale = Vec3::new(0.1, 0.15 * side, 0.2);
        let turn = Quat::from_euler(EulerRot::XYZ, i as f32, 0.5 * i as f32, 0.0);
        let at = Vec3::new((i % 5) as f32 - 2.0, (i / 5 % 3) as f32 - 1.2, (i / 15) as f32 - 1.2) * 0.38;
        let mesh = if shared { first + is_glass } else { scene.meshes.len() as u32 };
        if !shared {
            scene.meshes.push(ball(2 + is_glass));
        }
        scene.instances.push(Instance {
            mesh,
            world_from_mesh: Mat4::from_scale_rotation_translation(scale, turn, at),
            light_group: None,
        });
    }
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, 0.95), Vec3::ZERO, 80.0));
    scene
}

/// The same random numbers meet the same triangles. Normals are packed in another frame, so that they
/// differ by 1e-4: glass sends a few paths past an edge by that, the more the longer they are, and splats spread
/// what they carry.
#[test]
fn instances_render_as_copies_do() {
    let _turn = in_turn();
    let (shared, copied) = (scene(true), scene(false));
    let packed = |scene: &Scene| {
        PackedScene::new(scene, &scene.cameras[0], &RenderSettings::default(), DeviceKind::Cpu)
            .expect("packed")
    };
    let (with, without) = (packed(&shared), packed(&copied));
    assert_eq!((with.n_instances, without.n_instances), (2 * N_BALLS, 0));
    assert!(5 * with.scene.len() < without.scene.len() && 5 * with.nodes.len() < without.nodes.len());
    for integrator in [Integrator::Path, Integrator::Bdpt] {
        let integrator = IntegratorSettings { integrator, ..IntegratorSettings::default() };
        let image = |scene: &Scene| {
            let settings = RenderSettings { max_path_length: Some(6), ..settings(32, integrator, 5) };
            render(&cpu(), scene, &settings, 8)
        };
        let (a, b) = (image(&shared), image(&copied));
        let (a, b) = (a.pixels.as_flattened(), b.pixels.as_flattened());
        let differs = |(a, b): (&f32, &f32)| (a - b).abs() > 1e-2 * b.max(1e-2);
        let n_different = a.iter().zip(b).filter(|&pair| differs(pair)).count();
        let mean = |values: &[f32]| values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len() as f64;
        println!(
            "{:?}: {n_different} of {} differ; means {} and {}",
            integrator.integrator,
            a.len(),
            mean(a),
            mean(b)
        );
        assert!(n_different <= a.len() / 100, "{n_different} of {} values differ", a.len());
        assert!((mean(a) / mean(b) - 1.0).abs() <= 5e-3);
    }
}
