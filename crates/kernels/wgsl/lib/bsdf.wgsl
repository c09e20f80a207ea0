// Surface scattering: sample, evaluate, density, in both transport modes.
//
// Directions wo and wi are unit and point away from the surface; wo towards the vertex that the
// subpath came from. bsdf_eval has no cosine in it. Densities are per solid angle, without roulette.
// A delta lobe has eval and pdf 0: only bsdf_sample reaches it. A material may have delta lobes and
// others at once: then pdf integrates to the chance of the others. f(wo, wi) = f(wi, wo) for
// reflection; f_radiance(wo, wi) = f_importance(wi, wo) for transmission.

const TRANSPORT_RADIANCE: u32 = 0u;
const TRANSPORT_IMPORTANCE: u32 = 1u;

/// Survival at roulette where the next connection is possible; below 1 so that every path ends.
const MAX_SURVIVAL: f32 = 0.95;
/// Survival at delta surfaces: below 1 too, or light caught between mirrors would never end.
const DELTA_SURVIVAL: f32 = 0.98;
/// Survival where the albedo bound says little: it grows towards grazing.
const MIN_SURVIVAL: f32 = 0.25;

struct BsdfSample {
    wi: vec3<f32>,
    /// Density per solid angle; 1 for a delta lobe, 0 if nothing was sampled.
    pdf: f32,
    /// f |cos_s(wi)| / pdf in the mode asked for; the adjoint factor is the caller's.
    weight: vec3<f32>,
    is_delta: bool,
    /// Crossed to the other side.
    transmitted: bool,
}

fn no_sample() -> BsdfSample {
    return BsdfSample(vec3<f32>(0.0, 0.0, 1.0), 0.0, vec3<f32>(0.0), false, false);
}

/// Whether any of its lobes is no delta, so that it can be joined to.
fn is_connectible(material: Material) -> bool {
    return (material.flags & MATERIAL_CONNECTIBLE) != 0u;
}

/// Whether it has no interface.
fn is_diffuse(material: Material) -> bool {
    return !may_have(FEATURE_INTERFACES) || material.kind == SURFACE_DIFFUSE;
}

/// Chance of going on from a vertex: of position and material alone, because recursive MIS needs it
/// in reverse.
fn survival(material: Material) -> f32 {
    if (is_diffuse(material)) {
        return min(material.albedo, MAX_SURVIVAL);
    }
    if (material.kind == SURFACE_NULL) {
        return DELTA_SURVIVAL;
    }
    return clamp(material.albedo, MIN_SURVIVAL, select(DELTA_SURVIVAL, MAX_SURVIVAL, is_connectible(material)));
}

/// Whether wi and wo both leave the same side, by both normals.
fn same_side(frame: Frame, wo: vec3<f32>, wi: vec3<f32>) -> bool {
    let side = select(-1.0, 1.0, dot(frame.ng, wo) > 0.0);
    return side * dot(frame.ng, wi) > 0.0 && side * dot(frame.ns, wi) > 0.0 && side * dot(frame.ns, wo) > 0.0;
}

/// Whether they leave opposite sides, by both normals.
fn opposite_sides(frame: Frame, wo: vec3<f32>, wi: vec3<f32>) -> bool {
    let side = select(-1.0, 1.0, dot(frame.ng, wo) > 0.0);
    return side * dot(frame.ng, wi) < 0.0 && side * dot(frame.ns, wi) < 0.0 && side * dot(frame.ns, wo) > 0.0;
}

/// Whether light on wo's side is absorbed.
fn absorbs(material: Material, frame: Frame, wo: vec3<f32>) -> bool {
    return (material.flags & MATERIAL_FRONT_ONLY) != 0u && dot(frame.ng, wo) <= 0.0;
}

/// The shading frame with its normal on wo's side: columns along the tangent turned by the
/// material's rotation, across it, and the normal.
fn local_basis(material: Material, frame: Frame, wo: vec3<f32>) -> mat3x3<f32> {
    let n = select(-frame.ns, frame.ns, dot(frame.ng, wo) > 0.0);
    if (!may_have(FEATURE_ANISOTROPY) || material.alpha.x == material.alpha.y) {
        return frame_from_normal(n);
    }
    let flat_tangent = frame.tangent - n * dot(n, frame.tangent);
    let size2 = dot(flat_tangent, flat_tangent);
    var x = flat_tangent * inverseSqrt(max(size2, 1e-30));
    if (size2 < 1e-12) {
        x = frame_from_normal(n)[0];
    }
    let y = frame.bitangent_sign * cross(frame.ns, x);
    let along = material.rotation.x * x + material.rotation.y * y;
    return mat3x3<f32>(along, cross(n, along), n);
}

/// f(wo, wi), per steradian, no cosine; 0 for delta lobes.
fn bsdf_eval(material: Material, frame: Frame, wo: vec3<f32>, wi: vec3<f32>, mode: u32) -> vec3<f32> {
    let reflects = same_side(frame, wo, wi);
    if (is_diffuse(material)) {
        return select(vec3<f32>(0.0), material.reflectance * INV_PI, reflects && !absorbs(material, frame, wo));
    }
    if (!is_connectible(material) || absorbs(material, frame, wo)) {
        return vec3<f32>(0.0);
    }
    let front = dot(frame.ng, wo) > 0.0;
    let basis = local_basis(material, frame, wo);
    if (reflects) {
        return eval_reflected(material, front, wo * basis, wi * basis);
    }
    if (opposite_sides(frame, wo, wi)) {
        return eval_transmitted(material, front, wo * basis, wi * basis, mode);
    }
    return vec3<f32>(0.0);
}

/// Density of wi given wo, per solid angle; 0 for delta lobes. The same in both modes.
fn bsdf_pdf(material: Material, frame: Frame, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    let reflects = same_side(frame, wo, wi);
    if (is_diffuse(material)) {
        return select(0.0, abs(dot(frame.ns, wi)) * INV_PI, reflects && !absorbs(material, frame, wo));
    }
    if (!is_connectible(material) || absorbs(material, frame, wo)) {
        return 0.0;
    }
    if (!reflects && !opposite_sides(frame, wo, wi)) {
        return 0.0;
    }
    let basis = local_basis(material, frame, wo);
    return lobes_pdf(material, dot(frame.ng, wo) > 0.0, wo * basis, wi * basis);
}

/// Draws wi for wo. u: two numbers for a direction and one for a choice of lobe.
fn bsdf_sample(material: Material, frame: Frame, wo: vec3<f32>, u: vec3<f32>, mode: u32) -> BsdfSample {
    if (material.kind == SURFACE_NULL) {
        return BsdfSample(-wo, 1.0, vec3<f32>(1.0), true, true);
    }
    if (absorbs(material, frame, wo)) {
        return no_sample();
    }
    if (is_diffuse(material)) {
        return sample_diffuse(material, frame, wo, u.xy);
    }
    return sample_lobes(material, frame, wo, u, mode);
}

fn sample_diffuse(material: Material, frame: Frame, wo: vec3<f32>, u: vec2<f32>) -> BsdfSample {
    let side = select(-1.0, 1.0, dot(frame.ng, wo) > 0.0);
    let local = sample_cosine_hemisphere(u);
    let wi = frame_from_normal(side * frame.ns) * local;
    let pdf = local.z * INV_PI;
    if (pdf <= 0.0 || !same_side(frame, wo, wi)) {
        return no_sample();
    }
    return BsdfSample(wi, pdf, material.reflectance, false, false);
}

/// What shading normals owe the adjoint: |cos_s(wo) cos_g(wi)| / |cos_g(wo) cos_s(wi)| with wo
/// towards the light side (Veach 1997, section 5.3.2). For light-subpath vertices only.
fn adjoint_factor(frame: Frame, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    let denominator = abs(dot(frame.ng, wo) * dot(frame.ns, wi));
    let numerator = abs(dot(frame.ns, wo) * dot(frame.ng, wi));
    return select(0.0, numerator / max(denominator, 1e-30), denominator > 0.0);
}

/// Radiance emitted towards wo, which is on the front where dot(ng, wo) > 0.
fn emitted_radiance(material: Material, cos_front: f32) -> vec3<f32> {
    let emits = cos_front > 0.0 || (material.flags & MATERIAL_EMITS_BACK) != 0u;
    return select(vec3<f32>(0.0), material.emission, emits && cos_front != 0.0);
}
