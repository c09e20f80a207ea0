//! Rooms with glass whose index of refraction differs by colour.

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

/// A block and a ball of coloured glass, and a ball that is half glass under a coat, below a wide lamp in a
/// coloured room. `rough`: the glass is of facets.
pub fn room(rough: bool, ior: f32, dispersion: f32) -> Scene {
    let mut scene = Scene::default();
    let wall = diffuse(Vec3::new(0.4, 0.5, 0.4), Vec3::ZERO);
    add(&mut scene, Shape::cuboid(-Vec3::ONE, Vec3::ONE).inside_out(), wall);
    let lamp = Shape::parallelogram(Vec3::new(-1.0, 0.95, -1.0), 2.0 * Vec3::X, 2.0 * Vec3::Z);
    add(&mut scene, lamp, diffuse(Vec3::ZERO, Vec3::new(1.2, 1.6, 2.0)));
    let clear = Surface::Dielectric {
        ior,
        dispersion,
        reflection: Vec3::ONE.into(),
        transmission: Vec3::new(0.7, 0.6, 0.7).into(),
        sigma_a: Vec3::new(1.5, 1.0, 1.0),
        thin: false,
        roughness: Roughness::alpha(if rough { 0.4 } else { 0.0 }),
    };
    let half = MetallicRoughness {
        ior,
        dispersion,
        transmission: 0.6.into(),
        thin: false,
        roughness: if rough { 0.6 } else { 0.0 }.into(),
        clearcoat: 0.5.into(),
        clearcoat_roughness: 0.6.into(),
        ..MetallicRoughness::default()
    };
    let block = Shape::cuboid(Vec3::new(-0.75, -0.9, -0.4), Vec3::new(-0.25, 0.0, 0.0));
    add(&mut scene, block, Material::new(clear.clone()));
    add(&mut scene, Shape::icosphere(2, Vec3::new(0.1, -0.3, 0.2), 0.3), Material::new(clear));
    let half = Material::new(Surface::MetallicRoughness(Box::new(half)));
    add(&mut scene, Shape::icosphere(2, Vec3::new(0.6, -0.5, -0.4), 0.35), half);
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, 0.95), Vec3::new(0.0, -0.2, 0.0), 85.0));
    scene
}
