// What probes read and write: four vec4 of numbers in, four out, for each invocation.

#include "lib/all.wgsl"

const PROBE_STRIDE: u32 = 4u;

@group(0) @binding(13) var<storage, read> probe_in: array<vec4<f32>>;
@group(0) @binding(14) var<storage, read_write> probe_out: array<vec4<f32>>;

fn probe_count() -> u32 {
    return arrayLength(&probe_out) / PROBE_STRIDE;
}

fn probe_input(index: u32, field: u32) -> vec4<f32> {
    return probe_in[index * PROBE_STRIDE + field];
}

fn probe_output(index: u32, field: u32, value: vec4<f32>) {
    probe_out[index * PROBE_STRIDE + field] = value;
}

/// A unit vector from any numbers.
fn probe_unit(v: vec3<f32>) -> vec3<f32> {
    return normalize(v + vec3<f32>(0.0, 0.0, 1e-3));
}
