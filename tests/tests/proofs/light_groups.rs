//! Groups of lights: their films add up to the image, and each is the image by its lights alone.

use std::sync::Arc;

use midway_device::Device;
use midway_film::{Channel, Image};
use midway_render::{Aov, JoinChoice, LightPaths, RenderSettings, Renderer};
use midway_scene::{LightGroupRule, Scene};
use midway_tests::{
    estimate::{Agreement, Blocks, checked_image, combine, cpu, gpu, render_until, renderer},
    integrators::{self, Case},
    lit,
};

use crate::support::{Report, in_turn, settings};

const SIZE: usize = 16;
/// Layers are floats of sums that are integers: each is rounded once, and so is their sum.
const ROUNDING: f64 = 1e-6;

/// Every kind of light, in four groups: the point light and the spot are one.
fn scene() -> Scene {
    let mut scene = lit::room_with_all_lights();
    let lights = ["light 0", "light 1"].map(str::to_owned).to_vec();
    let rule = LightGroupRule { group: "bulbs".to_owned(), lights };
    assert!(scene.group_lights(&[rule]).is_empty());
    assert_eq!(scene.light_groups().names.len(), 4);
    scene
}

/// The scene without the lights of all groups but one.
fn alone(scene: &Scene, group: u8) -> Scene {
    let groups = scene.light_groups();
    let mut alone = scene.clone();
    for (instance, &of) in scene.instances.iter().zip(&groups.instances) {
        let material = scene.meshes[instance.mesh as usize].material as usize;
        if of != group {
            alone.materials[material].emission.value = glam::Vec3::ZERO;
        }
    }
    let mut place = groups.lights.iter();
    alone.lights.retain(|_| place.next() == Some(&group));
    if groups.environment != group {
        alone.environment = None;
    }
    alone
}

fn with_groups(case: &Case, seed: u32) -> RenderSettings {
    RenderSettings { light_groups: true, aovs: vec![Aov::Variance], ..settings(SIZE, case.settings, seed) }
}

fn rendered(device: &Arc<dyn Device>, scene: &Scene, settings: &RenderSettings, samples: u64) -> Renderer {
    let mut renderer = renderer(device, scene, settings);
    render_until(&mut renderer, samples);
    renderer
}

/// The layers as images.
fn layers(renderer: &Renderer) -> Vec<Image> {
    let channels = renderer.group_channels().expect("reads");
    let image = |rgb: &[Channel]| Image {
        width: SIZE,
        height: SIZE,
        pixels: (0..SIZE * SIZE).map(|i| [0, 1, 2].map(|c| rgb[c].samples[i])).collect(),
    };
    channels.chunks_exact(3).map(image).collect()
}

fn sum(layers: &[Image]) -> Image {
    let none = Image::filled(SIZE, SIZE, [0.0; 3]);
    layers.iter().fold(none, |sum, layer| combine(&sum, layer, |a, b| a + b))
}

/// The largest difference, over the larger of the value and the mean.
fn difference(a: &Image, b: &Image) -> f64 {
    let mean = b.mean().iter().sum::<f64>() / 3.0;
    let values = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    values.map(|(a, b)| f64::from((a - b).abs()) / f64::from(*b).max(mean)).fold(0.0, f64::max)
}

/// Keeping groups apart changes no bit of the image or its variance, and the layers add up to it.
#[test]
fn groups_add_up_to_the_image() {
    let _turn = in_turn();
    let scene = scene();
    let mut report = Report::default();
    for case in integrators::all() {
        let asked = with_groups(&case, 3);
        let apart = rendered(&cpu(), &scene, &asked, 3);
        let together = rendered(&cpu(), &scene, &RenderSettings { light_groups: false, ..asked.clone() }, 3);
        let image = checked_image(&apart);
        let same = image == checked_image(&together)
            && apart.channels().expect("reads") == together.channels().expect("reads");
        report.note(&format!("{}: the same image", case.name()), same);
        assert!(together.light_groups().is_empty() && layers(&together).is_empty());
        let off = difference(&sum(&layers(&apart)), &image);
        report.note(&format!("{}: the sum is off by {off:.1e}", case.name()), off <= ROUNDING);
    }
    report.finish();
}

/// By every way in which a contribution is told which light it comes from. All of them see all of the
/// room, so that one reference does for all.
#[test]
fn each_group_is_the_image_by_its_lights_alone() {
    const SAMPLES: u64 = 64;
    let _turn = in_turn();
    let scene = scene();
    let names = scene.light_groups().names;
    let in_use = vec![true; SIZE * SIZE];
    let blocks = |images: &[Image]| Blocks::of_batches(images, &in_use);
    let reference = |group: usize| {
        let alone = alone(&scene, group as u8);
        let images = batches(&alone, &with_groups(&integrators::full(), 7), SAMPLES);
        blocks(&images.iter().map(|layers| sum(layers)).collect::<Vec<_>>())
    };
    let references: Vec<Blocks> = (0..names.len()).map(reference).collect();
    let mut pool = integrators::k_step(3, JoinChoice::Importance);
    pool.settings.light_paths = LightPaths::Pool(None);
    let cases = [
        integrators::path(),
        integrators::light(),
        integrators::full(),
        integrators::k_step(1, JoinChoice::Uniform),
        pool,
        integrators::single_step(false, true),
    ];
    let mut report = Report::default();
    for (case, seed) in cases.iter().zip(100..) {
        let apart = batches(&scene, &with_groups(case, seed), SAMPLES);
        for (group, name) in names.iter().enumerate() {
            let layer: Vec<Image> = apart.iter().map(|layers| layers[group].clone()).collect();
            let agreement = Agreement::of(&blocks(&layer), &references[group]);
            report.check(&format!("{}, {name}", case.name()), &agreement, None);
        }
    }
    report.finish();
}

/// The layers of 16 independent images.
fn batches(scene: &Scene, settings: &RenderSettings, samples: u64) -> Vec<Vec<Image>> {
    let mut renderer = renderer(&cpu(), scene, settings);
    let mut batch = |i: u32| {
        renderer.restart_with_seed(settings.seed ^ i.wrapping_mul(0x9e37_79b9)).expect("restarts");
        render_until(&mut renderer, samples);
        checked_image(&renderer);
        layers(&renderer)
    };
    (0..16).map(&mut batch).collect()
}

/// Kernels that are compiled for groups give what the CPU's give, layer by layer.
#[test]
fn a_gpu_keeps_the_same_groups_apart() {
    let _turn = in_turn();
    let Some(gpu) = gpu() else { return };
    let scene = scene();
    let mut report = Report::default();
    for case in [integrators::path(), integrators::full()] {
        let [ours, theirs] = [cpu(), gpu.clone()].map(|device| {
            let renderer = rendered(&device, &scene, &with_groups(&case, 8), 8);
            (checked_image(&renderer), layers(&renderer))
        });
        let off = difference(&sum(&theirs.1), &theirs.0);
        report.note(&format!("{}: the sum is off by {off:.1e}", case.name()), off <= ROUNDING);
        for (group, (ours, theirs)) in ours.1.iter().zip(&theirs.1).enumerate() {
            let share = agreeing(ours, theirs);
            report.note(&format!("{}, group {group}: {share:.4}", case.name()), share >= 0.98);
        }
    }
    report.finish();
}

/// The share of values that agree to rounding.
fn agreeing(a: &Image, b: &Image) -> f64 {
    let mean = b.mean().iter().sum::<f64>() / 3.0;
    let values = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let near = values.filter(|(a, b)| f64::from((**a - **b).abs()) <= 1e-3 * f64::from(**b).max(mean));
    near.count() as f64 / (3 * SIZE * SIZE) as f64
}
