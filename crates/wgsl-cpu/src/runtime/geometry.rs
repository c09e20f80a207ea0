//! WGSL's geometric functions.

use std::ops::{Add, Mul, Neg, Sub};

use super::{Componentwise, Number, Vec2, Vec3, Vec4, Zero};

/// A scalar or vector of `f32` with the operators that geometry needs.
pub trait Geometric:
    Componentwise<Component = f32>
    + Zero
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<f32, Output = Self>
{
    /// Its Euclidean length.
    #[inline(always)]
    fn length(self) -> f32 {
        dot(self, self).sqrt()
    }
}

impl Geometric for f32 {
    #[inline(always)]
    fn length(self) -> f32 {
        self.abs()
    }
}

impl Geometric for Vec2<f32> {}
impl Geometric for Vec3<f32> {}
impl Geometric for Vec4<f32> {}

/// The sum of the products of components.
#[inline(always)]
pub fn dot<V: Componentwise<Component: Number>>(a: V, b: V) -> V::Component {
    a.inner(b, Number::mul, Number::add)
}

/// The Euclidean length.
#[inline(always)]
pub fn length<V: Geometric>(v: V) -> f32 {
    v.length()
}

/// The length of the difference.
#[inline(always)]
pub fn distance<V: Geometric>(a: V, b: V) -> f32 {
    (a - b).length()
}

/// `v` scaled to length 1; not a number if `v` is zero.
#[inline(always)]
pub fn normalize<V: Geometric>(v: V) -> V {
    v * (1.0 / v.length())
}

/// The cross product.
#[inline(always)]
pub fn cross(a: Vec3<f32>, b: Vec3<f32>) -> Vec3<f32> {
    Vec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// `v` where `incident` and `reference` are opposed, else `-v`.
#[inline(always)]
pub fn face_forward<V: Geometric>(v: V, incident: V, reference: V) -> V {
    if dot(reference, incident) < 0.0 { v } else { -v }
}

/// The mirror direction of `incident` at the unit normal `normal`.
#[inline(always)]
pub fn reflect<V: Geometric>(incident: V, normal: V) -> V {
    incident - normal * (2.0 * dot(normal, incident))
}

/// The refracted direction for the ratio `eta` of indices, zero at total reflection.
#[inline(always)]
pub fn refract<V: Geometric>(incident: V, normal: V, eta: f32) -> V {
    let cos = dot(normal, incident);
    let k = 1.0 - eta * eta * (1.0 - cos * cos);
    if k < 0.0 { V::ZERO } else { incident * eta - normal * (eta * cos + k.sqrt()) }
}
