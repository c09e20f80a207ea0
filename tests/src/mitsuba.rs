//! Scenes in Mitsuba's XML with images that Mitsuba made of them (`bench/mitsuba_agreement.py`).

use std::{fs, path::PathBuf};

use midway_film::{ExrFile, Image};
use midway_scene::Scene;

use crate::{
    estimate::{Blocks, Expected, FAMILY_LEVEL},
    statistics::{Estimate, sidak},
};

/// Independent images behind a reference's standard errors, less one.
const DEGREES: f64 = 15.0;

/// Rounding to a half float, uniform within 2^-11 of a number: its standard deviation.
const HALF_ROUNDING: f64 = 2.8e-4;

/// A scene and what Mitsuba makes of it.
pub struct Case {
    /// The file's name without its extension.
    pub name: String,
    /// As imported.
    pub scene: Scene,
    /// With standard errors.
    pub expected: Expected,
}

fn folder(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(name).join("mitsuba")
}

/// The names of all scenes: files with a camera.
pub fn names() -> Vec<String> {
    let files = fs::read_dir(folder("scenes")).expect("the scenes are there").flatten();
    let is_scene = |path: &PathBuf| {
        path.extension().is_some_and(|e| e == "xml")
            && fs::read_to_string(path).expect("a scene is text").contains("<sensor")
    };
    let name = |path: PathBuf| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut names: Vec<String> = files.map(|file| file.path()).filter(is_scene).map(name).collect();
    names.sort();
    names
}

impl Case {
    /// Reads both.
    pub fn load(name: &str) -> Self {
        let path = folder("scenes").join(format!("{name}.xml"));
        let scene = midway_import::load(&path).expect("a scene of the tests loads").scene;
        let file =
            ExrFile::read(&folder("references").join(format!("{name}.exr"))).expect("a reference loads");
        let mean = file.image().expect("means");
        let standard_error = file.layer("se");
        assert!(standard_error.is_some(), "{name} has no standard errors");
        Self { name: name.to_owned(), scene, expected: Expected { mean, standard_error } }
    }

    /// The reference by blocks. Half floats round all pixels of an even area alike, so that no mean over
    /// them is better known than one of them.
    pub fn blocks(&self) -> Blocks {
        let in_use = vec![true; self.expected.mean.pixels.len()];
        let mut blocks = Blocks::of_expected(&self.expected, &in_use);
        let known = blocks.blocks.iter_mut().flatten().chain([&mut blocks.whole]);
        known.for_each(|estimate| {
            let rounding = HALF_ROUNDING * estimate.mean;
            *estimate = Estimate::known(estimate.mean, estimate.standard_error.hypot(rounding));
        });
        blocks
    }

    /// Width and height that the scene asks for, which are those of its reference.
    pub fn size(&self) -> [u32; 2] {
        let size = self.scene.cameras[0].resolution.expect("a film has a size");
        assert_eq!(size.map(|n| n as usize), [self.expected.mean.width, self.expected.mean.height]);
        size
    }

    /// How well the means of independent images agree with the reference, pixel by pixel and channel by
    /// channel.
    pub fn pixels(&self, images: &[Image]) -> Pixels {
        let errors = self.expected.standard_error.as_ref().expect("checked when it was loaded");
        let expected = self.expected.mean.pixels.as_flattened().iter().zip(errors.pixels.as_flattened());
        let p = |(i, (mean, error)): (usize, (&f32, &f32))| {
            let values: Vec<f64> =
                images.iter().map(|image| f64::from(image.pixels.as_flattened()[i])).collect();
            let known = Estimate::known(f64::from(*mean), f64::from(*error));
            Estimate::of(&values).p_value(&Estimate { degrees: DEGREES, ..known })
        };
        let (worst, least_p) = expected
            .enumerate()
            .map(|pair| (pair.0, p(pair)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .expect("an image has pixels");
        let level = sidak(FAMILY_LEVEL, 3 * self.expected.mean.pixels.len());
        let width = self.expected.mean.width;
        Pixels { least_p, level, worst: [worst / 3 % width, worst / 3 / width] }
    }
}

/// The least p-value over the pixels and channels of an image.
#[derive(Clone, Copy, Debug)]
pub struct Pixels {
    /// By Welch's t-test.
    pub least_p: f64,
    /// The level that each is tested at.
    pub level: f64,
    /// Where it is, x and y.
    pub worst: [usize; 2],
}

impl Pixels {
    /// No pixel differs significantly.
    pub fn agree(&self) -> bool {
        self.least_p >= self.level
    }
}

impl std::fmt::Display for Pixels {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y] = self.worst;
        write!(f, "worst pixel ({x}, {y}), p {:.1e} (level {:.1e})", self.least_p, self.level)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case() -> Case {
        Case {
            name: String::new(),
            scene: Scene::default(),
            expected: Expected {
                mean: Image::filled(8, 8, [1.0; 3]),
                standard_error: Some(Image::filled(8, 8, [0.01; 3])),
            },
        }
    }

    /// Images about 1 that differ by up to 10 %.
    fn noisy() -> Vec<Image> {
        let mut state = 1u32;
        let mut uniform = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        (0..32).map(|_| Image::from_fn(8, 8, |_, _| [0; 3].map(|_| 0.9 + 0.2 * uniform()))).collect()
    }

    #[test]
    fn right_pixels_agree_and_one_wrong_one_does_not() {
        let mut images = noisy();
        assert!(case().pixels(&images).agree());
        images.iter_mut().for_each(|image| image.pixels[13][2] *= 1.3);
        let pixels = case().pixels(&images);
        assert!(!pixels.agree());
        assert_eq!(pixels.worst, [5, 1]);
        images.iter_mut().for_each(|image| image.pixels[13][2] = f32::NAN);
        assert!(!case().pixels(&images).agree());
    }
}
