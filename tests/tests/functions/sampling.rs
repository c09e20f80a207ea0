//! Samplers of disks, hemispheres, triangles, and lights, against their densities.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use midway_kernels::native::lib;
use wgsl_cpu::runtime::{Vec2, Vec3};

use crate::{
    chi_square::{Cap, ChiSquare, histogram2},
    support::{Random, assert_near, double, single},
};

const N: u64 = 400_000;

#[test]
fn disk_is_uniform_in_area() {
    let mut random = Random::new(1);
    let polar = (0..N).map(|_| {
        let d = lib::sample_disk(random.unit2());
        let radius2 = f64::from(d.x).powi(2) + f64::from(d.y).powi(2);
        assert!(radius2 <= 1.0 + 1e-6, "{d:?} is outside the disk");
        let angle = f64::from(d.y).atan2(f64::from(d.x)) / TAU;
        ((radius2 as f32).min(0.999_999), ((angle - angle.floor()) as f32).min(0.999_999))
    });
    ChiSquare::uniform(&histogram2(30, polar)).assert_holds("sample_disk");
}

/// A common mistake, which the test above must see: the radius not a square root.
#[test]
fn disk_with_linear_radius_is_rejected() {
    let mut random = Random::new(2);
    let polar = (0..N).map(|_| (random.unit().powi(2), random.unit()));
    ChiSquare::uniform(&histogram2(30, polar)).assert_rejects("a linear radius");
}

#[test]
fn disk_is_finite_at_the_edges_of_the_square() {
    for a in [0.0, 0.25, 0.5, 0.75, 0.999_999_94f32] {
        for b in [0.0, 0.25, 0.5, 0.75, 0.999_999_94f32] {
            let d = lib::sample_disk(Vec2::new(a, b));
            assert!(d.x.hypot(d.y) <= 1.000_001, "{a} {b}: {d:?}");
        }
    }
    assert_eq!(lib::sample_disk(Vec2::splat(0.5)), Vec2::splat(0.0));
}

#[test]
fn cosine_hemisphere_has_its_density() {
    let mut random = Random::new(3);
    let mut sample = || {
        let d = double(lib::sample_cosine_hemisphere(random.unit2()));
        assert_near(d.length(), 1.0, 1e-6, "length");
        Some(d)
    };
    Cap::sphere().test(N, &mut sample, |d| d.z.max(0.0) / PI).assert_holds("sample_cosine_hemisphere");
    let uniform = |d: DVec3| if d.z > 0.0 { 1.0 / TAU } else { 0.0 };
    Cap::sphere().test(N, &mut sample, uniform).assert_rejects("a uniform hemisphere");
}

/// A bias of a few per cent between bins is seen, not only gross errors.
#[test]
fn a_slightly_wrong_density_is_rejected() {
    let mut random = Random::new(4);
    let sample = || Some(double(lib::sample_cosine_hemisphere(random.unit2())));
    let wrong = |d: DVec3| if d.z > 0.0 { 1.04 / TAU * 2.0 * d.z.powf(1.08) } else { 0.0 };
    Cap::sphere().test(N, sample, wrong).assert_rejects("cos^1.08");
}

#[test]
fn triangle_is_uniform_in_area() {
    const BINS: usize = 24;
    let mut random = Random::new(5);
    let samples = (0..N).map(|_| {
        let uv = lib::sample_triangle(random.unit2());
        assert!(uv.x >= 0.0 && uv.y >= 0.0 && uv.x + uv.y <= 1.000_001, "{uv:?} is outside");
        (uv.x.min(0.999_999), uv.y.min(0.999_999))
    });
    let observed = histogram2(BINS, samples);
    let cell = 2.0 * N as f64 / (BINS * BINS) as f64;
    let expected: Vec<f64> = (0..BINS * BINS)
        .map(|i| match (i / BINS + i % BINS).cmp(&(BINS - 1)) {
            std::cmp::Ordering::Less => cell,
            std::cmp::Ordering::Equal => cell / 2.0,
            std::cmp::Ordering::Greater => 0.0,
        })
        .collect();
    // Rounding may put a sample on the far side of the diagonal; it belongs to the cell before.
    let beyond: u64 = observed.iter().zip(&expected).filter(|(_, e)| **e == 0.0).map(|(o, _)| o).sum();
    assert!(beyond <= 5, "{beyond} samples outside the triangle");
    let inside: Vec<u64> =
        observed.iter().zip(&expected).map(|(o, e)| if *e > 0.0 { *o } else { 0 }).collect();
    let kept = (N - beyond) as f64 / N as f64;
    let expected: Vec<f64> = expected.iter().map(|e| e * kept).collect();
    ChiSquare::of(&inside, &expected).assert_holds("sample_triangle");
}

#[test]
fn emission_has_its_density() {
    let mut random = Random::new(6);
    for emits_back in [false, true] {
        for _ in 0..4 {
            let ng = single(random.direction());
            let sample = || Some(double(lib::sample_emission(ng, emits_back, random.unit3())));
            let pdf = |d: DVec3| f64::from(lib::emission_pdf_sa(d.dot(double(ng)) as f32, emits_back));
            let test = Cap::sphere().test(N, sample, pdf);
            test.assert_holds(&format!("sample_emission, back {emits_back}, about {ng:?}"));
        }
    }
}

#[test]
fn one_sided_density_of_a_two_sided_light_is_rejected() {
    let mut random = Random::new(7);
    let ng = Vec3::new(0.0, 0.6, 0.8);
    let sample = || Some(double(lib::sample_emission(ng, true, random.unit3())));
    let one_sided = |d: DVec3| f64::from(lib::emission_pdf_sa(d.dot(double(ng)) as f32, false));
    Cap::sphere().test(N, sample, one_sided).assert_rejects("a one-sided density");
}

/// An alias table by Vose's method: each cell's threshold and alias.
fn alias_table(weights: &[f64]) -> Vec<(f32, u32)> {
    let mean = weights.iter().sum::<f64>() / weights.len() as f64;
    let mut scaled: Vec<f64> = weights.iter().map(|w| w / mean).collect();
    let mut table: Vec<(f32, u32)> = (0..weights.len()).map(|i| (1.0, i as u32)).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..weights.len()).partition(|&i| scaled[i] < 1.0);
    while let (Some(s), Some(&l)) = (small.pop(), large.last()) {
        table[s] = (scaled[s] as f32, l as u32);
        scaled[l] -= 1.0 - scaled[s];
        if scaled[l] < 1.0 {
            small.push(l);
            large.pop();
        }
    }
    table
}

#[test]
fn alias_pick_has_the_chances_of_the_weights() {
    let mut random = Random::new(8);
    for n in [1, 2, 7, 300] {
        let mut weights: Vec<f64> = (0..n).map(|_| random.between(0.0, 1.0).powi(3)).collect();
        if n > 2 {
            weights[1] = 0.0;
        }
        let table = alias_table(&weights);
        let mut observed = vec![0; n];
        for _ in 0..N {
            let scaled = random.unit() * n as f32;
            let cell = (scaled as u32).min(n as u32 - 1);
            let (threshold, alias) = table[cell as usize];
            observed[lib::alias_pick(cell, scaled - cell as f32, threshold, alias) as usize] += 1;
        }
        let total: f64 = weights.iter().sum();
        if n == 1 {
            assert_eq!(observed, [N]);
            continue;
        }
        let expected: Vec<f64> = weights.iter().map(|w| w / total * N as f64).collect();
        ChiSquare::of(&observed, &expected).assert_holds(&format!("alias_pick of {n}"));
        let swapped: Vec<f64> = expected.iter().rev().copied().collect();
        ChiSquare::of(&observed, &swapped).assert_rejects("other weights");
    }
}
