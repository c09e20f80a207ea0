//! LDR-FLIP: how visible the differences between two images are when one flips between them.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference
//! Evaluator for Alternating Images", HPG 2020; equation numbers below are that paper's. Filters
//! are applied separably, as in the authors' own code (their note "Separated convolutions"), with
//! which the tests agree. Written in Rust so that the project needs no C++ compiler.

use std::f32::consts::PI;

use crate::{
    FilmError, Image,
    metrics::check_comparable,
    tone_map::{linear_from_srgb, srgb_from_linear, transform},
};

/// A 0.7 m wide 4K monitor seen from 0.7 m, the paper's default.
pub const DEFAULT_PIXELS_PER_DEGREE: f32 = 67.020_64;

/// Exponent of the colour difference, q_c.
const COLOUR_EXPONENT: f32 = 0.7;
/// The fraction p_c of the largest colour difference that maps to p_t (eq. 12).
const KNEE_IN: f32 = 0.4;
/// p_t (eq. 12).
const KNEE_OUT: f32 = 0.95;
/// Width w of the feature detectors, in degrees.
const FEATURE_WIDTH: f32 = 0.082;
/// Exponent of the feature difference, q_f.
const FEATURE_EXPONENT: f32 = 0.5;

/// `(a, b)` of the contrast sensitivity Gaussians (table 1): achromatic, red-green, and the two of
/// blue-yellow.
const SENSITIVITY: [(f32, f32); 4] = [(1.0, 0.0047), (1.0, 0.0053), (34.1, 0.04), (13.5, 0.025)];

/// White under D65, of [`XYZ_FROM_RGB`].
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [0.412_386_56, 0.357_591_5, 0.180_450_49],
    [0.212_636_82, 0.715_183, 0.072_180_2],
    [0.019_330_62, 0.119_197_16, 0.950_372_6],
];
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_399, -0.498_615_86],
    [-0.969_224_33, 1.875_930_1, 0.041_554_224],
    [0.055_639_423, -0.204_011_2, 1.057_149],
];

/// The error map, one value in [0, 1] a pixel. The images are linear and are clipped to the
/// display's range.
///
/// # Errors
/// As [`crate::compare`].
pub fn flip(test: &Image, reference: &Image, pixels_per_degree: f32) -> Result<Vec<f32>, FilmError> {
    check_comparable(test, reference)?;
    let (test, reference) = (Opponent::new(test), Opponent::new(reference));
    let colour = colour_difference(&test, &reference, pixels_per_degree);
    let feature = feature_difference(&test, &reference, pixels_per_degree);
    // Eq. 17: a difference in edges or points makes the colour difference count more.
    Ok(colour.iter().zip(feature).map(|(colour, feature)| colour.powf(1.0 - feature)).collect())
}

/// A grey plane with its size.
struct Plane {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

/// An image in the linear opponent space Y Cx Cz.
struct Opponent([Plane; 3]);

impl Opponent {
    fn new(image: &Image) -> Self {
        let pixels: Vec<[f32; 3]> = image.pixels.iter().map(|pixel| opponent(*pixel)).collect();
        Self([0, 1, 2].map(|channel| Plane {
            width: image.width,
            height: image.height,
            values: pixels.iter().map(|pixel| pixel[channel]).collect(),
        }))
    }
}

fn opponent(linear: [f32; 3]) -> [f32; 3] {
    // Through the transfer curve and back, as a display would be given it.
    let shown = linear.map(|value| linear_from_srgb(srgb_from_linear(value.clamp(0.0, 1.0))));
    let [x, y, z] = relative_xyz(shown);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn relative_xyz(rgb: [f32; 3]) -> [f32; 3] {
    let xyz = transform(&XYZ_FROM_RGB, rgb);
    [xyz[0] / WHITE[0], xyz[1] / WHITE[1], xyz[2] / WHITE[2]]
}

/// Section 4.1: filter by contrast sensitivity, then HyAB distance in Hunt-adjusted CIELAB.
fn colour_difference(test: &Opponent, reference: &Opponent, pixels_per_degree: f32) -> Vec<f32> {
    // Three standard deviations of the widest Gaussian.
    let widest = SENSITIVITY.iter().map(|(_, b)| *b).fold(0.0, f32::max);
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as isize;
    let gaussian = |(a, b): (f32, f32)| -> Vec<f32> {
        let taps = (-radius..=radius).map(|x| {
            let degrees = x as f32 / pixels_per_degree;
            (a * (PI / b).sqrt()).sqrt() * (-PI * PI * degrees * degrees / b).exp()
        });
        taps.collect()
    };
    let mut taps = SENSITIVITY.map(gaussian);
    normalise(&mut taps[0], 1.0);
    normalise(&mut taps[1], 1.0);
    // The blue-yellow filter is the sum of two separable ones: together they sum to 1.
    let sums = [2, 3].map(|i| taps[i].iter().sum::<f32>());
    let norm = (sums[0] * sums[0] + sums[1] * sums[1]).sqrt();
    normalise(&mut taps[2], sums[0] / norm);
    normalise(&mut taps[3], sums[1] / norm);

    let largest = largest_distance();
    let (a, b) = (perceived(test, &taps), perceived(reference, &taps));
    a.iter().zip(&b).map(|(a, b)| remap(hyab(*a, *b).powf(COLOUR_EXPONENT), largest)).collect()
}

fn normalise(taps: &mut [f32], sum: f32) {
    let factor = sum / taps.iter().sum::<f32>();
    taps.iter_mut().for_each(|tap| *tap *= factor);
}

/// The filtered image in Hunt-adjusted CIELAB.
fn perceived(image: &Opponent, taps: &[Vec<f32>; 4]) -> Vec<[f32; 3]> {
    let [y, cx, cz] = &image.0;
    let filtered = [
        convolve(y, &taps[0], &taps[0]),
        convolve(cx, &taps[1], &taps[1]),
        convolve(cz, &taps[2], &taps[2]),
        convolve(cz, &taps[3], &taps[3]),
    ];
    let colour = |i: usize| [filtered[0][i], filtered[1][i], filtered[2][i] + filtered[3][i]];
    (0..y.values.len()).map(|i| hunt_lab(displayable(colour(i)))).collect()
}

/// Back to linear RGB, clipped to the display's gamut.
fn displayable([y, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (y + 16.0) / 116.0;
    let xyz = [(y + cx / 500.0) * WHITE[0], y * WHITE[1], (y - cz / 200.0) * WHITE[2]];
    transform(&RGB_FROM_XYZ, xyz).map(|value| value.clamp(0.0, 1.0))
}

fn hunt_lab(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z] = relative_xyz(rgb)
        .map(|t| if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 });
    let lightness = 116.0 * y - 16.0;
    // Hunt: colours look more saturated where it is bright (eq. 9).
    let hunt = 0.01 * lightness;
    [lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)]
}

/// Eq. 10: city block in lightness, Euclidean in chroma.
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// The largest colour difference there is: between green and blue.
fn largest_distance() -> f32 {
    hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(COLOUR_EXPONENT)
}

/// Eq. 12: two straight pieces into [0, 1], so that large differences do not drown small ones.
fn remap(difference: f32, largest: f32) -> f32 {
    let knee = KNEE_IN * largest;
    if difference < knee {
        difference * KNEE_OUT / knee
    } else {
        KNEE_OUT + (difference - knee) / (largest - knee) * (1.0 - KNEE_OUT)
    }
}

/// Section 4.2: differences between the edges and between the points of the two images.
fn feature_difference(test: &Opponent, reference: &Opponent, pixels_per_degree: f32) -> Vec<f32> {
    let taps = FeatureTaps::new(0.5 * FEATURE_WIDTH * pixels_per_degree);
    let (a, b) = (features(&test.0[0], &taps), features(&reference.0[0], &taps));
    a.iter()
        .zip(&b)
        .map(|(a, b)| {
            let larger = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
            (larger / 2.0_f32.sqrt()).powf(FEATURE_EXPONENT)
        })
        .collect()
}

/// A Gaussian and its derivatives, whose positive and negative taps each sum to 1.
struct FeatureTaps {
    gaussian: Vec<f32>,
    edge: Vec<f32>,
    point: Vec<f32>,
}

impl FeatureTaps {
    fn new(deviation: f32) -> Self {
        let radius = (3.0 * deviation).ceil() as isize;
        let taps = |weight: fn(f32, f32) -> f32| -> Vec<f32> {
            let raw = (-radius..=radius).map(|x| {
                let (x, variance) = (x as f32, deviation * deviation);
                weight(x, variance) * (-x * x / (2.0 * variance)).exp()
            });
            raw.collect()
        };
        let mut gaussian = taps(|_, _| 1.0);
        normalise(&mut gaussian, 1.0);
        let edge = balanced(taps(|x, _| -x));
        let point = balanced(taps(|x, variance| x * x / variance - 1.0));
        Self { gaussian, edge, point }
    }
}

fn balanced(mut taps: Vec<f32>) -> Vec<f32> {
    let positive: f32 = taps.iter().filter(|tap| **tap > 0.0).sum();
    let negative: f32 = -taps.iter().filter(|tap| **tap < 0.0).sum::<f32>();
    for tap in &mut taps {
        *tap /= if *tap > 0.0 { positive } else { negative };
    }
    taps
}

/// The strength of edges and of points at each pixel of the achromatic plane.
fn features(y: &Plane, taps: &FeatureTaps) -> Vec<[f32; 2]> {
    let grey = Plane { values: y.values.iter().map(|y| (y + 16.0) / 116.0).collect(), ..*y };
    let magnitude = |derivative: &[f32]| -> Vec<f32> {
        let along_x = convolve(&grey, derivative, &taps.gaussian);
        let along_y = convolve(&grey, &taps.gaussian, derivative);
        along_x.iter().zip(along_y).map(|(x, y)| x.hypot(y)).collect()
    };
    magnitude(&taps.edge).into_iter().zip(magnitude(&taps.point)).map(|(edge, point)| [edge, point]).collect()
}

/// Filters by `along_x` and then by `along_y`, of equal odd length; the border is repeated.
fn convolve(plane: &Plane, along_x: &[f32], along_y: &[f32]) -> Vec<f32> {
    let (width, height) = (plane.width, plane.height);
    let radius = along_x.len() / 2;
    let clamped = |at: usize, tap: usize, limit: usize| (at + tap).saturating_sub(radius).min(limit - 1);
    let mut rows = vec![0.0_f32; plane.values.len()];
    for (row, out) in plane.values.chunks_exact(width).zip(rows.chunks_exact_mut(width)) {
        for (x, sum) in out.iter_mut().enumerate() {
            *sum = along_x.iter().enumerate().map(|(tap, w)| w * row[clamped(x, tap, width)]).sum();
        }
    }
    let mut result = vec![0.0_f32; plane.values.len()];
    for (y, out) in result.chunks_exact_mut(width).enumerate() {
        for (tap, weight) in along_y.iter().enumerate() {
            let row = &rows[clamped(y, tap, height) * width..][..width];
            out.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
        }
    }
    result
}

#[cfg(test)]
#[path = "flip_tests.rs"]
mod tests;
