// What conductors, dielectrics, plastic and metallic-roughness have in common: lobes at an interface
// of facets, evaluated and sampled in local directions (z the shading normal on wo's side, wo.z > 0;
// wi.z < 0 is transmitted). `front`: whether wo is on the front.

/// Chances of the lobes, their sum 1 or, where nothing scatters, 0. Each is a function of the side
/// and of |cos wo| alone, so that a delta reflection is chosen in reverse by the same chance; so is
/// a delta transmission, but of a solid that has more lobes on one side than on the other (the
/// weights of MIS then leave the ratio out, on all strategies alike: they sum to 1 all the same).
struct Lobes {
    facets: f32,
    /// Cosine-distributed, on wo's side and on the other.
    reflected: f32,
    transmitted: f32,
    coat: f32,
}

/// What the interface does with light that meets a facet: no distribution, no masking.
struct Split {
    reflected: vec3<f32>,
    transmitted: vec3<f32>,
}

/// The index on the far side over that on wo's.
fn relative_index(material: Material, front: bool) -> f32 {
    let from_inside = !front && (material.flags & MATERIAL_INSIDE) != 0u;
    return select(material.ior, 1.0 / material.ior, from_inside);
}

/// Fresnel's factors with their colours; the same from both sides of a facet.
fn interface_split(material: Material, front: bool, cos_o: f32) -> Split {
    let cosine = clamp(cos_o, 0.0, 1.0);
    let eta = relative_index(material, front);
    if (is_kind(material.kind, SURFACE_CONDUCTOR, FEATURE_CONDUCTOR)) {
        return Split(conductor_fresnel(material, cosine), vec3<f32>(0.0));
    }
    if (is_kind(material.kind, SURFACE_METALLIC_ROUGHNESS, FEATURE_METALLIC_ROUGHNESS)) {
        return metallic_split(material, eta, cosine);
    }
    let exact = fresnel_dielectric(cosine, eta).x;
    let sheet = material.kind == SURFACE_DIELECTRIC && !bends(material);
    let f = select(exact, fresnel_sheet(exact), sheet);
    return Split(material.reflect * f, material.transmit * (1.0 - f));
}

fn conductor_fresnel(material: Material, cosine: f32) -> vec3<f32> {
    if ((material.flags & MATERIAL_COMPLEX) != 0u) {
        return material.reflect * fresnel_complex(material.f0, material.f90, cosine);
    }
    return fresnel_schlick(material.f0, cosine);
}

/// Schlick's approximation by the cosine on the rarer side; 1 at total internal reflection.
fn metallic_split(material: Material, eta: f32, cosine: f32) -> Split {
    var rare = cosine;
    if (bends(material) && eta < 1.0) {
        let sin2 = (1.0 - cosine * cosine) / (eta * eta);
        if (sin2 >= 1.0) {
            return Split(vec3<f32>(1.0), vec3<f32>(0.0));
        }
        rare = sqrt(1.0 - sin2);
    }
    let through = vec3<f32>(1.0) - fresnel_schlick_to(material.base_f0, vec3<f32>(material.base_f90), rare);
    return Split(fresnel_schlick_to(material.f0, material.f90, rare), material.transmit * through);
}

/// The chance of reflection at a facet.
fn reflection_chance(split: Split) -> f32 {
    let reflected = max3(split.reflected);
    let sum = reflected + max3(split.transmitted);
    return select(0.0, reflected / max(sum, 1e-30), sum > 0.0);
}

/// What single scattering loses, at a cosine to the normal on a side.
fn loss_at(material: Material, front: bool, mu: f32) -> f32 {
    if (bends(material) && !front) {
        return curve_at(material.curves.b, mu);
    }
    return curve_at(material.curves.a, mu);
}

const LN_4: f32 = 1.386294361;

/// The same for a direction: a stretched surface loses more along the α that is smaller, the more the
/// closer to grazing (fitted to quadrature).
fn loss_towards(material: Material, front: bool, w: vec3<f32>) -> f32 {
    let loss = loss_at(material, front, w.z);
    if (material.alpha.x == material.alpha.y) {
        return loss;
    }
    let along = material.alpha * w.xy;
    let mean = mean_alpha(material.alpha);
    let ratio = clamp(mean * mean * dot(w.xy, w.xy) / max(dot(along, along), 1e-20), 0.1, 4.0);
    let oblique = 1.0 - saturate(w.z);
    let exponent = 0.5 * stretch_known(material.alpha) * oblique * oblique * oblique;
    return min(loss * pow_unit(0.25 * ratio, exponent) / exp_negative(-LN_4 * exponent), 1.0);
}

fn ms_at(material: Material, front: bool) -> vec3<f32> {
    return select(material.ms_back, material.ms_front, front);
}

/// Whether the layers and the base of plastic and of metallic-roughness are met from this side.
fn has_layers(material: Material, front: bool) -> bool {
    return front || !bends(material);
}

/// Chances of the lobes, about in proportion to what they scatter.
fn lobe_chances(material: Material, front: bool, mu: f32) -> Lobes {
    var facets = 1.0;
    var reflected = 0.0;
    var transmitted = 0.0;
    var coat = 0.0;
    if (!is_smooth(material)) {
        let loss = loss_at(material, front, mu);
        let both = max3(material.ms_transmit) > 0.0;
        reflected = select(0.0, select(loss, 0.5 * loss, both), max3(ms_at(material, front)) > 0.0);
        transmitted = select(0.0, 0.5 * loss, both);
        facets = 1.0 - loss;
    }
    if (has_layers(material, front)) {
        if (is_kind(material.kind, SURFACE_PLASTIC, FEATURE_PLASTIC)) {
            let through = plastic_through(material, mu).x;
            facets *= max3(material.reflect) * (1.0 - through);
            reflected = reflected * max3(material.reflect) + PI * max3(material.reflectance) * through;
        }
        if (is_kind(material.kind, SURFACE_METALLIC_ROUGHNESS, FEATURE_METALLIC_ROUGHNESS)) {
            let f = fresnel_schlick_to(material.f0, material.f90, mu);
            let layers = metallic_layers(material, mu);
            facets *= layers * (max3(f) + 0.02 * max3(material.f90) + max3(material.transmit));
            reflected = layers * reflected + PI * max3(material.reflectance * metallic_through(material, mu))
                + max3(material.sheen) * (0.05 + curve_at(material.curves.sheen, mu));
            transmitted *= layers;
            coat = 1.0 - coat_through(material, mu);
        }
    }
    let sum = facets + reflected + transmitted + coat;
    let scale = select(0.0, 1.0 / max(sum, 1e-30), sum > 0.0);
    return Lobes(facets * scale, reflected * scale, transmitted * scale, coat * scale);
}

/// Reflection by facets, no delta lobes.
fn eval_reflected(material: Material, front: bool, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    var f = vec3<f32>(0.0);
    let h = reflecting_facet(wo, wi);
    let cos_h = dot(wo, h);
    if (!is_smooth(material)) {
        let facets = ggx_distribution(material.alpha, h) * ggx_visibility(material.alpha, wo, wi) * 0.25;
        f = interface_split(material, front, cos_h).reflected * facets;
    }
    if (!is_kind(material.kind, SURFACE_METALLIC_ROUGHNESS, FEATURE_METALLIC_ROUGHNESS) || !has_layers(material, front)) {
        return f;
    }
    f *= layers_between(material, wo.z, wi.z);
    if (may_have(FEATURE_LAYERS) && material.coat > 0.0 && material.coat_alpha > 0.0) {
        let alpha = vec2<f32>(material.coat_alpha);
        let facets = ggx_distribution(alpha, h) * ggx_visibility(alpha, wo, wi) * 0.25;
        f += vec3<f32>(facets * coat_fresnel(material, cos_h));
    }
    return f;
}

/// Reflection by multiple bounces and the base: by the cosines (z), of stretched surfaces by the
/// direction (xy, of any length) too.
fn eval_base(material: Material, front: bool, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    var f = vec3<f32>(0.0);
    let mu_o = wo.z;
    let mu_i = wi.z;
    if (!is_smooth(material)) {
        f = ms_at(material, front) * (loss_towards(material, front, wo) * loss_towards(material, front, wi));
    }
    if (!has_layers(material, front)) {
        return f;
    }
    if (is_kind(material.kind, SURFACE_PLASTIC, FEATURE_PLASTIC)) {
        return f + material.reflectance * plastic_through(material, mu_o) * plastic_through(material, mu_i);
    }
    if (is_kind(material.kind, SURFACE_METALLIC_ROUGHNESS, FEATURE_METALLIC_ROUGHNESS)) {
        f *= layers_between(material, mu_o, mu_i);
        f += material.reflectance * metallic_through(material, mu_o) * metallic_through(material, mu_i);
    }
    return f;
}

fn eval_sheen(material: Material, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    if (!may_have(FEATURE_LAYERS) || material.kind != SURFACE_METALLIC_ROUGHNESS || max3(material.sheen) == 0.0) {
        return vec3<f32>(0.0);
    }
    let covered = min(coat_through(material, wo.z), coat_through(material, wi.z));
    return material.sheen * (covered * sheen_eval(material.sheen_alpha, wo, wi));
}

/// Whether a rough interface lets light through.
fn may_transmit(material: Material) -> bool {
    return may_have(FEATURE_TRANSMISSION) && !is_smooth(material) && max3(material.transmit) > 0.0;
}

/// Transmission, no delta lobes, of radiance from wi to wo.
fn eval_transmitted(material: Material, front: bool, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    if (!may_transmit(material)) {
        return vec3<f32>(0.0);
    }
    let eta = relative_index(material, front);
    let loss = loss_towards(material, front, wo) * loss_towards(material, !front, vec3<f32>(wi.xy, -wi.z));
    var f = material.ms_transmit * loss;
    if (bends(material)) {
        f *= max(1.0, eta * eta);
    }
    f += interface_split_transmitted(material, front, wo, wi, eta);
    if (is_kind(material.kind, SURFACE_METALLIC_ROUGHNESS, FEATURE_METALLIC_ROUGHNESS)) {
        let outside = metallic_layers(material, select(-wi.z, wo.z, front));
        f *= select(layers_between(material, wo.z, -wi.z), outside, bends(material));
    }
    return select(f, f / (eta * eta), bends(material));
}

/// Single scattering in importance mode.
fn interface_split_transmitted(material: Material, front: bool, wo: vec3<f32>, wi: vec3<f32>, eta: f32) -> vec3<f32> {
    let mirrored = vec3<f32>(wi.xy, -wi.z);
    let facets = ggx_visibility(material.alpha, wo, wi);
    if (!bends(material)) {
        let h = reflecting_facet(wo, mirrored);
        return interface_split(material, front, dot(wo, h)).transmitted * (ggx_distribution(material.alpha, h) * facets * 0.25);
    }
    let h = refracting_facet(wo, wi, eta);
    if (h.z <= 0.0) {
        return vec3<f32>(0.0);
    }
    let cos_o = dot(wo, h);
    let split = interface_split(material, front, cos_o);
    return split.transmitted * (ggx_distribution(material.alpha, h) * facets * cos_o * refraction_jacobian(wo, wi, h, eta));
}

/// dω_h / dω_i of refraction (Walter et al. 2007, equation 17).
fn refraction_jacobian(wo: vec3<f32>, wi: vec3<f32>, h: vec3<f32>, eta: f32) -> f32 {
    let sum = dot(wi, h) + dot(wo, h) / eta;
    return abs(dot(wi, h)) / max(sum * sum, 1e-20);
}

/// Density of wi per solid angle, but for delta lobes and cosine lobes on wo's side.
fn lobes_pdf(material: Material, front: bool, chances: Lobes, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    if (wi.z < 0.0) {
        return chances.transmitted * -wi.z * INV_PI + chances.facets * transmitted_pdf(material, front, wo, wi);
    }
    var pdf = 0.0;
    let h = reflecting_facet(wo, wi);
    if (!is_smooth(material)) {
        let chance = reflection_chance(interface_split(material, front, dot(wo, h)));
        pdf = chances.facets * chance * facet_reflection_pdf(material.alpha, wo, h);
    }
    if (may_have(FEATURE_LAYERS) && chances.coat > 0.0 && material.coat_alpha > 0.0) {
        pdf += chances.coat * facet_reflection_pdf(vec2<f32>(material.coat_alpha), wo, h);
    }
    return pdf;
}

/// Density of a reflection by sample_ggx_normal.
fn facet_reflection_pdf(alpha: vec2<f32>, wo: vec3<f32>, h: vec3<f32>) -> f32 {
    return ggx_distribution(alpha, h) * ggx_seen(alpha, wo) * 0.25;
}

fn transmitted_pdf(material: Material, front: bool, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    if (!may_transmit(material)) {
        return 0.0;
    }
    if (!bends(material)) {
        let h = reflecting_facet(wo, vec3<f32>(wi.xy, -wi.z));
        let chance = 1.0 - reflection_chance(interface_split(material, front, dot(wo, h)));
        return chance * facet_reflection_pdf(material.alpha, wo, h);
    }
    let eta = relative_index(material, front);
    let h = refracting_facet(wo, wi, eta);
    if (h.z <= 0.0) {
        return 0.0;
    }
    let cos_o = dot(wo, h);
    let chance = 1.0 - reflection_chance(interface_split(material, front, cos_o));
    return chance * ggx_distribution(material.alpha, h) * ggx_seen(material.alpha, wo) * cos_o
        * refraction_jacobian(wo, wi, h, eta);
}
