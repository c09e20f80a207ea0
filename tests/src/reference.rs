//! The yardstick scenes and their references, made by another renderer.

use std::path::Path;

use midway_film::{ExrFile, Image};
use midway_scene::Scene;

use crate::{
    estimate::{Expected, combine},
    shared,
};

/// A scene with its reference image at the size that proofs render.
pub struct Yardstick {
    /// `A`, `B` or `C`.
    pub name: &'static str,
    /// The scene.
    pub scene: Scene,
    /// Pixels along both sides.
    pub size: u32,
    /// The reference, with its standard errors.
    pub expected: Expected,
    /// Pixels all of which show a specular surface.
    pub on_specular: Vec<bool>,
    /// Pixels none of which shows a specular surface.
    pub off_specular: Vec<bool>,
    /// Pixels that show a lamp, and their neighbours.
    pub on_lamp: Vec<bool>,
}

/// Our pixels are so many of the reference's wide and high (64 x 64 of 256 x 256).
const PIXEL: usize = 4;
/// What is brighter than this share of the brightest emission is taken for a lamp: lit surfaces and
/// caustics of the three scenes reach 2.5 %, the rims of their lamps begin at 4 %.
const LAMP: f32 = 0.03;

impl Yardstick {
    /// The Cornell box.
    pub fn a() -> Option<Self> {
        Self::load("A", "scenes/yardstick/A-cornell.gltf", "references/A_ref.exr")
    }

    /// The glass sphere and its caustic.
    pub fn b() -> Option<Self> {
        Self::load("B", "scenes/yardstick/B-caustic.gltf", "references/B_ref.exr")
    }

    /// The lamp.
    pub fn c() -> Option<Self> {
        Self::load("C", "scenes/yardstick/C-lamp.gltf", "references/C_ref.exr")
    }

    /// None, with a message, where the folder of scenes is absent.
    fn load(name: &'static str, scene: &str, reference: &str) -> Option<Self> {
        let scene = midway_import::load(&shared::file(scene)?).expect("a scene of the yardstick loads").scene;
        let file = read(&shared::file(reference)?);
        let mean = file.image().expect("means").block_means(PIXEL);
        let error = file.layer("se").expect("standard errors");
        // The standard error of a mean of n independent pixels: the root of their mean square over √n.
        let square = combine(&error, &error, |a, b| a * b).block_means(PIXEL);
        let standard_error = combine(&square, &square, |square, _| (square / (PIXEL * PIXEL) as f64).sqrt());
        let specular = match file.layer("mask") {
            Some(mask) => mask.block_means(PIXEL).pixels.iter().map(|p| p[0]).collect(),
            None => vec![0.0; mean.pixels.len()],
        };
        let brightest = scene.materials.iter().map(|m| m.emission.value.max_element()).fold(0.0, f32::max);
        Some(Self {
            name,
            scene,
            size: mean.width as u32,
            on_specular: specular.iter().map(|&share| share == 1.0).collect(),
            off_specular: specular.iter().map(|&share| share == 0.0).collect(),
            on_lamp: near_brighter_than(&mean, LAMP * brightest),
            expected: Expected { mean, standard_error: Some(standard_error) },
        })
    }

    /// Pixels that show lit surfaces: no specular one, and no lamp, which is seen with weight 1 by
    /// whatever integrator and would hide the rest behind the noise of its rim (in B a lamp of 4
    /// pixels has 44 % of the image's mean).
    pub fn lit(&self) -> Vec<bool> {
        self.off_specular.iter().zip(&self.on_lamp).map(|(off, lamp)| *off && !lamp).collect()
    }
}

/// Pixels of which one of the 3 x 3 about them is brighter.
fn near_brighter_than(image: &Image, threshold: f32) -> Vec<bool> {
    let (width, height) = (image.width, image.height);
    let near = |at: usize, size: usize| at.saturating_sub(1)..(at + 2).min(size);
    let is_near = |i: usize| {
        let mut rows = near(i / width, height);
        rows.any(|y| near(i % width, width).any(|x| image.pixels[y * width + x][0] > threshold))
    };
    (0..image.pixels.len()).map(is_near).collect()
}

fn read(path: &Path) -> ExrFile {
    ExrFile::read(path).expect("a reference loads")
}
