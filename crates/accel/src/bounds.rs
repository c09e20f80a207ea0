//! Axis-aligned boxes.

use glam::Vec3;

/// An axis-aligned box; inverted (+∞ to -∞) where it holds nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least corner.
    pub min: Vec3,
    /// Greatest corner.
    pub max: Vec3,
}

impl Bounds {
    /// Holds nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// Around points.
    pub fn of_points(points: &[Vec3]) -> Self {
        points.iter().fold(Self::EMPTY, |b, &p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// Around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether all of `other` is within; true where `other` is empty.
    pub fn contains(&self, other: &Self) -> bool {
        other.is_empty() || (self.min.cmple(other.min).all() && self.max.cmpge(other.max).all())
    }

    /// Whether a point is within.
    pub fn contains_point(&self, p: Vec3) -> bool {
        self.min.cmple(p).all() && self.max.cmpge(p).all()
    }

    /// Whether it holds nothing.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Half the surface area; 0 where empty. In f64, since squares of large extents overflow f32.
    pub fn half_area(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let d = self.max.as_dvec3() - self.min.as_dvec3();
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// Grown on each side by four units in the last place of its own coordinates, so that a slab
    /// test in f32 does not miss what lies on a face. Saturates at the largest finite number.
    pub(crate) fn padded(self) -> Self {
        let pad =
            (self.min.abs().max(self.max.abs()) * (4.0 * f32::EPSILON)).max(Vec3::splat(f32::MIN_POSITIVE));
        Self {
            min: (self.min - pad).max(Vec3::splat(f32::MIN)),
            max: (self.max + pad).min(Vec3::splat(f32::MAX)),
        }
    }
}
