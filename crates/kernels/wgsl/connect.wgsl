// Joins each camera vertex to vertices of light subpaths (s >= 2), by full and k-step.
// One invocation: one queued path. Reads: scene, paths, light_vertices, light_paths. Writes:
// shadow_rays; in the path, how many joins are made where more than CONNECTIONS_PER_BOUNCE are to
// be, so that it waits for the rest (trace_closest and shade_camera leave it alone meanwhile).

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/shadow_rays.wgsl"
#include "bindings/light_vertices.wgsl"
#include "bindings/vertex.wgsl"
#include "bindings/stored_vertex.wgsl"
#include "bindings/join_choice.wgsl"
#include "bindings/join.wgsl"

@compute @workgroup_size(64)
fn connect(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let place = invocation_index(invocation);
    if (place >= queue_length()) {
        return;
    }
    let id = queued_path(place);
    var path = load_path(id);
    let hit = load_hit(id);
    let light_path = draw_light_path(path);
    let n_joins = join_count(light_path);
    if (hit.triangle == NONE || n_joins == 0u) {
        return;
    }
    let vertex = arrive(path, hit, 0u);
    if (!is_connectible(vertex.material)) {
        return;
    }
    let end = min(path.joined + CONNECTIONS_PER_BOUNCE, n_joins);
    var linked = select(NONE, nth_from_end(light_path, path.joined), params.join == JOIN_FULL);
    for (var j = path.joined; j < end; j += 1u) {
        linked = join(path, vertex, light_path, j, linked);
    }
    let joined = select(0u, end, end < n_joins);
    if (joined != path.joined) {
        path.joined = joined;
        store_path(id, path);
    }
}

/// The j-th join: one light vertex, or one of several candidates by its weighted, unshadowed contribution
/// (resampled importance sampling, Talbot 2005). The slot linked behind.
fn join(path: Path, vertex: Vertex, light_path: u32, j: u32, linked: u32) -> u32 {
    let n_candidates = candidate_count();
    var chosen = no_join();
    var chosen_s = 0u;
    var weight = 1.0;
    var total = 0.0;
    var next = NONE;
    for (var i = 0u; i < n_candidates; i += 1u) {
        let bits = candidate_bits(path, j, i);
        let slot = choose_slot(path, light_path, j, bits, linked);
        if (slot == NONE) {
            return NONE;
        }
        let stored = load_light_vertex(slot);
        next = stored.link;
        if (!length_allowed(stored.s, path.depth + 2u)) {
            continue;
        }
        let candidate = evaluate_join(path, vertex, stored);
        let target_value = max3(candidate.contribution) * candidate.mis_weight;
        total += target_value;
        if (n_candidates == 1u || unit_float(bits).y * total < target_value) {
            chosen = candidate;
            chosen_s = stored.s;
            // of several > 0: it was chosen by it
            weight = choice_weight(light_path, stored) / select(1.0, f32(n_candidates) * target_value, n_candidates > 1u);
        }
    }
    push_join(path, chosen_s, chosen, weight * select(1.0, total, n_candidates > 1u));
    return next;
}
