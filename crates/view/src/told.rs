//! What browsers are told, as JSON.

use glam::Vec3;
use midway_render::{RenderStats, Renderer};
use midway_scene::{Bounds, Camera, Projection, Scene};
use serde_json::{Value, json};

use crate::{
    nothing::is_nothing,
    pick,
    protocol::{Method, Surroundings},
};

/// What browsers are told of a renderer.
pub fn figures(renderer: &Renderer, stats: &RenderStats, seconds: f64, rays: u64) -> Value {
    let settings = renderer.settings();
    json!({
        "integrator": settings.integrator.describe(), "method": Method::of(&settings.integrator),
        "samples": renderer.samples(), "seconds": seconds, "rays": rays,
        "mrays": rays as f64 / seconds.max(1e-9) / 1e6,
        "rejected": stats.rejected, "overflowed": stats.overflowed,
        "size": [settings.width, settings.height], "bias": settings.bias(),
        "memory": renderer.plan().total(),
    })
}

/// What browsers are told of a scene that changes with nothing they ask for. To find it all triangles are asked.
pub struct Outline {
    bounds: Bounds,
    cameras: Vec<Value>,
}

impl Outline {
    /// Of a scene.
    pub fn of(scene: &Scene) -> Self {
        let view = |camera: &Camera| view_of(camera, pick::middle(scene, camera));
        Self { bounds: scene.bounds(), cameras: scene.cameras.iter().map(view).collect() }
    }

    /// A box around the scene.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }
}

/// What browsers are told of a scene: seen by a camera that is turned about a place; with the names of its
/// variants of materials and the place of the one that is taken, and with what is around it.
pub fn scene_message(
    (scene, outline, name): (&Scene, &Outline, &str),
    (camera, target): (&Camera, Vec3),
    (variants, variant): (&[String], Option<u32>),
    surroundings: Surroundings,
) -> Value {
    let (bounds, counts) = (outline.bounds, scene.counts());
    let groups = scene.light_groups().names;
    let n_triangles = if is_nothing(scene) { 0 } else { counts.triangles };
    json!({
        "type": "scene", "name": name, "triangles": n_triangles,
        "lights": counts.emissive_triangles + scene.lights.len(),
        "cameras": outline.cameras, "view": view_of(camera, target),
        "bounds": [bounds.min.to_array(), bounds.max.to_array()],
        "environment": surroundings, "variants": variants, "variant": variant, "groups": Value::from_iter(groups.iter().map(|name| &**name)),
    })
}

/// A camera as browsers know it, turned about a place in front of it.
pub fn view_of(camera: &Camera, target: Vec3) -> Value {
    let eye = camera.position();
    let direction = |axis: Vec3| camera.world_from_camera.transform_vector3(axis).normalize();
    let distance = eye.distance(target);
    let height = match camera.projection {
        Projection::Orthographic { height } => Some(height),
        Projection::Perspective { .. } => None,
    };
    json!({
        "name": camera.name, "eye": eye.to_array(), "up": direction(Vec3::Y).to_array(),
        "target": (eye + direction(Vec3::NEG_Z) * distance).to_array(),
        "fov": camera.yfov().map(f32::to_degrees), "height": height, "lens": camera.lens_radius, "focus": camera.focus_distance,
    })
}
