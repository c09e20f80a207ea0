// Joins each camera vertex to vertices of light subpaths, by the join in use (s >= 2; in
// single-step without next-event estimation s >= 1).
// One invocation: one queued path. Reads: scene, paths, light_vertices, light_paths. Writes:
// shadow_rays; in the path, how many joins are made where more than CONNECTIONS_PER_BOUNCE are to
// be, so that it waits for the rest (trace_closest and shade_camera leave it alone meanwhile).

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/environment.wgsl"
#include "bindings/lights.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/shadow_rays.wgsl"
#include "bindings/light_vertices.wgsl"
#include "bindings/vertex.wgsl"
#include "bindings/stored_vertex.wgsl"
#include "bindings/join_choice.wgsl"
#include "bindings/light_join.wgsl"

@compute @workgroup_size(64)
fn connect(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let place = invocation_index(invocation);
    if (place >= queue_length()) {
        return;
    }
    let id = queued_path(place);
    var path = load_path(id);
    let hit = load_hit(id);
    if (hit.triangle == NONE) {
        return;
    }
    let vertex = arrive(path, hit);
    if (!is_connectible(vertex.material) || !may_join(path, vertex)) {
        return;
    }
    let drawn = draw_light_path(path);
    let n_joins = join_count(drawn);
    let end = min(path.joined + CONNECTIONS_PER_BOUNCE, n_joins);
    for (var j = path.joined; j < end; j += 1u) {
        let choice = choose_light_vertex(path, vertex, drawn, j);
        if (choice.slot != NONE) {
            join(path, vertex, choice);
        }
    }
    let joined = select(0u, end, end < n_joins);
    if (joined != path.joined) {
        path.joined = joined;
        store_path(id, path);
    }
}

/// In single-step only the vertex where roulette ends the path is joined.
fn may_join(path: Path, vertex: Vertex) -> bool {
    return params.join != JOIN_SINGLE_STEP || scatter_numbers(path, 0u).w >= vertex.survival;
}

/// Strategy (s, t): one shadow ray, its contribution times the choice's estimator weight.
fn join(path: Path, vertex: Vertex, choice: Choice) {
    let stored = load_light_vertex(choice.slot);
    let t = path.depth + 2u;
    if (!length_allowed(stored.s, t)) {
        return;
    }
    if (stored.s == 1u) {
        join_emitter(path, vertex, stored, choice.weight);
        return;
    }
    let y = load_join_vertex(stored);
    let joined = evaluate_join(path, vertex, stored, y);
    let weight = strategy_weight(stored.s, t, joined.mis_weight);
    let contribution = joined.contribution * (weight * choice.weight);
    if (contributes(contribution)) {
        push_shadow_ray(path.index, stored.group, offset_origin(vertex.surface.position, normal_towards(vertex.surface, joined.wi)),
            offset_origin(stored.position, normal_towards(y.surface, -joined.wi)), contribution);
    }
}

/// Strategy (1, t) of single-step without next-event estimation: y_0 is where the light path ended.
fn join_emitter(path: Path, vertex: Vertex, stored: LightVertex, estimator: f32) {
    let config = mis_config();
    let light = load_light(stored.link);
    let point = light_point(light, vec2<f32>(stored.u, stored.v), stored.wo);
    let factor = emitter_factor(config, ending_chance(config, params.emitter_survival), vertex.ending);
    join_light(path, vertex, light.group, see_light(light, point, vertex.surface.position), factor, estimator);
}
