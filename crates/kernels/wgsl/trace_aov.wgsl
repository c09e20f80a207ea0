// Adds what one sample of each pixel hits first to the sums of the auxiliary layers: by the ray that
// the beauty's sample starts with, to the first surface that is there, mirrors and glass included.
// One invocation: one pixel of the window, from first_path on. Reads: scene, nodes, triangles, texels.
// Writes: aov_sums (each invocation its own pixel's), counters.

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/geometry.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/dispatch_args.wgsl"
#include "bindings/camera_sample.wgsl"
#include "bindings/aov_sums.wgsl"

@compute @workgroup_size(64)
fn trace_aov(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let id = invocation_index(invocation);
    if (id >= params.n_paths) {
        return;
    }
    if (id == 0u) {
        count_rays(params.n_paths);
    }
    let pixel = params.first_path + id;
    let ray = camera_sample(film_pixel(pixel), params.first_sample);
    let hit = closest_hit(ray.origin, ray.direction, F32_MAX);
    if (hit.triangle == NONE) {
        return;
    }
    let point = load_raw_point(load_surface(hit.triangle, hit.u, hit.v));
    let surface = point.surface;
    let normal = select(-surface.ns, surface.ns, dot(surface.ng, ray.direction) < 0.0);
    let depth = dot(surface.position - params.camera.origin, params.camera.forward);
    let at = pixel * AOV_STRIDE;
    aov_sums[at] += vec4<f32>(surface_albedo(point.raw), 1.0);
    aov_sums[at + 1u] += vec4<f32>(normal, depth);
    aov_sums[at + 2u] += vec4<f32>(surface.position, 0.0);
}

/// About the share of light that a surface gives back, by colour: the base colour, of a metal its
/// reflectance seen head on; all of it for clear glass, as denoisers expect.
fn surface_albedo(material: RawMaterial) -> vec3<f32> {
    if (material.kind == SURFACE_DIELECTRIC || material.kind == SURFACE_NULL) {
        return vec3<f32>(1.0);
    }
    if (material.kind == SURFACE_CONDUCTOR && (material.flags & MATERIAL_COMPLEX) != 0u) {
        return material.color * fresnel_complex(material.eta_or_sheen.xyz, material.k_or_coat, 1.0);
    }
    return material.color;
}
