//! The picture as a file.

use std::sync::Arc;

use midway_device::Device;
use midway_film::{Display, Framing, Metadata, write_exr_with, write_png};

use crate::{ViewError, engine::Engine};

/// Of a saved picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Linear radiance and layers.
    Exr,
    /// As it is shown.
    Png,
}

/// The samples so far as a file's bytes, with a header that says how they came about: of which scene, and of
/// which variant of its materials where one is taken.
///
/// # Errors
/// If there are none yet, the device fails or the temporary file cannot be written.
pub fn bytes(
    engine: &Engine,
    names: (&str, Option<&str>),
    device: &Arc<dyn Device>,
    format: Format,
) -> Result<Vec<u8>, ViewError> {
    if engine.left.renderer.samples() == 0 {
        return Err(ViewError::Refused("there are no samples yet".into()));
    }
    let image = engine.image()?;
    let header = header(engine, names, device);
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("picture");
    match format {
        Format::Exr => {
            let settings = engine.left.renderer.settings();
            let pair = |x: u32, y: u32| [x as usize, y as usize];
            let framing = settings
                .crop
                .map(|c| Framing { frame: pair(settings.width, settings.height), offset: pair(c.x, c.y) });
            let mut channels = engine.left.renderer.channels()?;
            channels.extend(engine.left.renderer.group_channels()?);
            write_exr_with(&path, &image, &channels, framing, &header)?;
        }
        Format::Png => {
            let display = Display { exposure: engine.shown.exposure, tone_map: engine.shown.tone_map.into() };
            write_png(&path, &engine.mixed_image()?, display, &header)?;
        }
    }
    Ok(std::fs::read(&path)?)
}

fn header(engine: &Engine, (name, variant): (&str, Option<&str>), device: &Arc<dyn Device>) -> Metadata {
    let renderer = &engine.left.renderer;
    let (settings, info) = (renderer.settings(), device.info());
    let whole = |n: u64| i64::try_from(n).unwrap_or(i64::MAX);
    let bias = settings.bias();
    let mut header = Metadata::new();
    header.set("scene", name);
    header.set("scene_hash", engine.scene.hash());
    if let Some(variant) = variant {
        header.set("variant", variant);
    }
    header.set("seed", settings.seed);
    header.set("device", format!("{} ({})", info.name, info.backend));
    header.set("width", settings.width);
    header.set("height", settings.height);
    // glam stores columns; files store rows.
    header.set("world_from_camera", engine.camera.world_from_camera.transpose().to_cols_array_2d());
    header.set("integrator", settings.integrator.describe());
    header.set("filter", settings.filter.describe());
    header.set("bias", if bias.is_empty() { "none".to_owned() } else { bias.join("; ") });
    header.set("samples", whole(renderer.samples()));
    header.set("seconds", engine.left.seconds);
    header.set("rays", whole(engine.left.rays()));
    header.set("rejected_contributions", whole(engine.left.stats.rejected));
    header
}
