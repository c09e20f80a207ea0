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

/// A place in [0, 1) with a density linear from a to b, which are not negative; uniform where both
/// are 0 (Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition, section A.4.1).
fn sample_linear(u: f32, a: f32, b: f32) -> f32 {
    let larger = max(a, b);
    if (larger <= 0.0) {
        return u;
    }
    let p = a / larger;
    let q = b / larger;
    let denominator = p + sqrt(mix(p * p, q * q, u));
    return min(u * (p + q) / max(denominator, 1e-30), LAST_BELOW_ONE);
}

/// A direction uniform in the cone about an axis whose cap is `height` = 1 - cos high.
fn sample_cone(axis: vec3<f32>, height: f32, u: vec2<f32>) -> vec3<f32> {
    let drop = u.x * height;
    let radius = sqrt(max(0.0, drop * (2.0 - drop)));
    let azimuth = unit_circle(u.y);
    return frame_from_normal(axis) * vec3<f32>(radius * azimuth.x, radius * azimuth.y, 1.0 - drop);
}
