//! Loading a scene, with its warnings.

use std::path::Path;

use midway_scene::Scene;

use crate::{
    console,
    status::{OrStatus, Outcome, Status},
};

/// A scene that can be rendered.
pub struct LoadedScene {
    /// Valid by [`Scene::validate`], as the importer promises.
    pub scene: Scene,
    /// What the file has and Midway does not use, once each.
    pub warnings: Vec<String>,
}

/// Reads and checks a scene file.
///
/// # Errors
/// [`Status::Input`], naming the file.
pub fn load(path: &Path) -> Outcome<LoadedScene> {
    let import = midway_import::load(path).or_status(Status::Input)?;
    let warnings = import.warnings.iter().map(ToString::to_string).collect();
    Ok(LoadedScene { scene: import.scene, warnings })
}

/// Prints the warnings, each on a line.
pub fn print_warnings(warnings: &[String]) {
    warnings.iter().for_each(|warning| console::warning(warning));
}
