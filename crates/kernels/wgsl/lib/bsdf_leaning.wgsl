// Shading normals that lean away from the geometry's.
//
// How a surface is shaded depends on the direction towards the camera and on that towards the light,
// not on who asks: in radiance mode wo leads to the camera, in importance mode wi does. f is made of
// lobes in a local frame about a normal n(camera): ns, or what is nearest to it that faces the camera.
//
//   Facets, sheen, and what is transmitted: what a lobe would send to the wrong side of the surface is
//   mirrored by it: f(camera, light) = lobe(light) + lobe(folded light). Nothing is lost.
//   Bases (cosines): what is cut off, (1 - ng·n) / 2 of a cosine lobe, comes back by the cosine to ng.
//
// So white surfaces stay white, nothing reaches the other side, and where normals do not lean, none of
// this is there. Of the same spirit as Schüssler et al., "Microfacet-based Normal Mapping for Robust
// Monte Carlo Path Tracing" (2017), where light leaves by a second facet, but light directions that
// the field's shading normals light keep their value, but for bases' small part.

/// The least cosine of n to the camera.
const LEAST_SEEN_COSINE: f32 = 1e-4;

/// A surface as it is seen from a direction.
struct Seen {
    /// Columns: along the material's direction, across it, n.
    basis: mat3x3<f32>,
    /// The geometric normal on the direction's side, in the basis.
    ng: vec3<f32>,
    /// The coat's normal as it is seen, in the basis.
    coat: vec3<f32>,
    front: bool,
}

/// A direction mirrored at the surface, to its other side.
fn folded(ng: vec3<f32>, w: vec3<f32>) -> vec3<f32> {
    return w - 2.0 * dot(ng, w) * ng;
}

/// How much of a cosine lobe is on the wrong side of the surface.
fn share_cut_off(cos_lean: f32) -> f32 {
    return 0.5 * max(1.0 - cos_lean, 0.0);
}

/// ns on the direction's side, turned towards it where it faces away.
fn normal_seen_from(ns: vec3<f32>, w: vec3<f32>) -> vec3<f32> {
    let cosine = dot(ns, w);
    if (cosine >= LEAST_SEEN_COSINE) {
        return ns;
    }
    return normalize(ns + (LEAST_SEEN_COSINE - cosine) * w); // not zero: neither is behind the surface
}

fn see_from(material: Material, frame: Frame, w: vec3<f32>) -> Seen {
    let front = dot(frame.ng, w) > 0.0;
    let side = select(-1.0, 1.0, front);
    let basis = local_basis(material, frame, normal_seen_from(side * frame.ns, w), side);
    var coat = vec3<f32>(0.0, 0.0, 1.0);
    if (coat_leans(material)) {
        coat = normal_seen_from(side * frame.coat_ns, w) * basis;
    }
    return Seen(basis, side * frame.ng * basis, coat, front);
}

/// The cosine by which a coat meets a local direction.
fn coat_cosine(material: Material, coat: vec3<f32>, w: vec3<f32>) -> f32 {
    return select(abs(w.z), min(abs(dot(coat, w)), 1.0), coat_leans(material));
}

/// The frame of the coat.
fn coat_frame(material: Material, frame: Frame) -> Frame {
    return Frame(frame.ng, select(frame.ns, frame.coat_ns, coat_leans(material)), frame.tangent, frame.bitangent_sign, frame.coat_ns);
}

/// What a coat with a normal of its own lets through towards w, over what it would by the normal below,
/// which is in the layers' values: so that coat and what is below give back what they would apart.
fn coat_leaning_factor(material: Material, frame: Frame, w: vec3<f32>) -> f32 {
    let front = dot(frame.ng, w) > 0.0;
    if (!coat_leans(material) || !has_layers(material, front)) {
        return 1.0;
    }
    let side = select(-1.0, 1.0, front);
    let own = coat_through(material, dot(normal_seen_from(side * frame.coat_ns, w), w));
    let below = coat_through(material, dot(normal_seen_from(side * frame.ns, w), w));
    return own / max(below, LEAST_THROUGH);
}

/// The same between two directions: as glTF has it, towards the camera, or the one that is outside of a
/// solid.
fn coat_leaning_between(material: Material, frame: Frame, to_camera: vec3<f32>, to_light: vec3<f32>) -> f32 {
    let by_light = bends(material) && dot(frame.ng, to_camera) < 0.0;
    return coat_leaning_factor(material, frame, select(to_camera, to_light, by_light));
}

/// Columns along the tangent turned by the material's rotation, across it, and the normal n.
fn local_basis(material: Material, frame: Frame, n: vec3<f32>, side: f32) -> mat3x3<f32> {
    if (!may_have(FEATURE_ANISOTROPY) || material.alpha.x == material.alpha.y) {
        return frame_from_normal(n);
    }
    let flat_tangent = frame.tangent - n * dot(n, frame.tangent);
    let size2 = dot(flat_tangent, flat_tangent);
    var x = flat_tangent * inverseSqrt(max(size2, 1e-30));
    if (size2 < 1e-12) {
        x = frame_from_normal(n)[0];
    }
    let y = frame.bitangent_sign * side * cross(n, x);
    let along = material.rotation.x * x + material.rotation.y * y;
    return mat3x3<f32>(along, cross(n, along), n);
}

/// How much of a light path's density is a cosine lobe about ng, so that it reaches the cameras that
/// lobes about n(light) do not.
fn stray_chance(material: Material, frame: Frame, mode: u32) -> f32 {
    let cosine = dot(frame.ng, frame.ns);
    let least = select(cosine, min(cosine, dot(frame.ng, frame.coat_ns)), coat_leans(material));
    let leans = clamp(1.0 - least, 0.0, 0.5);
    return select(0.0, leans, mode == TRANSPORT_IMPORTANCE && is_connectible(material));
}

/// The part of it on the side that wi is on.
fn stray_share(material: Material, reflects: bool) -> f32 {
    if (is_smooth(material) || max3(material.transmit) == 0.0) {
        return select(0.0, 1.0, reflects);
    }
    return 0.5;
}

/// The share of bases' samples that are drawn about ng: on light paths all, as what they weigh is then
/// bounded where the cosine to ns is small.
fn share_about_ng(seen: Seen, mode: u32) -> f32 {
    return select(share_cut_off(seen.ng.z), 1.0, mode == TRANSPORT_IMPORTANCE);
}

/// A perfect reflection.
struct Mirrored {
    wi: vec3<f32>,
    /// To ns, of the direction towards the camera; 0 where ns faces away.
    cosine: f32,
    /// Of this reflection among those there are; 0 for none.
    chance: f32,
}

/// wo reflected about ns, then, where it would end behind the surface, by the surface. A light may be
/// seen by both ways: a light path draws one.
fn mirror_leaning(frame: Frame, wo: vec3<f32>, u: f32, mode: u32) -> Mirrored {
    let side = dot(frame.ng, wo);
    let first = 2.0 * dot(frame.ns, wo) * frame.ns - wo;
    let is_first = dot(frame.ng, first) * side > 0.0;
    if (mode == TRANSPORT_RADIANCE) {
        return Mirrored(select(folded(frame.ng, first), first, is_first), facing(frame, wo), 1.0);
    }
    let start = folded(frame.ng, wo);
    let second = 2.0 * dot(frame.ns, start) * frame.ns - start;
    let is_second = dot(frame.ng, second) * side > 0.0;
    let chance = select(0.0, select(1.0, 0.5, is_first && is_second), is_first || is_second);
    let takes_second = is_second && (!is_first || u < 0.5);
    // The cosine of what is mirrored, not of where it went, whose rounding Fresnel's factors magnify near
    // the critical angle.
    let cosine = saturate(sign(side) * dot(frame.ns, select(wo, start, takes_second)));
    return Mirrored(select(first, second, takes_second), cosine, chance);
}

/// Cosine to ns on the direction's side; 0 where ns faces away.
fn facing(frame: Frame, w: vec3<f32>) -> f32 {
    return saturate(select(-1.0, 1.0, dot(frame.ng, w) > 0.0) * dot(frame.ns, w));
}

/// What f times the light's cosine is to be multiplied by on a path: on light paths, where the light's
/// cosine is wo's, the camera's to ng over the light's to ng (Veach 1997, section 5.3.2).
fn adjoint_cosines(frame: Frame, wo: vec3<f32>, wi: vec3<f32>, mode: u32) -> f32 {
    let ratio = abs(dot(frame.ng, wi)) / max(abs(dot(frame.ng, wo)), 1e-20);
    return select(1.0, ratio, mode == TRANSPORT_IMPORTANCE);
}
