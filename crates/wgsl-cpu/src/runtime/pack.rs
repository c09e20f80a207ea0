//! WGSL's packing of several numbers in one `u32`, the first in the least significant bits.

use super::{Vec2, Vec4};

/// Rounds to the nearest binary16, ties to even; what is too large becomes infinite.
#[inline]
pub fn f32_to_f16(x: f32) -> u16 {
    let bits = x.to_bits();
    let sign = (bits >> 16 & 0x8000) as u16;
    let magnitude = bits & 0x7fff_ffff;
    if magnitude > 0x7f80_0000 {
        return sign | 0x7e00;
    }
    // 65520 and above round to infinity; below 2^-14 the result is subnormal.
    if magnitude >= 0x477f_f000 {
        return sign | 0x7c00;
    }
    if magnitude < 0x3880_0000 {
        // Adding 0.5 aligns the last bit of a binary16 subnormal (2^-24) with that of the sum.
        let sum = f32::from_bits(magnitude) + 0.5;
        return sign | (sum.to_bits() - 0.5f32.to_bits()) as u16;
    }
    let rebiased = magnitude - (112 << 23);
    let ties_to_even = 0xfff + (rebiased >> 13 & 1);
    sign | ((rebiased + ties_to_even) >> 13) as u16
}

/// The value of a binary16.
#[inline]
pub fn f16_to_f32(half: u16) -> f32 {
    let sign = u32::from(half & 0x8000) << 16;
    let magnitude = u32::from(half & 0x7fff);
    let value = match magnitude {
        0x7c00.. => 0x7f80_0000 | (magnitude & 0x3ff) << 13,
        0x0400.. => (magnitude << 13) + (112 << 23),
        // A subnormal: an integer times 2^-24.
        _ => (magnitude as f32 * f32::from_bits(103 << 23)).to_bits(),
    };
    f32::from_bits(sign | value)
}

/// `x` in `[-1, 1]` (clamped; NaN as 0) as an integer in `[-scale, scale]`.
#[inline(always)]
fn snorm(x: f32, scale: f32) -> u32 {
    // `as` turns a NaN, which both comparisons of `clamp` pass on, to 0.
    (0.5 + scale * x.clamp(-1.0, 1.0)).floor() as i32 as u32
}

/// `x` in `[0, 1]` (clamped; NaN as 0) as an integer in `[0, scale]`.
#[inline(always)]
fn unorm(x: f32, scale: f32) -> u32 {
    (0.5 + scale * x.clamp(0.0, 1.0)).floor() as u32
}

/// Puts the low bits of each part beside each other.
#[inline(always)]
fn join<const N: usize>(parts: [u32; N]) -> u32 {
    let width = 32 / N as u32;
    let mask = u32::MAX >> (32 - width);
    parts.iter().rev().fold(0, |packed, part| packed << width | part & mask)
}

/// The parts of a `u32`, zero-extended.
#[inline(always)]
fn split<const N: usize>(packed: u32) -> [u32; N] {
    let width = 32 / N as u32;
    std::array::from_fn(|i| packed >> (i as u32 * width) & (u32::MAX >> (32 - width)))
}

/// The parts of a `u32`, sign-extended.
#[inline(always)]
fn split_signed<const N: usize>(packed: u32) -> [i32; N] {
    let unused = 32 - 32 / N as u32;
    split(packed).map(|part: u32| (part << unused) as i32 >> unused)
}

/// Two binary16 numbers.
#[inline]
pub fn pack2x16float(v: Vec2<f32>) -> u32 {
    join(v.to_array().map(|x| u32::from(f32_to_f16(x))))
}

/// Inverse of [`pack2x16float`].
#[inline]
pub fn unpack2x16float(packed: u32) -> Vec2<f32> {
    split(packed).map(|part: u32| f16_to_f32(part as u16)).into()
}

/// Two numbers in `[-1, 1]` with 16 bits each.
#[inline]
pub fn pack2x16snorm(v: Vec2<f32>) -> u32 {
    join(v.to_array().map(|x| snorm(x, 32767.0)))
}

/// Inverse of [`pack2x16snorm`].
#[inline]
pub fn unpack2x16snorm(packed: u32) -> Vec2<f32> {
    split_signed(packed).map(|part: i32| (part as f32 / 32767.0).max(-1.0)).into()
}

/// Two numbers in `[0, 1]` with 16 bits each.
#[inline]
pub fn pack2x16unorm(v: Vec2<f32>) -> u32 {
    join(v.to_array().map(|x| unorm(x, 65535.0)))
}

/// Inverse of [`pack2x16unorm`].
#[inline]
pub fn unpack2x16unorm(packed: u32) -> Vec2<f32> {
    split(packed).map(|part: u32| part as f32 / 65535.0).into()
}

/// Four numbers in `[-1, 1]` with 8 bits each.
#[inline]
pub fn pack4x8snorm(v: Vec4<f32>) -> u32 {
    join(v.to_array().map(|x| snorm(x, 127.0)))
}

/// Inverse of [`pack4x8snorm`].
#[inline]
pub fn unpack4x8snorm(packed: u32) -> Vec4<f32> {
    split_signed(packed).map(|part: i32| (part as f32 / 127.0).max(-1.0)).into()
}

/// Four numbers in `[0, 1]` with 8 bits each.
#[inline]
pub fn pack4x8unorm(v: Vec4<f32>) -> u32 {
    join(v.to_array().map(|x| unorm(x, 255.0)))
}

/// Inverse of [`pack4x8unorm`].
#[inline]
pub fn unpack4x8unorm(packed: u32) -> Vec4<f32> {
    split(packed).map(|part: u32| part as f32 / 255.0).into()
}

/// The low 8 bits of four integers.
#[inline]
pub fn pack4x_i8(v: Vec4<i32>) -> u32 {
    join(v.to_array().map(|x| x as u32))
}

/// Inverse of [`pack4x_i8`].
#[inline]
pub fn unpack4x_i8(packed: u32) -> Vec4<i32> {
    split_signed(packed).into()
}

/// The low 8 bits of four integers.
#[inline]
pub fn pack4x_u8(v: Vec4<u32>) -> u32 {
    join(v.to_array())
}

/// Inverse of [`pack4x_u8`].
#[inline]
pub fn unpack4x_u8(packed: u32) -> Vec4<u32> {
    split(packed).into()
}

/// Four integers clamped to `[-128, 127]`.
#[inline]
pub fn pack4x_i8_clamp(v: Vec4<i32>) -> u32 {
    join(v.to_array().map(|x| x.clamp(-128, 127) as u32))
}

/// Four integers clamped to `[0, 255]`.
#[inline]
pub fn pack4x_u8_clamp(v: Vec4<u32>) -> u32 {
    join(v.to_array().map(|x| x.min(255)))
}
