//! Integers, floats and packing against wide arithmetic.

use wgsl_cpu_probes::{
    FLOATS, INTEGERS, PACKING, TRANSCENDENTALS,
    cases::{self, float_pairs, fractions, integer_pairs, vectors},
};

use crate::{assert_float_rows, assert_rows};

#[test]
fn integers_wrap_and_never_trap() {
    let actual = cases::of(&INTEGERS).run_native();
    assert_rows(&actual, &integer_pairs(), |&[a, b]| {
        let (wa, wb) = (u64::from(a), u64::from(b));
        let (c, d) = (i64::from(a as i32), i64::from(b as i32));
        let shift = b % 32;
        let offset = shift;
        let width = 7.min(32 - offset);
        let field = (wa >> offset) & ((1 << width) - 1);
        let signed_field = ((field << (64 - width)) as i64) >> (64 - width);
        let inserted = (wa & !(0x1ff << 5)) | ((wb & 0x1ff) << 5);
        // Indexes of bits; -1 where there is none.
        let highest = |wide: u64| (0..32).rev().find(|bit| wide >> bit & 1 == 1).map_or(u32::MAX, |bit| bit);
        let lowest = (0..32).find(|bit| wa >> bit & 1 == 1).unwrap_or(u32::MAX);
        let magnitude = if c < 0 { u64::from(!a) } else { wa };
        [
            (wa + wb) as u32,
            (wa.wrapping_sub(wb)) as u32,
            (wa.wrapping_mul(wb)) as u32,
            wa.checked_div(wb).unwrap_or(wa) as u32,
            wa.checked_rem(wb).unwrap_or(0) as u32,
            (c + d) as u32,
            (c - d) as u32,
            (c * d) as u32,
            c.checked_div(d).unwrap_or(c) as u32,
            c.checked_rem(d).unwrap_or(0) as u32,
            (wa << shift) as u32,
            (wa >> shift) as u32,
            (c << shift) as u32,
            (c >> shift) as u32,
            (-c) as u32,
            c.unsigned_abs() as u32,
            c.signum() as u32,
            a.min(b),
            a.max(b),
            c.min(d) as u32,
            c.max(d) as u32,
            (0..32).map(|bit| a >> bit & 1).sum(),
            highest(wa).wrapping_add(1).abs_diff(32),
            lowest.min(32),
            highest(wa),
            lowest,
            highest(magnitude),
            (0..32).fold(0, |reversed, bit| reversed << 1 | a >> bit & 1),
            field as u32,
            signed_field as u32,
            inserted as u32,
            (wa & wb) as u32,
            (wa | wb) as u32,
            (wa ^ wb) as u32,
            !a,
            a.clamp(10, 1000),
            if c < d { b } else { a },
            u32::from(a < b),
            a / 7,
            (c / -3) as u32,
        ]
    });
}

#[test]
fn floats_follow_the_specification() {
    let actual = cases::of(&FLOATS).run_native();
    assert_float_rows(&actual, &float_pairs(), 1e-6, |&[a32, b32]| {
        let (a, b) = (f64::from(a32), f64::from(b32));
        let smooth = ((a + 2.0) / 5.0).clamp(0.0, 1.0);
        let exponent = if a == 0.0 { 0.0 } else { a.abs().log2().floor() + 1.0 };
        let half = |x: f64| if x.abs() >= 65520.0 { f64::INFINITY * x.signum() } else { round_bits(x, 11) };
        [
            a + b,
            a - b,
            a * b,
            // Of a float quotient, whose error counts where the quotient is large.
            f64::from(a32 - b32 * (a32 / b32).trunc()),
            a.min(b),
            a.max(b),
            a.clamp(-1.5, 2.5),
            a.clamp(0.0, 1.0),
            a.floor(),
            a.ceil(),
            a.round_ties_even(),
            a.trunc(),
            a - a.floor(),
            a.abs(),
            if a == 0.0 { 0.0 } else { a.signum() },
            f64::from(u8::from(a <= b)),
            a.trunc().clamp(-2147483648.0, 2147483520.0),
            a.trunc().clamp(0.0, 4294967040.0),
            f64::from(u8::from(a != 0.0)),
            a.max(b),
            0.75 * a + 0.25 * b,
            smooth * smooth * (3.0 - 2.0 * smooth),
            a - a.trunc(),
            a.trunc(),
            a / exponent.exp2(),
            exponent,
            8.0 * a,
            half(a),
            a * b + 1.0,
            -a,
            0.1875 * a,
            -a,
        ]
    });
}

/// `x` rounded to a significand of `n` bits, ties to even.
fn round_bits(x: f64, n: i32) -> f64 {
    if x == 0.0 {
        return x;
    }
    let unit = (x.abs().log2().floor() as i32 - (n - 1)).max(-24);
    let unit = f64::from(unit).exp2();
    (x / unit).round_ties_even() * unit
}

#[test]
fn transcendentals_are_near() {
    let actual = cases::of(&TRANSCENDENTALS).run_native();
    assert_float_rows(&actual, &fractions(), 1e-6, |&x| {
        let x = f64::from(x);
        let scaled = f64::from(0.9f32 * x as f32);
        [
            x.sin(),
            x.cos(),
            x.tan(),
            x.asin(),
            x.acos(),
            x.atan(),
            x.atan2(0.5),
            x.sinh(),
            x.cosh(),
            x.tanh(),
            x.asinh(),
            (1.0 + x).acosh(),
            scaled.atanh(),
            x.exp(),
            x.exp2(),
            x.ln(),
            x.log2(),
            x.powf(2.5),
            x.sqrt(),
            1.0 / x.sqrt(),
            1.0 / x,
            x.to_radians(),
            x.to_degrees(),
            x / 3.0,
        ]
    });
}

#[test]
fn packing_rounds_and_clamps() {
    let actual = cases::of(&PACKING).run_native();
    assert_rows(&actual, &vectors(), |v| {
        let snorm = |x: f32, scale: f64| (0.5 + scale * f64::from(x.clamp(-1.0, 1.0))).floor() as i64;
        let unorm = |x: f32, scale: f64| (0.5 + scale * f64::from(x.clamp(0.0, 1.0))).floor() as i64;
        let join = |parts: &[i64], width: u32| {
            let mask = (1 << width) - 1;
            parts.iter().rev().fold(0, |word, part| word << width | part & mask) as u32
        };
        let [x, y, z, w] = *v;
        let word = x.to_bits();
        let part = |i: u32, width: u32| f64::from(word >> (i * width) & ((1 << width) - 1));
        let signed = |i: u32, width: u32, scale: f64| {
            let value = part(i, width);
            let value = if value > scale { value - f64::from(1 << width) } else { value };
            (value / scale).max(-1.0) as f32
        };
        let halves = [x, y].map(|value| half_bits(f64::from(value)));
        let tiny = [z, w].map(|value| half_bits(f64::from(value * 1e-6)));
        let unpacked = [x, y].map(|value| (round_bits(f64::from(value), 11) as f32).to_bits());
        [
            join(&v.map(|x| snorm(x, 127.0)), 8),
            join(&v.map(|x| unorm(x, 255.0)), 8),
            join(&[x, y].map(|x| snorm(x, 32767.0)), 16),
            join(&[x, y].map(|x| unorm(x, 65535.0)), 16),
            join(&halves, 16),
            join(&tiny, 16),
            0,
            0,
            signed(0, 8, 127.0).to_bits(),
            signed(1, 8, 127.0).to_bits(),
            signed(2, 8, 127.0).to_bits(),
            signed(3, 8, 127.0).to_bits(),
            ((part(0, 8) / 255.0) as f32).to_bits(),
            ((part(1, 8) / 255.0) as f32).to_bits(),
            ((part(2, 8) / 255.0) as f32).to_bits(),
            ((part(3, 8) / 255.0) as f32).to_bits(),
            signed(0, 16, 32767.0).to_bits(),
            signed(1, 16, 32767.0).to_bits(),
            ((part(0, 16) / 65535.0) as f32).to_bits(),
            ((part(1, 16) / 65535.0) as f32).to_bits(),
            unpacked[0],
            unpacked[1],
            0,
            0,
        ]
    });
}

/// The binary16 of a number below 2, from its exponent and its rounded significand.
fn half_bits(x: f64) -> i64 {
    let sign = i64::from(x.is_sign_negative()) << 15;
    let rounded = round_bits(x, 11).abs();
    let smallest_normal = (-14.0f64).exp2();
    if rounded < smallest_normal {
        return sign | (rounded * 24.0f64.exp2()) as i64;
    }
    let exponent = rounded.log2().floor();
    sign | ((exponent as i64 + 15) << 10) | ((rounded / exponent.exp2() - 1.0) * 1024.0) as i64
}
