//! Several devices at one image: the samples of one, whoever renders which.

use std::{sync::Arc, time::Duration};

use midway_device::{Device, OpenOptions, open_device};
use midway_film::{Channel, Image};
use midway_render::{Aov, RenderSettings, Team};
use midway_scene::Scene;
use midway_tests::{
    estimate::{cpu, gpu, render, render_until, renderer},
    integrators::{self, Case},
    own,
};

use crate::{
    devices::{AGREEING, share_of_agreeing_pixels},
    support::{Report, in_turn, settings},
};

/// Pixels along both sides: of a device with one thread, one sample of each is a pass.
const SIZE: usize = 48;
/// Samples a pixel; three devices cannot have equal shares.
const SAMPLES: u64 = 7;

fn one_thread() -> Arc<dyn Device> {
    let options = OpenOptions { threads: Some(1), ..OpenOptions::default() };
    open_device("cpu", &options).expect("the CPU device needs nothing")
}

fn team(devices: &[Arc<dyn Device>], scene: &Scene, settings: &RenderSettings) -> Team {
    Team::new(devices, scene, &scene.cameras[0], settings, &[], |_| {}).expect("starts")
}

fn finish(team: &mut Team) -> Image {
    while team.samples() < SAMPLES {
        team.step(SAMPLES - team.samples(), Duration::from_millis(1)).expect("renders");
    }
    team.gathered().expect("gathers").image().expect("resolves")
}

fn cases() -> Vec<Case> {
    let pool = integrators::joins().into_iter().filter(|case| case.name().contains("pool")).take(2);
    [integrators::path(), integrators::light(), integrators::full()].into_iter().chain(pool).collect()
}

#[test]
fn devices_that_share_the_samples_give_the_bits_of_one() {
    let _turn = in_turn();
    let scene = own::load(own::SCENES[0]);
    let mut report = Report::default();
    for case in cases() {
        let settings = settings(SIZE, case.settings, 5);
        let mut team = team(&[(); 3].map(|()| one_thread()), &scene, &settings);
        team.step(SAMPLES, Duration::ZERO).expect("renders");
        report.note(&format!("{}: a pass on each", case.name()), team.samples() == 3);
        // A look halfway takes nothing away.
        let early = team.gathered().expect("gathers").image().expect("resolves");
        let whole = finish(&mut team);
        let stats = team.stats().expect("counted");
        let mut alone = renderer(&cpu(), &scene, &settings);
        render_until(&mut alone, SAMPLES);
        let same = whole == alone.image().expect("resolves") && early != whole;
        report.note(&format!("{}: the bits of one", case.name()), same);
        let rays = stats.rays == alone.stats().expect("counted").rays;
        report.note(&format!("{}: rays of all are counted", case.name()), rays);
    }
    report.finish();
}

#[test]
fn other_settings_begin_anew_on_every_device() {
    let _turn = in_turn();
    let scene = own::load(own::SCENES[0]);
    let [path, full] = [integrators::path(), integrators::full()].map(|c| settings(SIZE, c.settings, 5));
    let mut team = team(&[(); 2].map(|()| one_thread()), &scene, &path);
    team.step(SAMPLES, Duration::ZERO).expect("renders");
    team.set_settings(&full).expect("changes");
    assert_eq!(team.samples(), 0);
    assert!(finish(&mut team) == render(&cpu(), &scene, &full, SAMPLES));
}

/// First hits are those of the same samples; the variance is estimated from other passes.
#[test]
fn layers_are_those_of_all_samples() {
    let _turn = in_turn();
    let scene = own::load(own::SCENES[0]);
    let settings =
        RenderSettings { aovs: Aov::ALL.to_vec(), ..settings(SIZE, integrators::path().settings, 5) };
    let mut team = team(&[(); 2].map(|()| one_thread()), &scene, &settings);
    finish(&mut team);
    let ours = team.gathered().expect("gathers").channels().expect("reads");
    let mut alone = renderer(&cpu(), &scene, &settings);
    render_until(&mut alone, SAMPLES);
    let theirs = alone.channels().expect("reads");
    let is_variance = |channel: &&Channel| channel.name.starts_with("variance");
    let exact = |channels: &[Channel]| -> Vec<Channel> {
        channels.iter().filter(|channel| !is_variance(channel)).cloned().collect()
    };
    assert_eq!(exact(&ours), exact(&theirs));
    let mean =
        |channels: &[Channel]| channels.iter().filter(is_variance).flat_map(|c| &c.samples).sum::<f32>();
    let ratio = mean(&ours) / mean(&theirs);
    assert!((0.7..1.4).contains(&ratio), "{ratio}");
}

#[test]
fn a_gpu_and_the_cpu_share_the_samples() {
    let _turn = in_turn();
    let Some(gpu) = gpu() else { return };
    let scene = own::load(own::SCENES[0]);
    let settings = settings(SIZE, integrators::path().settings, 5);
    let image = finish(&mut team(&[gpu, cpu()], &scene, &settings));
    let share = share_of_agreeing_pixels(&image, &render(&cpu(), &scene, &settings, SAMPLES));
    assert!(share >= AGREEING, "{share}");
}
