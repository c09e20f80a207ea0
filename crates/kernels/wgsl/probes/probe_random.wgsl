// Probe: lib/rng.wgsl, lib/sobol.wgsl. Bits, so both devices must agree exactly.
// In: nothing but the invocation's index.

#include "bindings/probe.wgsl"

@compute @workgroup_size(64)
fn probe_random(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let bits = draw_bits(id.x, id.x / 7u, dimension(DRAW_NEE, id.x % 5u), 12345u);
    probe_output(id.x, 0u, unit_float(bits));
    probe_output(id.x, 1u, vec4<f32>(vec4<u32>(uniform_index(unit_float(bits).x, 1000u), uniform_index(0.9999999, 7u),
        table_index(id.x, 3u, bits.x, 9u, 4096u), bits.y >> 16u)));
    let place = uniform_index_bits(bits.z, 3000000000u);
    probe_output(id.x, 2u, vec4<f32>(vec4<u32>(place >> 16u, place & 0xffffu, uniform_index_bits(bits.w, 7u), 0u)));
    let sobol = sobol_bits(id.x % 7u, id.x / 7u, dimension(DRAW_NEE, id.x % 5u), 12345u);
    probe_output(id.x, 3u, unit_float(sobol));
}
