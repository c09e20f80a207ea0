//! The other side of the render thread ([`crate::worker`]): requests go in, frames and figures come out.

use std::{
    sync::{Arc, atomic::AtomicUsize, mpsc},
    thread,
    time::Duration,
};

use midway_device::Device;
use midway_film::Image;
use midway_import::Variants;
use midway_render::RenderSettings;
use midway_scene::Scene;
use tokio::sync::{broadcast, watch};

use crate::{
    ViewError,
    engine::Haste,
    frame::{Encoding, Frame},
    protocol::Request,
    save::{Answer, Format},
    uploads::Uploaded,
    worker::{Telling, Worker},
};

/// Requests that may wait for the render thread.
pub const QUEUE: usize = 256;
/// Events that a browser may lag behind.
const EVENTS: usize = 64;

/// What the render thread is told.
pub enum Command {
    /// By the browser that steers.
    Request(Request),
    /// To open a file that was uploaded.
    Open(Uploaded),
    /// To give the picture as a file.
    Save(Format, Answer),
}

/// The other side of the render thread.
#[derive(Clone)]
pub struct Session {
    commands: mpsc::SyncSender<Command>,
    /// The newest frame.
    pub frames: watch::Receiver<Arc<Frame>>,
    /// The newest figures, as JSON.
    pub status: watch::Receiver<Arc<str>>,
    /// The scene as it is told to browsers, as JSON.
    pub scene: watch::Receiver<Arc<str>>,
    /// What happens once, as JSON.
    pub events: broadcast::Sender<Arc<str>>,
    /// Browsers that look: nothing is rendered for nobody.
    pub watchers: Arc<AtomicUsize>,
    /// By which long passes are ended.
    pub haste: Haste,
}

/// What a session starts with.
pub struct Start {
    /// Where it renders.
    pub device: Arc<dyn Device>,
    /// What, and its name.
    pub scene: Scene,
    /// Its name.
    pub name: String,
    /// Its file's variants of materials.
    pub variants: Variants,
    /// The place of the one that it has now.
    pub variant: Option<u32>,
    /// With what.
    pub settings: RenderSettings,
    /// Time of a frame in motion.
    pub hold: Duration,
    /// What to plot the error against.
    pub reference: Option<Image>,
}

impl Session {
    /// Starts the render thread.
    ///
    /// # Errors
    /// If the scene does not fit the device, or the system refuses threads.
    pub fn start(start: Start) -> Result<Self, ViewError> {
        let (encoding, frames) = Encoding::start()?;
        let (status, status_receiver) = watch::channel(Arc::from("{}"));
        let (scene, scene_receiver) = watch::channel(Arc::from("{}"));
        let (session, inbox) = Self::of(frames, status_receiver, scene_receiver);
        let telling = Telling { encoding, status, scene, events: session.events.clone() };
        let worker = Worker::new(start, telling, &session)?;
        thread::Builder::new().name("render".into()).spawn(move || worker.run(&inbox))?;
        Ok(session)
    }

    /// What carries frames and figures to browsers, and their commands to whoever receives them.
    pub fn of(
        frames: watch::Receiver<Arc<Frame>>,
        status: watch::Receiver<Arc<str>>,
        scene: watch::Receiver<Arc<str>>,
    ) -> (Self, mpsc::Receiver<Command>) {
        let (commands, inbox) = mpsc::sync_channel(QUEUE);
        let (events, watchers) = (broadcast::Sender::new(EVENTS), Arc::default());
        (Self { commands, frames, status, scene, events, watchers, haste: Haste::default() }, inbox)
    }

    /// Hands over a command; false where too many wait.
    pub fn send(&self, command: Command) -> bool {
        let ends_the_pass = match &command {
            Command::Open(_) | Command::Save(..) => false,
            Command::Request(request) => request.forgets_samples(),
        };
        let taken = self.commands.try_send(command).is_ok();
        if ends_the_pass && taken {
            self.haste.stop();
        }
        taken
    }
}
