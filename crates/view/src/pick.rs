//! What is seen at a place of the film, on the host: asked for by a double click, not by rendering.

use glam::Vec3;
use midway_scene::{Bounds, Camera, Projection, Scene};
use rayon::prelude::*;

/// Triangles that a thread is given at least.
const PART: usize = 1 << 14;

/// The nearest point on the ray through a place of the film, from 0 to 1 right and down, lens left out. By all
/// cores: two million triangles take one of them about a tenth of a second.
pub fn pick(scene: &Scene, camera: &Camera, aspect: f32, place: [f32; 2]) -> Option<Vec3> {
    let (origin, direction) = ray(camera, aspect, place);
    let nearest = (0..scene.instances.len() as u32).into_par_iter().flat_map(|instance| {
        let placed = scene.placed(instance);
        let triangles = (0..placed.n_triangles()).into_par_iter().with_min_len(PART);
        triangles.filter_map(move |triangle| hit(placed.positions(triangle), origin, direction))
    });
    nearest.min_by(f32::total_cmp).map(|t| origin + direction * t)
}

/// Whether the ray through a place of the film passes a box.
pub fn passes(bounds: &Bounds, camera: &Camera, aspect: f32, place: [f32; 2]) -> bool {
    let (origin, direction) = ray(camera, aspect, place);
    let (mut entry, mut exit) = (0.0f32, f32::INFINITY);
    for axis in 0..3 {
        let [least, most] = [bounds.min, bounds.max].map(|corner| corner[axis] - origin[axis]);
        if direction[axis] == 0.0 {
            if least > 0.0 || most < 0.0 {
                return false;
            }
            continue; // between two sides that it never meets
        }
        let [a, b] = [least, most].map(|side| side / direction[axis]);
        (entry, exit) = (entry.max(a.min(b)), exit.min(a.max(b)));
    }
    !bounds.is_empty() && entry <= exit
}

/// Where the ray through a place of the film starts, and its unit direction.
fn ray(camera: &Camera, aspect: f32, [x, y]: [f32; 2]) -> (Vec3, Vec3) {
    let (right, up) = ((2.0 * x - 1.0) * aspect, 1.0 - 2.0 * y);
    let (origin, direction) = match camera.projection {
        Projection::Perspective { yfov } => {
            let half = (0.5 * yfov).tan();
            (Vec3::ZERO, Vec3::new(right * half, up * half, -1.0))
        }
        Projection::Orthographic { height } => (Vec3::new(right, up, 0.0) * (0.5 * height), Vec3::NEG_Z),
    };
    let origin = camera.world_from_camera.transform_point3(origin);
    (origin, camera.world_from_camera.transform_vector3(direction).normalize())
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
    use glam::Mat4;
    use midway_scene::{Instance, Mesh};

    use super::*;

    #[test]
    fn rays_pass_a_box_in_front_of_them() {
        let camera = |eye| Camera::look_at(eye, eye + Vec3::NEG_Z, Vec3::Y, 1.0).unwrap();
        let bounds = Bounds { min: Vec3::splat(-1.0), max: Vec3::ONE };
        for (eye, passed) in [
            (Vec3::new(0.0, 0.0, 5.0), true),
            (Vec3::ZERO, true),
            (Vec3::new(0.0, 0.0, -5.0), false),
            (Vec3::new(3.0, 0.0, 5.0), false),
            (Vec3::new(1.0, 1.0, 5.0), true),
            (Vec3::new(-1.0, -1.0, 5.0), true),
        ] {
            assert_eq!(passes(&bounds, &camera(eye), 1.0, [0.5; 2]), passed, "{eye}");
        }
    }

    #[test]
    fn the_nearest_is_picked() {
        let wall = |z: f32| Mesh {
            positions: [[-9.0, -9.0, z], [9.0, -9.0, z], [0.0, 9.0, z]].map(Vec3::from_array).to_vec(),
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let placed = |mesh| Instance { mesh, world_from_mesh: Mat4::IDENTITY, light_group: None };
        let scene = Scene {
            meshes: vec![wall(-5.0), wall(-2.0), wall(-7.0)],
            instances: vec![placed(0), placed(1), placed(2)],
            ..Scene::default()
        };
        let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0).unwrap();
        assert!((pick(&scene, &camera, 1.0, [0.5; 2]).unwrap() - Vec3::NEG_Z * 2.0).length() <= 1e-6);
        assert_eq!(pick(&scene, &camera, 100.0, [0.0, 0.5]), None);
    }

    #[test]
    fn a_triangle_is_hit_where_it_is() {
        let triangle = [Vec3::new(-1.0, -1.0, -2.0), Vec3::new(1.0, -1.0, -2.0), Vec3::new(0.0, 1.0, -2.0)];
        assert_eq!(hit(triangle, Vec3::ZERO, Vec3::NEG_Z), Some(2.0));
        assert_eq!(hit(triangle, Vec3::ZERO, Vec3::Z), None);
        assert_eq!(hit(triangle, Vec3::new(2.0, 0.0, 0.0), Vec3::NEG_Z), None);
        assert_eq!(hit([Vec3::ONE; 3], Vec3::ZERO, Vec3::ONE), None);
    }
}
