//! What is seen at a place of the film, on the host: asked for by a double click, not by rendering.

use glam::Vec3;
use midway_scene::{Camera, Projection, Scene};

/// The nearest point on the ray through a place of the film, from 0 to 1 right and down, lens left out.
pub fn pick(scene: &Scene, camera: &Camera, aspect: f32, [x, y]: [f32; 2]) -> Option<Vec3> {
    let (right, up) = ((2.0 * x - 1.0) * aspect, 1.0 - 2.0 * y);
    let (origin, direction) = match camera.projection {
        Projection::Perspective { yfov } => {
            let half = (0.5 * yfov).tan();
            (Vec3::ZERO, Vec3::new(right * half, up * half, -1.0))
        }
        Projection::Orthographic { height } => (Vec3::new(right, up, 0.0) * (0.5 * height), Vec3::NEG_Z),
    };
    let origin = camera.world_from_camera.transform_point3(origin);
    let direction = camera.world_from_camera.transform_vector3(direction).normalize();
    let mut nearest = f32::INFINITY;
    for instance in 0..scene.instances.len() as u32 {
        let placed = scene.placed(instance);
        for triangle in 0..placed.n_triangles() {
            nearest = hit(placed.positions(triangle), origin, direction).map_or(nearest, |t| t.min(nearest));
        }
    }
    nearest.is_finite().then(|| origin + direction * nearest)
}

/// More triangles than this are not asked one by one unless somebody waits for the answer.
const FEW: usize = 2_000_000;

/// What a camera is to be turned about: what it sees in its middle, or the place nearest to the scene's
/// middle on its way there; in front of it in any case.
pub fn middle(scene: &Scene, camera: &Camera) -> Vec3 {
    let seen = (scene.counts().triangles <= FEW).then(|| pick(scene, camera, 1.0, [0.5; 2])).flatten();
    let (eye, bounds) = (camera.position(), scene.bounds());
    let forward = camera.world_from_camera.transform_vector3(Vec3::NEG_Z).normalize();
    let size = if bounds.is_empty() { 1.0 } else { bounds.diagonal().length() };
    let along = if bounds.is_empty() { size } else { (bounds.centre() - eye).dot(forward) };
    seen.unwrap_or(eye + forward * along.max(size * 1e-2).max(f32::MIN_POSITIVE))
}

/// Where a ray meets a triangle (Möller and Trumbore 1997).
fn hit([a, b, c]: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<f32> {
    let (u_edge, v_edge) = (b - a, c - a);
    let p = direction.cross(v_edge);
    let determinant = u_edge.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let from = origin - a;
    let u = from.dot(p) / determinant;
    let q = from.cross(u_edge);
    let v = direction.dot(q) / determinant;
    let t = v_edge.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_is_hit_where_it_is() {
        let triangle = [Vec3::new(-1.0, -1.0, -2.0), Vec3::new(1.0, -1.0, -2.0), Vec3::new(0.0, 1.0, -2.0)];
        assert_eq!(hit(triangle, Vec3::ZERO, Vec3::NEG_Z), Some(2.0));
        assert_eq!(hit(triangle, Vec3::ZERO, Vec3::Z), None);
        assert_eq!(hit(triangle, Vec3::new(2.0, 0.0, 0.0), Vec3::NEG_Z), None);
        assert_eq!(hit([Vec3::ONE; 3], Vec3::ZERO, Vec3::ONE), None);
    }
}
