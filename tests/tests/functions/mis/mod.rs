//! MIS weights, by cameras whose rays spread and by parallel ones: those of one path over all strategies in use sum to 1, and each is what its
//! definition says, for every integrator's set of strategies and both heuristics.

mod chain;

use chain::{Chain, Origin};
use midway_kernels::native::lib::MisConfig;

use crate::support::Random;

/// A weight's error, relative; f32 loses some 1e-6 a vertex, squared densities twice that.
const WEIGHT_TOLERANCE: f64 = 1e-3;
/// The error of a sum of weights.
const SUM_TOLERANCE: f64 = 1e-4;
/// Paths of each length for each configuration.
const N_PATHS: usize = 150;
const LONGEST: usize = 8;

/// Every set of strategies that an integrator uses, with both heuristics.
fn configurations() -> Vec<(&'static str, MisConfig)> {
    let config = |nee, single_step, join, splat| MisConfig { power: 0, nee, single_step, join, splat };
    let sets = [
        ("path-naive", config(0, 0, 0.0, 0.0)),
        ("path", config(1, 0, 0.0, 0.0)),
        ("full", config(1, 0, 1.0, 300.0)),
        ("full without splats", config(1, 0, 1.0, 0.0)),
        ("k-step, K below L", config(1, 0, 0.37, 4.0)),
        ("pool, K above L", config(1, 0, 2.5, 4.0)),
        ("pool of few paths", config(1, 0, 0.2, 0.05)),
        ("single-step", config(0, 1, 1.0, 0.0)),
        ("single-step with nee", config(1, 1, 1.0, 0.0)),
        ("single-step with splat", config(0, 1, 1.0, 4.0)),
        ("single-step with nee and splat", config(1, 1, 1.0, 4.0)),
    ];
    let both =
        |(name, config): (&'static str, MisConfig)| [0, 1].map(|power| (name, MisConfig { power, ..config }));
    sets.into_iter().flat_map(both).collect()
}

/// `n` paths of each length from 2 edges up, from lights of each kind in turn.
fn chains(config: MisConfig, n: usize, seed: u64) -> Vec<Chain> {
    let mut random = Random::new(seed);
    let mut chains = Vec::new();
    for edges in 2..=LONGEST {
        let mut origins = Origin::ALL.into_iter().cycle();
        let mut next = || origins.next().expect("a cycle has no end");
        let fit = std::iter::repeat_with(|| Chain::new(edges, next(), config, &mut random));
        chains.extend(fit.filter(|chain| !chain.is_degenerate()).take(n));
    }
    chains
}

#[test]
fn weights_are_what_their_definition_says() {
    for (seed, (name, config)) in (100..).zip(configurations()) {
        for chain in chains(config, N_PATHS, seed).iter().filter(|chain| chain.is_possible(config)) {
            let expected = chain.weights_by_definition(config);
            let actual = chain.weights_by_recursion(config, chain, config);
            for (s, (actual, expected)) in actual.iter().zip(&expected).enumerate() {
                let error = (actual - expected).abs();
                let tolerance = WEIGHT_TOLERANCE * expected + 1e-7;
                assert!(
                    error <= tolerance,
                    "{name}, s = {s}: {actual}, not {expected}: {config:?} {chain:?}"
                );
            }
        }
    }
}

#[test]
fn weights_sum_to_one() {
    for (seed, (name, config)) in (200..).zip(configurations()) {
        for chain in chains(config, N_PATHS, seed).iter().filter(|chain| chain.is_possible(config)) {
            let sum = sum_of_weights(chain, config, chain, config);
            assert!((sum - 1.0).abs() <= SUM_TOLERANCE, "{name}: the sum is {sum}: {config:?} {chain:?}");
        }
    }
}

/// The test means something only where several strategies share the path.
#[test]
fn several_strategies_share_most_paths() {
    for (name, config) in configurations().into_iter().filter(|(name, _)| *name != "path-naive") {
        let mut chains = chains(config, 20, 300);
        chains.retain(|chain| chain.is_possible(config));
        let shared = chains.iter().filter(|chain| {
            chain.weights_by_definition(config).iter().filter(|weight| **weight > 1e-4).count() >= 2
        });
        let share = shared.count() as f64 / chains.len() as f64;
        assert!(share >= 0.3, "{name}: {share} of the paths have two strategies");
    }
}

fn sum_of_weights(chain: &Chain, config: MisConfig, walk: &Chain, walk_config: MisConfig) -> f64 {
    chain.weights_by_recursion(config, walk, walk_config).iter().sum()
}

/// Of the paths, the share whose weights' sum is off by more than a correct one's may be.
fn share_caught(config: MisConfig, mistake: impl Fn(&Chain) -> (Chain, MisConfig)) -> f64 {
    let mut chains = chains(config, 20, 400);
    chains.retain(|chain| chain.is_possible(config));
    let caught = chains.iter().filter(|chain| {
        let (walk, walk_config) = mistake(chain);
        let error = (sum_of_weights(chain, config, &walk, walk_config) - 1.0).abs();
        error.is_nan() || error > SUM_TOLERANCE
    });
    caught.count() as f64 / chains.len() as f64
}

fn named(name: &str) -> MisConfig {
    configurations().into_iter().find(|(n, _)| *n == name).expect("a configuration's name").1
}

#[test]
fn two_per_cent_off_in_a_factor_is_caught() {
    for (name, mistake) in [
        ("full", (|c| MisConfig { join: c.join * 1.02, ..c }) as fn(MisConfig) -> MisConfig),
        ("k-step, K below L", |c| MisConfig { join: c.join * 0.98, ..c }),
        ("pool of few paths", |c| MisConfig { splat: c.splat * 1.02, ..c }),
        ("single-step", |c| MisConfig { join: c.join * 1.02, ..c }),
        ("single-step with nee", |c| MisConfig { nee: 0, ..c }),
        ("single-step", |c| MisConfig { single_step: 0, ..c }),
    ] {
        let config = named(name);
        let share = share_caught(config, |chain| (chain.clone(), mistake(config)));
        assert!(share >= 0.2, "{name}: caught on {share} of the paths only");
        assert_eq!(share_caught(config, |chain| (chain.clone(), config)), 0.0, "{name} without a mistake");
    }
}

#[test]
fn swapped_densities_are_caught() {
    for name in ["path", "full", "single-step with nee and splat"] {
        let config = named(name);
        let share = share_caught(config, |chain| {
            let mut walk = chain.clone();
            std::mem::swap(&mut walk.forward[1], &mut walk.reverse[1]);
            (walk, config)
        });
        assert!(share >= 0.3, "{name}: caught on {share} of the paths only");
    }
}

#[test]
fn parallel_rays_taken_for_others_are_caught() {
    for name in ["full", "pool of few paths", "single-step with splat"] {
        let share = share_caught(named(name), |chain| {
            let mut walk = chain.clone();
            walk.parallel = !walk.parallel;
            (walk, named(name))
        });
        assert!(share >= 0.2, "{name}: caught on {share} of the paths only");
    }
}

#[test]
fn a_delta_vertex_taken_for_another_is_caught() {
    let config = named("full");
    let share = share_caught(config, |chain| {
        let mut walk = chain.clone();
        walk.is_delta[1] = !walk.is_delta[1];
        (walk, config)
    });
    assert!(share >= 0.5, "caught on {share} of the paths only");
}
