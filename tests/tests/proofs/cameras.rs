//! Cameras other than the pinhole: closed forms, and integrators against each other.

use midway_render::{FilterKind, Integrator, JoinChoice, PixelFilter, RenderSettings};
use midway_scene::Scene;
use midway_tests::{
    camera_scenes as cameras,
    estimate::{Agreement, Blocks, cpu},
    integrators::{self, Case},
    scenes::{self, Known},
};

use crate::support::{Report, estimate, estimate_with, in_turn, mean_bound, settings};

/// Samples a pixel by `path`; others get as many as take as long.
const SAMPLES: u64 = 256;
/// `path-naive` is what the others are held to, with so many times the samples.
const AGAINST: u64 = 6;

/// One of each kind: what differs by camera is the first segment, t = 1 and their weights.
fn cases() -> Vec<Case> {
    let mut pool = integrators::k_step(3, JoinChoice::Uniform);
    pool.settings.light_paths = midway_render::LightPaths::Pool(None);
    vec![
        integrators::path_naive(),
        integrators::path(),
        integrators::light(),
        integrators::full(),
        integrators::k_step(1, JoinChoice::Importance),
        pool,
        integrators::single_step(false, false),
        integrators::single_step(true, true),
    ]
}

fn prove(known: &Known) {
    let _turn = in_turn();
    let in_use = vec![true; scenes::SIZE * scenes::SIZE];
    let expected = Blocks::of_expected(&known.expected, &in_use);
    let mut report = Report::default();
    for case in cases() {
        let images = estimate(&cpu(), &known.scene, scenes::SIZE, &case, SAMPLES);
        let agreement = Agreement::of(&Blocks::of_batches(&images, &in_use), &expected);
        report.check(&format!("{}, {}", known.name, case.name()), &agreement, Some(mean_bound()));
    }
    report.finish();
}

#[test]
fn a_lens_blurs_an_edge_by_its_disk() {
    prove(&cameras::blurred_edge());
}

#[test]
fn a_lens_half_covered_sees_half() {
    prove(&cameras::half_covered_lens());
}

#[test]
fn facing_squares_through_a_lens() {
    prove(&cameras::facing_squares_through_a_lens());
}

#[test]
fn facing_squares_by_parallel_rays() {
    prove(&cameras::facing_squares_by_parallel_rays());
}

#[test]
fn facing_squares_by_parallel_rays_through_a_lens() {
    prove(&cameras::facing_squares_by_parallel_rays_through_a_lens());
}

/// Through a lens, out of focus, and by a wide filter.
fn agree(scene: &Scene) {
    let _turn = in_turn();
    let in_use = vec![true; scenes::SIZE * scenes::SIZE];
    let settings = RenderSettings {
        filter: PixelFilter::new(FilterKind::BlackmanHarris),
        ..settings(scenes::SIZE, integrators::path().settings, 0)
    };
    let blocks = |case: &Case, samples| {
        Blocks::of_batches(&estimate_with(&cpu(), scene, &settings, case, samples), &in_use)
    };
    let expected = blocks(&integrators::path_naive(), AGAINST * SAMPLES);
    let mut report = Report::default();
    for case in cases().into_iter().filter(|case| case.settings.integrator != Integrator::PathNaive) {
        let agreement = Agreement::of(&blocks(&case, SAMPLES), &expected);
        report.check_where_reachable(&case.name(), &agreement);
    }
    report.finish();
}

#[test]
fn integrators_agree_through_a_lens() {
    agree(&cameras::ball_out_of_focus());
}

#[test]
fn integrators_agree_by_parallel_rays() {
    agree(&cameras::ball_by_parallel_rays());
}
