// Probe: lib/math.wgsl, lib/fixed_point.wgsl.
// In: a point, a normal's direction, a non-positive exponent. One invocation: one set of numbers.

#include "bindings/probe.wgsl"

@compute @workgroup_size(64)
fn probe_math(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let a = probe_input(id.x, 0u);
    let n = probe_unit(probe_input(id.x, 1u).xyz);
    let frame = frame_from_normal(n);
    let fixed = to_fixed(abs(a.x) * 100.0);
    let angle = clamp(a.w, -1.0, 1.0) * PI_OVER_4;
    probe_output(id.x, 0u, vec4<f32>(offset_origin(a.xyz, n), exp_negative(-abs(a.w))));
    probe_output(id.x, 1u, vec4<f32>(frame * vec3<f32>(0.6, 0.0, 0.8), from_fixed(fixed.x, fixed.y)));
    probe_output(id.x, 2u, vec4<f32>(safe_inverse(vec3<f32>(n.xy, 0.0)), luminance(abs(a.xyz))));
    probe_output(id.x, 3u, vec4<f32>(sin_quarter(angle), cos_quarter(angle), f32(is_finite(a.x)), max3(a.xyz)));
}
