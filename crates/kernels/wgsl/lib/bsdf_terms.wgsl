// What surfaces with an interface (lib/bsdf_lobes.wgsl) scatter between two directions, and the
// densities of either given the other, in one pass: they share facets, Fresnel's factors, masking and
// albedos. Local directions are those of lib/bsdf_leaning.wgsl.

/// Of a direction `wi` given `wo`, where a path comes from.
struct BsdfTerms {
    /// f, see lib/bsdf.wgsl; within this file times the light's cosine.
    f: vec3<f32>,
    /// Density of wi given wo in the mode of the path that comes from wo, and of wo given wi in the
    /// other's, per solid angle.
    pdf_fwd: f32,
    pdf_rev: f32,
}

fn no_terms() -> BsdfTerms {
    return BsdfTerms(vec3<f32>(0.0), 0.0, 0.0);
}

/// Single scattering by facets, no delta lobes: f, and the densities but for the chance of facets.
/// wi.z < 0 is transmitted; what is thin transmits as it reflects, mirrored.
fn facet_terms(material: Material, front: bool, wo: vec3<f32>, wi: vec3<f32>) -> BsdfTerms {
    let across = wi.z < 0.0;
    if (is_smooth(material) || (across && !may_transmit(material))) {
        return no_terms();
    }
    var h = vec3<f32>(0.0);
    // The densities of wi and of wo over that of the facet: equation 17 of Walter et al. 2007, and 1/4
    // where it reflects.
    var per_wi = 0.25;
    var per_wo = 0.25;
    if (across && bends(material)) {
        let eta = relative_index(material, front);
        h = refracting_facet(wo, wi, eta);
        if (h.z <= 0.0) {
            return no_terms();
        }
        let sum = dot(wi, h) + dot(wo, h) / eta;
        let cosines = -dot(wo, h) * dot(wi, h); // > 0: it refracts one into the other
        per_wi = cosines / max(sum * sum, 1e-20);
        per_wo = cosines / max(eta * eta * sum * sum, 1e-20);
    } else {
        h = reflecting_facet(wo, vec3<f32>(wi.xy, abs(wi.z)));
    }
    let split = interface_split(material, front, dot(wo, h));
    let reflects = reflection_chance(split);
    let distribution = ggx_distribution(material.alpha, h);
    let masking = ggx_masking(material.alpha, wo, wi);
    let chance = distribution * select(reflects, 1.0 - reflects, across);
    return BsdfTerms(select(split.reflected, split.transmitted, across) * (distribution * masking.visibility * per_wi),
        chance * masking.seen_wo * per_wi, chance * masking.seen_wi * per_wo);
}

/// The same of a rough coat, with its chances, wi.z > 0.
fn coat_terms(material: Material, chance_o: f32, chance_i: f32, wo: vec3<f32>, wi: vec3<f32>) -> BsdfTerms {
    if (!may_have(FEATURE_LAYERS) || material.coat == 0.0 || material.coat_alpha == 0.0) {
        return no_terms();
    }
    let alpha = vec2<f32>(material.coat_alpha);
    let h = reflecting_facet(wo, wi);
    let distribution = 0.25 * ggx_distribution(alpha, h);
    let masking = ggx_masking(alpha, wo, wi);
    return BsdfTerms(vec3<f32>(distribution * masking.visibility * coat_fresnel(material, dot(wo, h))),
        chance_o * distribution * masking.seen_wo, chance_i * distribution * masking.seen_wi);
}

/// A direction with all that is met there.
struct Met {
    w: vec3<f32>,
    aspect: Aspect,
    chances: Lobes,
}

/// coat: its normal, in the same basis.
fn meet(material: Material, front: bool, coat: vec3<f32>, w: vec3<f32>) -> Met {
    let up = vec3<f32>(w.xy, abs(w.z));
    let aspect = aspect_at(material, front, up, coat_cosine(material, coat, w));
    return Met(w, aspect, lobe_chances(material, front, up.z, aspect));
}

/// Facets under their layers, the coat's, and what is transmitted.
fn lobe_terms(material: Material, front: bool, o: Met, i: Met) -> BsdfTerms {
    let facets = facet_terms(material, front, o.w, i.w);
    var terms = BsdfTerms(facets.f, o.chances.facets * facets.pdf_fwd, i.chances.facets * facets.pdf_rev);
    if (i.w.z < 0.0) {
        return transmitted_terms(material, front, o, i, terms);
    }
    if (is_kind(material.kind, SURFACE_METALLIC_ROUGHNESS, FEATURE_METALLIC_ROUGHNESS) && has_layers(material, front)) {
        terms.f *= layers_between(o, i);
        if (!coat_leans(material)) {
            let coat = coat_terms(material, o.chances.coat, i.chances.coat, o.w, i.w);
            terms = BsdfTerms(terms.f + coat.f, terms.pdf_fwd + coat.pdf_fwd, terms.pdf_rev + coat.pdf_rev);
        }
    }
    return terms;
}

/// Facets' transmission with that of multiple bounces, f of radiance from wi to wo.
fn transmitted_terms(material: Material, front: bool, o: Met, i: Met, facets: BsdfTerms) -> BsdfTerms {
    if (!may_transmit(material)) {
        return no_terms();
    }
    let eta = relative_index(material, front);
    var bounces = material.ms_transmit * (o.aspect.loss * i.aspect.loss);
    if (bends(material)) {
        bounces *= max(1.0, eta * eta);
    }
    var f = facets.f + bounces;
    if (is_kind(material.kind, SURFACE_METALLIC_ROUGHNESS, FEATURE_METALLIC_ROUGHNESS)) {
        let outside = select(i.aspect.layers, o.aspect.layers, front);
        f = f * select(layers_between(o, i), outside, bends(material)) + material.held_transmit * (o.aspect.held * i.aspect.held);
    }
    return BsdfTerms(select(f, f / (eta * eta), bends(material)),
        facets.pdf_fwd + o.chances.transmitted * INV_PI * -i.w.z, facets.pdf_rev + i.chances.transmitted * INV_PI * o.w.z);
}

/// f of multiple bounces and of the base.
fn base_value(material: Material, front: bool, o: Met, i: Met) -> vec3<f32> {
    var f = vec3<f32>(0.0);
    if (!is_smooth(material)) {
        f = ms_at(material, front) * (o.aspect.loss * i.aspect.loss);
    }
    if (!has_layers(material, front)) {
        return f;
    }
    if (is_kind(material.kind, SURFACE_METALLIC_ROUGHNESS, FEATURE_METALLIC_ROUGHNESS)) {
        f = f * layers_between(o, i) + material.held_back * (o.aspect.held * i.aspect.held);
    }
    return f + material.reflectance * o.aspect.through * i.aspect.through; // nothing goes through but of these two
}

fn sheen_value(material: Material, front: bool, o: Met, i: Met) -> vec3<f32> {
    if (!may_have(FEATURE_LAYERS) || material.kind != SURFACE_METALLIC_ROUGHNESS || max3(material.sheen) == 0.0
        || !has_layers(material, front)) {
        return vec3<f32>(0.0);
    }
    let covered = min(o.aspect.under_coat, i.aspect.under_coat);
    return material.sheen * (covered * sheen_eval(material.sheen_alpha, o.w, i.w));
}

// What `seen_terms` adds up.
const PART_DIRECT: u32 = 0u;
/// The lobe that the surface mirrors.
const PART_FOLDED: u32 = 1u;
/// What the surface cuts off of cosine lobes, as bright as where it is lost: within the lean of the
/// horizon.
const PART_CUT_OFF: u32 = 2u;

/// Which parts there are of a direction wi.
fn parts_of(seen: Seen, wi: vec3<f32>) -> u32 {
    let reflects = dot(seen.ng, wi) > 0.0;
    let mirrored = folded(seen.ng, wi);
    let direct = wi.z != 0.0 && (wi.z > 0.0) == reflects;
    let is_folded = mirrored.z != 0.0 && (mirrored.z > 0.0) == reflects;
    let cut_off = reflects && share_cut_off(seen.ng.z) > 1e-6;
    return select(0u, 1u << PART_DIRECT, direct) | select(0u, 1u << PART_FOLDED, is_folded)
        | select(0u, 1u << PART_CUT_OFF, cut_off);
}

/// f times the light's cosine and the forward density of local directions, about the normal seen from
/// wo; the reverse as far as it is seen about the same normal and not folded (`sees_alike`). One loop, so
/// that a kernel holds its code once. under: `coat_leaning_between`.
fn seen_terms(material: Material, seen: Seen, wo: vec3<f32>, wi: vec3<f32>, about_ng: f32, under: f32) -> BsdfTerms {
    let cos_g = dot(seen.ng, wi);
    let reflects = cos_g > 0.0;
    let o = meet(material, seen.front, seen.coat, wo);
    var terms = no_terms();
    if (reflects) {
        terms.pdf_fwd = o.chances.reflected * INV_PI * mix(max(wi.z, 0.0), cos_g, about_ng);
    }
    var parts = parts_of(seen, wi);
    while (parts != 0u) { // at most 3 times
        let part = firstTrailingBit(parts);
        parts &= parts - 1u;
        let i = meet(material, seen.front == reflects, seen.coat, part_direction(seen, wi, part));
        var weight = abs(i.w.z);
        if (part == PART_CUT_OFF) {
            weight = share_cut_off(seen.ng.z) * cos_g;
        } else {
            let lobes = lobe_terms(material, seen.front, o, i);
            terms.f += weight * lobes.f;
            terms.pdf_fwd += lobes.pdf_fwd;
            terms.pdf_rev += select(0.0, lobes.pdf_rev, part == PART_DIRECT);
        }
        if (reflects && part != PART_FOLDED) {
            terms.f += weight * base_value(material, seen.front, o, i);
        }
        if (reflects && part != PART_CUT_OFF) {
            terms.f += weight * sheen_value(material, seen.front, o, i);
        }
        if (reflects && part == PART_DIRECT) {
            terms.pdf_rev += i.chances.reflected * INV_PI * dot(seen.ng, wo);
        }
    }
    terms.f *= under;
    if (coat_leans(material) && reflects && has_layers(material, seen.front)) {
        let coat = leaning_coat_terms(material, seen, o.chances.coat, wo, wi);
        terms = BsdfTerms(terms.f + coat.f, terms.pdf_fwd + coat.pdf_fwd, terms.pdf_rev + coat.pdf_rev);
    }
    return terms;
}

/// The same of a coat with a normal of its own, for directions on one side of the surface: its lobe, and
/// what of it the surface mirrors. chance: of the coat, seen from wo.
fn leaning_coat_terms(material: Material, seen: Seen, chance: f32, wo: vec3<f32>, wi: vec3<f32>) -> BsdfTerms {
    let basis = frame_from_normal(seen.coat);
    let back = meet(material, seen.front, seen.coat, wi).chances.coat;
    var terms = no_terms();
    for (var part = PART_DIRECT; part <= PART_FOLDED; part += 1u) {
        let i = part_direction(seen, wi, part) * basis;
        if (i.z > 0.0) {
            let lobe = coat_terms(material, chance, back, wo * basis, i);
            terms.f += i.z * lobe.f;
            terms.pdf_fwd += lobe.pdf_fwd;
            terms.pdf_rev += select(0.0, lobe.pdf_rev, part == PART_DIRECT);
        }
    }
    return terms;
}

fn part_direction(seen: Seen, wi: vec3<f32>, part: u32) -> vec3<f32> {
    if (part == PART_CUT_OFF) {
        return vec3<f32>(wi.xy, 0.5 * sqrt(max(1.0 - seen.ng.z * seen.ng.z, 0.0)));
    }
    return select(wi, folded(seen.ng, wi), part == PART_FOLDED);
}

/// Whether a surface is seen about the same normal from the light as from the camera, with nothing of
/// the camera's direction folded: what is met there is then the same with the roles exchanged.
fn sees_alike(material: Material, seen: Seen, frame: Frame, to_camera: vec3<f32>, to_light: vec3<f32>) -> bool {
    let side = select(-1.0, 1.0, seen.front);
    let light_side = select(-1.0, 1.0, dot(frame.ng, to_light) > 0.0);
    let unturned = side * dot(frame.ns, to_camera) >= LEAST_SEEN_COSINE
        && light_side * dot(frame.ns, to_light) >= LEAST_SEEN_COSINE;
    let mirrored = folded(seen.ng, to_camera * seen.basis);
    var coat_unturned = true;
    if (coat_leans(material)) {
        coat_unturned = side * dot(frame.coat_ns, to_camera) >= LEAST_SEEN_COSINE
            && light_side * dot(frame.coat_ns, to_light) >= LEAST_SEEN_COSINE && dot(seen.coat, mirrored) < 0.0;
    }
    return unturned && mirrored.z < 0.0 && coat_unturned;
}

/// f times the light's cosine, and the densities of the light's direction on a camera path (pdf_fwd) and
/// of the camera's on a light path (pdf_rev).
fn interface_terms(material: Material, frame: Frame, to_camera: vec3<f32>, to_light: vec3<f32>) -> BsdfTerms {
    var terms = no_terms();
    var from_direction = to_camera;
    var to_direction = to_light;
    var n_views = 1u;
    let under = coat_leaning_between(material, frame, to_camera, to_light);
    for (var view = 0u; view < n_views; view += 1u) {
        let seen = see_from(material, frame, from_direction);
        let about_ng = select(share_cut_off(seen.ng.z), 1.0, view != 0u);
        let part = seen_terms(material, seen, from_direction * seen.basis, to_direction * seen.basis, about_ng, under);
        if (view == 0u) {
            terms = part;
            n_views = select(2u, 1u, sees_alike(material, seen, frame, to_camera, to_light));
        } else {
            terms.pdf_rev = part.pdf_fwd;
        }
        from_direction = to_light;
        to_direction = to_camera;
    }
    let cos_camera = dot(frame.ng, to_camera);
    let reflects = cos_camera * dot(frame.ng, to_light) > 0.0;
    terms.pdf_rev = mix(terms.pdf_rev, stray_share(material, reflects) * abs(cos_camera) * INV_PI,
        stray_chance(material, frame, TRANSPORT_IMPORTANCE));
    return terms;
}
