//! Changes between passes that keep the scene on the device, compiled kernels and, where there is room
//! in them, working buffers.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

use midway_device::Device;
use midway_kernels::constants as k;
use midway_scene::{Camera, Scene};

use super::{
    Renderer,
    kept::{Kept, make_film, n_light_paths, n_pixels},
};
use crate::{
    Join, RenderError, RenderSettings,
    batch::{Lane, LaneUses},
    buffers::Pipelines,
    pool::{POOL_KERNELS, PoolSize},
    sizes::{MOST_PLACES, reserved_slots},
};

/// Of layers, and of what is shown.
const OTHER_KERNELS: [&str; 5] = ["resolve", "mix_groups", "encode_display", "trace_aov", "measure_variance"];

impl Renderer {
    /// Looks through another camera; the next pass is the first again. `scene` is the one that the
    /// renderer was made with: it is asked for the medium that the camera is in.
    ///
    /// # Errors
    /// If the device fails.
    pub fn set_camera(&mut self, scene: &Scene, camera: &Camera) -> Result<(), RenderError> {
        self.kept.camera = camera.clone();
        let found = self.kept.packed.media.as_ref().and_then(|media| media.of_camera(scene, camera));
        self.kept.packed.camera_medium = found.unwrap_or(k::NONE);
        self.base = self.kept.base_params(&*self.device, &self.settings)?.0;
        self.restart()
    }

    /// K of the next passes. The samples so far stay: each pass is unbiased with its own K, as weights
    /// depend on it as a constant of the pass. Costs nothing up to the largest K there ever was.
    ///
    /// # Errors
    /// [`RenderError::Settings`] where K is out of range, or the join has none; if the device fails.
    pub fn set_k(&mut self, k: u32) -> Result<(), RenderError> {
        let mut settings = self.settings.clone();
        settings.integrator.k = k;
        if settings.integrator.joins() != Some(Join::KStep) {
            return Err(RenderError::Settings("only the join k-step has a K".to_owned()));
        }
        self.set_settings(settings)
    }

    /// Renders with other settings. The next pass is the first again, unless K is all that changed.
    /// Resolution, crop, K and bounds are cheap as long as no more pixels or light vertices are
    /// asked for than there was room for before; other integrators take working buffers anew.
    /// After an error the renderer is as it was.
    ///
    /// # Errors
    /// If the settings are invalid or ask for another table of random numbers or another
    /// [`crate::LightSampling`], or the device fails or is too small.
    pub fn set_settings(&mut self, settings: RenderSettings) -> Result<(), RenderError> {
        settings.validate()?;
        check_fixed(&self.settings, &settings)?;
        if settings == self.settings {
            return Ok(());
        }
        let keeps_samples = differs_in_k_alone(&self.settings, &settings);
        if keeps_samples && self.pass.is_some() {
            self.step(1)?; // a pass has one K
        }
        let buffers_differ =
            settings.aovs != self.settings.aovs || settings.light_groups != self.settings.light_groups;
        if n_pixels(&settings) > self.kept.n_pixels || buffers_differ {
            return self.rebuild(settings, false);
        }
        let (base, mean) = self.kept.base_params(&*self.device, &settings)?;
        if !self.has_room(&settings, mean)? {
            return self.rebuild(settings, keeps_samples);
        }
        (self.base, self.mean_light_vertices, self.settings) = (base, mean, settings);
        if keeps_samples { Ok(()) } else { self.restart() }
    }

    /// Ends a pass early, between two of its batches, when `stop` is set; it is unset then. Batches have
    /// few places for each path in flight from here on.
    pub fn stop_when(&mut self, stop: Arc<AtomicBool>) {
        (self.kept.stop, self.kept.is_watched) = (stop, true);
    }

    /// What compiles all kernels that [`Renderer::set_settings`] may ask for with this scene, one after
    /// another, and those of [`super::Basis::surrounded`] last, to be called on a thread of its own: a
    /// change then does not wait for a compiler. One that fails is left to whoever needs it.
    pub fn compile_ahead(&self) -> impl FnOnce() + Send + 'static {
        let (device, packed) = (Arc::clone(&self.device), &self.kept.packed);
        let surrounded = packed.features ^ k::FEATURE_ENVIRONMENT;
        // An environment is a group of its own.
        let apart = [packed.features, surrounded].map(|features| features | k::FEATURE_LIGHT_GROUPS);
        let features = [packed.features, apart[0], surrounded, apart[1]];
        move || {
            for features in features {
                let names = LaneUses::all_kernels().chain(POOL_KERNELS).chain(OTHER_KERNELS);
                names.for_each(|name| drop(Pipelines::new(features).load(&*device, name)));
            }
        }
    }

    /// Another renderer of the same scene on the same device; they share the scene's memory.
    ///
    /// # Errors
    /// As [`Renderer::set_settings`].
    pub fn beside(&self, settings: RenderSettings) -> Result<Self, RenderError> {
        settings.validate()?;
        Self::with_film(Arc::clone(&self.device), self.kept.clone(), settings)
    }

    /// A renderer with a film of its own around a scene that is on the device.
    pub(super) fn with_film(
        device: Arc<dyn Device>,
        mut kept: Kept,
        settings: RenderSettings,
    ) -> Result<Self, RenderError> {
        kept.n_pixels = n_pixels(&settings);
        kept.n_groups = kept.groups_of(&settings);
        make_film(&*device, &mut kept.shared, kept.n_pixels, kept.n_groups)?;
        Self::build(device, kept, settings, |_| {})
    }

    /// Whether the working buffers do for `settings`; then lanes are cut to them.
    fn has_room(&mut self, settings: &RenderSettings, mean_light_vertices: f32) -> Result<bool, RenderError> {
        if self.lanes.iter().any(|lane| lane.uses() != LaneUses::of(settings)) {
            return Ok(false);
        }
        let most_places = self.lanes.first().map_or(MOST_PLACES, Lane::most_places);
        let sizes = self.kept.sizes(&*self.device, settings, mean_light_vertices, most_places)?;
        match (&self.pool, sizes.pool) {
            (Some((_, have)), Some(_)) => {
                let regions: u32 = self.lanes.iter().map(|lane| lane.size().append_capacity).sum();
                let n_vertices = reserved_slots(settings, n_light_paths(settings)) + regions;
                let need = PoolSize { n_paths: n_light_paths(settings), n_vertices };
                let lane = self.lanes.first().map(|lane| lane.size());
                Ok(lane.is_some_and(|lane| sizes.lane.n_shadow_rays <= lane.n_shadow_rays)
                    && need.n_paths <= have.n_paths
                    && need.n_vertices <= have.n_vertices
                    && lane.is_some_and(|lane| sizes.lane.append_capacity <= lane.append_capacity))
            }
            (None, None) => Ok(self.lanes.iter_mut().all(|lane| lane.resize(sizes.lane))),
            _ => Ok(false),
        }
    }

    /// Takes working buffers anew, around the same scene.
    fn rebuild(&mut self, settings: RenderSettings, keeps_samples: bool) -> Result<(), RenderError> {
        let mut kept = self.kept.clone();
        let (n_pixels, n_groups) = (n_pixels(&settings), kept.groups_of(&settings));
        if n_pixels > kept.n_pixels || n_groups != kept.n_groups {
            (kept.n_pixels, kept.n_groups) = (n_pixels.max(kept.n_pixels), n_groups);
            make_film(&*self.device, &mut kept.shared, kept.n_pixels, n_groups)?;
        }
        let mut next = Self::build(Arc::clone(&self.device), kept, settings, |_| {})?;
        if keeps_samples {
            std::mem::swap(&mut next.aovs, &mut self.aovs);
            (next.samples, next.next_sample) = (self.samples, self.next_sample);
            let n_paths = next.lanes.first().map_or(1, |lane| lane.size().n_paths);
            next.batch.store(self.batch.load(Ordering::Relaxed).min(n_paths), Ordering::Relaxed);
        }
        next.carried = self.totals()?;
        next.shown_mix = std::mem::take(&mut self.shown_mix);
        *self = next;
        if keeps_samples { Ok(()) } else { self.restart() }
    }
}

/// That `after` asks for nothing that is packed with the scene and other than `before`.
pub(super) fn check_fixed(before: &RenderSettings, after: &RenderSettings) -> Result<(), RenderError> {
    if after.rng.table() != before.rng.table() {
        return Err(RenderError::Settings("a table of random numbers is fixed from the start".to_owned()));
    }
    if after.light_sampling != before.light_sampling {
        return Err(RenderError::Settings("how lights are chosen is fixed from the start".to_owned()));
    }
    Ok(())
}

fn differs_in_k_alone(before: &RenderSettings, after: &RenderSettings) -> bool {
    let mut same = after.clone();
    same.integrator.k = before.integrator.k;
    same == *before && after.integrator.joins() == Some(Join::KStep)
}
