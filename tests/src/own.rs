//! The repository's own scenes.

use std::path::Path;

use midway_scene::Scene;

/// Their files in `scenes/`.
pub const SCENES: [&str; 3] = ["cornell-box.gltf", "glass-caustic.gltf", "lamp.gltf"];

/// Loads one of them.
pub fn load(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name);
    midway_import::load(&path).expect("the repository's scenes load").scene
}
