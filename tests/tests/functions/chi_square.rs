//! Pearson's chi-square test of samples against a density, as pbrt and Mitsuba test samplers: the
//! domain is cut into bins, the density is integrated over each, and bins that expect little are
//! pooled.

use std::{f64::consts::TAU, fmt};

use glam::DVec3;
use midway_tests::statistics::{chi_square_tail, sidak};

/// Chance that a correct sampler fails one of all the tests of this folder.
const FAMILY_LEVEL: f64 = 1e-3;
/// At least as many as there are tests by [`ChiSquare::assert_holds`].
const N_TESTS: usize = 200;
/// Bins that expect fewer samples are pooled.
const LEAST_EXPECTED: f64 = 5.0;
/// More of the mass than this outside all bins, or less than minus this, says that the density is
/// no density.
const MASS_TOLERANCE: f64 = 2e-3;

/// A test's outcome.
#[derive(Clone, Copy, Debug)]
pub struct ChiSquare {
    statistic: f64,
    degrees: usize,
    /// Chance of so large a statistic where the samples do follow the density.
    pub p: f64,
}

impl ChiSquare {
    /// Of counts against expected counts of the same sum. A few samples in bins that expect none are
    /// forgiven: quadrature misses slivers of the support.
    pub fn of(observed: &[u64], expected: &[f64]) -> Self {
        assert_eq!(observed.len(), expected.len());
        let impossible = Self { statistic: f64::INFINITY, degrees: 0, p: 0.0 };
        let sums = (observed.iter().sum::<u64>() as f64, expected.iter().sum::<f64>());
        let same_sum = (sums.0 - sums.1).abs() <= 1e-6 * sums.0;
        if !same_sum {
            return impossible;
        }
        let (mut statistic, mut cells, mut pool) = (0.0, 0usize, (0.0, 0.0));
        let mut add = |o: f64, e: f64| {
            statistic += (o - e).powi(2) / e;
            cells += 1;
        };
        for (&o, &e) in observed.iter().zip(expected) {
            if e >= LEAST_EXPECTED {
                add(o as f64, e);
            } else {
                pool = (pool.0 + o as f64, pool.1 + e);
            }
        }
        if pool.1 >= LEAST_EXPECTED {
            add(pool.0, pool.1);
        } else if pool.0 > 10.0 * LEAST_EXPECTED {
            return impossible;
        }
        let degrees = cells.saturating_sub(1);
        let p = if degrees > 0 { chi_square_tail(statistic, degrees as f64) } else { 0.0 };
        Self { statistic, degrees, p: if p.is_nan() { 0.0 } else { p } }
    }

    /// Of counts that should all be alike.
    pub fn uniform(observed: &[u64]) -> Self {
        let mean = observed.iter().sum::<u64>() as f64 / observed.len() as f64;
        Self::of(observed, &vec![mean; observed.len()])
    }

    pub fn holds(&self) -> bool {
        self.p >= sidak(FAMILY_LEVEL, N_TESTS)
    }

    #[track_caller]
    pub fn assert_holds(&self, what: &str) {
        assert!(self.holds(), "{what}: {self}");
    }

    #[track_caller]
    pub fn assert_rejects(&self, what: &str) {
        assert!(!self.holds(), "{what} was not rejected: {self}");
    }
}

impl fmt::Display for ChiSquare {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "chi-square {} at {} degrees of freedom, p = {:e}", self.statistic, self.degrees, self.p)
    }
}

/// Bins of equal solid angle on a cap about an axis.
#[derive(Clone, Copy)]
pub struct Cap {
    frame: [DVec3; 3],
    /// The cosine at its edge; -1 for the whole sphere.
    cos_min: f64,
    rows: usize,
    columns: usize,
}

impl Cap {
    /// The cap's cosines to `axis` are at least `cos_min`.
    pub fn new(axis: DVec3, cos_min: f64) -> Self {
        let x = axis.any_orthonormal_vector();
        Self { frame: [x, axis.cross(x), axis], cos_min, rows: 20, columns: 40 }
    }

    pub fn sphere() -> Self {
        Self::new(DVec3::Z, -1.0)
    }

    fn bins(&self) -> usize {
        self.rows * self.columns
    }

    /// The bin of a unit direction; none outside the cap.
    fn bin(&self, d: DVec3) -> Option<usize> {
        let [x, y, z] = self.frame.map(|axis| d.dot(axis));
        let (v, u) = ((1.0 - z) / (1.0 - self.cos_min), y.atan2(x) / TAU);
        let row = (v * self.rows as f64).floor();
        let column = ((u - u.floor()) * self.columns as f64).floor() as usize;
        (row < self.rows as f64)
            .then(|| (row.max(0.0) as usize).min(self.rows - 1) * self.columns + column.min(self.columns - 1))
    }

    /// The direction at (v, u) in the unit square.
    fn direction(&self, v: f64, u: f64) -> DVec3 {
        let z = 1.0 - v * (1.0 - self.cos_min);
        let (sin, cos) = (u * TAU).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        self.frame[0] * (r * cos) + self.frame[1] * (r * sin) + self.frame[2] * z
    }

    /// A density's integral over each bin, by the midpoint rule.
    fn integrate(&self, pdf: &dyn Fn(DVec3) -> f64) -> Vec<f64> {
        const POINTS: usize = 16;
        let cell = TAU * (1.0 - self.cos_min) / (self.bins() * POINTS * POINTS) as f64;
        let place = |i: usize, k: usize, n: usize| (i as f64 + (k as f64 + 0.5) / POINTS as f64) / n as f64;
        let bin = |i: usize| {
            let (row, column) = (i / self.columns, i % self.columns);
            let points = (0..POINTS * POINTS).map(|k| {
                pdf(self
                    .direction(place(row, k / POINTS, self.rows), place(column, k % POINTS, self.columns)))
            });
            points.sum::<f64>() * cell
        };
        (0..self.bins()).map(bin).collect()
    }

    /// Tests directions against their density per solid angle. A sample may be none; these, and
    /// directions outside the cap, must be the mass that the density lacks.
    pub fn test(
        &self,
        n: u64,
        mut sample: impl FnMut() -> Option<DVec3>,
        pdf: impl Fn(DVec3) -> f64,
    ) -> ChiSquare {
        let mut observed = vec![0; self.bins() + 1];
        for _ in 0..n {
            let bin = sample().and_then(|d| self.bin(d)).unwrap_or(self.bins());
            observed[bin] += 1;
        }
        let mut masses = self.integrate(&pdf);
        let missing = 1.0 - masses.iter().sum::<f64>();
        assert!(missing >= -MASS_TOLERANCE, "the density's integral is {}", 1.0 - missing);
        // Quadrature leaves a little mass over where nothing is missing.
        if missing.abs() <= MASS_TOLERANCE && observed[self.bins()] == 0 {
            masses.iter_mut().for_each(|mass| *mass /= 1.0 - missing);
            masses.push(0.0);
        } else {
            masses.push(missing.max(0.0));
        }
        let total: f64 = masses.iter().sum();
        let expected: Vec<f64> = masses.iter().map(|mass| mass / total * n as f64).collect();
        ChiSquare::of(&observed, &expected)
    }
}

/// Counts of values in [0, 1) by equal bins.
pub fn histogram(bins: usize, values: impl Iterator<Item = f32>) -> Vec<u64> {
    let mut counts = vec![0; bins];
    for value in values {
        assert!((0.0..1.0).contains(&value), "{value} is outside [0, 1)");
        counts[(f64::from(value) * bins as f64) as usize] += 1;
    }
    counts
}

/// The same of pairs, by a square of `bins` x `bins`.
pub fn histogram2(bins: usize, values: impl Iterator<Item = (f32, f32)>) -> Vec<u64> {
    let mut counts = vec![0; bins * bins];
    let place = |value: f32| {
        assert!((0.0..1.0).contains(&value), "{value} is outside [0, 1)");
        (f64::from(value) * bins as f64) as usize
    };
    for (a, b) in values {
        counts[place(a) * bins + place(b)] += 1;
    }
    counts
}

#[test]
fn chi_square_itself_accepts_and_rejects() {
    assert!(ChiSquare::of(&[98, 102, 100], &[100.0, 100.0, 100.0]).holds());
    ChiSquare::of(&[150, 50, 100], &[100.0, 100.0, 100.0]).assert_rejects("a wrong density");
    ChiSquare::of(&[100, 100, 0], &[100.0, 100.0, 100.0]).assert_rejects("another sum");
    ChiSquare::of(&[1000, 1000, 60], &[1030.0, 1030.0, 0.0]).assert_rejects("samples without density");
    ChiSquare::of(&[100, 100], &[f64::NAN, 100.0]).assert_rejects("NaN");
}
