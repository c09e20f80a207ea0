// Probe: lib/pixel_filter.wgsl. In: numbers.

#include "bindings/probe.wgsl"

@compute @workgroup_size(64)
fn probe_pixel_filter(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let u = fract(abs(probe_input(id.x, 0u)));
    let width = 0.5 + 3.0 * fract(abs(probe_input(id.x, 1u).x));
    let pixel_filter = PixelFilter(id.x & 1u, select(width, 1.0, (id.x & 6u) == 0u));
    let x = 20.0 * u.y;
    let picked = pick_pixel(pixel_filter, x, u.z);
    probe_output(id.x, 0u, vec4<f32>(sample_filter(pixel_filter, u.x), picked.weight, picked.place, x));
    probe_output(id.x, 1u, vec4<f32>(filter_value(pixel_filter, u.w - 0.5), 0.0, 0.0, 0.0));
}
