//! Scenes with known answers by cameras other than the pinhole.

use std::f64::consts::PI;

use glam::Vec3;
use midway_scene::{Camera, Projection, Scene};

use crate::{
    scenes::{Known, facing_squares},
    shapes::{Shape, add, camera, diffuse},
};

/// [`facing_squares`] with the receiver in focus: what is diffuse looks the same from all of the lens.
pub fn facing_squares_through_a_lens() -> Known {
    let mut known = facing_squares();
    known.name = "facing squares through a lens";
    focus(&mut known.scene.cameras[0], 0.15, 0.8);
    known
}

/// [`facing_squares`] by a film as large as the receiver.
pub fn facing_squares_by_parallel_rays() -> Known {
    let mut known = facing_squares();
    known.name = "facing squares by parallel rays";
    known.scene.cameras[0].projection = Projection::Orthographic { height: 1.0 };
    known
}

/// The same through a lens, in focus.
pub fn facing_squares_by_parallel_rays_through_a_lens() -> Known {
    let mut known = facing_squares_by_parallel_rays();
    known.name = "facing squares by parallel rays through a lens";
    focus(&mut known.scene.cameras[0], 0.15, 0.8);
    known
}

/// The edge of a lamp out of focus: at a film point whose sharp ray meets the lamp's plane at x, the
/// lens sees the part of its disk of confusion that lies beyond the edge.
pub fn blurred_edge() -> Known {
    const DISTANCE: f64 = 4.0;
    const HALF_WIDTH: f64 = 0.2; // at distance 1
    const LENS_RADIUS: f64 = 0.4;
    const FOCUS: f64 = 2.5;
    let emission = Vec3::new(1.0, 2.0, 4.0);
    let lamp = Shape::parallelogram(
        Vec3::new(0.0, -1.3, -DISTANCE as f32),
        Vec3::X * 1.3, // the film, and the disk of confusion on both sides
        Vec3::Y * 2.6,
    );
    let mut scene = Scene::default();
    add(&mut scene, lamp, diffuse(Vec3::ZERO, emission));
    scene.cameras.push(camera(Vec3::ZERO, -Vec3::Z, 2.0 * (HALF_WIDTH as f32).atan().to_degrees()));
    focus(&mut scene.cameras[0], LENS_RADIUS as f32, FOCUS as f32);
    let confusion = LENS_RADIUS * (DISTANCE / FOCUS - 1.0);
    Known::new("blurred edge", scene, true, move |x, _| {
        emission * share_of_disk(x * HALF_WIDTH * DISTANCE / confusion) as f32
    })
}

/// A lamp in focus behind the edge of a black screen out of focus: the lens is covered in part, and
/// what a splat is worth follows from the lens point that it is seen from.
pub fn half_covered_lens() -> Known {
    const SCREEN: f64 = 1.5;
    const FOCUS: f64 = 4.0;
    const HALF_WIDTH: f64 = 0.2; // at distance 1
    const LENS_RADIUS: f64 = 0.4;
    let emission = Vec3::new(4.0, 2.0, 1.0);
    let facing = |x: f32, width: f32, z: f64| {
        Shape::parallelogram(Vec3::new(x, -1.0, -z as f32), Vec3::X * width, Vec3::Y * 2.0)
    };
    let mut scene = Scene::default();
    add(&mut scene, facing(-1.0, 2.0, FOCUS), diffuse(Vec3::ZERO, emission));
    add(&mut scene, facing(-2.0, 2.0, SCREEN), diffuse(Vec3::ZERO, Vec3::ZERO));
    scene.cameras.push(camera(Vec3::ZERO, -Vec3::Z, 2.0 * (HALF_WIDTH as f32).atan().to_degrees()));
    focus(&mut scene.cameras[0], LENS_RADIUS as f32, FOCUS as f32);
    let confusion = LENS_RADIUS * (1.0 - SCREEN / FOCUS);
    Known::new("half covered lens", scene, true, move |x, _| {
        emission * share_of_disk(x * HALF_WIDTH * SCREEN / confusion) as f32
    })
}

/// The share of the unit disk to the left of t.
fn share_of_disk(t: f64) -> f64 {
    let t = t.clamp(-1.0, 1.0);
    0.5 + (t * (1.0 - t * t).sqrt() + t.asin()) / PI
}

/// A ball in a grey room under a wide lamp: its front is before the plane of focus, the wall behind.
pub fn ball_out_of_focus() -> Scene {
    let mut scene = Scene::default();
    let room = Shape::cuboid(-Vec3::ONE, Vec3::ONE).inside_out();
    let (ball, centre) = (Vec3::new(0.8, 0.6, 0.4), Vec3::new(0.0, -0.2, 0.0));
    let lamp = Shape::parallelogram(Vec3::new(-0.6, 0.9, -0.6), 1.2 * Vec3::X, 1.2 * Vec3::Z);
    add(&mut scene, room, diffuse(Vec3::splat(0.5), Vec3::ZERO));
    add(&mut scene, Shape::icosphere(2, centre, 0.6), diffuse(ball, Vec3::ZERO));
    add(&mut scene, lamp, diffuse(Vec3::ZERO, Vec3::splat(4.0)));
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, 0.95), centre, 80.0));
    focus(&mut scene.cameras[0], 0.08, 0.7);
    scene
}

/// The same by parallel rays.
pub fn ball_by_parallel_rays() -> Scene {
    let mut scene = ball_out_of_focus();
    scene.cameras[0].projection = Projection::Orthographic { height: 1.7 };
    scene
}

fn focus(camera: &mut Camera, lens_radius: f32, distance: f32) {
    camera.lens_radius = lens_radius;
    camera.focus_distance = distance;
}
