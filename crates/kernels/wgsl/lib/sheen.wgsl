// Sheen: microfibres (Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF", 2017), as
// KHR_materials_sheen has it: f = colour D(h) V(wo, wi), α the square of the perceptual roughness.
// Directions are local, on the upper side.

/// Below it the distribution is a ring too thin for the table of its albedo.
const MIN_SHEEN_ALPHA: f32 = 0.04;

/// D, normalised as GGX's: (2 + 1/α) sin(θ)^(1/α) / (2π).
fn sheen_distribution(alpha: f32, cos_h: f32) -> f32 {
    let sin_h = sqrt(max(1.0 - cos_h * cos_h, 1e-12));
    return (2.0 + 1.0 / alpha) * pow_unit(sin_h, 1.0 / alpha) * (0.5 * INV_PI);
}

/// The fitted L of the paper's equation 3 at a cosine in [0, 1/2].
fn sheen_fit(alpha: f32, x: f32) -> f32 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    let a = mix(21.5473, 25.3245, t);
    let b = mix(3.82987, 3.32435, t);
    let c = mix(0.19823, 0.16801, t);
    let d = mix(-1.97760, -1.27393, t);
    let e = mix(-4.32054, -4.85967, t);
    return a / (1.0 + b * pow_unit(max(x, 1e-6), c)) + d * x + e;
}

/// Λ of Smith's shadowing, the branches of the paper's equation 4.
fn sheen_lambda(alpha: f32, cosine: f32) -> f32 {
    let x = min(cosine, 1.0 - cosine);
    let fit = sheen_fit(alpha, x);
    let exponent = select(2.0 * sheen_fit(alpha, 0.5) - fit, fit, cosine < 0.5);
    return 1.0 / exp_negative(-max(exponent, 0.0)) * exp_negative(min(exponent, 0.0));
}

/// f for colour 1.
fn sheen_eval(alpha: f32, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    let h = normalize(wo + wi);
    let g = 1.0 / (1.0 + sheen_lambda(alpha, wo.z) + sheen_lambda(alpha, wi.z));
    return sheen_distribution(alpha, h.z) * g / max(4.0 * wo.z * wi.z, 1e-8);
}
