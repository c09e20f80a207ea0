//! A crop is that part of the film: the same samples where no path of another pixel counts, the same
//! mean where splats do.

use midway_film::Image;
use midway_render::{Crop, FilterKind, PixelFilter, RenderSettings};
use midway_tests::{
    camera_scenes::{ball_out_of_focus, facing_squares_through_a_lens},
    estimate::{Agreement, Blocks, Expected, cpu, render},
    integrators, own,
    scenes::SIZE,
};

use crate::support::{Report, estimate_with, in_turn, settings};

const CROP: Crop = Crop { x: 5, y: 11, width: 17, height: 9 };
/// Samples a pixel by `path` of the estimates.
const SAMPLES: u64 = 4096;

fn cut(image: &Image, crop: Crop) -> Image {
    Image::from_fn(crop.width as usize, crop.height as usize, |x, y| {
        image.pixels[(crop.y as usize + y) * image.width + crop.x as usize + x]
    })
}

fn without_splats() -> Vec<integrators::Case> {
    let mut full = integrators::full();
    full.settings.splat = Some(false);
    let naive = integrators::path_naive();
    vec![naive, integrators::path(), full, integrators::single_step(true, false)]
}

#[test]
fn a_crop_has_the_bits_of_the_whole() {
    let _turn = in_turn();
    let mut report = Report::default();
    for (name, scene) in [("cornell box", own::load(own::SCENES[0])), ("a lens", ball_out_of_focus())] {
        for case in without_splats() {
            for kind in [FilterKind::Box, FilterKind::BlackmanHarris] {
                let filter = PixelFilter::new(kind);
                let whole = RenderSettings { filter, ..settings(SIZE, case.settings, 3) };
                let part = RenderSettings { crop: Some(CROP), ..whole.clone() };
                let [whole, part] = [whole, part].map(|settings| render(&cpu(), &scene, &settings, 5));
                let text = format!("{name}, {}, {}", case.name(), filter.describe());
                report.note(&text, part == cut(&whole, CROP) && !part.is_black());
            }
        }
    }
    report.finish();
}

/// Splats of a crop come from fewer light paths, which find fewer of its pixels: both count.
#[test]
fn a_crop_has_the_radiance_of_the_whole_by_splats_too() {
    let _turn = in_turn();
    let known = facing_squares_through_a_lens();
    let in_use = vec![true; (CROP.width * CROP.height) as usize];
    let expected = Expected { mean: cut(&known.expected.mean, CROP), standard_error: None };
    let expected = Blocks::of_expected(&expected, &in_use);
    let mut report = Report::default();
    for case in [integrators::light(), integrators::full(), integrators::single_step(true, true)] {
        let part = RenderSettings { crop: Some(CROP), ..settings(SIZE, case.settings, 0) };
        let images = estimate_with(&cpu(), &known.scene, &part, &case, SAMPLES);
        let agreement = Agreement::of(&Blocks::of_batches(&images, &in_use), &expected);
        report.check_where_reachable(&case.name(), &agreement);
    }
    report.finish();
}
