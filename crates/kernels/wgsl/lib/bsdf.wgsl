// Surface scattering: sample, evaluate, density, in both transport modes.
//
// Directions wo and wi are unit and point away from the surface; wo towards the vertex that the
// subpath came from. f is relative to the geometry: what arrives is to be multiplied by the
// cosine of wi to ng, in both modes; shading normals are in it. So f_radiance(wo, wi) =
// f_importance(wi, wo), always; where normals do not lean, f(wo, wi) = f(wi, wo) for reflection.
// Densities are per solid angle, without roulette. A delta lobe has f and pdf 0: only bsdf_sample
// reaches it. A material may have delta lobes and others at once: then pdf integrates to the chance of
// the others.

const TRANSPORT_RADIANCE: u32 = 0u;
const TRANSPORT_IMPORTANCE: u32 = 1u;

/// Survival at roulette where the next connection is possible; below 1 so that every path ends. Roulette by
/// throughput may go beyond at a path's first vertices.
const MAX_SURVIVAL: f32 = 0.95;
/// Survival at delta surfaces: below 1 too, or light caught between mirrors would never end.
const DELTA_SURVIVAL: f32 = 0.98;
/// Survival where the albedo bound says little: it grows towards grazing.
const MIN_SURVIVAL: f32 = 0.25;
/// Vertices of a path at which roulette by throughput may be certain to spare it; later it never is.
const SURE_VERTICES: u32 = 8u;

struct BsdfSample {
    wi: vec3<f32>,
    /// Density per solid angle; 1 for a delta lobe, 0 if nothing was sampled.
    pdf: f32,
    /// That of wo given wi, on a path of the other mode; 0 for a delta lobe.
    pdf_rev: f32,
    /// f |cos_g(wi)| / pdf in the mode asked for.
    weight: vec3<f32>,
    is_delta: bool,
    /// Crossed to the other side.
    transmitted: bool,
}

fn no_sample() -> BsdfSample {
    return BsdfSample(vec3<f32>(0.0, 0.0, 1.0), 0.0, 0.0, vec3<f32>(0.0), false, false);
}

/// Whether any of its lobes is no delta, so that it can be joined to.
fn is_connectible(material: Material) -> bool {
    return (material.flags & MATERIAL_CONNECTIBLE) != 0u;
}

/// Whether it has no interface.
fn is_diffuse(material: Material) -> bool {
    return !may_have(FEATURE_INTERFACES) || material.kind == SURFACE_DIFFUSE;
}

/// Chance of going on from a vertex as MIS counts it: of position and material alone, because recursive
/// MIS needs it in reverse.
fn survival(material: Material) -> f32 {
    if (is_diffuse(material)) {
        return min(material.albedo, MAX_SURVIVAL);
    }
    if (material.kind == SURFACE_NULL) {
        return DELTA_SURVIVAL;
    }
    return clamp(material.albedo, MIN_SURVIVAL, most_survival(material));
}

fn most_survival(material: Material) -> f32 {
    return select(DELTA_SURVIVAL, MAX_SURVIVAL, is_connectible(material));
}

/// Chance that roulette by throughput spares a path that arrives at its surface vertex number `depth` (from
/// 0) with this throughput (its largest component): where the albedo takes that below `least`, it is left
/// with about `least`, as by the lower bound of a weight window (Booth and Hendricks 1984). Weights of MIS do
/// not go by it: they share a path out among its strategies by `survival`, and any shares that add up to 1 will
/// do. A multiple of what random numbers are multiples of, so that it is the chance of one below it.
fn survival_by_throughput(material: Material, throughput: f32, least: f32, depth: u32) -> f32 {
    let most = select(most_survival(material), 1.0, depth < SURE_VERTICES);
    let chance = survival(material) * throughput / least; // least > 0: a constant of the integrator
    // A throughput that is no number goes on, to be counted.
    return select(most, ceil(chance * UNIT_STEPS) / UNIT_STEPS, chance < most);
}

/// Whether light on wo's side is absorbed.
fn absorbs(material: Material, frame: Frame, wo: vec3<f32>) -> bool {
    return (material.flags & MATERIAL_FRONT_ONLY) != 0u && dot(frame.ng, wo) <= 0.0;
}

/// f(wo, wi), per steradian, times the light's cosine to the shading normal over that to ng, and the
/// densities of wi given wo and, by the other mode, of wo given wi; 0 for delta lobes.
fn bsdf_terms(material: Material, frame: Frame, wo: vec3<f32>, wi: vec3<f32>, mode: u32) -> BsdfTerms {
    let radiance = mode == TRANSPORT_RADIANCE;
    let to_camera = select(wi, wo, radiance);
    let to_light = select(wo, wi, radiance);
    let cos_light = abs(dot(frame.ng, to_light));
    if (!is_connectible(material) || absorbs(material, frame, wo) || absorbs(material, frame, wi)
        || cos_light == 0.0 || dot(frame.ng, to_camera) == 0.0) {
        return no_terms();
    }
    var terms = no_terms();
    if (is_diffuse(material)) {
        terms = diffuse_terms(material, frame, to_camera, to_light);
    } else {
        terms = interface_terms(material, frame, to_camera, to_light);
    }
    return BsdfTerms(terms.f / cos_light, select(terms.pdf_rev, terms.pdf_fwd, radiance),
        select(terms.pdf_fwd, terms.pdf_rev, radiance));
}

/// Draws wi for wo. u: two numbers for a direction and one for a choice of lobe.
fn bsdf_sample(material: Material, frame: Frame, wo: vec3<f32>, u: vec3<f32>, mode: u32) -> BsdfSample {
    if (material.kind == SURFACE_NULL) {
        return BsdfSample(-wo, 1.0, 0.0, vec3<f32>(1.0), true, true);
    }
    if (absorbs(material, frame, wo)) {
        return no_sample();
    }
    if (is_diffuse(material)) {
        return sample_diffuse(material, frame, wo, u, mode);
    }
    return sample_lobes(material, frame, wo, u, mode);
}

/// Radiance emitted towards wo, which is on the front where dot(ng, wo) > 0.
fn emitted_radiance(material: Material, cos_front: f32) -> vec3<f32> {
    let emits = cos_front > 0.0 || (material.flags & MATERIAL_EMITS_BACK) != 0u;
    return select(vec3<f32>(0.0), material.emission, emits && cos_front != 0.0);
}
