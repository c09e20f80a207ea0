//! The third table of `crates/kernels/src/albedo.bin`: what facets of two α lose by the direction, and the
//! cosine by which they meet Schlick's factor (`crates/kernels/wgsl/lib/albedo.wgsl`).

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;
use midway_kernels::constants as k;

use crate::albedo::{self, Curve};

/// Cells along each side of the square of numbers that normals are drawn from.
const CELLS: usize = 64;
/// Cells of the mean over the hemisphere, in the squared cosine and in a quarter turn.
const MEAN_CELLS: usize = 24;
/// Cosines, and azimuths between the axes, that blends are fitted to.
const BLEND_COSINES: usize = 8;
const BLEND_AZIMUTHS: usize = 5;
/// Halvings (by the golden section) of the interval of ln q.
const SECTIONS: usize = 24;
const LEAST_LN_Q: f64 = -6.0;

/// A cubic in μ.
type Cubic = [f64; 4];

/// What the table says of two α.
#[derive(Clone, Debug)]
pub struct Entry {
    along: Curve,
    across: Curve,
    cosine2_along: Cubic,
    cosine2_across: Cubic,
    /// q of losses, q of squared cosines, the mean loss.
    stretch: [f64; 3],
}

/// One entry of every `step` of the table, in its order.
pub fn table(step: usize) -> Vec<Entry> {
    let n = k::ALBEDO_ALPHAS;
    let alphas = |entry: u32| {
        let ratio = (f64::from(entry / n) / f64::from(k::ALBEDO_RATIOS - 1)).powi(2);
        let larger = albedo::alpha_of(entry % n);
        [larger, (larger * ratio).max(1e-4)]
    };
    (0..n * k::ALBEDO_RATIOS).step_by(step).map(|entry| Entry::fit(alphas(entry))).collect()
}

/// E of a white mirror's facets, and their albedo with the factor (1 - cos)⁵, towards a direction.
pub fn albedos(alpha: [f64; 2], wo: DVec3) -> [f64; 2] {
    let mut sums = [0.0; 2];
    reflected(alpha, wo, |_, weight, cosine| {
        sums[0] += weight;
        sums[1] += weight * (1.0 - cosine).powi(5);
    });
    sums
}

/// Calls `add` with the directions that a white mirror's facets send light to, how much, and the cosine to
/// the facet.
pub(crate) fn reflected(alpha: [f64; 2], wo: DVec3, mut add: impl FnMut(DVec3, f64, f64)) {
    let alpha = DVec3::new(alpha[0], alpha[1], 1.0);
    let lambda = |w: DVec3| ((alpha * w).length() / w.z - 1.0) / 2.0;
    let (masked, stretched) = (lambda(wo), (alpha * wo).normalize());
    for i in 0..CELLS * CELLS {
        let place = |i: usize| (i as f64 + 0.5) / CELLS as f64;
        let (sin, cos) = (place(i % CELLS) * TAU).sin_cos();
        let z = (1.0 - place(i / CELLS)) * (1.0 + stretched.z) - stretched.z;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let h = (alpha * (DVec3::new(r * cos, r * sin, z) + stretched)).normalize();
        let cosine = wo.dot(h).clamp(0.0, 1.0);
        let wi = 2.0 * cosine * h - wo;
        if wi.z > 0.0 {
            let weight = (1.0 + masked) / (1.0 + masked + lambda(wi));
            add(wi, weight / (CELLS * CELLS) as f64, cosine);
        }
    }
}

/// A direction by its cosine and its azimuth from the larger α.
pub fn direction(mu: f64, azimuth: f64) -> DVec3 {
    let (sin, cos) = azimuth.sin_cos();
    let r = (1.0 - mu * mu).max(0.0).sqrt();
    DVec3::new(r * cos, r * sin, mu)
}

/// The squared cosine at which Schlick's factor gives facets' albedo, and its weight in a fit: how much
/// the albedo changes by it, squared.
fn facing2([all, grazing]: [f64; 2]) -> (f64, f64) {
    let cosine = 1.0 - (grazing / all).powf(0.2);
    let slope = (1.0 - cosine).powi(4) / (2.0 * cosine);
    (cosine * cosine, slope * slope + 1e-6)
}

impl Entry {
    /// The larger α is the first.
    fn fit(alpha: [f64; 2]) -> Self {
        let loss = |azimuth: f64, seen: f64| {
            // The curve's place is 1 / (1 + α tan θ).
            move |place: f64| {
                let tangent = (1.0 / place - 1.0) / seen;
                1.0 - albedos(alpha, direction(1.0 / tangent.hypot(1.0), azimuth))[0]
            }
        };
        let cosines = |azimuth: f64| {
            albedo::least_squares(albedo::cosines().map(|mu| {
                let (square, weight) = facing2(albedos(alpha, direction(mu, azimuth)));
                (mu, square, weight)
            }))
        };
        let entry = Self {
            along: albedo::fit(loss(0.0, alpha[0])),
            across: albedo::fit(loss(FRAC_PI_2, alpha[1])),
            cosine2_along: cosines(0.0),
            cosine2_across: cosines(FRAC_PI_2),
            stretch: [1.0, 1.0, 0.0],
        };
        let entry = if alpha[0] == alpha[1] { entry } else { entry.with_blends(alpha) };
        let mean = entry.mean(alpha);
        Self { stretch: [entry.stretch[0], entry.stretch[1], mean], ..entry }
    }

    /// With the q that come nearest to both albedos between the axes.
    fn with_blends(self, alpha: [f64; 2]) -> Self {
        let samples: Vec<(DVec3, [f64; 2])> = (0..BLEND_COSINES * BLEND_AZIMUTHS)
            .map(|i| {
                let root = ((i % BLEND_COSINES) as f64 + 0.5) / BLEND_COSINES as f64;
                let azimuth = (i / BLEND_COSINES + 1) as f64 / (BLEND_AZIMUTHS + 1) as f64 * FRAC_PI_2;
                let wo = direction(root * root, azimuth);
                (wo, albedos(alpha, wo))
            })
            .collect();
        let error = |which: usize| {
            let (entry, samples) = (&self, &samples);
            move |q: f64| {
                let mut entry = entry.clone();
                entry.stretch[which] = q;
                let of = |&(wo, [all, grazing]): &(DVec3, [f64; 2])| {
                    let error = if which == 0 {
                        entry.loss(alpha, wo) - (1.0 - all)
                    } else {
                        all * (1.0 - entry.facing(wo)).powi(5) - grazing
                    };
                    error * error
                };
                samples.iter().map(of).sum::<f64>()
            }
        };
        let stretch = [least_at(error(0)), least_at(error(1)), 0.0];
        Self { stretch, ..self }
    }

    /// What is lost towards a direction, x along the larger α.
    pub fn loss(&self, alpha: [f64; 2], wo: DVec3) -> f64 {
        let slope = (alpha[0] * wo.x).hypot(alpha[1] * wo.y);
        let place = wo.z / (wo.z + slope);
        let at = |curve: &Curve| albedo::at(curve, place).clamp(0.0, 1.0);
        let t = blend(self.stretch[0], wo);
        at(&self.along) * (1.0 - t) + at(&self.across) * t
    }

    /// The cosine by which facets meet Schlick's factor.
    pub fn facing(&self, wo: DVec3) -> f64 {
        let at = |cubic: &Cubic| cubic.iter().rev().fold(0.0, |sum, c| sum * wo.z + c);
        let t = blend(self.stretch[1], wo);
        (at(&self.cosine2_along) * (1.0 - t) + at(&self.cosine2_across) * t).clamp(0.0, 1.0).sqrt()
    }

    /// The mean over the hemisphere of what the entry says is lost, weighted by the cosine.
    fn mean(&self, alpha: [f64; 2]) -> f64 {
        let n = MEAN_CELLS;
        let place = |i: usize| (i as f64 + 0.5) / n as f64;
        let value = |i: usize| self.loss(alpha, direction(place(i % n).sqrt(), place(i / n) * FRAC_PI_2));
        (0..n * n).map(value).sum::<f64>() / (n * n) as f64
    }

    /// In the order of the table.
    pub fn numbers(&self) -> Vec<f64> {
        let [along, across] = [self.along.as_slice(), self.across.as_slice()];
        [along, across, &self.cosine2_along, &self.cosine2_across, &self.stretch, &[0.0]].concat()
    }
}

/// How far a direction is from along the larger α to across it.
fn blend(q: f64, wo: DVec3) -> f64 {
    let share = wo.y * wo.y / (wo.x * wo.x + wo.y * wo.y).max(1e-20);
    q * share / (1.0 - (1.0 - q) * share)
}

/// Where a function of q in (0, 1] is least, by the golden section in ln q.
fn least_at(error: impl Fn(f64) -> f64) -> f64 {
    let golden = (5.0f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = (LEAST_LN_Q, 0.0);
    for _ in 0..SECTIONS {
        let (left, right) = (high - golden * (high - low), low + golden * (high - low));
        if error(left.exp()) < error(right.exp()) {
            high = right;
        } else {
            low = left;
        }
    }
    ((low + high) / 2.0).exp()
}
