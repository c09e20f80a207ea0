// Probe: lib/dispersion.wgsl. In: a throughput with a number in [0, 1), an index and its spread.

#include "bindings/probe.wgsl"

@compute @workgroup_size(64)
fn probe_dispersion(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let a = probe_input(id.x, 0u);
    let b = abs(probe_input(id.x, 1u));
    let throughput = abs(a.xyz) * f32(id.x % 5u); // nothing left of some
    let kept = keep_one_channel(throughput, fract(abs(a.w)));
    let flags = select(0u, MATERIAL_DISPERSES, id.x % 2u == 1u);
    probe_output(id.x, 0u, vec4<f32>(kept, f32(channel_of(kept))));
    probe_output(id.x, 1u, vec4<f32>(f32(channel_of(throughput)), channel_ior(1.0 + b.x, b.y, channel_of(kept)),
        f32(disperses(flags)), 0.0));
}
