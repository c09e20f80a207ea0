//! What the render thread works with: a scene, its renderers, and how they are to be shown.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use glam::{Mat3, Vec3};
use midway_device::Device;
use midway_film::{Display, Image};
use midway_render::{
    Aov, Crop, Hold, HoldLimits, IntegratorSettings, Join, Load, RenderSettings, RenderStats, Renderer,
};
use midway_scene::{Camera, Environment, Projection, Scene};

use crate::{
    ViewError,
    frame::Pixels,
    layers,
    protocol::{Layer, Method, Shown, Surroundings, View, Wish, crop},
};

/// A frame that refines lasts about this long, so that input waits no longer.
const REFINE: Duration = Duration::from_millis(80);
/// The camera rests when no input came for this long.
const REST: Duration = Duration::from_millis(150);
/// A frame in motion that has not ended after this many times its time is given up for a smaller one.
const MOVING_LATE: u32 = 4;
/// Samples of a pixel in a frame while the camera moves, at most.
const MOVING_SAMPLES: u32 = 16;
/// The smallest scale of a side while it moves.
const MOVING_SCALE: f32 = 0.125;
/// Longest side of a film that a browser may ask for.
const MAX_SIDE: u32 = 8192;
/// The largest factor of a group of lights.
const MAX_FACTOR: f32 = 1e6;
/// How long a camera at rest is taken to move so that a small picture is shown ahead.
const PREVIEW: Duration = Duration::from_millis(30);
/// Stands for the environment of a scene that has none.
const WHITE: Environment =
    Environment { radiance: Vec3::ONE, image: None, world_from_environment: Mat3::IDENTITY };
/// Samples of a pixel after which an image is done.
pub const MAX_SAMPLES: u64 = 1 << 20;

/// A renderer and the time it has spent since its first sample.
pub struct Half {
    /// The renderer.
    pub renderer: Renderer,
    /// Seconds of passes since the last restart.
    pub seconds: f64,
    /// Rays that it had traced then.
    rays_before: u64,
    /// What it had counted after the last frame.
    pub stats: RenderStats,
}

impl Half {
    fn new(renderer: Renderer) -> Self {
        Self { renderer, seconds: 0.0, rays_before: 0, stats: RenderStats::default() }
    }

    /// Rays since the last restart.
    pub fn rays(&self) -> u64 {
        self.stats.rays - self.rays_before
    }

    fn begin(&mut self) {
        self.seconds = 0.0;
        self.rays_before = self.stats.rays;
    }

    /// Passes, until `samples` of every pixel were added or `time` is over; a first that is not over
    /// after `patience` is left. Whether none of them was stopped.
    fn render(&mut self, samples: u64, time: Duration, patience: Duration) -> Result<bool, ViewError> {
        let start = Instant::now();
        let end = self.renderer.samples() + samples;
        let mut goes_on = true;
        loop {
            let done = self.renderer.samples();
            let spent = start.elapsed();
            if done >= end || (spent >= time && done > end - samples) {
                break;
            }
            // As many as fit the rest of the time at the pace so far.
            let paced =
                (done - (end - samples)) as f64 * (time.as_secs_f64() / spent.as_secs_f64().max(1e-6) - 1.0);
            let wanted = (end - done).min((paced as u64).max(1));
            let patience = if done == end - samples { patience.saturating_sub(spent) } else { Duration::MAX };
            match self.renderer.step_within(wanted, patience)? {
                None => break,
                Some(0) => {
                    self.begin();
                    goes_on = false;
                    break;
                }
                Some(_) => {}
            }
        }
        self.seconds += start.elapsed().as_secs_f64();
        self.stats = self.renderer.stats()?;
        Ok(goes_on)
    }
}

/// Tells a pass that refines that something better is to be done.
#[derive(Clone, Default)]
pub struct Haste {
    stop: Arc<AtomicBool>,
    /// Frames in motion are short, and are shown whatever comes.
    refines: Arc<AtomicBool>,
}

impl Haste {
    fn begin(&self, refines: bool) {
        self.refines.store(refines, Ordering::Relaxed);
        self.stop.store(false, Ordering::Relaxed);
    }

    /// Ends the pass that is under way, if it refines.
    pub fn stop(&self) {
        if self.refines.load(Ordering::Relaxed) {
            self.stop.store(true, Ordering::Relaxed);
        }
    }
}

/// What an engine is made with besides its scene.
pub struct Seed {
    /// Where it renders.
    pub device: Arc<dyn Device>,
    /// With what.
    pub settings: RenderSettings,
    /// How it is shown.
    pub shown: Shown,
    /// How long frames in motion are to last.
    pub hold_time: Duration,
    /// By which long passes are ended.
    pub haste: Haste,
}

/// The renderers of one scene.
pub struct Engine {
    /// The scene, with the environment as it is now.
    pub scene: Arc<Scene>,
    /// The environment as it was loaded, or dropped; where there was none, what stands for it.
    surroundings: Environment,
    /// Images of the scene as it was loaded.
    n_images: usize,
    /// The one looked through.
    pub camera: Camera,
    /// What is asked for while the camera rests.
    pub settings: RenderSettings,
    /// The whole picture, or its left.
    pub left: Half,
    /// The right of a split.
    pub right: Option<Half>,
    /// Its K.
    right_k: u32,
    /// How it is shown.
    pub shown: Shown,
    /// Factors of the groups of lights as they are shown; empty where all count in full.
    mix: Vec<[f32; 3]>,
    /// What frames are rendered with while the camera moves.
    pub hold: Hold,
    /// How long these are to last.
    hold_time: Duration,
    moved_at: Option<Instant>,
    /// Whether a small picture was shown ahead of a first pass that lasts.
    previewed: bool,
    /// A camera that is not yet looked through.
    next_camera: Option<Camera>,
    input: u32,
    /// How long the last frame took.
    pub frame_time: Duration,
    /// By which long passes are ended.
    pub haste: Haste,
}

impl Engine {
    /// Takes a scene to the device.
    ///
    /// # Errors
    /// If the renderer cannot be made.
    pub fn new(scene: Scene, seed: Seed) -> Result<Self, ViewError> {
        let Seed { device, settings, shown, hold_time, haste } = seed;
        let camera = scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&scene.bounds(), 1.0));
        let settings = RenderSettings { aovs: aovs(shown.layer), crop: None, ..settings };
        let scene = Arc::new(scene);
        let mut left = Half::new(Renderer::new(device, &scene, &camera, settings.clone())?);
        left.renderer.stop_when(Arc::clone(&haste.stop));
        thread::Builder::new().name("compile".into()).spawn(left.renderer.compile_ahead())?;
        let hold = Hold::new(hold_limits(&settings, hold_time));
        Ok(Self {
            surroundings: scene.environment.unwrap_or(WHITE),
            n_images: scene.images.len(),
            scene,
            camera,
            settings,
            left,
            right: None,
            right_k: 1,
            shown,
            mix: Vec::new(),
            hold,
            hold_time,
            moved_at: None,
            previewed: false,
            next_camera: None,
            input: 0,
            frame_time: Duration::ZERO,
            haste,
        })
    }

    /// Takes the place of another: rendered and shown as that is by now, whole and with all lights in full.
    ///
    /// # Errors
    /// If that does not fit this scene.
    pub fn succeed(&mut self, other: &Self) -> Result<(), ViewError> {
        self.hold_time = other.hold_time;
        let settings = RenderSettings { crop: None, light_groups: false, ..other.settings.clone() };
        self.change(settings)?;
        self.shown = other.shown;
        Ok(())
    }

    /// Whether frames are rendered for speed.
    pub fn is_moving(&self) -> bool {
        self.next_camera.is_some() || self.moved_at.is_some_and(|at| at.elapsed() < REST)
    }

    /// Whether there is nothing left to refine.
    pub fn is_done(&self) -> bool {
        let done = |half: &Half| half.renderer.samples() >= MAX_SAMPLES;
        !self.is_moving() && self.is_whole() && done(&self.left) && self.right.as_ref().is_none_or(done)
    }

    /// Whether the film is as it was asked for, not smaller for speed.
    pub fn is_whole(&self) -> bool {
        let now = self.left.renderer.settings();
        (now.width, now.height, now.crop) == (self.settings.width, self.settings.height, self.settings.crop)
    }

    /// The fixed time of a frame in motion.
    pub fn hold_time(&self) -> Duration {
        self.hold_time
    }

    /// Looks from elsewhere.
    ///
    /// # Errors
    /// If it is no view.
    pub fn look(&mut self, view: &View) -> Result<(), ViewError> {
        let [eye, target, up] = [view.eye, view.target, view.up].map(Vec3::from_array);
        let yfov = view.fov.map(f32::to_radians);
        let seen = Camera::look_at(eye, target, up, yfov.unwrap_or(1.0))
            .map_err(|e| ViewError::Refused(e.to_string()))?;
        let projection = match (yfov, self.camera.projection) {
            (Some(yfov), Projection::Perspective { .. }) => Projection::Perspective { yfov },
            (_, projection) => projection,
        };
        let positive = |value: Option<f32>| value.filter(|v| v.is_finite() && *v > 0.0);
        let lens_radius = view.lens.filter(|r| r.is_finite() && *r >= 0.0).unwrap_or(self.camera.lens_radius);
        self.camera = Camera {
            world_from_camera: seen.world_from_camera,
            projection,
            lens_radius,
            focus_distance: positive(view.focus).unwrap_or_else(|| eye.distance(target)),
            ..self.camera.clone()
        };
        self.next_camera = Some(self.camera.clone());
        (self.moved_at, self.previewed) = (Some(Instant::now()), false);
        self.input = view.input;
        Ok(())
    }

    /// Asks for another integrator, bound or size.
    ///
    /// # Errors
    /// If it cannot be had.
    pub fn wish(&mut self, wish: &Wish) -> Result<(), ViewError> {
        let mut settings = self.settings.clone();
        if let Some(method) = wish.method {
            settings.integrator = method.settings();
        }
        if let Some(bound) = wish.max_path_length {
            settings.max_path_length = (bound > 0).then_some(bound);
        }
        if let Some([width, height]) = wish.size.filter(|size| *size != [settings.width, settings.height]) {
            (settings.width, settings.height, settings.crop) =
                (width.min(MAX_SIDE), height.min(MAX_SIDE), None);
        }
        if let Some(milliseconds) = wish.hold_ms.filter(|ms| (1.0..=10_000.0).contains(ms)) {
            self.hold_time = Duration::from_secs_f32(milliseconds / 1000.0);
        }
        self.change(settings)
    }

    /// Renders a part of the film only.
    ///
    /// # Errors
    /// If it does not lie in the film.
    pub fn region(&mut self, window: Option<[u32; 4]>) -> Result<(), ViewError> {
        self.change(RenderSettings { crop: window.map(crop), ..self.settings.clone() })
    }

    /// Shows the samples so far in another way.
    ///
    /// # Errors
    /// If another layer's buffers do not fit.
    pub fn show(&mut self, shown: Shown) -> Result<(), ViewError> {
        let exposure = if shown.exposure.is_finite() { shown.exposure.clamp(-100.0, 100.0) } else { 0.0 };
        let wanted = aovs(shown.layer);
        if wanted != self.settings.aovs {
            self.change(RenderSettings { aovs: wanted, ..self.settings.clone() })?;
        }
        self.shown = Shown { exposure, ..shown };
        Ok(())
    }

    /// Puts another integrator beside the first, from the same time on.
    ///
    /// # Errors
    /// If it does not fit.
    pub fn split(&mut self, right: Option<Method>) -> Result<(), ViewError> {
        self.hold = Hold::new(hold_limits(&self.settings, self.hold_time));
        let Some(method) = right else {
            self.right = None;
            return Ok(());
        };
        let settings = RenderSettings { integrator: method.settings(), ..self.settings.clone() };
        let renderer = self.left.renderer.beside(settings)?;
        self.right = Some(Half::new(renderer));
        self.right_k = method.k;
        self.restart()
    }

    /// Forgets all samples.
    ///
    /// # Errors
    /// If the device fails.
    pub fn restart(&mut self) -> Result<(), ViewError> {
        for half in [Some(&mut self.left), self.right.as_mut()].into_iter().flatten() {
            half.renderer.restart()?;
            half.begin();
        }
        Ok(())
    }

    /// Another strength or turn of the environment, or another environment.
    ///
    /// # Errors
    /// If the scene cannot be rendered with it.
    pub fn surround(
        &mut self,
        surroundings: Surroundings,
        image: Option<midway_scene::Image>,
    ) -> Result<(), ViewError> {
        let Surroundings { strength, rotation } = surroundings;
        if !(strength.is_finite() && (0.0..=1e6).contains(&strength) && rotation.is_finite()) {
            return Err(ViewError::Refused("an environment's strength is 0 to a million".into()));
        }
        let before = (self.scene.environment, self.scene.images.clone());
        let scene = Arc::make_mut(&mut self.scene);
        let mut base = self.surroundings;
        if let Some(image) = image {
            scene.images.truncate(self.n_images); // one that was dropped before
            scene.images.push(image);
            base = Environment { image: Some(self.n_images as u32), ..WHITE };
        }
        let turn = Mat3::from_rotation_y(rotation.to_radians());
        scene.environment = (strength > 0.0).then(|| Environment {
            radiance: base.radiance * strength,
            world_from_environment: turn * base.world_from_environment,
            ..base
        });
        if let Err(error) = self.left.renderer.set_environment(scene) {
            (scene.environment, scene.images) = before;
            return Err(error.into());
        }
        self.surroundings = base;
        self.left.begin();
        match self.right.take() {
            Some(half) => self.split(Some(Method::of(&half.renderer.settings().integrator))),
            None => Ok(()),
        }
    }

    /// Renders one frame, or a part of one, and gives its pixels; none where it was stopped or its pass
    /// goes on in the next.
    ///
    /// # Errors
    /// If the device fails.
    pub fn frame(&mut self) -> Result<Option<Pixels>, ViewError> {
        let start = Instant::now();
        let moving = self.is_moving();
        let load = self.hold.load();
        if moving && self.pass_done().is_some() {
            self.restart()?;
        }
        if self.pass_done().is_none() {
            self.apply(if moving { load } else { Load { k: u32::MAX, samples: 1, scale: 1.0 } })?;
        }
        if let Some(camera) = self.next_camera.take() {
            for half in [Some(&mut self.left), self.right.as_mut()].into_iter().flatten() {
                half.renderer.set_camera(&self.scene, &camera)?;
                half.begin();
            }
        }
        let samples = if moving { u64::from(load.samples) } else { u64::MAX >> 1 };
        let time = if moving { self.hold_time } else { REFINE };
        let patience = match moving {
            true if self.hold.is_least() => Duration::MAX,
            true => time * MOVING_LATE,
            false => time,
        };
        let before = self.samples();
        self.haste.begin(!moving);
        let rendered = self.render(samples.min(MAX_SAMPLES), time, patience);
        self.haste.begin(false);
        if !rendered? {
            return Ok(None);
        }
        let after = self.samples();
        let shows = if moving { before[0] != after[0] && before[1] != after[1] } else { before != after };
        if !shows {
            self.put_off(moving)?;
            return Ok(None);
        }
        self.previewed &= moving;
        let pixels = self.pixels(moving)?;
        self.frame_time = start.elapsed();
        if moving {
            // Fewer than asked for where the time was over.
            let samples = (after[0] - before[0]).clamp(1, u64::from(load.samples)) as u32;
            self.hold.observe(Load { samples, ..load }, self.frame_time);
        }
        Ok(Some(pixels))
    }

    /// A pass has outlasted its frame. In motion it is given up for the smallest there is; at rest it goes
    /// on, but where it is the first a small picture is shown ahead.
    fn put_off(&mut self, moving: bool) -> Result<(), ViewError> {
        if moving {
            self.hold = Hold::new(hold_limits(&self.settings, self.hold_time));
            return self.restart();
        }
        if self.left.renderer.samples() == 0 && !self.previewed {
            self.previewed = true;
            self.moved_at = Instant::now().checked_sub(REST - PREVIEW);
        }
        Ok(())
    }

    /// Samples of both halves; without a split the one stands for both.
    fn samples(&self) -> [u64; 2] {
        let left = self.left.renderer.samples();
        [left, self.right.as_ref().map_or(left, |half| half.renderer.samples())]
    }

    /// The share that is done of a pass that is under way; none between passes.
    fn pass_done(&self) -> Option<f64> {
        let right = self.right.as_ref().and_then(|half| half.renderer.pass_done());
        self.left.renderer.pass_done().or(right)
    }

    /// Brings passes that are under way to their end.
    ///
    /// # Errors
    /// If the device fails.
    pub fn end_pass(&mut self) -> Result<(), ViewError> {
        for half in [Some(&mut self.left), self.right.as_mut()].into_iter().flatten() {
            if half.renderer.pass_done().is_some() {
                half.renderer.step(1)?;
            }
        }
        Ok(())
    }

    /// Whether a pass has ended that can be shown.
    pub fn has_picture(&self) -> bool {
        self.left.renderer.samples() > 0
    }

    /// Keeps groups of lights apart and shows them multiplied by `factors`; none: all of them in full,
    /// not kept apart.
    ///
    /// # Errors
    /// If they are no factors, or the films do not fit.
    pub fn mix(&mut self, factors: Option<Vec<[f32; 3]>>) -> Result<(), ViewError> {
        let sound = |factor: &f32| (0.0..=MAX_FACTOR).contains(factor);
        let n = self.scene.light_groups().names.len();
        if factors.as_ref().is_some_and(|f| f.len() > n || !f.as_flattened().iter().all(sound)) {
            return Err(ViewError::Refused(format!("a group's factor is 0 to {MAX_FACTOR}, of {n} groups")));
        }
        let apart = factors.is_some();
        if apart != self.settings.light_groups {
            self.change(RenderSettings { light_groups: apart, ..self.settings.clone() })?;
        }
        self.mix = factors.unwrap_or_default();
        Ok(())
    }

    /// The factors of groups that are kept apart, as they were asked for.
    pub fn mix_shown(&self) -> Option<&[[f32; 3]]> {
        self.settings.light_groups.then_some(&self.mix)
    }

    /// The samples so far, as they are shown.
    ///
    /// # Errors
    /// If the device fails.
    pub fn pixels(&mut self, moving: bool) -> Result<Pixels, ViewError> {
        let display = Display { exposure: self.shown.exposure, tone_map: self.shown.tone_map.into() };
        let (layer, mix) = (self.shown.layer, self.mix.clone());
        let picture = |half: &mut Half| -> Result<Vec<u8>, ViewError> {
            match layer {
                Layer::Beauty => {
                    half.renderer.set_mix(&mix);
                    Ok(half.renderer.display(display)?)
                }
                _ => layers::picture(&half.renderer, layer),
            }
        };
        let mut pictures = vec![picture(&mut self.left)?];
        if let Some(half) = &mut self.right {
            pictures.push(picture(half)?);
        }
        let window = self.left.renderer.settings().window();
        Ok(Pixels { input: self.input, width: window.width, height: window.height, pictures, moving })
    }

    /// The picture's radiance.
    ///
    /// # Errors
    /// If the device fails.
    pub fn image(&self) -> Result<Image, ViewError> {
        Ok(self.left.renderer.image()?)
    }

    /// The picture's radiance with the mix of its lights.
    ///
    /// # Errors
    /// If the device fails.
    pub fn mixed_image(&self) -> Result<Image, ViewError> {
        let mixes = !self.mix.is_empty();
        Ok(if mixes { self.left.renderer.mixed_image(&self.mix)? } else { self.left.renderer.image()? })
    }

    /// Whether it was not stopped. In a split whoever has had less time renders, until both have had
    /// theirs.
    fn render(&mut self, samples: u64, time: Duration, patience: Duration) -> Result<bool, ViewError> {
        let Some(right) = &mut self.right else { return self.left.render(samples, time, patience) };
        let start = Instant::now();
        let first = (self.left.renderer.samples(), right.renderer.samples());
        loop {
            let spent = start.elapsed();
            let both = self.left.renderer.samples() != first.0 && right.renderer.samples() != first.1;
            if (both && spent >= time) || spent >= patience {
                return Ok(true);
            }
            let half = if self.left.seconds <= right.seconds { &mut self.left } else { &mut *right };
            if !half.render(samples, time / 8, (patience - spent).min(time))? {
                self.restart()?;
                return Ok(false);
            }
        }
    }

    /// Cuts the renderers to a load.
    fn apply(&mut self, load: Load) -> Result<(), ViewError> {
        let scaled = |side: u32| ((side as f32 * load.scale) as u32).max(1);
        let whole = &self.settings;
        let crop = whole.crop.map(|c| Crop {
            x: scaled(c.x).min(scaled(whole.width) - 1),
            y: scaled(c.y).min(scaled(whole.height) - 1),
            width: scaled(c.width),
            height: scaled(c.height),
        });
        let (width, height) = (scaled(whole.width), scaled(whole.height));
        let crop = if load.scale >= 1.0 { whole.crop } else { crop.map(|c| inside(c, width, height)) };
        let halves = [(Some(&mut self.left), whole.integrator.k), (self.right.as_mut(), self.right_k)];
        for (half, k) in halves.into_iter().filter_map(|(half, k)| Some((half?, k))) {
            let mut integrator = half.renderer.settings().integrator;
            if integrator.joins() == Some(Join::KStep) {
                integrator.k = load.k.min(k);
            }
            let aovs = whole.aovs.clone();
            let settings = RenderSettings { width, height, crop, integrator, aovs, ..whole.clone() };
            let before = half.renderer.samples();
            half.renderer.set_settings(settings)?;
            if half.renderer.samples() < before {
                half.begin();
            }
        }
        Ok(())
    }

    /// Other settings for the picture, checked by its renderer, and what a split shares of them.
    fn change(&mut self, settings: RenderSettings) -> Result<(), ViewError> {
        let same_k = IntegratorSettings { k: self.settings.integrator.k, ..settings.integrator };
        let costs_other =
            same_k != self.settings.integrator || settings.max_path_length != self.settings.max_path_length;
        if self.pass_done().is_some()
            && self.settings == (RenderSettings { integrator: same_k, ..settings.clone() })
        {
            settings.validate()?;
            self.hold.set_limits(hold_limits(&settings, self.hold_time));
            self.settings = settings; // with the next pass: one pass has one K
            return Ok(());
        }
        self.left.renderer.set_settings(settings.clone())?;
        self.previewed = false;
        if self.left.renderer.samples() == 0 {
            self.left.begin();
        }
        if let Some(right) = &mut self.right {
            let integrator = right.renderer.settings().integrator;
            let beside = RenderSettings { integrator, ..settings.clone() };
            right.renderer.set_settings(beside)?;
        }
        self.settings = settings;
        let limits = hold_limits(&self.settings, self.hold_time);
        if costs_other {
            self.hold = Hold::new(limits);
        } else {
            self.hold.set_limits(limits);
        }
        if self.right.is_some() { self.restart() } else { Ok(()) }
    }
}

fn inside(crop: Crop, width: u32, height: u32) -> Crop {
    Crop { width: crop.width.min(width - crop.x), height: crop.height.min(height - crop.y), ..crop }
}

/// What a layer is made of.
fn aovs(layer: Layer) -> Vec<Aov> {
    match layer {
        Layer::Beauty => vec![],
        Layer::Noise => vec![Aov::Variance],
        Layer::Albedo => vec![Aov::Albedo],
        Layer::Normal => vec![Aov::Normal],
        Layer::Depth => vec![Aov::Depth],
    }
}

fn hold_limits(settings: &RenderSettings, target: Duration) -> HoldLimits {
    let k = if settings.integrator.joins() == Some(Join::KStep) { settings.integrator.k } else { 1 };
    HoldLimits { target, least_k: 1, most_k: k, most_samples: MOVING_SAMPLES, least_scale: MOVING_SCALE }
}
