//! The expected error of a render, from two of them that differ by their seed alone: half the
//! squared difference has the variance of one as its mean, and no reference's noise is in it.

use std::path::Path;

use anyhow::{Result, ensure};
use midway_film::{ExrFile, Image};

/// Keeps relMSE finite where the image is dark, as in `midway compare`.
const RELMSE_EPSILON: f64 = 0.01;
/// The part of the pixels that the trimmed mean leaves out: its worst.
const TRIMMED: f64 = 1e-3;

/// Expected errors of one of two renders.
#[derive(Clone, Copy, Debug, PartialEq)]
struct HalfError {
    /// Root of the mean of (a - b)² / 2.
    rmse: f64,
    /// Mean of (a - b)² / 2 over ((a + b) / 2)² + 0.01.
    relmse: f64,
    /// The same without the worst 0.1 % of the pixels.
    relmse_trimmed: f64,
}

/// Prints the errors of two files as one JSON object.
pub fn run(a: &Path, b: &Path) -> Result<()> {
    let error = half_error(&read(a)?, &read(b)?)?;
    let object = serde_json::json!({
        "rmse": error.rmse, "relmse": error.relmse, "relmse_trimmed": error.relmse_trimmed,
    });
    println!("{object}");
    Ok(())
}

fn read(path: &Path) -> Result<Image> {
    Ok(ExrFile::read(path)?.image()?)
}

fn half_error(a: &Image, b: &Image) -> Result<HalfError> {
    ensure!(a.size() == b.size(), "the images' sizes differ: {:?} and {:?}", a.size(), b.size());
    ensure!(!a.pixels.is_empty(), "the images are empty");
    let all = a.pixels.iter().chain(&b.pixels).flatten();
    ensure!(all.into_iter().all(|value| value.is_finite()), "a pixel is NaN or infinite");
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
    relative.sort_by(f64::total_cmp);
    let kept = ((n as f64 * (1.0 - TRIMMED)) as usize).max(1);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    Ok(HalfError {
        rmse: (squares / n as f64).sqrt(),
        relmse: mean(&relative),
        relmse_trimmed: mean(&relative[..kept]),
    })
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
