//! Loading a scene, with its warnings.

use std::path::Path;

use midway_import::{ImportError, NO_LIGHT, Options, Variants, Warning, WarningKind};
use midway_scene::Scene;

use crate::{
    args::{LightGroupsArg, RootArg},
    console,
    status::{Failure, Outcome, Status},
};

/// A scene that can be rendered.
pub struct LoadedScene {
    /// Valid by [`Scene::validate`], as the importer promises.
    pub scene: Scene,
    /// The file's variants of materials.
    pub variants: Variants,
    /// The name of the one that was taken.
    pub variant: Option<String>,
    /// What the file has and Midway does not use, once each.
    warnings: Vec<String>,
}

impl LoadedScene {
    /// Adds to the warnings.
    pub fn warn(&mut self, warnings: &[Warning]) {
        self.warnings.extend(warnings.iter().map(ToString::to_string));
    }

    /// What was left out, and whether the image will be black.
    pub fn warnings(&self) -> Vec<String> {
        let no_light = (!self.scene.has_light()).then(|| NO_LIGHT.to_owned());
        self.warnings.iter().cloned().chain(no_light).collect()
    }
}

/// Reads and checks a scene file, with the materials that it has by default.
///
/// # Errors
/// As [`load_variant`].
pub fn load(path: &Path, root: &RootArg) -> Outcome<LoadedScene> {
    load_variant(path, root, None)
}

/// Reads and checks a scene file, with the materials of a variant where one is named.
///
/// # Errors
/// [`Status::Usage`] where there is no such variant, with those that there are, or where the root does
/// not hold the scene; else [`Status::Input`], naming the file.
pub fn load_variant(path: &Path, root: &RootArg, variant: Option<&str>) -> Outcome<LoadedScene> {
    let options = Options { variant: variant.map(str::to_owned), root: root.root.clone() };
    let (import, warnings) = midway_import::load_with(path, &options);
    // Flags may bring light: whether there is any is asked when the warnings are.
    let of_file = warnings.into_iter().filter(|warning| warning.kind != WarningKind::NoLight);
    let warnings: Vec<String> = of_file.map(|warning| warning.to_string()).collect();
    let (scene, variants) = import.map_err(|error| {
        print_warnings(&warnings);
        match error {
            ImportError::UnknownVariant { .. } => Failure::usage(format!("--variant: {error}")),
            ImportError::OutsideRoot { .. } => Failure::usage(format!("--root: {error}")),
            ImportError::UnsafePath { .. } => Failure::new(Status::Input, format!("{error} (--root FOLDER)")),
            _ => Failure::new(Status::Input, error),
        }
    })?;
    Ok(LoadedScene { scene, variants, variant: options.variant, warnings })
}

/// Refuses a root where no scene is read.
///
/// # Errors
/// [`Status::Usage`] where there is one.
pub fn refuse_root(root: &RootArg) -> Outcome {
    match &root.root {
        Some(_) => Err(Failure::usage("--root: no scene file is read whose files could lie there")),
        None => Ok(()),
    }
}

/// Prints the warnings, each on a line.
pub fn print_warnings(warnings: &[String]) {
    warnings.iter().for_each(|warning| console::warning(warning));
}

/// Puts lights into groups by their names.
///
/// # Errors
/// [`Status::Usage`] where a name is no light's, with those that there are.
pub fn group_lights(scene: &mut Scene, asked: Option<&LightGroupsArg>) -> Outcome {
    let Some(LightGroupsArg(rules)) = asked else { return Ok(()) };
    let known = scene.light_groups().names.join(", ");
    match scene.group_lights(rules).first() {
        Some(unknown) => {
            Err(Failure::usage(format!("--light-groups: no light is called '{unknown}'; there are: {known}")))
        }
        None => Ok(()),
    }
}
