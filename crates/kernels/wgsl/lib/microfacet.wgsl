// The GGX (Trowbridge-Reitz) distribution of facets, anisotropic, with Smith's height-correlated
// masking and shadowing (Heitz, "Understanding the Masking-Shadowing Function", JCGT 3(2), 2014).
// Directions are local: z along the normal, x and y along and across the tangent; wo.z > 0.
// alpha.x, alpha.y >= MIN_ALPHA: smoother surfaces are delta lobes.

/// Below it f32 does not resolve the lobe.
const MIN_ALPHA: f32 = 1e-3;

/// Density of facets' normals: its integral times the cosine is 1.
fn ggx_distribution(alpha: vec2<f32>, h: vec3<f32>) -> f32 {
    let x = h.x / alpha.x;
    let y = h.y / alpha.y;
    let d = x * x + y * y + h.z * h.z;
    return INV_PI / (alpha.x * alpha.y * d * d);
}

/// Length of a direction as seen where the surface is stretched to roughness 1: Smith's Λ is
/// (|w'| / |w.z| - 1) / 2.
fn ggx_stretched(alpha: vec2<f32>, w: vec3<f32>) -> f32 {
    return length(vec3<f32>(alpha * w.xy, w.z));
}

/// Masking and shadowing of two directions, on the same side or, as pbrt-v4 has it, on opposite ones.
struct Masking {
    /// G₂(wo, wi) / |wo.z wi.z| = 1 / ((1 + Λ(wo) + Λ(wi)) |wo.z wi.z|).
    visibility: f32,
    /// G₁ / |z| of each; times D and the cosine to h it is the density of the normals seen from there.
    seen_wo: f32,
    seen_wi: f32,
}

fn ggx_masking(alpha: vec2<f32>, wo: vec3<f32>, wi: vec3<f32>) -> Masking {
    let o = ggx_stretched(alpha, wo);
    let i = ggx_stretched(alpha, wi);
    let cos_o = abs(wo.z);
    let cos_i = abs(wi.z);
    // stretched directions are as long as their z at least, and wo.z > 0
    return Masking(2.0 / max(o * cos_i + i * cos_o, 1e-30), 2.0 / (cos_o + o), 2.0 / max(cos_i + i, 1e-30));
}

/// A facet's normal as seen from wo, by spherical caps (Dupuy and Benyoub, "Sampling Visible GGX
/// Normals with Spherical Caps", 2023).
fn sample_ggx_normal(alpha: vec2<f32>, wo: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    let stretched = normalize(vec3<f32>(alpha * wo.xy, wo.z));
    let z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
    let r = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    let h = vec3<f32>(r * cos_sin_turn(u.x), z) + stretched;
    return normalize(vec3<f32>(alpha * h.xy, max(h.z, 1e-9)));
}

/// The facet that reflects wo into wi, both on the upper side.
fn reflecting_facet(wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    return normalize(wo + wi);
}

/// The facet that refracts wo into wi, on the other side, eta the index there over that at wo; 0
/// where there is none.
fn refracting_facet(wo: vec3<f32>, wi: vec3<f32>, eta: f32) -> vec3<f32> {
    let sum = wo + eta * wi;
    let h = sum / max(length(sum), 1e-20);
    let up = select(-h, h, h.z > 0.0);
    let faces_both = dot(up, wo) > 0.0 && dot(up, wi) < 0.0;
    return select(vec3<f32>(0.0), up, faces_both);
}
