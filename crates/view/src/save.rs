//! The picture as a file.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use midway_device::Device;
use midway_film::{Display, Framing, Metadata, write_exr_with, write_png, write_srgb8_png};
use tokio::sync::oneshot;

use crate::{ViewError, engine::Engine, layers, protocol::Layer};

/// Of a saved picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Linear radiance and layers.
    Exr,
    /// As it is shown: the picture, or a layer.
    Png,
}

/// How long a picture to be saved is waited for.
const PATIENCE: Duration = Duration::from_secs(10);

/// Where a picture that was asked for goes: its bytes, or why there are none.
pub type Answer = oneshot::Sender<Result<Vec<u8>, String>>;

/// Pictures that were asked for while there was none of full size: the view was moving, or had just changed.
#[derive(Default)]
pub struct Waiting(Vec<(Format, Answer, Instant)>);

impl Waiting {
    /// Whether any is waited for.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Another is asked for.
    pub fn push(&mut self, format: Format, answer: Answer) {
        self.0.push((format, answer, Instant::now()));
    }

    /// Answers all where there is a picture by now, `saved` by its format; else those that have waited long.
    pub fn answer(
        &mut self,
        engine: &mut Engine,
        saved: impl Fn(&Engine, Format) -> Result<Vec<u8>, ViewError>,
    ) -> Result<(), ViewError> {
        if self.is_empty() {
            return Ok(());
        }
        if !engine.is_moving() && engine.is_whole() {
            engine.end_pass()?;
        }
        let is_there = !engine.is_moving() && engine.is_whole() && engine.left.renderer.samples() > 0;
        for (format, answer, since) in std::mem::take(&mut self.0) {
            if is_there {
                // The browser may have gone.
                let _ = answer.send(saved(engine, format).map_err(|error| error.to_string()));
            } else if since.elapsed() >= PATIENCE {
                let why = if engine.is_moving() { "the view is moving" } else { "there are no samples yet" };
                let _ = answer.send(Err(format!("{why}: save again when it rests")));
            } else {
                self.0.push((format, answer, since));
            }
        }
        Ok(())
    }
}

/// The samples so far as a file's bytes, with a header that says how they came about: of which scene, and of
/// which variant of its materials where one is taken.
///
/// # Errors
/// If the device fails or the temporary file cannot be written.
pub fn bytes(
    engine: &Engine,
    names: (&str, Option<&str>),
    device: &Arc<dyn Device>,
    format: Format,
) -> Result<Vec<u8>, ViewError> {
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
            let layer = engine.shown.layer;
            if layer == Layer::Beauty {
                let display =
                    Display { exposure: engine.shown.exposure, tone_map: engine.shown.tone_map.into() };
                write_png(&path, &engine.mixed_image()?, display, &header)?;
            } else {
                let rgba = layers::picture(&engine.left.renderer, layer)?;
                let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
                write_srgb8_png(&path, image.size(), &rgb, &header)?;
            }
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
