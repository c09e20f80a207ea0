// Constants of a pass, fixed before it runs.

#include "lib/all.wgsl"

// Params.join
const JOIN_NONE: u32 = 0u;
const JOIN_FULL: u32 = 1u;
const JOIN_K_STEP: u32 = 2u;
const JOIN_SINGLE_STEP: u32 = 3u;

// Params.flags
const FLAG_POOL: u32 = 1u;
const FLAG_IMPORTANCE: u32 = 2u;
const FLAG_NEE: u32 = 4u;
const FLAG_SPLAT: u32 = 8u;
/// s = 0 counts: the camera subpath may hit a light.
const FLAG_HIT: u32 = 16u;
/// (1, 1) counts as a splat: emitters seen by the light image alone.
const FLAG_SPLAT_EMITTERS: u32 = 32u;
const FLAG_POWER_HEURISTIC: u32 = 64u;
/// Only the strategy (only_s, only_t) counts.
const FLAG_ONE_STRATEGY: u32 = 128u;
/// With weight 1 in place of its MIS weight.
const FLAG_RAW: u32 = 256u;
/// Random numbers are Sobol points.
const FLAG_SOBOL: u32 = 512u;
/// Next-event estimation draws lights by the tree over them, not by power.
const FLAG_LIGHT_TREE: u32 = 1024u;
/// bench_megakernel counts its rays.
const FLAG_COUNT_RAYS: u32 = 2048u;

struct Params {
    camera: Camera,
    /// A sphere around all triangles.
    scene_centre: vec3<f32>,
    scene_radius: f32,
    /// The rendered window, in pixels of the full film.
    crop_x: u32,
    crop_y: u32,
    crop_width: u32,
    n_pixels: u32,
    /// Pixels along x of the full film.
    film_width: u32,
    /// The pixel filter: FILTER_*, and its full width in pixels.
    filter_kind: u32,
    filter_width: f32,
    /// Slots of paths in flight at once, the places that the batch fills them with, n_paths or more,
    /// and the first of these in the pass.
    n_paths: u32,
    n_places: u32,
    first_path: u32,
    first_sample: u32,
    seed: u32,
    flags: u32,
    join: u32,
    k: u32,
    /// Edges at most; NONE for no bound.
    max_path_length: u32,
    /// Contributions are scaled down to this largest component; infinite for no clamp.
    clamp: f32,
    /// Factors of MisConfig.
    join_factor: f32,
    splat_factor: f32,
    /// Survival at y_0.
    emitter_survival: f32,
    /// The throughput that roulette by throughput leaves a camera path with (survival_by_throughput).
    least_throughput: f32,
    /// Light paths that joins draw from.
    n_light_paths: u32,
    /// The medium (material) that the camera is in, or NONE.
    camera_medium: u32,
    only_s: u32,
    only_t: u32,
    /// Places in the buffer `scene`, in vec4.
    lights_at: u32,
    surfaces_at: u32,
    instances_at: u32,
    random_at: u32,
    textures_at: u32,
    /// The table of the sRGB curve.
    srgb_at: u32,
    /// Materials' records of textures.
    slots_at: u32,
    n_lights: u32,
    /// The tree over lights, and the ways to its leaves (bindings/light_tree.wgsl).
    light_tree_at: u32,
    light_ways_at: u32,
    /// Triangles stored as they are in the world: ids below it. NONE where all are.
    n_baked: u32,
    n_instances: u32,
    /// NONE where there is no environment.
    environment_at: u32,
    /// Entries of the table of pre-generated numbers, 0 for none.
    n_random: u32,
    /// Slots of light_vertices before those that are appended to, and how many may be appended.
    append_at: u32,
    append_capacity: u32,
    /// 1 where appended vertices last until the next bounce only.
    append_transient: u32,
    /// Samples of a pixel in the pass that measure_variance looks at.
    pass_samples: u32,
    /// What encode_display multiplies radiance by, and then does: TONE_MAP_*.
    exposure_scale: f32,
    tone_map: u32,
    /// Groups of lights that the film keeps apart, at least 1.
    n_groups: u32,
}

@group(0) @binding(0) var<uniform> params: Params;

/// Invocations along x of a two-dimensional grid, see plan_queue.
const GRID_ROW: u32 = 2097152u;

/// The index of an invocation in its dispatch.
fn invocation_index(id: vec3<u32>) -> u32 {
    return id.y * GRID_ROW + id.x;
}

/// Whether next-event estimation draws lights by the tree over them.
fn uses_light_tree() -> bool {
    return may_have(FEATURE_LIGHT_TREE) && has_flag(FLAG_LIGHT_TREE);
}

/// Whether contributions are told apart by the group of the light that they come from.
fn keeps_groups() -> bool {
    return may_have(FEATURE_LIGHT_GROUPS) && params.n_groups > 1u;
}

fn has_flag(flag: u32) -> bool {
    return (params.flags & flag) != 0u;
}

/// The number in the full film of a pixel of the window. Random numbers are drawn by it, so that a
/// crop shows the samples of the whole.
fn film_pixel(in_window: u32) -> u32 {
    let row = in_window / params.crop_width; // > 0: an empty film is refused
    return (params.crop_y + row) * params.film_width + params.crop_x + in_window % params.crop_width;
}

/// The pixel of the window by its number in the full film; it lies in the window.
fn window_pixel(in_film: u32) -> u32 {
    let row = in_film / params.film_width; // > 0
    return (row - params.crop_y) * params.crop_width + in_film % params.film_width - params.crop_x;
}

fn pixel_filter() -> PixelFilter {
    return PixelFilter(params.filter_kind, params.filter_width);
}

fn mis_config() -> MisConfig {
    return MisConfig(
        select(0u, 1u, has_flag(FLAG_POWER_HEURISTIC)),
        select(0u, 1u, has_flag(FLAG_NEE)),
        select(0u, 1u, params.join == JOIN_SINGLE_STEP),
        params.join_factor,
        params.splat_factor,
    );
}

/// Whether a path of s light and t camera vertices is short enough.
fn length_allowed(s: u32, t: u32) -> bool {
    return s + t - 1u <= params.max_path_length;
}

/// A strategy's MIS weight as it enters the image: developers look at one strategy alone, or raw.
fn strategy_weight(s: u32, t: u32, mis_weight: f32) -> f32 {
    if (has_flag(FLAG_ONE_STRATEGY) && (params.only_s != s || params.only_t != t)) {
        return 0.0;
    }
    return select(mis_weight, 1.0, has_flag(FLAG_RAW));
}

/// Whether a contribution is worth a ray. NaN is: it must reach the film to be counted.
fn contributes(rgb: vec3<f32>) -> bool {
    return !all(rgb == vec3<f32>(0.0));
}
