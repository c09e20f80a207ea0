//! The Sobol points: nets in every draw, uniform over paths and seeds, and of one draw nothing to be
//! learned of another.

use midway_kernels::native::lib;
use wgsl_cpu::runtime::Vec4;

use crate::{
    chi_square::{ChiSquare, histogram, histogram2},
    random_numbers::least_p_of_all_pairs,
};

const SEED: u32 = 3;

fn draw(path: u32, sample: u32) -> Vec4<f32> {
    lib::unit_float(lib::sobol_bits(path, sample, lib::dimension(lib::DRAW_SCATTER, 1), SEED))
}

/// How many of the samples from `first` lie in each cell of a grid over two components.
fn grid(path: u32, first: u32, log2_n: u32, axes: [(u32, u32); 2]) -> Vec<u32> {
    let mut counts = vec![0; 1 << (axes[0].1 + axes[1].1)];
    for sample in first..first + (1 << log2_n) {
        let point = draw(path, sample);
        let cell = axes.map(|(axis, log2_cells)| (point.at(axis) * (1u32 << log2_cells) as f32) as usize);
        counts[cell[0] << axes[1].1 | cell[1]] += 1;
    }
    counts
}

/// Any 2ᵐ samples that start at a multiple of 2ᵐ have one in each of 2ᵐ intervals of each component,
/// and in each elementary box of the first two: a (0, 2)-sequence (Sobol 1967; Niederreiter 1992).
#[test]
fn aligned_samples_are_nets() {
    for (path, log2_n) in (0..8).flat_map(|path| [1, 4, 8].map(|log2_n| (path, log2_n))) {
        for first in [0, 5, 255].map(|block| block << log2_n) {
            for axis in 0..4 {
                let counts = grid(path, first, log2_n, [(axis, log2_n), (0, 0)]);
                assert!(counts.iter().all(|n| *n == 1), "path {path}, from {first}, component {axis}");
            }
            for split in 0..=log2_n {
                let counts = grid(path, first, log2_n, [(0, split), (1, log2_n - split)]);
                assert!(counts.iter().all(|n| *n == 1), "path {path}, from {first}, boxes of 2^-{split}");
            }
        }
    }
}

/// Pairs of the later components have quality t = 1 to 3: 256 points fill 8 x 8 cells evenly or
/// nearly so, where independent ones leave a cell in fifty empty.
#[test]
fn all_pairs_of_components_are_stratified() {
    for (path, (a, b)) in
        (0..8).flat_map(|path| [(0, 2), (0, 3), (1, 2), (1, 3), (2, 3)].map(move |pair| (path, pair)))
    {
        let counts = grid(path, 0, 8, [(a, 3), (b, 3)]);
        assert!(
            counts.iter().all(|n| (2..=6).contains(n)),
            "path {path}, components {a} and {b}: {counts:?}"
        );
    }
}

/// Each sample by itself is uniform over paths, to the last bits, and so are pairs of components.
#[test]
fn one_sample_of_many_paths_is_uniform() {
    const PATHS: u32 = 1 << 18;
    for sample in [0, 1, 37, 65_536] {
        let points: Vec<Vec4<f32>> = (0..PATHS).map(|path| draw(path, sample)).collect();
        for axis in 0..4 {
            let coarse = histogram(1000, points.iter().map(|p| p.at(axis)));
            ChiSquare::uniform(&coarse).assert_holds(&format!("sample {sample}, component {axis}"));
            let fine = histogram(1024, points.iter().map(|p| (p.at(axis) * 4096.0).fract()));
            ChiSquare::uniform(&fine).assert_holds(&format!("sample {sample}, component {axis}, fine"));
            let pair = histogram2(32, points.iter().map(|p| (p.at(axis), p.at((axis + 1) % 4))));
            ChiSquare::uniform(&pair).assert_holds(&format!("sample {sample}, components from {axis}"));
        }
    }
}

/// As the hash's: joins multiply numbers of different purposes. The second shift is to the next path,
/// the third to the next sample of the same path.
#[test]
fn all_purposes_are_independent() {
    for shift in [0, 1, 256] {
        let p = least_p_of_all_pairs(lib::sobol_bits, shift);
        assert!(p >= 1e-3, "counters {shift} apart: {p:e}");
    }
}

/// The test above sees purposes that share one sequence.
#[test]
fn one_sequence_for_all_purposes_is_rejected() {
    let shared = |path, sample, _, seed| lib::sobol_bits(path, sample, 0, seed);
    let p = least_p_of_all_pairs(shared, 0);
    assert!(p <= 1e-9, "{p:e}");
}

/// Beyond the bits that address one sequence the next begins, scrambled anew.
#[test]
fn later_sequences_differ() {
    let period = 1 << lib::SOBOL_BITS;
    let same = (0..256).filter(|&i| (0..4).any(|axis| draw(1, i).at(axis) == draw(1, i + period).at(axis)));
    assert!(same.count() <= 1);
}

/// The mean of a smooth function over 256 samples has less than a tenth of the variance that
/// independent samples give it.
#[test]
fn means_of_smooth_functions_converge_faster() {
    let f = |p: Vec4<f32>| (p.x * p.y).sin() + p.z * p.z * p.w;
    let variance = |bits: fn(u32, u32, u32, u32) -> Vec4<u32>| {
        let mean = |path: u32| {
            (0..256).map(|sample| f64::from(f(lib::unit_float(bits(path, sample, 9, SEED))))).sum::<f64>()
                / 256.0
        };
        let means: Vec<f64> = (0..64).map(mean).collect();
        let centre = means.iter().sum::<f64>() / 64.0;
        means.iter().map(|mean| (mean - centre).powi(2)).sum::<f64>() / 63.0
    };
    let (sobol, hash) = (variance(lib::sobol_bits), variance(lib::draw_bits));
    assert!(sobol <= 0.1 * hash, "{sobol:e} against {hash:e}");
}
