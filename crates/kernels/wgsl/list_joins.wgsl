// Lists which light vertices each camera vertex is joined to (s >= 2), by full and k-step. On a GPU those
// are left out that the sides of either surface, or the path's length, rule out: invocations of connect wait
// for each other. On a CPU connect finds it out for itself, at no more cost.
// One invocation: one queued path. Reads: scene, paths, queues, light_vertices, light_paths. Writes: joins; in
// the path, how many are listed where there are more than connections_per_bounce(), so that it waits for the
// rest (trace_closest and shade_camera leave it alone meanwhile).

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/shadow_rays.wgsl"
#include "bindings/light_vertices.wgsl"
#include "bindings/stored_vertex.wgsl"
#include "bindings/join_choice.wgsl"
#include "bindings/join_list.wgsl"

@compute @workgroup_size(64)
fn list_joins(@builtin(global_invocation_id) invocation: vec3<u32>) {
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
    let surface = load_surface(hit.triangle, hit.u, hit.v);
    if ((material_flags(surface.material) & MATERIAL_DELTA) != 0u) {
        return;
    }
    let end = min(path.joined + connections_per_bounce(), n_joins);
    var found: array<u32, CONNECTIONS_OF_RUNS>;
    var n_found = 0u;
    var linked = NONE;
    if (params.join == JOIN_FULL) {
        linked = nth_from_end(light_path, path.joined);
    }
    for (var j = path.joined; j < end; j += 1u) {
        if (candidate_count() > 1u) {
            found[n_found] = j;
            n_found += 1u;
            continue;
        }
        let slot = choose_slot(path, light_path, j, candidate_bits(path, j, 0u), linked);
        if (slot == NONE) {
            break;
        }
        if (params.join == JOIN_FULL) {
            linked = load_light_vertex(slot).link;
        }
        if (may_have(FEATURE_JOIN_RUNS) || may_join(path, surface, load_light_vertex(slot))) {
            found[n_found] = slot;
            n_found += 1u;
        }
    }
    // A GPU puts the atomics of invocations side by side together where all add the same: by powers of two.
    var listed = 0u;
    for (var size = connections_per_bounce(); size > 0u; size /= 2u) {
        if ((n_found & size) != 0u) {
            let at = atomicAdd(&counters[COUNT_JOINS], size);
            for (var i = 0u; i < size; i += 1u) {
                store_join(at + i, ListedJoin(id, found[listed + i]));
            }
            listed += size;
        }
    }
    let joined = select(0u, end, end < n_joins);
    if (joined != 0u) {
        atomicAdd(&counters[COUNT_WAITING], 1u);
    }
    if (joined != path.joined) {
        path.joined = joined;
        store_path(id, path);
    }
}

/// Whether a path through both vertices is short enough, and neither surface rules it out by its sides.
fn may_join(path: Path, surface: Surface, stored: LightVertex) -> bool {
    let between = stored.position - surface.position;
    let wi = between / sqrt(max(dot(between, between), 1e-38));
    return length_allowed(stored.s, path.depth + 2u)
        && may_scatter(surface, -path.direction, wi)
        && may_scatter(load_stored_surface(stored), stored.wo, -wi);
}
