//! Vectors: plain values with WGSL's component-wise operators.

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Rem, Sub};

use super::{AsIndex, Number, Scalar, Signed, Zero};

/// A scalar or a vector, as functions that work on each component see it.
pub trait Componentwise: Copy {
    /// The component's type.
    type Component: Scalar;
    /// The same shape with components of another type.
    type With<U: Scalar>;
    /// Applies `f` to each component.
    fn map<U: Scalar>(self, f: impl Fn(Self::Component) -> U) -> Self::With<U>;
    /// Applies `f` to each pair of components.
    fn zip<U: Scalar>(self, other: Self, f: impl Fn(Self::Component, Self::Component) -> U) -> Self::With<U>;
    /// [`Componentwise::zip`] with components of another type.
    fn zip_with<W: Scalar, U: Scalar>(
        self,
        other: Self::With<W>,
        f: impl Fn(Self::Component, W) -> U,
    ) -> Self::With<U>;
    /// Applies `f` to each triple of components.
    fn zip3<U: Scalar>(
        self,
        second: Self,
        third: Self,
        f: impl Fn(Self::Component, Self::Component, Self::Component) -> U,
    ) -> Self::With<U>;
    /// The components of `accept` where `condition` holds, else those of `self`.
    fn select(self, accept: Self, condition: Self::With<bool>) -> Self;
    /// Combines pairs of components by `product` and these, from the first to the last, by `sum`.
    fn inner(
        self,
        other: Self,
        product: impl Fn(Self::Component, Self::Component) -> Self::Component,
        sum: impl Fn(Self::Component, Self::Component) -> Self::Component,
    ) -> Self::Component;
    /// Combines all components from the first to the last.
    fn fold<A>(self, start: A, f: impl Fn(A, Self::Component) -> A) -> A;
}

macro_rules! scalar {
    ($($scalar:ident)*) => {$(
        impl Componentwise for $scalar {
            type Component = $scalar;
            type With<U: Scalar> = U;
            #[inline(always)]
            fn map<U: Scalar>(self, f: impl Fn($scalar) -> U) -> U {
                f(self)
            }
            #[inline(always)]
            fn zip<U: Scalar>(self, other: Self, f: impl Fn($scalar, $scalar) -> U) -> U {
                f(self, other)
            }
            #[inline(always)]
            fn zip_with<W: Scalar, U: Scalar>(self, other: W, f: impl Fn($scalar, W) -> U) -> U {
                f(self, other)
            }
            #[inline(always)]
            fn zip3<U: Scalar>(
                self,
                second: Self,
                third: Self,
                f: impl Fn($scalar, $scalar, $scalar) -> U,
            ) -> U {
                f(self, second, third)
            }
            #[inline(always)]
            fn select(self, accept: Self, condition: bool) -> Self {
                if condition { accept } else { self }
            }
            #[inline(always)]
            fn inner(
                self,
                other: Self,
                product: impl Fn(Self, Self) -> Self,
                _: impl Fn(Self, Self) -> Self,
            ) -> Self {
                product(self, other)
            }
            #[inline(always)]
            fn fold<A>(self, start: A, f: impl Fn(A, $scalar) -> A) -> A {
                f(start, self)
            }
        }
    )*};
}

scalar!(bool f32 i32 u32);

/// One vector type: its shape, component access and zero value.
macro_rules! vector {
    ($Vec:ident, $n:literal, $name:literal, $($c:ident $i:literal),*; x $($rest:ident)*) => {
        #[doc = concat!("WGSL's `", $name, "<T>`.")]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        #[repr(C)]
        pub struct $Vec<T> {
            $(#[doc = concat!("The component `", stringify!($c), "`.")] pub $c: T,)*
        }

        impl<T: Copy> $Vec<T> {
            /// A vector of these components.
            #[inline(always)]
            pub const fn new($($c: T),*) -> Self {
                Self { $($c),* }
            }

            /// The same value in every component.
            #[inline(always)]
            pub const fn splat(value: T) -> Self {
                Self { $($c: value),* }
            }

            /// The components in order.
            #[inline(always)]
            pub const fn to_array(self) -> [T; $n] {
                [$(self.$c),*]
            }

            /// The component at `index`, the last one if it is out of range.
            #[inline(always)]
            pub fn at(self, index: impl AsIndex) -> T {
                self.to_array()[index.as_index($n)]
            }

            /// The place of the component at `index`, the last one if it is out of range.
            #[inline(always)]
            pub fn at_mut(&mut self, index: impl AsIndex) -> &mut T {
                match index.as_index($n) {
                    $($i => &mut self.$c,)*
                    _ => unreachable!("an index in range"),
                }
            }
        }

        impl<T: Copy> From<[T; $n]> for $Vec<T> {
            #[inline(always)]
            fn from([$($c),*]: [T; $n]) -> Self {
                Self { $($c),* }
            }
        }

        impl<T: Zero> Zero for $Vec<T> {
            const ZERO: Self = Self { $($c: T::ZERO),* };
        }

        impl<T: Scalar> Componentwise for $Vec<T> {
            type Component = T;
            type With<U: Scalar> = $Vec<U>;
            #[inline(always)]
            fn map<U: Scalar>(self, f: impl Fn(T) -> U) -> $Vec<U> {
                $Vec { $($c: f(self.$c)),* }
            }
            #[inline(always)]
            fn zip<U: Scalar>(self, other: Self, f: impl Fn(T, T) -> U) -> $Vec<U> {
                $Vec { $($c: f(self.$c, other.$c)),* }
            }
            #[inline(always)]
            fn zip_with<W: Scalar, U: Scalar>(self, other: $Vec<W>, f: impl Fn(T, W) -> U) -> $Vec<U> {
                $Vec { $($c: f(self.$c, other.$c)),* }
            }
            #[inline(always)]
            fn zip3<U: Scalar>(self, second: Self, third: Self, f: impl Fn(T, T, T) -> U) -> $Vec<U> {
                $Vec { $($c: f(self.$c, second.$c, third.$c)),* }
            }
            #[inline(always)]
            fn select(self, accept: Self, condition: $Vec<bool>) -> Self {
                Self { $($c: if condition.$c { accept.$c } else { self.$c }),* }
            }
            #[inline(always)]
            fn inner(self, other: Self, product: impl Fn(T, T) -> T, sum: impl Fn(T, T) -> T) -> T {
                let total = product(self.x, other.x);
                $(let total = sum(total, product(self.$rest, other.$rest));)*
                total
            }
            #[inline(always)]
            fn fold<A>(self, start: A, f: impl Fn(A, T) -> A) -> A {
                [$(self.$c),*].into_iter().fold(start, f)
            }
        }

        operators!($Vec, $($c),*);
    };
}

/// The operators of one vector type: with a vector, and with a scalar on either side.
macro_rules! operators {
    ($Vec:ident, $($c:ident),*) => {
        number_operator!($Vec, Add add, $($c),*);
        number_operator!($Vec, Sub sub, $($c),*);
        number_operator!($Vec, Mul mul, $($c),*);
        number_operator!($Vec, Div div, $($c),*);
        number_operator!($Vec, Rem rem, $($c),*);
        bit_operator!($Vec, BitAnd bitand, $($c),*);
        bit_operator!($Vec, BitOr bitor, $($c),*);
        bit_operator!($Vec, BitXor bitxor, $($c),*);
        scalar_on_the_left!($Vec, f32 i32 u32);

        impl<T: Signed> Neg for $Vec<T> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self { $($c: Signed::neg(self.$c)),* }
            }
        }

        impl<T: Not<Output = T>> Not for $Vec<T> {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                Self { $($c: !self.$c),* }
            }
        }
    };
}

macro_rules! number_operator {
    ($Vec:ident, $Op:ident $op:ident, $($c:ident),*) => {
        impl<T: Number> $Op for $Vec<T> {
            type Output = Self;
            #[inline(always)]
            fn $op(self, other: Self) -> Self {
                Self { $($c: Number::$op(self.$c, other.$c)),* }
            }
        }

        impl<T: Number> $Op<T> for $Vec<T> {
            type Output = Self;
            #[inline(always)]
            fn $op(self, other: T) -> Self {
                Self { $($c: Number::$op(self.$c, other)),* }
            }
        }
    };
}

macro_rules! bit_operator {
    ($Vec:ident, $Op:ident $op:ident, $($c:ident),*) => {
        impl<T: $Op<Output = T>> $Op for $Vec<T> {
            type Output = Self;
            #[inline(always)]
            fn $op(self, other: Self) -> Self {
                Self { $($c: self.$c.$op(other.$c)),* }
            }
        }
    };
}

/// `scalar op vector`, which cannot be generic in the scalar.
macro_rules! scalar_on_the_left {
    ($Vec:ident, $($scalar:ident)*) => {$(
        scalar_on_the_left!($Vec, $scalar, Add add);
        scalar_on_the_left!($Vec, $scalar, Sub sub);
        scalar_on_the_left!($Vec, $scalar, Mul mul);
        scalar_on_the_left!($Vec, $scalar, Div div);
        scalar_on_the_left!($Vec, $scalar, Rem rem);
    )*};
    ($Vec:ident, $scalar:ident, $Op:ident $op:ident) => {
        impl $Op<$Vec<$scalar>> for $scalar {
            type Output = $Vec<$scalar>;
            #[inline(always)]
            fn $op(self, other: $Vec<$scalar>) -> $Vec<$scalar> {
                $Op::$op($Vec::splat(self), other)
            }
        }
    };
}

vector!(Vec2, 2, "vec2", x 0, y 1; x y);
vector!(Vec3, 3, "vec3", x 0, y 1, z 2; x y z);
vector!(Vec4, 4, "vec4", x 0, y 1, z 2, w 3; x y z w);

macro_rules! comparison {
    ($($name:ident, $operator:tt, $bound:ident;)*) => {$(
        #[doc = concat!("`a ", stringify!($operator), " b` of each pair of components.")]
        #[inline(always)]
        pub fn $name<V: Componentwise<Component: $bound>>(a: V, b: V) -> V::With<bool> {
            a.zip(b, |a, b| a $operator b)
        }
    )*};
}

comparison! {
    equal, ==, Scalar;
    not_equal, !=, Scalar;
    less, <, Number;
    less_equal, <=, Number;
    greater, >, Number;
    greater_equal, >=, Number;
}

/// The components of `accept` where `condition` holds, else those of `reject`.
#[inline(always)]
pub fn select<V: Componentwise>(reject: V, accept: V, condition: V::With<bool>) -> V {
    reject.select(accept, condition)
}

/// Whether every component holds.
#[inline(always)]
pub fn all<V: Componentwise<Component = bool>>(v: V) -> bool {
    v.fold(true, |all, component| all & component)
}

/// Whether any component holds.
#[inline(always)]
pub fn any<V: Componentwise<Component = bool>>(v: V) -> bool {
    v.fold(false, |any, component| any | component)
}

/// Value conversion to `f32`.
#[inline(always)]
pub fn to_f32<V: Componentwise>(v: V) -> V::With<f32> {
    v.map(Scalar::to_f32)
}

/// Value conversion to `i32`: floats are clamped, NaN gives 0.
#[inline(always)]
pub fn to_i32<V: Componentwise>(v: V) -> V::With<i32> {
    v.map(Scalar::to_i32)
}

/// Value conversion to `u32`: floats are clamped, NaN gives 0.
#[inline(always)]
pub fn to_u32<V: Componentwise>(v: V) -> V::With<u32> {
    v.map(Scalar::to_u32)
}

/// Value conversion to `bool`: whether each component is not zero.
#[inline(always)]
pub fn to_bool<V: Componentwise>(v: V) -> V::With<bool> {
    v.map(Scalar::to_bool)
}

/// The same bits as `f32`.
#[inline(always)]
pub fn bitcast_f32<V: Componentwise>(v: V) -> V::With<f32> {
    v.map(|component| f32::from_bits(component.bits()))
}

/// The same bits as `i32`.
#[inline(always)]
pub fn bitcast_i32<V: Componentwise>(v: V) -> V::With<i32> {
    v.map(|component| component.bits() as i32)
}

/// The same bits as `u32`.
#[inline(always)]
pub fn bitcast_u32<V: Componentwise>(v: V) -> V::With<u32> {
    v.map(Scalar::bits)
}
