//! The fifth table of `crates/kernels/src/albedo.bin`: what a coat and a sheen hold back of the light of a
//! white interface below them (`crates/kernels/wgsl/lib/albedo.wgsl`).
//!
//! S(w) is what they let through. Facets' f is multiplied by min(S(wo), S(wi)), so what is missing of S(wo) is
//! E[max(S(wo) - S(wi), 0)] over where the interface sends light: where S grows with the cosine this is linear
//! in S. It is fitted by least squares, as a sum over a few cosines of 1 - S there, with factors that are
//! functions of the direction, for coats and sheens of many roughnesses and strengths at once.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;
use midway_kernels::constants as k;

use crate::{
    albedo::{self, Curve},
    stretched::{self, direction},
};

/// Cosines that the factors belong to.
const NODES: usize = 4;
/// Powers of a direction's root, and functions of its azimuth.
const POWERS: usize = 4;
const FUNCTIONS: usize = 3;
const TERMS: usize = POWERS * FUNCTIONS;
const ALPHAS: usize = k::HELD_ALPHAS as usize;
const RATIOS: usize = k::HELD_RATIOS as usize;
/// Directions that are fitted to: cosines and azimuths.
const COSINES: usize = 11;
const AZIMUTHS: usize = 7;
/// Bins of the cosine that light leaves by.
const BINS: usize = 1000;
/// Cells of the lobe of multiple bounces, in the squared cosine and in a quarter turn.
const BOUNCE_CELLS: [usize; 2] = [32, 8];
/// Entries of the first table whose coats are fitted to, 0 a smooth one; and whose sheens are.
const COATS: [u32; 9] = [0, 1, 2, 3, 5, 6, 9, 12, 15];
const SHEENS: [u32; 6] = [3, 5, 6, 8, 11, 15];

/// All numbers, in the order of the table.
pub fn table() -> Vec<f64> {
    let shapes = shapes();
    let nodes = pseudo_inverse(&shapes.iter().map(at_nodes).collect::<Vec<_>>());
    let places = pseudo_inverse(&directions().map(terms).collect::<Vec<_>>());
    let alphas = pseudo_inverse(&half_steps::<ALPHAS>());
    let ratios = pseudo_inverse(&half_steps::<RATIOS>());
    let mut numbers = vec![0.0; ALPHAS * RATIOS * TERMS * NODES];
    for (a, of_alpha) in alphas.iter().enumerate() {
        for (r, of_ratio) in ratios.iter().enumerate() {
            let larger = (a as f64 / (2 * ALPHAS - 2) as f64).powi(2).max(1e-4);
            let ratio = (r as f64 / (2 * RATIOS - 2) as f64).powi(2);
            let held = held_back([larger, (larger * ratio).max(1e-4)], &shapes);
            let mut factors = [[0.0; NODES]; TERMS];
            for (of_place, held) in places.iter().zip(&held) {
                for (of_shape, held) in nodes.iter().zip(held) {
                    for (term, p) in factors.iter_mut().zip(of_place) {
                        term.iter_mut().zip(of_shape).for_each(|(sum, n)| *sum += p * n * held);
                    }
                }
            }
            for (i, numbers) in numbers.chunks_mut(TERMS * NODES).enumerate() {
                let weight = of_alpha[i / RATIOS] * of_ratio[i % RATIOS];
                let factors = factors.as_flattened().iter();
                numbers.iter_mut().zip(factors).for_each(|(sum, factor)| *sum += weight * factor);
            }
        }
    }
    numbers
}

/// S by the cosine, at the middle of each bin.
type Shape = Vec<f64>;

fn shapes() -> Vec<Shape> {
    let coats = COATS.map(coat);
    let sheens = SHEENS.map(|entry| {
        let [.., sheen] = albedo::alpha_curves(albedo::alpha_of(entry));
        by_cosine(|mu| albedo::at(&sheen, mu).clamp(0.0, 1.0))
    });
    let through = |strength: f64| move |held: &Shape| held.iter().map(|held| 1.0 - strength * held).collect();
    let both = |coat: &Shape, sheen: &Shape| -> Shape {
        coat.iter().zip(sheen).map(|(coat, sheen)| (1.0 - coat) * (1.0 - sheen)).collect()
    };
    let single = coats.iter().chain(&sheens);
    let mut shapes: Vec<Shape> = single.clone().map(through(1.0)).chain(single.map(through(0.5))).collect();
    for coat in coats.iter().step_by(2) {
        shapes.extend(sheens.iter().map(|sheen| both(coat, sheen)));
    }
    shapes
}

/// What a coat reflects.
fn coat(entry: u32) -> Shape {
    let f0 = f64::from(k::COAT_F0);
    if entry == 0 {
        return by_cosine(|mu| f0 + (1.0 - f0) * (1.0 - mu).powi(5));
    }
    let [loss, grazing, _]: [Curve; 3] = albedo::alpha_curves(albedo::alpha_of(entry));
    by_cosine(|mu| {
        let value = (1.0 - f0) * albedo::at(&grazing, mu) + f0 * (1.0 - albedo::at(&loss, mu));
        value.clamp(0.0, 1.0)
    })
}

fn by_cosine(value: impl Fn(f64) -> f64) -> Shape {
    (0..BINS).map(|bin| value((bin as f64 + 0.5) / BINS as f64)).collect()
}

/// A shape's value at a cosine, by the nearest bins.
fn value(shape: &Shape, mu: f64) -> f64 {
    let place = (mu * BINS as f64 - 0.5).clamp(0.0, (BINS - 1) as f64);
    let low = (place as usize).min(BINS - 2);
    shape[low] + (shape[low + 1] - shape[low]) * (place - low as f64)
}

fn at_nodes(shape: &Shape) -> [f64; NODES] {
    let nodes = [k::HELD_NODE_0, k::HELD_NODE_1, k::HELD_NODE_2, k::HELD_NODE_3];
    nodes.map(|mu| 1.0 - value(shape, f64::from(mu)))
}

fn directions() -> impl Iterator<Item = DVec3> {
    (0..COSINES * AZIMUTHS).map(|i| {
        let place = (i / AZIMUTHS) as f64 / (COSINES - 1) as f64;
        direction(0.02 + 0.97 * place.powf(1.5), (i % AZIMUTHS) as f64 / (AZIMUTHS - 1) as f64 * FRAC_PI_2)
    })
}

/// What multiplies the factors: for each power of the cosine's root, functions of the azimuth.
fn terms(wo: DVec3) -> [f64; TERMS] {
    let q = f64::from(k::HELD_BLEND);
    let share = wo.y * wo.y / (wo.x * wo.x + wo.y * wo.y).max(1e-20);
    let functions = [1.0, share, q * share / (1.0 - (1.0 - q) * share)];
    std::array::from_fn(|i| functions[i % FUNCTIONS] * wo.z.sqrt().powi((i / FUNCTIONS) as i32))
}

/// Weights of N entries at each of them and half way between.
fn half_steps<const N: usize>() -> Vec<[f64; N]> {
    let weight = |i: usize, entry: usize| (1.0 - (i as f64 / 2.0 - entry as f64).abs()).max(0.0);
    (0..2 * N - 1).map(|i| std::array::from_fn(|entry| weight(i, entry))).collect()
}

/// What is held back towards each direction, of each shape. The larger α is the first.
fn held_back(alpha: [f64; 2], shapes: &[Shape]) -> Vec<Vec<f64>> {
    let [cosines, azimuths] = BOUNCE_CELLS;
    let place = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
    let cells = (0..cosines * azimuths).map(|i| {
        let wi = direction(place(i % cosines, cosines).sqrt(), place(i / cosines, azimuths) * FRAC_PI_2);
        (wi.z, 1.0 - stretched::albedos(alpha, wi)[0])
    });
    let cells: Vec<(f64, f64)> = cells.collect();
    let all_lost = cells.iter().map(|(_, loss)| loss).sum::<f64>().max(1e-12);
    let at = |wo: DVec3| {
        let mut bins = vec![0.0; BINS];
        let mut add = |mu: f64, weight: f64| bins[((mu * BINS as f64) as usize).min(BINS - 1)] += weight;
        stretched::reflected(alpha, wo, |wi, weight, _| add(wi.z, weight));
        let lost = 1.0 - stretched::albedos(alpha, wo)[0];
        cells.iter().for_each(|&(mu, loss)| add(mu, lost * loss / all_lost));
        let of = |shape: &Shape| {
            let through = value(shape, wo.z);
            bins.iter().zip(shape).map(|(weight, below)| weight * (through - below).max(0.0)).sum()
        };
        shapes.iter().map(of).collect()
    };
    directions().map(at).collect()
}

/// For each row of a matrix what its value adds to the least squares' unknowns.
fn pseudo_inverse<const N: usize>(rows: &[[f64; N]]) -> Vec<[f64; N]> {
    let mut normal = [[0.0; N]; N];
    for row in rows {
        for (sums, a) in normal.iter_mut().zip(row) {
            sums.iter_mut().zip(row).for_each(|(sum, b)| *sum += a * b);
        }
    }
    rows.iter().map(|row| albedo::solve(normal, *row)).collect()
}
