// Fresnel reflectance: Schlick's approximation, dielectrics, metals.

/// Schlick's approximation; cos in [0, 1].
fn fresnel_schlick(f0: vec3<f32>, cos_i: f32) -> vec3<f32> {
    return fresnel_schlick_to(f0, vec3<f32>(1.0), cos_i);
}

/// The same from f0 at normal incidence to f90 at grazing.
fn fresnel_schlick_to(f0: vec3<f32>, f90: vec3<f32>, cos_i: f32) -> vec3<f32> {
    let c = 1.0 - cos_i;
    let c2 = c * c;
    return f0 + (f90 - f0) * (c2 * c2 * c);
}

/// Its mean over the hemisphere, weighted by the cosine: the integral of 2 c (1 - c)^5 is 1/21.
fn fresnel_schlick_mean(f0: vec3<f32>, f90: vec3<f32>) -> vec3<f32> {
    return f0 + (f90 - f0) * (1.0 / 21.0);
}

/// Unpolarised Fresnel reflectance of a dielectric: x, and the transmitted cosine: y (0 at total
/// internal reflection). eta is the index on the far side over the near side, cos_i in [0, 1].
fn fresnel_dielectric(cos_i: f32, eta: f32) -> vec2<f32> {
    let sin2_t = (1.0 - cos_i * cos_i) / (eta * eta); // eta > 0: checked at import
    if (sin2_t >= 1.0) {
        return vec2<f32>(1.0, 0.0);
    }
    let cos_t = sqrt(1.0 - sin2_t);
    // Denominators are positive: cos_t > 0, and cos_i >= 0.
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    return vec2<f32>(0.5 * (parallel * parallel + perpendicular * perpendicular), cos_t);
}

/// A thin sheet, both faces and all bounces between them: R + T²R + T²R³ + ... = 2R / (1 + R).
fn fresnel_sheet(fresnel: f32) -> f32 {
    return 2.0 * fresnel / (1.0 + fresnel);
}

/// Unpolarised reflectance of a metal of complex index eta + ik, by channel (Lagarde, "Memo on
/// Fresnel equations", 2013); cos_i in [0, 1].
fn fresnel_complex(eta: vec3<f32>, k: vec3<f32>, cos_i: f32) -> vec3<f32> {
    let cos2 = cos_i * cos_i;
    let sin2 = 1.0 - cos2;
    let t0 = eta * eta - k * k - vec3<f32>(sin2);
    let root = sqrt(t0 * t0 + 4.0 * eta * eta * k * k);
    let a = sqrt(max(0.5 * (root + t0), vec3<f32>(0.0)));
    let t1 = root + vec3<f32>(cos2);
    let t2 = 2.0 * cos_i * a;
    let perpendicular = (t1 - t2) / max(t1 + t2, vec3<f32>(1e-20));
    let t3 = cos2 * root + vec3<f32>(sin2 * sin2);
    let t4 = t2 * sin2;
    let ratio = (t3 - t4) / max(t3 + t4, vec3<f32>(1e-20));
    return clamp(0.5 * perpendicular * (vec3<f32>(1.0) + ratio), vec3<f32>(0.0), vec3<f32>(1.0));
}
