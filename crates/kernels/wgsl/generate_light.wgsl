// Starts the light subpaths of a batch: a light by power, a point on it (at infinity: a direction), a
// direction (at infinity: a point on the disk that covers the scene).
// One invocation: one path. Writes: paths, queues, light_vertices (y_0, where it can be an end),
// light_paths. Leaves: surviving paths in the queue's write half (plan_queue turns it round), their
// MIS state as after y_0 (lib/mis.wgsl).

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/environment.wgsl"
#include "bindings/lights.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/light_vertices.wgsl"
#include "bindings/light_store.wgsl"

@compute @workgroup_size(64)
fn generate_light(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let id = invocation_index(invocation);
    if (id >= params.n_paths) {
        return;
    }
    begin_light_path(id);
    if (params.n_lights == 0u) {
        return;
    }
    let index = light_path_index(id);
    let sample = light_path_sample(id);
    let u_point = random(index, sample, dimension(DRAW_LIGHT + DRAW_EMIT_POINT, 0u));
    let u_direction = random(index, sample, dimension(DRAW_LIGHT + DRAW_EMIT_DIRECTION, 0u));
    let light_index = pick_light(u_point.x);
    let light = load_light(light_index);
    let point = draw_light_point(light, u_point.yz, index, sample, dimension(DRAW_LIGHT + DRAW_ENVIRONMENT, 0u));
    if (point.pdf <= 0.0) {
        return;
    }
    let vertex = LightVertex(point.position, light_triangle(light), point.emission / point.pdf, 0.0,
        point.normal, 0.0, point.uv.x, point.uv.y, light_index, 1u);
    if (has_flag(FLAG_SPLAT_EMITTERS) && light.kind == LIGHT_TRIANGLE) {
        append_light_vertex(vertex);
    }
    let ends_here = u_direction.w >= params.emitter_survival;
    if (ends_here) {
        end_light_path(id, vertex);
        return;
    }
    let emitted = emit(light, point, u_direction.xyz);
    let pdf_direction = emitted.pdf * params.emitter_survival;
    if (pdf_direction <= 0.0) {
        return;
    }
    let throughput = point.emission * (emitted.factor / (point.pdf * pdf_direction));
    if (!any(throughput > vec3<f32>(0.0))) {
        return; // the edge of a spot: its vertices would be chosen by an importance of 0
    }
    let config = mis_config();
    let ending = ending_chance(config, params.emitter_survival);
    let state = mis_begin_light(config, point.pdf, point.pdf, pdf_direction, emitted.cos_light, ending);
    store_path(id, Path(emitted.origin, index, emitted.direction, 0u, 0u, is_infinite(light), throughput, sample, state,
        light.medium));
    push_path(id);
}
