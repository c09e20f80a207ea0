// At each vertex of a camera subpath: light found by hitting it (s = 0), light sampled afresh
// (s = 1), roulette, and the next direction.
// One invocation: one queued path. Reads: scene, paths, queues. Writes: paths, queues, shadow_rays,
// film. Leaves: in the queue's write half the paths that go on, and those that `connect` has not
// finished with, unchanged.

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/shadow_rays.wgsl"
#include "bindings/film.wgsl"
#include "bindings/vertex.wgsl"

@compute @workgroup_size(64)
fn shade_camera(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let place = invocation_index(invocation);
    if (place >= queue_length()) {
        return;
    }
    let id = queued_path(place);
    let path = load_path(id);
    if (path.joined != 0u) {
        push_path(id);
        return;
    }
    let hit = load_hit(id);
    if (hit.triangle == NONE) {
        return;
    }
    let vertex = arrive(path, hit);
    let t = path.depth + 2u; // with the lens and this vertex
    if (vertex.surface.light != NONE) {
        add_emission(path, vertex, t);
    }
    if (has_flag(FLAG_NEE) && params.n_lights != 0u && is_connectible(vertex.material) && length_allowed(1u, t)) {
        sample_light(path, vertex, t);
    }
    let u = scatter_numbers(path, 0u);
    if (u.w >= vertex.survival || !length_allowed(0u, t + 1u)) {
        return;
    }
    let factor = camera_previous_factor(mis_config(), t, vertex.mis, vertex.ending);
    let next = scatter(path, vertex, factor, u.xyz, TRANSPORT_RADIANCE);
    if (contributes(next.throughput)) {
        store_path(id, next);
        push_path(id);
    }
}

/// Strategy (0, t): the path hit a light.
fn add_emission(path: Path, vertex: Vertex, t: u32) {
    let cos_front = dot(vertex.surface.ng, vertex.wo);
    let radiance = emitted_radiance(vertex.material, cos_front);
    if (!has_flag(FLAG_HIT) || !contributes(radiance)) {
        return;
    }
    var weight = 1.0; // seen directly: by no other strategy
    if (t > 2u) {
        let config = mis_config();
        let light = load_light(vertex.surface.light);
        let pdf_position = light.pmf / light.area; // area > 0
        let emits_back = (vertex.material.flags & MATERIAL_EMITS_BACK) != 0u;
        let pdf_emission = pdf_position * emission_pdf_sa(cos_front, emits_back) * params.emitter_survival;
        let ending_y = ending_chance(config, params.emitter_survival);
        let factor = emitter_factor(config, ending_y, vertex.mis.ending);
        weight = mis_weight_hit(config, vertex.mis, factor, pdf_position, pdf_emission);
    }
    film_add(path.index, vertex.throughput * radiance * strategy_weight(0u, t, weight));
}

/// Strategy (1, t): a point on a light drawn for this vertex.
fn sample_light(path: Path, vertex: Vertex, t: u32) {
    let u = random(path.index, path.sample, dimension(DRAW_NEE, path.depth));
    let light = load_light(pick_light(u.x));
    let uv = sample_triangle(u.yz);
    let shaded = load_emitter(light.triangle, uv.x, uv.y);
    let on_light = shaded.surface;
    let emitter = shaded.material;
    let between = on_light.position - vertex.surface.position;
    let distance_squared = dot(between, between);
    if (distance_squared == 0.0) {
        return;
    }
    let distance = sqrt(distance_squared);
    let wi = between / distance;
    let cos_light = dot(on_light.ng, -wi);
    let radiance = emitted_radiance(emitter, cos_light);
    let f = bsdf_eval(vertex.material, frame_of(vertex.surface), vertex.wo, wi, TRANSPORT_RADIANCE);
    if (!contributes(radiance * f)) {
        return;
    }
    let config = mis_config();
    let pdf_position = light.pmf / light.area; // area > 0
    let emits_back = (emitter.flags & MATERIAL_EMITS_BACK) != 0u;
    let cos_surface = abs(dot(vertex.surface.ng, wi));
    let pdf_hit = scatter_pdf(vertex, vertex.wo, wi) * abs(cos_light) / distance_squared;
    let pdf_emit = emission_pdf_sa(cos_light, emits_back) * params.emitter_survival * cos_surface / distance_squared;
    let earlier = mis_earlier(config, vertex.mis, camera_previous_factor(config, t, vertex.mis, vertex.ending),
        scatter_pdf(vertex, wi, vertex.wo));
    let weight = mis_weight_emitter(config, 1.0, pdf_hit, pdf_position, pdf_position, pdf_emit, earlier);
    let geometry = abs(dot(vertex.surface.ns, wi)) * abs(cos_light) / distance_squared;
    let leaving = medium_towards(path.medium, vertex.surface, vertex.material, vertex.wo, wi);
    let medium = medium_before(leaving, on_light, emitter, -wi);
    let contribution = vertex.throughput * f * radiance * medium_transmittance(medium, distance)
        * (geometry / pdf_position * strategy_weight(1u, t, weight));
    if (contributes(contribution)) {
        push_shadow_ray(path.index, offset_origin(vertex.surface.position, normal_towards(vertex.surface, wi)),
            offset_origin(on_light.position, normal_towards(on_light, -wi)), contribution);
    }
}
