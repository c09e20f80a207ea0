//! The tables of albedos: that they are what the definitions give.

use midway_kernels::{ALBEDO_TABLES, constants as k};
use midway_tests::{
    albedo::{self, Curve, TERMS},
    held_back, stretched, stretched_solid,
};

/// The test computes one entry of so many: all of them take 30 s, and those of solids two minutes more.
const EVERY: usize = 17;
/// Numbers of the first two tables, and of an entry of the third.
const N_OF_CURVES: usize = 4 * k::STRETCHED_AT as usize;
const N_OF_STRETCHED: usize = 4 * k::STRETCHED_STRIDE as usize;
/// Numbers of the first three tables, and of a row of the fourth, whose entries are fitted together.
const N_BEFORE_SOLID: usize = 4 * k::SOLID_AT as usize;
const N_OF_SOLID_ROW: usize = 4 * (k::SOLID_STRIDE * k::SOLID_RATIOS * k::SOLID_INDICES) as usize;
/// The row that the test computes: α 0.48.
const ROW: u32 = 9;

fn stored_numbers() -> Vec<f64> {
    let (floats, rest) = ALBEDO_TABLES.as_chunks::<4>();
    assert!(rest.is_empty() && floats.len() == 4 * k::ALBEDO_SIZE as usize);
    floats.iter().map(|&b| f64::from(f32::from_le_bytes(b))).collect()
}

fn stored() -> Vec<Curve> {
    stored_numbers()[..N_OF_CURVES].as_chunks::<TERMS>().0.to_vec()
}

/// `MIDWAY_WRITE_TABLES=1` writes them anew.
#[test]
fn tables_are_those_of_the_definitions() {
    if std::env::var("MIDWAY_WRITE_TABLES").as_deref() == Ok("1") {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../crates/kernels/src/albedo.bin");
        let numbers = albedo::tables(1).into_iter().flatten();
        let all = numbers.chain(stretched::table(1).into_iter().flat_map(|entry| entry.numbers()));
        let solid = (0..k::SOLID_ALPHAS).flat_map(stretched_solid::row).flatten();
        let all = all.chain(solid).chain(held_back::table());
        std::fs::write(path, albedo::bytes(all)).expect("the tables are written");
        return;
    }
    let computed = albedo::tables(EVERY);
    let stored = stored();
    let groups = stored.chunks(3).step_by(EVERY).flatten();
    assert_eq!(groups.clone().count(), computed.len());
    for (i, (stored, computed)) in groups.zip(&computed).enumerate() {
        for mu in [0.0, 0.05, 0.2, 0.5, 1.0] {
            let error = (albedo::at(stored, mu) - albedo::at(computed, mu)).abs();
            assert!(error <= 1e-4, "curve {i} at {mu}: off by {error}");
        }
    }
}

/// Of facets of two α too.
#[test]
fn the_stretched_table_is_that_of_the_definitions() {
    let stored = stored_numbers();
    let entries = stored[N_OF_CURVES..N_BEFORE_SOLID].chunks(N_OF_STRETCHED).step_by(EVERY);
    let computed = stretched::table(EVERY);
    assert_eq!(entries.len(), computed.len());
    for (i, (stored, computed)) in entries.zip(&computed).enumerate() {
        for (at, (stored, computed)) in stored.iter().zip(computed.numbers()).enumerate() {
            // Rounding to f32 of what was computed.
            let error = (stored - computed).abs();
            assert!(error <= 1e-4 * computed.abs().max(1.0), "entry {i}, number {at}: off by {error}");
        }
    }
}

/// And of those between dielectrics.
#[test]
fn the_solid_table_is_that_of_the_definitions() {
    let stored = &stored_numbers()[N_BEFORE_SOLID + ROW as usize * N_OF_SOLID_ROW..][..N_OF_SOLID_ROW];
    let computed: Vec<f64> = stretched_solid::row(ROW).into_iter().flatten().collect();
    assert_eq!(stored.len(), computed.len());
    for (i, (stored, computed)) in stored.iter().zip(computed).enumerate() {
        let error = (stored - computed).abs();
        assert!(error <= 1e-4 * computed.abs().max(1.0), "number {i}: {stored}, not {computed}");
    }
}

/// And of what layers hold back.
#[test]
fn the_table_of_layers_is_that_of_the_definitions() {
    let stored = &stored_numbers()[4 * k::HELD_AT as usize..];
    let computed = held_back::table();
    assert_eq!(stored.len(), computed.len());
    for (i, (stored, computed)) in stored.iter().zip(computed).enumerate() {
        let error = (stored - computed).abs();
        assert!(error <= 1e-4 * computed.abs().max(1.0), "number {i}: {stored}, not {computed}");
    }
}

/// Curves at cosines they were not fitted at, against quadrature.
#[test]
fn curves_are_near_what_they_stand_for() {
    for alpha in [0.05, 0.3, 0.9] {
        let entry = f64::from(k::ALBEDO_ALPHAS - 1) * f64::sqrt(alpha);
        let [low, high] = [entry.floor(), entry.ceil()].map(|entry| stored()[3 * entry as usize]);
        for mu in [0.05, 0.2, 0.7, 1.0] {
            let t = entry.fract();
            let curve = albedo::at(&low, mu) * (1.0 - t) + albedo::at(&high, mu) * t;
            let loss = 1.0 - albedo::mirror_albedo(alpha, mu, |_| 1.0);
            assert!((curve - loss).abs() <= 0.012, "α {alpha} at {mu}: {curve}, not {loss}");
        }
    }
}
