//! Scenes whose radiance is known, by every integrator that sees them, on both devices.
//!
//! Tolerances: no 8 x 8 block differs at the family level, the mean is within 4 standard errors,
//! and within 1 % (`estimate.rs`, `support.rs`); on a GPU where its samples suffice for that.

use std::sync::Arc;

use midway_device::Device;
use midway_render::{Integrator, JoinChoice, LightPaths};
use midway_tests::{
    estimate::{Agreement, Blocks, cpu, gpu},
    integrators::{self, Case},
    scenes::{self, Known},
};

use crate::support::{Report, estimate, in_turn, mean_bound};

/// Samples a pixel by `path`, about 0.7 s a case on two cores; others get as many as take as long.
const SAMPLES: u64 = 256;
/// On lavapipe, about 10 times slower.
const GPU_SAMPLES: u64 = 48;
/// Passes of a small pool, so many pools: what varies is the pools' luck, which all pixels share.
const POOL_SAMPLES: u64 = 4096;

fn compare(device: &Arc<dyn Device>, known: &Known, case: &Case, samples: u64) -> (String, Agreement) {
    let in_use = vec![true; scenes::SIZE * scenes::SIZE];
    let expected = Blocks::of_expected(&known.expected, &in_use);
    let images = estimate(device, &known.scene, scenes::SIZE, case, samples);
    let agreement = Agreement::of(&Blocks::of_batches(&images, &in_use), &expected);
    (format!("{}, {}", known.name, case.name()), agreement)
}

fn sees(case: &Case, known: &Known) -> bool {
    case.settings.integrator != Integrator::Light || known.light_sees
}

fn prove_on_cpu(known: &Known) {
    let _turn = in_turn();
    let mut report = Report::default();
    for case in integrators::all().into_iter().filter(|case| sees(case, known)) {
        let (name, agreement) = compare(&cpu(), known, &case, SAMPLES);
        report.check(&name, &agreement, Some(mean_bound()));
    }
    report.finish();
}

#[test]
fn a_white_furnace_is_white() {
    prove_on_cpu(&scenes::white_furnace());
}

#[test]
fn a_white_furnace_is_white_with_mirror_and_glass_in_view() {
    prove_on_cpu(&scenes::specular_furnace());
}

#[test]
fn a_closed_sphere_has_the_radiance_of_the_geometric_series() {
    prove_on_cpu(&scenes::closed_sphere());
}

#[test]
fn a_closed_sphere_with_an_area_light_is_lit_evenly() {
    prove_on_cpu(&scenes::closed_sphere_with_an_area_light());
}

#[test]
fn facing_squares_have_the_known_form_factor() {
    prove_on_cpu(&scenes::facing_squares());
}

#[test]
fn a_veil_before_the_lamp_takes_its_share() {
    prove_on_cpu(&scenes::facing_squares_through_a_veil());
}

#[test]
fn textures_color_what_they_lie_on() {
    prove_on_cpu(&scenes::textured_squares());
}

#[test]
fn a_box_of_perfect_mirrors_shows_its_lamp_everywhere() {
    prove_on_cpu(&scenes::mirror_box());
}

#[test]
fn a_lamp_in_glass_is_dimmed_by_fresnel_and_the_square_of_the_index() {
    prove_on_cpu(&scenes::lamp_in_glass());
}

#[test]
fn a_camera_in_glass_sees_the_square_of_the_index() {
    prove_on_cpu(&scenes::camera_in_glass());
}

/// A pool of two paths: V and what the paths bring vary together from pass to pass, so that a weight
/// that follows V is biased, where in a pool of thousands it would not show.
#[test]
fn a_pool_of_two_paths_is_as_good() {
    let _turn = in_turn();
    let known = scenes::closed_sphere_with_an_area_light();
    let mut report = Report::default();
    for choice in [JoinChoice::Uniform, JoinChoice::Importance] {
        let mut case = integrators::k_step(1, choice);
        case.settings.light_paths = LightPaths::Pool(Some(2));
        let (name, agreement) = compare(&cpu(), &known, &case, POOL_SAMPLES);
        report.check_where_reachable(&name, &agreement);
    }
    report.finish();
}

/// Every scene by an integrator from one end and from both, and every integrator in one scene; that
/// a GPU renders the same samples as the CPU by each of them is proved pixel by pixel
/// (`devices.rs`).
#[test]
fn a_gpu_renders_the_closed_forms_too() {
    let _turn = in_turn();
    let Some(gpu) = gpu() else { return };
    let mut report = Report::default();
    let mut prove = |known: &Known, case: &Case| {
        let (name, agreement) = compare(&gpu, known, case, GPU_SAMPLES);
        report.check_where_reachable(&name, &agreement);
    };
    for known in scenes::all() {
        prove(&known, &integrators::path());
        prove(&known, &integrators::full());
    }
    let known = scenes::closed_sphere_with_an_area_light();
    for case in integrators::all().iter().filter(|case| case.cost < 8.0) {
        prove(&known, case);
    }
    report.finish();
}
