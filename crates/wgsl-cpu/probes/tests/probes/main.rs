//! The probes, run natively against values computed here, and on a GPU against the native ones.

mod control;
mod numbers;
mod structures;
mod twins;

use wgsl_cpu_probes::{KERNELS, cases};

#[test]
fn every_probe_has_a_case() {
    let cases: Vec<_> = cases::all().iter().map(|case| case.kernel.name).collect();
    for kernel in KERNELS {
        assert!(cases.contains(&kernel.name), "{} has no case", kernel.name);
    }
    assert_eq!(cases.len(), KERNELS.len());
}

/// Asserts that all rows of `STRIDE` words are as expected, naming the first that is not.
fn assert_rows<const STRIDE: usize, I: std::fmt::Debug>(
    actual: &[u32],
    inputs: &[I],
    expected: impl Fn(&I) -> [u32; STRIDE],
) {
    assert_eq!(actual.len(), inputs.len() * STRIDE);
    for (input, row) in inputs.iter().zip(actual.chunks_exact(STRIDE)) {
        let expected = expected(input);
        for (i, (actual, expected)) in row.iter().zip(expected).enumerate() {
            assert!(*actual == expected, "output {i} for {input:?}: {actual:#x}, not {expected:#x}");
        }
    }
}

/// The same of floats, which may differ by `tolerance` of the greater of 1 and the value.
fn assert_float_rows<const STRIDE: usize, I: std::fmt::Debug>(
    actual: &[u32],
    inputs: &[I],
    tolerance: f64,
    expected: impl Fn(&I) -> [f64; STRIDE],
) {
    assert_eq!(actual.len(), inputs.len() * STRIDE);
    for (input, row) in inputs.iter().zip(actual.chunks_exact(STRIDE)) {
        let expected = expected(input);
        for (i, (&word, expected)) in row.iter().zip(expected).enumerate() {
            let actual = f64::from(f32::from_bits(word));
            let is_near =
                actual == expected || (actual - expected).abs() <= tolerance * expected.abs().max(1.0);
            assert!(is_near, "output {i} for {input:?}: {actual}, not {expected}");
        }
    }
}
