//! `bdpt` (join `full`) as one kernel, a thread a sample, which the integrator's kernels are measured
//! against (`midway bench baseline`): the plain form of Otte 2014.

use std::{sync::Arc, time::Duration};

use midway_device::{BoundKernel, Buffer, BufferUsage, Command, Device, DeviceKind, MemoryPlan};
use midway_film::Image;
use midway_kernels::{constants as k, layout::Params};

use super::{
    Renderer,
    kept::{Kept, make_film, read_image},
};
use crate::{
    Crop, Join, RenderError,
    batch::{LaneTotals, read_totals},
    buffers::dispatch,
    params::mixed_seed,
    sizes::plan_shared,
};

/// Samples of the first launch, before anything was measured, and of all where no watchdog is…
const FIRST_LAUNCH: u32 = 16_384;
/// … and of a launch at least: below that not the samples, but what a launch costs is measured.
const LEAST_LAUNCH: u32 = 256;
/// A GPU's launch, which is one dispatch, lasts at least this long where there is room for so many samples,
/// so that little time goes to waiting…
const LAUNCH_TARGET: Duration = Duration::from_millis(20);
/// … and at most this long, so that a desktop's watchdog never fires.
const LAUNCH_LIMIT: Duration = Duration::from_millis(50);
/// Light vertices that an invocation has room for at least.
const OWN_VERTICES_LEAST: u32 = 8;

/// How much is in flight at once.
#[derive(Clone, Copy)]
struct LaunchSize {
    /// Invocations.
    n_places: u32,
    /// Light vertices that each of these has room for by itself.
    own_vertices: u32,
    /// Light vertices that all of them together have room for beyond that.
    appended_vertices: u32,
}

impl LaunchSize {
    /// `mean_light_vertices`: L. Lengths are about geometric: a path has e⁻² L vertices beyond the first
    /// 2 L on average, for which there is room nearly four times.
    fn new(n_places: u32, mean_light_vertices: f32) -> Self {
        let own_vertices = ((2.0 * mean_light_vertices).ceil() as u32).max(OWN_VERTICES_LEAST);
        let appended_vertices = n_places * own_vertices.div_ceil(4);
        Self { n_places, own_vertices, appended_vertices }
    }

    /// The largest whose memory fits beside `shared`.
    fn fit(device: &dyn Device, shared: &MemoryPlan, mean_light_vertices: f32) -> Result<Self, RenderError> {
        let mut n_places = match device.info().kind {
            DeviceKind::Gpu => 1 << 20,
            DeviceKind::Cpu | DeviceKind::SoftwareGpu => FIRST_LAUNCH,
        };
        loop {
            let size = Self::new(n_places, mean_light_vertices);
            let mut plan = shared.clone();
            plan.scaling("light vertices", size.vertex_bytes());
            plan.scaling("light paths", size.path_bytes());
            match plan.check(device.info()) {
                Ok(()) => return Ok(size),
                Err(error) if n_places <= FIRST_LAUNCH => return Err(error.into()),
                Err(_) => n_places /= 2,
            }
        }
    }

    fn own_slots(&self) -> u32 {
        self.n_places * self.own_vertices
    }

    fn vertex_bytes(&self) -> u64 {
        (u64::from(self.own_slots()) + u64::from(self.appended_vertices)) * u64::from(k::VERTEX_STRIDE) * 16
    }

    fn path_bytes(&self) -> u64 {
        u64::from(self.n_places) * 8
    }
}

/// Renders the samples that a [`Renderer`] with join `full` renders, into a film of its own.
pub struct Megakernel {
    device: Arc<dyn Device>,
    base: Params,
    window: Crop,
    size: LaunchSize,
    kernel: BoundKernel,
    resolve: BoundKernel,
    params: Buffer,
    counters: Buffer,
    film: Buffer,
    image: Buffer,
    /// Invocations of the next launch, by how long the last ones took.
    launch: u32,
    samples: u32,
}

impl Renderer {
    /// The same scene, camera and settings by one kernel. Compiles it.
    ///
    /// # Errors
    /// If the integrator is not `bdpt` with join `full` and a light path for each sample, or the device
    /// is too small.
    pub fn megakernel(&self) -> Result<Megakernel, RenderError> {
        let integrator = &self.settings.integrator;
        if integrator.joins() != Some(Join::Full) || integrator.uses_pool() {
            let only = "one kernel does bdpt with join full and a light path for each sample only";
            return Err(RenderError::Settings(only.to_owned()));
        }
        let Kept { scene_plan, pipelines, n_pixels, n_groups, .. } = &self.kept;
        let device = &*self.device;
        let shared = plan_shared(scene_plan, &self.settings, *n_pixels, *n_groups);
        let size = LaunchSize::fit(device, &shared, self.mean_light_vertices)?;
        let mut set = self.kept.shared.clone();
        make_film(device, &mut set, *n_pixels, *n_groups)?;
        for (name, bytes, usage) in [
            ("params", size_of::<Params>() as u64, BufferUsage::Uniform),
            ("counters", u64::from(k::N_COUNTERS) * 4, BufferUsage::Storage),
            ("light_vertices", size.vertex_bytes(), BufferUsage::Storage),
            ("light_paths", size.path_bytes(), BufferUsage::Storage),
        ] {
            set.insert(name, device.create_buffer(name, bytes, usage)?);
        }
        let bind = |name| set.bind(device, pipelines, name);
        Ok(Megakernel {
            base: self.base,
            window: self.settings.window(),
            size,
            kernel: bind("bench_megakernel")?,
            resolve: bind("resolve")?,
            params: set.get("params").clone(),
            counters: set.get("counters").clone(),
            film: set.get("film").clone(),
            image: set.get("image").clone(),
            launch: FIRST_LAUNCH.min(size.n_places),
            samples: 0,
            device: self.device.clone(),
        })
    }
}

impl Megakernel {
    /// Renders so many samples of every pixel more.
    ///
    /// # Errors
    /// If the device fails, or light paths have more vertices than there is room for.
    pub fn render(&mut self, n_samples: u32) -> Result<(), RenderError> {
        let end = self.samples + n_samples;
        while self.samples < end {
            // Whole images, as many as one launch may hold.
            let images = (self.size.n_places / self.base.n_pixels).clamp(1, end - self.samples);
            let n_places = images * self.base.n_pixels;
            let mut first = 0;
            while first < n_places {
                let n = self.launch.min(n_places - first);
                let wall = self.run(first, n)?;
                self.adapt(n, wall);
                first += n;
            }
            self.samples += images;
        }
        Ok(())
    }

    /// Whether rays are counted, which is slow: [`Megakernel::totals`] has those since it is asked for.
    pub fn count_rays(&mut self, count: bool) {
        self.base.flags &= !k::FLAG_COUNT_RAYS;
        if count {
            self.base.flags |= k::FLAG_COUNT_RAYS;
        }
    }

    /// Forgets all samples; those to come are of this seed.
    ///
    /// # Errors
    /// If the device fails.
    pub fn restart_with_seed(&mut self, seed: u32) -> Result<(), RenderError> {
        self.base.seed = mixed_seed(seed);
        self.samples = 0;
        self.device.run(&[Command::Clear(self.film.clone())], false)?;
        Ok(())
    }

    /// What was counted since it was made.
    ///
    /// # Errors
    /// If the device fails.
    pub fn totals(&self) -> Result<LaneTotals, RenderError> {
        read_totals(&*self.device, &self.counters)
    }

    /// The mean of all samples.
    ///
    /// # Errors
    /// If the device fails.
    pub fn image(&self) -> Result<Image, RenderError> {
        let params = Params { first_sample: self.samples, ..self.base };
        self.device.write_buffer(&self.params, 0, bytemuck::bytes_of(&params))?;
        self.device.run(&[dispatch(&self.resolve, self.base.n_pixels)], false)?;
        read_image(&*self.device, &self.image, self.window)
    }

    /// Launches `n` samples; how long they took.
    fn run(&self, first: u32, n: u32) -> Result<Duration, RenderError> {
        let params = Params {
            first_path: first,
            first_sample: self.samples,
            n_paths: n,
            n_places: n,
            append_at: n * self.size.own_vertices,
            append_capacity: self.size.appended_vertices,
            ..self.base
        };
        let appended = u64::from(k::COUNT_VERTICES) * 4;
        self.device.write_buffer(&self.params, 0, bytemuck::bytes_of(&params))?;
        self.device.write_buffer(&self.counters, appended, &[0; 4])?;
        let wall = self.device.run(&[dispatch(&self.kernel, n)], false)?.wall;
        let bytes = self.device.read_buffer(&self.counters, appended, 4)?;
        if bytemuck::pod_read_unaligned::<u32>(&bytes) > params.append_capacity {
            return Err(RenderError::PathTooLong { capacity: self.size.own_vertices });
        }
        Ok(wall)
    }

    /// Doubles or halves a GPU's launches.
    fn adapt(&mut self, n: u32, wall: Duration) {
        if self.device.info().kind != DeviceKind::Gpu {
            return;
        }
        if wall > LAUNCH_LIMIT {
            self.launch = (n / 2).max(LEAST_LAUNCH);
        } else if wall < LAUNCH_TARGET && n == self.launch {
            self.launch = (2 * n).min(self.size.n_places);
        }
    }
}
