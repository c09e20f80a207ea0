//! Wavefront OBJ with MTL materials.
//!
//! Read here and not by `tobj`, which knows no smoothing groups and no line numbers and panics on
//! some bad lines (`Kd 0.5`).

mod build;
mod maps;
mod mtl;
mod parse;
mod shape;
mod surface;
mod text;

use std::path::Path;

use midway_scene::Scene;

use crate::{
    ImportError, Place, default_material,
    files::{self, SceneFolder},
    images::Images,
    warning::{WarningKind, Warnings},
};
use maps::{Maps, Origin};
use mtl::Library;
pub(crate) use shape::shape;

pub(crate) fn load(path: &Path, folder: SceneFolder, warnings: &mut Warnings) -> Result<Scene, ImportError> {
    let bytes = files::read_scene(path, true)?;
    let text = String::from_utf8_lossy(&bytes);
    let obj = parse::parse(path, &text, warnings)?;
    let library = load_libraries(path, &folder, &obj, warnings)?;

    let mut scene = Scene::default();
    let mut images = Images::default();
    let mut indices = Vec::with_capacity(obj.materials.len());
    for (name, line) in &obj.materials {
        let mut maps = Maps { folder: &folder, images: &mut images, warnings };
        let known = library.material(name, &mut maps)?;
        if known.is_none() {
            let message = match name.as_str() {
                "" => "faces without a material are rendered as diffuse grey".to_owned(),
                name => format!("the material {name:?} is not defined: rendered as diffuse grey"),
            };
            warnings.add(WarningKind::Approximation, text::place_of(path, *line), message);
        }
        indices.push(scene.materials.len() as u32);
        scene.materials.push(known.unwrap_or_else(default_material));
    }
    scene.images = images.decode(warnings);
    build::build(&obj, &indices, &mut scene, warnings, path)?;
    Ok(scene)
}

/// Reads the material libraries; one that is not there can be done without.
fn load_libraries(
    path: &Path,
    folder: &SceneFolder,
    obj: &parse::Obj,
    warnings: &mut Warnings,
) -> Result<Library, ImportError> {
    let mut library = Library::default();
    for (names, line) in &obj.libraries {
        let place = Place::new(path, line.to_string());
        let names = names.replace('\\', "/");
        let mut read = |name: &str| {
            let name = maps::reachable(name, folder);
            match folder.read_text(name, &place) {
                Ok(bytes) => {
                    let origin = Origin { library: name, folder };
                    library.read(path, origin, &String::from_utf8_lossy(&bytes), warnings)?;
                    Ok(true)
                }
                Err(ImportError::MissingBuffer { .. }) => Ok(false),
                Err(other) => Err(other),
            }
        };
        // A line may name several files, and a file's name may have spaces.
        if read(&names)? {
            continue;
        }
        let words: Vec<&str> = names.split_whitespace().collect();
        let mut missing = Vec::new();
        for &word in &words {
            if words.len() == 1 || !read(word)? {
                missing.push(word);
            }
        }
        let missing = if missing.len() == words.len() { vec![&*names] } else { missing };
        for name in missing {
            let message = format!("the material file {name:?} does not exist");
            warnings.add(WarningKind::MissingFile, text::place_of(path, *line), message);
        }
    }
    Ok(library)
}
