//! Readers of scene files, one per format, with structured warnings.
//!
//! A file is not trusted: every offset, count and index is checked against what the file holds,
//! references stay inside the scene's folder (or [`Options::root`]), and nothing is fetched from a
//! network. What the file says and the scene cannot hold is listed in [`Import::warnings`], each kind
//! of thing once.
//!
//! ```no_run
//! let import = midway_import::load("scenes/cornell-box.gltf".as_ref())?;
//! for warning in &import.warnings {
//!     eprintln!("{warning}");
//! }
//! println!("{} triangles", import.scene.counts().triangles);
//! # Ok::<(), midway_import::ImportError>(())
//! ```

mod disney;
mod environment;
mod error;
mod files;
mod geometry;
mod gltf;
mod images;
mod metals;
mod mitsuba;
mod mixture;
mod obj;
mod pbrt;
mod ply;
mod spectrum;
mod variants;
mod warning;

use std::path::{Path, PathBuf};

use glam::Vec3;
use midway_scene::{Camera, Material, Scene, Surface};

use files::SceneFolder;
use warning::Warnings;

pub use environment::load_environment;
pub use error::{ImportError, Place};
pub use variants::Variants;
pub use warning::{Warning, WarningKind};

/// The formats read, for messages and help.
pub const FORMATS: &str =
    "glTF 2.0 (.gltf, .glb), Wavefront OBJ (.obj), PLY (.ply), Mitsuba (.xml) and pbrt (.pbrt)";

/// What is said of a scene without lights.
pub const NO_LIGHT: &str = "nothing emits light: the image will be black";

/// How a scene is read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Take the materials of the variant of that name (`KHR_materials_variants`); without one, those
    /// that the file has by default.
    pub variant: Option<String>,
    /// The folder that everything the scene refers to has to lie in, and the scene itself; without
    /// one, the scene's own folder. Neither `..` nor links lead out of it.
    pub root: Option<PathBuf>,
}

/// A scene as read, and what was left out of it.
#[derive(Clone, Debug)]
pub struct Import {
    /// Valid: [`Scene::validate`] has passed. Has at least one camera, framed on the bounds where
    /// the file has none.
    pub scene: Scene,
    /// The file's variants of materials, of which [`Options::variant`] takes one.
    pub variants: Variants,
    /// What the file says and the scene does not.
    pub warnings: Vec<Warning>,
}

/// Reads a scene, by the path's extension, or as GLB where the content says so.
///
/// # Errors
///
/// [`ImportError`], one clear line: what is wrong, where, and what to do.
pub fn load(path: &Path) -> Result<Import, ImportError> {
    let (loaded, warnings) = load_with(path, &Options::default());
    loaded.map(|(scene, variants)| Import { scene, variants, warnings })
}

/// Like [`load`], as the options say, with the warnings that there were before the error where there
/// is one. A variant that the file has not is [`ImportError::UnknownVariant`], a root that does not
/// hold the scene [`ImportError::OutsideRoot`].
pub fn load_with(path: &Path, options: &Options) -> (Result<(Scene, Variants), ImportError>, Vec<Warning>) {
    let mut warnings = Warnings::default();
    let loaded = load_complete(path, options, &mut warnings);
    (loaded, warnings.into_list())
}

fn load_complete(
    path: &Path,
    options: &Options,
    warnings: &mut Warnings,
) -> Result<(Scene, Variants), ImportError> {
    let folder = SceneFolder::of(path, options.root.as_deref())?;
    let variant = options.variant.as_deref();
    let (mut scene, variants) = if is_gltf(path)? {
        gltf::load(path, folder, variant, warnings)?
    } else if let Some(name) = variant {
        return Err(ImportError::unknown_variant(path, name, Vec::new()));
    } else {
        (read(path, folder, warnings)?, Variants::default())
    };
    complete(path, &mut scene, warnings)?;
    Ok((scene, variants))
}

fn extension_of(path: &Path) -> Option<String> {
    path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase())
}

/// By its extension or, where that is no format's, by its content.
fn is_gltf(path: &Path) -> Result<bool, ImportError> {
    match extension_of(path).as_deref() {
        Some("gltf" | "glb") => Ok(true),
        Some("obj" | "pbrt" | "ply" | "xml") => Ok(false),
        _ => files::starts_with(path, gltf::GLB_MAGIC),
    }
}

/// A scene of any format but glTF.
fn read(path: &Path, folder: SceneFolder, warnings: &mut Warnings) -> Result<Scene, ImportError> {
    match extension_of(path).as_deref() {
        Some("obj") => obj::load(path, folder, warnings),
        Some("pbrt") => pbrt::load(path, folder, warnings),
        Some("ply") => ply::load(path, warnings),
        Some("xml") => mitsuba::load(path, folder, warnings),
        _ => Err(ImportError::UnsupportedFormat { path: path.to_owned() }),
    }
}

/// Adds what every scene needs and checks the result.
fn complete(path: &Path, scene: &mut Scene, warnings: &mut Warnings) -> Result<(), ImportError> {
    if scene.counts().triangles == 0 {
        return Err(ImportError::EmptyScene { path: path.to_owned() });
    }
    scene.validate().map_err(|source| ImportError::InvalidScene { path: path.to_owned(), source })?;
    if scene.cameras.is_empty() {
        scene.cameras.push(Camera::framing(&scene.bounds(), 1.0));
        warnings.add(WarningKind::NoCamera, "", "there is no camera: one is placed that sees everything");
    }
    if !scene.has_light() {
        warnings.add(WarningKind::NoLight, "", NO_LIGHT);
    }
    Ok(())
}

/// What a surface with no material of its own, or none that can be found, looks like.
fn default_material() -> Material {
    Material { name: String::new(), ..Material::new(Surface::diffuse(Vec3::splat(0.8))) }
}
