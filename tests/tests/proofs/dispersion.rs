//! Glass that disperses: each channel is what it were if all light had that channel's index.

use midway_film::Image;
use midway_render::{Integrator, JoinChoice};
use midway_scene::Scene;
use midway_tests::{
    dispersion::{DISPERSION, IOR, indices, rough_blocks, smooth_room},
    estimate::{Agreement, Blocks, cpu, gpu, render},
    integrators::{self, Case},
    scenes::SIZE,
};

use crate::{
    devices::{self, share_of_agreeing_pixels},
    support::{Report, estimate, in_turn, settings},
};

/// Samples a pixel by `path`: about 1 s a case.
const SAMPLES: u64 = 320;
/// What the integrators are held to takes so many times the samples, for each channel.
const AGAINST: u64 = 4;

/// By the index of green and the dispersion.
type Glass = fn(f32, f32) -> Scene;

/// From one end, from the other, and by joins of each kind: of all pairs, of some, of one, of a pool's.
fn cases() -> Vec<Case> {
    let importance = integrators::k_step(3, JoinChoice::Importance);
    let pool = integrators::joins().into_iter().nth(1).expect("a pool's full join");
    let ends = integrators::single_step(true, true);
    vec![integrators::path_naive(), integrators::light(), integrators::full(), importance, ends, pool]
}

/// A scene without dispersion, by each channel's index.
fn channel_by_channel(scene: Glass) -> Vec<Image> {
    let of = |ior: f32| estimate(&cpu(), &scene(ior, 0.0), SIZE, &integrators::path(), AGAINST * SAMPLES);
    let [red, green, blue] = indices().map(of);
    let batches = red.iter().zip(&green).zip(&blue);
    let pixel = |i: usize, [r, g, b]: [&Image; 3]| [r.pixels[i][0], g.pixels[i][1], b.pixels[i][2]];
    batches.map(|((r, g), b)| Image::from_fn(SIZE, SIZE, |x, y| pixel(y * SIZE + x, [r, g, b]))).collect()
}

fn each_channel_has_its_index(scene: Glass, light_sees: bool) {
    let _turn = in_turn();
    let in_use = vec![true; SIZE * SIZE];
    let expected = Blocks::of_batches(&channel_by_channel(scene), &in_use);
    let agreement = |dispersion: f32, case: &Case| {
        let images = estimate(&cpu(), &scene(IOR, dispersion), SIZE, case, SAMPLES);
        Agreement::of(&Blocks::of_batches(&images, &in_use), &expected)
    };
    let mut report = Report::default();
    // Light paths cannot be seen by way of a delta lobe.
    for case in cases().iter().filter(|case| light_sees || case.settings.integrator != Integrator::Light) {
        let agreement = agreement(DISPERSION, case);
        if case.settings.integrator == Integrator::Light {
            // Few light paths leave by a facet that sends them to the eye: a heavy tail.
            let text = format!("{}: {agreement}", case.name());
            report.note(&text, agreement.nothing_is_brighter() && agreement.means_agree());
        } else {
            report.check_where_reachable(&case.name(), &agreement);
        }
    }
    let plain = agreement(0.0, &integrators::path());
    report.note(&format!("green's index for all is told apart: {plain}"), !plain.holds());
    report.finish();
}

#[test]
fn smooth_glass_that_disperses_has_each_channels_index() {
    each_channel_has_its_index(smooth_room, false);
}

#[test]
fn rough_glass_that_disperses_has_each_channels_index() {
    each_channel_has_its_index(rough_blocks, true);
}

#[test]
fn a_gpu_disperses_as_the_cpu_does() {
    let _turn = in_turn();
    let Some(gpu) = gpu() else { return };
    let mut report = Report::default();
    let scene = rough_blocks(IOR, DISPERSION);
    for case in [integrators::full(), integrators::light()] {
        let settings = settings(2 * SIZE, case.settings, 7);
        let images = [&gpu, &cpu()].map(|device| render(device, &scene, &settings, 2));
        let share = share_of_agreeing_pixels(&images[0], &images[1]);
        let text = format!("{}: {:.2} % of pixels", case.name(), 100.0 * share);
        report.note(&text, share >= devices::AGREEING && !images[1].is_black());
    }
    report.finish();
}
