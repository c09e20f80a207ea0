//! The yardstick scenes and their references, made by another renderer.

use std::path::Path;

use midway_film::ExrFile;
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
}

/// Our pixels are so many of the reference's wide and high (64 x 64 of 256 x 256).
const PIXEL: usize = 4;

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
        Some(Self {
            name,
            scene,
            size: mean.width as u32,
            on_specular: specular.iter().map(|&share| share == 1.0).collect(),
            off_specular: specular.iter().map(|&share| share == 0.0).collect(),
            expected: Expected { mean, standard_error: Some(standard_error) },
        })
    }

    /// Every pixel.
    pub fn everywhere(&self) -> Vec<bool> {
        vec![true; self.off_specular.len()]
    }
}

fn read(path: &Path) -> ExrFile {
    ExrFile::read(path).expect("a reference loads")
}
