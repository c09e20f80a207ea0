//! Matrices: columns, as WGSL has them.

use std::ops::{Add, Mul, Sub};

use super::{AsIndex, Vec2, Vec3, Vec4, Zero, dot};

/// WGSL's `matCxR<f32>`, where `V` is the column `vecR<f32>`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Mat<V, const C: usize> {
    /// The columns.
    pub columns: [V; C],
}

impl<V: Copy, const C: usize> Mat<V, C> {
    /// A matrix of these columns.
    #[inline(always)]
    pub const fn new(columns: [V; C]) -> Self {
        Self { columns }
    }

    /// The column at `index`, the last one if it is out of range.
    #[inline(always)]
    pub fn at(self, index: impl AsIndex) -> V {
        self.columns[index.as_index(C)]
    }
}

impl<V: Zero, const C: usize> Zero for Mat<V, C> {
    const ZERO: Self = Self { columns: [V::ZERO; C] };
}

impl<V: Copy + Add<Output = V>, const C: usize> Add for Mat<V, C> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { columns: std::array::from_fn(|c| self.columns[c] + other.columns[c]) }
    }
}

impl<V: Copy + Sub<Output = V>, const C: usize> Sub for Mat<V, C> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { columns: std::array::from_fn(|c| self.columns[c] - other.columns[c]) }
    }
}

impl<V: Copy + Mul<f32, Output = V>, const C: usize> Mul<f32> for Mat<V, C> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, scalar: f32) -> Self {
        Self { columns: self.columns.map(|column| column * scalar) }
    }
}

impl<V: Copy + Mul<f32, Output = V>, const C: usize> Mul<Mat<V, C>> for f32 {
    type Output = Mat<V, C>;
    #[inline(always)]
    fn mul(self, matrix: Mat<V, C>) -> Mat<V, C> {
        matrix * self
    }
}

/// Products whose inner dimension is that of `$Vec`.
macro_rules! inner {
    ($Vec:ident, $n:literal, $c0:ident $($c:ident)*) => {
        impl<V> Mul<$Vec<f32>> for Mat<V, $n>
        where
            V: Copy + Add<Output = V> + Mul<f32, Output = V>,
        {
            type Output = V;
            #[inline(always)]
            fn mul(self, v: $Vec<f32>) -> V {
                let [$c0, $($c),*] = self.columns;
                $c0 * v.$c0 $(+ $c * v.$c)*
            }
        }

        impl<V, const C: usize> Mul<Mat<$Vec<f32>, C>> for Mat<V, $n>
        where
            V: Copy + Add<Output = V> + Mul<f32, Output = V>,
        {
            type Output = Mat<V, C>;
            #[inline(always)]
            fn mul(self, right: Mat<$Vec<f32>, C>) -> Mat<V, C> {
                Mat { columns: right.columns.map(|column| self * column) }
            }
        }
    };
}

inner!(Vec2, 2, x y);
inner!(Vec3, 3, x y z);
inner!(Vec4, 4, x y z w);

/// A matrix that can be transposed.
pub trait Transpose {
    /// Its transpose's type.
    type Output;
    /// Rows become columns.
    fn transpose(self) -> Self::Output;
}

/// What depends on both dimensions: `$Column` is a column, `$Row` a row.
macro_rules! outer {
    ($($Column:ident $r:literal $Row:ident $c:literal;)*) => {$(
        impl Mul<Mat<$Column<f32>, $c>> for $Column<f32> {
            type Output = $Row<f32>;
            #[inline(always)]
            fn mul(self, matrix: Mat<$Column<f32>, $c>) -> $Row<f32> {
                matrix.columns.map(|column| dot(self, column)).into()
            }
        }

        impl Transpose for Mat<$Column<f32>, $c> {
            type Output = Mat<$Row<f32>, $r>;
            #[inline(always)]
            fn transpose(self) -> Mat<$Row<f32>, $r> {
                let columns = self.columns.map($Column::to_array);
                Mat { columns: std::array::from_fn(|r| columns.map(|column| column[r]).into()) }
            }
        }
    )*};
}

outer! {
    Vec2 2 Vec2 2;
    Vec2 2 Vec3 3;
    Vec2 2 Vec4 4;
    Vec3 3 Vec2 2;
    Vec3 3 Vec3 3;
    Vec3 3 Vec4 4;
    Vec4 4 Vec2 2;
    Vec4 4 Vec3 3;
    Vec4 4 Vec4 4;
}

/// Rows become columns.
#[inline(always)]
pub fn transpose<M: Transpose>(matrix: M) -> M::Output {
    matrix.transpose()
}

/// A square matrix.
pub trait Square {
    /// Its determinant.
    fn determinant(self) -> f32;
}

impl Square for Mat<Vec2<f32>, 2> {
    #[inline]
    fn determinant(self) -> f32 {
        let [a, b] = self.columns;
        a.x * b.y - a.y * b.x
    }
}

impl Square for Mat<Vec3<f32>, 3> {
    #[inline]
    fn determinant(self) -> f32 {
        let [a, b, c] = self.columns;
        dot(a, super::cross(b, c))
    }
}

impl Square for Mat<Vec4<f32>, 4> {
    #[inline]
    fn determinant(self) -> f32 {
        // Laplace expansion by the upper and the lower pair of rows.
        let [a, b, c, d] = self.columns;
        let upper = |p: Vec4<f32>, q: Vec4<f32>| p.x * q.y - p.y * q.x;
        let lower = |p: Vec4<f32>, q: Vec4<f32>| p.z * q.w - p.w * q.z;
        upper(a, b) * lower(c, d) - upper(a, c) * lower(b, d)
            + upper(a, d) * lower(b, c)
            + upper(b, c) * lower(a, d)
            - upper(b, d) * lower(a, c)
            + upper(c, d) * lower(a, b)
    }
}

/// The determinant of a square matrix.
#[inline(always)]
pub fn determinant<M: Square>(matrix: M) -> f32 {
    matrix.determinant()
}
