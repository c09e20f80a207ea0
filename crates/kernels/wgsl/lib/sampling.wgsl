// Maps from the unit square to the domains that paths are drawn from, each with its density.

/// Concentric map of the unit square to the unit disk, uniform in area (Shirley and Chiu 1997).
fn sample_disk(u: vec2<f32>) -> vec2<f32> {
    let a = 2.0 * u.x - 1.0;
    let b = 2.0 * u.y - 1.0;
    if (a == 0.0 && b == 0.0) {
        return vec2<f32>(0.0);
    }
    // |denominator| is the larger of the two and not 0.
    if (abs(a) > abs(b)) {
        let phi = PI_OVER_4 * (b / a);
        return a * vec2<f32>(cos_quarter(phi), sin_quarter(phi));
    }
    let phi = PI_OVER_4 * (a / b);
    return b * vec2<f32>(sin_quarter(phi), cos_quarter(phi));
}

/// A direction about +z with density cos / π per solid angle (Malley's method).
fn sample_cosine_hemisphere(u: vec2<f32>) -> vec3<f32> {
    let d = sample_disk(u);
    return vec3<f32>(d, sqrt(max(0.0, 1.0 - dot(d, d))));
}

/// Barycentrics (of the second and third vertex) uniform in the triangle's area.
fn sample_triangle(u: vec2<f32>) -> vec2<f32> {
    let r = sqrt(u.x);
    return vec2<f32>(r * (1.0 - u.y), r * u.y);
}
