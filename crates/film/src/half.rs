//! The expected error of a render, from two of them that differ by their seed alone: half the
//! squared difference has the variance of one as its mean, and no reference's noise is in it.

use crate::{FilmError, Image, metrics::check_comparable};

/// Keeps relMSE finite where the image is dark, as against a reference.
const RELMSE_EPSILON: f64 = 0.01;
/// The part of the pixels that the trimmed mean leaves out: its worst.
const TRIMMED: f64 = 1e-3;

/// Expected errors of one of two renders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfError {
    /// Root of the mean of (a - b)² / 2.
    pub rmse: f64,
    /// Mean of (a - b)² / 2 over ((a + b) / 2)² + 0.01.
    pub relmse: f64,
    /// The same without the worst 0.1 % of the pixels.
    pub relmse_trimmed: f64,
}

/// The expected error of either of two renders by different seeds.
///
/// # Errors
/// As [`crate::compare`].
pub fn half_error(a: &Image, b: &Image) -> Result<HalfError, FilmError> {
    check_comparable(a, b)?;
    let mut squares = 0.0;
    let mut relative: Vec<f64> = Vec::with_capacity(a.pixels.len());
    for (a, b) in a.pixels.iter().zip(&b.pixels) {
        let mut pixel = 0.0;
        for (a, b) in a.iter().zip(b) {
            let (a, b) = (f64::from(*a), f64::from(*b));
            let (half, mean) = ((a - b).powi(2) / 2.0, (a + b) / 2.0);
            squares += half / 3.0;
            pixel += half / (mean * mean + RELMSE_EPSILON) / 3.0;
        }
        relative.push(pixel);
    }
    let n = relative.len();
    let (relmse, relmse_trimmed) = mean_and_trimmed(relative);
    Ok(HalfError { rmse: (squares / n as f64).sqrt(), relmse, relmse_trimmed })
}

/// The mean of values, and that without the largest 0.1 % of them; there is at least one.
pub fn mean_and_trimmed(mut values: Vec<f64>) -> (f64, f64) {
    values.sort_by(f64::total_cmp);
    let kept = ((values.len() as f64 * (1.0 - TRIMMED)) as usize).max(1);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    (mean(&values), mean(&values[..kept]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        let (a, b) = (Image::filled(4, 4, [0.4; 3]), Image::filled(4, 4, [0.2; 3]));
        let error = half_error(&a, &b).unwrap();
        assert!((error.rmse - 0.02_f64.sqrt()).abs() <= 1e-7);
        assert!((error.relmse - 0.02 / 0.1).abs() <= 1e-6);
        assert!((error.relmse_trimmed - 0.02 / 0.1).abs() <= 1e-6);
    }

    #[test]
    fn must_fail_nan_and_other_sizes() {
        let good = Image::filled(4, 4, [0.4; 3]);
        let mut bad = good.clone();
        bad.pixels[3][1] = f32::NAN;
        assert!(half_error(&good, &bad).is_err());
        assert!(half_error(&good, &Image::filled(4, 5, [0.4; 3])).is_err());
        assert!(half_error(&Image::filled(0, 0, [0.0; 3]), &Image::filled(0, 0, [0.0; 3])).is_err());
    }
}
