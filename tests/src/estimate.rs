//! Independent estimates of an image, and their agreement with a reference by blocks of pixels.

use std::{
    env,
    sync::{Arc, OnceLock},
};

use midway_device::{Device, DeviceKind, OpenOptions, list_devices, open_device};
use midway_film::Image;
use midway_render::{RenderSettings, Renderer};
use midway_scene::Scene;

use crate::statistics::{Estimate, sidak};

/// Pixels along a block's side.
pub const BLOCK: usize = 8;
/// Chance that a correct renderer fails a whole image.
pub const FAMILY_LEVEL: f64 = 1e-3;

/// The CPU device.
pub fn cpu() -> Arc<dyn Device> {
    static CPU: OnceLock<Arc<dyn Device>> = OnceLock::new();
    CPU.get_or_init(|| open_device("cpu", &OpenOptions::default()).expect("the CPU device needs nothing")).clone()
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

/// Renders `samples` a pixel by the scene's first camera.
pub fn render(device: &Arc<dyn Device>, scene: &Scene, settings: &RenderSettings, samples: u64) -> Image {
    batches(device, scene, settings, 1, samples).remove(0)
}

/// `n` independent images of `samples` a pixel each: consecutive samples of one sequence.
pub fn batches(
    device: &Arc<dyn Device>,
    scene: &Scene,
    settings: &RenderSettings,
    n: usize,
    samples: u64,
) -> Vec<Image> {
    let mut images = Vec::with_capacity(n);
    let mut renderer =
        Renderer::new(device.clone(), scene, &scene.cameras[0], settings.clone()).expect("renders");
    let mut sum_before: Option<Image> = None;
    for batch in 1..=n as u64 {
        while renderer.samples() < batch * samples {
            renderer.step(batch * samples - renderer.samples()).expect("renders");
        }
        let mean = renderer.image().expect("resolves");
        images.push(difference(&mean, sum_before.as_ref(), batch));
        sum_before = Some(mean);
    }
    let stats = renderer.stats().expect("counted");
    assert_eq!(stats.rejected, 0, "rejected samples");
    assert_eq!(stats.overflowed, 0, "overflowed sums");
    images
}

/// The last batch alone, from the mean of `n` batches and that of the `n - 1` before.
fn difference(mean: &Image, before: Option<&Image>, n: u64) -> Image {
    let Some(before) = before else { return mean.clone() };
    let (n, mut image) = (n as f64, mean.clone());
    for (pixel, old) in image.pixels.iter_mut().zip(&before.pixels) {
        for (value, old) in pixel.iter_mut().zip(old) {
            *value = (f64::from(*value) * n - f64::from(*old) * (n - 1.0)) as f32;
        }
    }
    image
}

/// Means over blocks of pixels, three channels each.
pub fn block_means(image: &Image) -> Vec<f64> {
    let (columns, rows) = (image.width.div_ceil(BLOCK), image.height.div_ceil(BLOCK));
    let mut sums = vec![(0.0, 0.0); columns * rows * 3];
    for (i, pixel) in image.pixels.iter().enumerate() {
        let block = (i / image.width / BLOCK) * columns + i % image.width / BLOCK;
        for (channel, value) in pixel.iter().enumerate() {
            let (sum, n) = &mut sums[block * 3 + channel];
            *sum += f64::from(*value);
            *n += 1.0;
        }
    }
    sums.into_iter().map(|(sum, n)| sum / n).collect()
}

/// Estimates of each block's mean from independent images.
pub fn block_estimates(images: &[Image]) -> Vec<Estimate> {
    let means: Vec<Vec<f64>> = images.iter().map(block_means).collect();
    (0..means[0].len()).map(|b| Estimate::of(&means.iter().map(|m| m[b]).collect::<Vec<_>>())).collect()
}

/// How well two sets of block estimates agree.
#[derive(Clone, Copy, Debug)]
pub struct Agreement {
    /// The least p-value over the blocks.
    pub least_p: f64,
    /// The level that each block is tested at.
    pub level: f64,
    /// The mean over all blocks of the first over that of the second.
    pub ratio: f64,
    /// The standard error of that ratio.
    pub ratio_error: f64,
}

impl Agreement {
    /// Compares blocks in use (`mask`), weighing all alike.
    pub fn of(a: &[Estimate], b: &[Estimate], mask: impl Fn(usize) -> bool) -> Self {
        let pairs: Vec<(&Estimate, &Estimate)> =
            a.iter().zip(b).enumerate().filter(|(i, _)| mask(*i)).map(|(_, pair)| pair).collect();
        let least_p = pairs.iter().map(|(a, b)| a.p_value(b)).fold(f64::INFINITY, f64::min);
        let sum = |f: &dyn Fn(&(&Estimate, &Estimate)) -> f64| pairs.iter().map(f).sum::<f64>();
        let (sum_a, sum_b) = (sum(&|p| p.0.mean), sum(&|p| p.1.mean));
        let variance = sum(&|p| p.0.standard_error.powi(2) + p.1.standard_error.powi(2));
        Self {
            least_p,
            level: sidak(FAMILY_LEVEL, pairs.len()),
            ratio: sum_a / sum_b,
            ratio_error: variance.sqrt() / sum_b,
        }
    }

    /// No block differs significantly, and the mean is within 4 standard errors.
    pub fn holds(&self) -> bool {
        self.least_p >= self.level && (self.ratio - 1.0).abs() <= 4.0 * self.ratio_error
    }
}
