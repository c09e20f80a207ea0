//! What all proofs share: turns, how many samples, and reporting all failures of a list at once.

use std::{
    env,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use midway_device::Device;
use midway_film::Image;
use midway_render::{IntegratorSettings, RenderSettings};
use midway_scene::Scene;
use midway_tests::{
    estimate::{Agreement, MEAN_ERRORS, batches},
    integrators::Case,
};

/// Independent batches of a case: 31 degrees of freedom, so that Student's tail at the level of a
/// block (about 5e-6) is at 5.5 standard errors.
const BATCHES: usize = 32;
/// Batches where one sample is already dear: 6.9 standard errors.
const FEW_BATCHES: usize = 16;
/// Nightly takes this many times the samples: 1 % is then as far as 0.3 % (√11 = 3.3).
const NIGHTLY_SAMPLES: u64 = 11;

/// Renders take all cores, and are measured alone: one proof at a time.
pub fn in_turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether this is the long run.
pub fn is_nightly() -> bool {
    env::var("MIDWAY_NIGHTLY").as_deref() == Ok("1")
}

/// How far a mean may be off where samples suffice: the promise of issue 2.
pub fn mean_bound() -> f64 {
    if is_nightly() { 0.003 } else { 0.01 }
}

/// Settings for a square film.
pub fn settings(size: usize, integrator: IntegratorSettings, seed: u32) -> RenderSettings {
    RenderSettings { width: size as u32, height: size as u32, seed, integrator, ..RenderSettings::default() }
}

/// Batches of a case in about the time of `samples` of `path`.
pub fn estimate(
    device: &Arc<dyn Device>,
    scene: &Scene,
    size: usize,
    case: &Case,
    samples: u64,
) -> Vec<Image> {
    estimate_by(device, scene, &settings(size, case.settings, seed_of(case)), case, samples)
}

/// As [`estimate`], with other settings than the size; their integrator and seed are the case's.
pub fn estimate_with(
    device: &Arc<dyn Device>,
    scene: &Scene,
    settings: &RenderSettings,
    case: &Case,
    samples: u64,
) -> Vec<Image> {
    let settings = RenderSettings { integrator: case.settings, seed: seed_of(case), ..settings.clone() };
    estimate_by(device, scene, &settings, case, samples)
}

/// A second look at a case that failed, independent of the first and with four times the samples: a
/// fault shows the more, while one of some 40,000 blocks that was off by chance is not off again.
pub fn estimate_again(
    device: &Arc<dyn Device>,
    scene: &Scene,
    size: usize,
    case: &Case,
    samples: u64,
) -> Vec<Image> {
    estimate_by(device, scene, &settings(size, case.settings, !seed_of(case)), case, 4 * samples)
}

fn estimate_by(
    device: &Arc<dyn Device>,
    scene: &Scene,
    settings: &RenderSettings,
    case: &Case,
    samples: u64,
) -> Vec<Image> {
    let scale = if is_nightly() { NIGHTLY_SAMPLES } else { 1 };
    let affordable = (scale * samples) as f64 / case.cost;
    let n = if affordable < BATCHES as f64 { FEW_BATCHES } else { BATCHES };
    let each = (affordable / n as f64) as u64;
    batches(device, scene, settings, n, each.max(1))
}

/// Each case has a seed of its own (FNV-1a of its name): joins that share light paths would share
/// their luck, and Welch's test asks for independent estimates.
fn seed_of(case: &Case) -> u32 {
    case.name().bytes().fold(0x811c_9dc5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

/// Prints every comparison; fails at the end if one did.
#[derive(Default)]
pub struct Report {
    failures: Vec<String>,
}

impl Report {
    /// One comparison: blocks and mean agree, and the mean is within `bound`, where there is one.
    pub fn check(&mut self, name: &str, agreement: &Agreement, bound: Option<f64>) {
        let holds = agreement.holds() && bound.is_none_or(|bound| agreement.mean_within(bound));
        self.note(&format!("{name}: {agreement}"), holds);
    }

    /// As [`Report::check`], bounded where the standard errors that a mean may be off are within the
    /// bound: elsewhere it would test the number of samples.
    pub fn check_where_reachable(&mut self, name: &str, agreement: &Agreement) {
        let bound = mean_bound();
        let reachable = MEAN_ERRORS * agreement.ratio_error <= bound;
        self.check(name, agreement, reachable.then_some(bound));
    }

    /// One statement, and whether it holds.
    pub fn note(&mut self, text: &str, holds: bool) {
        let mark = if holds { "ok  " } else { "FAIL" };
        println!("{mark} {text}");
        if !holds {
            self.failures.push(text.to_owned());
        }
    }

    /// Fails if a comparison did.
    pub fn finish(self) {
        assert!(self.failures.is_empty(), "{} failed:\n{}", self.failures.len(), self.failures.join("\n"));
    }
}
