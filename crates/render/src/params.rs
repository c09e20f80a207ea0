//! The kernels' `Params` from what was asked.

use glam::Vec3;
use midway_kernels::{constants as k, layout};
use midway_scene::{Camera, Projection};

use crate::{FilterKind, Integrator, Join, JoinChoice, Mis, PackedScene, RenderSettings, Rng};

/// Survival at y_0 in single-step without next-event estimation, where y_0 may be an end.
const EMITTER_SURVIVAL: f32 = 0.75;

/// What roulette leaves the throughput of a camera path with, at least: the least error at equal time on
/// the scenes of this repository and Sponza (bench/NOTES.md). Where paths are joined, the long ones have
/// less to bring.
const LEAST_THROUGHPUT: f32 = 0.2;
const LEAST_THROUGHPUT_JOINED: f32 = 0.4;

/// The constants of a whole render; batches fill in their own.
pub fn base_params(
    settings: &RenderSettings,
    camera: &Camera,
    packed: &PackedScene,
    n_light_paths: u32,
) -> layout::Params {
    let window = settings.window();
    let integrator = &settings.integrator;
    let single_step_alone = integrator.joins() == Some(Join::SingleStep) && !integrator.uses_nee();
    layout::Params {
        camera: pack_camera(settings, camera),
        crop_x: window.x,
        crop_y: window.y,
        crop_width: window.width,
        n_pixels: window.width * window.height,
        film_width: settings.width,
        filter_kind: match settings.filter.kind {
            FilterKind::Box => k::FILTER_BOX,
            FilterKind::BlackmanHarris => k::FILTER_BLACKMAN_HARRIS,
        },
        filter_width: settings.filter.width,
        seed: mixed_seed(settings.seed),
        flags: flags(settings) | if samples_by_tree(settings, packed) { k::FLAG_LIGHT_TREE } else { 0 },
        join: match integrator.joins() {
            None => k::JOIN_NONE,
            Some(Join::Full) => k::JOIN_FULL,
            Some(Join::KStep) => k::JOIN_K_STEP,
            Some(Join::SingleStep) => k::JOIN_SINGLE_STEP,
        },
        k: integrator.k,
        max_path_length: settings.max_path_length.unwrap_or(k::NONE),
        clamp: settings.clamp.unwrap_or(f32::INFINITY),
        splat_factor: if integrator.uses_splat() { n_light_paths as f32 } else { 0.0 },
        emitter_survival: if single_step_alone { EMITTER_SURVIVAL } else { 1.0 },
        least_throughput: if integrator.joins().is_some() {
            LEAST_THROUGHPUT_JOINED
        } else {
            LEAST_THROUGHPUT
        },
        n_light_paths,
        camera_medium: packed.camera_medium,
        only_s: settings.one_strategy.map_or(0, |one| one.s),
        only_t: settings.one_strategy.map_or(0, |one| one.t),
        scene_centre: packed.sphere.centre.to_array(),
        scene_radius: packed.sphere.radius,
        lights_at: packed.lights_at,
        light_tree_at: packed.light_tree_at,
        light_ways_at: packed.light_ways_at,
        environment_at: packed.environment_at,
        surfaces_at: packed.surfaces_at,
        instances_at: packed.instances_at,
        random_at: packed.random_at,
        textures_at: packed.textures_at,
        srgb_at: packed.srgb_at,
        slots_at: packed.slots_at,
        n_lights: packed.n_lights,
        n_baked: packed.n_baked,
        n_instances: packed.n_instances,
        n_random: packed.n_random,
        ..bytemuck::Zeroable::zeroed()
    }
}

/// Whether next-event estimation is there, and draws lights by the tree.
pub fn samples_by_tree(settings: &RenderSettings, packed: &PackedScene) -> bool {
    settings.integrator.uses_nee() && packed.light_tree_at != k::NONE
}

/// The kernels' seed: mixed, so that seeds that differ in one bit are as far apart as any.
pub fn mixed_seed(seed: u32) -> u32 {
    midway_kernels::native::lib::mix32(seed)
}

/// The factor c of strategies with s >= 2 and t >= 2 (design: a constant of the pass). `mean_vertices`:
/// L, the mean number of connectible vertices of a light path.
pub fn join_factor(settings: &RenderSettings, mean_vertices: f32) -> f32 {
    let integrator = &settings.integrator;
    match integrator.joins() {
        None => 0.0,
        Some(Join::Full | Join::SingleStep) => 1.0,
        Some(Join::KStep) => {
            let ratio = integrator.k as f32 / mean_vertices;
            if integrator.uses_pool() { ratio } else { ratio.min(1.0) }
        }
    }
}

fn flags(settings: &RenderSettings) -> u32 {
    let integrator = &settings.integrator;
    let one = settings.one_strategy;
    [
        (integrator.uses_pool(), k::FLAG_POOL),
        (integrator.join_choice == JoinChoice::Importance, k::FLAG_IMPORTANCE),
        (integrator.uses_nee(), k::FLAG_NEE),
        (integrator.uses_splat(), k::FLAG_SPLAT),
        (integrator.uses_camera_paths(), k::FLAG_HIT),
        (integrator.integrator == Integrator::Light, k::FLAG_SPLAT_EMITTERS),
        (integrator.mis == Mis::Power, k::FLAG_POWER_HEURISTIC),
        (one.is_some(), k::FLAG_ONE_STRATEGY),
        (one.is_some_and(|one| one.raw), k::FLAG_RAW),
        (settings.rng == Rng::Sobol, k::FLAG_SOBOL),
    ]
    .into_iter()
    .filter_map(|(set, flag)| set.then_some(flag))
    .fold(0, |all, flag| all | flag)
}

fn pack_camera(settings: &RenderSettings, camera: &Camera) -> layout::Camera {
    let (width, height) = (settings.width as f32, settings.height as f32);
    let axis = |v: Vec3| camera.world_from_camera.transform_vector3(v).normalize();
    let (half_height, parallel) = match camera.projection {
        Projection::Perspective { yfov } => ((yfov * 0.5).tan(), 0),
        Projection::Orthographic { height } => (height * 0.5, 1),
    };
    let half_width = half_height * width / height;
    layout::Camera {
        origin: camera.position().to_array(),
        pixel_area: (2.0 * half_width / width) * (2.0 * half_height / height),
        right: axis(Vec3::X).to_array(),
        half_width,
        up: axis(Vec3::Y).to_array(),
        half_height,
        forward: axis(Vec3::NEG_Z).to_array(),
        width,
        height,
        lens_radius: camera.lens_radius,
        inverse_focus: 1.0 / camera.focus_distance,
        parallel,
    }
}
