//! Layers beside the picture as pictures.

use midway_film::{Image, magma};
use midway_render::Renderer;
use rayon::prelude::*;

use crate::{ViewError, protocol::Layer};

/// Nothing is farther than this in a picture of depths.
const NOTHING: f32 = 1e9;
/// A relative standard error that is shown as white.
const WHITE_NOISE: f32 = 0.5;
/// Added to a pixel's square where errors are divided by it, as relMSE has it.
const EPSILON: f32 = 0.01;

/// A layer's picture in RGBA, by all cores: frames wait for it.
///
/// # Errors
/// If the device fails.
pub fn picture(renderer: &Renderer, layer: Layer) -> Result<Vec<u8>, ViewError> {
    let channels = renderer.channels()?;
    let plane = |name: &str| channels.iter().find(|c| c.name == name).map(|c| c.samples.as_slice());
    let window = renderer.settings().window();
    let n = window.width as usize * window.height as usize;
    let three = |names: [&str; 3]| names.map(|name| plane(name).unwrap_or(&[]));
    let colour: Box<dyn Fn(usize) -> [f32; 3] + Sync> = match layer {
        Layer::Normal => {
            let xyz = three(["normal.X", "normal.Y", "normal.Z"]);
            Box::new(move |i| xyz.map(|p| p.get(i).map_or(0.0, |v| v * 0.5 + 0.5)))
        }
        Layer::Depth => {
            let depth = plane("depth.Z").unwrap_or(&[]);
            let (near, far) = range(depth);
            Box::new(move |i| {
                let seen = depth.get(i).copied().filter(|d| *d < NOTHING);
                [seen.map_or(0.0, |d| 1.0 - 0.9 * (d - near) / (far - near).max(f32::MIN_POSITIVE)); 3]
            })
        }
        Layer::Noise => {
            let errors =
                relative_errors(&renderer.image()?, three(["variance.R", "variance.G", "variance.B"]));
            Box::new(move |i| magma(errors.get(i).map_or(0.0, |e| e.sqrt() / WHITE_NOISE).min(1.0)))
        }
        Layer::Albedo | Layer::Beauty => {
            let rgb = three(["albedo.R", "albedo.G", "albedo.B"]);
            Box::new(move |i| rgb.map(|p| p.get(i).map_or(0.0, |v| v.max(0.0).powf(1.0 / 2.2))))
        }
    };
    let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let mut rgba = vec![255; 4 * n];
    rgba.par_chunks_exact_mut(4).enumerate().for_each(|(i, pixel)| {
        pixel[..3].copy_from_slice(&colour(i).map(byte));
    });
    Ok(rgba)
}

/// Nearest and farthest of what is there.
fn range(depth: &[f32]) -> (f32, f32) {
    let there = depth.iter().copied().filter(|d| *d < NOTHING);
    there.fold((f32::MAX, 0.0), |(near, far), d| (near.min(d), far.max(d)))
}

/// Of each pixel the mean over channels of variance / (value² + 0.01): the error that relMSE expects of
/// it. Infinite after one pass.
pub fn relative_errors(image: &Image, variance: [&[f32]; 3]) -> Vec<f32> {
    let error = |(i, pixel): (usize, &[f32; 3])| {
        let of = |c: usize| variance[c].get(i).map_or(f32::INFINITY, |v| v / (pixel[c] * pixel[c] + EPSILON));
        (of(0) + of(1) + of(2)) / 3.0
    };
    image.pixels.iter().enumerate().map(error).collect()
}

/// The relMSE that is expected of an image of `n` samples, by what it differs by from the image that it
/// was after `n_before` of them: with two halves A and B, ((A - B) / 2)² over the square of the pixel.
/// By Sobol points it is too high, as the halves make up for each other, but less so than by the spread
/// between passes: of the Cornell box by `path` at 64 samples 1.35 times as high, where that is 1.97.
pub fn expected_relmse((image, n): (&Image, u64), (before, n_before): (&Image, u64)) -> f64 {
    // The squared difference is σ² (n - n_before) / (n n_before), the image's own error σ² / n.
    let scale = n_before as f64 / (n - n_before) as f64;
    let error = |(a, b): (&f32, &f32)| {
        let (a, b) = (f64::from(*a), f64::from(*b));
        (a - b) * (a - b) * scale / (a * a + f64::from(EPSILON))
    };
    let values = image.pixels.as_flattened();
    let sum: f64 = values.iter().zip(before.pixels.as_flattened()).map(error).sum();
    sum / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means of independent numbers, cut in halves and in other parts.
    #[test]
    fn two_parts_of_the_samples_tell_the_error() {
        let mut state = 1u32;
        let mut number = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        for (n, n_before) in [(16, 8), (12, 8), (24, 8)] {
            let mut before = Image::filled(64, 64, [0.0; 3]);
            let mut image = before.clone();
            for (sum, first) in image.pixels.iter_mut().flatten().zip(before.pixels.iter_mut().flatten()) {
                let values: Vec<f32> = (0..n).map(|_| number()).collect();
                *first = values[..n_before].iter().sum::<f32>() / n_before as f32;
                *sum = values.iter().sum::<f32>() / n as f32;
            }
            let told = expected_relmse((&image, n as u64), (&before, n_before as u64));
            // Of uniform numbers: variance 1/12, mean 1/2; the square of the pixel varies a little.
            let expected = 1.0 / 12.0 / n as f64 / (0.25 + 0.01);
            assert!((told / expected - 1.0).abs() <= 0.1, "{n}: {told} {expected}");
        }
    }

    #[test]
    fn errors_are_relative_to_the_pixel() {
        let image = Image::filled(2, 1, [3.0, 0.0, 1.0]);
        let variance = [0.901, 0.01, 0.0];
        let planes = variance.map(|v| [v, v]);
        let errors = relative_errors(&image, [&planes[0], &planes[1], &planes[2]]);
        assert!((errors[0] - (0.1 + 1.0) / 3.0).abs() <= 1e-5, "{errors:?}");
        assert!(relative_errors(&image, [&[], &[], &[]])[0].is_infinite());
    }
}
