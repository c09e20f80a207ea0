// Makes the joins that list_joins has listed, by full and k-step.
// One invocation: one join, or a run of them (joins_per_invocation). Reads: scene, paths, light_vertices, light_paths,
// joins. Writes: shadow_rays.

#include "bindings/params.wgsl"
#include "bindings/workgroups.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/shadow_rays.wgsl"
#include "bindings/light_vertices.wgsl"
#include "bindings/vertex.wgsl"
#include "bindings/stored_vertex.wgsl"
#include "bindings/join_choice.wgsl"
#include "bindings/join_list.wgsl"
#include "bindings/join.wgsl"

@compute @workgroup_size(SHADE_WORKGROUP)
fn connect(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let n_joins = atomicLoad(&counters[COUNT_JOINS]);
    let first = invocation_index(invocation) * joins_per_invocation();
    if (first >= n_joins) {
        return;
    }
    var at = first;
    var listed = load_join(at);
    loop {
        let id = listed.path;
        let path = load_path(id);
        let vertex = arrive(path, load_hit(id), 0u);
        // Those of one camera vertex lie side by side.
        loop {
            if (is_connectible(vertex.material)) {
                join(path, vertex, listed.slot_or_number);
            }
            at += 1u;
            if (!may_have(FEATURE_JOIN_RUNS) || at >= min(first + JOIN_RUN, n_joins)) {
                return;
            }
            listed = load_join(at);
            if (listed.path != id) {
                break;
            }
        }
    }
}

/// One join: with a light vertex, or with one of several candidates by its weighted, unshadowed contribution
/// (resampled importance sampling, Talbot 2005).
fn join(path: Path, vertex: Vertex, slot_or_number: u32) {
    let light_path = draw_light_path(path);
    let n_candidates = candidate_count();
    var chosen = no_join();
    var chosen_s = 0u;
    var weight = 1.0;
    var total = 0.0;
    for (var i = 0u; i < n_candidates; i += 1u) {
        var slot = slot_or_number;
        var u = 0.0;
        if (n_candidates > 1u) {
            let bits = candidate_bits(path, slot_or_number, i);
            slot = choose_slot(path, light_path, slot_or_number, bits, NONE);
            u = unit_float(bits).y;
        }
        let stored = load_light_vertex(slot);
        if (!length_allowed(stored.s, path.depth + 2u)) {
            continue;
        }
        let candidate = evaluate_join(path, vertex, stored);
        let target_value = max3(candidate.contribution) * candidate.mis_weight;
        total += target_value;
        if (n_candidates == 1u || u * total < target_value) {
            chosen = candidate;
            chosen_s = stored.s;
            // of several > 0: it was chosen by it
            weight = choice_weight(light_path, stored) / select(1.0, f32(n_candidates) * target_value, n_candidates > 1u);
        }
    }
    push_join(path, chosen_s, chosen, weight * select(1.0, total, n_candidates > 1u));
}
