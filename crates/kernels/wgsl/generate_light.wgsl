// Starts the light subpaths of a batch: a light by power, a point on it, a direction.
// One invocation: one path. Writes: paths, queues, light_vertices (y_0, where it can be an end),
// light_paths. Leaves: surviving paths in the queue's write half (plan_queue turns it round), their
// MIS state as after y_0 (lib/mis.wgsl).

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/material.wgsl"
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
    let light = load_light(pick_light(u_point.x));
    let uv = sample_triangle(u_point.yz);
    let surface = load_surface(light.triangle, uv.x, uv.y);
    let material = load_material(surface.material);
    let emits_back = (material.flags & MATERIAL_EMITS_BACK) != 0u;
    let pdf_position = light.pmf / light.area; // area > 0: emissive triangles without area are left out

    let vertex = LightVertex(surface.position, light.triangle, material.emission / pdf_position, 0.0,
        surface.ng, 0.0, uv.x, uv.y, bitcast<u32>(1.0), 1u);
    if (has_flag(FLAG_SPLAT_EMITTERS)) {
        append_light_vertex(vertex);
    }
    let ends_here = u_direction.w >= params.emitter_survival;
    if (ends_here) {
        end_light_path(id, vertex);
        return;
    }
    let direction = sample_emission(surface.ng, emits_back, u_direction.xyz);
    let cos_front = dot(surface.ng, direction);
    let pdf_direction = emission_pdf_sa(cos_front, emits_back) * params.emitter_survival;
    if (pdf_direction <= 0.0) {
        return;
    }
    let throughput = material.emission * (abs(cos_front) / (pdf_position * pdf_direction));
    let config = mis_config();
    let ending = ending_chance(config, params.emitter_survival);
    let state = mis_begin_light(config, pdf_position, pdf_position, pdf_direction, abs(cos_front), ending);
    let origin = offset_origin(surface.position, select(-surface.ng, surface.ng, cos_front > 0.0));
    store_path(id, Path(origin, index, direction, 0u, 0u, throughput, sample, state, light.medium, false));
    push_path(id);
}
