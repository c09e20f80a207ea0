//! Scenes whose radiance is known, by every integrator that sees them, on both devices.
//!
//! Tolerances: no 8 x 8 block differs at the family level, the mean is within 4 standard errors,
//! and within 1 % (`estimate.rs`, `support.rs`).

use std::sync::Arc;

use midway_device::Device;
use midway_render::Integrator;
use midway_tests::{
    estimate::{Agreement, Blocks, cpu, gpu},
    integrators,
    scenes::{self, Known},
};

use crate::support::{Report, estimate, in_turn, mean_bound};

/// Samples a pixel by `path`, about 1 s a case on two cores; others get as many as take as long.
const SAMPLES: u64 = 384;
/// On lavapipe, about 10 times slower.
const GPU_SAMPLES: u64 = 64;

fn prove(device: &Arc<dyn Device>, known: &Known, samples: u64, report: &mut Report) {
    let in_use = vec![true; scenes::SIZE * scenes::SIZE];
    let expected = Blocks::of_expected(&known.expected, &in_use);
    for case in integrators::all() {
        if case.settings.integrator == Integrator::Light && !known.light_sees {
            continue;
        }
        let images = estimate(device, &known.scene, scenes::SIZE, &case, samples);
        let agreement = Agreement::of(&Blocks::of_batches(&images, &in_use), &expected);
        report.check(&format!("{}, {}", known.name, case.name()), &agreement, Some(mean_bound()));
    }
}

fn prove_on_cpu(known: &Known) {
    let _turn = in_turn();
    let mut report = Report::default();
    prove(&cpu(), known, SAMPLES, &mut report);
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

#[test]
fn a_gpu_renders_the_closed_forms_too() {
    let _turn = in_turn();
    let Some(gpu) = gpu() else { return };
    let mut report = Report::default();
    for known in scenes::all() {
        prove(&gpu, &known, GPU_SAMPLES, &mut report);
    }
    report.finish();
}
