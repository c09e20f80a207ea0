//! Cameras of every kind: rays against their density, and back onto the film.

use glam::DVec3;
use midway_kernels::native::lib::{self, Camera};
use wgsl_cpu::runtime::{Vec2, Vec3};

use crate::{
    chi_square::{Cap, ChiSquare, histogram2},
    support::{Random, assert_near, double, single},
};

const N: u64 = 400_000;
const HALF: [f64; 2] = [0.9, 0.54];

/// 40 by 24 pixels, looking along `forward`; focused at 2.5.
fn camera(forward: DVec3, lens_radius: f32, parallel: bool) -> Camera {
    let right = forward.any_orthonormal_vector();
    let (width, height) = (40.0, 24.0);
    Camera {
        origin: Vec3::new(1.0, 2.0, 3.0),
        pixel_area: (4.0 * HALF[0] * HALF[1]) as f32 / (width * height),
        right: single(right),
        half_width: HALF[0] as f32,
        up: single(right.cross(forward)),
        half_height: HALF[1] as f32,
        forward: single(forward),
        width,
        height,
        lens_radius,
        inverse_focus: 0.4,
        parallel: u32::from(parallel),
    }
}

/// Pinhole, thin lens, parallel rays, and these with a lens.
fn kinds(forward: DVec3) -> [Camera; 4] {
    [(0.0, false), (0.3, false), (0.0, true), (0.3, true)].map(|(lens, kind)| camera(forward, lens, kind))
}

#[test]
fn pinhole_directions_have_their_density() {
    let mut random = Random::new(9);
    for _ in 0..3 {
        let camera = camera(random.direction(), 0.0, false);
        let n_pixels = f64::from(camera.width * camera.height);
        let cos_corner = 1.0 / (1.0 + HALF[0].powi(2) + HALF[1].powi(2)).sqrt();
        let cap = Cap::new(double(camera.forward).normalize(), cos_corner * 0.999);
        let mut sample = || {
            let film = random.unit2() * Vec2::new(camera.width, camera.height);
            Some(double(lib::camera_ray(camera, film, Vec3::splat(0.0)).direction))
        };
        let pdf = |d: DVec3| {
            let at = double(camera.origin) + d;
            let film = lib::camera_project(camera, single(at), Vec3::splat(0.0));
            let inside = film.z > 0.0
                && (0.0..camera.width).contains(&film.x)
                && (0.0..camera.height).contains(&film.y);
            if inside { f64::from(lib::camera_pdf(camera, film.z)) / n_pixels } else { 0.0 }
        };
        cap.test(N, &mut sample, pdf).assert_holds("camera_ray of a pinhole");
        let no_cosines = |d: DVec3| if pdf(d) > 0.0 { 1.0 / (4.0 * HALF[0] * HALF[1]) } else { 0.0 };
        let flat = cap.test(N, &mut sample, |d| no_cosines(d) * 0.99);
        flat.assert_rejects("a density without its cosines");
    }
}

/// Where rays of neighbouring film points meet a tilted plane, a pixel's area there is 1 over the
/// density.
#[test]
fn the_density_is_one_film_point_a_pixel() {
    const STEP: f32 = 0.25; // pixels: a differential to some 1e-4, and 1e-5 of rounding
    let mut random = Random::new(11);
    for _ in 0..500 {
        for camera in kinds(random.direction()) {
            let film = random.unit2() * Vec2::new(camera.width, camera.height);
            let lens = lib::sample_lens(camera, random.unit2());
            let ray = lib::camera_ray(camera, film, lens);
            let (start, direction) = (double(ray.origin), double(ray.direction));
            let distance = random.between(0.5, 6.0);
            let (z_1, normal) = (start + distance * direction, random.direction());
            let cosine = normal.dot(direction).abs();
            if cosine < 0.3 {
                continue;
            }
            let meet = |x: f32, y: f32| {
                let ray = lib::camera_ray(camera, Vec2::new(film.x + x, film.y + y), lens);
                let (start, direction) = (double(ray.origin), double(ray.direction));
                start + direction * ((z_1 - start).dot(normal) / direction.dot(normal))
            };
            let along_x = (meet(STEP, 0.0) - meet(-STEP, 0.0)) / (2.0 * f64::from(STEP));
            let along_y = (meet(0.0, STEP) - meet(0.0, -STEP)) / (2.0 * f64::from(STEP));
            let cos_forward = direction.dot(double(camera.forward)) as f32;
            let across = lib::camera_pdf_across(camera, cos_forward, (distance * distance) as f32);
            let density = f64::from(across) * cosine;
            assert_near(density * along_x.cross(along_y).length(), 1.0, 3e-3, "density times area");
            assert_near(f64::from(ray.pdf), f64::from(lib::camera_pdf(camera, cos_forward)), 1e-2, "pdf");
        }
    }
}

#[test]
fn points_on_a_ray_are_projected_back() {
    let mut random = Random::new(10);
    for _ in 0..2000 {
        for camera in kinds(random.direction()) {
            let film = random.unit2() * Vec2::new(camera.width, camera.height);
            let lens = lib::sample_lens(camera, random.unit2());
            let ray = lib::camera_ray(camera, film, lens);
            let (start, direction) = (double(ray.origin), double(ray.direction));
            let distance = random.between(0.5, 6.0);
            let back = lib::camera_project(camera, single(start + distance * direction), lens);
            assert_near(f64::from(back.x), f64::from(film.x), 5e-4, "film x");
            assert_near(f64::from(back.y), f64::from(film.y), 5e-4, "film y");
            let depth = distance * direction.dot(double(camera.forward));
            assert_near(f64::from(back.z), depth, 5e-6, "depth");
            let again = lib::camera_start(camera, Vec2::new(back.x, back.y), lens);
            assert_near(double(again).distance(start), 0.0, 5e-5, "the ray's start");
            let behind = lib::camera_project(camera, single(start - direction), lens);
            assert_eq!(behind.z, 0.0, "behind the camera");
        }
    }
}

#[test]
fn rays_of_a_film_point_meet_in_the_plane_of_focus() {
    let mut random = Random::new(12);
    for camera in kinds(random.direction()) {
        let film = random.unit2() * Vec2::new(camera.width, camera.height);
        let at_focus = |lens| {
            let ray = lib::camera_ray(camera, film, lens);
            let direction = double(ray.direction);
            let cosine = direction.dot(double(camera.forward));
            double(ray.origin) + direction * (1.0 / (f64::from(camera.inverse_focus) * cosine))
        };
        let sharp = at_focus(Vec3::splat(0.0));
        for _ in 0..100 {
            let lens = lib::sample_lens(camera, random.unit2());
            assert_near(at_focus(lens).distance(sharp), 0.0, 5e-6, "distance from the point in focus");
        }
    }
}

#[test]
fn lens_points_are_uniform_in_area_and_across_the_view() {
    let mut random = Random::new(13);
    let camera = camera(random.direction(), 0.3, false);
    let polar = (0..N).map(|_| {
        let p = double(lib::sample_lens(camera, random.unit2()));
        assert_near(p.dot(double(camera.forward)), 0.0, 1e-6, "along the view");
        let (x, y) = (p.dot(double(camera.right)), p.dot(double(camera.up)));
        let angle = y.atan2(x) / std::f64::consts::TAU;
        let share = p.length_squared() / 0.09;
        ((share as f32).min(0.999_999), ((angle - angle.floor()) as f32).min(0.999_999))
    });
    ChiSquare::uniform(&histogram2(30, polar)).assert_holds("sample_lens");
}
