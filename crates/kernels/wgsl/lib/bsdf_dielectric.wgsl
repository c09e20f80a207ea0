// Boundaries between dielectrics, smooth or of GGX facets, solid or thin.
//
// Solid: Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (2007), equations
// 20 and 21, with Smith's height-correlated G₂. Thin: both faces with all bounces between them
// (fresnel_sheet); what is transmitted goes on as if reflected and mirrored at the sheet.
// What single scattering loses is given back, but to scenes that ask for single bounces, by reciprocal lobes (Kulla and Conty 2017). Solid, with
// n the denser index over the rarer, A and B the mean losses of the rarer and the denser side:
//   rare to dense, importance: k n² L_A(wo) L_B(wi) / π; dense to rare: k L_B(wo) L_A(wi) / π;
//   rare to rare: (1 - k n² B) L_A L_A / (π A); dense to dense: (1 - k A) L_B L_B / (π B),
// k = (1 - F_mean) / max(A, n² B): all of it comes out again, and f(wo, wi) / n(wi)² is symmetric.
// Radiance is scaled by (n_near / n_far)² on refraction, importance is not (Veach 1997, section 5.2).

/// Curves: solid of one α, a the loss at the front and b at the back; thin, a the loss of a mirror.
fn finish_dielectric(raw: RawMaterial, plain: Material) -> Material {
    var material = plain;
    material.reflect = raw.specular_color;
    material.transmit = raw.color;
    material.albedo = max(max3(raw.color), max3(raw.specular_color));
    if (bends(material) && abs(raw.ior - 1.0) < 1e-3) {
        // Facets between equal indices bend nothing.
        material.alpha = vec2<f32>(0.0);
        material.flags &= ~MATERIAL_CONNECTIBLE;
    }
    if (!bounces_on(material)) {
        return material;
    }
    let mean = dielectric_mean(max(raw.ior, 1.0 / raw.ior));
    if (!bends(material)) {
        return thin_bounces(material, vec3<f32>(fresnel_sheet(mean)), 1.0);
    }
    return solid_bounces(material, mean, 1.0);
}

/// Fresnel's mean over the hemisphere from the rarer side, n > 1, within 0.003 (a fit by
/// Kulla and Conty 2017).
fn dielectric_mean(n: f32) -> f32 {
    return (n - 1.0) / (4.08567 + 1.00071 * n);
}

/// Multiple bounces in a thin sheet of mean reflectance f; `share`: how much of the surface it is
/// (what it transmits has that in its colour).
fn thin_bounces(plain: Material, f: vec3<f32>, share: f32) -> Material {
    var material = plain;
    let scale = INV_PI / loss_mean(material);
    material.ms_front += scale * share * f * material.reflect;
    material.ms_back = material.ms_front;
    material.ms_transmit = scale * (vec3<f32>(1.0) - f) * material.transmit;
    return material;
}

/// The same at a solid's boundary of mean reflectance f from the rarer side.
fn solid_bounces(plain: Material, f: f32, share: f32) -> Material {
    var material = plain;
    let dense_front = material.ior < 1.0;
    var front = 0.0;
    var back = 0.0;
    if (has_solid_losses(material.alpha, material.flags)) {
        let roots = select(material.curves.stretch.zw, material.curves.stretch.wz, dense_front);
        let squares = roots * roots;
        front = clamp(squares.x * squares.x, 1e-6, 1.0);
        back = clamp(squares.y * squares.y, 1e-6, 1.0);
    } else {
        front = lost_mean(material.curves.a, material.alpha.x);
        back = lost_mean(material.curves.b, material.alpha.x);
    }
    let n2 = max(material.ior * material.ior, 1.0 / (material.ior * material.ior));
    let a = select(front, back, dense_front);
    let b = select(back, front, dense_front);
    let k = (1.0 - f) / max(a, n2 * b); // > 0: means are
    let rare = share * material.reflect * ((1.0 - k * n2 * b) * INV_PI / a);
    let dense = share * material.reflect * ((1.0 - k * a) * INV_PI / b);
    material.ms_front = select(rare, dense, dense_front);
    material.ms_back = select(dense, rare, dense_front);
    material.ms_transmit = material.transmit * (k * INV_PI);
    return material;
}
