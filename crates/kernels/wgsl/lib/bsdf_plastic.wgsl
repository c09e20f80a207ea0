// A diffuse base under a dielectric coat, as Mitsuba's `plastic` (smooth) and `roughplastic` (GGX).
//
// The coat reflects F D G₂ / (4 cos cos), tinted, with the multiple bounces of a mirror of its mean
// reflectance (a delta lobe where smooth). The base is f = ρ T(wo) T(wi) / (π n² (1 - ρ' F_in)),
// T = 1 - the coat's albedo, F_in the diffuse reflectance of the coat from within: n² (1 - F_in) =
// mean T; ρ' = ρ where `nonlinear`, else 1. White is lossless. Limits: none of the tint goes into T.
// Where light that meets a second facet is lost, T is what single scattering transmits, and what it loses
// from within is no part of F_in.

/// Curves: a the loss of a mirror (of single bounces the coat's own from outside, and across that from
/// within), b the albedo of the coat's single scattering, or of stretched facets.
fn finish_plastic(raw: RawMaterial, plain: Material) -> Material {
    var material = plain;
    material.flags |= MATERIAL_CONNECTIBLE;
    material.reflect = raw.specular_color;
    let mean = vec3<f32>(dielectric_mean(max(raw.ior, 1.0 / raw.ior)));
    var through = 1.0 - mean.x;
    var lost_within = 0.0;
    if (bounces_on(material)) {
        let loss = loss_mean(material);
        material.base_ms = multiple_bounces(mean, loss);
        material.ms_front = raw.specular_color * material.base_ms * (INV_PI / loss);
        through = plastic_through_mean(material, loss);
        material.ms_back = material.ms_front;
    } else if (!is_smooth(material)) {
        material.base_ms = vec3<f32>(1.0);
        through = plastic_through_mean(material, curve_mean(material.curves.a));
        lost_within = curve_mean(material.curves.across);
    }
    let n2 = raw.ior * raw.ior;
    let inside = 1.0 - through / n2 - lost_within;
    let again = select(vec3<f32>(1.0), raw.color, (raw.flags & MATERIAL_NONLINEAR) != 0u);
    material.reflectance = raw.color * INV_PI / (n2 * max(vec3<f32>(1.0) - again * inside, vec3<f32>(1e-4)));
    material.albedo = max(max3(raw.color), 0.25);
    return material;
}

/// What the coat lets through, for a direction with the loss there.
fn plastic_through(material: Material, w: vec3<f32>, loss: f32) -> vec3<f32> {
    if (is_smooth(material)) {
        return vec3<f32>(1.0 - fresnel_dielectric(w.z, material.ior).x);
    }
    var once = 0.0;
    if (has_stretched_curves(material.alpha, material.flags)) {
        once = (1.0 - loss) * fresnel_dielectric(stretched_facing(material, w), material.ior).x;
    } else {
        once = curve_at(material.curves.b, w.z);
    }
    return vec3<f32>(max(1.0 - once - material.base_ms.x * loss, 0.0));
}

/// What a rough coat lets through, on average over the hemisphere, weighted by the cosine. loss: the mean.
fn plastic_through_mean(material: Material, loss: f32) -> f32 {
    if (!has_stretched_curves(material.alpha, material.flags)) {
        return 1.0 - curve_mean(material.curves.b) - material.base_ms.x * loss;
    }
    var sum = 0.0;
    for (var i = 0u; i < n_mean_points(material); i += 1u) {
        let point = mean_point(material, i);
        sum += point.weight * plastic_through(material, point.w, loss_at(material, true, point.w)).x;
    }
    return sum;
}
