//! Joins against each other, where no reference is needed.

use midway_tests::{
    estimate::{Agreement, Blocks, cpu},
    integrators::{self, Case},
    reference::Yardstick,
};

use crate::support::{Report, estimate, in_turn};

/// Samples a pixel by `path`: about 4 s a case.
const SAMPLES: u64 = 384;

/// The paper's single-step loses energy; ours divides by the chance of having ended.
#[test]
fn single_step_is_not_darker_than_full() {
    let _turn = in_turn();
    let mut report = Report::default();
    for yardstick in [Yardstick::a(), Yardstick::c()].into_iter().flatten() {
        let in_use = yardstick.lit();
        let blocks = |case: &Case| {
            let images = estimate(&cpu(), &yardstick.scene, yardstick.size as usize, case, SAMPLES);
            Blocks::of_batches(&images, &in_use)
        };
        let full = blocks(&integrators::full());
        for case in integrators::joins() {
            if case.settings.joins() == Some(midway_render::Join::SingleStep) {
                let agreement = Agreement::of(&blocks(&case), &full);
                let text = format!("{}, {} over full: {agreement}", yardstick.name, case.name());
                report.note(&text, agreement.means_agree());
            }
        }
    }
    report.finish();
}
