// Ray against box and triangle.

struct Hit {
    /// Distance in units of the direction's length.
    t: f32,
    /// Barycentrics of the second and third vertex.
    u: f32,
    v: f32,
    triangle: u32,
}

/// min and max for slabs, which have no NaN (safe_inverse): a single instruction on a CPU, where
/// WGSL's own, which must prefer the other operand to a NaN, take five.
fn lesser(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return select(b, a, a < b);
}

fn greater(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return select(b, a, a > b);
}

fn lesser1(a: f32, b: f32) -> f32 {
    return select(b, a, a < b);
}

fn greater1(a: f32, b: f32) -> f32 {
    return select(b, a, a > b);
}

/// Entry and exit distance of the slabs; a miss has x > y. The exit is widened by 2 ulp, so that
/// rounding never loses a box (Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013).
fn intersect_box(box_min: vec3<f32>, box_max: vec3<f32>, origin: vec3<f32>, inverse: vec3<f32>, t_max: f32) -> vec2<f32> {
    let a = (box_min - origin) * inverse;
    let b = (box_max - origin) * inverse;
    let low = lesser(a, b);
    let high = greater(a, b);
    let enter = greater1(greater1(low.x, low.y), greater1(low.z, 0.0));
    let leave = lesser1(lesser1(high.x, high.y), high.z) * 1.0000004;
    return vec2<f32>(enter, lesser1(leave, t_max));
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
