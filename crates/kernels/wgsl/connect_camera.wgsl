// Projects light vertices onto the film (t = 1).
// One invocation: one stored vertex of the range in the counters. Reads: scene, light_vertices.
// Writes: shadow_rays. Each vertex makes one ray at most.

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/shadow_rays.wgsl"
#include "bindings/light_vertices.wgsl"
#include "bindings/stored_vertex.wgsl"

@compute @workgroup_size(64)
fn connect_camera(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let index = atomicLoad(&counters[COUNT_SPLAT_FIRST]) + invocation_index(invocation);
    if (index >= atomicLoad(&counters[COUNT_SPLAT_END])) {
        return;
    }
    let stored = load_light_vertex(params.append_at + index);
    let to_camera = params.camera.origin - stored.position;
    let distance_squared = dot(to_camera, to_camera);
    if (distance_squared == 0.0) {
        return;
    }
    let distance = sqrt(distance_squared);
    let wi = to_camera / distance;
    let film_point = camera_project(params.camera, -wi);
    let pixel = pixel_of(film_point);
    if (pixel == NONE || !length_allowed(stored.s, 1u)) {
        return;
    }
    let vertex = load_join_vertex(stored);
    let pdf_camera = camera_pdf_sa(params.camera, film_point.z) / distance_squared;
    let cosine = light_end_cosine(stored, vertex, wi);
    var weight = 1.0; // `light` has no other strategy: no camera path hits what it sees
    if (stored.s > 1u && has_flag(FLAG_HIT)) {
        let pdf_y = pdf_camera * abs(dot(vertex.surface.ng, wi));
        weight = mis_weight_splat(mis_config(), pdf_y, light_earlier(stored, vertex, wi));
    }
    let medium = medium_before(params.camera_medium, vertex.surface, vertex.material, wi);
    // splat_factor > 0: light paths per sample of every pixel
    let contribution = light_end_scatter(stored, vertex, wi) * medium_transmittance(medium, distance)
        * (cosine * pdf_camera / params.splat_factor * strategy_weight(stored.s, 1u, weight));
    if (contributes(contribution)) {
        push_shadow_ray(pixel, offset_origin(stored.position, normal_of(vertex.surface, wi)), params.camera.origin, contribution);
    }
}

/// The geometric normal on a direction's side.
fn normal_of(surface: Surface, direction: vec3<f32>) -> vec3<f32> {
    return select(-surface.ng, surface.ng, dot(surface.ng, direction) > 0.0);
}

/// The pixel of the window under a film point, or NONE.
fn pixel_of(film_point: vec3<f32>) -> u32 {
    let x = film_point.x - f32(params.crop_x);
    let y = film_point.y - f32(params.crop_y);
    let width = f32(params.crop_width);
    let height = f32(params.n_pixels / params.crop_width); // crop_width > 0: an empty film is refused
    if (film_point.z <= 0.0 || !(x >= 0.0 && y >= 0.0 && x < width && y < height)) {
        return NONE;
    }
    return u32(y) * params.crop_width + u32(x);
}
