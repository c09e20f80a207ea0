//! Normal maps and maps of directions lie as their image does, whichever way up the mesh counts its
//! texture coordinates.

use glam::{Mat3, Vec2, Vec3};
use midway_film::Image;
use midway_scene::{
    CoatNormal, Image as Picture, Material, MetallicRoughness, NormalMap, Scene, Surface, Texels, Texture,
};
use midway_tests::{
    estimate::{cpu, render},
    integrators,
    shapes::{Shape, add, camera, diffuse},
};

use crate::support::{in_turn, settings};

const SIZE: usize = 16;
const SAMPLES: u64 = 16;

/// The map, its image of one texel upside down where the mesh counts so.
fn map(flip_v: bool) -> Texture {
    let flipped = Mat3::from_translation(Vec2::Y) * Mat3::from_scale(Vec2::new(1.0, -1.0));
    Texture { image_from_uv: if flip_v { flipped } else { Mat3::IDENTITY }, ..Texture::new(0) }
}

/// A floor under a lamp at one side, its normals leaning by a map.
fn scene(lean: [f32; 2], flip_v: bool) -> Scene {
    let mut floor = diffuse(Vec3::splat(0.7), Vec3::ZERO);
    floor.normal_map = Some(NormalMap { texture: map(flip_v), scale: 1.0 });
    scene_of(floor, lean, flip_v)
}

/// A floor under a lamp at one side, and an image of one texel that points somewhere.
fn scene_of(floor: Material, points: [f32; 2], flip_v: bool) -> Scene {
    let mut scene = Scene::default();
    let texel = [0.5 + 0.5 * points[0], 0.5 + 0.5 * points[1], 0.9, 1.0];
    let texels = Texels::Float(vec![texel].into());
    scene.images.push(Picture { name: String::new(), width: 1, height: 1, texels });
    add(&mut scene, Shape::parallelogram(Vec3::new(-1.0, -1.0, 0.0), 2.0 * Vec3::X, 2.0 * Vec3::Y), floor);
    let place = |uv: Vec2| if flip_v { Vec2::new(uv.x, 1.0 - uv.y) } else { uv };
    scene.meshes[0].uvs[0] = [Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO].map(place).to_vec();
    let lamp = Shape::parallelogram(Vec3::new(1.0, 1.0, 2.0), 0.5 * Vec3::Y, 0.5 * Vec3::X);
    add(&mut scene, lamp, diffuse(Vec3::ZERO, Vec3::splat(5.0)));
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, 2.0), Vec3::ZERO, 40.0));
    scene
}

fn picture(lean: [f32; 2], flip_v: bool) -> Image {
    picture_of(&scene(lean, flip_v))
}

fn picture_of(scene: &Scene) -> Image {
    let settings = settings(SIZE, integrators::path().settings, 3);
    render(&cpu(), scene, &settings, SAMPLES)
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

/// A coat on black leans by its own map as a surface does by its, and not by the map of what is below.
#[test]
fn a_coat_leans_by_its_own_map() {
    let _turn = in_turn();
    let lean = [0.3, -0.2];
    let floor = |below: Option<Texture>, coat: CoatNormal| Material {
        normal_map: below.map(|texture| NormalMap { texture, scale: 1.0 }),
        ..Material::new(Surface::MetallicRoughness(Box::new(MetallicRoughness {
            base_color: Vec3::ZERO.into(),
            specular: 0.0.into(),
            clearcoat: 1.0.into(),
            clearcoat_roughness: 0.6.into(),
            clearcoat_normal: coat,
            ..MetallicRoughness::default()
        })))
    };
    let own = |flip_v| CoatNormal::Map(NormalMap { texture: map(flip_v), scale: 1.0 });
    let seen = |floor, flip_v| picture_of(&scene_of(floor, lean, flip_v));
    let straight = seen(floor(None, CoatNormal::Below), false);
    let leaning = seen(floor(Some(map(false)), CoatNormal::Below), false);
    let apart = difference(&leaning, &straight);
    assert!(apart >= 0.05, "leaning changes the picture by {apart}");
    for (name, other, expected) in [
        ("by its own map", seen(floor(None, own(false)), false), &leaning),
        ("by its own map, flipped", seen(floor(None, own(true)), true), &leaning),
        ("by its own map over the same", seen(floor(Some(map(false)), own(false)), false), &leaning),
        ("by no map", seen(floor(Some(map(false)), CoatNormal::Mesh), false), &straight),
    ] {
        let error = difference(&other, expected);
        assert!(error <= 1e-3, "{name}: {error}");
    }
}

/// A map of directions turns brushed metal as a rotation does, and the rotation turns what it says.
#[test]
fn a_map_of_directions_turns_anisotropy() {
    let _turn = in_turn();
    let floor = |rotation: f32, direction: Option<Texture>| {
        Material::new(Surface::MetallicRoughness(Box::new(MetallicRoughness {
            metallic: 1.0.into(),
            roughness: 0.4.into(),
            anisotropy: 0.8.into(),
            anisotropy_rotation: rotation,
            anisotropy_direction: direction,
            ..MetallicRoughness::default()
        })))
    };
    let turned =
        |rotation, points, flip_v| picture_of(&scene_of(floor(rotation, Some(map(flip_v))), points, flip_v));
    let plain = |rotation| picture_of(&scene_of(floor(rotation, None), [1.0, 0.0], false));
    let (sin, cos) = 0.6f32.sin_cos();
    let steep = 1.2f32;
    for flip_v in [false, true] {
        for (map, rotation) in
            [([steep.cos(), steep.sin()], steep), ([cos, sin], 0.6), ([0.5 * cos, -0.5 * sin], -0.6)]
        {
            let error = difference(&turned(0.0, map, flip_v), &plain(rotation));
            assert!(error <= 1e-3, "{map:?}, flipped: {flip_v}: {error}");
        }
    }
    let error = difference(&turned(0.4, [cos, sin], false), &plain(1.0));
    assert!(error <= 1e-3, "both: {error}");
    let apart = difference(&plain(0.6), &plain(-0.6));
    assert!(apart >= 0.05, "turning changes the picture by {apart}");
}
