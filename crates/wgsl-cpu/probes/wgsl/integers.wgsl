// WGSL's integer semantics on pairs of words. One invocation is one pair.

@group(0) @binding(0) var<storage, read> inputs: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read_write> outputs: array<array<u32, 40>>;

@compute @workgroup_size(64)
fn integers(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&inputs) { return; }
    let a = inputs[id.x].x;
    let b = inputs[id.x].y;
    let c = bitcast<i32>(a);
    let d = bitcast<i32>(b);
    outputs[id.x] = array<u32, 40>(
        a + b, a - b, a * b, a / b, a % b,
        u32(c + d), u32(c - d), u32(c * d), u32(c / d), u32(c % d),
        a << (b & 31u), a >> (b & 31u), u32(c << (b & 31u)), u32(c >> (b & 31u)), u32(-c),
        u32(abs(c)), u32(sign(c)), min(a, b), max(a, b), u32(min(c, d)),
        u32(max(c, d)), countOneBits(a), countLeadingZeros(a), countTrailingZeros(a), firstLeadingBit(a),
        firstTrailingBit(a), u32(firstLeadingBit(c)), reverseBits(a), extractBits(a, b & 31u, 7u),
        u32(extractBits(c, b & 31u, 7u)),
        insertBits(a, b, 5u, 9u), a & b, a | b, a ^ b, ~a,
        clamp(a, 10u, 1000u), select(a, b, c < d), u32(a < b), a / 7u, u32(c / -3),
    );
}
