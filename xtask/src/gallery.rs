//! The gallery: every scene of the project by every integrator, each for the same time.

use std::{
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use clap::Args;
use midway_device::{Device, OpenOptions, open_device};
use midway_film::Display;
use midway_render::{Integrator, IntegratorSettings, Join, LightPaths, RenderSettings, Renderer};
use midway_scene::Scene;

use crate::sheet::{Cell, Sheet};

/// The scenes, in the order of the rows.
const SCENES: [&str; 3] = ["cornell-box", "glass-caustic", "lamp"];

/// `cargo xtask gallery`.
#[derive(Args, Debug)]
pub struct GalleryArgs {
    /// Seconds for each picture.
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Pixels along each side of a picture.
    #[arg(long, default_value_t = 256)]
    size: u32,
    /// As `midway render --device`.
    #[arg(long, default_value = "auto")]
    device: String,
    /// The picture to write.
    #[arg(short, long, default_value = "docs/gallery.png")]
    output: PathBuf,
}

/// Renders and writes the gallery.
///
/// # Errors
/// If a scene cannot be read, the device fails, or the picture cannot be written.
pub fn run(args: &GalleryArgs) -> Result<()> {
    let device = open_device(&args.device, &OpenOptions::default())?;
    let mut rows = Vec::new();
    for name in SCENES {
        let path = PathBuf::from("scenes").join(name).with_extension("gltf");
        let scene = midway_import::load(&path)?.scene;
        let cells = integrators()
            .into_iter()
            .map(|(label, integrator)| render(&device, &scene, args, label, integrator))
            .collect::<Result<Vec<_>>>()
            .with_context(|| path.display().to_string())?;
        rows.push(cells);
    }
    let (size, seconds) = (args.size, args.seconds);
    let title = format!("{size} x {size} pixels, {seconds} s each on {}", device.info().name);
    Sheet { title, rows }.write(&args.output, Display::default())?;
    println!("written: {}", args.output.display());
    Ok(())
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
) -> Result<Cell> {
    let settings =
        RenderSettings { width: args.size, height: args.size, integrator, ..RenderSettings::default() };
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
