//! WGSL's numeric built-in functions. Functions of one value work on each component.

use super::{Componentwise, Number, Scalar};

/// Functions of one `f32`.
macro_rules! float {
    ($($(#[$doc:meta])* $name:ident = $f:expr;)*) => {$(
        $(#[$doc])*
        #[inline(always)]
        pub fn $name<V: Componentwise<Component = f32>>(x: V) -> V::With<f32> {
            x.map($f)
        }
    )*};
}

float! {
    /// Cosine of an angle in radians.
    cos = f32::cos;
    /// Hyperbolic cosine.
    cosh = f32::cosh;
    /// Sine of an angle in radians.
    sin = f32::sin;
    /// Hyperbolic sine.
    sinh = f32::sinh;
    /// Tangent of an angle in radians.
    tan = f32::tan;
    /// Hyperbolic tangent.
    tanh = f32::tanh;
    /// Arc cosine.
    acos = f32::acos;
    /// Inverse hyperbolic cosine.
    acosh = f32::acosh;
    /// Arc sine.
    asin = f32::asin;
    /// Inverse hyperbolic sine.
    asinh = f32::asinh;
    /// Arc tangent.
    atan = f32::atan;
    /// Inverse hyperbolic tangent.
    atanh = f32::atanh;
    /// Degrees to radians.
    radians = f32::to_radians;
    /// Radians to degrees.
    degrees = f32::to_degrees;
    /// The least integer not below.
    ceil = f32::ceil;
    /// The greatest integer not above.
    floor = f32::floor;
    /// The nearest integer, ties to even.
    round = f32::round_ties_even;
    /// The integer part.
    trunc = f32::trunc;
    /// `x - floor(x)`.
    fract = |x| x - x.floor();
    /// `e` to the power of `x`.
    exp = f32::exp;
    /// 2 to the power of `x`.
    exp2 = f32::exp2;
    /// Natural logarithm.
    log = f32::ln;
    /// Logarithm to base 2.
    log2 = f32::log2;
    /// Square root.
    sqrt = f32::sqrt;
    /// `1 / sqrt(x)`.
    inverse_sqrt = |x| 1.0 / x.sqrt();
    /// Clamped to 0 and 1; NaN gives 0.
    saturate = unit;
    /// Rounded to what binary16 represents.
    quantize_to_f16 = |x| super::f16_to_f32(super::f32_to_f16(x));
}

/// `x` clamped to 0 and 1; NaN gives 0, which `f32::clamp` would pass on.
#[inline(always)]
fn unit(x: f32) -> f32 {
    Number::min(Number::max(x, 0.0), 1.0)
}

/// The angle of `(x, y)`.
#[inline(always)]
pub fn atan2<V: Componentwise<Component = f32>>(y: V, x: V) -> V::With<f32> {
    y.zip(x, f32::atan2)
}

/// `x` to the power of `y`.
#[inline(always)]
pub fn pow<V: Componentwise<Component = f32>>(x: V, y: V) -> V::With<f32> {
    x.zip(y, f32::powf)
}

/// 1 where `edge <= x`, else 0.
#[inline(always)]
pub fn step<V: Componentwise<Component = f32>>(edge: V, x: V) -> V::With<f32> {
    edge.zip(x, |edge, x| (edge <= x).to_f32())
}

/// `a * b + c`: one rounding where the target has the instruction, else two, as WGSL allows.
#[inline(always)]
pub fn fma<V: Componentwise<Component = f32>>(a: V, b: V, c: V) -> V::With<f32> {
    a.zip3(b, c, |a, b, c| if cfg!(target_feature = "fma") { a.mul_add(b, c) } else { a * b + c })
}

/// `a * (1 - t) + b * t`.
#[inline(always)]
pub fn mix<V: Componentwise<Component = f32>>(a: V, b: V, t: V) -> V::With<f32> {
    a.zip3(b, t, |a, b, t| a * (1.0 - t) + b * t)
}

/// Hermite interpolation between 0 at `low` and 1 at `high`.
#[inline(always)]
pub fn smoothstep<V: Componentwise<Component = f32>>(low: V, high: V, x: V) -> V::With<f32> {
    low.zip3(x, high, |low, x, high| {
        let t = unit((x - low) / (high - low));
        t * t * (3.0 - 2.0 * t)
    })
}

/// `x * 2^exponent`, exact also where `2^exponent` alone is not representable.
#[inline(always)]
pub fn ldexp<V: Componentwise<Component = f32>>(x: V, exponent: V::With<i32>) -> V::With<f32> {
    x.zip_with(exponent, scale_by_power)
}

/// One component of [`ldexp`]. A double holds every product before the only rounding.
#[inline]
fn scale_by_power(x: f32, exponent: i32) -> f32 {
    let exponent = exponent.clamp(-400, 400) as i64;
    (f64::from(x) * f64::from_bits(((1023 + exponent) as u64) << 52)) as f32
}

/// WGSL's result of `modf`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModfResult<V> {
    /// The fractional part, with the sign of the argument.
    pub fract: V,
    /// The whole part.
    pub whole: V,
}

/// The fractional and the whole part.
#[inline(always)]
pub fn modf<V: Componentwise<Component = f32>>(x: V) -> ModfResult<V::With<f32>> {
    ModfResult { fract: x.map(|x| x - x.trunc()), whole: x.map(f32::trunc) }
}

/// WGSL's result of `frexp`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrexpResult<V, E> {
    /// In `[0.5, 1)` by magnitude, or zero.
    pub fract: V,
    /// The power of two that it is scaled by.
    pub exp: E,
}

/// `x = fract * 2^exp` with `fract` in `[0.5, 1)` by magnitude, or both zero.
#[inline(always)]
pub fn frexp<V: Componentwise<Component = f32>>(x: V) -> FrexpResult<V::With<f32>, V::With<i32>> {
    FrexpResult { fract: x.map(|x| significand(x).0), exp: x.map(|x| significand(x).1) }
}

/// One component of [`frexp`].
#[inline]
fn significand(x: f32) -> (f32, i32) {
    if x == 0.0 || !x.is_finite() {
        return (x, 0);
    }
    // Every finite float is a normal double.
    let bits = f64::from(x).to_bits();
    let exponent = (bits >> 52 & 0x7ff) as i32 - 1022;
    (f64::from_bits(bits & !(0x7ff << 52) | 1022 << 52) as f32, exponent)
}

/// The absolute value.
#[inline(always)]
pub fn abs<V: Componentwise<Component: Number>>(x: V) -> V::With<V::Component> {
    x.map(Number::abs)
}

/// -1, 0 or 1.
#[inline(always)]
pub fn sign<V: Componentwise<Component: Number>>(x: V) -> V::With<V::Component> {
    x.map(Number::sign)
}

/// The lesser; of a NaN and a number, the number.
#[inline(always)]
pub fn min<V: Componentwise<Component: Number>>(a: V, b: V) -> V::With<V::Component> {
    a.zip(b, Number::min)
}

/// The greater; of a NaN and a number, the number.
#[inline(always)]
pub fn max<V: Componentwise<Component: Number>>(a: V, b: V) -> V::With<V::Component> {
    a.zip(b, Number::max)
}

/// `min(max(x, low), high)`.
#[inline(always)]
pub fn clamp<V: Componentwise<Component: Number>>(x: V, low: V, high: V) -> V::With<V::Component> {
    x.zip3(low, high, |x, low, high| Number::min(Number::max(x, low), high))
}
