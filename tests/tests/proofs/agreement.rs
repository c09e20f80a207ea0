//! Integrators against each other, where there is no closed form.

use midway_render::Integrator;
use midway_tests::{
    estimate::{Agreement, Blocks, cpu},
    integrators::{self, Case},
    scenes,
};

use crate::support::{Report, estimate, in_turn};

/// Samples a pixel by `path`: about 1 s a case.
const SAMPLES: u64 = 384;
/// `path-naive` draws nothing that `light` and the joins rely on: it is what they are held to, with
/// so many times the samples.
const AGAINST: u64 = 8;

/// Shading normals that differ from the geometry's make scattering asymmetric: without the adjoint
/// factor light paths disagree with camera paths (Veach 1997, section 5.3).
#[test]
fn integrators_agree_on_shading_normals() {
    let _turn = in_turn();
    let scene = scenes::leaning_normals();
    let in_use = vec![true; scenes::SIZE * scenes::SIZE];
    let blocks = |case: &Case, samples| {
        Blocks::of_batches(&estimate(&cpu(), &scene, scenes::SIZE, case, samples), &in_use)
    };
    let expected = blocks(&integrators::path_naive(), AGAINST * SAMPLES);
    let mut report = Report::default();
    let held =
        integrators::all().into_iter().filter(|case| case.settings.integrator != Integrator::PathNaive);
    for case in held {
        let agreement = Agreement::of(&blocks(&case, SAMPLES), &expected);
        report.check_where_reachable(&case.name(), &agreement);
    }
    report.finish();
}

/// Every model of a surface: from one end, from the other and from both.
#[test]
fn integrators_agree_on_every_material() {
    let _turn = in_turn();
    let in_use = vec![true; scenes::SIZE * scenes::SIZE];
    let mut report = Report::default();
    for smooth in [false, true] {
        let scene = scenes::materials_room(smooth);
        let blocks = |case: &Case, samples| {
            Blocks::of_batches(&estimate(&cpu(), &scene, scenes::SIZE, case, samples), &in_use)
        };
        let expected = blocks(&integrators::path_naive(), AGAINST * SAMPLES);
        let ends = [
            integrators::path(),
            integrators::full(),
            integrators::single_step(true, true),
            integrators::light(),
        ];
        // Light paths cannot be seen by way of a delta lobe.
        for case in ends.iter().filter(|case| !smooth || case.settings.integrator != Integrator::Light) {
            let agreement = Agreement::of(&blocks(case, SAMPLES), &expected);
            report.check_where_reachable(&format!("{}, smooth: {smooth}", case.name()), &agreement);
        }
    }
    report.finish();
}
