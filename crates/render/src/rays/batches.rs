//! The rays that are traced.

use glam::Vec3;
use midway_kernels::native;
use midway_scene::{Bounds, Camera, Projection, Scene};

/// Where rays come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// Through the pixels of a square image, row by row.
    Camera,
    /// From anywhere in the scene's bounds in any direction.
    Random,
}

/// Rays to be traced together.
pub(super) struct Batch {
    pub name: String,
    /// Two vec4 each: origin and t_max; direction.
    pub rays: Vec<[f32; 4]>,
}

/// Every batch of a scene, each of about `n_rays` rays.
pub(super) fn all(scene: &Scene, n_rays: u32) -> Vec<Batch> {
    let bounds = scene.bounds();
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&bounds, 1.0));
    vec![
        Batch { name: "camera".to_owned(), rays: camera_rays(&camera, n_rays) },
        Batch { name: "random".to_owned(), rays: random_rays(&bounds, n_rays) },
    ]
}

fn ray(origin: Vec3, direction: Vec3, t_max: f32) -> [[f32; 4]; 2] {
    [origin.extend(t_max).to_array(), direction.extend(0.0).to_array()]
}

fn camera_rays(camera: &Camera, n_rays: u32) -> Vec<[f32; 4]> {
    let side = f64::from(n_rays).sqrt() as u32;
    let axis = |v: Vec3| camera.world_from_camera.transform_vector3(v).normalize();
    let (right, up, forward) = (axis(Vec3::X), axis(Vec3::Y), axis(Vec3::NEG_Z));
    let place = |pixel: u32| {
        let at = |i: u32| (i as f32 + 0.5) / side as f32 * 2.0 - 1.0;
        at(pixel % side) * right - at(pixel / side) * up
    };
    let through = |pixel: u32| match camera.projection {
        Projection::Perspective { yfov } => {
            ray(camera.position(), (forward + (yfov * 0.5).tan() * place(pixel)).normalize(), f32::MAX)
        }
        Projection::Orthographic { height } => {
            ray(camera.position() + 0.5 * height * place(pixel), forward, f32::MAX)
        }
    };
    (0..side * side).flat_map(through).collect()
}

fn random_rays(bounds: &Bounds, n_rays: u32) -> Vec<[f32; 4]> {
    let one = |index: u32| {
        let [x, y, z, _] = native::random4(index, 0, 0, 2);
        let [u, v, ..] = native::random4(index, 1, 0, 2);
        let cos = 1.0 - 2.0 * u;
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let phi = std::f32::consts::TAU * v;
        let direction = Vec3::new(sin * phi.cos(), cos, sin * phi.sin());
        ray(bounds.min + Vec3::new(x, y, z) * (bounds.max - bounds.min), direction, f32::MAX)
    };
    (0..n_rays).flat_map(one).collect()
}
