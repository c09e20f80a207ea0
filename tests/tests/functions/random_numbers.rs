//! The counter-based generator: uniform in one dimension, and in pairs along every axis that
//! kernels draw from.

use midway_kernels::native::lib;
use wgsl_cpu::runtime::Vec4;

use crate::{
    chi_square::{ChiSquare, histogram, histogram2},
    support::Random,
};

const SIDE: u32 = 512;
const SEED: u32 = 1;

fn draw(path: u32, sample: u32, dimension: u32) -> Vec4<f32> {
    lib::unit_float(lib::draw_bits(path, sample, dimension, SEED))
}

/// Each (path, sample) of a block of counters, as kernels count.
fn counters() -> impl Iterator<Item = (u32, u32)> {
    (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE))
}

#[test]
fn every_component_is_uniform() {
    let dimension = lib::dimension(lib::DRAW_SCATTER, 1);
    for component in 0..4u32 {
        let values = counters().map(|(path, sample)| draw(path, sample, dimension).at(component));
        ChiSquare::uniform(&histogram(1000, values)).assert_holds(&format!("component {component}"));
    }
}

/// What one draw says of another: of the next pixel, the next sample, the next depth, another
/// purpose, the light path of the same index, another component, another seed.
#[test]
fn pairs_are_uniform() {
    let at = |path, sample, dimension| draw(path, sample, dimension);
    let here = lib::dimension(lib::DRAW_SCATTER, 0);
    type Pair<'a> = (&'a str, Box<dyn Fn(u32, u32) -> (f32, f32)>);
    let pairs: [Pair<'_>; 9] = [
        ("pixels", Box::new(move |p, s| (at(p, s, here).x, at(p + 1, s, here).x))),
        ("samples", Box::new(move |p, s| (at(p, s, here).x, at(p, s + 1, here).x))),
        ("depths", Box::new(move |p, s| (at(p, s, here).x, at(p, s, here + 1).x))),
        ("purposes", Box::new(move |p, s| (at(p, s, here).x, at(p, s, lib::dimension(lib::DRAW_NEE, 0)).x))),
        (
            "camera and light",
            Box::new(move |p, s| {
                let light = lib::dimension(lib::DRAW_LIGHT + lib::DRAW_SCATTER, 0);
                (at(p, s, here).y, at(p, s, light).y)
            }),
        ),
        ("x and y", Box::new(move |p, s| (at(p, s, here).x, at(p, s, here).y))),
        ("y and z", Box::new(move |p, s| (at(p, s, here).y, at(p, s, here).z))),
        ("z and w", Box::new(move |p, s| (at(p, s, here).z, at(p, s, here).w))),
        ("seeds", Box::new(move |p, s| (at(p, s, here).x, lib::unit_float(lib::draw_bits(p, s, here, 2)).x))),
    ];
    for (what, pair) in &pairs {
        let test = ChiSquare::uniform(&histogram2(32, counters().map(|(path, sample)| pair(path, sample))));
        test.assert_holds(what);
        assert!(test.p <= 1.0 - 1e-6, "{what}: more even than chance, {test}");
    }
}

/// The purposes that meet in one join, component by component. pcg4d on the bare dimension fails
/// here: purposes differ in high bits only.
#[test]
fn draws_that_meet_in_a_join_are_independent() {
    let camera = lib::DRAW_SCATTER;
    let others = [
        lib::DRAW_LIGHT + lib::DRAW_SCATTER,
        lib::DRAW_LIGHT + lib::DRAW_EMIT_DIRECTION,
        lib::DRAW_LIGHT + lib::DRAW_RESERVOIR,
        lib::DRAW_JOIN + 1,
        lib::DRAW_NEE,
    ];
    for (other, depth, component) in
        others.into_iter().flat_map(|o| (0..3).flat_map(move |d| (0..4).map(move |c| (o, d, c))))
    {
        let (a, b) = (lib::dimension(camera, depth), lib::dimension(other, depth));
        let pairs = counters().map(|(p, s)| (draw(p, s, a).at(component), draw(p, s, b).at(component)));
        let what = format!("purpose {other:#x}, depth {depth}, component {component}");
        ChiSquare::uniform(&histogram2(16, pairs)).assert_holds(&what);
    }
}

/// Every purpose's dimension at the first depths, those of camera paths and of light paths.
fn dimensions() -> Vec<u32> {
    let purposes = [
        lib::DRAW_FILM,
        lib::DRAW_SCATTER,
        lib::DRAW_NEE,
        lib::DRAW_EMIT_POINT,
        lib::DRAW_EMIT_DIRECTION,
        lib::DRAW_RESERVOIR,
        lib::DRAW_RESERVOIR + 1,
        lib::DRAW_JOIN,
        lib::DRAW_JOIN + 1,
    ];
    let both = purposes.into_iter().flat_map(|purpose| [purpose, purpose + lib::DRAW_LIGHT]);
    both.flat_map(|purpose| [0, 1, 2].map(|depth| lib::dimension(purpose, depth))).collect()
}

pub type Bits = fn(u32, u32, u32, u32) -> Vec4<u32>;

/// The first `CELL_BITS` bits of each component of a draw, for a block of counters.
fn cells(bits: Bits, dimension: u32) -> [Vec<u8>; 4] {
    let drawn: Vec<Vec4<u32>> = (0..N_COUNTERS).map(|i| bits(i % 256, i / 256, dimension, SEED)).collect();
    [0u32, 1, 2, 3].map(|c| drawn.iter().map(|bits| (bits.at(c) >> (32 - CELL_BITS)) as u8).collect())
}

const N_COUNTERS: u32 = 1 << 15;
const CELL_BITS: u32 = 3;

/// The least p-value of a chi-square test of independence over all components of all pairs of
/// dimensions, at counters `shift` apart, times the number of tests.
pub fn least_p_of_all_pairs(bits: Bits, shift: usize) -> f64 {
    let all: Vec<Vec<u8>> = dimensions().into_iter().flat_map(|dim| cells(bits, dim)).collect();
    let (mut least, mut n) = (f64::INFINITY, 0);
    for (i, a) in all.iter().enumerate() {
        for b in &all[i + 1..] {
            let mut counts = [0u64; 1 << (2 * CELL_BITS)];
            for (x, y) in a.iter().zip(&b[shift..]) {
                counts[usize::from(x << CELL_BITS | y)] += 1;
            }
            least = ChiSquare::uniform(&counts).p.min(least);
            n += 1;
        }
    }
    assert!(n >= 20_000, "{n} pairs");
    least * f64::from(n)
}

/// No draw of a path says anything of another one, nor of one of the next path: joins multiply a
/// camera path's numbers with its light path's, and dependence biases their mean.
#[test]
fn all_purposes_are_independent() {
    for shift in [0, 1] {
        let p = least_p_of_all_pairs(lib::draw_bits, shift);
        assert!(p >= 1e-3, "paths {shift} apart: {p:e}");
    }
}

/// pcg4d of the bare counters, as it first was: numbers of keys that differ in a high bit only
/// depend on each other.
#[test]
fn bare_pcg4d_is_rejected() {
    let p = least_p_of_all_pairs(|path, sample, dim, seed| lib::pcg4d(Vec4::new(path, sample, dim, seed)), 0);
    assert!(p <= 1e-9, "{p:e}");
}

/// The tests above see dependence: neighbouring counters hashed by a weak multiplication.
#[test]
fn a_weak_hash_is_rejected() {
    let weak = |i: u32| (i.wrapping_mul(0x9e37_79b1) >> 8) as f32 / 16_777_216.0;
    let pairs = (0..SIDE * SIDE).map(|i| (weak(i), weak(i + 1)));
    ChiSquare::uniform(&histogram2(32, pairs)).assert_rejects("a multiplicative hash");
}

#[test]
fn unit_floats_are_below_one() {
    let u = lib::unit_float(Vec4::splat(u32::MAX));
    assert_eq!(u.x, 1.0 - 1.0 / 16_777_216.0);
    assert_eq!(lib::unit_float(Vec4::splat(255)).x, 0.0);
}

#[test]
fn uniform_indices_are_uniform_and_in_range() {
    let mut random = Random::new(20);
    for n in [1, 2, 7, 100, 1000] {
        let mut counts = vec![0; n as usize];
        for _ in 0..200_000 {
            counts[lib::uniform_index(random.unit(), n) as usize] += 1;
        }
        if n > 1 {
            ChiSquare::uniform(&counts).assert_holds(&format!("uniform_index of {n}"));
        }
        assert_eq!(lib::uniform_index(1.0, n), n - 1);
        assert_eq!(lib::uniform_index(0.0, n), 0);
    }
}

#[test]
fn uniform_index_bits_is_the_high_word_of_the_product() {
    let mut random = Random::new(21);
    for i in 0..100_000u64 {
        let (bits, n) = (random.bits() as u32, random.bits() as u32 >> (i % 32));
        let expected = (u64::from(bits) * u64::from(n)) >> 32;
        assert_eq!(u64::from(lib::uniform_index_bits(bits, n)), expected, "{bits} of {n}");
    }
    assert_eq!(lib::uniform_index_bits(u32::MAX, u32::MAX), u32::MAX - 1);
}

#[test]
fn table_indices_cover_the_table() {
    const ENTRIES: u32 = 1024;
    let mut counts = vec![0; ENTRIES as usize];
    for (path, sample) in counters() {
        counts[lib::table_index(path, sample, 0x10000, 7, ENTRIES) as usize] += 1;
    }
    let mean = f64::from(SIDE * SIDE / ENTRIES);
    assert!(counts.iter().all(|&n: &u64| n as f64 >= 0.5 * mean && n as f64 <= 2.0 * mean), "uneven");
}

#[test]
fn purposes_do_not_share_dimensions() {
    let purposes = [lib::DRAW_FILM, lib::DRAW_SCATTER, lib::DRAW_NEE, lib::DRAW_EMIT_POINT];
    let purposes =
        purposes.into_iter().chain([lib::DRAW_EMIT_DIRECTION, lib::DRAW_RESERVOIR, lib::DRAW_JOIN]);
    let mut seen = std::collections::HashSet::new();
    for purpose in purposes.flat_map(|p| [p, p + lib::DRAW_LIGHT]) {
        for depth in [0, 1, 2, 0xffff] {
            assert!(seen.insert(lib::dimension(purpose, depth)), "{purpose:#x} at {depth}");
        }
    }
}
