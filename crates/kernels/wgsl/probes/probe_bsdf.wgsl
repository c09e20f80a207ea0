// Probe: lib/bsdf.wgsl, each kind of surface in turn. In: numbers in [0, 1), directions of the
// normals and of wo, a colour.

#include "bindings/probe.wgsl"

@compute @workgroup_size(64)
fn probe_bsdf(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let u = fract(abs(probe_input(id.x, 0u)));
    let ng = probe_unit(probe_input(id.x, 1u).xyz);
    let tilted = normalize(ng + 0.2 * sin_quarter(0.5) * probe_input(id.x, 2u).xyz / (1.0 + length(probe_input(id.x, 2u).xyz)));
    let wo = probe_unit(probe_input(id.x, 2u).xyz);
    let colour = fract(abs(probe_input(id.x, 3u)));
    let material = Material(colour.xyz, id.x % 3u, vec3<f32>(1.0), 1.1 + colour.w, vec3<f32>(0.0), (id.x / 3u) % 4u);
    let mode = (id.x / 12u) % 2u;
    let sampled = bsdf_sample(material, ng, tilted, wo, u.xyz, mode);
    probe_output(id.x, 0u, vec4<f32>(sampled.wi, sampled.pdf));
    probe_output(id.x, 1u, vec4<f32>(sampled.weight, f32(sampled.is_delta) + 2.0 * f32(sampled.transmitted)));
    probe_output(id.x, 2u, vec4<f32>(bsdf_eval(material, ng, tilted, wo, sampled.wi), bsdf_pdf(material, ng, tilted, wo, sampled.wi)));
    probe_output(id.x, 3u, vec4<f32>(survival(material), adjoint_factor(ng, tilted, wo, sampled.wi), fresnel_dielectric(u.w, material.ior)));
}
