//! Scenes at the edge of what makes sense: they render to the end, nothing is rejected, and what
//! has a known answer has it.

use glam::{Mat3, Mat4, Vec3};
use midway_film::Image;
use midway_render::{Integrator, LightSampling, RenderSettings};
use midway_scene::{Environment, Light, LightKind, Scene, SpotFalloff};
use midway_tests::{
    estimate::{Agreement, Blocks, cpu, render},
    integrators::{self, Case},
    scenes,
    shapes::{Shape, add, camera, diffuse, glass, mirror},
};

use crate::support::{Report, estimate, in_turn, settings};

/// Pixels along both sides.
const SIZE: usize = 16;

/// Renders by every integrator; `holds` says whether an image is as it should be.
fn renders(scene: &Scene, holds: impl Fn(&Image) -> bool) {
    renders_by(integrators::all(), scene, holds);
}

/// By all that see lights which cannot be hit.
fn renders_where_lit(scene: &Scene, holds: impl Fn(&Image) -> bool) {
    let mut cases = integrators::all();
    cases.retain(|case| case.settings.integrator != Integrator::PathNaive);
    renders_by(cases, scene, holds);
}

fn renders_by(cases: Vec<Case>, scene: &Scene, holds: impl Fn(&Image) -> bool) {
    let _turn = in_turn();
    let mut report = Report::default();
    // The few lights that there are by a tree too, from one end and from both.
    let by_tree = [integrators::path(), integrators::full()].map(|case| (case, LightSampling::Tree));
    for (case, light_sampling) in cases.into_iter().map(|case| (case, LightSampling::Auto)).chain(by_tree) {
        let settings = RenderSettings { light_sampling, ..settings(SIZE, case.settings, 3) };
        let image = render(&cpu(), scene, &settings, 4);
        let finite = image.pixels.as_flattened().iter().all(|value| value.is_finite() && *value >= 0.0);
        report.note(&format!("{} {light_sampling:?}", case.name()), finite && holds(&image));
    }
    report.finish();
}

/// A room, its ceiling a lamp of this emission, and a camera in it.
fn room(emission: Vec3) -> Scene {
    let (lamp, walls) = Shape::cuboid(-Vec3::ONE, Vec3::ONE).inside_out().split(|triangle| triangle / 2 == 3);
    let mut scene = Scene::default();
    add(&mut scene, walls, diffuse(Vec3::splat(0.5), Vec3::ZERO));
    add(&mut scene, lamp, diffuse(Vec3::splat(0.5), emission));
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, 0.9), Vec3::ZERO, 60.0));
    scene
}

fn is_lit(image: &Image) -> bool {
    !image.is_black()
}

#[test]
fn a_room_without_light_is_black() {
    renders(&room(Vec3::ZERO), Image::is_black);
}

#[test]
fn a_lamp_of_no_area_is_no_lamp() {
    let mut scene = room(Vec3::ZERO);
    let line = Shape::parallelogram(Vec3::ZERO, Vec3::X, Vec3::X);
    add(&mut scene, line, diffuse(Vec3::ZERO, Vec3::ONE));
    renders(&scene, Image::is_black);
}

#[test]
fn a_lamp_too_weak_to_be_chosen_renders() {
    let mut scene = room(Vec3::ONE);
    let lamp = Shape::parallelogram(Vec3::new(-0.5, -0.9, -0.5), Vec3::Z, Vec3::X * 1e-3);
    add(&mut scene, lamp, diffuse(Vec3::splat(0.5), Vec3::splat(1e-36)));
    renders(&scene, is_lit);
}

fn with_lights(mut scene: Scene, kinds: &[LightKind]) -> Scene {
    scene.lights.extend(kinds.iter().map(|&kind| Light { name: String::new(), kind, group: None }));
    scene
}

fn spot(inner_angle: f32, outer_angle: f32, falloff: SpotFalloff) -> LightKind {
    let (position, direction) = (Vec3::new(0.0, 0.9, 0.0), Vec3::NEG_Y);
    LightKind::Spot { position, direction, intensity: Vec3::ONE, inner_angle, outer_angle, falloff }
}

#[test]
fn lights_of_no_intensity_are_black() {
    let dark = [
        LightKind::Point { position: Vec3::ZERO, intensity: Vec3::ZERO },
        LightKind::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::ZERO },
    ];
    let mut scene = with_lights(room(Vec3::ZERO), &dark);
    let radiance = Vec3::ZERO;
    scene.environment = Some(Environment { radiance, image: None, world_from_environment: Mat3::IDENTITY });
    renders(&scene, Image::is_black);
}

/// Cones that f32 can hardly tell apart, without a core, of all directions, and a lamp in a wall.
#[test]
fn odd_spots_and_point_lights_render() {
    let mut kinds = vec![LightKind::Point { position: Vec3::new(0.2, 1.0, 0.1), intensity: Vec3::ONE }];
    for falloff in [SpotFalloff::CosineSquared, SpotFalloff::Smoothstep, SpotFalloff::Angle] {
        kinds.extend([
            spot(0.0, 1e-4, falloff),
            spot(0.0, std::f32::consts::PI, falloff),
            spot(0.5, 0.500_000_06, falloff),
        ]);
    }
    renders_where_lit(&with_lights(room(Vec3::ZERO), &kinds), is_lit);
}

#[test]
fn one_triangle_in_an_environment_renders() {
    let mut scene = Scene::default();
    let triangle =
        Shape { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], normals: vec![], triangles: vec![[0, 1, 2]] };
    add(&mut scene, triangle, diffuse(Vec3::splat(0.5), Vec3::ZERO));
    let radiance = Vec3::ONE;
    scene.environment = Some(Environment { radiance, image: None, world_from_environment: Mat3::IDENTITY });
    // Far outside the sphere that light from infinity is aimed at.
    scene.cameras.push(camera(Vec3::new(0.3, 0.3, 20.0), Vec3::new(0.3, 0.3, 0.0), 5.0));
    renders(&scene, is_lit);
}

#[test]
fn triangles_of_no_area_render() {
    let mut scene = room(Vec3::ONE);
    let point = Shape { positions: vec![Vec3::ZERO; 3], normals: vec![], triangles: vec![[0, 1, 2]] };
    add(&mut scene, point, glass(1.5));
    add(&mut scene, Shape::parallelogram(Vec3::ZERO, Vec3::Y, Vec3::Y), mirror(1.0));
    renders(&scene, is_lit);
}

#[test]
fn glass_of_index_1_and_things_that_coincide_render() {
    let mut scene = room(Vec3::ONE);
    add(&mut scene, Shape::icosphere(2, Vec3::ZERO, 0.4).smooth(Vec3::ZERO), glass(1.0));
    add(&mut scene, Shape::icosphere(2, Vec3::ZERO, 0.4), glass(1.5));
    // A wall upon a wall.
    add(&mut scene, Shape::parallelogram(-Vec3::ONE, Vec3::Z, Vec3::X), diffuse(Vec3::ONE, Vec3::ZERO));
    renders(&scene, is_lit);
}

#[test]
fn a_camera_between_mirrors_that_keep_all_light_renders_to_the_end() {
    let walls = Shape::cuboid(-Vec3::ONE, Vec3::ONE).inside_out();
    let mut scene = Scene::default();
    add(&mut scene, walls, mirror(1.0));
    add(&mut scene, Shape::icosphere(0, Vec3::ZERO, 0.1), diffuse(Vec3::ONE, Vec3::ONE));
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, 0.9), Vec3::ZERO, 60.0));
    renders(&scene, is_lit);
}

#[test]
fn light_into_the_void_leaves_an_empty_pool() {
    let mut scene = Scene::default();
    let lamp = Shape::parallelogram(Vec3::new(-0.5, -0.5, 0.0), Vec3::X, Vec3::Y);
    add(&mut scene, lamp, diffuse(Vec3::splat(0.5), Vec3::ONE));
    scene.cameras.push(camera(Vec3::Z, Vec3::ZERO, 20.0));
    // The lamp fills the film: it emits 1 and there is nothing to reflect.
    renders(&scene, |image| image.mean().iter().all(|mean| (mean - 1.0).abs() <= 0.5));
}

#[test]
fn a_camera_that_sees_nothing_renders_black() {
    let mut scene = Scene::default();
    let lamp = Shape::parallelogram(Vec3::new(-0.5, -0.5, 0.0), Vec3::X, Vec3::Y);
    add(&mut scene, lamp, diffuse(Vec3::splat(0.5), Vec3::ONE));
    scene.cameras.push(camera(Vec3::Z, Vec3::Z * 2.0, 20.0));
    renders(&scene, Image::is_black);
}

/// Fronts stay fronts, and glass has its inside inside.
#[test]
fn a_mirrored_furnace_is_as_white() {
    let _turn = in_turn();
    let mut known = scenes::specular_furnace();
    for (index, instance) in known.scene.instances.iter_mut().enumerate() {
        let mirrored = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
        let all = Mat4::from_scale(Vec3::splat(-1.0)) * Mat4::from_rotation_x(std::f32::consts::PI);
        instance.world_from_mesh = if index % 2 == 0 { mirrored } else { all };
    }
    let in_use = vec![true; scenes::SIZE * scenes::SIZE];
    let expected = Blocks::of_expected(&known.expected, &in_use);
    let mut report = Report::default();
    for case in [integrators::path(), integrators::full()] {
        let images = estimate(&cpu(), &known.scene, scenes::SIZE, &case, 192);
        let agreement = Agreement::of(&Blocks::of_batches(&images, &in_use), &expected);
        report.check(&case.name(), &agreement, Some(0.01));
    }
    report.finish();
}
