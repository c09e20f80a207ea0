//! The rays that are traced.

use std::sync::Arc;

use glam::Vec3;
use midway_device::Device;
use midway_kernels::native;
use midway_scene::{Bounds, Camera, Projection, Scene};

use super::Question;
use crate::{BounceRays, RenderError, RenderSettings, Renderer};

/// Bounces that are measured each alone; those after them together.
const BOUNCES_ALONE: usize = 3;

/// Rays to be traced together.
pub(super) struct Batch {
    pub name: String,
    /// What they ask; both where none.
    pub question: Option<Question>,
    /// Two vec4 each: origin and t_max; direction.
    pub rays: Vec<[f32; 4]>,
}

/// For each path whose rays are recorded there are so many rays of other kinds: a path has several of its own.
pub(super) const RAYS_A_PATH: u32 = 16;

/// Every batch of a scene: of about `n_rays` rays through pixels and from anywhere, and what a sample of each
/// pixel of `path` traces, `n_rays` / [`RAYS_A_PATH`] pixels of the whole image.
pub(super) fn all(device: &Arc<dyn Device>, scene: &Scene, n_rays: u32) -> Result<Vec<Batch>, RenderError> {
    let bounds = scene.bounds();
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&bounds, 1.0));
    let mut batches = vec![
        Batch { name: "camera".to_owned(), question: None, rays: camera_rays(&camera, n_rays) },
        Batch { name: "random".to_owned(), question: None, rays: random_rays(&bounds, n_rays) },
    ];
    if scene.has_light() {
        batches.extend(recorded(device, scene, &camera, n_rays)?);
    }
    Ok(batches)
}

fn recorded(
    device: &Arc<dyn Device>,
    scene: &Scene,
    camera: &Camera,
    n_rays: u32,
) -> Result<Vec<Batch>, RenderError> {
    let side = (f64::from(n_rays / RAYS_A_PATH).sqrt() as u32).max(1);
    let settings = RenderSettings { width: side, height: side, ..RenderSettings::default() };
    let recorded = Renderer::new(device.clone(), scene, camera, settings)?.record_rays()?;
    let mut batches: Vec<Batch> = Vec::new();
    for (index, bounce) in recorded.into_iter().flat_map(|batch| batch.into_iter().enumerate()) {
        let name = match index {
            0..BOUNCES_ALONE => format!("bounce {}", index + 1),
            _ => format!("bounces {}+", BOUNCES_ALONE + 1),
        };
        for (question, rays) in [(Question::Closest, bounce.closest), (Question::Any, bounce.shadow)] {
            let asked = Some(question);
            match batches.iter_mut().find(|batch| batch.name == name && batch.question == asked) {
                Some(batch) => batch.rays.extend(rays),
                None => batches.push(Batch { name: name.clone(), question: asked, rays }),
            }
        }
    }
    batches.retain(|batch| !batch.rays.is_empty());
    Ok(batches)
}

/// What was recorded, each question in one batch.
pub(super) fn replayed(recorded: Vec<Vec<BounceRays>>) -> Vec<Batch> {
    let of = |question| Batch { name: "recorded".to_owned(), question: Some(question), rays: Vec::new() };
    let (mut closest, mut any) = (of(Question::Closest), of(Question::Any));
    for bounce in recorded.into_iter().flatten() {
        closest.rays.extend(bounce.closest);
        any.rays.extend(bounce.shadow);
    }
    [closest, any].into_iter().filter(|batch| !batch.rays.is_empty()).collect()
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
