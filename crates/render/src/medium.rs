//! Which medium a point lies in, by the surfaces a ray from it crosses.

use glam::Vec3;
use midway_accel::{Bvh, closest_hit};
use midway_scene::{Material, WorldTriangle};

/// Crossings followed at most; beyond it the point counts as outside.
const MAX_CROSSINGS: usize = 256;

/// Finds the medium of points in a scene.
pub struct MediumFinder<'a> {
    /// The hierarchy over `positions`.
    pub bvh: &'a Bvh,
    /// Vertices of the world's triangles.
    pub positions: &'a [[Vec3; 3]],
    /// The world's triangles.
    pub triangles: &'a [WorldTriangle],
    /// The scene's materials.
    pub materials: &'a [Material],
}

impl MediumFinder<'_> {
    /// Whether any material has an inside.
    pub fn any_medium(&self) -> bool {
        self.materials.iter().any(is_boundary)
    }

    /// The material whose inside the point lies in, by the boundaries crossed on the way out along
    /// `direction`: each crossed from inside without having been entered on the way encloses the
    /// point; the first met is the innermost.
    pub fn medium_at(&self, point: Vec3, direction: Vec3) -> Option<u32> {
        let mut entered: Vec<u32> = Vec::new();
        let mut origin = point;
        for _ in 0..MAX_CROSSINGS {
            let hit = closest_hit(self.bvh, self.positions, origin, direction, f32::MAX)?;
            let triangle = &self.triangles[hit.triangle as usize];
            let normal = triangle.geometric_normal()?;
            let material = triangle.material;
            if is_boundary(&self.materials[material as usize]) {
                if normal.dot(direction) < 0.0 {
                    entered.push(material);
                } else if let Some(place) = entered.iter().rposition(|&m| m == material) {
                    entered.remove(place);
                } else {
                    return Some(material);
                }
            }
            let step = hit.t * (1.0 + 1e-5);
            origin += direction * step.max(f32::MIN_POSITIVE);
        }
        None
    }
}

fn is_boundary(material: &Material) -> bool {
    material.surface.has_inside()
}
