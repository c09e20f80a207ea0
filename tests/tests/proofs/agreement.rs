//! Integrators against each other, where there is no closed form.

use std::sync::Arc;

use midway_device::{Device, DeviceKind};
use midway_film::Image;
use midway_render::{Integrator, IntegratorSettings, JoinChoice, LightPaths};
use midway_scene::Scene;
use midway_tests::{
    estimate::{Agreement, Blocks, cpu, gpu},
    everything::everything,
    integrators::{self, Case},
    lit, scenes,
};

use crate::support::{Report, estimate, estimate_again, in_turn, is_nightly};

/// Samples a pixel by `path`: about 1 s a case.
const SAMPLES: u64 = 384;
/// What integrators are held to takes so many times the samples: `path-naive`, as it draws nothing
/// that `light` and the joins rely on, or `path` where there are lights that cannot be hit.
const AGAINST: u64 = 8;

/// Shading normals that differ from the geometry's make scattering asymmetric: without the adjoint
/// factor light paths disagree with camera paths (Veach 1997, section 5.3).
#[test]
fn integrators_agree_on_shading_normals() {
    let _turn = in_turn();
    agree(&scenes::leaning_normals(), &integrators::path_naive());
}

/// A lamp, a point light, a spot, the sun and a sky in one room: each is one kind in the choice of
/// lights, and has strategies of its own.
#[test]
fn integrators_agree_on_all_lights_at_once() {
    let _turn = in_turn();
    agree(&lit::room_with_all_lights(), &integrators::path());
}

/// Every light and every material in one room, by every integrator on the CPU and on a real GPU: what one kind does to
/// another is met too, as a spot's light on a coat seen in a mirror is.
#[test]
fn integrators_agree_on_every_light_and_material_at_once() {
    let _turn = in_turn();
    let everything = everything();
    let all_pixels = vec![true; scenes::SIZE * scenes::SIZE];
    let seen_by_light = everything.seen_by_light();
    let n_seen = seen_by_light.iter().filter(|seen| **seen).count();
    assert!(n_seen > all_pixels.len() / 2 && n_seen < all_pixels.len(), "{n_seen} pixels seen by light");
    let scene = &everything.scene;
    let on_cpu = |case: &Case, samples| estimate(&cpu(), scene, scenes::SIZE, case, samples);
    // By other seeds, as `path` is compared with itself; four times the samples that are asked for.
    let on_gpu =
        |gpu: &Arc<dyn Device>, case: &Case| estimate_again(gpu, scene, scenes::SIZE, case, SAMPLES / 32);
    let expected = on_cpu(&integrators::path(), AGAINST * SAMPLES);
    let mut report = Report::default();
    let mut check = |name: &str, case: &Case, images: &[Image]| {
        let in_use = if case.settings.integrator == Integrator::Light { &seen_by_light } else { &all_pixels };
        let blocks = |images: &[Image]| Blocks::of_batches(images, in_use);
        let agreement = Agreement::of(&blocks(images), &blocks(&expected));
        report.check_where_reachable(&format!("{name}, {}", case.name()), &agreement);
    };
    // Points, spots and the sun cannot be hit.
    let others = |case: &Case| !matches!(case.settings.integrator, Integrator::PathNaive | Integrator::Path);
    for case in integrators::all().into_iter().filter(others) {
        check("CPU", &case, &on_cpu(&case, SAMPLES));
    }
    // A software GPU takes many minutes and 14 GB to compile kernels that know of everything.
    match gpu().filter(|gpu| gpu.info().kind == DeviceKind::Gpu) {
        Some(gpu) => {
            let cases = if is_nightly() { integrators::all().split_off(1) } else { one_of_each_kind() };
            for case in cases {
                check("GPU", &case, &on_gpu(&gpu, &case));
            }
        }
        None => println!("not by a GPU: there is none but in software"),
    }
    report.finish();
}

fn one_of_each_kind() -> Vec<Case> {
    let full = integrators::full();
    let settings = IntegratorSettings { light_paths: LightPaths::Pool(None), ..full.settings };
    let k_step = integrators::k_step(3, JoinChoice::Importance);
    let single_step = integrators::single_step(true, true);
    vec![integrators::path(), integrators::light(), full, Case { settings, ..full }, k_step, single_step]
}

fn agree(scene: &Scene, reference: &Case) {
    let in_use = vec![true; scenes::SIZE * scenes::SIZE];
    let blocks = |case: &Case, samples| {
        Blocks::of_batches(&estimate(&cpu(), scene, scenes::SIZE, case, samples), &in_use)
    };
    let expected = blocks(reference, AGAINST * SAMPLES);
    let mut report = Report::default();
    let of = |case: &Case| case.settings.integrator;
    let sees = |case: &Case| of(case) != Integrator::PathNaive && of(case) != of(reference);
    for case in integrators::all().into_iter().filter(sees) {
        let agreement = Agreement::of(&blocks(&case, SAMPLES), &expected);
        report.check_where_reachable(&case.name(), &agreement);
    }
    report.finish();
}

/// Every model of a surface, with shading normals that lean too: from one end, from the other and from
/// both.
#[test]
fn integrators_agree_on_every_material() {
    let _turn = in_turn();
    let in_use = vec![true; scenes::SIZE * scenes::SIZE];
    let mut report = Report::default();
    let rooms = [
        ("rough", scenes::materials_room(false)),
        ("smooth", scenes::materials_room(true)),
        ("leaning", scenes::leaning_materials_room()),
    ];
    for (name, scene) in &rooms {
        let smooth = *name == "smooth";
        let blocks = |case: &Case, samples| {
            Blocks::of_batches(&estimate(&cpu(), scene, scenes::SIZE, case, samples), &in_use)
        };
        let expected = blocks(&integrators::path_naive(), AGAINST * SAMPLES);
        let ends = [
            integrators::path(),
            integrators::full(),
            integrators::single_step(true, true),
            integrators::light(),
        ];
        // Light paths cannot be seen by way of a delta lobe.
        for case in ends.iter().filter(|case| !smooth || case.settings.integrator != Integrator::Light) {
            let agreement = Agreement::of(&blocks(case, SAMPLES), &expected);
            let text = format!("{}, {name}: {agreement}", case.name());
            if *name == "leaning" && case.settings.integrator == Integrator::Light {
                // Light that grazes a surface weighs 1 / cosine where the normal leans towards it, once for
                // each bounce within glass: a heavy tail, which few samples have, and no bias: paths of at
                // most 5 edges agree after 65,536 samples a pixel (bench/NOTES.md).
                report.note(&text, agreement.nothing_is_brighter() && agreement.means_agree());
            } else {
                report.check_where_reachable(&format!("{}, {name}", case.name()), &agreement);
            }
        }
    }
    report.finish();
}
