//! WGSL's integer built-in functions. All work on each component.

use super::{Componentwise, Scalar, Zero};

/// `i32` and `u32`.
pub trait Integer: super::Number {
    /// Reinterprets 32 bits.
    fn from_bits(bits: u32) -> Self;
    /// `self >> shift` for a shift below 32, extending the sign of an `i32`.
    fn shift_right(self, shift: u32) -> Self;
    /// The bits that tell where the most significant one that matters is: those of a negative
    /// `i32` are inverted.
    fn magnitude_bits(self) -> u32;
}

impl Integer for u32 {
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        bits
    }
    #[inline(always)]
    fn shift_right(self, shift: u32) -> Self {
        self.wrapping_shr(shift)
    }
    #[inline(always)]
    fn magnitude_bits(self) -> u32 {
        self
    }
}

impl Integer for i32 {
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        bits as i32
    }
    #[inline(always)]
    fn shift_right(self, shift: u32) -> Self {
        self.wrapping_shr(shift)
    }
    #[inline(always)]
    fn magnitude_bits(self) -> u32 {
        (self ^ (self >> 31)) as u32
    }
}

/// Functions of one integer.
macro_rules! integer {
    ($($(#[$doc:meta])* $name:ident($x:ident) = $f:expr;)*) => {$(
        $(#[$doc])*
        #[inline(always)]
        pub fn $name<V: Componentwise<Component: Integer>>(x: V) -> V::With<V::Component> {
            x.map(|$x| V::Component::from_bits($f))
        }
    )*};
}

integer! {
    /// How many zero bits follow the least significant one bit.
    count_trailing_zeros(x) = x.bits().trailing_zeros();
    /// How many zero bits precede the most significant one bit.
    count_leading_zeros(x) = x.bits().leading_zeros();
    /// How many bits are one.
    count_one_bits(x) = x.bits().count_ones();
    /// The bits in reverse order.
    reverse_bits(x) = x.bits().reverse_bits();
    /// The index of the least significant one bit, -1 if there is none.
    first_trailing_bit(x) = match x.bits() {
        0 => u32::MAX,
        bits => bits.trailing_zeros(),
    };
    /// The index of the most significant one bit (of a negative number, zero bit), -1 if there is
    /// none.
    first_leading_bit(x) = 31u32.wrapping_sub(x.magnitude_bits().leading_zeros());
}

/// `count` bits from `offset` up, extended by the sign of an `i32`. Ranges are cut at 32 bits.
#[inline(always)]
pub fn extract_bits<V>(x: V, offset: u32, count: u32) -> V::With<V::Component>
where
    V: Componentwise<Component: Integer>,
{
    let (offset, count) = bit_range(offset, count);
    x.map(|x| match count {
        0 => V::Component::ZERO,
        _ => V::Component::from_bits(x.bits() << (32 - offset - count)).shift_right(32 - count),
    })
}

/// `x` with `count` bits from `offset` up replaced by the low bits of `new`. Ranges are cut at 32
/// bits.
#[inline(always)]
pub fn insert_bits<V>(x: V, new: V, offset: u32, count: u32) -> V::With<V::Component>
where
    V: Componentwise<Component: Integer>,
{
    let (offset, count) = bit_range(offset, count);
    if count == 0 {
        return x.map(|x| x);
    }
    let mask = (u32::MAX >> (32 - count)) << offset;
    x.zip(new, |x, new| V::Component::from_bits(x.bits() & !mask | (new.bits() << offset) & mask))
}

/// The part of a range of bits that is inside 32; `offset` is below 32 unless the range is empty.
#[inline(always)]
fn bit_range(offset: u32, count: u32) -> (u32, u32) {
    let offset = offset.min(32);
    (offset, count.min(32 - offset))
}

/// `x << shift`, the shift modulo 32.
#[inline(always)]
pub fn shift_left<V>(x: V, shift: V::With<u32>) -> V::With<V::Component>
where
    V: Componentwise<Component: Integer>,
{
    x.zip_with(shift, |x, shift| V::Component::from_bits(x.bits().wrapping_shl(shift)))
}

/// `x >> shift`, the shift modulo 32, extending the sign of an `i32`.
#[inline(always)]
pub fn shift_right<V>(x: V, shift: V::With<u32>) -> V::With<V::Component>
where
    V: Componentwise<Component: Integer>,
{
    x.zip_with(shift, Integer::shift_right)
}
