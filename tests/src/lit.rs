//! Scenes with known answers that are lit from points, from one direction, or from all around.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3, Mat3, Vec3};
use midway_scene::{
    Environment, Image, Light, LightKind, Roughness, Scene, Sides, SpotFalloff, Surface, Texels,
};

use crate::{
    scenes::Known,
    shapes::{Shape, add, camera, diffuse, glass, mirror},
};

/// All of them.
pub fn all() -> Vec<Known> {
    let mut all = vec![
        point(),
        directional(),
        constant_environment(),
        sky(),
        sky_in_a_mirror(),
        environment_furnace(),
        point_in_absorbing_glass(),
    ];
    all.extend(FALLOFFS.map(spot));
    all
}

/// Albedo of the floors.
const ALBEDO: Vec3 = Vec3::new(0.9, 0.5, 0.3);
/// Half the side of what the camera sees of a floor.
const HALF: f64 = 0.5;
/// Where lights hang above it.
const LAMP: DVec3 = DVec3::new(0.2, -0.1, 0.6);

/// A floor at z = 0 that fills the film, seen from above.
fn floor() -> Scene {
    let mut scene = Scene::default();
    let square = Shape::parallelogram(Vec3::new(-0.75, -0.75, 0.0), 1.5 * Vec3::X, 1.5 * Vec3::Y);
    add(&mut scene, square, diffuse(ALBEDO, Vec3::ZERO));
    let fov = 2.0 * (HALF as f32 / 0.8).atan().to_degrees();
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, 0.8), Vec3::ZERO, fov));
    scene
}

fn lit_by(mut scene: Scene, kind: LightKind) -> Scene {
    scene.lights.push(Light { name: String::new(), kind, group: None });
    scene
}

fn unseen_by_naive(known: Known) -> Known {
    Known { naive_sees: false, ..known }
}

/// From the floor to the lamp: cos / d², by a place on the film.
fn falls_on_floor(x: f64, y: f64) -> (DVec3, f64) {
    let to_lamp = LAMP - DVec3::new(x * HALF, y * HALF, 0.0);
    (to_lamp, to_lamp.z / to_lamp.length().powi(3))
}

/// A point light: radiance is ρ / π I cos / d².
pub fn point() -> Known {
    let intensity = Vec3::new(1.0, 2.0, 4.0);
    let scene = lit_by(floor(), LightKind::Point { position: LAMP.as_vec3(), intensity });
    unseen_by_naive(Known::new("point light", scene, true, move |x, y| {
        ALBEDO * intensity * (falls_on_floor(x, y).1 / PI) as f32
    }))
}

/// Every falloff of spots.
pub const FALLOFFS: [SpotFalloff; 3] =
    [SpotFalloff::CosineSquared, SpotFalloff::Smoothstep, SpotFalloff::Angle];

/// A spot aslant, both its cones in view: as a point light, times its falloff.
pub fn spot(falloff: SpotFalloff) -> Known {
    let (inner, outer) = (0.25f64, 0.8f64);
    let intensity = Vec3::new(3.0, 2.0, 1.0);
    let axis = DVec3::new(-0.3, 0.2, -1.0).normalize();
    let kind = LightKind::Spot {
        position: LAMP.as_vec3(),
        direction: axis.as_vec3(),
        intensity,
        inner_angle: inner as f32,
        outer_angle: outer as f32,
        falloff,
    };
    let name = match falloff {
        SpotFalloff::CosineSquared => "spot, cosine squared",
        SpotFalloff::Smoothstep => "spot, smoothstep",
        SpotFalloff::Angle => "spot, angle",
    };
    unseen_by_naive(Known::new(name, lit_by(floor(), kind), true, move |x, y| {
        let (to_lamp, arrives) = falls_on_floor(x, y);
        let angle = axis.angle_between(-to_lamp);
        let cosines = (angle.cos() - outer.cos()) / (inner.cos() - outer.cos());
        let place = cosines.clamp(0.0, 1.0);
        let share = match falloff {
            SpotFalloff::CosineSquared => place.powi(2),
            SpotFalloff::Smoothstep => place.powi(2) * (3.0 - 2.0 * place),
            SpotFalloff::Angle => ((outer - angle) / (outer - inner)).clamp(0.0, 1.0),
        };
        ALBEDO * intensity * (arrives * share / PI) as f32
    }))
}

/// Parallel light: radiance is ρ / π E cos.
pub fn directional() -> Known {
    let irradiance = Vec3::new(1.0, 2.0, 3.0);
    let direction = Vec3::new(0.6, 0.0, -0.8);
    let scene = lit_by(floor(), LightKind::Directional { direction, irradiance });
    unseen_by_naive(Known::new("directional light", scene, true, move |_, _| {
        ALBEDO * irradiance * (0.8 / PI) as f32
    }))
}

fn constant(radiance: Vec3) -> Environment {
    Environment { radiance, image: None, world_from_environment: Mat3::IDENTITY }
}

/// The same radiance from all around: an unoccluded floor has ρ L.
pub fn constant_environment() -> Known {
    let radiance = Vec3::new(0.5, 1.0, 2.0);
    let mut scene = floor();
    scene.environment = Some(constant(radiance));
    Known::new("constant environment", scene, true, move |_, _| ALBEDO * radiance)
}

/// The same under a point light too: of two lights, one near and one at infinity, either is the likelier
/// by place.
pub fn point_and_environment() -> Known {
    let (radiance, intensity) = (Vec3::new(0.5, 1.0, 2.0), Vec3::new(1.0, 2.0, 4.0));
    let mut scene = lit_by(floor(), LightKind::Point { position: LAMP.as_vec3(), intensity });
    scene.environment = Some(constant(radiance));
    unseen_by_naive(Known::new("point light and environment", scene, true, move |x, y| {
        ALBEDO * (radiance + intensity * (falls_on_floor(x, y).1 / PI) as f32)
    }))
}

/// Columns and rows of [`sky_image`].
pub const SKY: [usize; 2] = [8, 5];

/// A small sky: dark below, brighter above, and a sun in one texel.
fn sky_image() -> Image {
    let texels: Vec<[f32; 4]> = (0..SKY[0] * SKY[1])
        .map(|i| {
            let (column, row) = ((i % SKY[0]) as f32, (i / SKY[0]) as f32);
            let sun = if i == 2 + SKY[0] { 40.0 } else { 0.0 };
            [0.1 * column + sun, 0.2 * (5.0 - row) + sun, if row < 2.0 { 1.0 } else { 0.0 } + 0.5 * sun, 1.0]
        })
        .collect();
    let [width, height] = SKY.map(|n| n as u32);
    Image { name: "sky".to_owned(), width, height, texels: Texels::Float(texels.into()) }
}

/// What multiplies the sky's image.
const SKY_RADIANCE: Vec3 = Vec3::new(0.7, 0.9, 1.1);

/// The image's +y is turned to about +z, and a little more.
fn sky_frame() -> Mat3 {
    Mat3::from_rotation_x(1.3) * Mat3::from_rotation_y(0.7)
}

pub(crate) fn add_sky(scene: &mut Scene) {
    scene.images.push(sky_image());
    scene.environment =
        Some(Environment { radiance: SKY_RADIANCE, image: Some(0), world_from_environment: sky_frame() });
}

/// The sky of [`sky`], in f64.
pub struct Sky {
    texels: Texels,
    /// Turns the world's directions into the image's.
    pub environment_from_world: DMat3,
}

impl Default for Sky {
    fn default() -> Self {
        Self { texels: sky_image().texels, environment_from_world: sky_frame().as_dmat3().transpose() }
    }
}

impl Sky {
    /// Radiance from a direction of the world: latitude and longitude to a place among texels'
    /// centres, and a bilinear blend of the four about it.
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        let d = self.environment_from_world * direction;
        let u = 0.5 + d.x.atan2(-d.z) / TAU;
        let v = d.y.clamp(-1.0, 1.0).acos() / PI;
        let (x, y) = (u * SKY[0] as f64 - 0.5, v * SKY[1] as f64 - 0.5);
        let texel = |column: f64, row: f64| {
            let column = column.rem_euclid(SKY[0] as f64) as usize;
            let row = row.clamp(0.0, SKY[1] as f64 - 1.0) as usize;
            DVec3::from_slice(&self.texels.linear(row * SKY[0] + column).map(f64::from)[..3])
        };
        let (left, upper) = (x.floor(), y.floor());
        let row = |row: f64| texel(left, row).lerp(texel(left + 1.0, row), x - left);
        row(upper).lerp(row(upper + 1.0), y - upper) * SKY_RADIANCE.as_dvec3()
    }
}

/// An image of a sky, turned: an unoccluded floor has ρ / π times its irradiance, by midpoints.
pub fn sky() -> Known {
    const STEPS: u32 = 800;
    let mut scene = floor();
    add_sky(&mut scene);
    let sky = Sky::default();
    let mut irradiance = DVec3::ZERO;
    for i in 0..STEPS {
        // Midpoints of cos² and of longitude: each cell has π / n of projected solid angle.
        let sin2 = (f64::from(i) + 0.5) / f64::from(STEPS);
        for j in 0..STEPS {
            let phi = TAU * (f64::from(j) + 0.5) / f64::from(STEPS);
            let direction = DVec3::new(sin2.sqrt() * phi.cos(), sin2.sqrt() * phi.sin(), (1.0 - sin2).sqrt());
            irradiance += sky.radiance(direction);
        }
    }
    irradiance *= PI / f64::from(STEPS * STEPS);
    Known::new("sky", scene, true, move |_, _| ALBEDO * (irradiance / PI).as_vec3())
}

/// A sky behind a mirror that takes the middle half of the film.
pub fn sky_in_a_mirror() -> Known {
    const HEIGHT: f64 = 0.8;
    let mut scene = Scene::default();
    let square = Shape::parallelogram(Vec3::new(-0.25, -0.25, 0.0), 0.5 * Vec3::X, 0.5 * Vec3::Y);
    add(&mut scene, square, mirror(1.0));
    add_sky(&mut scene);
    let fov = 2.0 * (HALF / HEIGHT).atan().to_degrees() as f32;
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, HEIGHT as f32), Vec3::ZERO, fov));
    let sky = Sky::default();
    Known::new("sky in a mirror", scene, false, move |x, y| {
        let in_mirror = x.abs() < 0.5 && y.abs() < 0.5;
        let z = if in_mirror { HEIGHT } else { -HEIGHT };
        let direction = DVec3::new(x * HALF, y * HALF, z).normalize();
        sky.radiance(direction).as_vec3()
    })
}

/// Things that keep all light in an environment of radiance 1: radiance is 1 everywhere.
pub fn environment_furnace() -> Known {
    let mut scene = Scene::default();
    let white = diffuse(Vec3::ONE, Vec3::ZERO);
    let ground = Shape::parallelogram(Vec3::new(-1.0, -0.7, -1.0), 4.0 * Vec3::Z, 2.0 * Vec3::X);
    add(&mut scene, ground, white.clone());
    add(&mut scene, Shape::icosphere(1, Vec3::new(0.1, -0.2, 0.0), 0.5), white);
    // Behind the camera: a block of which they take a few pixels has hardly any variance, but for the
    // rare paths that roulette ends.
    add(&mut scene, Shape::icosphere(2, Vec3::new(0.5, -0.3, 2.5), 0.35), glass(1.5));
    add(&mut scene, Shape::icosphere(2, Vec3::new(-0.4, -0.3, 2.6), 0.35), mirror(1.0));
    scene.environment = Some(constant(Vec3::ONE));
    scene.cameras.push(camera(Vec3::new(0.0, 0.2, 2.0), Vec3::ZERO, 60.0));
    Known::new("furnace of the environment", scene, false, |_, _| Vec3::ONE)
}

/// A lamp and a floor at the bottom of a block of glass that absorbs; the camera is in it too. The
/// glass does not bend what stays within it, and its walls are so far away that what they send back
/// is absorbed (e⁻³⁰).
pub fn point_in_absorbing_glass() -> Known {
    const ABSORPTION: DVec3 = DVec3::new(1.0, 0.5, 2.0);
    let intensity = Vec3::new(1.0, 2.0, 4.0);
    let mut scene = lit_by(floor(), LightKind::Point { position: LAMP.as_vec3(), intensity });
    let mut block = glass(1.5);
    let Surface::Dielectric { sigma_a, .. } = &mut block.surface else { unreachable!("glass is one") };
    *sigma_a = ABSORPTION.as_vec3();
    add(&mut scene, Shape::cuboid(Vec3::splat(-30.0), Vec3::splat(30.0)), block);
    unseen_by_naive(Known::new("point light in absorbing glass", scene, true, move |x, y| {
        let (to_lamp, arrives) = falls_on_floor(x, y);
        let to_camera = DVec3::new(x * HALF, y * HALF, 0.8);
        let length = to_lamp.length() + to_camera.length();
        let transmitted = (ABSORPTION * -length).exp().as_vec3();
        ALBEDO * intensity * transmitted * (arrives / PI) as f32
    }))
}

/// A grey room with a window, and all lights at once: a lamp, a point light, a spot, the sun through
/// the window, and a sky. The window is not in view.
pub fn room_with_all_lights() -> Scene {
    let mut scene = Scene::default();
    let grey = diffuse(Vec3::new(0.6, 0.5, 0.4), Vec3::ZERO);
    // Walls in the order -x, +x, -y, +y, -z, +z: the one at +x has a window in its upper half.
    let (wall, rest) = Shape::cuboid(-Vec3::ONE, Vec3::ONE).inside_out().split(|triangle| triangle / 2 == 1);
    drop(wall);
    add(&mut scene, rest, grey.clone());
    add(&mut scene, Shape::parallelogram(Vec3::new(1.0, -1.0, -1.0), 2.0 * Vec3::Z, Vec3::Y), grey);
    let lamp = Shape::parallelogram(Vec3::new(-0.7, 0.9, -0.6), 0.4 * Vec3::X, 0.4 * Vec3::Z);
    add(&mut scene, lamp, diffuse(Vec3::ZERO, Vec3::splat(4.0)));
    add(
        &mut scene,
        Shape::icosphere(1, Vec3::new(-0.3, -0.6, -0.4), 0.35),
        diffuse(Vec3::splat(0.7), Vec3::ZERO),
    );
    let lights = [
        LightKind::Point { position: Vec3::new(0.5, 0.2, -0.3), intensity: Vec3::new(0.1, 0.2, 0.3) },
        LightKind::Spot {
            position: Vec3::new(-0.2, 0.8, 0.4),
            direction: Vec3::new(0.0, -0.8, -0.6),
            intensity: Vec3::new(0.8, 0.6, 0.4),
            inner_angle: 0.2,
            outer_angle: 0.6,
            falloff: SpotFalloff::CosineSquared,
        },
        LightKind::Directional { direction: Vec3::new(-0.8, -0.6, 0.0), irradiance: Vec3::splat(1.0) },
    ];
    scene.lights.extend(lights.map(|kind| Light { name: String::new(), kind, group: None }));
    add_sky(&mut scene);
    scene.cameras.push(camera(Vec3::new(0.7, 0.1, 0.9), Vec3::new(-0.6, -0.2, -0.6), 60.0));
    scene
}

/// That room with 60 small lights more, of every kind that is somewhere, turned every way.
pub fn room_with_many_lights() -> Scene {
    let mut scene = room_with_all_lights();
    // One is there already; the other transmits, so that lights shine on both its sides.
    let balls = [Vec3::new(-0.3, -0.6, -0.4), Vec3::new(0.45, -0.7, -0.5)];
    let mut rough_glass = glass(1.5);
    if let Surface::Dielectric { roughness, .. } = &mut rough_glass.surface {
        *roughness = Roughness::alpha(0.5);
    }
    add(&mut scene, Shape::icosphere(2, balls[1], 0.25), rough_glass);
    let is_free = |place: &Vec3| balls.iter().all(|ball| place.distance(*ball) > 0.5);
    let mut places = (1..).map(spread).map(|u| 1.6 * u - 0.8).filter(is_free);
    for (i, place) in places.by_ref().take(60).enumerate() {
        let direction = (2.0 * spread(1000 + i) - 1.0).normalize();
        let along = 0.25 * direction.any_orthonormal_vector();
        let triangle =
            Shape::parallelogram(place, along, direction.cross(along)).split(|triangle| triangle == 0).0;
        let mut both_sides = diffuse(Vec3::ZERO, Vec3::new(0.8, 0.5, 0.6));
        both_sides.emits = Sides::Both;
        match i % 5 {
            0 => add(&mut scene, triangle, diffuse(Vec3::ZERO, Vec3::splat(1.2))),
            1 => add(&mut scene, triangle, both_sides),
            2 => lit_by_point(&mut scene, place),
            _ => lit_by_spot(&mut scene, place, direction, i),
        }
    }
    scene
}

fn lit_by_point(scene: &mut Scene, position: Vec3) {
    let kind = LightKind::Point { position, intensity: Vec3::new(0.02, 0.01, 0.03) };
    scene.lights.push(Light { name: String::new(), kind, group: None });
}

/// From 2 degrees to nearly all around.
fn lit_by_spot(scene: &mut Scene, position: Vec3, direction: Vec3, number: usize) {
    let outer_angle = 0.04 + 0.05 * number as f32;
    let falloff = FALLOFFS[number % 3];
    let kind = LightKind::Spot {
        position,
        direction,
        intensity: Vec3::splat(0.04),
        inner_angle: 0.3 * outer_angle,
        outer_angle,
        falloff,
    };
    scene.lights.push(Light { name: String::new(), kind, group: None });
}

/// The points of an additive recurrence, spread evenly over the unit cube.
fn spread(i: usize) -> Vec3 {
    (DVec3::new(0.819_172_5, 0.671_043_6, 0.549_700_5) * i as f64).fract().as_vec3()
}
