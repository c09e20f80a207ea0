// Directional albedos of rough interfaces, as curves over the cosine. A curve is a polynomial of
// degree 7 in √μ; those of the tables (bindings/material.wgsl) are fitted to quadrature by
// tests/src/albedo.rs, within 0.01. Curves are linear: they can be blended and scaled.
//
// Facets of two α (tests/src/stretched.rs, within 0.01) lose by the azimuth too. There the
// curve is over 1 / (1 + α tan θ), α seen along the direction: all that is lost along either axis is then
// nearly the same, and a curve along the larger α and one across it are blended by the azimuth. Schlick's
// factor is met at one cosine, whose square is a cubic in μ along each axis, blended too.
//
// Facets of two α between dielectrics (tests/src/stretched_solid.rs): polynomials of degree 5 in the root
// of the same place, times functions of the azimuth: powers of x = 1 / n′ and the blend. What facets
// without a smaller α do is a problem in their plane alone, of the index n′ = √((n² - p²) / (1 - p²)), p
// the index times the part of the direction across (which refraction keeps), where p < 1; beyond, from
// the denser side, they are a mirror's (x = 0). What is given back is within 0.02 of what quadrature says is
// lost, where the smaller α is under a tenth of the larger within 0.03. Limits: nothing is fitted under a
// cosine of 0.02; losses there are off by up to 0.05 at 0.01, 0.4 at 0.001.
//
// What a coat and a sheen hold back of the light of facets below them (tests/src/held_back.rs, within 0.021): a
// cubic in √μ times functions of the azimuth, whose coefficients are sums over four cosines of what the
// layers do not let through there.

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
const SOLID_AT: u32 = STRETCHED_AT + ALBEDO_ALPHAS * ALBEDO_RATIOS * STRETCHED_STRIDE;

/// Entries of the fourth table: by the two α as in the third, and by the index; the ratio is innermost.
const SOLID_ALPHAS: u32 = 14u;
const SOLID_INDICES: u32 = 8u;
const SOLID_RATIOS: u32 = 6u;
/// vec4 of an entry. Of each power of the root, the first first: factors of (1, x, x², blend) from the
/// rarer side; of (1, x, x², x³) from the denser. Six factors of the denser's blend; the fourth roots of
/// the mean losses from the rarer side and from the denser.
const SOLID_STRIDE: u32 = 14u;
/// Closer indices lose as this one.
const MIN_SOLID_INDEX: f32 = 1.03;
/// q of the blend over the ratio; how wide the edge of total reflection is over the smaller α (tried).
const SOLID_BLEND: f32 = 0.6;
const SOLID_SMOOTHING: f32 = 0.7;

const HELD_AT: u32 = SOLID_AT + SOLID_ALPHAS * SOLID_INDICES * SOLID_RATIOS * SOLID_STRIDE;

/// Entries of the fifth table: by √ of the larger α, and by √ of the smaller over it; the ratio is innermost.
const HELD_ALPHAS: u32 = 8u;
const HELD_RATIOS: u32 = 4u;
/// vec4 of an entry: for each power of √μ the factors of the functions of the azimuth (1, the share of the
/// direction across the larger α, the blend), by the cosine.
const HELD_STRIDE: u32 = 12u;
/// Those cosines.
const HELD_NODE_0: f32 = 0.03;
const HELD_NODE_1: f32 = 0.1;
const HELD_NODE_2: f32 = 0.25;
const HELD_NODE_3: f32 = 0.6;
/// q of the blend.
const HELD_BLEND: f32 = 0.1;

const ALBEDO_SIZE: u32 = HELD_AT + HELD_ALPHAS * HELD_RATIOS * HELD_STRIDE;

/// What layers hold back: of the fifth table's functions of the azimuth, cubics in √μ.
struct HeldBack {
    all: vec4<f32>,
    across: vec4<f32>,
    blended: vec4<f32>,
}

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

/// Facets below this α lose next to nothing but close to grazing: curves of it are below 0 here and there.
const SMALL_ALPHA: f32 = 0.075;

/// The mean of a curve of what facets of α lose, as `curve_at` has it: what it leaves out below 0 is no part
/// of it. By the midpoint rule in √μ, where 2 μ dμ is 4 s³ ds.
fn lost_mean(curve: Curve, alpha: f32) -> f32 {
    if (alpha >= SMALL_ALPHA) {
        return curve_mean(curve);
    }
    var sum = 0.0;
    for (var i = 0u; i < 32u; i += 1u) {
        let root = (f32(i) + 0.5) / 32.0;
        let mu = root * root;
        sum += mu * root * curve_at(curve, mu);
    }
    return clamp(sum / 8.0, 1e-6, 1.0);
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

/// Place in the fifth table of two α, the larger positive.
fn held_place(alpha: vec2<f32>) -> vec2<f32> {
    let larger = max(alpha.x, alpha.y);
    return vec2<f32>(sqrt(min(larger, 1.0)) * f32(HELD_ALPHAS - 1u), sqrt(min(alpha.x, alpha.y) / larger) * f32(HELD_RATIOS - 1u));
}

/// What is held back of the light to a direction.
fn held_at(held: HeldBack, alpha: vec2<f32>, w: vec3<f32>) -> f32 {
    let root = sqrt(max(w.z, 0.0));
    let powers = vec4<f32>(1.0, root, root * root, root * root * root);
    var sum = dot(held.all, powers);
    if (may_have(FEATURE_ANISOTROPY) && alpha.x != alpha.y) {
        sum += stretched_blend(alpha, w, 1.0) * dot(held.across, powers) + stretched_blend(alpha, w, HELD_BLEND) * dot(held.blended, powers);
    }
    return clamp(sum, 0.0, 1.0);
}

/// Its mean over the hemisphere, weighted by the cosine: the midpoint rule in √μ, where 2 μ dμ is 4 s³ ds,
/// and in a quarter turn.
fn held_mean(held: HeldBack, alpha: vec2<f32>) -> f32 {
    let azimuths = select(1u, 4u, may_have(FEATURE_ANISOTROPY) && alpha.x != alpha.y);
    var sum = 0.0;
    var weights = 0.0;
    for (var i = 0u; i < 8u * azimuths; i += 1u) {
        let root = (f32(i & 7u) + 0.5) / 8.0;
        let mu = root * root;
        let angle = (f32(i >> 3u) + 0.5) * (0.5 * PI) / f32(azimuths);
        let weight = mu * root;
        sum += weight * held_at(held, alpha, vec3<f32>(sqrt(1.0 - mu * mu) * vec2<f32>(cos(angle), sin(angle)), mu));
        weights += weight;
    }
    return max(sum / weights, 1e-6);
}

/// The denser index over the rarer, within the fourth table.
fn solid_index(ior: f32) -> f32 {
    return clamp(max(ior, 1.0 / ior), MIN_SOLID_INDEX, MAX_INDEX);
}

/// What the fourth table's indices are even in.
fn critical_place(index: f32) -> f32 {
    let sine = 1.0 / index;
    return sine - sqrt(1.0 - sine * sine); // index > 1
}

/// Place in the fourth table of two α, the larger positive, and of an index of refraction.
fn solid_place(alpha: vec2<f32>, ior: f32) -> vec3<f32> {
    let larger = max(alpha.x, alpha.y);
    let low = critical_place(MAX_INDEX);
    let index = (critical_place(solid_index(ior)) - low) / (critical_place(MIN_SOLID_INDEX) - low);
    return vec3<f32>(sqrt(min(larger, 1.0)) * f32(SOLID_ALPHAS - 1u), index * f32(SOLID_INDICES - 1u),
        sqrt(min(alpha.x, alpha.y) / larger) * f32(SOLID_RATIOS - 1u));
}

/// x and the blend of a direction on the rarer or the denser side.
fn solid_azimuth(alpha: vec2<f32>, w: vec3<f32>, ior: f32, dense: bool) -> vec2<f32> {
    let n = solid_index(ior);
    let smaller = min(alpha.x, alpha.y);
    let kept = select(w.x, w.y, alpha.x > alpha.y) * select(1.0, n, dense);
    let edge = select(0.0, SOLID_SMOOTHING * smaller, dense);
    let below = 1.0 - kept * kept;
    let u = max(0.5 * (below + length(vec2<f32>(below, edge))), 0.0);
    return vec2<f32>(sqrt(u / (n * n - 1.0 + u)), // n > 1
        stretched_blend(alpha, w, SOLID_BLEND * smaller / max(alpha.x, alpha.y)));
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
