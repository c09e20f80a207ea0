//! What is shown before there is a scene.

use glam::{Mat4, Vec3};
use midway_scene::{Instance, Material, Mesh, Scene, Surface};

/// A scene in which nothing is seen: a renderer needs a triangle, and this one lets all light through.
pub fn nothing() -> Scene {
    let mesh =
        Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], triangles: vec![[0, 1, 2]], ..Mesh::default() };
    Scene {
        meshes: vec![mesh],
        instances: vec![Instance { mesh: 0, world_from_mesh: Mat4::IDENTITY, light_group: None }],
        materials: vec![Material::new(Surface::Null)],
        ..Scene::default()
    }
}

/// Whether no surface of a scene is seen.
pub fn is_nothing(scene: &Scene) -> bool {
    scene.materials.iter().all(|material| material.surface == Surface::Null && !material.is_emissive())
}
