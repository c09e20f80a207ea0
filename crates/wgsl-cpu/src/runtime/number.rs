//! Scalars with WGSL's arithmetic: integers wrap, nothing traps, every conversion is defined.

/// A WGSL type that has a zero value.
pub trait Zero: Copy {
    /// The zero value.
    const ZERO: Self;
}

/// The zero value of `T`.
#[inline(always)]
pub const fn zero<T: Zero>() -> T {
    T::ZERO
}

impl<T: Zero, const N: usize> Zero for [T; N] {
    const ZERO: Self = [T::ZERO; N];
}

/// Any scalar, by its conversions. `to_*` are WGSL's value conversions and `bits` is what
/// `bitcast` reinterprets.
pub trait Scalar: Copy + PartialEq + Zero {
    /// `f32(self)`.
    fn to_f32(self) -> f32;
    /// `i32(self)`: floats are clamped to what both types represent, NaN gives 0.
    fn to_i32(self) -> i32;
    /// `u32(self)`: floats are clamped to what both types represent, NaN gives 0.
    fn to_u32(self) -> u32;
    /// `bool(self)`: whether it is not zero.
    #[inline(always)]
    fn to_bool(self) -> bool {
        self != Self::ZERO
    }
    /// Its 32 bits.
    fn bits(self) -> u32;
}

/// `f32`, `i32` and `u32`: the scalars that can be calculated with.
pub trait Number: Scalar + PartialOrd {
    /// One.
    const ONE: Self;
    /// `self + other`, wrapping.
    fn add(self, other: Self) -> Self;
    /// `self - other`, wrapping.
    fn sub(self, other: Self) -> Self;
    /// `self * other`, wrapping.
    fn mul(self, other: Self) -> Self;
    /// `self / other`; for integers `x / 0 = x` and `MIN / -1 = MIN`.
    fn div(self, other: Self) -> Self;
    /// `self % other`, with the sign of `self`; for integers `x % 0 = 0`.
    fn rem(self, other: Self) -> Self;
    /// The lesser; of a NaN and a number, the number.
    fn min(self, other: Self) -> Self;
    /// The greater; of a NaN and a number, the number.
    fn max(self, other: Self) -> Self;
    /// The absolute value, wrapping.
    fn abs(self) -> Self;
    /// -1, 0 or 1.
    fn sign(self) -> Self;
}

/// `f32` and `i32`.
pub trait Signed: Number {
    /// `-self`, wrapping.
    fn neg(self) -> Self;
}

/// The largest `f32` that is also an `i32`.
const I32_MAX_F32: f32 = 2_147_483_520.0;
/// The largest `f32` that is also a `u32`.
const U32_MAX_F32: f32 = 4_294_967_040.0;

impl Zero for bool {
    const ZERO: Self = false;
}

impl Scalar for bool {
    #[inline(always)]
    fn to_f32(self) -> f32 {
        f32::from(u8::from(self))
    }
    #[inline(always)]
    fn to_i32(self) -> i32 {
        i32::from(self)
    }
    #[inline(always)]
    fn to_u32(self) -> u32 {
        u32::from(self)
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
}

impl Zero for f32 {
    const ZERO: Self = 0.0;
}

impl Scalar for f32 {
    #[inline(always)]
    fn to_f32(self) -> f32 {
        self
    }
    #[inline(always)]
    fn to_i32(self) -> i32 {
        // Written so that a NaN stays one and `as` makes it 0.
        (if self > I32_MAX_F32 { I32_MAX_F32 } else { self }) as i32
    }
    #[inline(always)]
    fn to_u32(self) -> u32 {
        (if self > U32_MAX_F32 { U32_MAX_F32 } else { self }) as u32
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        self.to_bits()
    }
}

impl Number for f32 {
    const ONE: Self = 1.0;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self + other
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self - other
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self * other
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self / other
    }
    #[inline(always)]
    fn rem(self, other: Self) -> Self {
        self - other * (self / other).trunc()
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.min(other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.max(other)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn sign(self) -> Self {
        f32::from(i8::from(self > 0.0) - i8::from(self < 0.0))
    }
}

impl Signed for f32 {
    #[inline(always)]
    fn neg(self) -> Self {
        -self
    }
}

/// The parts of [`Scalar`] and [`Number`] that both integer types have in common.
macro_rules! integer {
    ($int:ident, $abs:expr, $sign:expr) => {
        impl Zero for $int {
            const ZERO: Self = 0;
        }

        impl Scalar for $int {
            #[inline(always)]
            fn to_f32(self) -> f32 {
                self as f32
            }
            #[inline(always)]
            fn to_i32(self) -> i32 {
                self as i32
            }
            #[inline(always)]
            fn to_u32(self) -> u32 {
                self as u32
            }
            #[inline(always)]
            fn bits(self) -> u32 {
                self as u32
            }
        }

        impl Number for $int {
            const ONE: Self = 1;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                self.wrapping_add(other)
            }
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                self.wrapping_sub(other)
            }
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                self.wrapping_mul(other)
            }
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                if other == 0 { self } else { self.wrapping_div(other) }
            }
            #[inline(always)]
            fn rem(self, other: Self) -> Self {
                if other == 0 { 0 } else { self.wrapping_rem(other) }
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Ord::min(self, other)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Ord::max(self, other)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $abs(self)
            }
            #[inline(always)]
            fn sign(self) -> Self {
                $sign(self)
            }
        }
    };
}

integer!(i32, i32::wrapping_abs, i32::signum);
integer!(u32, std::convert::identity, |value| Ord::min(value, 1));

impl Signed for i32 {
    #[inline(always)]
    fn neg(self) -> Self {
        self.wrapping_neg()
    }
}

/// `a / b` of two scalars.
#[inline(always)]
pub fn div<T: Number>(a: T, b: T) -> T {
    a.div(b)
}

/// `a % b` of two scalars.
#[inline(always)]
pub fn rem<T: Number>(a: T, b: T) -> T {
    a.rem(b)
}
