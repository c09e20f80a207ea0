//! The yardstick scenes against another renderer's images, on the CPU device.
//!
//! Tolerances: as for closed forms, with the reference's own standard errors; the bound on the mean
//! counts where the spread lets it (`Report::check_where_reachable`).
//!
//! A case that fails is looked at once more, with four times the samples and another seed: some 80
//! images of 64 blocks and 3 channels are tested here, each image at a level of 10⁻³, and blocks in
//! dark corners are skewed.
//!
//! Heavy tails: an integrator that meets a small lamp only by chance (through glass in B, by
//! reflection from the ceiling that the lamp of C lights) estimates most of what it sees from events
//! that a run of seconds may not hold at all. Its blocks look dark, with a small spread: a t-test
//! would fail a correct renderer. Of these no more is asked than that nothing is significantly
//! brighter; that they miss nothing is shown by scene A and by the closed forms.

use midway_tests::{
    estimate::{Agreement, Blocks, cpu},
    integrators::{self, Case},
    reference::Yardstick,
};

use crate::support::{Report, estimate, estimate_again, in_turn, is_nightly};

/// Samples a pixel by `path`, about 4 s a case on two cores; others get as many as take as long.
const SAMPLES: u64 = 384;

fn prove(yardstick: Option<Yardstick>, is_heavy: impl Fn(&Case) -> bool) {
    let _turn = in_turn();
    let Some(yardstick) = yardstick else { return };
    let in_use = yardstick.lit();
    let expected = Blocks::of_expected(&yardstick.expected, &in_use);
    let mut report = Report::default();
    let every = is_nightly() || yardstick.name == "A";
    let cases = if every { integrators::all() } else { integrators::share(yardstick.name) };
    for case in cases {
        let size = yardstick.size as usize;
        let of = |images: &[_]| Agreement::of(&Blocks::of_batches(images, &in_use), &expected);
        let agreement = of(&estimate(&cpu(), &yardstick.scene, size, &case, SAMPLES));
        let name = format!("{}, {}", yardstick.name, case.name());
        if is_heavy(&case) {
            report.note(&format!("{name} (heavy tail): {agreement}"), agreement.nothing_is_brighter());
        } else if agreement.holds() {
            report.check_where_reachable(&name, &agreement);
        } else {
            println!("looked at again: {name}: {agreement}");
            let agreement = of(&estimate_again(&cpu(), &yardstick.scene, size, &case, SAMPLES));
            report.check_where_reachable(&format!("{name}, second look"), &agreement);
        }
    }
    report.finish();
}

#[test]
fn scene_a_has_the_radiance_of_the_reference() {
    prove(Yardstick::a(), |_| false);
}

#[test]
fn scene_b_off_the_sphere_has_the_radiance_of_the_reference() {
    // Without splats the caustic is found by s = 0 alone.
    prove(Yardstick::b(), |case| !case.settings.uses_splat());
}

#[test]
fn scene_c_has_the_radiance_of_the_reference() {
    prove(Yardstick::c(), |case| !case.settings.uses_light_paths());
}

/// On the sphere s = 0 dominates, with a heavy tail: the caustic seen through glass.
#[test]
fn scene_b_on_the_sphere_is_nowhere_brighter_than_the_reference() {
    let _turn = in_turn();
    let Some(yardstick) = Yardstick::b() else { return };
    let in_use = &yardstick.on_specular;
    let expected = Blocks::of_expected(&yardstick.expected, in_use);
    let mut report = Report::default();
    for case in [integrators::path(), integrators::full(), integrators::single_step(true, true)] {
        let images = estimate(&cpu(), &yardstick.scene, yardstick.size as usize, &case, SAMPLES);
        let agreement = Agreement::of(&Blocks::of_batches(&images, in_use), &expected);
        let text = format!("B on the sphere, {}: {agreement}", case.name());
        report.note(&text, agreement.nothing_is_brighter());
    }
    report.finish();
}
