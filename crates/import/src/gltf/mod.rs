//! glTF 2.0, as `.gltf` with buffers beside it or as `.glb`.
//!
//! The JSON is walked as it is, each value with its pointer, so that every error and warning says
//! where, and so that a lie about an index or a length is met by a check and not by a reader that
//! trusts a schema (the `gltf` crate's own validation indexes out of bounds on bad input).

mod accessors;
mod attributes;
mod buffers;
mod cameras;
mod check;
mod container;
mod draco;
mod instancing;
mod json;
mod lights;
mod materials;
mod meshes;
mod meshopt;
mod nodes;
mod textures;
mod unused;
mod variants;

use std::path::Path;

use midway_scene::Scene;

use crate::{
    ImportError, Place,
    files::{self, SceneFolder},
    warning::{WarningKind, Warnings},
};
use accessors::Accessors;
use buffers::Buffers;
use json::Json;
use meshes::Meshes;
use textures::Textures;
use variants::Variants;

pub(crate) use container::GLB_MAGIC;

/// Extensions that are read, wholly or as far as warnings say.
const SUPPORTED_EXTENSIONS: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    variants::EXTENSION,
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

/// Extensions without which a file is still understood: no image depends on them.
const HARMLESS_EXTENSIONS: &[&str] = &["KHR_animation_pointer", "KHR_xmp_json_ld"];

/// The scene, in the variant of that name where one is wanted, and all variants.
pub(crate) fn load(
    path: &Path,
    mut folder: SceneFolder,
    variant: Option<&str>,
    warnings: &mut Warnings,
) -> Result<(Scene, crate::Variants), ImportError> {
    let bytes = files::read_scene(path, false)?;
    let (text, binary) = container::open(path, &bytes)?;
    let value = json::parse(path, text)?;
    let root = Json::root(path, &value);
    check_version(&root)?;
    check::list(&value, warnings);
    check_required_extensions(&root)?;
    let variants = Variants::read(&root, variant)?;

    let buffers = Buffers::load(&root, &mut folder, binary)?;
    let accessors = Accessors::new(&root, &buffers, bytes.len() as u64)?;
    let mut textures = Textures::new(&root, &buffers, &folder, bytes.len() as u64)?;
    let mut materials = materials::read_all(&root, &mut textures, warnings)?;
    let mut meshes = Meshes::new(&root, accessors, materials.len(), &variants)?;
    // Images are all known by now, and nothing else needs them.
    let mut of_images = Warnings::default();
    let (placed, images) =
        rayon::join(|| nodes::walk(&root, &mut meshes, warnings), || textures.into_images(&mut of_images));
    let placed = placed?;
    unused::warn(&root, warnings)?;
    warnings.append(of_images);
    if meshes.uses_default_material() {
        materials.push(materials::default_material());
    }
    let (meshes, variants) = meshes.into_parts();
    let scene = Scene {
        cameras: placed.cameras,
        meshes,
        instances: placed.instances,
        materials,
        images,
        lights: placed.lights,
        environment: None,
        environment_group: None,
    };
    Ok((scene, variants))
}

fn check_version(root: &Json) -> Result<(), ImportError> {
    let asset = root.required("asset")?;
    let version = asset.required("version")?;
    let text = version.string()?;
    if text.starts_with("2.") {
        return Ok(());
    }
    Err(version.malformed(format!("it is glTF {text:?}, and 2.x is read")))
}

fn check_required_extensions(root: &Json) -> Result<(), ImportError> {
    for required in root.items("extensionsRequired")? {
        let name = required.string()?;
        if !SUPPORTED_EXTENSIONS.contains(&name) && !HARMLESS_EXTENSIONS.contains(&name) {
            let (place, extension) = (required.place(), name.to_owned());
            return Err(ImportError::UnsupportedExtension { place, extension });
        }
    }
    Ok(())
}

/// Warns of the extensions of an object that are not read.
fn warn_of_extensions(object: &Json, warnings: &mut Warnings) -> Result<(), ImportError> {
    if let Some(extensions) = object.get("extensions") {
        for (name, extension) in extensions.members()? {
            if !SUPPORTED_EXTENSIONS.contains(&name) {
                warnings.add(WarningKind::Extension, extension.pointer(), unused_extension(name));
            }
        }
    }
    Ok(())
}

fn unused_extension(name: &str) -> String {
    format!("the extension {name} is not used")
}

/// Where a whole file is meant.
fn file_place(path: &Path) -> Place {
    Place::new(path, "")
}
