// Surface scattering: sample, evaluate, density, in both transport modes.
//
// Directions wo and wi are unit and point away from the surface; wo towards the vertex that the
// subpath came from. ng is the unit geometric normal (front side), ns the shading normal in ng's
// hemisphere. bsdf_eval has no cosine in it. Densities are per solid angle, without roulette.
// A delta lobe has eval and pdf 0: only bsdf_sample reaches it.

const SURFACE_DIFFUSE: u32 = 0u;
const SURFACE_MIRROR: u32 = 1u;
const SURFACE_DIELECTRIC: u32 = 2u;

const TRANSPORT_RADIANCE: u32 = 0u;
const TRANSPORT_IMPORTANCE: u32 = 1u;

/// Survival at roulette where the next connection is possible; below 1 so that every path ends.
const MAX_SURVIVAL: f32 = 0.95;
/// Survival at delta surfaces: below 1 too, or light caught between mirrors would never end.
const DELTA_SURVIVAL: f32 = 0.98;

struct Material {
    /// Albedo, F0, or the tint of what is transmitted.
    reflectance: vec3<f32>,
    kind: u32,
    /// Emitted radiance.
    emission: vec3<f32>,
    /// Inside over outside.
    ior: f32,
    /// Absorption per unit length inside.
    sigma_a: vec3<f32>,
    /// MATERIAL_* bits.
    flags: u32,
}

const MATERIAL_EMITS_BACK: u32 = 1u;
const MATERIAL_THIN: u32 = 2u;

struct BsdfSample {
    wi: vec3<f32>,
    /// Density per solid angle; 1 for a delta lobe, 0 if nothing was sampled.
    pdf: f32,
    /// f |cos_s(wi)| / pdf in radiance mode; the adjoint factor is the caller's.
    weight: vec3<f32>,
    is_delta: bool,
    /// Crossed to the other side.
    transmitted: bool,
}

fn no_sample() -> BsdfSample {
    return BsdfSample(vec3<f32>(0.0, 0.0, 1.0), 0.0, vec3<f32>(0.0), false, false);
}

fn is_delta(material: Material) -> bool {
    return material.kind != SURFACE_DIFFUSE;
}

/// Chance of going on from a vertex: of position and material alone, because recursive MIS needs it
/// in reverse.
fn survival(material: Material) -> f32 {
    switch material.kind {
        case SURFACE_DIFFUSE: { return min(max3(material.reflectance), MAX_SURVIVAL); }
        case SURFACE_MIRROR: { return clamp(max3(material.reflectance), 0.25, DELTA_SURVIVAL); }
        default: { return DELTA_SURVIVAL; }
    }
}

/// Schlick's approximation; cos in [0, 1].
fn fresnel_schlick(f0: vec3<f32>, cos_i: f32) -> vec3<f32> {
    let c = 1.0 - cos_i;
    let c2 = c * c;
    return f0 + (vec3<f32>(1.0) - f0) * (c2 * c2 * c);
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

/// Whether wi and wo both leave the same side, by both normals.
fn same_side(ng: vec3<f32>, ns: vec3<f32>, wo: vec3<f32>, wi: vec3<f32>) -> bool {
    let side = select(-1.0, 1.0, dot(ng, wo) > 0.0);
    return side * dot(ng, wi) > 0.0 && side * dot(ns, wi) > 0.0 && side * dot(ns, wo) > 0.0;
}

/// f(wo, wi), per steradian, no cosine; 0 for delta lobes. Symmetric: reflection only.
fn bsdf_eval(material: Material, ng: vec3<f32>, ns: vec3<f32>, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    if (is_delta(material) || !same_side(ng, ns, wo, wi)) {
        return vec3<f32>(0.0);
    }
    return material.reflectance * INV_PI;
}

/// Density of wi given wo, per solid angle; 0 for delta lobes.
fn bsdf_pdf(material: Material, ng: vec3<f32>, ns: vec3<f32>, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    if (is_delta(material) || !same_side(ng, ns, wo, wi)) {
        return 0.0;
    }
    return abs(dot(ns, wi)) * INV_PI;
}

fn sample_diffuse(material: Material, ng: vec3<f32>, ns: vec3<f32>, wo: vec3<f32>, u: vec2<f32>) -> BsdfSample {
    let side = select(-1.0, 1.0, dot(ng, wo) > 0.0);
    let local = sample_cosine_hemisphere(u);
    let wi = frame_from_normal(side * ns) * local;
    let pdf = local.z * INV_PI;
    if (pdf <= 0.0 || !same_side(ng, ns, wo, wi)) {
        return no_sample();
    }
    return BsdfSample(wi, pdf, material.reflectance, false, false);
}

/// The normal to reflect and refract about, on wo's side: ns, or ng where ns would send the ray to
/// the wrong side of the surface.
fn delta_normal(ng: vec3<f32>, ns: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let side = select(-1.0, 1.0, dot(ng, wo) > 0.0);
    let n = side * ns;
    let cos_o = dot(n, wo);
    let reflected = 2.0 * cos_o * n - wo;
    let usable = cos_o > 0.0 && side * dot(ng, reflected) > 0.0;
    return select(side * ng, n, usable);
}

fn sample_mirror(material: Material, ng: vec3<f32>, ns: vec3<f32>, wo: vec3<f32>) -> BsdfSample {
    let n = delta_normal(ng, ns, wo);
    let cos_o = min(dot(n, wo), 1.0);
    if (cos_o <= 0.0) {
        return no_sample();
    }
    return BsdfSample(2.0 * cos_o * n - wo, 1.0, fresnel_schlick(material.reflectance, cos_o), true, false);
}

fn sample_thin(material: Material, n: vec3<f32>, wo: vec3<f32>, cos_o: f32, u: f32) -> BsdfSample {
    let fresnel = fresnel_dielectric(cos_o, material.ior).x;
    // Both faces and all bounces between them: R + T²R + T²R³ + ... = 2R / (1 + R).
    let reflected = 2.0 * fresnel / (1.0 + fresnel);
    if (u < reflected) {
        return BsdfSample(2.0 * cos_o * n - wo, 1.0, vec3<f32>(1.0), true, false);
    }
    return BsdfSample(-wo, 1.0, material.reflectance, true, true);
}

/// A smooth dielectric boundary: reflects with the Fresnel chance, else refracts. Radiance is
/// scaled by (n_near / n_far)² on refraction, importance is not (Veach 1997, section 5.2).
fn sample_dielectric(material: Material, ng: vec3<f32>, ns: vec3<f32>, wo: vec3<f32>, u: f32, mode: u32) -> BsdfSample {
    let n = delta_normal(ng, ns, wo);
    let cos_o = min(dot(n, wo), 1.0);
    if (cos_o <= 0.0) {
        return no_sample();
    }
    if ((material.flags & MATERIAL_THIN) != 0u) {
        return sample_thin(material, n, wo, cos_o, u);
    }
    let entering = dot(ng, wo) > 0.0;
    let eta = select(1.0 / material.ior, material.ior, entering);
    let fresnel = fresnel_dielectric(cos_o, eta);
    if (u < fresnel.x) {
        return BsdfSample(2.0 * cos_o * n - wo, 1.0, vec3<f32>(1.0), true, false);
    }
    let wi = normalize(n * (cos_o / eta - fresnel.y) - wo / eta);
    let crosses = dot(ng, wi) * dot(ng, wo) < 0.0;
    if (!crosses) {
        return no_sample();
    }
    let scale = select(1.0, 1.0 / (eta * eta), mode == TRANSPORT_RADIANCE);
    return BsdfSample(wi, 1.0, material.reflectance * scale, true, true);
}

/// Draws wi for wo. u: two numbers for a direction and one for a choice of lobe.
fn bsdf_sample(material: Material, ng: vec3<f32>, ns: vec3<f32>, wo: vec3<f32>, u: vec3<f32>, mode: u32) -> BsdfSample {
    switch material.kind {
        case SURFACE_DIFFUSE: { return sample_diffuse(material, ng, ns, wo, u.xy); }
        case SURFACE_MIRROR: { return sample_mirror(material, ng, ns, wo); }
        default: { return sample_dielectric(material, ng, ns, wo, u.z, mode); }
    }
}

/// What shading normals owe the adjoint: |cos_s(wo) cos_g(wi)| / |cos_g(wo) cos_s(wi)| with wo
/// towards the light side (Veach 1997, section 5.3.2). For light-subpath vertices only.
fn adjoint_factor(ng: vec3<f32>, ns: vec3<f32>, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    let denominator = abs(dot(ng, wo) * dot(ns, wi));
    let numerator = abs(dot(ns, wo) * dot(ng, wi));
    return select(0.0, numerator / max(denominator, 1e-30), denominator > 0.0);
}

/// Radiance emitted towards wo, which is on the front where dot(ng, wo) > 0.
fn emitted_radiance(material: Material, cos_front: f32) -> vec3<f32> {
    let emits = cos_front > 0.0 || (material.flags & MATERIAL_EMITS_BACK) != 0u;
    return select(vec3<f32>(0.0), material.emission, emits && cos_front != 0.0);
}
