//! Lights drawn by the tree over them: the same image as by power, by every kind of strategy that weighs
//! by the chance of drawing one.

use std::sync::Arc;

use midway_device::Device;
use midway_film::Image;
use midway_render::{JoinChoice, LightPaths, LightSampling, Mis, RenderSettings};
use midway_tests::{
    estimate::{Agreement, Blocks, checked_image, cpu, gpu, render_until, renderer},
    integrators::{self, Case},
    lit, scenes,
};

use crate::support::{Report, estimate_with, in_turn, mean_bound, settings};

/// Samples a pixel by `path`: about 1 s a case.
const SAMPLES: u64 = 256;
/// `path` by power takes so many times the samples.
const AGAINST: u64 = 8;

fn by(light_sampling: LightSampling, case: &Case, size: usize) -> RenderSettings {
    RenderSettings { light_sampling, ..settings(size, case.settings, 5) }
}

/// Sixty lights of every kind that is somewhere, a lamp, the sun and a sky: s = 0 and s = 1 by paths from
/// the camera, by the balance heuristic too, then both among light paths that begin by power.
#[test]
fn integrators_agree_by_the_tree_and_by_power() {
    let _turn = in_turn();
    let scene = lit::room_with_many_lights();
    let in_use = vec![true; scenes::SIZE * scenes::SIZE];
    let blocks = |sampling, case: &Case, samples| {
        let settings = by(sampling, case, scenes::SIZE);
        Blocks::of_batches(&estimate_with(&cpu(), &scene, &settings, case, samples), &in_use)
    };
    let expected = blocks(LightSampling::Power, &integrators::path(), AGAINST * SAMPLES);
    let mut balanced = integrators::path();
    balanced.settings.mis = Mis::Balance;
    let mut pool = integrators::k_step(3, JoinChoice::Uniform);
    pool.settings.light_paths = LightPaths::Pool(None);
    let cases = [
        integrators::path(),
        balanced,
        integrators::full(),
        integrators::k_step(1, JoinChoice::Uniform),
        pool,
        integrators::single_step(true, true),
    ];
    let mut report = Report::default();
    for case in &cases {
        let agreement = Agreement::of(&blocks(LightSampling::Tree, case, SAMPLES), &expected);
        report.check_where_reachable(&case.name(), &agreement);
    }
    report.finish();
}

/// A sphere lit by 256 triangles, near some places and far from others, is lit evenly; a floor under a point
/// light and a sky has the sum of both: where strategies weighed by another chance than that of the draw,
/// weights would not sum to 1.
#[test]
fn closed_forms_hold_by_the_tree() {
    let _turn = in_turn();
    let in_use = vec![true; scenes::SIZE * scenes::SIZE];
    let mut report = Report::default();
    let mut balanced = integrators::full();
    balanced.settings.mis = Mis::Balance;
    let cases = [integrators::path(), integrators::full(), balanced, integrators::single_step(true, false)];
    for known in [scenes::closed_sphere_with_an_area_light(), lit::point_and_environment()] {
        let expected = Blocks::of_expected(&known.expected, &in_use);
        for case in &cases {
            let settings = by(LightSampling::Tree, case, scenes::SIZE);
            let images = estimate_with(&cpu(), &known.scene, &settings, case, SAMPLES);
            let agreement = Agreement::of(&Blocks::of_batches(&images, &in_use), &expected);
            report.check(&format!("{}, {}", known.name, case.name()), &agreement, Some(mean_bound()));
        }
    }
    report.finish();
}

/// Kernels that are compiled with the tree draw the same lights.
#[test]
fn a_gpu_draws_the_same_lights() {
    const SIZE: usize = 16;
    let _turn = in_turn();
    let Some(gpu) = gpu() else { return };
    let scene = lit::room_with_many_lights();
    let mut report = Report::default();
    for case in [integrators::path(), integrators::full()] {
        let image = |sampling, device: &Arc<dyn Device>| {
            let mut renderer = renderer(device, &scene, &by(sampling, &case, SIZE));
            render_until(&mut renderer, 8);
            checked_image(&renderer)
        };
        let ours = image(LightSampling::Tree, &cpu());
        let share = agreeing(&ours, &image(LightSampling::Tree, &gpu));
        report.note(&format!("{}: {share:.4} agree", case.name()), share >= 0.95);
        let other = agreeing(&ours, &image(LightSampling::Power, &gpu));
        report.note(&format!("{}: {other:.4} agree with others", case.name()), other <= 0.5);
    }
    report.finish();
}

/// The share of values that agree to rounding.
fn agreeing(a: &Image, b: &Image) -> f64 {
    let values = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let near = values.filter(|(a, b)| f64::from((**a - **b).abs()) <= 1e-3 * f64::from(a.max(**b)));
    near.count() as f64 / a.pixels.as_flattened().len() as f64
}
