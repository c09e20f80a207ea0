//! Independent estimates of an image, and how well they agree with a reference by blocks of pixels.

use std::{
    env,
    sync::{Arc, OnceLock},
};

use midway_device::{Device, DeviceKind, OpenOptions, list_devices, open_device};
use midway_film::Image;
use midway_render::{RenderSettings, Renderer};
use midway_scene::Scene;

use crate::statistics::{Estimate, sidak};

/// Pixels along a block's side: a sum of 64 pixels is close to normal where one pixel is not.
pub const BLOCK: usize = 8;
/// Chance that a correct renderer fails all blocks of an image taken together.
pub const FAMILY_LEVEL: f64 = 1e-3;
/// Standard errors by which the mean over an image may be off: a chance of 4e-4 at 31 degrees of
/// freedom.
pub const MEAN_ERRORS: f64 = 4.0;
/// Relative error of f32 arithmetic along a path (positions, offsets, sums of the film): it counts
/// as a standard error, or closed forms without variance would be held to the last bit.
pub const ROUNDING: f64 = 1e-5;

/// The CPU device.
pub fn cpu() -> Arc<dyn Device> {
    static CPU: OnceLock<Arc<dyn Device>> = OnceLock::new();
    CPU.get_or_init(|| open_device("cpu", &OpenOptions::default()).expect("the CPU device needs nothing"))
        .clone()
}

/// A GPU, real or software; none where there is neither, which is said and, where
/// `MIDWAY_REQUIRE_GPU` is 1, a failure.
pub fn gpu() -> Option<Arc<dyn Device>> {
    static GPU: OnceLock<Option<Arc<dyn Device>>> = OnceLock::new();
    let gpu = GPU.get_or_init(|| {
        let info = list_devices().into_iter().find(|info| info.kind != DeviceKind::Cpu)?;
        Some(open_device(&info.name, &OpenOptions::default()).expect("a listed device opens"))
    });
    if gpu.is_none() {
        println!("the GPU suite did not run: no adapter");
        assert!(env::var("MIDWAY_REQUIRE_GPU").as_deref() != Ok("1"), "MIDWAY_REQUIRE_GPU=1 and no adapter");
    }
    gpu.clone()
}

/// A renderer by the scene's first camera.
pub fn renderer(device: &Arc<dyn Device>, scene: &Scene, settings: &RenderSettings) -> Renderer {
    Renderer::new(device.clone(), scene, &scene.cameras[0], settings.clone()).expect("renders")
}

/// Goes on until `samples` a pixel are done.
pub fn render_until(renderer: &mut Renderer, samples: u64) {
    while renderer.samples() < samples {
        renderer.step(samples - renderer.samples()).expect("renders");
    }
}

/// The image so far; nothing may have been rejected or have overflowed.
pub fn checked_image(renderer: &Renderer) -> Image {
    let stats = renderer.stats().expect("counted");
    assert_eq!(stats.rejected, 0, "rejected samples");
    assert_eq!(stats.overflowed, 0, "overflowed sums");
    renderer.image().expect("resolves")
}

/// Renders `samples` a pixel by the scene's first camera.
pub fn render(device: &Arc<dyn Device>, scene: &Scene, settings: &RenderSettings, samples: u64) -> Image {
    batches(device, scene, settings, 1, samples).remove(0)
}

/// `n` independent images of `samples` a pixel each, by seeds of their own: the samples of one seed
/// are spread evenly, so that one part of them says something of the others.
pub fn batches(
    device: &Arc<dyn Device>,
    scene: &Scene,
    settings: &RenderSettings,
    n: usize,
    samples: u64,
) -> Vec<Image> {
    let mut renderer = renderer(device, scene, settings);
    let mut batch = |number: u32| {
        renderer.restart_with_seed(batch_seed(settings.seed, number)).expect("restarts");
        render_until(&mut renderer, samples);
        checked_image(&renderer)
    };
    (0..n as u32).map(&mut batch).collect()
}

/// Seeds of the batches of one seed; the first is the seed itself.
fn batch_seed(seed: u32, batch: u32) -> u32 {
    seed ^ batch.wrapping_mul(0x9e37_79b9)
}

/// An image of `value(a, b)` for each component of two images of one size.
pub fn combine(a: &Image, b: &Image, value: impl Fn(f64, f64) -> f64) -> Image {
    assert_eq!(a.size(), b.size());
    let mut image = a.clone();
    for (a, b) in image.pixels.iter_mut().flatten().zip(b.pixels.as_flattened()) {
        *a = value(f64::from(*a), f64::from(*b)) as f32;
    }
    image
}

/// What an image should be.
#[derive(Clone, Debug)]
pub struct Expected {
    /// Each pixel's mean.
    pub mean: Image,
    /// The standard error of each, independent of the others'; none where the mean is exact.
    pub standard_error: Option<Image>,
}

/// Estimates of the means over blocks of pixels, each channel by itself, and over all pixels in
/// use and all channels.
#[derive(Clone, Debug)]
pub struct Blocks {
    /// For each block and channel; none where no pixel of the block is in use.
    pub blocks: Vec<Option<Estimate>>,
    /// For everything in use.
    pub whole: Estimate,
}

impl Blocks {
    /// From independent images, over the pixels in use.
    pub fn of_batches(images: &[Image], in_use: &[bool]) -> Self {
        let means: Vec<(Vec<Option<f64>>, f64)> = images.iter().map(|image| means(image, in_use)).collect();
        let estimate = |b: usize| means.iter().map(|(blocks, _)| blocks[b]).collect::<Option<Vec<_>>>();
        Self {
            blocks: (0..means[0].0.len()).map(|b| estimate(b).map(|values| Estimate::of(&values))).collect(),
            whole: Estimate::of(&means.iter().map(|(_, whole)| *whole).collect::<Vec<_>>()),
        }
    }

    /// From what is expected, over the pixels in use.
    pub fn of_expected(expected: &Expected, in_use: &[bool]) -> Self {
        let (blocks, whole) = means(&expected.mean, in_use);
        let count = |pixels: f64, variance: f64| (variance / pixels).sqrt();
        let squares = expected.standard_error.as_ref().map(|error| combine(error, error, |a, b| a * b));
        let (variances, whole_variance) =
            squares.map_or((vec![Some(0.0); blocks.len()], 0.0), |squares| means(&squares, in_use));
        let pixels = pixels_in_blocks(&expected.mean, in_use);
        let all_pixels = 3.0 * in_use.iter().filter(|used| **used).count() as f64;
        let estimate = |mean: f64, random: f64| Estimate::known(mean, random.hypot(ROUNDING * mean));
        Self {
            blocks: (0..blocks.len())
                .map(|b| Some(estimate(blocks[b]?, count(pixels[b / 3], variances[b]?))))
                .collect(),
            whole: estimate(whole, count(all_pixels, whole_variance)),
        }
    }

    /// The index of the block that holds a pixel, first channel.
    pub fn index_of(width: usize, pixel: usize) -> usize {
        let columns = width.div_ceil(BLOCK);
        3 * (pixel / width / BLOCK * columns + pixel % width / BLOCK)
    }
}

fn pixels_in_blocks(image: &Image, in_use: &[bool]) -> Vec<f64> {
    let mut counts = vec![0.0; image.width.div_ceil(BLOCK) * image.height.div_ceil(BLOCK)];
    for pixel in (0..image.pixels.len()).filter(|&pixel| in_use[pixel]) {
        counts[Blocks::index_of(image.width, pixel) / 3] += 1.0;
    }
    counts
}

/// Means over blocks, and over all.
fn means(image: &Image, in_use: &[bool]) -> (Vec<Option<f64>>, f64) {
    assert_eq!(image.pixels.len(), in_use.len());
    let counts = pixels_in_blocks(image, in_use);
    let mut sums = vec![0.0; counts.len() * 3];
    for (pixel, rgb) in image.pixels.iter().enumerate().filter(|(pixel, _)| in_use[*pixel]) {
        let block = Blocks::index_of(image.width, pixel);
        for (sum, value) in sums[block..].iter_mut().zip(rgb) {
            *sum += f64::from(*value);
        }
    }
    let whole = sums.iter().sum::<f64>() / (3.0 * counts.iter().sum::<f64>());
    let mean = |(b, sum): (usize, &f64)| (counts[b / 3] > 0.0).then(|| sum / counts[b / 3]);
    (sums.iter().enumerate().map(mean).collect(), whole)
}

/// How well two sets of block estimates agree.
#[derive(Clone, Copy, Debug)]
pub struct Agreement {
    /// The least p-value over the blocks, by Welch's t-test.
    pub least_p: f64,
    /// The least over those where the first is the brighter.
    pub least_p_above: f64,
    /// The block and channel that has the least (`Blocks::blocks`).
    pub worst: usize,
    /// The ratio of the means of that block.
    pub worst_ratio: f64,
    /// The level that each block is tested at.
    pub level: f64,
    /// The mean over everything in use of the first over that of the second.
    pub ratio: f64,
    /// The standard error of that ratio.
    pub ratio_error: f64,
}

impl Agreement {
    /// Compares two sets of blocks over the same pixels.
    pub fn of(a: &Blocks, b: &Blocks) -> Self {
        let pairs: Vec<(usize, Estimate, Estimate)> = (a.blocks.iter().zip(&b.blocks).enumerate())
            .filter_map(|(index, (a, b))| Some((index, (*a)?, (*b)?)))
            .collect();
        let mut agreement = Self {
            least_p: f64::INFINITY,
            least_p_above: f64::INFINITY,
            worst: 0,
            worst_ratio: 1.0,
            level: sidak(FAMILY_LEVEL, pairs.len()),
            ratio: a.whole.mean / b.whole.mean,
            ratio_error: a.whole.standard_error.hypot(b.whole.standard_error) / b.whole.mean,
        };
        for (index, a, b) in pairs {
            let p = a.p_value(&b);
            // NaN counts as brighter.
            if a.mean.partial_cmp(&b.mean).is_none_or(|order| order.is_gt()) {
                agreement.least_p_above = agreement.least_p_above.min(p);
            }
            if p < agreement.least_p {
                agreement.least_p = p;
                agreement.worst = index;
                agreement.worst_ratio = a.mean / b.mean;
            }
        }
        agreement
    }

    /// No block differs significantly.
    pub fn blocks_agree(&self) -> bool {
        self.least_p >= self.level && self.least_p.is_finite()
    }

    /// The mean is within [`MEAN_ERRORS`] standard errors.
    pub fn means_agree(&self) -> bool {
        (self.ratio - 1.0).abs() <= MEAN_ERRORS * self.ratio_error
    }

    /// The mean is within a relative bound.
    pub fn mean_within(&self, bound: f64) -> bool {
        (self.ratio - 1.0).abs() <= bound
    }

    /// Nothing is significantly brighter. All that can be said of an estimate with a heavy tail: few
    /// samples miss the tail, and look dark and sure of it.
    pub fn nothing_is_brighter(&self) -> bool {
        self.least_p_above >= self.level && self.ratio - 1.0 <= MEAN_ERRORS * self.ratio_error
    }

    /// No block differs significantly, nor does the mean.
    pub fn holds(&self) -> bool {
        self.blocks_agree() && self.means_agree()
    }
}

impl std::fmt::Display for Agreement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (error, standard_error) = (100.0 * (self.ratio - 1.0), 100.0 * self.ratio_error);
        write!(f, "mean {error:+.3} % (standard error {standard_error:.3} %), ")?;
        let (worst, channel) = (self.worst / 3, ["R", "G", "B"][self.worst % 3]);
        let off = 100.0 * (self.worst_ratio - 1.0);
        write!(
            f,
            "worst block {worst} {channel} {off:+.2} %, p {:.1e} (level {:.1e})",
            self.least_p, self.level
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Images about 1, whose pixels differ by up to 10 %.
    fn noisy_images(scale: f32) -> Vec<Image> {
        let mut state = 1u32;
        let mut uniform = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut pixel = |_, _| [0; 3].map(|_| scale * (0.9 + 0.2 * uniform()));
        (0..32).map(|_| Image::from_fn(16, 24, &mut pixel)).collect()
    }

    fn agreement(images: &[Image]) -> Agreement {
        let expected = Expected { mean: Image::filled(16, 24, [1.0; 3]), standard_error: None };
        let in_use = vec![true; 16 * 24];
        Agreement::of(&Blocks::of_batches(images, &in_use), &Blocks::of_expected(&expected, &in_use))
    }

    #[test]
    fn images_of_the_right_mean_agree() {
        let agreement = agreement(&noisy_images(1.0));
        assert!(agreement.holds(), "{agreement}");
    }

    #[test]
    fn images_scaled_by_1_percent_do_not() {
        assert!(!agreement(&noisy_images(1.01)).means_agree());
        assert!(!agreement(&noisy_images(1.01)).blocks_agree());
    }

    #[test]
    fn images_with_nan_or_black_do_not() {
        let mut images = noisy_images(1.0);
        images[3].pixels[5][1] = f32::NAN;
        assert!(!agreement(&images).blocks_agree());
        assert!(!agreement(&images).means_agree());
        assert!(!agreement(&vec![Image::filled(16, 24, [0.0; 3]); 32]).holds());
    }

    #[test]
    fn one_bad_block_is_found() {
        let mut images = noisy_images(1.0);
        for image in &mut images {
            for y in 8..16 {
                for x in 8..16 {
                    image.pixels[y * 16 + x][2] *= 1.02;
                }
            }
        }
        let agreement = agreement(&images);
        assert!(!agreement.blocks_agree());
        assert_eq!(agreement.worst, 3 * 3 + 2);
    }

    #[test]
    fn pixels_out_of_use_do_not_count() {
        let mut images = noisy_images(1.0);
        let mut in_use = vec![true; 16 * 24];
        for i in (0..16 * 24).filter(|i| i % 16 < 8) {
            in_use[i] = false;
            images.iter_mut().for_each(|image| image.pixels[i] = [9.0; 3]);
        }
        let expected = Expected { mean: Image::filled(16, 24, [1.0; 3]), standard_error: None };
        let (a, b) = (Blocks::of_batches(&images, &in_use), Blocks::of_expected(&expected, &in_use));
        assert!(Agreement::of(&a, &b).holds());
        assert_eq!(a.blocks.iter().flatten().count(), 9);
    }
}
