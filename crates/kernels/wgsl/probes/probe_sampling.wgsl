// Probe: lib/sampling.wgsl, lib/light.wgsl, what lights emit. In: numbers in [0, 1) and a normal's direction.

#include "bindings/probe.wgsl"

@compute @workgroup_size(64)
fn probe_sampling(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let u = fract(abs(probe_input(id.x, 0u)));
    let n = probe_unit(probe_input(id.x, 1u).xyz);
    let emitted = sample_emission(n, u.w < 0.5, u.xyz);
    probe_output(id.x, 0u, vec4<f32>(sample_cosine_hemisphere(u.xy), sample_disk(u.zw).x));
    probe_output(id.x, 1u, vec4<f32>(sample_triangle(u.xy), sample_triangle(u.zw)));
    probe_output(id.x, 2u, vec4<f32>(emitted, emission_pdf_sa(dot(n, emitted), u.w < 0.5)));
    let raw = RawMaterial(SURFACE_DIFFUSE, id.x % 2u, vec3<f32>(0.5), u.xyz, 1.0, vec3<f32>(0.0), 0.0, vec2<f32>(0.0), 0.0, 0.0,
        vec4<f32>(0.0), vec3<f32>(0.0), vec2<f32>(1.0, 0.0));
    let light = finish_material(raw, no_albedos());
    probe_output(id.x, 3u, vec4<f32>(emitted_radiance(light, n.z), f32(alias_pick(3u, u.x, u.y, 5u))));
}
