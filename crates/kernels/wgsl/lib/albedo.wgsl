// Directional albedos of rough interfaces, as curves over the cosine. A curve is a polynomial of
// degree 7 in √μ; those of the tables (bindings/material.wgsl) are fitted to quadrature by
// tests/src/albedo.rs, within 0.01. Curves are linear: they can be blended and scaled.
//
// Facets of two α (tests/src/stretched.rs, within 0.01) lose by the azimuth too. There the
// curve is over 1 / (1 + α tan θ), α seen along the direction: all that is lost along either axis is then
// nearly the same, and a curve along the larger α and one across it are blended by the azimuth. Schlick's
// factor is met at one cosine, whose square is a cubic in μ along each axis, blended too.

struct Curve {
    /// Coefficients of (√μ)⁰ … (√μ)³.
    low: vec4<f32>,
    /// And of (√μ)⁴ … (√μ)⁷.
    high: vec4<f32>,
}

/// Entries of the tables: by √α in [0, 1], and by 1 / n from 1 / MAX_INDEX to 1.
const ALBEDO_ALPHAS: u32 = 16u;
const ALBEDO_INDICES: u32 = 12u;
const MAX_INDEX: f32 = 3.0;

/// Curves of a conductor's table: 1 - E, E the albedo with Fresnel's factor 1; and the albedo with
/// the factor (1 - cos)⁵.
const CURVE_LOSS: u32 = 0u;
const CURVE_GRAZING: u32 = 1u;
/// Albedo of the sheen.
const CURVE_SHEEN: u32 = 2u;
const N_ALPHA_CURVES: u32 = 3u;
/// Curves of a dielectric's: what single scattering loses from the rarer side, from the denser side;
/// what is reflected to the rarer side.
const CURVE_RARE_LOSS: u32 = 0u;
const CURVE_DENSE_LOSS: u32 = 1u;
const CURVE_RARE_REFLECTED: u32 = 2u;
const N_INDEX_CURVES: u32 = 3u;

/// Entries of the third table: by √ of the larger α as above, and by √ of the smaller over it in [0, 1].
const ALBEDO_RATIOS: u32 = 8u;
/// vec4 of an entry: curves of the loss along the larger α and across it, squares of Schlick's cosine
/// along and across, `Albedos.stretch`.
const STRETCHED_STRIDE: u32 = 7u;

/// Sizes of the tables in vec4, and where the second and third start.
const INDEX_CURVES_AT: u32 = ALBEDO_ALPHAS * N_ALPHA_CURVES * 2u;
const STRETCHED_AT: u32 = INDEX_CURVES_AT + ALBEDO_ALPHAS * ALBEDO_INDICES * N_INDEX_CURVES * 2u;
const ALBEDO_SIZE: u32 = STRETCHED_AT + ALBEDO_ALPHAS * ALBEDO_RATIOS * STRETCHED_STRIDE;

fn no_curve() -> Curve {
    return Curve(vec4<f32>(0.0), vec4<f32>(0.0));
}

/// The value at a cosine in [0, 1], kept in [0, 1].
fn curve_at(curve: Curve, mu: f32) -> f32 {
    let s = sqrt(clamp(mu, 0.0, 1.0));
    let h = curve.high;
    let l = curve.low;
    return clamp(l.x + s * (l.y + s * (l.z + s * (l.w + s * (h.x + s * (h.y + s * (h.z + s * h.w)))))), 0.0, 1.0);
}

/// Its mean over the hemisphere, weighted by the cosine: the integral of 2 μ μ^(k/2) is 4 / (k + 4).
fn curve_mean(curve: Curve) -> f32 {
    let mean = dot(curve.low, vec4<f32>(1.0, 4.0 / 5.0, 4.0 / 6.0, 4.0 / 7.0))
        + dot(curve.high, vec4<f32>(4.0 / 8.0, 4.0 / 9.0, 4.0 / 10.0, 4.0 / 11.0));
    return clamp(mean, 1e-6, 1.0);
}

/// The albedo of facets with Schlick's factor from f0 to 1, of CURVE_LOSS and CURVE_GRAZING.
fn schlick_albedo(f0: f32, loss: Curve, grazing: Curve) -> Curve {
    let low = (1.0 - f0) * grazing.low - f0 * loss.low;
    return Curve(low + vec4<f32>(f0, 0.0, 0.0, 0.0), (1.0 - f0) * grazing.high - f0 * loss.high);
}

fn blend_curves(a: Curve, b: Curve, t: f32) -> Curve {
    return Curve(mix(a.low, b.low, vec4<f32>(t)), mix(a.high, b.high, vec4<f32>(t)));
}

/// Place of a roughness in the tables, whole entries.
fn alpha_place(alpha: f32) -> f32 {
    return sqrt(clamp(alpha, 0.0, 1.0)) * f32(ALBEDO_ALPHAS - 1u);
}

/// Place of two α in the third: of the larger, and of the smaller over it. The larger is positive.
fn stretched_place(alpha: vec2<f32>) -> vec2<f32> {
    let larger = max(alpha.x, alpha.y);
    return vec2<f32>(alpha_place(larger), sqrt(min(alpha.x, alpha.y) / larger) * f32(ALBEDO_RATIOS - 1u));
}

/// Where a curve of stretched facets is read: at 1 / (1 + α tan θ), θ the angle to the normal.
fn stretched_cosine(alpha: vec2<f32>, w: vec3<f32>) -> f32 {
    return w.z / max(w.z + length(alpha * w.xy), 1e-20);
}

/// How far a direction is from along the larger α to across it; q > 0 says how early (fitted).
fn stretched_blend(alpha: vec2<f32>, w: vec3<f32>, q: f32) -> f32 {
    let squares = w.xy * w.xy;
    let share = select(squares.x, squares.y, alpha.x > alpha.y) / max(squares.x + squares.y, 1e-20);
    return q * share / (1.0 - (1.0 - q) * share); // >= q: share <= 1
}

/// Place of an index of refraction, whichever side is the denser.
fn index_place(ior: f32) -> f32 {
    let rare_over_dense = max(min(ior, 1.0 / ior), 1.0 / MAX_INDEX);
    return (rare_over_dense - 1.0 / MAX_INDEX) / (1.0 - 1.0 / MAX_INDEX) * f32(ALBEDO_INDICES - 1u);
}

/// Colour of light that has bounced between facets more than once, of mean reflectance f and mean
/// loss (Kulla and Conty, "Revisiting Physically Based Shading at Imageworks", 2017).
fn multiple_bounces(f: vec3<f32>, loss_mean: f32) -> vec3<f32> {
    return f * f * (1.0 - loss_mean) / max(vec3<f32>(1.0) - f * loss_mean, vec3<f32>(1e-6));
}
