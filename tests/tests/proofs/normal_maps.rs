//! Normal maps lie as their image does, whichever way up the mesh counts its texture coordinates.

use glam::{Mat3, Vec2, Vec3};
use midway_film::Image;
use midway_scene::{Image as Picture, NormalMap, Scene, Texels, Texture};
use midway_tests::{
    estimate::{cpu, render},
    integrators,
    shapes::{Shape, add, camera, diffuse},
};

use crate::support::{in_turn, settings};

const SIZE: usize = 16;
const SAMPLES: u64 = 16;

/// A floor under a lamp at one side, its normals leaning by a map of one texel.
fn scene(lean: [f32; 2], flip_v: bool) -> Scene {
    let mut scene = Scene::default();
    let texel = [0.5 + 0.5 * lean[0], 0.5 + 0.5 * lean[1], 0.9, 1.0];
    let texels = Texels::Float(vec![texel].into());
    scene.images.push(Picture { name: String::new(), width: 1, height: 1, texels });
    let mut floor = diffuse(Vec3::splat(0.7), Vec3::ZERO);
    let flipped = Mat3::from_translation(Vec2::Y) * Mat3::from_scale(Vec2::new(1.0, -1.0));
    let image_from_uv = if flip_v { flipped } else { Mat3::IDENTITY };
    floor.normal_map = Some(NormalMap { texture: Texture { image_from_uv, ..Texture::new(0) }, scale: 1.0 });
    add(&mut scene, Shape::parallelogram(Vec3::new(-1.0, -1.0, 0.0), 2.0 * Vec3::X, 2.0 * Vec3::Y), floor);
    let place = |uv: Vec2| if flip_v { Vec2::new(uv.x, 1.0 - uv.y) } else { uv };
    scene.meshes[0].uvs[0] = [Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO].map(place).to_vec();
    let lamp = Shape::parallelogram(Vec3::new(1.0, 1.0, 2.0), 0.5 * Vec3::Y, 0.5 * Vec3::X);
    add(&mut scene, lamp, diffuse(Vec3::ZERO, Vec3::splat(5.0)));
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, 2.0), Vec3::ZERO, 40.0));
    scene
}

fn picture(lean: [f32; 2], flip_v: bool) -> Image {
    let settings = settings(SIZE, integrators::path().settings, 3);
    render(&cpu(), &scene(lean, flip_v), &settings, SAMPLES)
}

/// The largest difference of two images, as a share of the brightest value.
fn difference(a: &Image, b: &Image) -> f32 {
    let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let brightest = a.pixels.as_flattened().iter().fold(0.0, |most: f32, x| most.max(*x));
    pairs.fold(0.0, |most: f32, (a, b)| most.max((a - b).abs())) / brightest
}

#[test]
fn a_map_lies_the_same_whichever_way_up_coordinates_count() {
    let _turn = in_turn();
    for lean in [[0.3, 0.0], [0.0, 0.3], [-0.2, 0.25]] {
        let upright = picture(lean, false);
        assert!(!upright.is_black());
        let other = picture(lean, true);
        assert!(difference(&upright, &other) <= 1e-4, "{lean:?}: {}", difference(&upright, &other));
    }
}

/// The lamp stands towards +x and +y, which are right and up in the map.
#[test]
fn normals_lean_towards_the_right_and_up_of_the_map() {
    let _turn = in_turn();
    let sum = |lean| picture(lean, false).mean().iter().sum::<f64>();
    let straight = sum([0.0, 0.0]);
    for axis in 0..2 {
        let lean = |by: f32| if axis == 0 { [by, 0.0] } else { [0.0, by] };
        assert!(sum(lean(0.3)) > 1.05 * straight && sum(lean(-0.3)) < 0.95 * straight, "axis {axis}");
    }
}
