//! What the render thread works with: a scene, its renderers, and how they are to be shown.

mod change;
mod frame;
mod half;

use std::{
    sync::Arc,
    thread,
    time::{Duration, Instant},
};

use glam::Vec3;
use midway_device::Device;
use midway_render::{Aov, Hold, HoldLimits, IntegratorSettings, Join, RenderSettings, Renderer};
use midway_scene::{Camera, Projection, Scene, Surround};

use self::change::WHITE;
pub use self::{
    change::{Change, Prepared, Sketch},
    half::{Half, Haste},
};
use crate::{
    ViewError, pick,
    protocol::{Layer, Method, Shown, Surroundings, View, Wish, crop},
    told::Outline,
};

/// The camera rests when no input came for this long.
const REST: Duration = Duration::from_millis(150);
/// Samples of a pixel in a frame while the camera moves, at most.
const MOVING_SAMPLES: u32 = 16;
/// The smallest scale of a side while it moves.
const MOVING_SCALE: f32 = 0.125;
/// Longest side of a film that a browser may ask for.
const MAX_SIDE: u32 = 8192;
/// The largest factor of a group of lights.
const MAX_FACTOR: f32 = 1e6;
/// Samples of a pixel after which an image is done.
pub const MAX_SAMPLES: u64 = 1 << 20;

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
    /// The scene, with the environment and the materials as they are now.
    pub scene: Arc<Scene>,
    /// The environment as it was loaded, or dropped; where there was none, what stands for it.
    base: Surround,
    /// How much of it there is, and its turn.
    pub surroundings: Surroundings,
    /// Images of the scene as it was loaded.
    n_images: usize,
    /// What browsers are told of it, whatever changes.
    pub outline: Outline,
    /// The one looked through.
    pub camera: Camera,
    /// The place that it is turned about.
    pub target: Vec3,
    /// What a browser asked for last; none while it is the scene's own.
    pub view: Option<View>,
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
        let mut left = Renderer::new(device, &scene, &camera, settings.clone())?;
        left.stop_when(Arc::clone(&haste.stop));
        compile_beside(&left)?;
        let hold = Hold::new(hold_limits(&settings, hold_time));
        Ok(Self {
            base: match scene.environment {
                Some(_) => Surround::of(&scene),
                None => Surround { environment: Some(WHITE), image: None },
            },
            surroundings: Surroundings::of(&scene),
            n_images: scene.images.len(),
            target: pick::middle(&scene, &camera),
            view: None,
            outline: Outline::of(&scene),
            scene,
            camera,
            settings,
            left: Half::new(left),
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
        let positive = |value: Option<f32>| value.filter(|v| v.is_finite() && *v > 0.0);
        let projection = match (self.camera.projection, yfov, positive(view.height)) {
            (_, Some(yfov), None) | (Projection::Perspective { .. }, Some(yfov), _) => {
                Projection::Perspective { yfov }
            }
            (_, None, Some(height)) | (Projection::Orthographic { .. }, _, Some(height)) => {
                Projection::Orthographic { height }
            }
            (projection, ..) => projection,
        };
        let lens_radius = view.lens.filter(|r| r.is_finite() && *r >= 0.0).unwrap_or(self.camera.lens_radius);
        self.camera = Camera {
            world_from_camera: seen.world_from_camera,
            projection,
            lens_radius,
            focus_distance: positive(view.focus).unwrap_or_else(|| eye.distance(target)),
            ..self.camera.clone()
        };
        (self.target, self.view) = (target, Some(*view));
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

/// Compiles the kernels of a renderer's other settings on a thread of its own.
fn compile_beside(renderer: &Renderer) -> Result<(), ViewError> {
    thread::Builder::new().name("compile".into()).spawn(renderer.compile_ahead())?;
    Ok(())
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

#[cfg(test)]
pub mod tests {
    use std::path::Path;

    use midway_device::CpuDevice;
    use midway_render::Integrator;

    use super::*;

    pub fn engine(scene: Scene) -> Engine {
        engine_of(scene, 24)
    }

    /// With a film of `side` by `side`.
    pub fn engine_of(scene: Scene, side: u32) -> Engine {
        let integrator = IntegratorSettings { integrator: Integrator::Bdpt, ..IntegratorSettings::default() };
        Engine::new(
            scene,
            Seed {
                device: Arc::new(CpuDevice::new(Some(2)).unwrap()),
                settings: RenderSettings {
                    width: side,
                    height: side,
                    integrator,
                    ..RenderSettings::default()
                },
                shown: Shown::default(),
                hold_time: Duration::from_millis(33),
                haste: Haste::default(),
            },
        )
        .unwrap()
    }

    pub fn scene() -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell-box.gltf");
        midway_import::load(&path).unwrap().scene
    }
}
