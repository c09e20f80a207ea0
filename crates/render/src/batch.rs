//! One batch of paths on one lane: its working buffers, and its phases as lists of commands.

use std::{
    collections::BTreeMap,
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, AtomicUsize, Ordering},
    },
    time::Duration,
};

use midway_device::{
    BoundKernel, Buffer, BufferUsage, Command, Device, DeviceError, DeviceKind, MemoryPlan, RunTiming,
};
use midway_kernels::{constants as k, layout::Params};

use crate::{
    Join, RenderError, RenderSettings,
    buffers::{BufferSet, Pipelines, dispatch, dispatch_indirect},
    record::{BounceRays, Recorder},
};

/// Bytes of a vec4.
const VEC4: u64 = 16;
/// Bounces of a GPU between two questions whether any path is left, where more were taken than expected.
const BOUNCES_PER_RUN: usize = 16;
/// Counters that a batch starts from zero; those after them add up over the render.
const BATCH_COUNTERS: usize = k::COUNT_RAYS_LOW as usize;

/// How large a lane's buffers are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LaneSize {
    /// Paths in flight at most: slots.
    pub n_paths: u32,
    /// Places that a batch fills them with, at most: whoever ends hands its slot on, so that there is
    /// one thin tail of bounces for all of them.
    pub n_places: u32,
    /// Shadow rays that a slot may push in a bounce.
    pub n_shadow_rays: u32,
    /// Slots of light vertices before the appended ones.
    pub append_at: u32,
    /// Light vertices that can be appended.
    pub append_capacity: u32,
}

impl LaneSize {
    fn path_bytes(&self) -> u64 {
        u64::from(self.n_paths) * u64::from(k::PATH_STRIDE) * VEC4
    }

    fn shadow_capacity(&self) -> u32 {
        self.n_paths * self.n_shadow_rays
    }

    fn shadow_bytes(&self) -> u64 {
        u64::from(self.shadow_capacity()) * u64::from(k::SHADOW_STRIDE) * VEC4
    }

    /// Room for the joins of a bounce: as many as shadow rays, but for the one of the light that is sampled.
    fn join_bytes(&self) -> u64 {
        u64::from(self.n_paths) * u64::from(self.n_shadow_rays - 1) * 8
    }

    fn vertex_bytes(&self) -> u64 {
        u64::from((self.append_at + self.append_capacity).max(1)) * u64::from(k::VERTEX_STRIDE) * VEC4
    }

    /// Adds `lanes` lanes of this size to a plan. `own_vertices`: they keep light vertices that are not a pool's.
    pub fn plan(&self, plan: &mut MemoryPlan, lanes: u64, uses: LaneUses, own_vertices: bool) {
        plan.scaling("paths", lanes * self.path_bytes());
        plan.scaling("queues", lanes * u64::from(self.n_paths) * 8);
        plan.scaling("shadow rays", lanes * self.shadow_bytes());
        if uses.lists_joins() {
            plan.scaling("joins", lanes * self.join_bytes());
        }
        if own_vertices {
            plan.scaling("light vertices", lanes * self.vertex_bytes());
            plan.scaling("light paths", lanes * u64::from(self.n_places) * 8);
        }
    }
}

/// Counters of a batch, as it left them.
type Counters = [u32; BATCH_COUNTERS];

/// The working buffers of a lane and the kernels bound to them.
pub struct Lane {
    size: LaneSize,
    /// Places that it was made with.
    most_places: u32,
    uses: LaneUses,
    params: Buffer,
    counters: Buffer,
    args: Buffer,
    light: Option<LightKernels>,
    connect_camera: Option<BoundKernel>,
    camera: Option<CameraKernels>,
    joins: Option<JoinKernels>,
    trace_closest: BoundKernel,
    plan_queue: BoundKernel,
    plan_shadow: BoundKernel,
    trace_shadow: BoundKernel,
    /// Bounces that the next batch's light paths are expected to take, and its camera paths.
    light_bounces: AtomicUsize,
    camera_bounces: AtomicUsize,
    /// Nanoseconds that no part of a list of commands lasted longer than.
    longest_part: AtomicU64,
    /// Of each kernel so far, while that is asked for.
    times: Mutex<Option<KernelTimes>>,
    recorder: Recorder,
    /// What was recorded, while that is asked for.
    recorded: Mutex<Option<Recording>>,
}

/// The time on the device of each kernel, by its name.
pub type KernelTimes = BTreeMap<&'static str, KernelTime>;

/// The time on the device of a kernel's dispatches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KernelTime {
    /// All of them together.
    pub total: Duration,
    /// The longest.
    pub longest: Duration,
}

impl std::ops::Add for KernelTime {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { total: self.total + other.total, longest: self.longest.max(other.longest) }
    }
}

/// Rays read back so far; `n_paths`: of the batch under way.
#[derive(Default)]
struct Recording {
    n_paths: u32,
    bounces: Vec<BounceRays>,
}

/// What traces light subpaths.
struct LightKernels {
    generate: BoundKernel,
    shade: BoundKernel,
}

/// What traces camera subpaths.
struct CameraKernels {
    generate: BoundKernel,
    shade: BoundKernel,
}

/// How camera vertices are joined to light vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Joining {
    /// `full` and `k-step`: joins are listed and made one by one.
    Listed,
    /// Single-step: where a path ends.
    Ends,
}

/// What does so.
enum JoinKernels {
    Listed { list: BoundKernel, plan: BoundKernel, connect: BoundKernel },
    Ends(BoundKernel),
}

impl JoinKernels {
    /// The commands of a bounce.
    fn commands(&self, args: &Buffer) -> Vec<Command> {
        match self {
            Self::Listed { list, plan, connect } => vec![
                dispatch_indirect(list, args, k::ARGS_QUEUE),
                dispatch(plan, 1),
                dispatch_indirect(connect, args, k::ARGS_JOINS),
            ],
            Self::Ends(connect) => vec![dispatch_indirect(connect, args, k::ARGS_SHADE)],
        }
    }
}

/// What a lane is for: of the rest it loads no kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LaneUses {
    light: bool,
    splat: bool,
    camera: bool,
    joins: Option<Joining>,
}

impl LaneUses {
    /// All that an integrator does.
    pub fn of(settings: &RenderSettings) -> Self {
        let integrator = &settings.integrator;
        Self {
            light: integrator.uses_light_paths(),
            splat: integrator.uses_splat(),
            camera: integrator.uses_camera_paths(),
            joins: integrator.joins().map(|join| match join {
                Join::SingleStep => Joining::Ends,
                Join::Full | Join::KStep => Joining::Listed,
            }),
        }
    }

    /// The kernels that any integrator needs.
    pub fn all_kernels() -> impl Iterator<Item = &'static str> {
        Self { light: true, splat: true, camera: true, joins: Some(Joining::Listed) }
            .kernels()
            .chain(["connect_ends"])
    }

    /// Light paths alone, for themselves.
    pub fn light_paths() -> Self {
        Self { light: true, splat: false, camera: false, joins: None }
    }

    /// Whether joins are listed and made one by one.
    pub fn lists_joins(self) -> bool {
        self.joins == Some(Joining::Listed)
    }

    /// The kernels that it needs.
    pub fn kernels(self) -> impl Iterator<Item = &'static str> {
        let sets: [(bool, &[&str]); 6] = [
            (self.light, &["generate_light", "shade_light"]),
            (self.splat, &["connect_camera"]),
            (self.camera, &["generate_camera", "shade_camera"]),
            (self.lists_joins(), &["list_joins", "plan_joins", "connect"]),
            (self.joins == Some(Joining::Ends), &["connect_ends"]),
            (true, &["trace_closest", "trace_shadow", "plan_queue", "plan_shadow"]),
        ];
        sets.into_iter().filter(|(used, _)| *used).flat_map(|(_, names)| names.iter().copied())
    }
}

impl Lane {
    /// Allocates a lane. `shared` holds the scene, the film and, with a pool, its light vertices.
    pub fn new(
        device: &dyn Device,
        pipelines: &Pipelines,
        shared: &BufferSet,
        size: LaneSize,
        uses: LaneUses,
        own_vertices: bool,
    ) -> Result<Self, RenderError> {
        let mut set = shared.clone();
        let mut add = |name: &'static str, bytes: u64, usage| -> Result<Buffer, DeviceError> {
            let buffer = device.create_buffer(name, bytes, usage)?;
            set.insert(name, buffer.clone());
            Ok(buffer)
        };
        let params = add("params", size_of::<Params>() as u64, BufferUsage::Uniform)?;
        let counters = add("counters", u64::from(k::N_COUNTERS) * 4, BufferUsage::Storage)?;
        let args = add("dispatch_args", u64::from(k::N_ARGS) * 4, BufferUsage::Indirect)?;
        let paths = add("paths", size.path_bytes(), BufferUsage::Storage)?;
        let queues = add("queues", u64::from(size.n_paths) * 8, BufferUsage::Storage)?;
        let shadow_rays = add("shadow_rays", size.shadow_bytes(), BufferUsage::Storage)?;
        if uses.light && own_vertices {
            add("light_vertices", size.vertex_bytes(), BufferUsage::Storage)?;
            add("light_paths", u64::from(size.n_places) * 8, BufferUsage::Storage)?;
        }
        if uses.lists_joins() {
            add("joins", size.join_bytes(), BufferUsage::Storage)?;
        }
        let bind = |name| set.bind(device, pipelines, name);
        let bind_if = |used: bool, name| used.then(|| bind(name)).transpose();
        let light = || -> Result<_, RenderError> {
            Ok(LightKernels { generate: bind("generate_light")?, shade: bind("shade_light")? })
        };
        let camera = || -> Result<_, RenderError> {
            Ok(CameraKernels { generate: bind("generate_camera")?, shade: bind("shade_camera")? })
        };
        let joins = |joining| -> Result<_, RenderError> {
            Ok(match joining {
                Joining::Ends => JoinKernels::Ends(bind("connect_ends")?),
                Joining::Listed => JoinKernels::Listed {
                    list: bind("list_joins")?,
                    plan: bind("plan_joins")?,
                    connect: bind("connect")?,
                },
            })
        };
        let recorder = Recorder { paths, queues, shadow_rays, counters: counters.clone() };
        Ok(Self {
            recorder,
            recorded: Mutex::new(None),
            times: Mutex::new(None),
            size,
            most_places: size.n_places,
            uses,
            params,
            counters,
            args,
            light: uses.light.then(light).transpose()?,
            connect_camera: bind_if(uses.splat, "connect_camera")?,
            camera: uses.camera.then(camera).transpose()?,
            joins: uses.joins.map(joins).transpose()?,
            trace_closest: bind("trace_closest")?,
            plan_queue: bind("plan_queue")?,
            plan_shadow: bind("plan_shadow")?,
            trace_shadow: bind("trace_shadow")?,
            light_bounces: AtomicUsize::new(BOUNCES_PER_RUN),
            camera_bounces: AtomicUsize::new(BOUNCES_PER_RUN),
            longest_part: AtomicU64::new(0),
        })
    }

    /// Its size.
    pub fn size(&self) -> LaneSize {
        self.size
    }

    /// What it is for.
    pub fn uses(&self) -> LaneUses {
        self.uses
    }

    /// Places that it was made with, for each path in flight.
    pub fn most_places(&self) -> u32 {
        self.most_places / self.size.n_paths
    }

    /// Takes on another size, with no more places than it was made with, where its buffers have room for it.
    /// Only own light vertices may move.
    pub fn resize(&mut self, size: LaneSize) -> bool {
        let slots = |size: LaneSize| u64::from(size.append_at) + u64::from(size.append_capacity);
        let fits = size.n_paths == self.size.n_paths
            && size.n_places <= self.most_places
            && size.n_shadow_rays <= self.size.n_shadow_rays
            && slots(size) <= slots(self.size);
        if fits {
            self.size.n_places = size.n_places;
            self.size.append_capacity = self.size.append_at + self.size.append_capacity - size.append_at;
            self.size.append_at = size.append_at;
        }
        fits
    }

    /// What no part of a list of commands lasted longer than since this was last asked.
    pub fn take_longest_part(&self) -> Duration {
        Duration::from_nanos(self.longest_part.swap(0, Ordering::Relaxed))
    }

    /// Traces the light subpaths of `params`' batch and keeps their vertices; those that last one
    /// bounce only are projected onto the film as they come. Returns how many were appended in all,
    /// which may be more than there was room for.
    pub fn trace_light_paths(&self, device: &dyn Device, params: &Params) -> Result<u32, RenderError> {
        let Some(light) = &self.light else { return Ok(0) };
        let params = &Params { n_paths: params.n_paths.min(params.n_places), ..*params };
        let mut turn = vec![dispatch(&self.plan_queue, 1)];
        if let Some(connect_camera) = self.connect_camera.as_ref().filter(|_| params.append_transient != 0) {
            turn.push(dispatch_indirect(connect_camera, &self.args, k::ARGS_SPLAT));
            turn.extend(self.shadow_commands());
        }
        let mut start = self.begin(params, 0).to_vec();
        start.push(dispatch(&light.generate, params.n_paths));
        start.extend(turn.iter().cloned());
        let mut bounce = vec![
            dispatch_indirect(&self.trace_closest, &self.args, k::ARGS_QUEUE),
            dispatch_indirect(&light.shade, &self.args, k::ARGS_SHADE),
        ];
        bounce.extend(turn);
        let counters = self.run_until_empty(device, start, &bounce, &self.light_bounces)?;
        Ok(counters[k::COUNT_VERTICES as usize])
    }

    /// Projects the first `n` appended light vertices onto the film (t = 1).
    pub fn splat_light_vertices(&self, device: &dyn Device, n: u32) -> Result<(), RenderError> {
        self.run(device, &self.splats(device, n)?)
    }

    /// Those commands; none are left where rays are recorded.
    fn splats(&self, device: &dyn Device, n: u32) -> Result<Vec<Command>, RenderError> {
        let mut commands = Vec::new();
        let Some(connect_camera) = &self.connect_camera else { return Ok(commands) };
        let mut first = 0;
        while first < n {
            let end = n.min(first + self.size.shadow_capacity());
            commands.push(write_words(&self.counters, k::COUNT_SPLAT_FIRST, &[first, end]));
            commands.push(dispatch(connect_camera, end - first));
            commands.extend(self.shadow_commands());
            if let Some(recording) = &mut *self.recording() {
                device.run(&commands, false)?;
                commands.clear();
                let shadow = self.recorder.shadow(device)?;
                recording.bounces.push(BounceRays { closest: Vec::new(), shadow });
            }
            first = end;
        }
        Ok(commands)
    }

    /// Projects the first `n_splats` appended light vertices onto the film; then traces the camera subpaths of
    /// `params`' batch, joined to the light vertices kept.
    pub fn trace_camera_paths(
        &self,
        device: &dyn Device,
        params: &Params,
        n_splats: u32,
    ) -> Result<(), RenderError> {
        let Some(camera) = &self.camera else { return self.splat_light_vertices(device, n_splats) };
        let params = &Params { n_paths: params.n_paths.min(params.n_places), ..*params };
        let mut start = self.splats(device, n_splats)?;
        start.extend(self.begin(params, params.n_paths));
        start.extend([dispatch(&camera.generate, params.n_paths), dispatch(&self.plan_queue, 1)]);
        let mut bounce = vec![dispatch_indirect(&self.trace_closest, &self.args, k::ARGS_QUEUE)];
        bounce.extend(self.joins.iter().flat_map(|joins| joins.commands(&self.args)));
        bounce.push(dispatch_indirect(&camera.shade, &self.args, k::ARGS_SHADE));
        bounce.push(dispatch(&self.plan_queue, 1)); // plans shadow rays too
        bounce.push(dispatch_indirect(&self.trace_shadow, &self.args, k::ARGS_SHADOW));
        self.run_until_empty(device, start, &bounce, &self.camera_bounces)?;
        Ok(())
    }

    /// Calls `work`, which traces a batch on this lane, and returns every ray that was traced, bounce by
    /// bounce: those of light paths first, then what projects their vertices onto the film. One bounce at a
    /// time: slower, with the same results.
    pub fn record(
        &self,
        work: impl FnOnce() -> Result<(), RenderError>,
    ) -> Result<Vec<BounceRays>, RenderError> {
        *self.recording() = Some(Recording::default());
        let outcome = work();
        let recorded = self.recording().take();
        outcome.map(|()| recorded.map(|r| r.bounces).unwrap_or_default())
    }

    fn recording(&self) -> MutexGuard<'_, Option<Recording>> {
        self.recorded.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The counters that add up over the render: rays, rejected samples, overflows.
    pub fn totals(&self, device: &dyn Device) -> Result<LaneTotals, RenderError> {
        read_totals(device, &self.counters)
    }

    fn shadow_commands(&self) -> [Command; 2] {
        [dispatch(&self.plan_shadow, 1), dispatch_indirect(&self.trace_shadow, &self.args, k::ARGS_SHADOW)]
    }

    /// The commands that write a batch's constants and counters; `queued` paths will be in the queue's write half.
    fn begin(&self, params: &Params, queued: u32) -> [Command; 2] {
        debug_assert!(params.n_paths <= self.size.n_paths && params.n_places <= self.size.n_places);
        if let Some(recording) = &mut *self.recording() {
            recording.n_paths = params.n_paths;
        }
        let mut counters: Counters = [0; BATCH_COUNTERS];
        counters[k::COUNT_OUT as usize] = queued;
        counters[k::COUNT_PARITY as usize] = 1;
        counters[k::COUNT_NEXT as usize] = params.n_paths;
        [
            Command::Write { to: self.params.clone(), offset: 0, data: bytemuck::bytes_of(params).into() },
            write_words(&self.counters, 0, &counters),
        ]
    }

    /// Runs `start`, then `bounce` until no path is queued: first as often as is `expected`, so that a GPU is
    /// waited for once as a rule, then a few at a time.
    fn run_until_empty(
        &self,
        device: &dyn Device,
        mut commands: Vec<Command>,
        bounce: &[Command],
        expected: &AtomicUsize,
    ) -> Result<Counters, RenderError> {
        if let Some(recording) = &mut *self.recording() {
            device.run(&commands, false)?;
            // Light paths' first vertices are projected before anything is traced.
            let shadow = self.recorder.shadow(device)?;
            if !shadow.is_empty() {
                recording.bounces.push(BounceRays { closest: Vec::new(), shadow });
            }
            let mut counters = self.run_and_count(device, &[])?;
            while counters[k::COUNT_IN as usize] > 0 {
                let closest = self.recorder.queued(device, recording.n_paths)?;
                counters = self.run_and_count(device, bounce)?;
                recording.bounces.push(BounceRays { closest, shadow: self.recorder.shadow(device)? });
            }
            return Ok(counters);
        }
        // Asking whether any path is left is free on the CPU.
        let (first, next) = match device.info().kind {
            DeviceKind::Cpu => (1, 1),
            DeviceKind::Gpu | DeviceKind::SoftwareGpu => (expected.load(Ordering::Relaxed), BOUNCES_PER_RUN),
        };
        let repeated = |n: usize| bounce.iter().cycle().take(bounce.len() * n).cloned();
        commands.extend(repeated(first));
        loop {
            let counters = self.run_and_count(device, &commands)?;
            if counters[k::COUNT_IN as usize] == 0 {
                let taken = counters[k::COUNT_BOUNCES as usize] as usize;
                expected.store(expected_after(first, taken), Ordering::Relaxed);
                return Ok(counters);
            }
            commands = repeated(next).collect();
        }
    }

    /// Runs commands, timed kernel by kernel where that is asked for.
    fn run(&self, device: &dyn Device, commands: &[Command]) -> Result<(), RenderError> {
        let mut times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
        let timing = device.run(commands, times.is_some())?;
        self.note(&timing, &mut times);
        Ok(())
    }

    /// The same, and the batch's counters after them.
    fn run_and_count(&self, device: &dyn Device, commands: &[Command]) -> Result<Counters, RenderError> {
        let mut times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
        let bytes = size_of::<Counters>() as u64;
        let (timing, read) = device.run_and_read(commands, times.is_some(), &self.counters, (0, bytes))?;
        self.note(&timing, &mut times);
        Ok(bytemuck::pod_read_unaligned(&read))
    }

    fn note(&self, timing: &RunTiming, times: &mut Option<KernelTimes>) {
        if let Some(times) = times {
            for &(kernel, time) in &timing.dispatches {
                let sum = times.entry(kernel).or_default();
                *sum = *sum + KernelTime { total: time, longest: time };
            }
        }
        self.longest_part.fetch_max(timing.longest_part.as_nanos() as u64, Ordering::Relaxed);
    }

    /// Starts to time each kernel, from zero.
    pub fn time_kernels(&self) {
        *self.times.lock().unwrap_or_else(PoisonError::into_inner) = Some(KernelTimes::new());
    }

    /// The times since that was asked for; none where it was not.
    pub fn kernel_times(&self) -> KernelTimes {
        self.times.lock().unwrap_or_else(PoisonError::into_inner).clone().unwrap_or_default()
    }
}

/// How many bounces to expect of the next batch, where `expected` were run at once of this one and `taken` had
/// paths: another wait for a GPU costs more than a few bounces without any.
fn expected_after(expected: usize, taken: usize) -> usize {
    taken.max(expected - expected.saturating_sub(taken).div_ceil(4))
}

/// Writes words of a buffer from the one numbered `first` on.
fn write_words(to: &Buffer, first: u32, words: &[u32]) -> Command {
    Command::Write { to: to.clone(), offset: u64::from(first) * 4, data: bytemuck::cast_slice(words).into() }
}

/// The counters that add up, read from the device.
pub fn read_totals(device: &dyn Device, counters: &Buffer) -> Result<LaneTotals, RenderError> {
    let bytes = device.read_buffer(counters, 0, u64::from(k::N_COUNTERS) * 4)?;
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes);
    let word = |index: u32| u64::from(words[index as usize]);
    Ok(LaneTotals {
        rays: word(k::COUNT_RAYS_LOW) | word(k::COUNT_RAYS_HIGH) << 32,
        rejected: word(k::COUNT_REJECTED),
        overflowed: word(k::COUNT_OVERFLOW),
    })
}

/// What a lane has counted since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LaneTotals {
    /// Rays traced, closest and shadow.
    pub rays: u64,
    /// Contributions rejected as NaN, infinite or negative.
    pub rejected: u64,
    /// Film sums that overflowed.
    pub overflowed: u64,
}

impl std::ops::Add for LaneTotals {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            rejected: self.rejected + other.rejected,
            overflowed: self.overflowed + other.overflowed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::expected_after;

    #[test]
    fn as_many_bounces_are_expected_as_were_taken_and_fewer_only_slowly() {
        assert_eq!(expected_after(16, 40), 40);
        assert_eq!(expected_after(40, 40), 40);
        assert_eq!(expected_after(40, 20), 35);
        assert_eq!(expected_after(21, 20), 20);
        assert_eq!(expected_after(16, 0), 12);
        let settled = (0..100).fold(1000, |expected, _| expected_after(expected, 30));
        assert_eq!(settled, 30);
    }
}
