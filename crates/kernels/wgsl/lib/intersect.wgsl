// Ray against triangle.

struct Hit {
    /// Distance in units of the direction's length.
    t: f32,
    /// Barycentrics of the second and third vertex.
    u: f32,
    v: f32,
    triangle: u32,
}

/// Möller and Trumbore 1997. t < 0 for a miss.
fn intersect_triangle(v0: vec3<f32>, e1: vec3<f32>, e2: vec3<f32>, origin: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let p = cross(direction, e2);
    let determinant = dot(e1, p);
    let miss = vec3<f32>(-1.0, 0.0, 0.0);
    if (determinant == 0.0) {
        return miss;
    }
    let inverse = 1.0 / determinant;
    let s = origin - v0;
    let u = dot(s, p) * inverse;
    let q = cross(s, e1);
    let v = dot(direction, q) * inverse;
    let outside = u < 0.0 || v < 0.0 || u + v > 1.0;
    return select(vec3<f32>(dot(e2, q) * inverse, u, v), miss, outside);
}
