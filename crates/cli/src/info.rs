//! `midway info`.

use midway_scene::{Bounds, Camera, Material, Projection, Scene, Sides, Surface};
use serde_json::{Value, json};

use crate::{
    args::InfoArgs,
    console, light_info,
    scene_file::{self, LoadedScene},
    status::Outcome,
};

/// Prints what a scene file holds.
///
/// # Errors
/// [`crate::status::Status::Input`] if it cannot be read.
pub fn run(args: &InfoArgs) -> Outcome {
    let loaded = scene_file::load(&args.scene)?;
    if args.json {
        return console::output(&to_json(&loaded).to_string());
    }
    scene_file::print_warnings(&loaded.warnings());
    to_lines(&loaded.scene).iter().try_for_each(|line| console::output(line))
}

fn to_json(loaded: &LoadedScene) -> Value {
    let scene = &loaded.scene;
    let counts = scene.counts();
    let bounds = scene.bounds();
    json!({
        "hash": scene.hash(),
        "triangles": counts.triangles,
        "emissive_triangles": counts.emissive_triangles,
        "meshes": counts.meshes,
        "instances": counts.instances,
        "bounds": { "min": bounds.min.to_array(), "max": bounds.max.to_array() },
        "materials": Value::from_iter(scene.materials.iter().map(material_json)),
        "cameras": Value::from_iter(scene.cameras.iter().map(camera_json)),
        "lighting": light_info::to_json(scene),
        "warnings": loaded.warnings(),
    })
}

fn material_json(material: &Material) -> Value {
    json!({
        "name": material.name,
        "surface": surface_name(&material.surface),
        "emission": material.emission.value.to_array(),
        "emits_both_sides": material.emits == Sides::Both,
    })
}

fn camera_json(camera: &Camera) -> Value {
    json!({
        "name": camera.name,
        "yfov_degrees": camera.yfov().map(f32::to_degrees),
        "aspect": camera.aspect,
        "position": camera.position().to_array(),
    })
}

/// What a scene holds, for people.
pub fn to_lines(scene: &Scene) -> Vec<String> {
    let counts = scene.counts();
    let Bounds { min, max } = scene.bounds();
    let mut lines = vec![
        format!("triangles  {} ({} emit)", counts.triangles, counts.emissive_triangles),
        format!("meshes     {} in {} instances", counts.meshes, counts.instances),
        format!("bounds     ({}, {}, {}) to ({}, {}, {})", min.x, min.y, min.z, max.x, max.y, max.z),
        format!("hash       {}", scene.hash()),
        format!("cameras    {}", counts.cameras),
    ];
    lines.extend(scene.cameras.iter().enumerate().map(|(index, camera)| {
        let aspect = camera.aspect.map_or(String::new(), |aspect| format!(", aspect {aspect:.3}"));
        let view = match camera.projection {
            Projection::Perspective { yfov } => format!("{:.1} degrees high", yfov.to_degrees()),
            Projection::Orthographic { height } => format!("orthographic, {height} high"),
        };
        format!("  {index} {}: {view}{aspect}", name(&camera.name))
    }));
    lines.extend(light_info::to_lines(scene));
    lines.push(format!("materials  {}", counts.materials));
    lines.extend(scene.materials.iter().enumerate().map(|(index, material)| {
        let [r, g, b] = material.emission.value.to_array();
        let emits = if material.is_emissive() { format!(", emits {r} {g} {b}") } else { String::new() };
        format!("  {index} {}: {}{emits}", name(&material.name), surface_name(&material.surface))
    }));
    lines
}

fn name(name: &str) -> &str {
    if name.is_empty() { "(no name)" } else { name }
}

fn surface_name(surface: &Surface) -> &'static str {
    match surface {
        Surface::Diffuse { .. } => "diffuse",
        Surface::Conductor { .. } => "conductor",
        Surface::Dielectric { thin: false, .. } => "dielectric",
        Surface::Dielectric { thin: true, .. } => "thin dielectric",
        Surface::Plastic { .. } => "plastic",
        Surface::MetallicRoughness(_) => "metallic-roughness",
        Surface::Null => "nothing",
    }
}
