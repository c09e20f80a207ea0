// Joins the camera vertex where roulette ends a path to the vertex where it ended the light path
// (single-step; s >= 2, without next-event estimation s >= 1).
// One invocation: one queued path. Reads: scene, paths, light_vertices, light_paths. Writes: shadow_rays.

#include "bindings/params.wgsl"
#include "bindings/workgroups.wgsl"
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
#include "bindings/light_join.wgsl"
#include "bindings/join_choice.wgsl"
#include "bindings/join.wgsl"

@compute @workgroup_size(SHADE_WORKGROUP)
fn connect_ends(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let place = invocation_index(invocation);
    if (place >= queue_length()) {
        return;
    }
    let id = queued_path(place);
    let path = load_path(id);
    let hit = load_hit(id);
    let light_path = draw_light_path(path);
    if (hit.triangle == NONE || path_vertex_count(light_path) == 0u) {
        return;
    }
    let vertex = arrive(path, hit, 0u);
    let ends = scatter_numbers(path, 0u).w >= vertex.survival;
    if (!ends || !is_connectible(vertex.material)) {
        return;
    }
    let stored = load_light_vertex(light_path);
    if (!length_allowed(stored.s, path.depth + 2u)) {
        return;
    }
    if (stored.s == 1u) {
        join_emitter(path, vertex, stored);
        return;
    }
    let joined = evaluate_join(path, vertex, stored);
    push_join(path, stored.s, joined, ends_weight(joined.ending, vertex.ending));
}

/// By the chance that both paths ended here.
fn ends_weight(y_ending: f32, z_ending: f32) -> f32 {
    return 1.0 / (y_ending * z_ending); // > 0: both did end
}

/// Strategy (1, t) without next-event estimation: y_0 is where the light path ended.
fn join_emitter(path: Path, vertex: Vertex, stored: LightVertex) {
    let config = mis_config();
    let light = load_light(stored.link);
    let point = light_point(light, vec2<f32>(stored.u, stored.v), stored.wo);
    let ending = ending_chance(config, params.emitter_survival);
    join_light(path, vertex, light.group, see_light(light, point, vertex.surface.position, 1.0),
        emitter_factor(config, ending, vertex.ending), ends_weight(ending, vertex.ending));
}
