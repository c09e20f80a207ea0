//! The renderer: schedules samples as passes, and passes as batches over the device's lanes.

mod basis;
mod batches;
mod display;
mod groups;
mod kept;
mod live;
mod megakernel;
mod passes;
mod shared;

use std::{
    panic::resume_unwind,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU32},
    },
    thread,
    time::Duration,
};

use midway_device::{BoundKernel, Buffer, BufferUsage, Device, DeviceKind, MemoryPlan};
use midway_film::{Channel, Image};
use midway_kernels::{constants as k, layout::Params};
use midway_scene::{Camera, Scene};

pub use basis::Basis;
pub use megakernel::Megakernel;

use self::{
    batches::FEW_PLACES,
    kept::{Kept, load_kernels, make_film, n_pixels, put_on_device, read_image},
    passes::Pass,
};
use crate::{
    BounceRays, RenderError, RenderSettings,
    aov::Aovs,
    batch::{KernelTimes, Lane, LaneTotals, LaneUses},
    buffers::dispatch,
    pack::Packing,
    params::{mixed_seed, samples_by_tree},
    pool::{Pool, PoolSize},
    sizes::{MOST_PLACES, plan_shared},
};

/// Paths in flight of a GPU's first batch, before anything was measured.
const FIRST_BATCH: u32 = 16_384;

/// What a render has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// Rays traced, closest and shadow.
    pub rays: u64,
    /// Contributions that were NaN, infinite or negative, left out and counted.
    pub rejected: u64,
    /// Film sums that overflowed.
    pub overflowed: u64,
    /// L, the mean number of connectible vertices of a light path, by the pilot; 0 without joins.
    pub mean_light_vertices: f32,
    /// Light paths of a pass that joins draw from.
    pub n_light_paths: u32,
}

/// Renders one scene with one set of settings, progressively.
pub struct Renderer {
    device: Arc<dyn Device>,
    settings: RenderSettings,
    base: Params,
    plan: MemoryPlan,
    film: Buffer,
    image: Buffer,
    resolve: BoundKernel,
    resolve_params: Buffer,
    lanes: Vec<Lane>,
    pool: Option<(Pool, PoolSize)>,
    aovs: Aovs,
    mean_light_vertices: f32,
    samples: u64,
    /// The number of the next sample: `samples`, unless others render some of the numbers.
    next_sample: u64,
    pass: Option<Pass>,
    /// What lanes counted that are no more.
    carried: LaneTotals,
    encoder: Option<display::Encoder>,
    mixer: Option<groups::Mixer>,
    shown_mix: Vec<[f32; 3]>,
    kept: Kept,
    /// Paths in flight of the next batch, by how long the last ones took.
    batch: AtomicU32,
    /// Whether they have taken neither too short nor too long.
    is_settled: AtomicBool,
    /// Samples of the last pass, and how long they took.
    last_pass: Option<(u32, Duration)>,
}

impl Renderer {
    /// Packs the scene, measures L, plans memory, checks the plan and allocates.
    ///
    /// # Errors
    /// If the settings or the scene are invalid, or the device is too small for the plan.
    pub fn new(
        device: Arc<dyn Device>,
        scene: &Scene,
        camera: &Camera,
        settings: RenderSettings,
    ) -> Result<Self, RenderError> {
        Self::with_plan(device, scene, camera, settings, &[], |_| {})
    }

    /// As [`Renderer::new`]; `tell` is handed the plan before the working buffers are taken (the
    /// scene is on the device by then: the pilot that sizes them needs it). The kernels of `also`, what the
    /// scene will be rendered by next, are compiled beside those of `settings`: a driver takes no longer for
    /// both, where it has the cores.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub fn with_plan(
        device: Arc<dyn Device>,
        scene: &Scene,
        camera: &Camera,
        settings: RenderSettings,
        also: &[RenderSettings],
        tell: impl FnOnce(&MemoryPlan),
    ) -> Result<Self, RenderError> {
        settings.validate()?;
        let packing = Packing::new(scene, &settings, device.info().kind)?;
        let (features, n_light_groups) = (packing.features(), packing.n_light_groups());
        let load = || load_kernels(&*device, features, n_light_groups, &settings, also);
        let n_pixels = n_pixels(&settings);
        let n_groups = if settings.light_groups { n_light_groups } else { 1 };
        let check =
            |scene: &MemoryPlan| plan_shared(scene, &settings, n_pixels, n_groups).check(device.info());
        // A driver takes longer to compile than hierarchies take to be built.
        let (pipelines, prepared) = thread::scope(|scope| {
            let pipelines = scope.spawn(load);
            let prepared = put_on_device(&*device, packing, camera, check);
            (pipelines.join().unwrap_or_else(|panic| resume_unwind(panic)), prepared)
        });
        let (pipelines, (packed, scene_plan, mut shared)) = (pipelines?, prepared?);
        make_film(&*device, &mut shared, n_pixels, n_groups)?;
        let camera = camera.clone();
        let (light_vertices, stop) = (Vec::new(), Arc::default());
        let kept = Kept {
            packed,
            scene_plan,
            pipelines,
            shared,
            n_pixels,
            n_groups,
            camera,
            light_vertices,
            stop,
            is_watched: false,
        };
        Self::build(device, kept, settings, tell)
    }

    /// The working buffers of valid `settings`, around a scene that is on the device.
    fn build(
        device: Arc<dyn Device>,
        mut kept: Kept,
        settings: RenderSettings,
        tell: impl FnOnce(&MemoryPlan),
    ) -> Result<Self, RenderError> {
        kept.load_kernels(&*device, &settings)?;
        let (base, mean_light_vertices) = kept.base_params(&*device, &settings)?;
        let pipelines = &kept.pipelines;
        let mut shared = kept.shared.clone();
        let n_lanes = device.lanes() as u32;
        let most_places = if kept.is_watched { FEW_PLACES } else { MOST_PLACES };
        let sizes = kept.sizes(&*device, &settings, mean_light_vertices, most_places)?;
        tell(&sizes.plan);
        let size = sizes.lane;
        let pool = sizes
            .pool
            .map(|size| Ok::<_, RenderError>((Pool::new(&*device, pipelines, &mut shared, size)?, size)))
            .transpose()?;
        let lanes = (0..n_lanes)
            .map(|_| Lane::new(&*device, pipelines, &shared, size, LaneUses::of(&settings), pool.is_none()))
            .collect::<Result<Vec<_>, _>>()?;
        let aovs = Aovs::new(&*device, pipelines, &shared, &settings.aovs, kept.n_pixels)?;
        let first_batch =
            if device.info().kind == DeviceKind::Cpu { size.n_paths } else { size.n_paths.min(FIRST_BATCH) };
        let resolve_params =
            device.create_buffer("params", size_of::<Params>() as u64, BufferUsage::Uniform)?;
        let mut resolve_set = shared.clone();
        resolve_set.insert("params", resolve_params.clone());
        resolve_set.insert(
            "counters",
            device.create_buffer("counters", u64::from(k::N_COUNTERS) * 4, BufferUsage::Storage)?,
        );
        let mixer = || groups::Mixer::new(&*device, pipelines, resolve_set.clone(), kept.n_groups);
        Ok(Self {
            shown_mix: Vec::new(),
            mixer: settings.light_groups.then(mixer).transpose()?,
            resolve: resolve_set.bind(&*device, pipelines, "resolve")?,
            resolve_params,
            film: shared.get("film").clone(),
            image: shared.get("image").clone(),
            device,
            settings,
            base,
            plan: sizes.plan,
            lanes,
            pool,
            aovs,
            mean_light_vertices,
            samples: 0,
            next_sample: 0,
            pass: None,
            carried: LaneTotals::default(),
            encoder: None,
            kept,
            batch: AtomicU32::new(first_batch),
            is_settled: AtomicBool::new(false),
            last_pass: None,
        })
    }

    /// Memory on the device, by buffer.
    pub fn plan(&self) -> &MemoryPlan {
        &self.plan
    }

    /// What was asked.
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// Whether next-event estimation draws lights by the tree over them; none without it.
    pub fn samples_lights_by_tree(&self) -> Option<bool> {
        let nee = self.settings.integrator.uses_nee();
        nee.then(|| samples_by_tree(&self.settings, &self.kept.packed))
    }

    /// What it runs on.
    pub fn device(&self) -> &dyn Device {
        &*self.device
    }

    /// Samples of every pixel so far.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The image so far: the mean of all samples, of the rendered window.
    ///
    /// # Errors
    /// If the device fails.
    pub fn image(&self) -> Result<Image, RenderError> {
        if self.pass.is_none() {
            self.write_resolve_params()?;
            self.device.run(&[dispatch(&self.resolve, self.base.n_pixels)], false)?;
        }
        self.read_image()
    }

    fn write_resolve_params(&self) -> Result<(), RenderError> {
        let params = Params { first_sample: self.samples as u32, ..self.base };
        Ok(self.device.write_buffer(&self.resolve_params, 0, bytemuck::bytes_of(&params))?)
    }

    /// What was last put into the image.
    fn read_image(&self) -> Result<Image, RenderError> {
        read_image(&*self.device, &self.image, self.settings.window())
    }

    /// The channels of the layers that were asked for ([`RenderSettings::aovs`]), as they are so far.
    ///
    /// # Errors
    /// If the device fails.
    pub fn channels(&self) -> Result<Vec<Channel>, RenderError> {
        self.aovs.channels(&*self.device, self.samples, self.base.n_pixels)
    }

    /// The rays of a sample of each pixel, read back batch by batch and bounce by bounce, for measuring them
    /// alone; in each batch those of light paths come first. All samples are forgotten.
    ///
    /// # Errors
    /// If light paths come from a pool, or the device fails.
    pub fn record_rays(&mut self) -> Result<Vec<Vec<BounceRays>>, RenderError> {
        if self.pool.is_some() {
            return Err(RenderError::Settings("rays of a pool are not recorded".to_owned()));
        }
        let lane = &self.lanes[0];
        let n_paths = lane.size().n_paths.min(self.base.n_pixels);
        let batch = |first_path: u32| {
            let n_places = n_paths.min(self.base.n_pixels - first_path);
            let params = Params { first_path, n_paths, n_places, ..self.base };
            lane.record(|| self.render_batch(&*self.device, lane, params))
        };
        let batches = (0..self.base.n_pixels).step_by(n_paths as usize).map(batch);
        let recorded = batches.collect::<Result<_, _>>()?;
        self.restart()?;
        Ok(recorded)
    }

    /// Forgets all samples; the next pass is the first again.
    ///
    /// # Errors
    /// If the device fails.
    pub fn restart(&mut self) -> Result<(), RenderError> {
        self.device.run(&[midway_device::Command::Clear(self.film.clone())], false)?;
        self.aovs.restart(&*self.device)?;
        (self.samples, self.next_sample, self.pass) = (0, 0, None);
        Ok(())
    }

    /// As [`Renderer::restart`], with another seed: samples that are independent of those before.
    ///
    /// # Errors
    /// If the device fails.
    pub fn restart_with_seed(&mut self, seed: u32) -> Result<(), RenderError> {
        self.settings.seed = seed;
        self.base.seed = mixed_seed(seed);
        self.restart()
    }

    /// Starts to time each kernel, from zero; asking for times may slow the passes down.
    pub fn time_kernels(&self) {
        self.lanes.iter().for_each(Lane::time_kernels);
    }

    /// The time of each kernel since [`Renderer::time_kernels`], summed over lanes; empty where the
    /// device cannot tell.
    pub fn kernel_times(&self) -> KernelTimes {
        let mut sum = KernelTimes::new();
        for (kernel, time) in self.lanes.iter().flat_map(Lane::kernel_times) {
            let all = sum.entry(kernel).or_default();
            *all = *all + time;
        }
        sum
    }

    /// What was done so far.
    ///
    /// # Errors
    /// If the device fails.
    pub fn stats(&self) -> Result<RenderStats, RenderError> {
        let sum = self.totals()?;
        Ok(RenderStats {
            rays: sum.rays,
            rejected: sum.rejected,
            overflowed: sum.overflowed,
            mean_light_vertices: self.mean_light_vertices,
            n_light_paths: self.base.n_light_paths,
        })
    }

    /// What all lanes have counted, those included that are no more.
    fn totals(&self) -> Result<LaneTotals, RenderError> {
        let mut sum = self.carried + self.aovs.totals(&*self.device)?;
        for lane in &self.lanes {
            sum = sum + lane.totals(&*self.device)?;
        }
        Ok(sum)
    }
}
