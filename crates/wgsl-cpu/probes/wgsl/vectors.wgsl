// Vectors and matrices. One invocation is one pair of vectors.

@group(0) @binding(0) var<storage, read> inputs: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> outputs: array<vec4<f32>>;

const STRIDE = 16u;

@compute @workgroup_size(64)
fn vectors(@builtin(global_invocation_id) id: vec3<u32>) {
    if 2u * id.x + 1u >= arrayLength(&inputs) { return; }
    let a = inputs[2u * id.x];
    let b = inputs[2u * id.x + 1u];
    let m = mat3x4<f32>(a, b, a.wzyx);
    let square = mat3x3<f32>(a.xyz, b.xyz, a.zxy);
    var c = a;
    c.y = 7.0;
    c[id.x % 4u] += 1.0;
    c = c * 2.0 + b;
    let to = STRIDE * id.x;
    let zero = id.x / 1000000u;
    outputs[to] = vec4(a.xy, b.zw) - 2.0 * a;
    outputs[to + 1u] = c;
    outputs[to + 2u] = m * a.xyz;
    outputs[to + 3u] = vec4(b * m, determinant(square));
    outputs[to + 4u] = transpose(m) [id.x % 4u].xyzz;
    outputs[to + 5u] = vec4(square * square * a.xyz, dot(a, b));
    outputs[to + 6u] = vec4(cross(a.xyz, b.xyz), length(a));
    outputs[to + 7u] = vec4(normalize(a.xyz), distance(a, b));
    outputs[to + 8u] = vec4(reflect(a.xyz, b.xyz), f32(all(a < b)));
    outputs[to + 9u] = vec4(refract(normalize(a.xyz), normalize(b.xyz), 0.7), f32(any(a < b)));
    outputs[to + 10u] = select(a, b, a < b) + faceForward(a, b, a);
    outputs[to + 11u] = vec4<f32>(vec4<i32>(a * 10.0) / vec4<i32>(3, i32(zero), -7, 2));
    outputs[to + 12u] = bitcast<vec4<f32>>(bitcast<vec4<u32>>(a) & vec4(0xffff0000u));
    outputs[to + 13u] = mix(a, b, 0.25) + mix(a, b, vec4(0.0, 0.25, 0.5, 1.0));
    outputs[to + 14u] = vec4<f32>((vec4<u32>(abs(a) * 100.0) << vec4(1u, 2u, 3u, 4u)) % vec4(7u, zero, 11u, 13u));
    outputs[to + 15u] = (m + m * 0.5)[1] + a[id.x % 4u];
    outputs[to + 15u].w = -a[3];
    outputs[to + 15u][id.x % 3u] = 42.0;
}
