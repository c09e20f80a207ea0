//! Numbers for how far a test image is from a reference.

use crate::{DEFAULT_PIXELS_PER_DEGREE, FilmError, Image, flip};

/// Keeps relMSE finite where the reference is dark.
const RELMSE_EPSILON: f64 = 0.01;

/// What [`compare`] found. Means are over all pixels and channels, summed in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Mean absolute error.
    pub mae: f64,
    /// Root of the mean squared error.
    pub rmse: f64,
    /// Mean of (test - reference)² / (reference² + 0.01).
    pub relmse: f64,
    /// Mean of the FLIP error map of the images clipped to the display's range, in [0, 1].
    pub flip: f64,
    /// Mean of the test over mean of the reference, per channel. 1 where both are 0; infinite
    /// where only the reference is.
    pub mean_ratio: [f64; 3],
    /// Of the ratios of means over blocks of 16 x 16 pixels, each channel by itself: the tenth
    /// percentile, the median and the ninetieth. Fireflies and the few blocks where two renderers
    /// disagree do not move the median. Blocks darker than a thousandth of the mean do not count; 1
    /// where none does.
    pub block_ratio: [f64; 3],
}

/// Compares a test image with a reference.
///
/// # Errors
/// [`FilmError::SizeMismatch`], [`FilmError::BadShape`], and [`FilmError::NotFinite`] if any pixel
/// of either is NaN or infinite: there is no result that could pass a `<=`.
pub fn compare(test: &Image, reference: &Image) -> Result<Comparison, FilmError> {
    let (rmse, relmse) = rmse_and_relmse(test, reference)?;
    let mae = mean_over_values(test, reference, |a, b| (a - b).abs());
    let map = flip(test, reference, DEFAULT_PIXELS_PER_DEGREE)?;
    let flip = map.iter().map(|error| f64::from(*error)).sum::<f64>() / map.len() as f64;
    let (a, b) = (test.mean(), reference.mean());
    let mean_ratio = [0, 1, 2].map(|i| ratio(a[i], b[i]));
    Ok(Comparison { mae, rmse, relmse, flip, mean_ratio, block_ratio: block_ratio(test, reference) })
}

/// The two numbers of an error log, without the cost of FLIP.
///
/// # Errors
/// As [`compare`].
pub fn rmse_and_relmse(test: &Image, reference: &Image) -> Result<(f64, f64), FilmError> {
    check_comparable(test, reference)?;
    let mse = mean_over_values(test, reference, |a, b| (a - b) * (a - b));
    let relmse = mean_over_values(test, reference, relative_square);
    Ok((mse.sqrt(), relmse))
}

/// The relative error of each pixel: the root of its mean (a - b)² / (b² + 0.01).
///
/// # Errors
/// As [`compare`].
pub fn relative_error(test: &Image, reference: &Image) -> Result<Vec<f32>, FilmError> {
    check_comparable(test, reference)?;
    let pairs = test.pixels.iter().zip(&reference.pixels);
    Ok(pairs
        .map(|(a, b)| {
            let sum: f64 = (0..3).map(|i| relative_square(a[i].into(), b[i].into())).sum();
            (sum / 3.0).sqrt() as f32
        })
        .collect())
}

/// Pixels along a block's side.
const BLOCK: usize = 16;
/// Blocks darker than this share of the reference's mean do not count.
const DARK_BLOCK: f64 = 1e-3;

/// [`Comparison::block_ratio`].
fn block_ratio(test: &Image, reference: &Image) -> [f64; 3] {
    let means = |image: &Image| image.block_means(BLOCK);
    let (a, b) = (means(test), means(reference));
    let least = DARK_BLOCK * reference.mean().iter().sum::<f64>() / 3.0;
    let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let mut ratios: Vec<f64> = pairs
        .map(|(a, b)| (f64::from(*a), f64::from(*b)))
        .filter(|(_, b)| *b > least)
        .map(|(a, b)| a / b)
        .collect();
    ratios.sort_by(f64::total_cmp);
    [0.1, 0.5, 0.9].map(|p| {
        let last = ratios.len().saturating_sub(1) as f64;
        ratios.get((p * last).round() as usize).copied().unwrap_or(1.0)
    })
}

/// Fails unless both images are whole, of one size and finite.
pub(crate) fn check_comparable(test: &Image, reference: &Image) -> Result<(), FilmError> {
    test.check_shape()?;
    reference.check_shape()?;
    if test.size() != reference.size() {
        return Err(FilmError::SizeMismatch(test.size(), reference.size()));
    }
    check_finite("test", test)?;
    check_finite("reference", reference)
}

fn check_finite(which: &'static str, image: &Image) -> Result<(), FilmError> {
    let is_bad = |pixel: &[f32; 3]| !pixel.iter().all(|value| value.is_finite());
    let Some(first) = image.pixels.iter().position(is_bad) else {
        return Ok(());
    };
    let count = image.pixels.iter().filter(|pixel| is_bad(pixel)).count();
    Err(FilmError::NotFinite { which, count, x: first % image.width, y: first / image.width })
}

fn relative_square(a: f64, b: f64) -> f64 {
    (a - b) * (a - b) / (b * b + RELMSE_EPSILON)
}

fn mean_over_values(test: &Image, reference: &Image, f: impl Fn(f64, f64) -> f64) -> f64 {
    let pairs = test.pixels.as_flattened().iter().zip(reference.pixels.as_flattened());
    let sum: f64 = pairs.map(|(a, b)| f((*a).into(), (*b).into())).sum();
    sum / (3 * test.pixels.len()) as f64
}

fn ratio(a: f64, b: f64) -> f64 {
    if a == 0.0 && b == 0.0 { 1.0 } else { a / b }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Colourful, dark to bright, no two channels alike.
    fn picture() -> Image {
        Image::from_fn(48, 32, |x, y| {
            let (u, v) = (x as f32 / 48.0, y as f32 / 32.0);
            [0.9 * u + 0.05, 0.5 * v * v + 0.02, 0.3 * (1.0 - u) * v + 0.01]
        })
    }

    /// What a test of a renderer would demand: 0.5 % on the means, little error.
    fn passes(test: &Image, reference: &Image) -> bool {
        compare(test, reference).is_ok_and(|errors| {
            errors.relmse <= 1e-4
                && errors.flip <= 0.01
                && errors.mean_ratio.iter().all(|ratio| (ratio - 1.0).abs() <= 0.005)
        })
    }

    #[test]
    fn equal_images_have_no_error() {
        let errors = compare(&picture(), &picture()).unwrap();
        let zero = Comparison {
            mae: 0.0,
            rmse: 0.0,
            relmse: 0.0,
            flip: 0.0,
            mean_ratio: [1.0; 3],
            block_ratio: [1.0; 3],
        };
        assert_eq!(errors, zero);
        assert!(passes(&picture(), &picture()));
    }

    #[test]
    fn known_values() {
        let reference = Image::filled(4, 4, [0.3, 0.0, 0.0]);
        let test = Image::filled(4, 4, [0.4, 0.0, 0.1]);
        let errors = compare(&test, &reference).unwrap();
        assert!((errors.mae - 0.2 / 3.0).abs() <= 1e-7);
        assert!((errors.rmse - (0.02_f64 / 3.0).sqrt()).abs() <= 1e-7);
        assert!((errors.relmse - (0.01 / 0.1 + 0.01 / 0.01) / 3.0).abs() <= 1e-6);
        assert!((errors.mean_ratio[0] - 4.0 / 3.0).abs() <= 1e-6);
        assert_eq!(errors.mean_ratio[1], 1.0);
        assert_eq!(errors.mean_ratio[2], f64::INFINITY);
        let relative = relative_error(&test, &reference).unwrap();
        assert!((f64::from(relative[7]).powi(2) - errors.relmse).abs() <= 1e-6);
    }

    #[test]
    fn one_bad_block_moves_no_median() {
        let mut test = picture();
        for pixel in test.pixels.iter_mut() {
            *pixel = pixel.map(|value| value * 1.02);
        }
        for y in 0..16 {
            test.pixels[y * 48..y * 48 + 16].fill([50.0; 3]);
        }
        let [low, median, high] = compare(&test, &picture()).unwrap().block_ratio;
        assert!((low - 1.02).abs() <= 1e-5 && (median - 1.02).abs() <= 1e-5, "{low} {median}");
        assert!(high > 10.0, "{high}");
        assert_eq!(block_ratio(&picture(), &Image::filled(48, 32, [0.0; 3])), [1.0; 3]);
    }

    #[test]
    fn must_fail_nan_and_infinity() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut test = picture();
            test.pixels[48 * 3 + 7][1] = bad;
            assert!(!passes(&test, &picture()));
            assert!(!passes(&picture(), &test));
            let error = compare(&test, &picture()).unwrap_err();
            assert!(matches!(error, FilmError::NotFinite { which: "test", count: 1, x: 7, y: 3 }));
            assert!(rmse_and_relmse(&picture(), &test).is_err());
            assert!(relative_error(&test, &picture()).is_err());
        }
    }

    #[test]
    fn must_fail_all_black() {
        let black = Image::filled(48, 32, [0.0; 3]);
        assert!(!passes(&black, &picture()));
        assert!(!passes(&picture(), &black));
    }

    #[test]
    fn must_fail_other_size() {
        let cut = Image::from_fn(48, 31, |x, y| picture().pixels[y * 48 + x]);
        assert!(matches!(compare(&cut, &picture()), Err(FilmError::SizeMismatch([48, 31], [48, 32]))));
        let truncated = Image { pixels: picture().pixels[..1000].to_vec(), ..picture() };
        assert!(matches!(compare(&truncated, &picture()), Err(FilmError::BadShape { .. })));
        let empty = Image::filled(0, 0, [0.0; 3]);
        assert!(compare(&empty, &empty).is_err());
    }

    #[test]
    fn must_fail_swapped_channels() {
        let mut test = picture();
        test.pixels.iter_mut().for_each(|pixel| pixel.swap(0, 2));
        assert!(!passes(&test, &picture()));
    }

    #[test]
    fn must_fail_scaled_by_one_percent() {
        for factor in [0.99_f32, 1.01] {
            let mut test = picture();
            test.pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(|value| value * factor));
            assert!(!passes(&test, &picture()));
            let errors = compare(&test, &picture()).unwrap();
            assert!((errors.mean_ratio[1] - f64::from(factor)).abs() <= 1e-5);
        }
    }

    #[test]
    fn must_fail_shifted_by_a_pixel() {
        let test = Image::from_fn(48, 32, |x, y| picture().pixels[y * 48 + (x + 1) % 48]);
        assert!(!passes(&test, &picture()));
    }

    #[test]
    fn huge_values_do_not_overflow() {
        let reference = Image::filled(2, 2, [f32::MAX; 3]);
        let test = Image::filled(2, 2, [-f32::MAX; 3]);
        let errors = compare(&test, &reference).unwrap();
        assert!(errors.rmse.is_finite() && errors.rmse > 1e38);
    }
}
