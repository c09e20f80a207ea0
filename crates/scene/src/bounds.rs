//! Axis-aligned boxes.

use glam::{DAffine3, DVec3, Vec3};

use crate::{PlacedMesh, Scene};

/// An axis-aligned box; inverted (+∞ to -∞) where it holds nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least corner.
    pub min: Vec3,
    /// Greatest corner.
    pub max: Vec3,
}

/// A ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Its middle.
    pub centre: Vec3,
    /// > 0.
    pub radius: f32,
}

impl Bounds {
    /// Holds nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// Around points.
    pub fn of_points(points: &[Vec3]) -> Self {
        points.iter().copied().fold(Self::EMPTY, Self::with_point)
    }

    fn with_point(self, p: Vec3) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
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

    /// Around its corners in another frame, rounded outwards; empty where it is.
    #[must_use]
    pub fn transformed(&self, other_from_this: &DAffine3) -> Self {
        if self.is_empty() {
            return *self;
        }
        let corners = [self.min.as_dvec3(), self.max.as_dvec3()];
        let mut all = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in 0..8 {
            let pick = |axis: usize| corners[corner >> axis & 1][axis];
            let p = other_from_this.transform_point3(DVec3::new(pick(0), pick(1), pick(2)));
            all = (all.0.min(p), all.1.max(p));
        }
        Self { min: all.0.as_vec3().map(f32::next_down), max: all.1.as_vec3().map(f32::next_up) }
    }

    /// Its middle; NaN where empty.
    pub fn centre(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// A sphere around it, a little larger than need be, so that rounding leaves nothing outside.
    pub fn sphere(&self) -> Sphere {
        if self.is_empty() {
            return Sphere { centre: Vec3::ZERO, radius: 1.0 };
        }
        let largest = self.min.abs().max(self.max.abs()).max_element();
        let half = 0.5 * (self.max.as_dvec3() - self.min.as_dvec3()).length() as f32;
        let radius = half * 1.0001 + largest * (8.0 * f32::EPSILON);
        Sphere { centre: self.centre(), radius: radius.max(1e-15) }
    }

    /// Its extents; negative where empty.
    pub fn diagonal(&self) -> Vec3 {
        self.max - self.min
    }
}

/// Where meshes that are there several times have more triangles than this in all, they are placed by
/// their boxes.
const EXACT_BOUNDS_LIMIT: usize = 1 << 22;

impl Scene {
    /// Around every triangle in the world; empty where there is none. Where instances are so many
    /// that to visit each vertex would take long, around the boxes of meshes that several place.
    ///
    /// # Panics
    ///
    /// Where an index is out of range: call [`Scene::validate`] first.
    pub fn bounds(&self) -> Bounds {
        let mut n_uses = vec![0usize; self.meshes.len()];
        self.instances.iter().for_each(|i| n_uses[i.mesh as usize] += 1);
        let several = |mesh: usize| n_uses[mesh] > 1;
        let n_repeated: usize = (0..self.meshes.len())
            .filter(|&mesh| several(mesh))
            .map(|mesh| self.meshes[mesh].triangles.len().saturating_mul(n_uses[mesh]))
            .fold(0, usize::saturating_add);
        let by_box = |mesh: usize| several(mesh) && n_repeated > EXACT_BOUNDS_LIMIT;
        let boxes: Vec<Bounds> = (0..self.meshes.len())
            .map(
                |mesh| {
                    if by_box(mesh) { exact_bounds(&self.mesh_alone(mesh as u32)) } else { Bounds::EMPTY }
                },
            )
            .collect();
        let placed = |index: usize| {
            let (placed, mesh) = (self.placed(index as u32), self.instances[index].mesh as usize);
            match by_box(mesh) {
                true => boxes[mesh].transformed(placed.world_from_mesh()),
                false => exact_bounds(&placed),
            }
        };
        (0..self.instances.len()).map(placed).fold(Bounds::EMPTY, Bounds::union)
    }
}

/// Each vertex that a triangle has is placed once, not once for each of these.
fn exact_bounds(placed: &PlacedMesh<'_>) -> Bounds {
    let mesh = placed.mesh();
    let mut is_used = vec![false; mesh.positions.len()];
    mesh.triangles.as_flattened().iter().for_each(|&vertex| is_used[vertex as usize] = true);
    let used = mesh.positions.iter().zip(is_used).filter(|&(_, is_used)| is_used);
    used.map(|(&position, _)| placed.place(position)).fold(Bounds::EMPTY, Bounds::with_point)
}
