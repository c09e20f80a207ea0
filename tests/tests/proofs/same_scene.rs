//! One box in every format: `tests/scenes/same/`. Its importers have to make the same scene of it,
//! up to order, and the same image.

use std::path::Path;

use glam::Vec3;
use midway_scene::{ConductorFresnel, Material, MetallicRoughness, Scene, Sides, Surface, WorldTriangle};
use midway_tests::{
    estimate::{Agreement, Blocks, cpu},
    integrators,
};

use crate::support::{Report, estimate, in_turn, mean_bound};

/// Pixels along each side: that of the files' films.
const SIZE: usize = 64;
/// Samples a pixel: about 2 s a format.
const SAMPLES: u64 = 256;
/// Of lengths of about 1, through a matrix in one file or another.
const POSITION_TOLERANCE: f32 = 2e-6;

/// The box in each format that is read, the first the one that the others are held to.
fn boxes() -> Vec<(&'static str, Scene)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/same");
    let read = |extension: &str| midway_import::FORMATS.contains(&format!("(.{extension}"));
    let formats: Vec<_> = ["gltf", "obj", "pbrt", "xml"].into_iter().filter(|e| read(e)).collect();
    assert!(formats.len() >= 3, "{formats:?}");
    let load = |extension: &'static str| {
        let import = midway_import::load(&folder.join("box").with_extension(extension));
        (extension, import.unwrap_or_else(|e| panic!("{e}")).scene)
    };
    let mut boxes: Vec<_> = formats.into_iter().map(load).collect();
    // OBJ has no camera.
    let camera = boxes[0].1.cameras[0].clone();
    boxes.iter_mut().filter(|(format, _)| *format == "obj").for_each(|(_, scene)| {
        scene.cameras[0] = camera.clone();
    });
    boxes
}

/// What a material of the box is, whichever of the models says it.
#[derive(Debug, PartialEq)]
enum Look {
    Diffuse(Vec3),
    Mirror(Vec3),
    Glass(f32),
}

fn look(material: &Material) -> Look {
    match &material.surface {
        Surface::Diffuse { reflectance } => Look::Diffuse(reflectance.value),
        Surface::Conductor { fresnel, roughness } => {
            assert!(roughness.is_smooth());
            Look::Mirror(match fresnel {
                ConductorFresnel::Schlick { f0 } => f0.value,
                // η = 0 reflects everything.
                ConductorFresnel::Complex { eta, tint, .. } if *eta == Vec3::ZERO => tint.value,
                other => panic!("{other:?}"),
            })
        }
        Surface::Dielectric { ior, reflection, transmission, sigma_a, thin: false, roughness, .. } => {
            assert!(roughness.is_smooth());
            assert_eq!([reflection.value, transmission.value, *sigma_a], [Vec3::ONE, Vec3::ONE, Vec3::ZERO]);
            Look::Glass(*ior)
        }
        Surface::MetallicRoughness(model) => gltf_look(model),
        other => panic!("{other:?}"),
    }
}

fn gltf_look(model: &MetallicRoughness) -> Look {
    let [metallic, specular, roughness, transmission] =
        [&model.metallic, &model.specular, &model.roughness, &model.transmission].map(|input| input.value);
    match [metallic, specular, roughness, transmission] {
        [1.0, _, 0.0, _] => Look::Mirror(model.base_color.value),
        [0.0, _, 0.0, 1.0] if !model.thin => Look::Glass(model.ior),
        [0.0, 0.0, _, 0.0] => Look::Diffuse(model.base_color.value),
        other => panic!("{other:?}"),
    }
}

/// Whether two triangles have the same corners in the same sense.
fn coincide(a: &WorldTriangle, b: &WorldTriangle) -> bool {
    (0..3).any(|first| {
        (0..3).all(|i| a.positions[i].abs_diff_eq(b.positions[(first + i) % 3], POSITION_TOLERANCE))
    })
}

fn assert_same(format: &str, scene: &Scene, expected: &Scene) {
    let triangles: Vec<WorldTriangle> = scene.world_triangles().collect();
    assert_eq!(triangles.len(), expected.counts().triangles, "{format}");
    for wanted in expected.world_triangles() {
        let found: Vec<_> = triangles.iter().filter(|t| coincide(t, &wanted)).collect();
        let [found] = found[..] else {
            panic!("{format}: {} triangles are at {:?}", found.len(), wanted.positions);
        };
        let [material, wanted] = [(scene, found), (expected, &wanted)]
            .map(|(scene, triangle)| &scene.materials[triangle.material as usize]);
        let emission = (material.emission.value - wanted.emission.value).abs().max_element();
        assert!(emission <= 1e-5, "{format}: {material:?} is not {wanted:?}");
        assert!(!material.is_emissive() || material.emits == Sides::Front, "{format}");
        // Black emitters may be read as either of two models.
        assert_eq!(look(material), look(wanted), "{format}");
    }
    let [camera, wanted] = [&scene.cameras[0], &expected.cameras[0]];
    let off = camera.world_from_camera - wanted.world_from_camera;
    let off = off.to_cols_array().into_iter().fold(0.0f32, |most, x| most.max(x.abs()));
    assert!(off <= 1e-6, "{format}: {} is not {}", camera.world_from_camera, wanted.world_from_camera);
    let [fov, wanted] = [camera, wanted].map(|c| c.yfov().expect("a perspective camera"));
    assert!((fov - wanted).abs() <= 1e-6, "{format}: {fov} is not {wanted}");
}

#[test]
fn every_importer_makes_the_same_scene() {
    let boxes = boxes();
    let (_, expected) = &boxes[0];
    // What is compared with is not nothing.
    assert_eq!((expected.counts().triangles, expected.counts().emissive_triangles), (22, 2));
    for (format, scene) in &boxes[1..] {
        assert_same(format, scene, expected);
    }
}

/// A wall of another colour, a light turned over and a camera that is off have to be seen.
#[test]
fn scenes_that_differ_are_told_apart() {
    let (_, expected) = boxes().swap_remove(0);
    let spoilt: [fn(&mut Scene); 4] = [
        |scene| scene.materials[1].surface = Surface::diffuse(Vec3::splat(0.5)),
        |scene| scene.meshes[7].triangles.iter_mut().for_each(|t| t.swap(1, 2)),
        |scene| scene.cameras[0].world_from_camera.w_axis.x += 1e-4,
        |scene| scene.meshes[0].positions[0].x += 1e-4,
    ];
    for spoil in spoilt {
        let mut scene = expected.clone();
        spoil(&mut scene);
        let told = std::panic::catch_unwind(|| assert_same("spoilt", &scene, &expected));
        assert!(told.is_err());
    }
}

#[test]
fn every_importer_gives_the_same_image() {
    let _turn = in_turn();
    let in_use = vec![true; SIZE * SIZE];
    let blocks = |scene: &Scene| {
        Blocks::of_batches(&estimate(&cpu(), scene, SIZE, &integrators::path(), SAMPLES), &in_use)
    };
    let boxes = boxes();
    let expected = blocks(&boxes[0].1);
    let mut report = Report::default();
    for (format, scene) in &boxes[1..] {
        let agreement = Agreement::of(&blocks(scene), &expected);
        report.check(format, &agreement, Some(mean_bound()));
    }
    report.finish();
}
