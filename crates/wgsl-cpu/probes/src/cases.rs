//! What each probe is run on.

use wgsl_cpu::Kernel;

use crate::{
    ATOMICS, CONTROL, FLOATS, INTEGERS, LAYOUTS, PACKING, TRANSCENDENTALS, TRAVERSE, VECTORS,
    scene::TraversalScene,
    words::{Words, run_native},
};

/// How far a GPU's words may be from the native ones.
#[derive(Clone, Copy, Debug)]
pub enum Tolerance {
    /// The same bits.
    Exact,
    /// The words are `f32`s: the difference is at most this much of the greater of 1 and the value.
    Float(f32),
}

/// A probe with its buffers, in the order of its bindings.
pub struct Case {
    /// The probe.
    pub kernel: &'static Kernel,
    /// The buffers' words before the run.
    pub buffers: Vec<Vec<u32>>,
    /// The index of the buffer that is compared.
    pub output: usize,
    /// How many workgroups run.
    pub groups: u32,
    /// How it is compared.
    pub tolerance: Tolerance,
}

impl Case {
    /// The words of the compared buffer after a run on this thread.
    pub fn run_native(&self) -> Vec<u32> {
        let mut buffers: Vec<Words> = self.buffers.iter().map(|words| Words::new(words)).collect();
        run_native(self.kernel, &buffers.iter().collect::<Vec<_>>(), self.groups);
        buffers[self.output].to_vec()
    }
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Words in no order (the finalizer of MurmurHash3).
pub fn scrambled(n: u32) -> u32 {
    let n = (n ^ (n >> 16)).wrapping_mul(0x85eb_ca6b);
    let n = (n ^ (n >> 13)).wrapping_mul(0xc2b2_ae35);
    n ^ (n >> 16)
}

/// A float in `[-scale, scale)`.
fn float(seed: u32, scale: f32) -> f32 {
    scale * (scrambled(seed) as i32 as f32 / 2_147_483_648.0)
}

/// Words at the ends of both integer types, and some between.
pub fn integer_pairs() -> Vec<[u32; 2]> {
    let ends = [0, 1, 2, 3, 7, 31, 32, 1000, 0x7fff_ffff, 0x8000_0000, 0x8000_0001, u32::MAX - 6, u32::MAX];
    let at_ends = ends.into_iter().flat_map(|a| ends.map(|b| [a, b]));
    at_ends.chain((0..87).map(|n| [scrambled(2 * n), scrambled(2 * n + 1)])).collect()
}

/// Pairs of floats with halves, zeros, and what is too large for integers.
pub fn float_pairs() -> Vec<[f32; 2]> {
    let ends = [0.0, 0.5, -0.5, 1.5, 2.5, -2.5, 1.0, -1.0, 7.75, -7.25, 1e-3, 3.0e9, -3.0e9, 1.0e10];
    let at_ends = ends.into_iter().flat_map(|a| [0.75, -3.0, 1.5].map(|b| [a, b]));
    at_ends.chain((0..64).map(|n| [float(2 * n, 50.0), float(2 * n + 1, 3.0)])).collect()
}

/// Numbers in (0, 1).
pub fn fractions() -> Vec<f32> {
    (1..128).map(|n| n as f32 / 128.0).collect()
}

/// Vectors whose components are in `[-2, 2)`.
pub fn vectors() -> Vec<[f32; 4]> {
    (0..128).map(|n| [0, 1, 2, 3].map(|i| float(4 * n + i + 1, 2.0))).collect()
}

fn integers() -> Case {
    let inputs = integer_pairs();
    simple(&INTEGERS, inputs.as_flattened().to_vec(), inputs.len(), 40, Tolerance::Exact)
}

fn floats() -> Case {
    let inputs = float_pairs();
    simple(&FLOATS, bits(inputs.as_flattened()), inputs.len(), 32, Tolerance::Float(1e-6))
}

fn transcendentals() -> Case {
    let inputs = fractions();
    simple(&TRANSCENDENTALS, bits(&inputs), inputs.len(), 24, Tolerance::Float(1e-3))
}

fn packing() -> Case {
    let inputs = vectors();
    simple(&PACKING, bits(inputs.as_flattened()), inputs.len(), 24, Tolerance::Exact)
}

fn control() -> Case {
    let inputs: Vec<u32> = (0..100).chain((0..156).map(|n| scrambled(n) >> 8)).collect();
    let n = inputs.len();
    simple(&CONTROL, inputs, n, 8, Tolerance::Exact)
}

/// A probe of one input and one output buffer.
fn simple(kernel: &'static Kernel, inputs: Vec<u32>, n: usize, stride: usize, tolerance: Tolerance) -> Case {
    let buffers = vec![inputs, vec![0; n * stride]];
    Case { kernel, buffers, output: 1, groups: (n as u32).div_ceil(64), tolerance }
}

fn vectors_case() -> Case {
    let inputs = vectors();
    let buffers = vec![bits(inputs.as_flattened()), vec![0; inputs.len() / 2 * 64]];
    Case { kernel: &VECTORS, buffers, output: 1, groups: 1, tolerance: Tolerance::Float(2e-5) }
}

fn layouts() -> Case {
    let header =
        (0..32).map(|n| if (8..16).contains(&n) { 100 + n } else { float(n, 1.0).to_bits() }).collect();
    let n_records = 64;
    let records = (0..n_records * 56)
        .map(|n| if matches!(n % 56, 0 | 7 | 31 | 43) { n } else { float(n, 1.0).to_bits() })
        .collect();
    let result = vec![0; 4 + 56 * n_records as usize];
    let buffers = vec![header, records, result];
    Case { kernel: &LAYOUTS, buffers, output: 2, groups: 1, tolerance: Tolerance::Float(1e-6) }
}

/// The probe of atomics, compared by its sums.
fn atomics() -> Case {
    let inputs: Vec<u32> = (0..1000).map(scrambled).collect();
    let mut sums = vec![0; 12];
    sums[4] = u32::MAX;
    sums[6] = u32::MAX;
    let buffers = vec![inputs, sums, vec![0; 37]];
    Case { kernel: &ATOMICS, buffers, output: 1, groups: 16, tolerance: Tolerance::Exact }
}

/// Rays through a small scene; what is compared are distances and triangles.
pub fn traversal() -> Case {
    let scene = TraversalScene::random(2000, 512);
    let mut buffers = vec![vec![512]];
    buffers.extend([&scene.nodes, &scene.triangles, &scene.rays].map(|words| bits(words.as_flattened())));
    buffers.push(vec![0; 512 * 4]);
    Case { kernel: &TRAVERSE, buffers, output: 4, groups: 8, tolerance: Tolerance::Float(1e-4) }
}

/// A case for every probe.
pub fn all() -> Vec<Case> {
    vec![
        integers(),
        floats(),
        transcendentals(),
        vectors_case(),
        packing(),
        control(),
        layouts(),
        atomics(),
        traversal(),
    ]
}

/// The case of one probe.
///
/// # Panics
/// If there is none.
pub fn of(kernel: &Kernel) -> Case {
    all().into_iter().find(|case| case.kernel.name == kernel.name).expect("every probe has a case")
}
