//! Axis-aligned boxes.

use glam::Vec3;

use crate::Scene;

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

    /// Its middle; NaN where empty.
    pub fn centre(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Its extents; negative where empty.
    pub fn diagonal(&self) -> Vec3 {
        self.max - self.min
    }
}

impl Scene {
    /// Around every triangle in the world; empty where there is none.
    ///
    /// # Panics
    ///
    /// Where an index is out of range: call [`Scene::validate`] first.
    pub fn bounds(&self) -> Bounds {
        self.world_triangles().fold(Bounds::EMPTY, |b, t| b.union(Bounds::of_points(&t.positions)))
    }
}
