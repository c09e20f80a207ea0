//! Vectors, matrices and layouts.

use wgsl_cpu::runtime::{Mat, Vec2, Vec3};
use wgsl_cpu_probes::{LAYOUTS, VECTORS, cases, library, words::Words};

use crate::assert_float_rows;

type V = [f64; 4];

fn zip(a: V, b: V, f: impl Fn(f64, f64) -> f64) -> V {
    std::array::from_fn(|i| f(a[i], b[i]))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0], 0.0]
}

/// The sum of columns scaled by `v`.
fn combine(columns: [V; 3], v: V) -> V {
    std::array::from_fn(|row| (0..3).map(|column| columns[column][row] * v[column]).sum())
}

fn normalized(v: V) -> V {
    let length = dot(&v[..3], &v[..3]).sqrt();
    [v[0] / length, v[1] / length, v[2] / length, 0.0]
}

fn with_w([x, y, z, _]: V, w: f64) -> V {
    [x, y, z, w]
}

#[test]
fn vectors_and_matrices_are_those_of_algebra() {
    let case = cases::of(&VECTORS);
    let inputs: Vec<(usize, [V; 2])> = cases::vectors()
        .chunks_exact(2)
        .map(|pair| [0, 1].map(|i| pair[i].map(f64::from)))
        .enumerate()
        .collect();
    assert_float_rows(&case.run_native(), &inputs, 1e-4, |(id, [a, b])| {
        let rows: [V; 16] = expected(*id, *a, *b);
        let mut flat = [0.0; 64];
        flat.copy_from_slice(rows.as_flattened());
        flat
    });
}

fn expected(id: usize, a: V, b: V) -> [V; 16] {
    let f = |v: bool| f64::from(u8::from(v));
    let m = [a, b, [a[3], a[2], a[1], a[0]]];
    let square = [a, b, [a[2], a[0], a[1], 0.0]];
    let mut c = a;
    c[1] = 7.0;
    c[id % 4] += 1.0;
    let column = id % 4;
    let transposed: V = [m[0][column], m[1][column], m[2][column], m[2][column]];
    let (an, bn) = (normalized(a), normalized(b));
    let cos = dot(&an, &bn);
    let k = 1.0 - 0.49 * (1.0 - cos * cos);
    let refracted = zip(an, bn, |i, n| if k < 0.0 { 0.0 } else { 0.7 * i - (0.7 * cos + k.sqrt()) * n });
    let facing = if dot(&a, &b) < 0.0 { a } else { a.map(|x| -x) };
    // As the kernel has them: floats, cut and masked.
    let tens = a.map(|x| (x as f32 * 10.0).trunc());
    let hundreds = a.map(|x| ((x.abs() as f32) * 100.0) as u64);
    let shifted = [1, 2, 3, 4].map(|shift| hundreds[shift - 1] << shift);
    let masked = a.map(|x| f64::from(f32::from_bits((x as f32).to_bits() & 0xffff_0000)));
    let mix = |t: V| std::array::from_fn::<f64, 4, _>(|i| a[i] * (1.0 - t[i]) + b[i] * t[i]);
    let mut last = b.map(|x| 1.5 * x + a[id % 4]);
    last[3] = -a[3];
    last[id % 3] = 42.0;
    [
        [a[0] - 2.0 * a[0], a[1] - 2.0 * a[1], b[2] - 2.0 * a[2], b[3] - 2.0 * a[3]],
        zip(c, b, |c, b| 2.0 * c + b),
        combine(m, a),
        [
            dot(&b, &m[0]),
            dot(&b, &m[1]),
            dot(&b, &m[2]),
            dot(&square[0][..3], &cross(square[1], square[2])[..3]),
        ],
        transposed,
        with_w(combine(square, combine(square, a)), dot(&a, &b)),
        with_w(cross(a, b), dot(&a, &a).sqrt()),
        with_w(an, zip(a, b, |a, b| (a - b) * (a - b)).iter().sum::<f64>().sqrt()),
        with_w(zip(a, b, |x, n| x - 2.0 * dot(&a[..3], &b[..3]) * n), f((0..4).all(|i| a[i] < b[i]))),
        with_w(refracted, f((0..4).any(|i| a[i] < b[i]))),
        zip(zip(a, b, |a, b| if a < b { b } else { a }), facing, |x, y| x + y),
        [(tens[0] / 3.0).trunc(), tens[1], (tens[2] / -7.0).trunc(), (tens[3] / 2.0).trunc()].map(f64::from),
        masked,
        zip(mix([0.25; 4]), mix([0.0, 0.25, 0.5, 1.0]), |x, y| x + y),
        [shifted[0] % 7, 0, shifted[2] % 11, shifted[3] % 13].map(|word| word as f64),
        last,
    ]
}

/// Byte offsets by the WGSL specification, in words.
mod at {
    pub const RECORD: usize = 56;
    pub const INNER: usize = 4;
    pub const FRAME: usize = 16;
    pub const TAIL: usize = 28;
    pub const SMALL: usize = 52;
    pub const ID: usize = 3;
    pub const CORNERS: usize = 4;
    pub const INNER_SIZE: usize = 12;
}

#[test]
fn layouts_are_those_of_the_specification() {
    let case = cases::of(&LAYOUTS);
    let (header, records) = (&case.buffers[0], &case.buffers[1]);
    let result = case.run_native();
    let n_records = records.len() / at::RECORD;
    assert_eq!(result[0] as usize, n_records);
    let flags: u32 = records.iter().step_by(at::RECORD).sum();
    assert_eq!(result[1], flags.wrapping_neg());
    for id in 0..n_records {
        let record = &records[id * at::RECORD..][..at::RECORD];
        let mut expected = vec![0; at::RECORD];
        if id % 2 == 0 {
            changed_copy(header, record, &mut expected);
        } else {
            changed_parts(header, record, id, n_records as u32, &mut expected);
        }
        let actual = &result[4 + id * at::RECORD..][..at::RECORD];
        for (word, (&actual, &expected)) in actual.iter().zip(&expected).enumerate() {
            let near = (f32::from_bits(actual) - f32::from_bits(expected)).abs() <= 1e-6;
            assert!(actual == expected || near, "word {word} of record {id}: {actual:#x}, not {expected:#x}");
        }
    }
}

fn sum(words: &[u32], f: impl Fn(f32) -> f32) -> Vec<u32> {
    words.iter().map(|&word| f(f32::from_bits(word)).to_bits()).collect()
}

fn moved(header: &[u32], inner: &[u32], to: &mut [u32]) {
    to[..10].copy_from_slice(&inner[..10]);
    let scale = f32::from_bits(header[0]);
    for axis in 0..3 {
        let offset = f32::from_bits(header[4 + axis]);
        to[axis] = (scale * f32::from_bits(inner[axis]) + offset).to_bits();
    }
    let up = at::CORNERS + 3;
    to[up] = sum(&inner[up..=up], |y| y + 1.0)[0];
}

fn changed_copy(header: &[u32], record: &[u32], to: &mut [u32]) {
    to[0] = record[0];
    moved(header, &record[at::INNER..], &mut to[at::INNER..]);
    to[at::TAIL..at::TAIL + 10].copy_from_slice(&record[at::TAIL..at::TAIL + 10]);
    moved(header, &record[at::TAIL..], &mut to[at::TAIL + at::INNER_SIZE..]);
    to[at::SMALL..].copy_from_slice(&record[at::SMALL..]);
    let frame = |column: usize, row: usize| f32::from_bits(record[at::FRAME + 4 * column + row]);
    for (column, row) in (0..3).flat_map(|column| (0..3).map(move |row| (column, row))) {
        let product: f32 = (0..3).map(|k| frame(k, row) * frame(column, k)).sum();
        to[at::FRAME + 4 * column + row] = product.to_bits();
    }
}

fn changed_parts(header: &[u32], record: &[u32], id: usize, n_records: u32, to: &mut [u32]) {
    let turn = |column: usize, row: usize| header[16 + 4 * column + row];
    to[0] = header[8 + 4 * (id % 2) + 2] + n_records;
    to[at::INNER + 1] = record[at::TAIL + at::INNER_SIZE * (id % 2) + at::CORNERS + 4];
    for row in 0..2 {
        to[at::TAIL + at::INNER_SIZE * (id % 2) + at::CORNERS + 2 * (id % 3) + row] =
            record[at::SMALL + 2 + row];
    }
    for row in 0..3 {
        to[at::FRAME + 4 * (id % 3) + row] = turn(3, row);
    }
    to[at::FRAME + id % 3] = turn(id % 4, 2);
    to[at::TAIL..at::TAIL + 10].copy_from_slice(&record[at::INNER..at::INNER + 10]);
    assert_eq!(to[at::TAIL + at::ID], record[at::INNER + at::ID]);
    let small = &record[at::SMALL..];
    to[at::SMALL..].copy_from_slice(&[small[0], small[2], small[1], small[3]]);
}

#[test]
fn rare_constructs_do_what_they_say() {
    let flags = Vec3::new(true, false, true);
    let v = Vec3::new(1.0, -1.0, -1.0);
    // both = (b, false, a.z), either = (!a.x | both.x == a.x, true, ...).
    assert_eq!(library::bools(flags, true, v), Vec3::new(false, true, true));
    assert_eq!(library::bools(flags, false, v), Vec3::new(true, false, true));
    assert_eq!(library::of_table(1, 0), i32::MIN + 3 + 3 + 4);
    // An index out of range is the last one.
    assert_eq!(library::of_table(-1, 0), i32::MIN + 3 + 3 + 4);
    let m = Mat::new([Vec2::new(1.0, 2.0), Vec2::new(3.0, 4.0), Vec2::new(5.0, 6.0)]);
    let n = [Vec2::new(-1.0, -2.0), Vec2::new(4.0, 3.0)];
    assert_eq!(library::of_matrix(m, 1, 3.0), Vec2::new(-n[0].x - n[1].x, -n[0].y - n[1].y));
    assert_eq!(library::only_default(4), 1 + 1 + 2 + 100 + 4);
    assert_eq!(library::nested_loops(0), 0);
    assert_eq!(library::results(3.0), 1.0 + 4.0 + 0.75);
    let ids = library::Ids { global: Vec3::new(1, 2, 3), lane: 4 };
    assert_eq!(library::of_ids(ids), 6);
}

#[test]
fn places_in_buffers_stay_in_range() {
    // left, 2 x 3 counts, then at byte 32 tables of 6 vec3s and a vec2: 112 bytes each.
    let mut words = Words::new(&[0; 8 + 2 * 28]);
    // SAFETY: the one buffer is large enough, and only this thread uses it.
    let globals = unsafe { library::Globals::new(&[words.storage()]) };
    let x = Vec3::new(1.0, 2.0, 3.0);
    assert_eq!(library::into_buffer(&globals, 1, x), 3 - 5);
    // The last table, row and count.
    assert_eq!(library::into_buffer(&globals, u32::MAX, x), -3 - 5 + 2);
    let words = words.to_vec();
    assert_eq!(&words[1..8], [0, 0, 0, 0, 2, (-3i32) as u32, 0]);
    let table = &words[8 + 28..];
    let float = |at: usize| f32::from_bits(table[at]);
    assert_eq!([float(9), float(12), float(13), float(14)], [9.0, 1.0, 2.0, 3.0]);
    assert_eq!([float(16), float(17), float(18)], [1.0, 2.0, 9.0]);
    assert_eq!([float(20), float(21), float(22)], [-1.0, -2.0, -3.0]);
    assert_eq!(table[25] as i32, -1);
    assert!(words[8..8 + 28].iter().all(|&word| word == 0), "the first table");
}
