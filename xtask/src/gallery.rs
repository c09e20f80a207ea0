//! The gallery: the project's own boxes by every integrator, each for the same time; and scenes that
//! people have, with sheets of all materials and lights.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use glam::{Mat3, Vec3};
use midway_device::{Device, OpenOptions, open_device};
use midway_film::Display;
use midway_render::{Integrator, IntegratorSettings, Join, LightPaths, RenderSettings, Renderer};
use midway_scene::{Environment, Scene, Surface};

use crate::sheet::{Cell, Sheet};

/// The boxes, in the order of the rows.
const BOXES: [&str; 3] = ["cornell-box", "glass-caustic", "lamp"];
/// Scenes that people have, below the folder of scenes, each with its caption and its exposure, in stops.
const OTHERS: [(&str, &str, f32); 3] = [
    ("Sponza by Crytek", "sponza/sponza-area.gltf", 0.0),
    ("Veach's door by Benedikt Bitterli, CC0", "transport/veach-ajar/veach-ajar.gltf", -1.5),
    ("kitchen by Jay-Artist, CC BY 3.0", "transport/kitchen/kitchen.gltf", 0.0),
];
/// The sheets, likewise.
const SHEETS: [(&str, &str, f32); 2] =
    [("materials", "scenes/material-sheet.gltf", 0.0), ("lights", "scenes/light-sheet.gltf", 0.0)];
/// What the materials are shown under once more.
const SKY: &str = "tests/scenes/mitsuba/sky.exr";

/// `cargo xtask gallery`.
#[derive(Args, Debug)]
pub struct GalleryArgs {
    /// Which of the two pictures.
    #[arg(value_enum)]
    what: What,
    /// The folder of scenes that people have.
    #[arg(long, default_value = "../shared/scenes")]
    scenes: PathBuf,
    /// Seconds for each picture.
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Pixels across a picture.
    #[arg(long, default_value_t = 256)]
    size: u32,
    /// As `midway render --device`.
    #[arg(long, default_value = "auto")]
    device: String,
    /// The picture to write.
    #[arg(short, long)]
    output: PathBuf,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum What {
    /// The boxes by every integrator.
    Integrators,
    /// Scenes that people have, and sheets of materials and lights.
    Scenes,
}

/// Renders and writes the gallery.
///
/// # Errors
/// If a scene cannot be read, the device fails, or the picture cannot be written.
pub fn run(args: &GalleryArgs) -> Result<()> {
    let device = open_device(&args.device, &OpenOptions::default())?;
    let rows = match args.what {
        What::Integrators => boxes(&device, args)?,
        What::Scenes => others(&device, args)?,
    };
    let (size, seconds) = (args.size, args.seconds);
    let title = format!("{size} pixels across, {seconds} s each on {}", device.info().name);
    Sheet { title, rows }.write(&args.output, Display::default())?;
    println!("written: {}", args.output.display());
    Ok(())
}

fn boxes(device: &Arc<dyn Device>, args: &GalleryArgs) -> Result<Vec<Vec<Cell>>> {
    let row = |name: &str| {
        let path = Path::new("scenes").join(name).with_extension("gltf");
        let scene = midway_import::load(&path)?.scene;
        let cells = integrators().into_iter();
        cells
            .map(|(label, integrator)| render(device, &scene, args, label, integrator, args.size))
            .collect::<Result<Vec<_>>>()
            .with_context(|| path.display().to_string())
    };
    BOXES.into_iter().map(row).collect()
}

/// Two to a row, those left out that are not there.
fn others(device: &Arc<dyn Device>, args: &GalleryArgs) -> Result<Vec<Vec<Cell>>> {
    let far = OTHERS.map(|(label, file, stops)| (label, args.scenes.join(file), stops));
    let near = SHEETS.map(|(label, file, stops)| (label, PathBuf::from(file), stops));
    let mut cells = Vec::new();
    let mut add = |label: &str, scene: &Scene, stops: f32| -> Result<()> {
        let bdpt = IntegratorSettings { integrator: Integrator::Bdpt, ..IntegratorSettings::default() };
        let mut cell = render(device, scene, args, label, bdpt, args.size * 3 / 4)?;
        cell.image.pixels.as_flattened_mut().iter_mut().for_each(|value| *value *= stops.exp2());
        cells.push(cell);
        Ok(())
    };
    for (label, path, stops) in far.into_iter().chain(near) {
        if path.is_file() {
            add(label, &midway_import::load(&path)?.scene, stops)
                .with_context(|| path.display().to_string())?;
        } else {
            println!("left out: {} is not there", path.display());
        }
    }
    add("materials under a sky", &under_sky(midway_import::load(SHEETS[0].1.as_ref())?.scene)?, 0.0)?;
    let mut rows = Vec::new();
    while !cells.is_empty() {
        let rest = cells.split_off(cells.len().min(2));
        rows.push(std::mem::replace(&mut cells, rest));
    }
    Ok(rows)
}

/// The scene without its lamps, lit by an environment.
fn under_sky(mut scene: Scene) -> Result<Scene> {
    for material in scene.materials.iter_mut().filter(|m| m.name == "lamp" || m.name == "strip") {
        (material.emission, material.surface) = (Vec3::ZERO.into(), Surface::Null);
    }
    let (image, _) = midway_import::load_environment(SKY.as_ref())?;
    let index = scene.images.len() as u32;
    scene.environment =
        Some(Environment { radiance: Vec3::ONE, image: Some(index), world_from_environment: Mat3::IDENTITY });
    scene.images.push(image);
    Ok(scene)
}

/// What each column shows.
fn integrators() -> Vec<(&'static str, IntegratorSettings)> {
    let plain = |integrator| IntegratorSettings { integrator, ..IntegratorSettings::default() };
    let bdpt = |join| IntegratorSettings { join, ..plain(Integrator::Bdpt) };
    vec![
        ("path-naive", plain(Integrator::PathNaive)),
        ("path", plain(Integrator::Path)),
        ("light", plain(Integrator::Light)),
        ("bdpt full", bdpt(Join::Full)),
        ("bdpt k-step, K = 3", bdpt(Join::KStep)),
        ("bdpt single-step", bdpt(Join::SingleStep)),
        (
            "bdpt k-step, K = 3, pool",
            IntegratorSettings { light_paths: LightPaths::Pool(None), ..bdpt(Join::KStep) },
        ),
    ]
}

fn render(
    device: &Arc<dyn Device>,
    scene: &Scene,
    args: &GalleryArgs,
    label: &str,
    integrator: IntegratorSettings,
    height: u32,
) -> Result<Cell> {
    let settings = RenderSettings { width: args.size, height, integrator, ..RenderSettings::default() };
    let mut renderer = Renderer::new(device.clone(), scene, &scene.cameras[0], settings)?;
    let limit = Duration::try_from_secs_f64(args.seconds)?;
    let start = Instant::now();
    while renderer.samples() == 0 || start.elapsed() < limit {
        renderer.step(u64::from(u32::MAX))?;
    }
    let caption = format!("{label}: {} spp", renderer.samples());
    println!("{caption}");
    Ok(Cell { caption, image: renderer.image()? })
}
