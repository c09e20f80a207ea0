// Packing. One invocation is one vector and one word.

@group(0) @binding(0) var<storage, read> inputs: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> outputs: array<array<vec4<u32>, 6>>;

@compute @workgroup_size(64)
fn packing(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&inputs) { return; }
    let v = inputs[id.x];
    let word = bitcast<u32>(v.x);
    outputs[id.x][0] = vec4(pack4x8snorm(v), pack4x8unorm(v), pack2x16snorm(v.xy), pack2x16unorm(v.xy));
    outputs[id.x][1] = vec4(pack2x16float(v.xy), pack2x16float(v.zw * 1e-6), 0u, 0u);
    outputs[id.x][2] = bitcast<vec4<u32>>(unpack4x8snorm(word));
    outputs[id.x][3] = bitcast<vec4<u32>>(unpack4x8unorm(word));
    outputs[id.x][4] = bitcast<vec4<u32>>(vec4(unpack2x16snorm(word), unpack2x16unorm(word)));
    outputs[id.x][5] = vec4(bitcast<vec2<u32>>(unpack2x16float(pack2x16float(v.xy))), 0u, 0u);
}
