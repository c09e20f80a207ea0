//! `midway info`.

use midway_device::{Bytes, DeviceKind};
use midway_render::{PackedScene, RenderSettings};
use midway_scene::{Bounds, Camera, Material, Projection, Scene, Sides, Surface};
use serde_json::{Value, json};

use crate::{
    args::InfoArgs,
    console, light_info,
    scene_file::{self, LoadedScene},
    status::{OrStatus, Outcome, Status},
};

/// Prints what a scene file holds.
///
/// # Errors
/// [`Status::Input`] if it cannot be read, or cannot be rendered.
pub fn run(args: &InfoArgs) -> Outcome {
    let loaded = scene_file::load_variant(&args.scene, &args.root, args.variant.as_deref())?;
    let memory = Memory::of(&loaded.scene)?;
    if args.json {
        return console::output(&to_json(&loaded, &memory).to_string());
    }
    scene_file::print_warnings(&loaded.warnings());
    let lines = to_lines(&loaded);
    lines.iter().chain([&memory.to_line()]).try_for_each(|line| console::output(line))
}

/// Bytes that the scene takes on a device, to which a render adds film and paths.
struct Memory {
    hierarchies: u64,
    geometry: u64,
    images: u64,
}

impl Memory {
    fn of(scene: &Scene) -> Outcome<Self> {
        let packed = PackedScene::new(scene, &scene.cameras[0], &RenderSettings::default(), DeviceKind::Cpu)
            .or_status(Status::Input)?;
        Ok(Self {
            hierarchies: size_of_val(&packed.nodes[..]) as u64,
            geometry: (size_of_val(&packed.triangles[..]) + size_of_val(&packed.scene[..])) as u64,
            images: packed.images.bytes(),
        })
    }

    fn total(&self) -> u64 {
        self.hierarchies + self.geometry + self.images
    }

    fn to_json(&self) -> Value {
        json!({
            "hierarchies_bytes": self.hierarchies, "geometry_bytes": self.geometry,
            "images_bytes": self.images, "total_bytes": self.total(),
        })
    }

    fn to_line(&self) -> String {
        let [total, hierarchies, geometry, images] =
            [self.total(), self.hierarchies, self.geometry, self.images].map(Bytes);
        format!(
            "memory     {total} on the device: hierarchies {hierarchies}, geometry and lights {geometry}, images {images}"
        )
    }
}

fn to_json(loaded: &LoadedScene, memory: &Memory) -> Value {
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
        "images": counts.images,
        "memory": memory.to_json(),
        "variants": loaded.variants.names(),
        "variant": loaded.variant,
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
    let height = match camera.projection {
        Projection::Perspective { .. } => None,
        Projection::Orthographic { height } => Some(height),
    };
    json!({
        "name": camera.name,
        "yfov_degrees": camera.yfov().map(f32::to_degrees),
        "orthographic_height": height,
        "lens_radius": camera.lens_radius,
        "focus_distance": camera.focus_distance,
        "resolution": camera.resolution,
        "aspect": camera.aspect,
        "position": camera.position().to_array(),
    })
}

/// What a scene holds, for people.
pub fn to_lines(loaded: &LoadedScene) -> Vec<String> {
    let scene = &loaded.scene;
    let counts = scene.counts();
    let Bounds { min, max } = scene.bounds();
    let mut lines = vec![
        format!("triangles  {} ({} emit)", counts.triangles, counts.emissive_triangles),
        format!("meshes     {} in {} instances", counts.meshes, counts.instances),
        format!("images     {}", counts.images),
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
    lines.extend(variant_lines(loaded));
    lines.push(format!("materials  {}", counts.materials));
    lines.extend(scene.materials.iter().enumerate().map(|(index, material)| {
        let [r, g, b] = material.emission.value.to_array();
        let emits = if material.is_emissive() { format!(", emits {r} {g} {b}") } else { String::new() };
        format!("  {index} {}: {}{emits}", name(&material.name), surface_name(&material.surface))
    }));
    lines
}

/// Nothing where the file has none.
fn variant_lines(loaded: &LoadedScene) -> Vec<String> {
    let (variants, variant) = (loaded.variants.names(), &loaded.variant);
    let taken = match variant {
        Some(name) => format!("{name} is taken"),
        None => "the default materials are taken, --variant NAME takes one".to_owned(),
    };
    let first = (!variants.is_empty()).then(|| format!("variants   {}: {taken}", variants.len()));
    let names = variants.iter().enumerate().map(|(index, variant)| format!("  {index} {}", name(variant)));
    first.into_iter().chain(names).collect()
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
