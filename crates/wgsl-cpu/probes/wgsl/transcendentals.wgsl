// Functions that WGSL lets be off by some ulps. One invocation is one number in (0, 1).

@group(0) @binding(0) var<storage, read> inputs: array<f32>;
@group(0) @binding(1) var<storage, read_write> outputs: array<array<f32, 24>>;

@compute @workgroup_size(64)
fn transcendentals(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&inputs) { return; }
    let x = inputs[id.x];
    outputs[id.x] = array<f32, 24>(
        sin(x), cos(x), tan(x), asin(x), acos(x), atan(x), atan2(x, 0.5), sinh(x),
        cosh(x), tanh(x), asinh(x), acosh(1.0 + x), atanh(0.9 * x), exp(x), exp2(x), log(x),
        log2(x), pow(x, 2.5), sqrt(x), inverseSqrt(x), 1.0 / x, radians(x), degrees(x), x / 3.0,
    );
}
