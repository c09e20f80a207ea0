//! The same seed on the same device gives the same bits, whatever runs beside what.

use std::sync::Arc;

use midway_device::{Device, OpenOptions, open_device};
use midway_film::Image;
use midway_tests::{
    estimate::{checked_image, cpu, gpu, render, render_until, renderer},
    integrators, own,
};

use crate::support::{Report, in_turn, settings};

/// Pixels along both sides: more paths than one batch of a lane (1024) at 3 samples.
const SIZE: usize = 48;
/// Samples a pixel.
const SAMPLES: u64 = 3;

pub fn bits(image: &Image) -> Vec<u32> {
    image.pixels.as_flattened().iter().map(|value| value.to_bits()).collect()
}

fn cpu_of(threads: usize) -> Arc<dyn Device> {
    let options = OpenOptions { threads: Some(threads), ..OpenOptions::default() };
    open_device("cpu", &options).expect("the CPU device needs nothing")
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let _turn = in_turn();
    let scene = own::load(own::SCENES[0]);
    let devices = [1, 2, 3, 2].map(cpu_of);
    let mut report = Report::default();
    for case in integrators::all() {
        let settings = settings(SIZE, case.settings, 5);
        let images = devices.each_ref().map(|device| bits(&render(device, &scene, &settings, SAMPLES)));
        report.note(&case.name(), images.iter().all(|image| *image == images[0]));
    }
    report.finish();
}

#[test]
fn a_gpu_gives_the_same_bits_twice() {
    let _turn = in_turn();
    let Some(gpu) = gpu() else { return };
    let scene = own::load(own::SCENES[0]);
    let mut report = Report::default();
    for case in integrators::share("twice").into_iter().filter(|case| case.cost < 4.0) {
        let settings = settings(SIZE, case.settings, 5);
        let [once, again] = [(); 2].map(|()| bits(&render(&gpu, &scene, &settings, SAMPLES)));
        report.note(&case.name(), once == again);
    }
    report.finish();
}

#[test]
fn another_seed_gives_other_bits() {
    let _turn = in_turn();
    let scene = own::load(own::SCENES[0]);
    let mut report = Report::default();
    for case in integrators::all() {
        let [one, other] =
            [5, 6].map(|seed| bits(&render(&cpu(), &scene, &settings(SIZE, case.settings, seed), 1)));
        report.note(&case.name(), one != other);
    }
    report.finish();
}

#[test]
fn samples_one_by_one_are_the_samples_at_once() {
    let _turn = in_turn();
    let scene = own::load(own::SCENES[0]);
    let mut report = Report::default();
    for case in integrators::all() {
        let settings = settings(SIZE, case.settings, 5);
        let mut slow = renderer(&cpu(), &scene, &settings);
        for done in 1..=SAMPLES {
            assert_eq!(slow.step(1).expect("renders"), 1);
            assert_eq!(slow.samples(), done);
        }
        let mut fast = renderer(&cpu(), &scene, &settings);
        render_until(&mut fast, SAMPLES);
        report.note(&case.name(), bits(&checked_image(&slow)) == bits(&checked_image(&fast)));
    }
    report.finish();
}

#[test]
fn a_restarted_render_is_the_same_again() {
    let _turn = in_turn();
    let scene = own::load(own::SCENES[0]);
    let mut report = Report::default();
    for case in integrators::all() {
        let mut renderer = renderer(&cpu(), &scene, &settings(SIZE, case.settings, 5));
        render_until(&mut renderer, 1);
        let once = checked_image(&renderer);
        renderer.restart().expect("restarts");
        assert_eq!(renderer.samples(), 0);
        render_until(&mut renderer, 1);
        report.note(&case.name(), bits(&checked_image(&renderer)) == bits(&once));
    }
    report.finish();
}
