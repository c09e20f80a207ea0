// Probe: lib/bsdf*.wgsl, each kind of surface in turn, smooth and rough, solid and thin. In: numbers
// in [0, 1), directions of the normals and of wo, a colour.

#include "bindings/probe.wgsl"

/// Curves of about the size of those in the tables.
fn probe_albedos() -> Albedos {
    let loss = Curve(vec4<f32>(0.4, -0.5, 0.2, 0.0), vec4<f32>(0.0));
    let grazing = Curve(vec4<f32>(0.3, -0.2, 0.0, 0.0), vec4<f32>(0.0));
    return Albedos(loss, grazing, loss, loss, grazing, vec4<f32>(0.1, 0.5, 0.2, 0.6), loss, grazing, loss, vec4<f32>(0.1, -0.2, 0.3, 0.1),
        HeldBack(vec4<f32>(0.05, 0.1, -0.1, 0.02), vec4<f32>(0.02, -0.05, 0.03, 0.01), vec4<f32>(0.01, 0.03, -0.02, 0.01)));
}

fn probe_material(index: u32, u: vec4<f32>, colour: vec4<f32>) -> Material {
    let kind = index % 6u;
    let is_rough = (index / 6u) % 2u == 1u;
    let roughness = select(vec2<f32>(0.0), 0.2 + 0.6 * u.yw, is_rough);
    // Stretched, what is smooth across would be rough along: a lobe as sharp as rounding.
    let anisotropy = select(0.0, 0.3, is_rough);
    let flags = MATERIAL_COMPLEX * ((index / 12u) % 2u) + MATERIAL_INSIDE * ((index / 24u) % 2u)
        + MATERIAL_NONLINEAR * ((index / 12u) % 2u) + MATERIAL_SQUARED * ((index / 48u) % 2u)
        + MATERIAL_COAT_NORMAL * ((index / 96u) % 2u);
    let raw = RawMaterial(kind, flags, colour.xyz, vec3<f32>(1.0), 1.1 + colour.w, colour.zyx, 0.8, roughness, 0.4, 0.5,
        vec4<f32>(0.3, 0.5, 0.2, 0.7), vec3<f32>(0.6, 0.4, anisotropy), vec2<f32>(0.8, 0.6));
    return finish_material(raw, probe_albedos());
}

@compute @workgroup_size(64)
fn probe_bsdf(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let u = fract(abs(probe_input(id.x, 0u)));
    let ng = probe_unit(probe_input(id.x, 1u).xyz);
    let tilted = normalize(ng + 0.2 * sin_quarter(0.5) * probe_input(id.x, 2u).xyz / (1.0 + length(probe_input(id.x, 2u).xyz)));
    let wo = probe_unit(probe_input(id.x, 2u).xyz);
    let frame = Frame(ng, tilted, frame_from_normal(tilted)[1], 1.0, normalize(ng + tilted));
    let material = probe_material(id.x, u, fract(abs(probe_input(id.x, 3u))));
    let mode = (id.x / 7u) % 2u;
    let sampled = bsdf_sample(material, frame, wo, u.xyz, mode);
    probe_output(id.x, 0u, vec4<f32>(sampled.wi, sampled.pdf));
    probe_output(id.x, 1u, vec4<f32>(sampled.weight, f32(sampled.is_delta) + 2.0 * f32(sampled.transmitted)));
    let terms = bsdf_terms(material, frame, wo, sampled.wi, mode);
    probe_output(id.x, 2u, vec4<f32>(terms.f, terms.pdf_fwd));
    probe_output(id.x, 3u, vec4<f32>(survival_by_throughput(material, u.x, 0.4, id.x % 16u), adjoint_cosines(frame, wo, sampled.wi, mode), terms.pdf_rev,
        fresnel_dielectric(u.w, material.ior).x));
}
