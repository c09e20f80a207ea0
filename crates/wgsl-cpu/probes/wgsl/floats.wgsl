// What is exact, or nearly so, on floats. One invocation is one pair.

@group(0) @binding(0) var<storage, read> inputs: array<vec2<f32>>;
@group(0) @binding(1) var<storage, read_write> outputs: array<array<f32, 32>>;

@compute @workgroup_size(64)
fn floats(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&inputs) { return; }
    let a = inputs[id.x].x;
    let b = inputs[id.x].y;
    let whole = modf(a);
    let parts = frexp(a);
    var out: array<f32, 32>;
    out[0] = a + b;
    out[1] = a - b;
    out[2] = a * b;
    out[3] = a % b;
    out[4] = min(a, b);
    out[5] = max(a, b);
    out[6] = clamp(a, -1.5, 2.5);
    out[7] = saturate(a);
    out[8] = floor(a);
    out[9] = ceil(a);
    out[10] = round(a);
    out[11] = trunc(a);
    out[12] = fract(a);
    out[13] = abs(a);
    out[14] = sign(a);
    out[15] = step(a, b);
    out[16] = f32(i32(a));
    out[17] = f32(u32(a));
    out[18] = f32(bool(a));
    out[19] = select(a, b, a < b);
    out[20] = mix(a, b, 0.25);
    out[21] = smoothstep(-2.0, 3.0, a);
    out[22] = whole.fract;
    out[23] = whole.whole;
    out[24] = parts.fract;
    out[25] = f32(parts.exp);
    out[26] = ldexp(a, 3);
    out[27] = quantizeToF16(a);
    out[28] = fma(a, b, 1.0);
    out[29] = -a;
    out[30] = 0x1.8p-3 * a;
    out[31] = bitcast<f32>(bitcast<u32>(a) ^ 0x80000000u);
    outputs[id.x] = out;
}
