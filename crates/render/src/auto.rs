//! The integrator `auto`: of a few settings the one that has the least error for the same work on
//! this scene, by a warm-up of small images.
//!
//! Variance times cost is what decides, as in efficiency-aware multiple importance sampling (Grittmann
//! et al. 2022), for whole images. Work is counted in rays, not in seconds, and the warm-up has seeds of
//! its own: the same scene makes the same choice on every run of a device, for every seed and every crop,
//! so that images are the same bits, and parts of one image that are rendered apart fit together. The
//! warm-up's samples are not used again: what was chosen by them would favour images that happen to lack
//! rare bright paths.

use std::fmt::Write as _;

use midway_device::DeviceKind;
use midway_film::{Image, mean_and_trimmed};

use crate::{Integrator, IntegratorSettings, Join, RenderError, RenderSettings, Renderer};

/// Pixels of the warm-up's images at most: fewer do not find what a caustic of few pixels costs, more
/// cost a device without a GPU more than they are worth.
const fn n_pixels(kind: DeviceKind) -> f64 {
    match kind {
        DeviceKind::Gpu => 4096.0,
        DeviceKind::Cpu | DeviceKind::SoftwareGpu => 1024.0,
    }
}

/// Samples of a pixel in each of the two images of a candidate: as many as it takes for points that are
/// spread evenly to be worth to each what they will be. `path` gains more by them than `bdpt`.
const SAMPLES: u64 = 32;
/// Their seeds.
const SEEDS: [u32; 2] = [0x5eed_a070, 0x5eed_a071];
/// Pixels along the side of a block in which light is missed or found.
const BLOCK: usize = 8;
/// So much worse than path that no variant of full is better than path by what trying them takes: by equal
/// time k-step 1 had 0.94 of the relMSE of full where it won by most.
const FAR_BEHIND: f64 = 1.15;
/// Keeps relative errors finite where the image is dark, as in relMSE.
const EPSILON: f64 = 0.01;
/// How long a ray of `bdpt` takes, for what is computed at its ends, against a ray of `path`. On a GPU (H100) 1.24
/// to 1.5 times by `full`, in boxes as in Sponza, and 1.23 to 1.37 by k-step 1. On two cores 1.3 times.
fn bdpt_ray_cost(kind: DeviceKind, integrator: &IntegratorSettings) -> f64 {
    let has_one_join = integrator.joins() == Some(Join::KStep) && integrator.k == 1;
    match kind {
        DeviceKind::Gpu if !has_one_join => 1.4,
        DeviceKind::Gpu | DeviceKind::Cpu | DeviceKind::SoftwareGpu => 1.3,
    }
}

/// What the warm-up found out about one integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The integrator with its options.
    pub integrator: IntegratorSettings,
    /// relMSE of one sample a pixel, relative to the means of blocks, without the worst 0.1 % of the pixels.
    pub relmse: f64,
    /// Work of one sample of a pixel, in rays of `path`.
    pub work: f64,
}

impl Candidate {
    /// Error times work: how long it takes to a given error, relative to others.
    pub fn inefficiency(&self) -> f64 {
        self.relmse * self.work
    }

    fn name(&self) -> String {
        let integrator = &self.integrator;
        match (integrator.joins(), integrator.uses_splat()) {
            (None, _) => "path".to_owned(),
            (Some(Join::KStep), _) => format!("k-step {}", integrator.k),
            (Some(_), true) => "full".to_owned(),
            (Some(_), false) => "full without splats".to_owned(),
        }
    }
}

/// The integrator chosen, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The best first.
    pub candidates: Vec<Candidate>,
}

impl Choice {
    /// The best of the candidates, of which there is at least one; the first of equals.
    pub fn of(mut candidates: Vec<Candidate>) -> Self {
        candidates.sort_by(|a, b| a.inefficiency().total_cmp(&b.inefficiency()));
        Self { candidates }
    }

    /// What to render with.
    pub fn integrator(&self) -> IntegratorSettings {
        self.candidates[0].integrator
    }

    /// Who was compared, with error times work relative to the best: `full 1.00, k-step 3 1.06, …`.
    pub fn describe(&self) -> String {
        let best = self.candidates[0].inefficiency().max(f64::MIN_POSITIVE);
        let mut text = String::new();
        for candidate in &self.candidates {
            let separator = if text.is_empty() { "" } else { ", " };
            let ratio = candidate.inefficiency() / best;
            let _ = write!(text, "{separator}{} {ratio:.2}", candidate.name());
        }
        text
    }
}

/// Who is compared first, path and full; all that are compared converge to the same image.
fn candidates(like: &IntegratorSettings) -> [IntegratorSettings; 2] {
    let full = IntegratorSettings { integrator: Integrator::Bdpt, mis: like.mis, ..Default::default() };
    [IntegratorSettings { integrator: Integrator::Path, ..full }, full]
}

/// Who is compared besides, where full is not far behind path.
fn variants(full: IntegratorSettings) -> [IntegratorSettings; 3] {
    let k_step = |k| IntegratorSettings { join: Join::KStep, k, ..full };
    [k_step(1), k_step(3), IntegratorSettings { splat: Some(false), ..full }]
}

/// Two independent images of one candidate, and the work of a sample.
struct WarmUp {
    integrator: IntegratorSettings,
    images: [Image; 2],
    work: f64,
}

/// Compares the candidates on a renderer's scene. Of its settings all but the integrator, the crop, the
/// seed and the layers count; of the integrator its heuristic.
///
/// # Errors
/// If the device fails or has no room for small images beside the renderer.
pub fn choose(renderer: &Renderer) -> Result<Choice, RenderError> {
    let small = small_settings(renderer.settings(), n_pixels(renderer.device().info().kind));
    let warm_up = |integrator| warm_up(renderer.beside(RenderSettings { integrator, ..small.clone() })?);
    let [path, full] = candidates(&small.integrator);
    let mut warm_ups = vec![warm_up(path)?, warm_up(full)?];
    let first = judge(&warm_ups);
    if first[1].inefficiency() > FAR_BEHIND * first[0].inefficiency() {
        return Ok(Choice::of(first));
    }
    for variant in variants(full) {
        warm_ups.push(warm_up(variant)?);
    }
    Ok(Choice::of(judge(&warm_ups)))
}

/// The settings by which [`choose`], beside a renderer of `settings`, and a render by its choice need all the
/// kernels that they need: for compiling them early.
pub fn settings_ahead(settings: &RenderSettings) -> Vec<RenderSettings> {
    let warm_up = RenderSettings { light_groups: false, ..settings.clone() };
    let by_each = |settings: RenderSettings| {
        let by = |integrator| RenderSettings { integrator, ..settings.clone() };
        candidates(&settings.integrator).map(by)
    };
    [settings.clone(), warm_up].into_iter().flat_map(by_each).collect()
}

/// The whole film with fewer pixels: the variance of a sample hardly depends on a pixel's size.
fn small_settings(settings: &RenderSettings, n_pixels: f64) -> RenderSettings {
    let scale = (n_pixels / (f64::from(settings.width) * f64::from(settings.height))).sqrt().min(1.0);
    let side = |side: u32| ((f64::from(side) * scale).round() as u32).max(1);
    RenderSettings {
        width: side(settings.width),
        height: side(settings.height),
        crop: None,
        aovs: Vec::new(),
        light_groups: false,
        ..settings.clone()
    }
}

fn warm_up(mut renderer: Renderer) -> Result<WarmUp, RenderError> {
    let &RenderSettings { integrator, width, height, .. } = renderer.settings();
    let samples = 2.0 * SAMPLES as f64 * f64::from(width * height);
    let mut image = |seed| {
        renderer.restart_with_seed(seed)?;
        while renderer.samples() < SAMPLES {
            renderer.step(SAMPLES - renderer.samples())?;
        }
        renderer.image()
    };
    let images = [image(SEEDS[0])?, image(SEEDS[1])?];
    let rays = renderer.stats()?.rays as f64 / samples;
    let is_bdpt = integrator.integrator == Integrator::Bdpt;
    let cost = || bdpt_ray_cost(renderer.device().info().kind, &integrator);
    let ray = if is_bdpt { cost() } else { 1.0 };
    Ok(WarmUp { integrator, images, work: rays * ray })
}

/// The error of each candidate. One that has not found some of the light in so few samples shows little
/// spread: so it also counts how far those without splats are from those with, which have all strategies.
/// Errors are relative to means over blocks: a pixel of so few samples would be large where one of those that
/// are judged by it has a rare bright path, and forgive it that path alone.
fn judge(warm_ups: &[WarmUp]) -> Vec<Candidate> {
    let is_complete = |w: &&WarmUp| w.integrator.uses_splat();
    let halves = [0, 1].map(|i| mean(warm_ups.iter().filter(is_complete).map(|w| &w.images[i])));
    let reference = mean(halves.iter());
    let smooth = smooth(&reference);
    let judge = |w: &WarmUp| {
        let spread = 0.5 * mean_and_trimmed(relative_squares(&w.images[0], &w.images[1], &smooth)).1;
        let missed =
            if is_complete(&w) { 0.0 } else { missed_error(&mean(w.images.iter()), &halves, &reference) };
        Candidate { integrator: w.integrator, relmse: SAMPLES as f64 * spread.max(missed), work: w.work }
    };
    warm_ups.iter().map(judge).collect()
}

/// An image whose pixels are the means of their blocks.
fn smooth(image: &Image) -> Image {
    let blocks = image.block_means(BLOCK);
    Image::from_fn(image.width, image.height, |x, y| blocks.pixels[y / BLOCK * blocks.width + x / BLOCK])
}

/// The error of one of two images whose mean is `image`, by blocks of pixels: noise is as much smaller
/// in them as they have pixels, light that was found nowhere in them is not.
fn missed_error(image: &Image, halves: &[Image; 2], reference: &Image) -> f64 {
    let blocks = |image: &Image| image.block_means(BLOCK);
    let (reference, [a, b]) = (blocks(reference), [&halves[0], &halves[1]].map(blocks));
    let error = |a: &Image, b: &Image| mean_and_trimmed(relative_squares(a, b, &reference)).0;
    // A mean over two halves has half the error of one, which is half the squared difference.
    let of_reference = 0.25 * error(&a, &b);
    2.0 * (BLOCK * BLOCK) as f64 * (error(&blocks(image), &reference) - of_reference)
}

/// The mean of images of one size, of which there is at least one.
fn mean<'a>(images: impl Iterator<Item = &'a Image> + Clone) -> Image {
    let n = images.clone().count() as f32;
    let mut images = images.cloned();
    let mut sum = images.next().unwrap_or_else(|| Image::filled(1, 1, [0.0; 3]));
    for image in images {
        for (sum, value) in sum.pixels.iter_mut().flatten().zip(image.pixels.as_flattened()) {
            *sum += value;
        }
    }
    sum.pixels.iter_mut().flatten().for_each(|sum| *sum /= n);
    sum
}

/// (a - b)² / (reference² + 0.01) of each pixel, the mean of its channels.
fn relative_squares(a: &Image, b: &Image, reference: &Image) -> Vec<f64> {
    let pixel = |((a, b), r): ((&[f32; 3], &[f32; 3]), &[f32; 3])| {
        let term = |i: usize| {
            let (difference, r) = (f64::from(a[i]) - f64::from(b[i]), f64::from(r[i]));
            difference * difference / (r * r + EPSILON)
        };
        (0..3).map(term).sum::<f64>() / 3.0
    };
    a.pixels.iter().zip(&b.pixels).zip(&reference.pixels).map(pixel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::LaneUses;

    fn candidate(integrator: IntegratorSettings, relmse: f64, work: f64) -> Candidate {
        Candidate { integrator, relmse, work }
    }

    /// A renderer of them compiles nothing for the warm-up or for what it chooses.
    #[test]
    fn kernels_are_known_ahead() {
        let settings = RenderSettings { light_groups: true, ..RenderSettings::default() };
        let ahead = settings_ahead(&settings);
        let small = small_settings(&settings, 1024.0);
        for rendered in [&settings, &small] {
            let [path, full] = candidates(&rendered.integrator);
            for integrator in [path, full].into_iter().chain(variants(full)) {
                let needed: Vec<_> =
                    LaneUses::of(&RenderSettings { integrator, ..rendered.clone() }).kernels().collect();
                let holds = |one: &RenderSettings| {
                    let kernels: Vec<_> = LaneUses::of(one).kernels().collect();
                    one.light_groups == rendered.light_groups
                        && needed.iter().all(|name| kernels.contains(name))
                };
                assert!(ahead.iter().any(holds), "{}", integrator.describe());
            }
        }
    }

    #[test]
    fn the_least_error_for_the_work_wins_and_is_named() {
        let [path, full] = candidates(&IntegratorSettings::default());
        let choice = Choice::of(vec![candidate(path, 8.0, 3.0), candidate(full, 1.0, 10.0)]);
        assert_eq!(choice.integrator(), full);
        assert_eq!(choice.describe(), "full 1.00, path 2.40");
        let choice = Choice::of(vec![candidate(path, 1.0, 3.0), candidate(full, 0.5, 10.0)]);
        assert_eq!(choice.integrator(), path);
    }

    fn warm_up_of(integrator: IntegratorSettings, values: [f32; 2], work: f64) -> WarmUp {
        let image = |value: f32| {
            // Half of the pixels are above the mean, half below.
            Image::from_fn(16, 16, |x, _| [if x % 2 == 0 { 1.0 + value } else { 1.0 - value }; 3])
        };
        WarmUp { integrator, images: values.map(image), work }
    }

    /// Half the squared difference of the two images, over 1.01.
    #[test]
    fn the_spread_between_two_images_is_the_error() {
        let [path, full] = candidates(&IntegratorSettings::default());
        let judged = judge(&[warm_up_of(path, [0.3, -0.3], 2.0), warm_up_of(full, [0.1, -0.1], 5.0)]);
        for (candidate, difference) in judged.iter().zip([0.6, 0.2]) {
            let expected = SAMPLES as f64 * 0.5 * difference * difference / 1.01;
            assert!((candidate.relmse - expected).abs() <= 1e-3 * expected, "{candidate:?}");
        }
    }

    /// Two that are alike are judged alike, though one of them has all strategies and is in the reference. With a
    /// few rare paths in a whole block, block means are too noisy to tell.
    #[test]
    fn rare_bright_paths_count_alike_in_all() {
        let [path, full] = candidates(&IntegratorSettings::default());
        let mut state = 1u32;
        let mut pixel = |_, _| {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            [if state >> 8 < (1 << 24) / 5 { 5.0 } else { 0.1 }; 3]
        };
        let mut warm_up = |integrator| WarmUp {
            integrator,
            images: [0, 1].map(|_| Image::from_fn(64, 64, &mut pixel)),
            work: 1.0,
        };
        let judged = judge(&[warm_up(path), warm_up(full)]);
        let ratio = judged[0].relmse / judged[1].relmse;
        assert!((0.7..1.4).contains(&ratio), "{ratio}");
    }

    /// Light that is missing in one block of sixteen weighs more than half of the spread.
    #[test]
    fn a_spot_that_was_not_found_is_an_error() {
        let [path, full] = candidates(&IntegratorSettings::default());
        let image = |spot: f32, noise: f32| {
            let at = |x, y| {
                1.0 + if x < 8 && y < 8 { spot } else { 0.0 } + if (x + y) % 2 == 0 { noise } else { -noise }
            };
            Image::from_fn(32, 32, |x, y| [at(x, y); 3])
        };
        let with = |integrator, spot, noise, work| WarmUp {
            integrator,
            images: [image(spot, noise), image(spot, -noise)],
            work,
        };
        let judged = judge(&[with(path, 0.0, 0.1, 3.0), with(full, 1.0, 0.15, 10.0)]);
        assert_eq!(Choice::of(judged).integrator(), full);
        let judged = judge(&[with(path, 1.0, 0.1, 3.0), with(full, 1.0, 0.15, 10.0)]);
        assert_eq!(Choice::of(judged).integrator(), path);
    }

    /// A black image has no spread.
    #[test]
    fn light_that_was_not_found_is_an_error() {
        let [path, full] = candidates(&IntegratorSettings::default());
        let black = WarmUp {
            images: [0, 1].map(|_| Image::filled(16, 16, [0.0; 3])),
            ..warm_up_of(path, [0.0; 2], 2.0)
        };
        let choice = Choice::of(judge(&[black, warm_up_of(full, [0.1, -0.1], 10.0)]));
        assert_eq!(choice.integrator(), full);
    }
}
