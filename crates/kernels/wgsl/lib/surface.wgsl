// Points on triangles: packed normals, the shading normal, the tangent frame.

/// In place of a packed normal: the triangle is flat. No vector is packed so.
const FLAT_NORMAL: u32 = 0x80008000u;

/// A unit vector from its octahedral map in 2 x 16 bits (Cigolle et al. 2014, "A Survey of Efficient
/// Representations for Independent Unit Vectors", oct32): off by less than 1e-4 radians, a tenth of
/// the angle of a pixel in an image 1000 pixels wide. The coordinate axes are exact.
fn oct_decode(packed: u32) -> vec3<f32> {
    let e = unpack2x16snorm(packed);
    let z = 1.0 - abs(e.x) - abs(e.y);
    let fold = max(-z, 0.0);
    let x = e.x + select(fold, -fold, e.x >= 0.0);
    let y = e.y + select(fold, -fold, e.y >= 0.0);
    return normalize(vec3<f32>(x, y, z)); // not zero: the absolute values add up to 1
}

/// The octahedral map of a unit vector.
fn oct_encode(v: vec3<f32>) -> u32 {
    let e = v.xy / (abs(v.x) + abs(v.y) + abs(v.z)); // > 0: the vector is unit
    let fold = (1.0 - abs(e.yx)) * vec2<f32>(select(-1.0, 1.0, e.x >= 0.0), select(-1.0, 1.0, e.y >= 0.0));
    return pack2x16snorm(select(fold, e, v.z >= 0.0));
}

/// The unit shading normal in ng's hemisphere from interpolated normals; ng where they cancel.
fn shading_normal(ng: vec3<f32>, blend: vec3<f32>) -> vec3<f32> {
    let size2 = dot(blend, blend);
    let unit = blend * inverseSqrt(max(size2, 1e-30));
    let facing = select(-unit, unit, dot(unit, ng) >= 0.0);
    return select(ng, facing, size2 > 1e-12);
}

/// The unit vector orthogonal to the unit vector n that lies nearest to t; any where t has no
/// direction across n.
fn tangent_along(n: vec3<f32>, t: vec3<f32>) -> vec3<f32> {
    let across = t - n * dot(n, t);
    let size2 = dot(across, across);
    if (size2 > 1e-10 * dot(t, t)) {
        return across * inverseSqrt(size2);
    }
    let frame = frame_from_normal(n);
    return frame[0];
}

/// Along growing u: xyz, not unit, zero where the texture coordinates have no area. w: the sign of
/// the bitangent sign · cross(n, tangent) for it to point up in the image, against growing v, seen
/// from the front. e1, e2 and uv1, uv2 lead from the first vertex to the others; `front` is -1 where
/// cross(e1, e2) points to the back.
fn uv_tangent(e1: vec3<f32>, e2: vec3<f32>, uv1: vec2<f32>, uv2: vec2<f32>, front: f32) -> vec4<f32> {
    let determinant = uv1.x * uv2.y - uv2.x * uv1.y;
    let along_u = e1 * uv2.y - e2 * uv1.y;
    return vec4<f32>(along_u * sign(determinant), select(1.0, -1.0, determinant * front > 0.0));
}

/// A unit normal of a mesh in the world: by the cofactors of the rows of world_from_mesh, the inverse
/// transpose but for a factor, whose sign is `front`. The rows are scaled so that nothing underflows.
fn place_normal(x: vec3<f32>, y: vec3<f32>, z: vec3<f32>, front: f32, n: vec3<f32>) -> vec3<f32> {
    return normalize(front * vec3<f32>(dot(cross(y, z), n), dot(cross(z, x), n), dot(cross(x, y), n)));
}
