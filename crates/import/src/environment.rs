//! An environment from a file that is named beside the scene.

use std::path::Path;

use midway_scene::Image;

use crate::{
    ImportError, Warning, images,
    warning::{WarningKind, Warnings},
};

/// Reads an image of an environment by latitude and longitude (Radiance HDR, OpenEXR, or any other
/// image, by the sRGB curve where its numbers are whole). What is decoded is bounded by the file's
/// size.
///
/// # Errors
///
/// [`ImportError`] where there is no such file, or no image in it.
pub fn load_environment(path: &Path) -> Result<(Image, Vec<Warning>), ImportError> {
    let (image, note) = images::read_file(path, images::Encoding::Srgb)?;
    let mut warnings = Warnings::default();
    let place = path.display().to_string();
    if let Some(note) = note {
        warnings.add(WarningKind::Repaired, place.clone(), note);
    }
    if u64::from(image.width) != 2 * u64::from(image.height) {
        let message = format!(
            "an environment is twice as wide as it is high, this is {} x {}: stretched to the sphere",
            image.width, image.height
        );
        warnings.add(WarningKind::Approximation, place, message);
    }
    Ok((image, warnings.into_list()))
}
