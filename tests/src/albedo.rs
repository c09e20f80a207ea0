//! The tables of directional albedos that `crates/kernels/src/albedo.bin` holds, computed in f64 from
//! the models' definitions: quadrature over the visible normals, then a polynomial in √μ by least
//! squares (`crates/kernels/wgsl/lib/albedo.wgsl`). The tables of stretched
//! facets are in `stretched.rs` and `stretched_solid.rs`, that of layers over them in `held_back.rs`.

use glam::DVec3;
use midway_kernels::constants as k;

/// Coefficients of a curve.
pub const TERMS: usize = 8;
/// Cosines that a curve is fitted to, even in √μ.
const POINTS: usize = 40;
/// Cells along each side of the square of numbers that normals are drawn from.
const CELLS: usize = 64;
/// Cells in the cosine and in the azimuth of a direction lit by sheen.
const SHEEN_CELLS: usize = 256;

/// A curve's coefficients.
pub type Curve = [f64; TERMS];

/// Curves in the order of the first two tables, of one entry of every `step`: 1 for all of them.
pub fn tables(step: usize) -> Vec<Curve> {
    let n = k::ALBEDO_ALPHAS;
    let curves = |entry: u32| {
        let alpha = alpha_of(entry % n);
        // The first table is by α, then there is one by α for each index.
        if entry < n { alpha_curves(alpha) } else { index_curves(alpha, index_of(entry / n - 1)) }
    };
    (0..n * (1 + k::ALBEDO_INDICES)).step_by(step).flat_map(curves).collect()
}

/// A table's bytes.
pub fn bytes(numbers: impl IntoIterator<Item = f64>) -> Vec<u8> {
    numbers.into_iter().flat_map(|c| (c as f32).to_le_bytes()).collect()
}

/// α of an entry; the first is nearly smooth.
pub(crate) fn alpha_of(entry: u32) -> f64 {
    (f64::from(entry) / f64::from(k::ALBEDO_ALPHAS - 1)).powi(2).max(1e-4)
}

/// n of an entry: the denser index over the rarer; the last is nearly 1.
fn index_of(entry: u32) -> f64 {
    let least = 1.0 / f64::from(k::MAX_INDEX);
    1.0 / (least + (1.0 - least) * f64::from(entry) / f64::from(k::ALBEDO_INDICES - 1)).min(0.999)
}

/// Loss of a mirror, its albedo with the factor (1 - cos)⁵, albedo of the sheen.
pub(crate) fn alpha_curves(alpha: f64) -> [Curve; k::N_ALPHA_CURVES as usize] {
    let sheen_alpha = alpha.max(f64::from(k::MIN_SHEEN_ALPHA));
    [
        fit(|mu| 1.0 - mirror_albedo(alpha, mu, |_| 1.0)),
        fit(|mu| mirror_albedo(alpha, mu, |c| (1.0 - c).powi(5))),
        fit(|mu| sheen_albedo(sheen_alpha, mu)),
    ]
}

/// Losses of a dielectric's single scattering from the rarer and the denser side, and what it
/// reflects to the rarer.
fn index_curves(alpha: f64, n: f64) -> [Curve; k::N_INDEX_CURVES as usize] {
    let loss = |mu, eta| {
        let (reflected, transmitted) = dielectric_albedo(alpha, mu, eta);
        1.0 - reflected - transmitted
    };
    [fit(|mu| loss(mu, n)), fit(|mu| loss(mu, 1.0 / n)), fit(|mu| dielectric_albedo(alpha, mu, n).0)]
}

/// Λ of Smith's masking.
fn lambda(alpha: f64, cosine: f64) -> f64 {
    let tan2 = (1.0 - cosine * cosine).max(0.0) / (cosine * cosine);
    ((1.0 + alpha * alpha * tan2).sqrt() - 1.0) / 2.0
}

/// Normals visible from the cosine `mu`, all of the same weight.
fn visible_normals(alpha: f64, mu: f64) -> impl Iterator<Item = DVec3> {
    let sine = (1.0 - mu * mu).max(0.0).sqrt();
    let stretched = DVec3::new(alpha * sine, 0.0, mu).normalize();
    (0..CELLS * CELLS).map(move |i| {
        let place = |i: usize| (i as f64 + 0.5) / CELLS as f64;
        let (sin, cos) = (place(i % CELLS) * std::f64::consts::TAU).sin_cos();
        let z = (1.0 - place(i / CELLS)) * (1.0 + stretched.z) - stretched.z;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let h = DVec3::new(r * cos, r * sin, z) + stretched;
        DVec3::new(alpha * h.x, alpha * h.y, h.z.max(0.0)).normalize()
    })
}

fn direction(mu: f64) -> DVec3 {
    DVec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu)
}

/// Albedo of GGX facets whose reflectance is `fresnel` of the cosine: E[F G₂ / G₁].
pub fn mirror_albedo(alpha: f64, mu: f64, fresnel: impl Fn(f64) -> f64) -> f64 {
    let (wo, masked) = (direction(mu), lambda(alpha, mu));
    let weight = |h: DVec3| {
        let cosine = wo.dot(h).clamp(0.0, 1.0);
        let z = 2.0 * cosine * h.z - mu;
        if z <= 0.0 {
            return 0.0;
        }
        fresnel(cosine) * (1.0 + masked) / (1.0 + masked + lambda(alpha, z.min(1.0)))
    };
    visible_normals(alpha, mu).map(weight).sum::<f64>() / (CELLS * CELLS) as f64
}

/// What GGX facets between dielectrics reflect and transmit, as importance; `eta`: the far index over
/// the near.
pub fn dielectric_albedo(alpha: f64, mu: f64, eta: f64) -> (f64, f64) {
    let (wo, masked) = (direction(mu), lambda(alpha, mu));
    let transmitted = |h: DVec3| {
        let cosine = wo.dot(h).clamp(0.0, 1.0);
        let (f, cos_t) = fresnel(cosine, eta);
        let z = (cosine / eta - cos_t) * h.z - mu / eta;
        if f >= 1.0 || z >= 0.0 {
            return 0.0;
        }
        (1.0 - f) * (1.0 + masked) / (1.0 + masked + lambda(alpha, (-z).min(1.0)))
    };
    let sum: f64 = visible_normals(alpha, mu).map(transmitted).sum();
    (mirror_albedo(alpha, mu, |c| fresnel(c, eta).0), sum / (CELLS * CELLS) as f64)
}

/// Fresnel's reflectance, unpolarised, and the transmitted cosine.
pub fn fresnel(cos_i: f64, eta: f64) -> (f64, f64) {
    let sin2 = (1.0 - cos_i * cos_i) / (eta * eta);
    if sin2 >= 1.0 {
        return (1.0, 0.0);
    }
    let cos_t = (1.0 - sin2).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    (0.5 * (parallel * parallel + perpendicular * perpendicular), cos_t)
}

/// Albedo of Estevez and Kulla's sheen of colour 1, by the midpoint rule over directions.
pub fn sheen_albedo(alpha: f64, mu: f64) -> f64 {
    let wo = direction(mu);
    let masked = sheen_lambda(alpha, mu);
    let n = SHEEN_CELLS;
    let cell = std::f64::consts::TAU / (n * n) as f64;
    let value = |i: usize| {
        let z = ((i % n) as f64 + 0.5) / n as f64;
        let (sin, cos) = (((i / n) as f64 + 0.5) / n as f64 * std::f64::consts::PI).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let h = (wo + DVec3::new(r * cos, r * sin, z)).normalize();
        let sin_h = (1.0 - h.z * h.z).max(0.0).sqrt();
        let d = (2.0 + 1.0 / alpha) * sin_h.powf(1.0 / alpha) / std::f64::consts::TAU;
        d / ((1.0 + masked + sheen_lambda(alpha, z)) * 4.0 * mu)
    };
    (0..n * n).map(value).sum::<f64>() * cell
}

fn sheen_lambda(alpha: f64, cosine: f64) -> f64 {
    let t = (1.0 - alpha).powi(2);
    let blend = |rough: f64, smooth: f64| rough + (smooth - rough) * t;
    let (a, b, c) = (blend(21.5473, 25.3245), blend(3.82987, 3.32435), blend(0.19823, 0.16801));
    let (d, e) = (blend(-1.97760, -1.27393), blend(-4.32054, -4.85967));
    let fit = |x: f64| a / (1.0 + b * x.powf(c)) + d * x + e;
    if cosine < 0.5 { fit(cosine).exp() } else { (2.0 * fit(0.5) - fit(1.0 - cosine)).exp() }
}

/// The polynomial in √μ nearest to a function at POINTS cosines.
pub(crate) fn fit(value: impl Fn(f64) -> f64) -> Curve {
    least_squares(cosines().map(|mu| (mu.sqrt(), value(mu), 1.0)))
}

/// Cosines that a curve is fitted to.
pub(crate) fn cosines() -> impl Iterator<Item = f64> {
    (0..POINTS).map(|i| ((i as f64 + 0.5) / POINTS as f64).powi(2))
}

/// The polynomial of N terms nearest to points (x, y, weight).
pub(crate) fn least_squares<const N: usize>(points: impl Iterator<Item = (f64, f64, f64)>) -> [f64; N] {
    let mut rows = [[0.0; N]; N];
    let mut right = [0.0; N];
    for (x, y, weight) in points {
        for (a, row) in rows.iter_mut().enumerate() {
            for (b, sum) in row.iter_mut().enumerate() {
                *sum += weight * x.powi((a + b) as i32);
            }
            right[a] += weight * x.powi(a as i32) * y;
        }
    }
    solve(rows, right)
}

/// Gauss's elimination with the largest pivot; the normal equations are not singular.
pub(crate) fn solve<const N: usize>(mut rows: [[f64; N]; N], mut right: [f64; N]) -> [f64; N] {
    for column in 0..N {
        let largest = (column..N).max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs()));
        let largest = largest.unwrap_or(column);
        rows.swap(column, largest);
        right.swap(column, largest);
        let (pivot, above) = (rows[column], right[column]);
        for index in (0..N).filter(|&index| index != column) {
            let factor = rows[index][column] / pivot[column];
            rows[index].iter_mut().zip(pivot).for_each(|(value, above)| *value -= factor * above);
            right[index] -= factor * above;
        }
    }
    std::array::from_fn(|i| right[i] / rows[i][i])
}

/// A curve's value.
pub fn at(curve: &Curve, mu: f64) -> f64 {
    curve.iter().rev().fold(0.0, |sum, c| sum * mu.sqrt() + c)
}
