// Sampling of surfaces with an interface (lib/bsdf_lobes.wgsl): a lobe by its chance, then a
// direction. Samples of densities carry the sum of all lobes' values and densities.

/// The normal to reflect and refract about, on wo's side: ns, or ng where ns would send the ray to
/// the wrong side of the surface.
fn delta_normal(frame: Frame, wo: vec3<f32>) -> vec3<f32> {
    let side = select(-1.0, 1.0, dot(frame.ng, wo) > 0.0);
    let n = side * frame.ns;
    let cos_o = dot(n, wo);
    let reflected = 2.0 * cos_o * n - wo;
    let usable = cos_o > 0.0 && side * dot(frame.ng, reflected) > 0.0;
    return select(side * frame.ng, n, usable);
}

fn sample_lobes(material: Material, frame: Frame, wo: vec3<f32>, u: vec3<f32>, mode: u32) -> BsdfSample {
    let front = dot(frame.ng, wo) > 0.0;
    let basis = local_basis(material, frame, wo);
    let local_o = wo * basis;
    let chances = lobe_chances(material, front, clamp(local_o.z, 0.0, 1.0));
    let rest = u.z - chances.facets;
    var local = vec3<f32>(0.0);
    if (rest < 0.0) {
        let choice = u.z / chances.facets; // > u.z >= 0
        if (is_smooth(material)) {
            return sample_smooth(material, frame, wo, choice, chances.facets, mode);
        }
        local = sample_facet(material, front, local_o, u.xy, choice);
    } else if (may_have(FEATURE_LAYERS) && rest < chances.coat) {
        if (material.coat_alpha == 0.0) {
            return sample_smooth_coat(material, frame, wo, chances.coat);
        }
        local = sample_coat_facet(material, local_o, u.xy);
    } else {
        let up = sample_cosine_hemisphere(u.xy);
        local = select(up, vec3<f32>(up.xy, -up.z), rest - chances.coat < chances.transmitted);
    }
    return finish_sample(material, frame, basis, wo, local, mode);
}

/// A direction drawn from a density, with the sum of all lobes; wi local, 0 for none.
fn finish_sample(material: Material, frame: Frame, basis: mat3x3<f32>, wo: vec3<f32>, local: vec3<f32>, mode: u32) -> BsdfSample {
    let wi = basis * local;
    let pdf = bsdf_pdf(material, frame, wo, wi);
    if (pdf <= 0.0 || local.z == 0.0) {
        return no_sample();
    }
    let f = bsdf_eval(material, frame, wo, wi, mode);
    return BsdfSample(wi, pdf, f * (abs(dot(frame.ns, wi)) / pdf), false, local.z < 0.0);
}

/// A reflection or refraction at a facet seen from wo; 0 where it ends on the wrong side.
fn sample_facet(material: Material, front: bool, wo: vec3<f32>, u: vec2<f32>, choice: f32) -> vec3<f32> {
    if (wo.z <= 0.0) {
        return vec3<f32>(0.0);
    }
    let h = sample_ggx_normal(material.alpha, wo, u);
    let cos_o = dot(wo, h);
    let reflected = 2.0 * cos_o * h - wo;
    let reflects = choice < reflection_chance(interface_split(material, front, cos_o));
    if (reflects || !bends(material)) {
        let wi = select(vec3<f32>(reflected.xy, -reflected.z), reflected, reflects);
        return select(vec3<f32>(0.0), wi, reflected.z > 0.0);
    }
    let eta = relative_index(material, front);
    let wi = normalize(h * (cos_o / eta - fresnel_dielectric(min(cos_o, 1.0), eta).y) - wo / eta);
    return select(vec3<f32>(0.0), wi, wi.z < 0.0);
}

fn sample_coat_facet(material: Material, wo: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    if (wo.z <= 0.0) {
        return vec3<f32>(0.0);
    }
    let h = sample_ggx_normal(vec2<f32>(material.coat_alpha), wo, u);
    let reflected = 2.0 * dot(wo, h) * h - wo;
    return select(vec3<f32>(0.0), reflected, reflected.z > 0.0);
}

fn sample_smooth_coat(material: Material, frame: Frame, wo: vec3<f32>, chance: f32) -> BsdfSample {
    let n = delta_normal(frame, wo);
    let cos_o = min(dot(n, wo), 1.0);
    let weight = (1.0 - coat_through(material, cos_o)) / chance; // > 0: it was chosen by it
    return BsdfSample(2.0 * cos_o * n - wo, 1.0, vec3<f32>(weight), true, false);
}

/// A smooth interface: reflects or transmits by Fresnel's factors. Radiance is scaled by
/// (n_near / n_far)² on refraction, importance is not (Veach 1997, section 5.2).
fn sample_smooth(material: Material, frame: Frame, wo: vec3<f32>, choice: f32, chance: f32, mode: u32) -> BsdfSample {
    let n = delta_normal(frame, wo);
    let cos_o = min(dot(n, wo), 1.0);
    if (cos_o <= 0.0) {
        return no_sample();
    }
    let front = dot(frame.ng, wo) > 0.0;
    let split = interface_split(material, front, cos_o);
    let reflects = reflection_chance(split);
    if (reflects == 0.0 && max3(split.transmitted) == 0.0) {
        return no_sample();
    }
    if (choice < reflects) {
        let weight = split.reflected * (layers_over(material, front, cos_o) / (chance * reflects));
        return BsdfSample(2.0 * cos_o * n - wo, 1.0, weight, true, false);
    }
    if (!bends(material)) {
        let weight = split.transmitted * (layers_over(material, front, cos_o) / (chance * (1.0 - reflects)));
        return BsdfSample(-wo, 1.0, weight, true, true);
    }
    let eta = relative_index(material, front);
    let cos_t = fresnel_dielectric(cos_o, eta).y;
    let wi = normalize(n * (cos_o / eta - cos_t) - wo / eta);
    if (dot(frame.ng, wi) * dot(frame.ng, wo) >= 0.0) {
        return no_sample();
    }
    let scale = select(1.0, 1.0 / (eta * eta), mode == TRANSPORT_RADIANCE);
    let layers = layers_over(material, true, select(cos_t, cos_o, front));
    return BsdfSample(wi, 1.0, split.transmitted * (scale * layers / (chance * (1.0 - reflects))), true, true);
}

/// What covers a smooth interface, at a cosine.
fn layers_over(material: Material, front: bool, mu: f32) -> f32 {
    if (!is_kind(material.kind, SURFACE_METALLIC_ROUGHNESS, FEATURE_METALLIC_ROUGHNESS) || !has_layers(material, front)) {
        return 1.0;
    }
    return metallic_layers(material, mu);
}
