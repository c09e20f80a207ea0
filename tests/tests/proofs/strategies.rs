//! Strategies (s, t) one by one, and that an error of 2 % in one of them is caught.

use glam::Vec3;
use midway_film::Image;
use midway_render::{OneStrategy, RenderSettings, Rng};
use midway_tests::{
    estimate::{Agreement, Blocks, Expected, batches, combine, cpu},
    integrators,
    reference::Yardstick,
    scenes,
};

use crate::support::{Report, in_turn, is_nightly, settings};

/// The error that has to show.
const INJECTED: f64 = 0.02;
/// Independent batches.
const BATCHES: usize = 32;

fn scaled(image: &Image, factor: f64) -> Image {
    combine(image, image, |value, _| value * factor)
}

fn with_strategy(settings: &RenderSettings, s: u32, t: u32, raw: bool) -> RenderSettings {
    RenderSettings { one_strategy: Some(OneStrategy { s, t, raw }), ..settings.clone() }
}

/// In a closed sphere that emits Le everywhere, paths of k reflections carry Le ρ^k, and every
/// strategy alone, with weight 1, finds all of them. Nothing is near-coincident there (on a sphere
/// the geometry term is constant), so that a few seconds show 0.4 % of each.
#[test]
fn each_strategy_alone_has_the_radiance_of_its_path_length() {
    let _turn = in_turn();
    let longest = if is_nightly() { 8 } else { 5 };
    let known = scenes::closed_sphere();
    let (emission, albedo) =
        (Vec3::from_array(scenes::SPHERE_EMISSION), Vec3::from_array(scenes::SPHERE_ALBEDO));
    let in_use = vec![true; scenes::SIZE * scenes::SIZE];
    let mut report = Report::default();
    for (s, t) in (3..=longest).flat_map(|n| (0..n).map(move |s| (s, n - s))) {
        // Splats are few: many more of them, by the integrator that makes nothing else.
        let (case, samples) = if t == 1 { (integrators::light(), 64) } else { (integrators::full(), 10) };
        // By independent numbers: with Sobol points the standard errors of one strategy differed twofold
        // between seeds, and one mean of twelve lay 4.7 of them off by one seed of three: batches' means
        // are not normal there. Suspected: a tail at the edges of facets, which is all that is left.
        let independent = RenderSettings { rng: Rng::Hash, ..settings(scenes::SIZE, case.settings, 1) };
        let settings = with_strategy(&independent, s, t, true);
        let images = batches(&cpu(), &known.scene, &settings, BATCHES, samples);
        let radiance = (emission * albedo.powf((s + t - 2) as f32)).to_array();
        let mean = Image::filled(scenes::SIZE, scenes::SIZE, radiance);
        let expected = Blocks::of_expected(&Expected { mean, standard_error: None }, &in_use);
        let agreement = Agreement::of(&Blocks::of_batches(&images, &in_use), &expected);
        report.check(&format!("({s}, {t})"), &agreement, Some(0.02));
        let wrong: Vec<Image> = images.iter().map(|image| scaled(image, 1.0 + INJECTED)).collect();
        let caught = !Agreement::of(&Blocks::of_batches(&wrong, &in_use), &expected).holds();
        report.note(&format!("({s}, {t}) with 2 % more is caught"), caught);
    }
    report.finish();
}

/// The test of scene A against its reference fails where one strategy of `bdpt` is 2 % too bright.
/// 10 s show it for the strategies that carry 10 % of the image or more; nightly for those that
/// carry 6 % ((1, 3) and (2, 2)). Those that carry less are proved alone, above.
#[test]
fn an_error_of_2_percent_in_one_strategy_is_caught_in_scene_a() {
    let _turn = in_turn();
    let Some(yardstick) = Yardstick::a() else { return };
    let (strategies, samples) = if is_nightly() {
        (&[(1, 2), (2, 1), (3, 1), (2, 2), (1, 3)][..], 160)
    } else {
        (&[(1, 2), (2, 1), (3, 1)][..], 16)
    };
    let in_use = yardstick.lit();
    let expected = Blocks::of_expected(&yardstick.expected, &in_use);
    let settings = settings(yardstick.size as usize, integrators::full().settings, 1);
    let images = batches(&cpu(), &yardstick.scene, &settings, BATCHES, samples);
    let compare = |images: &[Image]| Agreement::of(&Blocks::of_batches(images, &in_use), &expected);
    let mut report = Report::default();
    report.check("A, bdpt", &compare(&images), None);
    for &(s, t) in strategies {
        let one = with_strategy(&settings, s, t, false);
        let alone = batches(&cpu(), &yardstick.scene, &one, BATCHES, samples);
        let wrong: Vec<Image> =
            images.iter().zip(&alone).map(|(all, one)| combine(all, one, |a, b| a + INJECTED * b)).collect();
        let agreement = compare(&wrong);
        report.note(&format!("A, 2 % more of ({s}, {t}) is caught: {agreement}"), !agreement.holds());
    }
    report.finish();
}
