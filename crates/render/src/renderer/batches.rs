//! Batches: what lanes work through at a time.

use std::{
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicU32, Ordering},
    },
    time::{Duration, Instant},
};

use midway_device::{Device, DeviceKind};
use midway_kernels::layout::Params;

use super::Renderer;
use crate::{Join, RenderError, batch::Lane, sizes::reserved_slots};

/// A part of a GPU's list of commands, as it is submitted, aims to last at least this long, so that little time
/// goes to submitting…
const RUN_TARGET: Duration = Duration::from_millis(40);
/// … and at most this long: of its many dispatches none then lasts 50 ms, and a desktop's watchdog never fires.
const RUN_LIMIT: Duration = Duration::from_millis(100);
/// Places for each path in flight of batches that are to be over soon: before it is known how long they
/// take, and where somebody looks on.
pub(super) const FEW_PLACES: u32 = 4;
/// Passes grow until they last so long: whoever waits for the end of one (a limit of time, Ctrl-C, several
/// devices) is to wait no longer.
const PASS_TARGET: Duration = Duration::from_millis(250);

/// Places of a pass that a lane works through at a time, with this many paths in flight at most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Batch {
    pub first: u32,
    pub n_paths: u32,
    pub n_places: u32,
}

impl Renderer {
    /// Light and camera subpaths of one batch; in halves where the light paths did not fit.
    pub(super) fn render_batch(
        &self,
        device: &dyn Device,
        lane: &Lane,
        params: Params,
    ) -> Result<(), RenderError> {
        let mut params = self.own_vertex_params(lane, params);
        let mut n_splats = 0;
        if self.pool.is_none() && self.settings.integrator.uses_light_paths() {
            let n_vertices = lane.trace_light_paths(device, &params)?;
            if params.append_transient == 0 {
                if n_vertices > params.append_capacity {
                    return self.render_halves(device, lane, params);
                }
                n_splats = n_vertices;
            }
        }
        params.append_transient = 0;
        lane.trace_camera_paths(device, &params, n_splats)
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
    pub(super) fn trace_pool(&self, params: &Params) -> Result<(), RenderError> {
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
                self.adapt_batch(n_paths, n, lane);
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
    pub(super) fn for_each_batch(
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
                let n_places = most.n_places.min(end - first);
                run(device, lane, Batch { first, n_places, ..most })?;
                self.adapt_batch(most.n_paths, n_places, lane);
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
        Batch { first: 0, n_paths, n_places: n_paths * self.places_per_path(lane) }
    }

    /// Places of a lane's batch for each path in flight.
    fn places_per_path(&self, lane: &Lane) -> u32 {
        let most = lane.size().n_places / lane.size().n_paths;
        let is_soon_over = self.kept.is_watched || !self.is_settled.load(Ordering::Relaxed);
        if is_soon_over { most.min(FEW_PLACES) } else { most }
    }

    /// Samples of a pass that fills the lanes: few at first, then up to twice as many as in the last, as far as
    /// these take no longer than a pass is to last.
    pub(super) fn samples_to_fill(&self) -> u32 {
        let per_sample = self.base.n_pixels;
        let places = |of: &dyn Fn(&Lane) -> u32| self.lanes.iter().map(of).sum::<u32>() / per_sample;
        let few = places(&|lane| lane.size().n_places.min(lane.size().n_paths * FEW_PLACES));
        let most = if self.kept.is_watched { few } else { places(&|lane| lane.size().n_places) };
        let grown = self.last_pass.map_or(0.0, |(n, time)| {
            let growth = PASS_TARGET.as_secs_f64() / time.as_secs_f64().max(1e-6);
            f64::from(n) * growth.min(2.0)
        });
        most.min(few.max(grown as u32)).max(1)
    }

    /// Enlarges or halves a GPU's batch of `n` paths in flight and `n_places` by how long the parts of its
    /// lists of commands took; any batch gives the same samples.
    fn adapt_batch(&self, n: u32, n_places: u32, lane: &Lane) {
        // A software GPU has no watchdog, and its lists take their time whatever they hold.
        if self.device.info().kind != DeviceKind::Gpu {
            return;
        }
        let longest = lane.take_longest_part();
        // What did not fill its slots says nothing of those that do.
        if n_places < n {
            return;
        }
        let adapted = match longest {
            _ if longest > RUN_LIMIT => (n / 2).max(1),
            // A part with more paths takes longer by no more than their ratio.
            _ if longest < RUN_TARGET / 8 => n * 4,
            _ if longest < RUN_TARGET => n * 2,
            _ => n,
        };
        let adapted = adapted.min(lane.size().n_paths);
        self.batch.store(adapted, Ordering::Relaxed);
        self.is_settled.store(adapted == n, Ordering::Relaxed);
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
