//! The renderer: schedules samples as passes, and passes as batches over the device's lanes.

mod display;
mod groups;
mod live;
mod megakernel;
mod shared;

use std::{
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, AtomicU32, Ordering},
    },
    time::{Duration, Instant},
};

use midway_device::{BoundKernel, Buffer, BufferUsage, Device, DeviceKind, MemoryPlan};
use midway_film::{Channel, Image};
use midway_kernels::{constants as k, layout::Params};
use midway_scene::{Camera, Scene};

pub use megakernel::Megakernel;

use crate::{
    BounceRays, Crop, Join, LightPaths, PackedScene, RenderError, RenderSettings,
    aov::Aovs,
    batch::{KernelTimes, Lane, LaneSize, LaneTotals, LaneUses},
    buffers::{BufferSet, Pipelines, dispatch},
    params::{base_params, join_factor, mixed_seed, samples_by_tree},
    pool::{POOL_KERNELS, Pool, PoolSize},
    sizes::{Sizes, plan_scene, plan_shared, reserved_slots},
};

/// Light paths of the pilot that measures L.
const PILOT_PATHS: u32 = 16_384;
/// Its seed: fixed, so that L is the same for every seed.
const PILOT_SEED: u32 = 0x9170_7001;

/// A GPU's list of commands aims to last at least this long, so that little time goes to waiting…
const RUN_TARGET: Duration = Duration::from_millis(40);
/// … and at most this long: of the many dispatches in it none then lasts 50 ms, and a desktop's
/// watchdog never fires.
const RUN_LIMIT: Duration = Duration::from_millis(100);
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

/// Places of a pass that a lane works through at a time, with this many paths in flight at most.
#[derive(Clone, Copy, Debug)]
struct Batch {
    first: u32,
    n_paths: u32,
    n_places: u32,
}

/// A pass that is not over: the film holds some of its samples.
struct Pass {
    params: Params,
    n_samples: u32,
    n_places: u32,
    /// Places that are on the film: all before this one.
    next: u32,
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
        Self::with_plan(device, scene, camera, settings, |_| {})
    }

    /// As [`Renderer::new`]; `tell` is handed the plan before the working buffers are taken (the
    /// scene is on the device by then: the pilot that sizes them needs it).
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub fn with_plan(
        device: Arc<dyn Device>,
        scene: &Scene,
        camera: &Camera,
        settings: RenderSettings,
        tell: impl FnOnce(&MemoryPlan),
    ) -> Result<Self, RenderError> {
        settings.validate()?;
        let mut packed = PackedScene::new(scene, camera, &settings, device.info().kind)?;
        let n_pixels = n_pixels(&settings);
        let bytes = |words: &[[u32; 4]]| size_of_val(words) as u64;
        let scene_plan = plan_scene(bytes(&packed.nodes), bytes(&packed.triangles), &packed);
        let n_groups = if settings.light_groups { packed.light_groups.len() as u32 } else { 1 };
        plan_shared(&scene_plan, &settings, n_pixels, n_groups).check(device.info())?;
        let pipelines = load_kernels(&*device, &packed, &settings)?;
        let mut shared = upload(&*device, &mut packed)?;
        make_film(&*device, &mut shared, n_pixels, n_groups)?;
        let (packed, camera) = (packed.without_copied(), camera.clone());
        let (light_vertices, stop) = (Vec::new(), Arc::default());
        let kept =
            Kept { packed, scene_plan, pipelines, shared, n_pixels, n_groups, camera, light_vertices, stop };
        Self::build(device, kept, settings, tell)
    }

    /// The working buffers of valid `settings`, around a scene that is on the device.
    fn build(
        device: Arc<dyn Device>,
        mut kept: Kept,
        settings: RenderSettings,
        tell: impl FnOnce(&MemoryPlan),
    ) -> Result<Self, RenderError> {
        kept.pipelines = load_kernels(&*device, &kept.packed, &settings)?;
        let (base, mean_light_vertices) = kept.base_params(&*device, &settings)?;
        let pipelines = &kept.pipelines;
        let mut shared = kept.shared.clone();
        let n_lanes = device.lanes() as u32;
        let sizes = kept.sizes(&*device, &settings, mean_light_vertices)?;
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

    /// Renders one pass: at least one sample of every pixel, at most `max_samples`. Returns how many:
    /// 0 where the pass was stopped ([`Renderer::stop_when`]), and with it all samples are forgotten.
    ///
    /// # Errors
    /// If the device fails.
    pub fn step(&mut self, max_samples: u64) -> Result<u64, RenderError> {
        loop {
            if let Some(samples) = self.step_within(max_samples, Duration::MAX)? {
                return Ok(samples);
            }
        }
    }

    /// As [`Renderer::step`], but left after about `time`, between two batches, where the pass is not
    /// over: none then, and the next call goes on with it. Meanwhile the image is the one before it, and
    /// what changes the renderer forgets the pass with all samples, or brings it to its end first.
    ///
    /// # Errors
    /// If the device fails.
    pub fn step_within(&mut self, max_samples: u64, time: Duration) -> Result<Option<u64>, RenderError> {
        let start = Instant::now();
        let mut pass = match self.pass.take() {
            Some(pass) => pass,
            None => {
                if time < Duration::MAX && self.samples > 0 {
                    self.write_resolve_params()?;
                    self.device.run(&[self.resolve_shown()?], false)?;
                }
                self.begin_pass(max_samples)?
            }
        };
        let params = pass.params;
        pass.next = self.for_each_batch(pass.next..pass.n_places, start, time, |device, lane, batch| {
            let Batch { first: first_path, n_paths, n_places } = batch;
            self.render_batch(device, lane, Params { first_path, n_paths, n_places, ..params })
        })?;
        if self.kept.stop.swap(false, Ordering::Relaxed) {
            self.restart()?;
            return Ok(Some(0));
        }
        if pass.next < pass.n_places {
            self.pass = Some(pass);
            return Ok(None);
        }
        self.count_samples(pass.n_samples)?;
        self.next_sample += u64::from(pass.n_samples);
        Ok(Some(u64::from(pass.n_samples)))
    }

    /// The share of the pass under way that is done, in [0, 1); none between passes.
    pub fn pass_done(&self) -> Option<f64> {
        self.pass.as_ref().map(|pass| f64::from(pass.next) / f64::from(pass.n_places))
    }

    /// Counts `n` samples that are on the film, and measures its layers after them.
    fn count_samples(&mut self, n: u32) -> Result<(), RenderError> {
        let params = Params { first_sample: self.samples as u32, ..self.base };
        self.aovs.measure(&*self.device, &params, n)?;
        self.samples += u64::from(n);
        Ok(())
    }

    fn begin_pass(&self, max_samples: u64) -> Result<Pass, RenderError> {
        let n_samples = self.next_pass(max_samples);
        let params = Params { first_sample: self.next_sample as u32, ..self.base };
        if self.pool.is_some() {
            self.trace_pool(&params)?;
        }
        Ok(Pass { params, n_samples, n_places: params.n_pixels * n_samples, next: 0 })
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

    /// The rays of one batch from the image's first pixel on, read back bounce by bounce, for measuring
    /// them alone; of light paths first where the integrator has them. All samples are forgotten.
    ///
    /// # Errors
    /// If light paths come from a pool, or the device fails.
    pub fn record_rays(&mut self) -> Result<Vec<BounceRays>, RenderError> {
        if self.pool.is_some() {
            return Err(RenderError::Settings("rays of a pool are not recorded".to_owned()));
        }
        let lane = &self.lanes[0];
        let n_paths = lane.size().n_paths.min(self.base.n_pixels);
        let params = Params { n_paths, n_places: n_paths, ..self.base };
        let recorded = lane.record(n_paths, || self.render_batch(&*self.device, lane, params))?;
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
            *sum.entry(kernel).or_default() += time;
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

    /// Samples of the next pass, of at most `max_samples`.
    fn next_pass(&self, max_samples: u64) -> u32 {
        let largest = self.aovs.largest_pass(self.samples).min(max_samples.max(1));
        self.samples_per_pass().min(u32::try_from(largest).unwrap_or(u32::MAX))
    }

    /// Samples of a pass: a pool is made for one sample of every pixel; else as many as fill the lanes.
    fn samples_per_pass(&self) -> u32 {
        if self.pool.is_some() {
            return 1;
        }
        let places = self.lanes.iter().map(|lane| lane.size().n_places).sum::<u32>();
        (places / self.base.n_pixels).max(1)
    }

    /// Light and camera subpaths of one batch; in halves where the light paths did not fit.
    fn render_batch(&self, device: &dyn Device, lane: &Lane, params: Params) -> Result<(), RenderError> {
        let mut params = self.own_vertex_params(lane, params);
        if self.pool.is_none() && self.settings.integrator.uses_light_paths() {
            let n_vertices = lane.trace_light_paths(device, &params)?;
            if params.append_transient == 0 {
                if n_vertices > params.append_capacity {
                    return self.render_halves(device, lane, params);
                }
                if self.settings.integrator.uses_splat() {
                    lane.splat_light_vertices(device, n_vertices)?;
                }
            }
        }
        if self.settings.integrator.uses_camera_paths() {
            params.append_transient = 0;
            lane.trace_camera_paths(device, &params)?;
        }
        Ok(())
    }

    fn render_halves(&self, device: &dyn Device, lane: &Lane, params: Params) -> Result<(), RenderError> {
        if params.n_places == 1 {
            return Err(RenderError::PathTooLong { capacity: params.append_capacity });
        }
        let half = params.n_places / 2;
        self.render_batch(device, lane, Params { n_places: half, ..params })?;
        let (first_path, n_places) = (params.first_path + half, params.n_places - half);
        self.render_batch(device, lane, Params { first_path, n_places, ..params })
    }

    /// Where a lane of its own appends light vertices.
    fn own_vertex_params(&self, lane: &Lane, mut params: Params) -> Params {
        if self.pool.is_none() {
            let size = lane.size();
            params.append_at = size.append_at;
            params.append_capacity = size.append_capacity;
            params.append_transient = u32::from(self.settings.integrator.joins() != Some(Join::Full));
        }
        params
    }

    /// Traces the light paths of a pass into the pool, projects them onto the film, and makes the
    /// table that joins draw from.
    fn trace_pool(&self, params: &Params) -> Result<(), RenderError> {
        let reserved = reserved_slots(&self.settings, params.n_light_paths);
        let keeps_all = self.settings.integrator.join != Join::SingleStep;
        let used: Vec<AtomicU32> = self.lanes.iter().map(|_| AtomicU32::new(0)).collect();
        let lane_paths = params.n_light_paths.div_ceil(self.lanes.len() as u32);
        self.for_each_lane(|device, index, lane| {
            let size = lane.size();
            let region = reserved + index as u32 * size.append_capacity;
            let end = params.n_light_paths.min((index as u32 + 1) * lane_paths);
            let mut first = index as u32 * lane_paths;
            while first < end && !self.kept.stop.load(Ordering::Relaxed) {
                let Batch { n_paths, n_places, .. } = self.next_batch(lane);
                let n = n_places.min(end - first);
                let at = used[index].load(Ordering::Relaxed);
                let batch = Params {
                    first_path: first,
                    n_paths,
                    n_places: n,
                    append_at: region + at,
                    append_capacity: size.append_capacity - at,
                    append_transient: u32::from(!keeps_all),
                    ..*params
                };
                let n_vertices = lane.trace_light_paths(device, &batch)?;
                if keeps_all {
                    if n_vertices > batch.append_capacity {
                        return Err(RenderError::PathTooLong { capacity: size.append_capacity });
                    }
                    if self.settings.integrator.uses_splat() {
                        lane.splat_light_vertices(device, n_vertices)?;
                    }
                    used[index].fetch_add(n_vertices, Ordering::Relaxed);
                }
                self.adapt_batch(n_paths, lane);
                first += n;
            }
            Ok(())
        })?;
        match &self.pool {
            Some((pool, _)) if keeps_all => pool.index(&*self.device, params),
            _ => Ok(()),
        }
    }

    /// Cuts places into batches and runs them on the lanes as these come free: at least one on each,
    /// and no new ones once `time` has passed since `start`. Returns the end of those that were run.
    fn for_each_batch(
        &self,
        places: std::ops::Range<u32>,
        start: Instant,
        time: Duration,
        run: impl Fn(&dyn Device, &Lane, Batch) -> Result<(), RenderError> + Sync,
    ) -> Result<u32, RenderError> {
        let (next, end) = (AtomicU32::new(places.start), places.end);
        self.for_each_lane(|device, _, lane| {
            while !self.kept.stop.load(Ordering::Relaxed) {
                let most = self.next_batch(lane);
                let claim = |first: u32| (first < end).then(|| first + most.n_places.min(end - first));
                let Ok(first) = next.fetch_update(Ordering::Relaxed, Ordering::Relaxed, claim) else {
                    return Ok(());
                };
                run(device, lane, Batch { first, n_places: most.n_places.min(end - first), ..most })?;
                self.adapt_batch(most.n_paths, lane);
                if start.elapsed() >= time {
                    return Ok(());
                }
            }
            Ok(())
        })?;
        Ok(next.into_inner())
    }

    /// How large a lane's next batch may be.
    fn next_batch(&self, lane: &Lane) -> Batch {
        let n_paths = self.batch.load(Ordering::Relaxed);
        let size = lane.size();
        Batch { first: 0, n_paths, n_places: n_paths * (size.n_places / size.n_paths) }
    }

    /// Doubles or halves a GPU's batch by how long its lists of commands took; any batch gives the
    /// same samples.
    fn adapt_batch(&self, n: u32, lane: &Lane) {
        // A software GPU has no watchdog, and its lists take their time whatever they hold.
        if self.device.info().kind != DeviceKind::Gpu {
            return;
        }
        let longest = lane.take_longest_run();
        let adapted = match longest {
            _ if longest > RUN_LIMIT => (n / 2).max(1),
            _ if longest < RUN_TARGET => (n * 2).min(lane.size().n_paths),
            _ => n,
        };
        self.batch.store(adapted, Ordering::Relaxed);
    }

    /// Runs `work` once for each lane, at once where the device can; the first error counts.
    fn for_each_lane(
        &self,
        work: impl Fn(&dyn Device, usize, &Lane) -> Result<(), RenderError> + Sync,
    ) -> Result<(), RenderError> {
        let failure = Mutex::new(None);
        let run = |index: usize| {
            if let Err(error) = work(&*self.device, index, &self.lanes[index]) {
                failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
            }
        };
        // SAFETY: a lane writes its own buffers; the film, which all write, is atomic; a pool's
        // vertices and paths are written by the lane that traces them, each at its own places, and
        // read once all lanes are done.
        unsafe { self.device.for_each_lane(&run) };
        failure.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }
}

/// What a change of settings starts from: the scene on its device, its film, and what was measured.
#[derive(Clone)]
struct Kept {
    /// Without what was copied to the device.
    packed: PackedScene,
    scene_plan: MemoryPlan,
    pipelines: Pipelines,
    /// The scene's buffers, the film and the image.
    shared: BufferSet,
    /// Pixels that these two have room for.
    n_pixels: u32,
    /// Groups of lights that the film has room for.
    n_groups: u32,
    camera: Camera,
    /// L by what it depends on, the bound of path lengths.
    light_vertices: Vec<(Option<u32>, f32)>,
    /// Set from outside: the pass under way is not worth its end.
    stop: Arc<AtomicBool>,
}

impl Kept {
    /// The constants of a whole render, and L, which is measured where it is needed first.
    fn base_params(
        &mut self,
        device: &dyn Device,
        settings: &RenderSettings,
    ) -> Result<(Params, f32), RenderError> {
        let mut base = base_params(settings, &self.camera, &self.packed, n_light_paths(settings));
        base.n_groups = self.groups_of(settings);
        if settings.integrator.joins().is_none() {
            return Ok((base, 0.0));
        }
        let bound = settings.max_path_length;
        let measured = self.light_vertices.iter().find(|(of, _)| *of == bound).map(|&(_, mean)| mean);
        let mean = match measured {
            Some(mean) => mean,
            None => measure_light_vertices(device, &self.pipelines, &self.shared, &base)?,
        };
        if measured.is_none() {
            self.light_vertices.push((bound, mean));
        }
        base.join_factor = join_factor(settings, mean);
        Ok((base, mean))
    }

    fn sizes(
        &self,
        device: &dyn Device,
        settings: &RenderSettings,
        mean_light_vertices: f32,
    ) -> Result<Sizes, RenderError> {
        let shared = plan_shared(&self.scene_plan, settings, self.n_pixels, self.n_groups);
        let n_lanes = device.lanes() as u32;
        Sizes::fit(device.info(), settings, mean_light_vertices, n_light_paths(settings), n_lanes, &shared)
    }
}

fn n_pixels(settings: &RenderSettings) -> u32 {
    let window = settings.window();
    window.width * window.height
}

/// Light paths of a pass that joins draw from.
fn n_light_paths(settings: &RenderSettings) -> u32 {
    match settings.integrator.light_paths {
        LightPaths::Pool(Some(n)) if settings.integrator.uses_pool() => n,
        _ => n_pixels(settings),
    }
}

/// Hands the scene's words over to the device, and copies its images there.
fn upload(device: &dyn Device, packed: &mut PackedScene) -> Result<BufferSet, RenderError> {
    let mut set = BufferSet::default();
    let parts =
        [("nodes", &mut packed.nodes), ("triangles", &mut packed.triangles), ("scene", &mut packed.scene)];
    for (name, words) in parts {
        set.insert(name, upload_words(device, name, std::mem::take(words))?);
    }
    let texels = device.create_buffer("texels", packed.images.bytes(), BufferUsage::Texels)?;
    packed.images.upload(device, &texels)?;
    set.insert("texels", texels);
    Ok(set)
}

/// A buffer of a scene's words.
fn upload_words(device: &dyn Device, name: &str, mut words: Vec<[u32; 4]>) -> Result<Buffer, RenderError> {
    if words.is_empty() {
        words.push([0; 4]); // a kernel's array has at least one element, even over an empty scene
    }
    Ok(device.create_buffer_of(name, words, BufferUsage::Storage)?)
}

/// Compiles what `settings` need, all at once, for this scene.
fn load_kernels(
    device: &dyn Device,
    packed: &PackedScene,
    settings: &RenderSettings,
) -> Result<Pipelines, RenderError> {
    let pool_kernels = settings.integrator.uses_pool().then_some(POOL_KERNELS);
    let names = LaneUses::of(settings).kernels().chain(pool_kernels.into_iter().flatten()).chain(["resolve"]);
    let apart = settings.light_groups && packed.light_groups.len() > 1;
    let features = packed.features | if apart { k::FEATURE_LIGHT_GROUPS } else { 0 };
    Ok(Pipelines::load(device, features, &names.collect::<Vec<_>>())?)
}

/// Puts a film for each of `n_groups` and an image of `n_pixels` in place of those in the set.
fn make_film(
    device: &dyn Device,
    set: &mut BufferSet,
    n_pixels: u32,
    n_groups: u32,
) -> Result<(), RenderError> {
    let film_bytes = u64::from(n_pixels) * u64::from(n_groups) * u64::from(k::FILM_STRIDE) * 4;
    let film = device.create_buffer("film", film_bytes, BufferUsage::Storage)?;
    set.insert("image", device.create_buffer("image", u64::from(n_pixels) * 16, BufferUsage::Storage)?);
    set.insert("film", film);
    Ok(())
}

/// The image of a window, from where `resolve` put it.
fn read_image(device: &dyn Device, image: &Buffer, window: Crop) -> Result<Image, RenderError> {
    let bytes = device.read_buffer(image, 0, u64::from(window.width) * u64::from(window.height) * 16)?;
    let words: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
    Ok(Image {
        width: window.width as usize,
        height: window.height as usize,
        pixels: words.into_iter().map(|[r, g, b, _]| [r, g, b]).collect(),
    })
}

/// L: the mean number of connectible vertices (s >= 2) of a light path, by a pilot of fixed seed.
fn measure_light_vertices(
    device: &dyn Device,
    pipelines: &Pipelines,
    shared: &BufferSet,
    base: &Params,
) -> Result<f32, RenderError> {
    let size = LaneSize {
        n_paths: PILOT_PATHS,
        n_places: PILOT_PATHS,
        n_shadow_rays: 1,
        append_at: 0,
        append_capacity: 0,
    };
    let lane = Lane::new(device, pipelines, shared, size, LaneUses::light_paths(), true)?;
    let params = Params {
        seed: PILOT_SEED,
        // Paths numbered from 0, whatever the film and its crop: L is then the same for all of them.
        crop_x: 0,
        crop_y: 0,
        crop_width: PILOT_PATHS,
        film_width: PILOT_PATHS,
        n_pixels: PILOT_PATHS,
        n_paths: PILOT_PATHS,
        n_places: PILOT_PATHS,
        n_light_paths: PILOT_PATHS,
        join: k::JOIN_FULL,
        flags: base.flags & !(k::FLAG_POOL | k::FLAG_SPLAT),
        emitter_survival: 1.0,
        ..*base
    };
    let n = lane.trace_light_paths(device, &params)?;
    // At least one vertex in the whole pilot, so that K / L stays finite.
    Ok(n.max(1) as f32 / PILOT_PATHS as f32)
}
