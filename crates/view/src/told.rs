//! What browsers are told, as JSON.

use midway_render::{RenderStats, Renderer};
use midway_scene::{Camera, Scene};
use serde_json::{Value, json};

use crate::{
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

/// What browsers are told of a scene: with the names of its variants of materials and the place of the one that
/// is taken, and with what is around it.
pub fn scene_message(
    scene: &Scene,
    name: &str,
    camera: &Camera,
    (variants, variant): (&[String], Option<u32>),
    surroundings: Surroundings,
) -> Value {
    let (bounds, counts) = (scene.bounds(), scene.counts());
    let groups = scene.light_groups().names;
    let cameras: Vec<Value> = scene.cameras.iter().map(|camera| view_of(scene, camera)).collect();
    json!({
        "type": "scene", "name": name, "triangles": counts.triangles,
        "lights": counts.emissive_triangles + scene.lights.len(),
        "cameras": cameras, "view": view_of(scene, camera),
        "bounds": [bounds.min.to_array(), bounds.max.to_array()],
        "environment": surroundings, "variants": variants, "variant": variant, "groups": Value::from_iter(groups.iter().map(|name| &**name)),
    })
}

/// A camera as browsers know it.
fn view_of(scene: &Scene, camera: &Camera) -> Value {
    let eye = camera.position();
    let direction = |axis: glam::Vec3| camera.world_from_camera.transform_vector3(axis).normalize();
    let distance = eye.distance(pick::middle(scene, camera));
    json!({
        "name": camera.name, "eye": eye.to_array(), "up": direction(glam::Vec3::Y).to_array(),
        "target": (eye + direction(glam::Vec3::NEG_Z) * distance).to_array(),
        "fov": camera.yfov().map(f32::to_degrees), "lens": camera.lens_radius, "focus": camera.focus_distance,
    })
}
