//! Every integrator with every join, as proofs go through them.

use midway_render::{Integrator, IntegratorSettings, Join, JoinChoice, LightPaths};

/// An integrator with its options.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The options.
    pub settings: IntegratorSettings,
    /// Time of a sample, roughly, where `path` takes 1 (measured on the CPU, Cornell box).
    pub cost: f64,
}

impl Case {
    /// Its options in words.
    pub fn name(&self) -> String {
        self.settings.describe()
    }

    /// The same with another source of light vertices.
    fn with_pool(mut self, cost: f64) -> Self {
        self.settings.light_paths = LightPaths::Pool(None);
        self.cost = cost;
        self
    }
}

/// `path-naive`.
pub fn path_naive() -> Case {
    simple(Integrator::PathNaive, 0.7)
}

/// `path`.
pub fn path() -> Case {
    simple(Integrator::Path, 1.0)
}

/// `light`.
pub fn light() -> Case {
    simple(Integrator::Light, 1.3)
}

/// `bdpt`, join `full`, one light path a sample.
pub fn full() -> Case {
    bdpt(Join::Full, 3.0)
}

/// `bdpt`, join `single-step`, with s = 1 and t = 1 everywhere or not.
pub fn single_step(nee: bool, splat: bool) -> Case {
    let mut case = bdpt(Join::SingleStep, if nee || splat { 2.2 } else { 1.5 });
    case.settings.nee = Some(nee);
    case.settings.splat = Some(splat);
    case
}

/// `bdpt`, join `k-step`.
pub fn k_step(k: u32, join_choice: JoinChoice) -> Case {
    let joins = if join_choice == JoinChoice::Importance { k } else { k.min(3) };
    let mut case = bdpt(Join::KStep, 2.0 + 0.4 * f64::from(joins));
    case.settings.k = k;
    case.settings.join_choice = join_choice;
    case
}

/// K of the proofs: one, the default, and more than nearly every light path holds.
pub const KS: [u32; 3] = [1, 3, 50];

/// All joins of `bdpt`, with one light path a sample and from a pool.
pub fn joins() -> Vec<Case> {
    let mut cases = vec![full(), full().with_pool(3.2)];
    for k in KS {
        let uniform = k_step(k, JoinChoice::Uniform);
        let importance = k_step(k, JoinChoice::Importance);
        let joins = f64::from(k);
        cases.extend([
            uniform,
            importance,
            uniform.with_pool(2.4 + 0.4 * joins),
            importance.with_pool(3.0 + 1.4 * joins),
        ]);
    }
    for (nee, splat) in [(false, false), (true, false), (false, true), (true, true)] {
        cases.push(single_step(nee, splat));
    }
    cases.push(single_step(false, false).with_pool(1.5));
    cases.push(single_step(true, true).with_pool(2.2));
    cases
}

/// All of them.
pub fn all() -> Vec<Case> {
    [path_naive(), path(), light()].into_iter().chain(joins()).collect()
}

/// Those from one end, `full`, and a third of the other joins, by a scene's name: over many scenes all
/// of them are met.
pub fn share(scene: &str) -> Vec<Case> {
    let turn = scene.bytes().map(usize::from).sum::<usize>() % 3;
    let others = joins().into_iter().skip(1).enumerate().filter(|(i, _)| i % 3 == turn).map(|(_, case)| case);
    [path_naive(), path(), light(), full()].into_iter().chain(others).collect()
}

fn simple(integrator: Integrator, cost: f64) -> Case {
    Case { settings: IntegratorSettings { integrator, ..Default::default() }, cost }
}

fn bdpt(join: Join, cost: f64) -> Case {
    Case { settings: IntegratorSettings { integrator: Integrator::Bdpt, join, ..Default::default() }, cost }
}
