//! The GPU renders what the CPU renders: the same samples, pixel by pixel.

use midway_film::Image;
use midway_render::RenderSettings;
use midway_tests::{
    estimate::{cpu, gpu, render},
    integrators, own, scenes,
};

use crate::support::{Report, in_turn, settings};

/// Pixels along both sides.
const SIZE: usize = 64;
/// Of the larger of a pixel's value and the image's mean: rounding differs between devices, and
/// changes what a path hits only now and then.
const TOLERANCE: f64 = 1e-3;
/// Of all pixels: in the others a path took another turn.
pub const AGREEING: f64 = 0.99;

/// Samples a pixel.
const SAMPLES: u64 = 4;

/// Of one image, in another.
pub fn share_of_agreeing_pixels(a: &Image, b: &Image) -> f64 {
    let mean = b.mean().iter().sum::<f64>() / 3.0;
    let close = |a: f32, b: f32| {
        let (a, b) = (f64::from(a), f64::from(b));
        (a - b).abs() <= TOLERANCE * b.abs().max(mean)
    };
    let agree = |(a, b): (&[f32; 3], &[f32; 3])| a.iter().zip(b).all(|(a, b)| close(*a, *b));
    a.pixels.iter().zip(&b.pixels).filter(|pair| agree(*pair)).count() as f64 / a.pixels.len() as f64
}

#[test]
fn a_gpu_renders_the_same_samples_as_the_cpu() {
    let _turn = in_turn();
    let Some(gpu) = gpu() else { return };
    let mut report = Report::default();
    for (index, name) in own::SCENES.into_iter().enumerate() {
        let scene = own::load(name);
        // A third of the joins for each scene, so that all are met; the dear ones repeat what others do.
        for case in integrators::share(&index.to_string()).into_iter().filter(|case| case.cost < 4.0) {
            let settings = settings(SIZE, case.settings, 7);
            let images = [&gpu, &cpu()].map(|device| render(device, &scene, &settings, SAMPLES));
            let share = share_of_agreeing_pixels(&images[0], &images[1]);
            let text = format!("{name}, {}: {:.2} % of pixels", case.name(), 100.0 * share);
            report.note(&text, share >= AGREEING && !images[1].is_black());
        }
    }
    report.finish();
}

/// Coats and what they cover, leaning apart, under a lamp. Nothing longer: each bounce between facets of
/// balls magnifies what sines and roots differ by, and a real GPU's paths take other turns in 5 % of the
/// pixels.
#[test]
fn a_gpu_renders_leaning_coats_as_the_cpu_does() {
    let _turn = in_turn();
    let Some(gpu) = gpu() else { return };
    let scene = scenes::leaning_materials_room();
    let settings =
        RenderSettings { max_path_length: Some(2), ..settings(SIZE, integrators::full().settings, 7) };
    let images = [&gpu, &cpu()].map(|device| render(device, &scene, &settings, SAMPLES));
    let share = share_of_agreeing_pixels(&images[0], &images[1]);
    println!("{:.2} % of pixels", 100.0 * share);
    assert!(share >= AGREEING && !images[1].is_black(), "{share}");
}

#[test]
fn images_of_another_seed_or_1_percent_brighter_are_told_apart() {
    let _turn = in_turn();
    let scene = own::load(own::SCENES[0]);
    let [one, other] =
        [7, 8].map(|seed| render(&cpu(), &scene, &settings(SIZE, integrators::path().settings, seed), 4));
    assert!(share_of_agreeing_pixels(&one, &one) == 1.0);
    assert!(share_of_agreeing_pixels(&other, &one) < AGREEING);
    let brighter = Image::from_fn(SIZE, SIZE, |x, y| one.pixels[y * SIZE + x].map(|value| value * 1.01));
    assert!(share_of_agreeing_pixels(&brighter, &one) < AGREEING);
}
