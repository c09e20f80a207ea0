// Sampling of surfaces with an interface (lib/bsdf_lobes.wgsl): a lobe by its chance, then a
// direction. Samples of densities carry the sum of all lobes' values and densities.

fn sample_lobes(material: Material, frame: Frame, wo: vec3<f32>, u: vec3<f32>, mode: u32) -> BsdfSample {
    let stray = stray_chance(material, frame, mode);
    let among = (u.z - stray) / (1.0 - stray); // stray <= 1/2
    var wi = vec3<f32>(0.0);
    if (among < 0.0) {
        wi = sample_stray(material, frame, wo, u.xy, u.z / stray);
    } else {
        let seen = see_from(material, frame, wo);
        let local_o = wo * seen.basis;
        let met = aspect_at(material, seen.front, local_o, coat_cosine(material, seen.coat, local_o));
        let chances = lobe_chances(material, seen.front, local_o.z, met);
        let rest = among - chances.facets;
        if (rest < 0.0 && is_smooth(material)) {
            return sample_smooth(material, frame, wo, among / chances.facets, (1.0 - stray) * chances.facets, mode);
        }
        if (rest >= 0.0 && rest < chances.coat && material.coat_alpha == 0.0) {
            return sample_smooth_coat(material, frame, wo, rest / chances.coat, (1.0 - stray) * chances.coat, mode);
        }
        wi = seen.basis * draw_local(material, seen, chances, local_o, vec3<f32>(u.xy, among), mode);
    }
    return finish_sample(material, frame, wo, wi, mode);
}

/// A local direction by the lobe that u.z chooses, on the side of the surface that it belongs to; 0 for
/// none.
fn draw_local(material: Material, seen: Seen, chances: Lobes, wo: vec3<f32>, u: vec3<f32>, mode: u32) -> vec3<f32> {
    let rest = u.z - chances.facets;
    var local = vec3<f32>(0.0);
    if (rest < 0.0) {
        local = sample_facet(material, seen.front, wo, u.xy, u.z / chances.facets); // > u.z >= 0
    } else if (may_have(FEATURE_LAYERS) && rest < chances.coat) {
        if (coat_leans(material)) {
            let basis = frame_from_normal(seen.coat);
            local = basis * sample_coat_facet(material, wo * basis, u.xy);
            return select(folded(seen.ng, local), local, dot(seen.ng, local) >= 0.0);
        }
        local = sample_coat_facet(material, wo, u.xy);
    } else {
        let up = sample_cosine_hemisphere(u.xy);
        let base = rest - chances.coat - chances.transmitted;
        if (base >= 0.0) {
            let about_ng = base < chances.reflected * share_about_ng(seen, mode);
            local = select(up, frame_from_normal(seen.ng) * up, about_ng);
            return select(vec3<f32>(0.0), local, dot(seen.ng, local) > 0.0);
        }
        local = vec3<f32>(up.xy, -up.z);
    }
    let strays = (dot(seen.ng, local) > 0.0) != (local.z > 0.0);
    return select(local, folded(seen.ng, local), strays);
}

/// A direction drawn from a density, with the sum of all lobes; wi is 0 for none.
fn finish_sample(material: Material, frame: Frame, wo: vec3<f32>, wi: vec3<f32>, mode: u32) -> BsdfSample {
    let terms = bsdf_terms(material, frame, wo, wi, mode);
    if (terms.pdf_fwd <= 0.0) {
        return no_sample();
    }
    let cos_g = dot(frame.ng, wi);
    let weight = terms.f * (abs(cos_g) / terms.pdf_fwd);
    return BsdfSample(wi, terms.pdf_fwd, terms.pdf_rev, weight, false, cos_g * dot(frame.ng, wo) < 0.0);
}

fn sample_stray(material: Material, frame: Frame, wo: vec3<f32>, u: vec2<f32>, choice: f32) -> vec3<f32> {
    let up = frame_from_normal(select(-frame.ng, frame.ng, dot(frame.ng, wo) > 0.0)) * sample_cosine_hemisphere(u);
    return select(-up, up, choice < stray_share(material, true));
}

/// A reflection or refraction at a facet seen from wo; 0 where it ends on the wrong side.
fn sample_facet(material: Material, front: bool, wo: vec3<f32>, u: vec2<f32>, choice: f32) -> vec3<f32> {
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
    let h = sample_ggx_normal(vec2<f32>(material.coat_alpha), wo, u);
    let reflected = 2.0 * dot(wo, h) * h - wo;
    return select(vec3<f32>(0.0), reflected, reflected.z > 0.0);
}

fn sample_smooth_coat(material: Material, frame: Frame, wo: vec3<f32>, u: f32, chance: f32, mode: u32) -> BsdfSample {
    let mirrored = mirror_leaning(coat_frame(material, frame), wo, u, mode);
    if (mirrored.chance == 0.0) {
        return no_sample();
    }
    let reflected = coat_fresnel(material, mirrored.cosine);
    let weight = reflected * adjoint_cosines(frame, wo, mirrored.wi, mode) / (chance * mirrored.chance); // > 0: it was chosen
    return BsdfSample(mirrored.wi, 1.0, 0.0, vec3<f32>(weight), true, false);
}

/// A smooth interface seen from a direction.
struct SmoothInterface {
    split: Split,
    /// Where what is transmitted goes; bent where the material bends.
    through: vec3<f32>,
}

/// By the direction and its cosine to ns (`facing`). What would be refracted to the side that it comes
/// from is reflected; so is all where the shading normal faces away, as at grazing.
fn smooth_interface(material: Material, frame: Frame, w: vec3<f32>, cos_o: f32) -> SmoothInterface {
    let front = dot(frame.ng, w) > 0.0;
    let n = select(-frame.ns, frame.ns, front);
    let split = interface_split(material, front, cos_o);
    if (!bends(material)) {
        return SmoothInterface(split, -w);
    }
    let eta = relative_index(material, front);
    let through = normalize(n * (cos_o / eta - fresnel_dielectric(cos_o, eta).y) - w / eta);
    if (cos_o == 0.0 || dot(frame.ng, through) * dot(frame.ng, w) >= 0.0) {
        return SmoothInterface(Split(split.reflected + split.transmitted, vec3<f32>(0.0)), through);
    }
    return SmoothInterface(split, through);
}

/// Reflects or transmits by Fresnel's factors. Radiance is scaled by (n_near / n_far)² on refraction,
/// importance is not (Veach 1997, section 5.2).
fn sample_smooth(material: Material, frame: Frame, wo: vec3<f32>, choice: f32, chance: f32, mode: u32) -> BsdfSample {
    let front = dot(frame.ng, wo) > 0.0;
    let cos_o = facing(frame, wo);
    let at = smooth_interface(material, frame, wo, cos_o);
    let reflects = reflection_chance(at.split);
    if (reflects == 0.0 && max3(at.split.transmitted) == 0.0) {
        return no_sample();
    }
    if (choice < reflects) {
        return sample_smooth_reflection(material, frame, wo, choice / reflects, chance * reflects, mode);
    }
    if (!bends(material)) {
        let weight = at.split.transmitted * (layers_over(material, frame, front, cos_o, wo) / (chance * (1.0 - reflects)));
        return BsdfSample(-wo, 1.0, 0.0, weight, true, true);
    }
    let eta = relative_index(material, front);
    let cos_t = abs(dot(frame.ns, at.through));
    // > 0: at cosines of 0 all is reflected
    let adjoint = adjoint_cosines(frame, wo, at.through, mode) * (cos_o / max(cos_t, 1e-20));
    let scale = select(adjoint, 1.0 / (eta * eta), mode == TRANSPORT_RADIANCE);
    let layers = layers_over(material, frame, true, select(cos_t, cos_o, front), select(at.through, wo, front));
    return BsdfSample(at.through, 1.0, 0.0, at.split.transmitted * (scale * layers / (chance * (1.0 - reflects))), true, true);
}

fn sample_smooth_reflection(material: Material, frame: Frame, wo: vec3<f32>, u: f32, chance: f32, mode: u32) -> BsdfSample {
    let mirrored = mirror_leaning(frame, wo, u, mode);
    if (mirrored.chance == 0.0) {
        return no_sample();
    }
    let to_camera = select(mirrored.wi, wo, mode == TRANSPORT_RADIANCE);
    let split = smooth_interface(material, frame, to_camera, mirrored.cosine).split;
    let layers = layers_over(material, frame, dot(frame.ng, wo) > 0.0, mirrored.cosine, to_camera);
    let weight = layers * adjoint_cosines(frame, wo, mirrored.wi, mode) / (chance * mirrored.chance);
    return BsdfSample(mirrored.wi, 1.0, 0.0, split.reflected * weight, true, false);
}

/// What covers a smooth interface, at a cosine; a coat with a normal of its own by that, from w.
fn layers_over(material: Material, frame: Frame, front: bool, mu: f32, w: vec3<f32>) -> f32 {
    if (!may_have(FEATURE_LAYERS) || material.kind != SURFACE_METALLIC_ROUGHNESS || !has_layers(material, front)) {
        return 1.0;
    }
    let coat_mu = select(mu, facing(coat_frame(material, frame), w), coat_leans(material));
    return layers_through(material, coat_through(material, coat_mu), curve_at(material.curves.sheen, mu));
}
