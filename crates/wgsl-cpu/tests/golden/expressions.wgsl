fn expressions(a: vec3<f32>, b: vec3<f32>, i: i32, u: u32, c: bool) -> vec4<f32> {
    let m = mat3x3<f32>(a, b, a.zyx);
    let scaled = 2.0 * (m * b) - a / (b + 1.0);
    let ints = vec2<i32>(i, i / 3) << vec2(u);
    let x = f32(i % -1) + f32(u / 7u) + bitcast<f32>(u) + f32(-i) + f32(c);
    let y = select(a.x, b.y, c || i < 3 && u > 2u);
    let any_less = any(a < b);
    let k = vec3<i32>(a)[u] + ints.y;
    let unused = a * b;
    return vec4(scaled.xy, mix(x, y, 0.25) + min(a, b).z, f32(k) + select(a, b, a >= b).x + f32(any_less));
}
