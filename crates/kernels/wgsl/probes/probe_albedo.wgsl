// Probe: how lib/albedo.wgsl and lib/material.wgsl look curves up, and lib/light.wgsl's sides. In: any
// numbers.

#include "bindings/probe.wgsl"

@compute @workgroup_size(64)
fn probe_albedo(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let a = probe_input(id.x, 0u);
    let b = probe_input(id.x, 1u);
    let u = fract(abs(probe_input(id.x, 2u)));
    let blend = blend_curves(Curve(a, b), Curve(b, a), u.x);
    probe_output(id.x, 0u, blend.low + blend.high * u.y);
    probe_output(id.x, 1u, vec4<f32>(alpha_place(a.x), index_place(0.25 + abs(a.y)), stretched_place(u.zw + 0.1)));
    let raw = RawMaterial(id.x % 6u, id.x % 64u, a.xyz, b.xyz, 1.5, u.xyz, u.w, u.xy, u.z, u.w, u, a.xyz, u.xy);
    let needs = vec2<f32>(f32(needs_albedos(raw)), f32(needs_dielectric_losses(raw)));
    let schlick = schlick_albedo(u.x, Curve(a, b), Curve(b, a));
    var layers = no_albedos();
    layers.coat = Curve(0.2 * u, vec4<f32>(0.0));
    layers.sheen = Curve(0.2 * u.wzyx, vec4<f32>(0.0));
    let held = held_at_nodes(raw, layers) + vec4<f32>(held_place(u.zw + 0.1), 0.0, 0.0);
    probe_output(id.x, 3u, schlick.low + schlick.high * u.y + held);
    let w = normalize(vec3<f32>(a.xy, 0.1 + abs(a.z)));
    let two = u.zw + 0.1;
    let stretched = stretched_cosine(u.zw, w) + stretched_blend(u.zw, w, 0.1 + u.x);
    let solid = dot(solid_place(two, 0.25 + abs(a.y)), vec3<f32>(1.0, 0.1, 0.01))
        + dot(solid_azimuth(two, w, 0.25 + abs(a.y), u.y > 0.5), vec2<f32>(1.0, 0.5));
    let sides = f32(emits_towards(b.x, true)) + 2.0 * f32(emits_towards(b.x, false));
    probe_output(id.x, 2u, vec4<f32>(needs.x + 2.0 * needs.y, sides, stretched, solid));
}
