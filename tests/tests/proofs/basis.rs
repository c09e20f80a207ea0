//! On a GPU too, renderers that share what another has on the device render what new ones render.

use midway_film::Image;
use midway_render::Renderer;
use midway_scene::{Environment, Scene, Surround};
use midway_tests::{
    estimate::{gpu, render_until, renderer},
    integrators, own,
};

use crate::{
    repeatability::bits,
    support::{in_turn, settings},
};

fn image(renderer: &mut Renderer) -> Image {
    render_until(renderer, 1);
    renderer.image().expect("reads")
}

#[test]
fn a_gpu_shares_what_another_scene_has_there() {
    let Some(gpu) = gpu() else { return };
    let _turn = in_turn();
    let scene = own::load(own::SCENES[0]);
    let settings = settings(16, integrators::full().settings, 5);
    let before = renderer(&gpu, &scene, &settings);
    let constant = Environment {
        radiance: glam::Vec3::new(0.2, 0.4, 0.8),
        image: None,
        world_from_environment: glam::Mat3::IDENTITY,
    };
    let surround = Surround { environment: Some(constant), image: None };
    let mut shared = before.basis().surrounded(&scene, &surround, settings.clone()).expect("fits");
    let around = Scene { environment: Some(constant), ..scene.clone() };
    assert_eq!(bits(&image(&mut shared)), bits(&image(&mut renderer(&gpu, &around, &settings))));
    let mut dressed = scene.clone();
    let materials: Vec<u32> = scene.meshes.iter().rev().map(|mesh| mesh.material).collect();
    for (mesh, material) in dressed.meshes.iter_mut().zip(materials) {
        mesh.material = material;
    }
    let mut shared = before.basis().dressed(&scene, &dressed, settings.clone()).expect("fits");
    assert_eq!(bits(&image(&mut shared)), bits(&image(&mut renderer(&gpu, &dressed, &settings))));
}
