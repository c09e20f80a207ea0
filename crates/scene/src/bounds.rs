//! Axis-aligned boxes.

use glam::{DAffine3, DVec3, Vec3};

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

    /// Its extents; negative where empty.
    pub fn diagonal(&self) -> Vec3 {
        self.max - self.min
    }
}

/// Meshes of more triangles than this, over all their instances, are placed by their box.
const EXACT_BOUNDS_LIMIT: usize = 1 << 22;

impl Scene {
    /// Around every triangle in the world; empty where there is none. Where a mesh has so many
    /// instances that to visit each vertex would take long, around their boxes.
    ///
    /// # Panics
    ///
    /// Where an index is out of range: call [`Scene::validate`] first.
    pub fn bounds(&self) -> Bounds {
        let mut n_uses = vec![0usize; self.meshes.len()];
        self.instances.iter().for_each(|i| n_uses[i.mesh as usize] += 1);
        let own: Vec<Bounds> = (0..).zip(&n_uses).map(|(mesh, &n)| self.own_bounds(mesh, n)).collect();
        let mut bounds = Bounds::EMPTY;
        for (index, instance) in (0u32..).zip(&self.instances) {
            let placed = self.placed(index);
            let n_triangles = placed.n_triangles();
            let n_uses = n_uses[instance.mesh as usize];
            bounds = bounds.union(if is_exact(n_triangles as usize, n_uses) {
                (0..n_triangles).fold(Bounds::EMPTY, |b, t| b.union(Bounds::of_points(&placed.positions(t))))
            } else {
                own[instance.mesh as usize].transformed(placed.world_from_mesh())
            });
        }
        bounds
    }

    /// A mesh's box in its own frame, where its instances are to be placed by it.
    fn own_bounds(&self, mesh: u32, n_uses: usize) -> Bounds {
        let alone = self.mesh_alone(mesh);
        if is_exact(alone.n_triangles() as usize, n_uses) {
            return Bounds::EMPTY;
        }
        (0..alone.n_triangles()).fold(Bounds::EMPTY, |b, t| b.union(Bounds::of_points(&alone.positions(t))))
    }
}

fn is_exact(n_triangles: usize, n_uses: usize) -> bool {
    n_uses <= 1 || n_triangles.saturating_mul(n_uses) <= EXACT_BOUNDS_LIMIT
}
