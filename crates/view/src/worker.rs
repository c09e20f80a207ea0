//! The thread that renders: requests in, frames and figures out. It never waits for a browser.

use std::{
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
        mpsc::{self, RecvTimeoutError},
    },
    time::{Duration, Instant},
};

use glam::Vec3;
use midway_device::Device;
use midway_film::Image;
use midway_import::Variants;
use midway_render::RenderSettings;
use midway_scene::Camera;
use serde_json::{Value, json};
use tokio::sync::{broadcast, watch};

use crate::{
    ViewError,
    beside::{Beside, put_away},
    changing::{Changing, News},
    engine::{Engine, Half, Prepared, Seed},
    frame::{Encoding, Pixels},
    measured::Measured,
    opening::{Arrival, Opened, Opening, name_of},
    pick,
    protocol::{Method, Request, Shown},
    save::{self, Waiting},
    session::{Command, QUEUE, Session, Start},
    told::{figures, scene_message, view_of},
    uploads::Uploaded,
};

/// How often figures are told.
const STATUS_EVERY: Duration = Duration::from_millis(200);
/// How often a resting picture is sent, at the start and later.
const SHOW_EVERY: Duration = Duration::from_millis(150);
const SHOW_LATE: Duration = Duration::from_millis(500);
/// After this much rendering pictures change slowly.
const LATE: f64 = 5.0;

/// What carries it to browsers.
pub struct Telling {
    /// Frames.
    pub encoding: Encoding,
    /// Figures.
    pub status: watch::Sender<Arc<str>>,
    /// The scene.
    pub scene: watch::Sender<Arc<str>>,
    /// What happens once.
    pub events: broadcast::Sender<Arc<str>>,
}

/// The thread's state.
pub struct Worker {
    engine: Engine,
    device: Arc<dyn Device>,
    telling: Telling,
    name: String,
    variants: Variants,
    variant: Option<u32>,
    watchers: Arc<AtomicUsize>,
    reference: Option<Image>,
    /// The view that the reference is of: the first.
    reference_camera: Camera,
    measured: Measured,
    paused: bool,
    shown_at: Instant,
    told_at: Instant,
    /// Whether what is shown is not what there is.
    stale: bool,
    failure: Option<String>,
    /// Whether it is to be said anew why the picture is black, or that it is not.
    judges: bool,
    /// Whether the view moved when this was last asked.
    moved: bool,
    /// The scene as it was last told to browsers.
    told: Value,
    opening: Opening,
    changing: Changing,
    picking: Beside<Option<Vec3>>,
    saves: Waiting,
    /// Scenes that were opened.
    opened: u32,
}

impl Worker {
    /// Of a scene that it takes to the device.
    ///
    /// # Errors
    /// If the scene does not fit it.
    pub fn new(start: Start, telling: Telling, session: &Session) -> Result<Self, ViewError> {
        let Start { device, scene, name, variants, variant, settings, hold, reference } = start;
        let (shown, haste) = (Shown::default(), session.haste.clone());
        let seed = Seed { device: Arc::clone(&device), settings, shown, hold_time: hold, haste };
        let engine = Engine::new(scene, seed)?;
        let mut worker = Self {
            reference_camera: engine.camera.clone(),
            engine,
            device,
            telling,
            name,
            variants,
            variant,
            watchers: Arc::clone(&session.watchers),
            reference,
            measured: Measured::default(),
            paused: false,
            shown_at: Instant::now(),
            told_at: Instant::now(),
            stale: true,
            failure: None,
            judges: false,
            moved: false,
            told: Value::Null,
            opening: Opening::default(),
            changing: Changing::default(),
            picking: Beside::default(),
            saves: Waiting::default(),
            opened: 0,
        };
        worker.tell_scene();
        Ok(worker)
    }

    /// Renders until nobody can ask for anything any more.
    pub fn run(mut self, inbox: &mpsc::Receiver<Command>) {
        loop {
            if let Some(outcome) = self.opening.arrived() {
                self.stale = true;
                let outcome = outcome.and_then(|arrival| self.welcome(arrival));
                self.tell_refusal(outcome);
            }
            self.tell_picked();
            self.change();
            self.tell_view();
            let ends_pass = self.failure.is_none() && self.saves.wants_the_pass_to_end(&self.engine);
            let idle = self.is_idle() && !ends_pass;
            let wait = if idle { Duration::from_millis(100) } else { Duration::ZERO };
            match inbox.recv_timeout(wait) {
                Ok(command) => {
                    self.obey_all(command, inbox);
                    continue;
                }
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {}
            }
            let rendered = match (ends_pass, idle) {
                (true, _) => self.end_pass(),
                (false, true) => Ok(()),
                (false, false) => self.render(),
            };
            if let Err(error) = rendered {
                self.failure = Some(error.to_string());
            }
            self.save();
            self.tell_status();
        }
    }

    fn is_idle(&self) -> bool {
        let nobody = self.watchers.load(Ordering::Relaxed) == 0 && self.saves.is_empty();
        let still = self.paused && !self.engine.is_moving();
        nobody || self.failure.is_some() || ((still || self.engine.is_done()) && !self.stale)
    }

    /// Carries out a command and all that came with it; of views the last counts.
    fn obey_all(&mut self, first: Command, inbox: &mpsc::Receiver<Command>) {
        for command in std::iter::once(first).chain(inbox.try_iter().take(QUEUE)) {
            let outcome = self.obey(command);
            self.tell_refusal(outcome);
        }
    }

    fn tell_refusal(&self, outcome: Result<(), ViewError>) {
        if let Err(error) = outcome {
            self.event(&json!({ "type": "refused", "reason": error.to_string() }));
        }
    }

    fn obey(&mut self, command: Command) -> Result<(), ViewError> {
        self.stale = true;
        match command {
            Command::Request(request) => self.obey_request(request),
            Command::Open(uploaded) => self.open(uploaded),
            Command::Save(format, answer) => {
                self.saves.push(format, answer);
                Ok(())
            }
        }
    }

    /// Answers who asked for the picture, once it is there.
    fn save(&mut self) {
        if let Some(failure) = &self.failure {
            self.saves.refuse(&format!("the renderer stopped: {failure}"));
            return;
        }
        let variant = self.variant.and_then(|index| self.variants.names().get(index as usize));
        let names = (&*self.name, variant.map(String::as_str));
        let taken = |engine: &Engine, format| save::take(engine, names, &self.device, format);
        let outcome = self.saves.answer(&self.engine, taken);
        self.tell_refusal(outcome);
    }

    fn obey_request(&mut self, request: Request) -> Result<(), ViewError> {
        let engine = &mut self.engine;
        match request {
            // The hand was on another scene, which gave way to this one meanwhile.
            Request::Look(view) if view.opened.is_some_and(|opened| opened != self.opened) => return Ok(()),
            Request::Look(view) => engine.look(&view)?,
            Request::Render(wish) => engine.wish(&wish)?,
            Request::Show(shown) => {
                engine.show(shown)?;
                self.judges = true;
                return Ok(());
            }
            Request::Mix { factors } => {
                engine.mix(factors)?;
                self.judges = true;
                return Ok(());
            }
            Request::Split { right } => engine.split(right)?,
            Request::Region { window } => engine.region(window)?,
            Request::Restart => engine.restart()?,
            Request::Environment(surroundings) => {
                surroundings.check()?;
                self.changing.surround(surroundings);
                return Ok(());
            }
            Request::Variant { index } => return self.ask_for_variant(index),
            Request::Pause { paused } => {
                self.paused = paused;
                self.judges |= paused;
                return Ok(());
            }
            Request::Pick { x, y } => {
                let aspect = engine.settings.width as f32 / engine.settings.height as f32;
                let (scene, camera) = (Arc::clone(&engine.scene), engine.camera.clone());
                return self.picking.start(move || Ok(pick::pick(&scene, &camera, aspect, [x, y])));
            }
            Request::Decoded | Request::Take | Request::Open { .. } => return Ok(()),
        }
        self.failure = None;
        self.judges |= self.paused;
        if self.engine.left.renderer.samples() == 0 || self.engine.is_moving() {
            self.measured = Measured::default();
        }
        Ok(())
    }

    fn ask_for_variant(&mut self, index: Option<u32>) -> Result<(), ViewError> {
        let Some(materials) = self.variants.materials(index) else {
            self.tell_scene(); // what was refused is not to be shown as taken
            return Err(ViewError::Refused("the scene has no such variant".into()));
        };
        self.changing.dress(materials, index);
        Ok(())
    }

    /// Tells what was picked: all triangles are asked, which in a large scene takes longer than a frame.
    fn tell_picked(&mut self) {
        match self.picking.done() {
            Some(Ok(point)) => {
                self.event(&json!({ "type": "picked", "point": point.map(|p| p.to_array()) }));
            }
            Some(Err(error)) => self.tell_refusal(Err(error)),
            None => {}
        }
    }

    /// Shows a change of the scene that is ready, and has the next prepared.
    fn change(&mut self) {
        if !self.picking.is_free() {
            return; // it reads the scene
        }
        if let Some(outcome) = self.changing.ready() {
            self.stale = true;
            let outcome = outcome.and_then(|(prepared, news)| self.take(prepared, news));
            if outcome.is_err() {
                self.tell_scene(); // what was refused is not to be shown as taken
            }
            self.tell_refusal(outcome);
        }
        let outcome = self.changing.go_on(|| self.engine.sketch());
        self.tell_refusal(outcome);
    }

    fn take(&mut self, prepared: Prepared, news: News) -> Result<(), ViewError> {
        put_away(self.engine.take(prepared)?);
        self.judges = self.paused;
        (self.measured, self.failure) = (Measured::default(), None);
        match news {
            News::Surroundings => {}
            News::Environment(warnings) => self.warn(&warnings),
            News::Variant(index) => self.variant = index,
        }
        self.tell_scene(); // groups of lights may be others
        Ok(())
    }

    /// Begins to open a scene or an environment; the picture goes on meanwhile.
    fn open(&mut self, uploaded: Uploaded) -> Result<(), ViewError> {
        self.event(&json!({ "type": "notice", "text": format!("opening {}", name_of(&uploaded.file)) }));
        let engine = &self.engine;
        let seed = Seed {
            device: Arc::clone(&self.device),
            settings: RenderSettings { light_groups: false, ..engine.settings.clone() },
            shown: engine.shown,
            hold_time: engine.hold_time(),
            haste: engine.haste.clone(),
        };
        self.opening.start(uploaded, seed)
    }

    /// Shows a scene that was opened, or has an environment prepared.
    fn welcome(&mut self, arrival: Arrival) -> Result<(), ViewError> {
        match arrival.opened {
            Opened::Environment(image) => {
                self.changing.replace(image, arrival.warnings);
                return Ok(());
            }
            Opened::Scene(mut engine, variants) => {
                engine.succeed(&self.engine)?;
                self.opened += 1;
                self.judges = self.paused;
                self.changing.forget();
                self.picking = Beside::default();
                put_away(std::mem::replace(&mut self.engine, *engine));
                (self.name, self.reference) = (arrival.name, None);
                (self.variants, self.variant) = (variants, None);
            }
        }
        self.warn(&arrival.warnings);
        (self.measured, self.failure) = (Measured::default(), None);
        self.tell_scene();
        Ok(())
    }

    fn warn(&self, warnings: &[String]) {
        if !warnings.is_empty() {
            self.event(&json!({ "type": "warnings", "lines": warnings }));
        }
    }

    /// Goes on with the pass that a save waits for; what is shown of the last one may have changed.
    fn end_pass(&mut self) -> Result<(), ViewError> {
        self.engine.end_pass()?;
        if self.stale && self.engine.has_picture() {
            let pixels = self.engine.pixels(false)?;
            self.show(pixels)?;
        }
        Ok(())
    }

    fn render(&mut self) -> Result<(), ViewError> {
        let engine = &mut self.engine;
        // What forgets samples while it is paused is followed by a first picture.
        let settled = self.paused && !engine.is_moving() && engine.is_whole() && engine.has_picture();
        let still = settled || engine.is_done();
        let pixels = if still { Some(engine.pixels(false)?) } else { engine.frame()? };
        let pixels = match pixels {
            // A long pass is under way: what is shown of the last one may have changed.
            None if self.stale && engine.has_picture() => Some(engine.pixels(false)?),
            pixels => pixels,
        };
        let Some(pixels) = pixels else { return Ok(()) };
        let every = if engine.left.seconds < LATE { SHOW_EVERY } else { SHOW_LATE };
        if pixels.moving || self.stale || self.shown_at.elapsed() >= every {
            self.show(pixels)?;
        }
        let engine = &self.engine;
        let is_of_this =
            self.opened == 0 && engine.camera == self.reference_camera && engine.settings.crop.is_none();
        self.measured.measure(engine, self.reference.as_ref().filter(|_| is_of_this))
    }

    fn show(&mut self, pixels: Pixels) -> Result<(), ViewError> {
        self.stale = pixels.moving;
        self.shown_at = Instant::now();
        self.telling.encoding.show(pixels);
        if self.engine.rests() && std::mem::take(&mut self.judges) {
            self.measured.judge_black(&self.engine)?;
        }
        Ok(())
    }

    fn event(&self, event: &Value) {
        let _ = self.telling.events.send(event.to_string().into());
    }

    fn tell_scene(&mut self) {
        let Engine { scene, outline, camera, target, surroundings, .. } = &self.engine;
        let of = (&**scene, outline, &*self.name);
        let variants = (self.variants.names(), self.variant);
        let mut told = scene_message(of, (camera, *target), variants, *surroundings);
        told["opened"] = self.opened.into();
        told["view"] = self.view();
        self.telling.scene.send_replace(told.to_string().into());
        self.told = told;
    }

    /// Tells the view once it rests: browsers that come, or take over, begin with it.
    fn tell_view(&mut self) {
        let moves = self.engine.is_moving();
        if !std::mem::replace(&mut self.moved, moves) || moves {
            return;
        }
        let view = self.view();
        if view != self.told["view"] {
            self.told["view"] = view;
            self.telling.scene.send_replace(self.told.to_string().into());
        }
    }

    /// The view as browsers know it: what is up and what is sharp as it was asked for.
    fn view(&self) -> Value {
        let engine = &self.engine;
        let mut view = view_of(&engine.camera, engine.target);
        if let Some(asked) = &engine.view {
            (view["up"], view["focus"]) = (json!(asked.up), json!(asked.focus));
        }
        view
    }

    fn tell_status(&mut self) {
        if self.told_at.elapsed() < STATUS_EVERY {
            return;
        }
        self.told_at = Instant::now();
        let told = self.describe().to_string();
        self.telling.status.send_replace(told.into());
    }

    fn describe(&self) -> Value {
        let engine = &self.engine;
        let half = |half: &Half| figures(&half.renderer, &half.stats, half.seconds, half.rays());
        let info = self.device.info();
        let wanted = self.changing.wanted();
        json!({
            "environment": wanted.surroundings.unwrap_or(engine.surroundings),
            "variant": wanted.variant.unwrap_or(self.variant),
            "type": "status", "left": half(&engine.left), "right": engine.right.as_ref().map(half),
            "film": [engine.settings.width, engine.settings.height],
            "region": engine.settings.crop.map(|c| [c.x, c.y, c.width, c.height]),
            "method": Method::of(&engine.settings.integrator), "max_path_length": engine.settings.max_path_length,
            "shown": engine.shown, "mix": engine.mix_shown(), "paused": self.paused, "moving": engine.is_moving(), "done": engine.is_done(),
            "frame_ms": engine.frame_time.as_secs_f64() * 1e3, "hold_ms": engine.hold_time().as_secs_f64() * 1e3,
            "device": info.name, "backend": info.backend,
            "relmse": self.measured.relmse, "measured_by": if self.measured.by_reference { "reference" } else { "halves" },
            "plot": self.measured.points, "black": self.measured.black, "failure": self.failure,
        })
    }
}
