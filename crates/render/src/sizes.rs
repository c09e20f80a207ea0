//! How large the working buffers are: as large as pays, or as fits.

use midway_device::{DeviceInfo, DeviceKind, MemoryPlan};
use midway_kernels::constants as k;

use crate::{
    IntegratorSettings, Join, RenderError, RenderSettings, aov,
    batch::{LaneSize, LaneUses},
    pool::PoolSize,
};

/// A pool's light vertices are given this much more room than the pilot's mean asks for: a pool that does not
/// fit is an error.
const POOL_ROOM: f64 = 1.25;
/// Light paths of the pilot that measures that mean.
pub const PILOT_PATHS: u32 = 16_384;
/// Those of a batch so many standard errors of the pilot's mean…
const PILOT_ERRORS: f64 = 6.0;
/// … and of the batch's own…
const BATCH_ERRORS: f64 = 8.0;
/// … and this many more, for small batches. A batch that does not fit is run in halves.
const VERTEX_ROOM_LEAST: u32 = 1024;
/// Places of a GPU's batch for each path in flight, at most: the more, the less the thin tail of its last
/// bounces weighs…
pub const MOST_PLACES: u32 = 64;
/// … and at least, where places take memory…
const LEAST_PLACES: u32 = 2;
/// … of which there are so many bytes for each path in flight where they keep light vertices, 768 MiB in all…
const BYTES_OF_VERTICES: f64 = 768.0;
/// … and so many where they take two words alone.
const BYTES_OF_WORDS: f64 = 128.0;
/// Of a software GPU, which has no tail to speak of.
const PLACES_OF_SOFTWARE: u32 = 4;
/// Batches smaller than this are not tried on a device that is too small.
const SMALLEST_BATCH: u32 = 4096;

/// The sizes of a render's working buffers, and the plan with all its memory.
pub struct Sizes {
    /// Of each lane.
    pub lane: LaneSize,
    /// Of the pool, where joins draw from one.
    pub pool: Option<PoolSize>,
    /// Everything, what lanes share included.
    pub plan: MemoryPlan,
}

impl Sizes {
    /// The largest batch that pays on the device, halved until the plan fits. On a GPU it has `most_places`
    /// for each path in flight at most.
    ///
    /// # Errors
    /// If even the smallest batch does not fit.
    pub fn fit(
        device: &DeviceInfo,
        settings: &RenderSettings,
        mean_light_vertices: f32,
        n_light_paths: u32,
        n_lanes: u32,
        shared: &MemoryPlan,
        most_places: u32,
    ) -> Result<Self, RenderError> {
        let integrator = &settings.integrator;
        let mut n_paths = match device.kind {
            // A batch's end is no thinner than its middle there, and its buffers are to stay in caches.
            DeviceKind::Cpu => 1024,
            DeviceKind::SoftwareGpu => 16_384,
            DeviceKind::Gpu if integrator.uses_light_paths() => 1 << 20,
            DeviceKind::Gpu => 1 << 21,
        };
        let places_per_path = match device.kind {
            DeviceKind::Cpu => 1,
            DeviceKind::SoftwareGpu => PLACES_OF_SOFTWARE,
            DeviceKind::Gpu => places_per_path(settings, mean_light_vertices).min(most_places),
        };
        loop {
            let n_places = n_paths * places_per_path;
            let lane = lane_size(
                [n_paths, n_places],
                device.kind,
                settings,
                mean_light_vertices,
                n_light_paths,
                n_lanes,
            );
            let sizes = Self::of(lane, settings, n_light_paths, n_lanes, shared);
            match sizes.plan.check(device) {
                Ok(()) => return Ok(sizes),
                Err(error) if n_paths <= SMALLEST_BATCH => return Err(error.into()),
                Err(_) => n_paths /= 2,
            }
        }
    }

    fn of(
        lane: LaneSize,
        settings: &RenderSettings,
        n_light_paths: u32,
        n_lanes: u32,
        shared: &MemoryPlan,
    ) -> Self {
        let uses_pool = settings.integrator.uses_pool();
        let pool = uses_pool.then(|| PoolSize {
            n_paths: n_light_paths,
            n_vertices: reserved_slots(settings, n_light_paths) + lane.append_capacity * n_lanes,
        });
        let mut plan = shared.clone();
        let uses = LaneUses::of(settings);
        lane.plan(&mut plan, u64::from(n_lanes), uses, settings.integrator.uses_light_paths() && !uses_pool);
        if let Some(pool) = pool {
            pool.plan(&mut plan);
        }
        Self { lane, pool, plan }
    }
}

/// Places of a GPU's batch for each path in flight.
fn places_per_path(settings: &RenderSettings, mean_light_vertices: f32) -> u32 {
    let integrator = &settings.integrator;
    if !integrator.uses_light_paths() || integrator.uses_pool() {
        return MOST_PLACES;
    }
    let bytes = if integrator.joins().is_some() { BYTES_OF_VERTICES } else { BYTES_OF_WORDS };
    let vertices = match integrator.joins() {
        Some(Join::Full) => vertices_of_a_path(mean_light_vertices),
        _ => f64::from(reserved_slots(settings, 1)),
    };
    let of_a_place = vertices * f64::from(k::VERTEX_STRIDE) * 16.0 + 8.0;
    ((bytes / of_a_place) as u32).clamp(LEAST_PLACES, MOST_PLACES)
}

/// The standard deviation of a path's light vertices: as many as it has, or, where few have any, their root.
fn spread(mean_light_vertices: f64) -> f64 {
    mean_light_vertices.max(mean_light_vertices.sqrt())
}

/// What a light path has at most, by the pilot.
fn vertices_of_a_path(mean_light_vertices: f32) -> f64 {
    let mean = f64::from(mean_light_vertices);
    mean + PILOT_ERRORS * spread(mean) / f64::from(PILOT_PATHS).sqrt()
}

/// Room for the light vertices of so many paths of a batch.
fn vertex_room(n_paths: u32, mean_light_vertices: f32) -> u32 {
    let n = f64::from(n_paths);
    let own_error = BATCH_ERRORS * n.sqrt() * spread(mean_light_vertices.into());
    (n * vertices_of_a_path(mean_light_vertices) + own_error) as u32 + VERTEX_ROOM_LEAST
}

fn lane_size(
    [n_paths, n_places]: [u32; 2],
    kind: DeviceKind,
    settings: &RenderSettings,
    mean_light_vertices: f32,
    n_light_paths: u32,
    n_lanes: u32,
) -> LaneSize {
    let pool_room = |paths: u32| {
        (f64::from(paths) * (f64::from(mean_light_vertices) * POOL_ROOM + 1.0)) as u32 + VERTEX_ROOM_LEAST
    };
    let integrator = &settings.integrator;
    let append_capacity = match (integrator.joins(), integrator.uses_pool()) {
        (Some(Join::Full), false) => vertex_room(n_places, mean_light_vertices),
        (Some(Join::Full | Join::KStep), true) => pool_room(n_light_paths.div_ceil(n_lanes)),
        // Projected at once: a slot's vertex, and y_0 of the path that starts there.
        _ => 2 * n_paths,
    };
    let append_at = if integrator.uses_pool() { 0 } else { reserved_slots(settings, n_places) };
    LaneSize { n_paths, n_places, n_shadow_rays: shadow_rays(kind, integrator), append_at, append_capacity }
}

/// Shadow rays of a path in one bounce, at most: its joins and a light sample, or the projections of two
/// light vertices.
fn shadow_rays(kind: DeviceKind, integrator: &IntegratorSettings) -> u32 {
    let joins = match kind {
        DeviceKind::Cpu => k::CONNECTIONS_OF_RUNS,
        DeviceKind::Gpu | DeviceKind::SoftwareGpu => k::CONNECTIONS_PER_BOUNCE,
    };
    match integrator.joins() {
        None if integrator.uses_light_paths() => 2,
        None => 1,
        Some(Join::SingleStep) => 2,
        Some(Join::KStep) => 1 + integrator.k.min(joins),
        Some(Join::Full) => 1 + joins,
    }
}

/// Slots of light vertices that the join needs before the appended ones.
pub fn reserved_slots(settings: &RenderSettings, n_paths: u32) -> u32 {
    let integrator = &settings.integrator;
    match integrator.joins() {
        Some(Join::SingleStep) => n_paths,
        Some(Join::KStep) if !integrator.uses_pool() => n_paths * integrator.k,
        _ => 0,
    }
}

/// Buffers of a scene, by the names that [`plan_scene`] takes their bytes by.
pub const SCENE_BUFFERS: [&str; 4] = ["nodes", "triangles", "scene", "texels"];

/// The memory of a scene whose [`SCENE_BUFFERS`] have so many bytes.
pub fn plan_scene(bytes: [u64; 4]) -> MemoryPlan {
    let [nodes, triangles, scene, texels] = bytes;
    let mut plan = MemoryPlan::default();
    plan.fixed("nodes", nodes);
    plan.fixed("triangles", triangles);
    plan.fixed("scene", scene);
    plan.texels("texels", texels);
    plan
}

/// That of the scene and of all else that lanes share, whatever their size.
pub fn plan_shared(
    scene: &MemoryPlan,
    settings: &RenderSettings,
    n_pixels: u32,
    n_groups: u32,
) -> MemoryPlan {
    let mut plan = scene.clone();
    plan.fixed("film", u64::from(n_pixels) * u64::from(n_groups) * u64::from(k::FILM_STRIDE) * 4);
    plan.fixed("image", u64::from(n_pixels) * 16);
    aov::plan(settings, n_pixels, &mut plan);
    plan
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Integrator;

    fn places(integrator: IntegratorSettings, mean_light_vertices: f32) -> u32 {
        let settings = RenderSettings { integrator, ..RenderSettings::default() };
        places_per_path(&settings, mean_light_vertices)
    }

    #[test]
    fn places_are_as_many_as_their_memory_allows() {
        let path = IntegratorSettings { integrator: Integrator::Path, ..Default::default() };
        let full = IntegratorSettings { integrator: Integrator::Bdpt, ..path };
        let k_step = |k| IntegratorSettings { join: Join::KStep, k, ..full };
        assert_eq!(places(path, 0.0), MOST_PLACES);
        assert_eq!(places(full, 2.5), 4);
        assert_eq!(places(full, 100.0), LEAST_PLACES);
        assert!(places(k_step(1), 2.5) > places(k_step(3), 2.5));
        assert_eq!(places(k_step(u32::MAX / 8), 2.5), LEAST_PLACES);
    }

    /// The mean, six of the pilot's errors, 1 / 128 each, and eight of the batch's.
    #[test]
    fn small_batches_and_sparse_vertices_have_more_room_for_a_path() {
        let for_a_path =
            |n: u32, mean: f32| f64::from(vertex_room(n, mean) - VERTEX_ROOM_LEAST) / f64::from(n);
        assert!((for_a_path(1024, 2.0) - 2.0 * (1.0 + 6.0 / 128.0 + 0.25)).abs() < 0.01);
        assert!((for_a_path(1 << 22, 2.0) - 2.0 * (1.0 + 6.0 / 128.0)).abs() < 0.01);
        assert!((for_a_path(1 << 24, 0.01) - (0.01 + 0.1 * 6.0 / 128.0)).abs() < 0.001);
    }
}
