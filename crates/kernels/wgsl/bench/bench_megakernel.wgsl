// Bidirectional path tracing (join full, a light path for each sample) in its plainest form, which the
// integrator's kernels are measured against: one kernel that does all of a sample (Otte 2014, section
// 3.1 and algorithm 2; a "megakernel" in Laine, Karras and Aila 2013). The same steps, by the same random
// numbers: the same image.
// One invocation: one place of the pass. It traces a light path, its vertices kept in memory of its own,
// projects them onto the film, and traces a camera path, each vertex of which is joined to all of them;
// what is joined is tested for visibility at once. Reads: scene, nodes, triangles, texels. Writes:
// light_vertices, light_paths, film, counters. Slots of light_vertices before append_at belong to one
// invocation each; vertices beyond these are appended, and where the count of appended ones comes to more
// than append_capacity, some were lost, and the host refuses the result.

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/geometry.wgsl"
#include "bindings/opacity.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/environment.wgsl"
#include "bindings/lights.wgsl"
#include "bindings/light_tree.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/dispatch_args.wgsl"
#include "bindings/film.wgsl"
#include "bindings/visibility.wgsl"
#include "bindings/vertex.wgsl"
#include "bindings/start_light.wgsl"
#include "bindings/light_step.wgsl"
#include "bindings/stored_vertex.wgsl"
#include "bindings/splat.wgsl"
#include "bindings/join.wgsl"
#include "bindings/light_join.wgsl"
#include "bindings/start_camera.wgsl"
#include "bindings/camera_step.wgsl"

/// Bounces of a path at most, as far as `Path.depth` counts them: roulette ends it long before.
const MOST_BOUNCES: u32 = DEPTH_MASK;

@compute @workgroup_size(64)
fn bench_megakernel(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let place = invocation_index(invocation);
    if (place >= params.n_places) {
        return;
    }
    trace_light_path(place);
    for (var slot = path_second_word(place); slot != NONE; ) { // a list, as long as the path
        let stored = load_light_vertex(slot);
        splat_light_vertex(stored);
        slot = stored.link;
    }
    trace_camera_path(place);
}

fn trace_light_path(place: u32) {
    let start = light_path(place);
    if (!start.is_traced) {
        return;
    }
    var path = start.path;
    for (var i = 0u; i < MOST_BOUNCES && contributes(path.throughput); i += 1u) {
        path = step_light(path, trace(path));
    }
}

fn trace_camera_path(place: u32) {
    var path = camera_path(place);
    for (var i = 0u; i < MOST_BOUNCES && contributes(path.throughput); i += 1u) {
        let hit = trace(path);
        if (hit.triangle == NONE) {
            escape(path);
            return;
        }
        let vertex = arrive(path, hit, 0u);
        if (is_connectible(vertex.material)) {
            join_light_path(place, path, vertex);
        }
        path = step_camera(path, vertex);
    }
}

/// Strategies (s, t), s >= 2, of one camera vertex.
fn join_light_path(place: u32, path: Path, vertex: Vertex) {
    for (var slot = path_second_word(place); slot != NONE; ) { // a list, as long as the light path
        let stored = load_light_vertex(slot);
        if (length_allowed(stored.s, path.depth + 2u)) {
            push_join(path, stored.s, evaluate_join(path, vertex, stored), 1.0);
        }
        slot = stored.link;
    }
}

fn trace(path: Path) -> Hit {
    count_one_ray();
    return closest_hit(path.origin, path.direction, F32_MAX);
}

/// What strategies hand a contribution to: here it does not wait for its visibility.
fn push_shadow_ray(pixel: u32, group: u32, start: vec3<f32>, end: vec3<f32>, contribution: vec3<f32>) {
    count_one_ray();
    if (is_free(start, end - start)) {
        film_add(pixel, group, contribution);
    }
}

/// Where that is asked for: one count for all invocations is slow.
fn count_one_ray() {
    if (has_flag(FLAG_COUNT_RAYS)) {
        count_rays(1u);
    }
}

/// Stores a linked vertex of a light path, in the path's own memory (that of neighbours is interleaved, so
/// that they are written together) or behind it; its slot, or NONE where it did not fit.
fn place_linked_vertex(light_path: u32, vertex: LightVertex) -> u32 {
    let n = path_vertex_count(light_path);
    if (n >= params.append_at / params.n_places) { // n_places > 0: this is one of them
        return append_light_vertex(vertex);
    }
    let slot = n * params.n_places + light_path;
    store_light_vertex(slot, vertex);
    return slot;
}
