//! Pixel filters: samples against their density, and splats against the same integral.

use std::f64::consts::TAU;

use midway_kernels::native::lib::{self, FILTER_BLACKMAN_HARRIS, FILTER_BOX, PixelFilter};

use crate::{
    chi_square::ChiSquare,
    support::{Random, assert_near},
};

const N: usize = 400_000;

fn filters() -> Vec<PixelFilter> {
    let width = |kind| [0.7, 1.0, 2.5, 3.0, 16.0].map(|width| PixelFilter { kind, width });
    [FILTER_BOX, FILTER_BLACKMAN_HARRIS].into_iter().flat_map(width).collect()
}

/// By the definition (Harris 1978, table 1).
fn expected(filter: PixelFilter, x: f64) -> f64 {
    let width = f64::from(filter.width);
    let turn = TAU * x / width;
    let window = if filter.kind == FILTER_BOX {
        1.0
    } else {
        1.0 + (0.48829 * turn.cos() + 0.14128 * (2.0 * turn).cos() + 0.01168 * (3.0 * turn).cos()) / 0.35875
    };
    if x.abs() <= 0.5 * width { window / width } else { 0.0 }
}

#[test]
fn values_are_the_windows() {
    let mut random = Random::new(20);
    for filter in filters() {
        for _ in 0..2000 {
            let x = random.between(-0.6, 0.6) * f64::from(filter.width);
            let value = f64::from(lib::filter_value(filter, x as f32));
            assert_near(value, expected(filter, f64::from(x as f32)), 2e-6, &format!("{filter:?} at {x}"));
        }
    }
}

fn histogram(filter: PixelFilter, seed: u64, n_bins: usize) -> Vec<u64> {
    let mut random = Random::new(seed);
    let mut bins = vec![0; n_bins];
    for _ in 0..N {
        let t = f64::from(lib::sample_filter(filter, random.unit()) / filter.width) + 0.5;
        assert!((0.0..=1.0).contains(&t), "{filter:?}: {t}");
        bins[((t * n_bins as f64) as usize).min(n_bins - 1)] += 1;
    }
    bins
}

/// What each of `n_bins` over the width should hold, by midpoints.
fn expected_bins(filter: PixelFilter, n_bins: usize) -> Vec<f64> {
    const CELLS: usize = 64;
    let width = f64::from(filter.width);
    let cell = width / (n_bins * CELLS) as f64;
    let value = |i: usize| expected(filter, (i as f64 + 0.5) * cell - 0.5 * width) * cell * N as f64;
    (0..n_bins).map(|bin| (bin * CELLS..(bin + 1) * CELLS).map(value).sum()).collect()
}

#[test]
fn offsets_have_the_filters_density() {
    for (seed, filter) in (21..).zip(filters()) {
        let observed = histogram(filter, seed, 100);
        let bins = expected_bins(filter, 100);
        let scale = N as f64 / bins.iter().sum::<f64>(); // quadrature's own error, below 1e-6
        assert_near(scale, 1.0, 1e-5, "mass");
        let bins: Vec<f64> = bins.iter().map(|bin| bin * scale).collect();
        ChiSquare::of(&observed, &bins).assert_holds(&format!("sample_filter of {filter:?}"));
    }
}

#[test]
fn a_wider_window_is_rejected() {
    let filter = PixelFilter { kind: FILTER_BLACKMAN_HARRIS, width: 3.0 };
    let wider = |t: f64| expected(filter, 3.0 * t / 1.01);
    let bins: Vec<f64> = (0..100).map(|i| wider((f64::from(i) + 0.5) / 100.0 - 0.5)).collect();
    let scale = N as f64 / bins.iter().sum::<f64>();
    let bins: Vec<f64> = bins.iter().map(|bin| bin * scale).collect();
    ChiSquare::of(&histogram(filter, 40, 100), &bins).assert_rejects("a window 1 % wider");
}

/// Whatever the splat's place, each pixel is given its own filter's value there.
#[test]
fn a_splat_brings_each_pixel_its_filters_value() {
    const DRAWS: usize = 8192;
    let mut random = Random::new(41);
    for filter in filters() {
        for _ in 0..40 {
            let x = random.between(40.0, 60.0) as f32;
            let mut given = [0.0; 100];
            for draw in 0..DRAWS {
                let u = (draw as f32 + 0.5) / DRAWS as f32;
                let picked = lib::pick_pixel(filter, x, u);
                given[picked.place as usize] += f64::from(picked.weight) / DRAWS as f64;
            }
            for (pixel, given) in given.iter().enumerate() {
                let value = expected(filter, f64::from(x) - (pixel as f64 + 0.5));
                // The even draws' own error, some 1/8192 of the sum; a box's edge may lie at x.
                let at_edge = expected(filter, f64::from(x) - (pixel as f64 + 0.5) * (1.0 + 1e-7)) != value;
                assert!(at_edge || (given - value).abs() <= 1e-3, "{filter:?} {x} {pixel}: {given}, {value}");
            }
        }
    }
}
