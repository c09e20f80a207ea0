//! The one kernel that `midway bench baseline` measures against renders what the integrator renders: what
//! is compared is the work, not the image.

use std::sync::Arc;

use midway_device::Device;
use midway_film::Image;
use midway_render::{FilterKind, PixelFilter, RenderSettings};
use midway_scene::Scene;
use midway_tests::{
    estimate::{checked_image, cpu, gpu, render, render_until, renderer},
    integrators, lit, own, scenes,
};

use crate::{
    devices::{AGREEING, share_of_agreeing_pixels},
    repeatability::bits,
    support::{Report, in_turn, settings},
};

/// Pixels along both sides.
const SIZE: usize = 40;
/// Samples a pixel: on the CPU more than one launch.
const SAMPLES: u32 = 12;

fn full(size: usize) -> RenderSettings {
    settings(size, integrators::full().settings, 5)
}

fn by_one_kernel(device: &Arc<dyn Device>, scene: &Scene, settings: &RenderSettings) -> Image {
    let mut kernel = renderer(device, scene, settings).megakernel().expect("a join that it does");
    kernel.render(SAMPLES).expect("renders");
    let totals = kernel.totals().expect("counted");
    assert_eq!((totals.rejected, totals.overflowed), (0, 0));
    kernel.image().expect("resolves")
}

/// By the same steps and the same random numbers: not only the same mean.
#[test]
fn one_kernel_renders_the_integrators_bits() {
    let _turn = in_turn();
    let own = own::SCENES.into_iter().map(|name| (name, own::load(name)));
    let made = [
        ("all lights", lit::room_with_all_lights()),
        ("materials", scenes::materials_room(false)),
        ("leaning", scenes::leaning_materials_room()),
    ];
    let wide = PixelFilter { kind: FilterKind::BlackmanHarris, width: 3.0 };
    let mut report = Report::default();
    for (name, mut scene) in own.chain(made) {
        scene.cameras[0].lens_radius = 0.01;
        let settings = RenderSettings { filter: wide, ..full(SIZE) };
        let expected = render(&cpu(), &scene, &settings, SAMPLES.into());
        let other = render(&cpu(), &scene, &RenderSettings { seed: 6, ..settings.clone() }, SAMPLES.into());
        let image = bits(&by_one_kernel(&cpu(), &scene, &settings));
        report.note(name, image == bits(&expected) && image != bits(&other) && !expected.is_black());
    }
    report.finish();
}

#[test]
fn one_kernel_renders_the_same_samples_on_a_gpu() {
    let _turn = in_turn();
    let Some(gpu) = gpu() else { return };
    let scene = own::load(own::SCENES[0]);
    let expected = render(&gpu, &scene, &full(SIZE), SAMPLES.into());
    let share = share_of_agreeing_pixels(&by_one_kernel(&gpu, &scene, &full(SIZE)), &expected);
    assert!(share >= AGREEING && !expected.is_black(), "{share}");
}

/// A path that waits with joins to make (more than 8 of a vertex) traces none meanwhile.
#[test]
fn one_kernel_counts_the_integrators_rays() {
    let _turn = in_turn();
    let scene = own::load(own::SCENES[0]);
    let mut renderer = renderer(&cpu(), &scene, &full(SIZE));
    render_until(&mut renderer, SAMPLES.into());
    let mut kernel = renderer.megakernel().expect("a join that it does");
    kernel.render(1).expect("renders");
    assert_eq!(kernel.totals().expect("counted").rays, 0, "counting is asked for");
    kernel.restart_with_seed(5).expect("restarts");
    kernel.count_rays(true);
    kernel.render(SAMPLES).expect("renders");
    assert_eq!(bits(&kernel.image().expect("resolves")), bits(&checked_image(&renderer)));
    assert_eq!(kernel.totals().expect("counted").rays, renderer.stats().expect("counted").rays);
}

#[test]
fn one_kernel_refuses_what_it_does_not_do() {
    let scene = own::load(own::SCENES[0]);
    for case in
        integrators::share("pool").into_iter().filter(|case| case.name() != integrators::full().name())
    {
        let renderer = renderer(&cpu(), &scene, &settings(8, case.settings, 5));
        assert!(renderer.megakernel().is_err(), "{}", case.name());
    }
}
