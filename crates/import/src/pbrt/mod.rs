//! pbrt's scenes, of version 4 and version 3.
//!
//! Both are streams of directives that change a graphics state; a shape or a light is made with the
//! state at its place. The file is v3's where it has `WorldEnd` or a film `"image"`, which v4 has
//! not: black bodies, spectra and the film's sensitivity have other meanings there (see `lights`).

mod camera;
mod colours;
mod directives;
mod environment;
mod files;
mod later;
mod lex;
mod lights;
mod materials;
mod materials_v3;
mod params;
mod quadrics;
mod shapes;
mod state;
mod textures;
mod world;

use std::path::Path;

use midway_scene::Scene;

use crate::{
    ImportError, Place,
    files::{self as scene_files, SceneFolder},
    warning::Warnings,
};
use colours::Version;
use directives::Interpreter;

pub(crate) fn load(path: &Path, folder: SceneFolder, warnings: &mut Warnings) -> Result<Scene, ImportError> {
    let mut bytes = scene_files::read_scene(path, true)?;
    if bytes.starts_with(&[0x1f, 0x8b]) {
        bytes = files::unpacked(&bytes, &Place::new(path, ""))?;
    }
    let text = String::from_utf8_lossy(&bytes);
    let mut interpreter = Interpreter::new(folder, version(&text), warnings);
    interpreter.main(path, &text)?;
    interpreter.finish(path)
}

/// By what only v3 has.
fn version(text: &str) -> Version {
    let is_v3 = |line: &str| {
        let line = line.trim_start();
        line.starts_with("WorldEnd") || line.starts_with("Film \"image\"")
    };
    if text.lines().any(is_v3) { Version::V3 } else { Version::V4 }
}
