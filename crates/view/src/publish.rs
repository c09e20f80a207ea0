//! A render that runs elsewhere, on the viewer's page, to be looked at.

use std::{
    sync::{Arc, atomic::Ordering, mpsc},
    time::{Duration, Instant},
};

use midway_device::DeviceInfo;
use midway_film::{Display, ToneMap};
use midway_render::{RenderStats, Renderer};
use midway_scene::{Camera, Scene};
use serde_json::json;
use tokio::sync::watch;

use crate::{
    ViewError,
    black::is_black,
    frame::{Encoding, Pixels},
    pick,
    protocol::{Method, Shown, Surroundings, ToneMapName},
    session::{Command, Session},
    told::{Outline, figures, scene_message},
};

/// Pictures are sent no more often.
const EVERY: Duration = Duration::from_millis(250);

/// The render's side.
pub struct Publisher {
    encoding: Encoding,
    status: watch::Sender<Arc<str>>,
    /// Told once; without it browsers would take the session to be over.
    _scene: watch::Sender<Arc<str>>,
    session: Session,
    commands: mpsc::Receiver<Command>,
    shown: Shown,
    surroundings: Surroundings,
    /// Whether anything shines.
    is_lit: bool,
    last: Option<Instant>,
}

impl Publisher {
    /// What a server shows of a render of `scene`; `display` is how.
    ///
    /// # Errors
    /// If the system refuses a thread.
    pub fn start(scene: &Scene, name: &str, camera: &Camera, display: Display) -> Result<Self, ViewError> {
        let (encoding, frames) = Encoding::start()?;
        let (status, status_receiver) = watch::channel(Arc::from("{}"));
        let seen = (camera, pick::middle(scene, camera));
        let outline = Outline::of(scene);
        let told = scene_message((scene, &outline, name), seen, (&[], None), Surroundings::of(scene));
        let (scene_sender, scene_receiver) = watch::channel(Arc::from(told.to_string()));
        let (session, commands) = Session::of(frames, status_receiver, scene_receiver);
        let tone_map = match display.tone_map {
            ToneMap::Linear => ToneMapName::Linear,
            ToneMap::Agx => ToneMapName::Agx,
            ToneMap::Aces => ToneMapName::Aces,
            ToneMap::PbrNeutral => ToneMapName::PbrNeutral,
        };
        let shown = Shown { exposure: display.exposure, tone_map, ..Shown::default() };
        Ok(Self {
            encoding,
            status,
            _scene: scene_sender,
            session,
            commands,
            shown,
            surroundings: Surroundings::of(scene),
            is_lit: scene.has_light(),
            last: None,
        })
    }

    /// What a server serves.
    pub fn session(&self) -> Session {
        self.session.clone()
    }

    /// Shows how the render stands, if anybody looks and it is time. Call it after each pass.
    ///
    /// # Errors
    /// If the device fails.
    pub fn publish(
        &mut self,
        renderer: &mut Renderer,
        stats: &RenderStats,
        seconds: f64,
        info: &DeviceInfo,
    ) -> Result<(), ViewError> {
        for command in self.commands.try_iter() {
            if let Command::Save(_, answer) = command {
                // The browser may have gone.
                let _ = answer.send(Err("this render writes its own files when it ends".to_owned()));
            }
        }
        let nobody = self.session.watchers.load(Ordering::Relaxed) == 0;
        if nobody || self.last.is_some_and(|last| last.elapsed() < EVERY) {
            return Ok(());
        }
        let start = Instant::now();
        self.last = Some(start);
        let display = Display { exposure: self.shown.exposure, tone_map: self.shown.tone_map.into() };
        let picture = renderer.display(display)?;
        let black = is_black(&picture).then_some(if self.is_lit {
            "No light has reached what is seen so far, or the exposure is too low."
        } else {
            "Nothing emits light."
        });
        let window = renderer.settings().window();
        let (width, height) = (window.width, window.height);
        self.encoding.show(Pixels { input: 0, width, height, pictures: vec![picture], moving: false });
        let settings = renderer.settings();
        let told = json!({
            "environment": self.surroundings, "variant": null,
            "type": "status", "left": figures(renderer, stats, seconds, stats.rays), "right": null,
            "film": [settings.width, settings.height],
            "region": settings.crop.map(|c| [c.x, c.y, c.width, c.height]),
            "method": Method::of(&settings.integrator), "max_path_length": settings.max_path_length,
            "shown": self.shown, "mix": null, "paused": false, "moving": false, "done": false,
            "frame_ms": start.elapsed().as_secs_f64() * 1e3, "hold_ms": 33, "device": info.name,
            "backend": info.backend, "relmse": null, "measured_by": "halves", "plot": [], "black": black, "failure": null,
        });
        self.status.send_replace(told.to_string().into());
        Ok(())
    }
}
