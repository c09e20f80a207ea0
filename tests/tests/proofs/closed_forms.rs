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
    lit,
    scenes::{self, Known},
};

use crate::support::{Report, estimate, in_turn, is_nightly, mean_bound};

/// Samples a pixel by `path`, about 0.7 s a case on two cores; others get as many as take as long.
const SAMPLES: u64 = 256;
/// For one floor under one light: there are many of them.
const LIT_SAMPLES: u64 = 128;
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
    match case.settings.integrator {
        Integrator::Light => known.light_sees,
        Integrator::PathNaive => known.naive_sees,
        _ => true,
    }
}

fn prove_on_cpu(known: &Known) {
    let cases = if is_nightly() { integrators::all() } else { integrators::share(known.name) };
    prove_by(cases, known);
}

fn prove_by(cases: Vec<Case>, known: &Known) {
    let _turn = in_turn();
    let mut report = Report::default();
    for case in cases.into_iter().filter(|case| sees(case, known)) {
        let (name, agreement) = compare(&cpu(), known, &case, SAMPLES);
        report.check(&name, &agreement, Some(mean_bound()));
    }
    report.finish();
}

/// The same, the mean bounded where samples suffice: single-step without next-event estimation finds
/// a light that cannot be hit only where both paths end at once.
fn prove_lit_on_cpu(known: &Known) {
    let _turn = in_turn();
    let mut report = Report::default();
    let cases = if is_nightly() { integrators::all() } else { integrators::share(known.name) };
    for case in cases.into_iter().filter(|case| sees(case, known)) {
        let (name, agreement) = compare(&cpu(), known, &case, LIT_SAMPLES);
        report.check_where_reachable(&name, &agreement);
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

/// Within what the tables leave (TESTING.md), on both devices, which read them from the scene.
#[test]
fn stretched_glass_is_white_in_a_furnace() {
    let _turn = in_turn();
    let mut report = Report::default();
    for device in std::iter::once(cpu()).chain(gpu()) {
        for single_bounce in [false, true] {
            let known = scenes::stretched_furnace(single_bounce);
            let (name, found) = compare(&device, &known, &integrators::path(), SAMPLES);
            let is_white = (found.ratio - 1.0).abs() <= 0.02 + 3.0 * found.ratio_error;
            let text = format!(
                "{}, {name}, single {single_bounce}: {:.4} +- {:.4}",
                device.info().name,
                found.ratio,
                found.ratio_error
            );
            report.note(&text, is_white != single_bounce);
        }
    }
    report.finish();
}

#[test]
fn a_closed_sphere_has_the_radiance_of_the_geometric_series() {
    prove_on_cpu(&scenes::closed_sphere());
}

#[test]
fn a_closed_sphere_with_an_area_light_is_lit_evenly() {
    prove_by(integrators::all(), &scenes::closed_sphere_with_an_area_light());
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

/// Seen from outside, what a surface lacks of n² on the way in it has too much of on the way out: only from
/// within does it show. Within what the tables of albedos leave (TESTING.md).
#[test]
fn a_camera_in_rough_glass_sees_the_square_of_the_index() {
    let _turn = in_turn();
    let known = scenes::camera_in_rough_glass();
    let mut report = Report::default();
    for case in [integrators::path_naive(), integrators::path(), integrators::full()] {
        let (name, found) = compare(&cpu(), &known, &case, SAMPLES);
        let is_square = (found.ratio - 1.0).abs() <= 0.02 + 3.0 * found.ratio_error;
        report.note(&format!("{name}: {:.4} +- {:.4}", found.ratio, found.ratio_error), is_square);
    }
    report.finish();
}

#[test]
fn a_floor_under_a_point_light() {
    prove_lit_on_cpu(&lit::point());
}

#[test]
fn a_floor_under_spots_of_each_falloff() {
    lit::FALLOFFS.iter().for_each(|falloff| prove_lit_on_cpu(&lit::spot(*falloff)));
}

#[test]
fn a_floor_under_a_directional_light() {
    prove_lit_on_cpu(&lit::directional());
}

#[test]
fn a_floor_under_a_constant_environment() {
    prove_lit_on_cpu(&lit::constant_environment());
}

#[test]
fn a_floor_under_an_image_of_a_sky_turned() {
    prove_lit_on_cpu(&lit::sky());
}

#[test]
fn an_environment_is_seen_directly_and_in_a_mirror() {
    prove_lit_on_cpu(&lit::sky_in_a_mirror());
}

#[test]
fn a_white_furnace_of_the_environment_is_white() {
    prove_lit_on_cpu(&lit::environment_furnace());
}

#[test]
fn a_floor_in_an_absorbing_block_under_a_point_light() {
    prove_lit_on_cpu(&lit::point_in_absorbing_glass());
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

/// Scenes by an integrator from one end and from both, and a share of all in one scene; that
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
    let scenes = [
        scenes::specular_furnace(),
        scenes::facing_squares_through_a_veil(),
        scenes::textured_squares(),
        scenes::lamp_in_glass(),
    ];
    for known in scenes {
        prove(&known, &integrators::path());
        prove(&known, &integrators::full());
    }
    let known = scenes::closed_sphere_with_an_area_light();
    for case in integrators::share(known.name).iter().filter(|case| case.cost < 8.0) {
        prove(&known, case);
    }
    report.finish();
}
