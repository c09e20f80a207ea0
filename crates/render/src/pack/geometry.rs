//! Triangles as traversal and as shading read them.

use glam::Vec3;
use midway_accel::Bvh;
use midway_kernels::constants as k;
use midway_scene::WorldTriangle;

use super::{Word4, word4};
use crate::lights::Lights;

/// The slots of the hierarchy's leaves.
pub(super) fn pack_triangles(bvh: &Bvh, positions: &[[Vec3; 3]]) -> Vec<Word4> {
    let mut words = Vec::with_capacity(bvh.primitives.len() * k::TRIANGLE_STRIDE as usize);
    for &primitive in &bvh.primitives {
        let [a, b, c] = positions[primitive as usize];
        words.extend([word4(a, primitive), word4(b - a, 0), word4(c - a, 0)]);
    }
    words
}

/// What shading needs of each triangle.
pub(super) fn pack_surfaces(world: &[WorldTriangle], lights: &Lights, words: &mut Vec<Word4>) {
    let mut light_of = vec![k::NONE; world.len()];
    for (index, light) in (0u32..).zip(&lights.lights) {
        light_of[light.triangle as usize] = index;
    }
    for (triangle, light) in world.iter().zip(light_of) {
        let [a, b, c] = triangle.positions;
        // Zero normals mean: shade with the geometric normal.
        let [n0, n1, n2] = triangle.normals.unwrap_or([Vec3::ZERO; 3]);
        words.extend([
            word4(a, triangle.material),
            word4(b - a, light),
            word4(c - a, 0),
            word4(n0, 0),
            word4(n1, 0),
            word4(n2, 0),
        ]);
    }
}
