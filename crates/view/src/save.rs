//! The picture as a file.

use std::{
    path::Path,
    sync::Arc,
    time::{Duration, Instant},
};

use midway_device::Device;
use midway_film::{Display, FilmError, Framing, Metadata, write_exr_with, write_png, write_srgb8_png};
use tokio::sync::oneshot;

use crate::{ViewError, beside::Beside, engine::Engine, layers, protocol::Layer};

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

/// Pictures that wait at once, at most.
const MOST: usize = 16;

/// Where a picture that was asked for goes: its bytes, or why there are none.
pub type Answer = oneshot::Sender<Result<Vec<u8>, String>>;

/// What is left to be done of a picture once it is read from the device.
pub type Encode = Box<dyn FnOnce() -> Result<Vec<u8>, ViewError> + Send>;

/// Pictures that were asked for: until there is one of full size, as the view was moving or had just changed,
/// and until the one before is encoded, on a thread of its own, as that takes longer than a frame may.
#[derive(Default)]
pub struct Waiting {
    asked: Vec<(Format, Answer, Instant)>,
    encoding: Beside<()>,
}

impl Waiting {
    /// Whether any is waited for.
    pub fn is_empty(&self) -> bool {
        self.asked.is_empty()
    }

    /// Whether nothing is waited for but the end of a pass: between two of them film and layers are of as many
    /// samples.
    pub fn wants_the_pass_to_end(&self, engine: &Engine) -> bool {
        let under_way = engine.left.renderer.pass_done().is_some();
        under_way && engine.rests() && !self.is_empty() && self.encoding.is_free()
    }

    /// Another is asked for; one of too many is refused.
    pub fn push(&mut self, format: Format, answer: Answer) {
        self.forget_gone();
        if self.asked.len() >= MOST {
            let _ = answer.send(Err("too many pictures are being saved: save again later".to_owned()));
            return;
        }
        self.asked.push((format, answer, Instant::now()));
    }

    /// Forgets those whose browser has gone.
    fn forget_gone(&mut self) {
        self.asked.retain(|(_, answer, _)| !answer.is_closed());
    }

    /// Has the first encoded where there is a picture by now, `taken` by its format; refuses those that have
    /// waited long.
    ///
    /// # Errors
    /// If the device fails, or the system refuses a thread.
    pub fn answer(
        &mut self,
        engine: &Engine,
        taken: impl FnOnce(&Engine, Format) -> Result<Encode, ViewError>,
    ) -> Result<(), ViewError> {
        self.encoding.done().transpose()?;
        self.forget_gone();
        if self.is_empty() || !self.encoding.is_free() {
            return Ok(());
        }
        if engine.rests() {
            if engine.left.renderer.pass_done().is_some() {
                return Ok(());
            }
            let (format, answer, _) = self.asked.remove(0);
            return self.encode(taken(engine, format), answer);
        }
        let why = if engine.is_moving() { "the view is moving" } else { "there are no samples yet" };
        for (_, answer, _) in self.asked.extract_if(.., |(.., since)| since.elapsed() >= PATIENCE) {
            // The browser may have gone.
            let _ = answer.send(Err(format!("{why}: save again when it rests")));
        }
        Ok(())
    }

    /// Refuses all: there will be no picture.
    pub fn refuse(&mut self, why: &str) {
        for (_, answer, _) in self.asked.drain(..) {
            // The browser may have gone.
            let _ = answer.send(Err(why.to_owned()));
        }
    }

    fn encode(&mut self, taken: Result<Encode, ViewError>, answer: Answer) -> Result<(), ViewError> {
        // The browser may have gone, here too.
        let tell =
            |outcome: Result<Vec<u8>, ViewError>| drop(answer.send(outcome.map_err(|e| e.to_string())));
        match taken {
            Err(error) => tell(Err(error)),
            Ok(encode) => self.encoding.start(move || {
                tell(encode());
                Ok(())
            })?,
        }
        Ok(())
    }
}

/// Reads the samples so far from the device, to be made a file with a header that says how they came about: of
/// which scene, and of which variant of its materials where one is taken.
///
/// # Errors
/// If the device fails. What follows: if the temporary file cannot be written.
pub fn take(
    engine: &Engine,
    names: (&str, Option<&str>),
    device: &Arc<dyn Device>,
    format: Format,
) -> Result<Encode, ViewError> {
    let header = header(engine, names, device);
    let (renderer, shown) = (&engine.left.renderer, engine.shown);
    Ok(match format {
        Format::Exr => {
            let settings = renderer.settings();
            let pair = |x: u32, y: u32| [x as usize, y as usize];
            let framing = settings
                .crop
                .map(|c| Framing { frame: pair(settings.width, settings.height), offset: pair(c.x, c.y) });
            let image = engine.image()?;
            let mut channels = renderer.channels()?;
            channels.extend(renderer.group_channels()?);
            file(move |path| write_exr_with(path, &image, &channels, framing, &header))
        }
        Format::Png if shown.layer == Layer::Beauty => {
            let (image, tone_map) = (engine.mixed_image()?, shown.tone_map.into());
            file(move |path| write_png(path, &image, Display { exposure: shown.exposure, tone_map }, &header))
        }
        Format::Png => {
            let rgba = layers::picture(renderer, shown.layer)?;
            let window = renderer.settings().window();
            let size = [window.width as usize, window.height as usize];
            file(move |path| {
                let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
                write_srgb8_png(path, size, &rgb, &header)
            })
        }
    })
}

/// The bytes of a file that is written.
fn file(write: impl FnOnce(&Path) -> Result<(), FilmError> + Send + 'static) -> Encode {
    Box::new(move || {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("picture");
        write(&path)?;
        Ok(std::fs::read(&path)?)
    })
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

#[cfg(test)]
mod tests {
    use std::{sync::mpsc, thread};

    use super::*;
    use crate::engine::tests::{engine, scene};

    /// What takes long of a picture holds no frame up, and the next picture waits for it.
    #[test]
    fn pictures_are_encoded_beside_one_at_a_time() {
        let mut engine = engine(scene());
        while engine.left.renderer.samples() == 0 {
            engine.left.renderer.step(1).unwrap();
        }
        let (go, gate) = mpsc::channel::<()>();
        let (mut waiting, mut gate) = (Waiting::default(), Some(gate));
        let (first, mut first_saved) = oneshot::channel();
        let (second, mut second_saved) = oneshot::channel();
        waiting.push(Format::Png, first);
        waiting.push(Format::Exr, second);
        let mut answer = |waiting: &mut Waiting| {
            let gate = gate.take();
            let encode = |_: &Engine, format| -> Result<Encode, ViewError> {
                let name = format!("{format:?}");
                Ok(Box::new(move || {
                    if let Some(gate) = gate {
                        gate.recv().unwrap();
                    }
                    Ok(name.into_bytes())
                }))
            };
            waiting.answer(&engine, encode).unwrap();
        };
        answer(&mut waiting);
        answer(&mut waiting);
        assert!(first_saved.try_recv().is_err() && !waiting.is_empty(), "it was waited for");
        go.send(()).unwrap();
        let mut saved = Vec::new();
        while saved.len() < 2 {
            answer(&mut waiting);
            saved.extend(first_saved.try_recv());
            saved.extend(second_saved.try_recv());
            thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(saved, [Ok(b"Png".to_vec()), Ok(b"Exr".to_vec())]);
        assert!(waiting.is_empty());
    }
}
