//! Files that are opened: read, decoded and packed on a thread of their own, so that the picture goes on.

use std::path::Path;

use midway_import::{Options, Variants};
use midway_scene::Image;

use crate::{
    ViewError,
    beside::Beside,
    engine::{Engine, Seed},
    uploads::Uploaded,
};

/// What a file turned out to be.
pub enum Opened {
    /// A scene, on the device, and its file's variants of materials.
    Scene(Box<Engine>, Variants),
    /// An environment.
    Environment(Image),
}

/// A file that is open, with its name and what was said of it.
pub struct Arrival {
    /// The file's name.
    pub name: String,
    /// What it is.
    pub opened: Opened,
    /// What of it is not used.
    pub warnings: Vec<String>,
}

type Outcome = Result<Arrival, ViewError>;

/// At most one file that is being opened, and of those that were asked for meanwhile the last scene and the
/// last environment after it.
#[derive(Default)]
pub struct Opening {
    running: Beside<Arrival>,
    scene: Option<(Uploaded, Seed)>,
    environment: Option<(Uploaded, Seed)>,
}

impl Opening {
    /// Opens a file as soon as none is being opened. `seed`: what a scene's engine is made of.
    ///
    /// # Errors
    /// If the system refuses a thread.
    pub fn start(&mut self, uploaded: Uploaded, seed: Seed) -> Result<(), ViewError> {
        if is_environment(&uploaded.file) {
            self.environment = Some((uploaded, seed));
        } else {
            (self.scene, self.environment) = (Some((uploaded, seed)), None);
        }
        self.go_on()
    }

    /// The file that was opened since this was last asked; none while it takes its time.
    ///
    /// # Errors
    /// If it could not be opened.
    pub fn arrived(&mut self) -> Option<Outcome> {
        let outcome = self.running.done()?;
        let goes_on = self.go_on();
        Some(goes_on.and(outcome))
    }

    fn go_on(&mut self) -> Result<(), ViewError> {
        if !self.running.is_free() {
            return Ok(());
        }
        match self.scene.take().or_else(|| self.environment.take()) {
            Some((uploaded, seed)) => self.running.start(move || open(uploaded, seed)),
            None => Ok(()),
        }
    }
}

/// The name by which a file is shown.
pub fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// By its extension; others are scenes.
fn is_environment(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default();
    extension.eq_ignore_ascii_case("hdr") || extension.eq_ignore_ascii_case("exr")
}

fn open(uploaded: Uploaded, seed: Seed) -> Outcome {
    let path = &*uploaded.file;
    let refused = |error: midway_import::ImportError| ViewError::Refused(error.to_string());
    let (opened, warnings) = if is_environment(path) {
        let (image, warnings) = midway_import::load_environment(path).map_err(refused)?;
        (Opened::Environment(image), warnings)
    } else {
        let options = Options { root: Some(uploaded.folder.path().to_owned()), ..Options::default() };
        let (loaded, warnings) = midway_import::load_with(path, &options);
        let (scene, variants) = loaded.map_err(refused)?;
        (Opened::Scene(Box::new(Engine::new(scene, seed)?), variants), warnings)
    };
    Ok(Arrival { name: name_of(path), opened, warnings: warnings.iter().map(ToString::to_string).collect() })
}
