//! The fourth table of `crates/kernels/src/albedo.bin`: what facets of two α between dielectrics lose by
//! the direction, from either side (`crates/kernels/wgsl/lib/albedo.wgsl`).
//!
//! Entries of one larger α are fitted together, to samples between them too: what lies between entries is
//! then as near as the entries themselves. (Each fitted alone, what lies between is off by up to 0.9.)

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4, TAU};

use glam::DVec3;
use midway_kernels::constants as k;

use crate::{albedo::fresnel, stretched::direction};

/// Cells along each side of the square of numbers that normals are drawn from, for fits.
const CELLS: usize = 40;
/// Cosines and azimuths that losses are fitted to; where α is under SMALL_ALPHA also places and azimuths,
/// since it is close to grazing that such facets lose.
const COSINES: usize = 16;
const AZIMUTHS: usize = 12;
const PLACES: usize = 8;
const PLACE_AZIMUTHS: usize = 9;
const SMALL_ALPHA: f64 = 0.3;
const LEAST_COSINE: f64 = 0.02;
/// Fits, each weighted by the errors of the one before.
const FITS: usize = 3;
const MOST_WEIGHT: f64 = 10.0;
/// What keeps a fit's coefficients small where samples do not say them.
const RIDGE: f64 = 3e-5;
/// Coefficients for each function of the azimuth.
const POWERS: usize = 6;
/// Functions of the azimuth, from the rarer side and from the denser.
const FUNCTIONS: [usize; 2] = [4, 5];
/// Under this α what is lost is all close to grazing, and errors count by how small it is elsewhere: else
/// they would be most of the mean.
const SMALLEST_ALPHA: f64 = 0.1;
const LITTLE_LOSS: f64 = 0.04;
/// Cells of means over the hemisphere, in the cosine's root and in a quarter turn.
const MEAN_CELLS: [usize; 2] = [128, 12];
/// Numbers of an entry.
const NUMBERS: usize = 4 * k::SOLID_STRIDE as usize;

/// Facets of two α, the larger along x, between dielectrics.
#[derive(Clone, Copy, Debug)]
pub struct Boundary {
    /// Along x and y.
    pub alpha: [f64; 2],
    /// The denser index over the rarer.
    pub n: f64,
}

impl Boundary {
    /// Of a place among the ratios and the indices of the table.
    fn at(larger: f64, ratio: f64, index: f64) -> Self {
        let ratio = (ratio / f64::from(k::SOLID_RATIOS - 1)).powi(2);
        let [low, high] = [k::MAX_INDEX, k::MIN_SOLID_INDEX].map(|n| angle_place(f64::from(n)));
        let place = low + (high - low) * index / f64::from(k::SOLID_INDICES - 1);
        let n = 1.0 / ((place * FRAC_1_SQRT_2).asin() + FRAC_PI_4).sin();
        Self { alpha: [larger, (larger * ratio).max(1e-4).min(larger)], n }
    }

    /// What single scattering loses, by the midpoint rule over `cells` x `cells` visible normals.
    pub fn loss(&self, wo: DVec3, dense: bool, cells: usize) -> f64 {
        let eta = if dense { 1.0 / self.n } else { self.n };
        let alpha = DVec3::new(self.alpha[0], self.alpha[1], 1.0);
        let lambda = |w: DVec3| ((alpha * w).length() / w.z.abs() - 1.0) / 2.0;
        let (masked, stretched) = (lambda(wo), (alpha * wo).normalize());
        let kept = |wi: DVec3| (1.0 + masked) / (1.0 + masked + lambda(wi));
        let place = |i: usize| (i as f64 + 0.5) / cells as f64;
        let mut sum = 0.0;
        for i in 0..cells * cells {
            let (sin, cos) = (place(i % cells) * TAU).sin_cos();
            let z = (1.0 - place(i / cells)) * (1.0 + stretched.z) - stretched.z;
            let r = (1.0 - z * z).max(0.0).sqrt();
            let h = (alpha * (DVec3::new(r * cos, r * sin, z) + stretched)).normalize();
            let cosine = wo.dot(h).clamp(0.0, 1.0);
            let (f, cos_t) = fresnel(cosine, eta);
            let reflected = 2.0 * cosine * h - wo;
            let refracted = (cosine / eta - cos_t) * h - wo / eta;
            sum += if reflected.z > 0.0 { f * kept(reflected) } else { 0.0 };
            sum += if f < 1.0 && refracted.z < 0.0 { (1.0 - f) * kept(refracted) } else { 0.0 };
        }
        1.0 - sum / (cells * cells) as f64
    }

    /// What multiplies the coefficients: for each power of the place's root, functions of the azimuth.
    fn terms(&self, wo: DVec3, dense: bool) -> Vec<f64> {
        let slope = (self.alpha[0] * wo.x).hypot(self.alpha[1] * wo.y);
        let root = (wo.z / (wo.z + slope)).sqrt();
        let invariant = if dense { self.n * wo.y } else { wo.y };
        let smooth = if dense { f64::from(k::SOLID_SMOOTHING) * self.alpha[1] } else { 0.0 };
        let u = 1.0 - invariant * invariant;
        let u = 0.5 * (u + u.hypot(smooth));
        let x = (u / (self.n * self.n - 1.0 + u)).sqrt();
        let q = f64::from(k::SOLID_BLEND) * self.alpha[1] / self.alpha[0];
        let share = wo.y * wo.y / (wo.x * wo.x + wo.y * wo.y).max(1e-20);
        let blend = q * share / (1.0 - (1.0 - q) * share);
        let functions: &[f64] =
            if dense { &[1.0, x, x * x, x * x * x, blend] } else { &[1.0, x, x * x, blend] };
        (0..POWERS).flat_map(|power| functions.iter().map(move |f| f * root.powi(power as i32))).collect()
    }

    /// Directions that losses are fitted to.
    fn directions(&self) -> impl Iterator<Item = DVec3> {
        let larger = self.alpha[0];
        let grid = |n: usize, azimuths: usize| {
            let root = move |i: usize| (i as f64 + 0.5) / (n as f64 - 0.5); // the normal is one
            let azimuth = move |i: usize| i as f64 / (azimuths - 1) as f64 * FRAC_PI_2;
            (0..n * azimuths).map(move |i| (root(i / azimuths), azimuth(i % azimuths)))
        };
        let square = |t: f64| LEAST_COSINE + (1.0 - LEAST_COSINE) * t * t;
        let by_cosine = grid(COSINES, AZIMUTHS).map(move |(t, azimuth)| direction(square(t), azimuth));
        let by_place = grid(PLACES, PLACE_AZIMUTHS).map(move |(t, azimuth)| {
            let tangent = (1.0 / square(t) - 1.0) / larger;
            direction(1.0 / tangent.hypot(1.0), azimuth)
        });
        by_cosine.chain(by_place.filter(move |_| larger < SMALL_ALPHA))
    }
}

/// What indices are even in: 1 / n less the cosine of the critical angle.
fn angle_place(n: f64) -> f64 {
    1.0 / n - (1.0 - 1.0 / (n * n)).sqrt()
}

/// Entries of the larger α numbered `row`, by the ratio within the index, each of its numbers.
pub fn row(row: u32) -> Vec<[f64; NUMBERS]> {
    let larger = (f64::from(row) / f64::from(k::SOLID_ALPHAS - 1)).powi(2).max(1e-4);
    let [rare, dense] = [false, true].map(|dense| Fit::of(larger, dense));
    let entry = |node: usize| {
        let [rare_terms, dense_terms] = [&rare, &dense].map(|fit| fit.node(node));
        let mut numbers = [0.0; NUMBERS];
        numbers[..24].copy_from_slice(rare_terms);
        for (power, terms) in dense_terms.chunks(FUNCTIONS[1]).enumerate() {
            numbers[24 + 4 * power..28 + 4 * power].copy_from_slice(&terms[..4]);
            numbers[48 + power] = terms[4];
        }
        [numbers[54], numbers[55]] = [rare.means[node], dense.means[node]];
        numbers
    };
    (0..(k::SOLID_RATIOS * k::SOLID_INDICES) as usize).map(entry).collect()
}

/// A direction's loss, and the entries that it is read from.
struct Sample {
    corners: Vec<(usize, f64)>,
    terms: Vec<f64>,
    loss: f64,
    weight: f64,
}

impl Sample {
    fn error(&self, coefficients: &[f64]) -> f64 {
        (value(&self.corners, &self.terms, coefficients) - self.loss).abs()
    }
}

/// The loss between entries.
fn value(corners: &[(usize, f64)], terms: &[f64], coefficients: &[f64]) -> f64 {
    let of = |node: usize| -> f64 {
        terms.iter().zip(&coefficients[node * terms.len()..]).map(|(term, c)| term * c).sum()
    };
    corners.iter().map(|&(node, weight)| weight * of(node)).sum::<f64>().clamp(0.0, 1.0)
}

/// Of all entries of one larger α, for a side: coefficients, and fourth roots of the mean losses.
struct Fit {
    coefficients: Vec<f64>,
    n_terms: usize,
    means: Vec<f64>,
}

impl Fit {
    fn of(larger: f64, dense: bool) -> Self {
        let n_terms = POWERS * FUNCTIONS[usize::from(dense)];
        let mut samples = samples(larger, dense);
        let mut coefficients = Vec::new();
        for _ in 0..FITS {
            coefficients = solve(&samples, n_terms);
            let errors: Vec<f64> = samples.iter().map(|sample| sample.error(&coefficients)).collect();
            let square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
            let mut sum = 0.0;
            for (sample, error) in samples.iter_mut().zip(&errors) {
                sample.weight *= 0.3 + (error / square.sqrt().max(1e-12)).min(MOST_WEIGHT);
                sum += sample.weight;
            }
            let scale = samples.len() as f64 / sum;
            samples.iter_mut().for_each(|sample| sample.weight *= scale);
        }
        let means: Vec<Sample> = places(larger)
            .map(|(boundary, corners)| {
                let loss = mean(boundary, dense, &corners, &coefficients).powf(0.25);
                Sample { corners, terms: vec![1.0], loss, weight: 1.0 }
            })
            .collect();
        Self { coefficients, n_terms, means: solve(&means, 1) }
    }

    fn node(&self, node: usize) -> &[f64] {
        &self.coefficients[node * self.n_terms..(node + 1) * self.n_terms]
    }
}

/// The mean over the hemisphere of what is found lost, weighted by the cosine.
fn mean(at: Boundary, dense: bool, corners: &[(usize, f64)], coefficients: &[f64]) -> f64 {
    let [n, azimuths] = MEAN_CELLS;
    let place = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
    let of = |i: usize| {
        let root = place(i % n, n);
        let wo = direction(root * root, place(i / n, azimuths) * FRAC_PI_2);
        4.0 * root.powi(3) * value(corners, &at.terms(wo, dense), coefficients) // 2 μ dμ = 4 √μ³ d√μ
    };
    (0..n * azimuths).map(of).sum::<f64>() / (n * azimuths) as f64
}

fn samples(larger: f64, dense: bool) -> Vec<Sample> {
    let at = |(boundary, corners): (Boundary, Vec<(usize, f64)>)| {
        let sample = move |wo| {
            let loss = boundary.loss(wo, dense, CELLS);
            let weight =
                if larger < SMALLEST_ALPHA { (LITTLE_LOSS / (LITTLE_LOSS + loss)).powi(2) } else { 1.0 };
            Sample { corners: corners.clone(), terms: boundary.terms(wo, dense), loss, weight }
        };
        boundary.directions().map(sample).collect::<Vec<_>>()
    };
    places(larger).flat_map(at).collect()
}

/// All entries of a larger α and what is half way between them, with the entries that it is read from.
fn places(larger: f64) -> impl Iterator<Item = (Boundary, Vec<(usize, f64)>)> {
    let half_steps = |n: u32| (0..2 * n - 1).map(|i| (i as usize / 2, f64::from(i % 2) / 2.0));
    half_steps(k::SOLID_INDICES).flat_map(move |(index, t)| {
        half_steps(k::SOLID_RATIOS).map(move |(ratio, u)| {
            let boundary = Boundary::at(larger, ratio as f64 + u, index as f64 + t);
            let node = |i: usize, r: usize| (index + i) * k::SOLID_RATIOS as usize + ratio + r;
            let corners = [
                (node(0, 0), (1.0 - t) * (1.0 - u)),
                (node(0, 1), (1.0 - t) * u),
                (node(1, 0), t * (1.0 - u)),
                (node(1, 1), t * u),
            ];
            (boundary, corners.into_iter().filter(|&(_, weight)| weight > 0.0).collect())
        })
    })
}

/// Least squares over all entries at once: normal equations in a band, by Cholesky.
fn solve(samples: &[Sample], n_terms: usize) -> Vec<f64> {
    let n = (k::SOLID_RATIOS * k::SOLID_INDICES) as usize * n_terms;
    let mut band = Band::new(n, (k::SOLID_RATIOS as usize + 2) * n_terms);
    let mut right = vec![0.0; n];
    for sample in samples {
        for &(p, of_p) in &sample.corners {
            for &(q, of_q) in sample.corners.iter().filter(|&&(q, _)| q <= p) {
                let weight = sample.weight * of_p * of_q;
                for (i, a) in sample.terms.iter().enumerate() {
                    let columns = if p == q { i + 1 } else { n_terms };
                    let row = band.row(p * n_terms + i, q * n_terms, columns);
                    row.iter_mut().zip(&sample.terms).for_each(|(sum, b)| *sum += weight * a * b);
                }
            }
            for (i, a) in sample.terms.iter().enumerate() {
                right[p * n_terms + i] += sample.weight * of_p * a * sample.loss;
            }
        }
    }
    band.solve(right)
}

/// The lower half of a symmetric matrix, of no more than `width` numbers a row.
struct Band {
    width: usize,
    numbers: Vec<f64>,
}

impl Band {
    fn new(n: usize, width: usize) -> Self {
        Self { width, numbers: vec![0.0; n * width] }
    }

    /// Columns from `first` of a row; the diagonal is its last.
    fn row(&mut self, row: usize, first: usize, columns: usize) -> &mut [f64] {
        let at = self.at(row, first);
        &mut self.numbers[at..at + columns]
    }

    fn at(&self, row: usize, column: usize) -> usize {
        row * self.width + column + self.width - 1 - row
    }

    fn first(&self, row: usize) -> usize {
        (row + 1).saturating_sub(self.width)
    }

    /// Solves with RIDGE on the diagonal.
    fn solve(mut self, mut x: Vec<f64>) -> Vec<f64> {
        let n = x.len();
        for i in 0..n {
            for j in self.first(i)..=i {
                let from = self.first(i).max(self.first(j));
                let (a, b) = (self.at(i, from), self.at(j, from));
                let [left, right] = [a, b].map(|at| &self.numbers[at..at + j - from]);
                let sum: f64 = left.iter().zip(right).map(|(a, b)| a * b).sum();
                let at = self.at(i, j);
                let rest = self.numbers[at] - sum;
                self.numbers[at] = if i == j {
                    (rest + RIDGE).max(1e-30).sqrt()
                } else {
                    rest / self.numbers[self.at(j, j)]
                };
            }
        }
        for i in 0..n {
            let sum: f64 = (self.first(i)..i).map(|j| self.numbers[self.at(i, j)] * x[j]).sum();
            x[i] = (x[i] - sum) / self.numbers[self.at(i, i)];
        }
        for i in (0..n).rev() {
            x[i] /= self.numbers[self.at(i, i)];
            for j in self.first(i)..i {
                x[j] -= self.numbers[self.at(i, j)] * x[i];
            }
        }
        x
    }
}
