//! The pyramid of strategies: for each path length, what each (s, t) finds, raw and weighted.
//!
//! Raw, all strategies of a row that reach the same light show the same image; weighted, a row's
//! images add up to what paths of that length contribute.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use anyhow::{Context, Result, ensure};
use clap::Args;
use midway_device::{Device, OpenOptions, open_device};
use midway_film::{Display, Image, Metadata, write_exr};
use midway_render::{Integrator, IntegratorSettings, OneStrategy, RenderSettings, Renderer};
use midway_scene::Scene;

use crate::sheet::{Cell, Sheet};

/// `cargo xtask pyramid`.
#[derive(Args, Debug)]
pub struct PyramidArgs {
    /// The scene.
    scene: PathBuf,
    /// Vertices s + t of the longest paths.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(2..=32))]
    max_vertices: u32,
    /// The folder to write to.
    #[arg(short, long, default_value = "out/pyramid")]
    output: PathBuf,
    /// Samples a pixel of each image.
    #[arg(long, default_value_t = 64)]
    spp: u64,
    /// Pixels along each side.
    #[arg(long, default_value_t = 128)]
    size: u32,
    /// As `midway render --device`.
    #[arg(long, default_value = "auto")]
    device: String,
    /// Brightens the sheets by this many stops.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    exposure: f32,
}

/// What a pyramid is rendered with.
struct Job<'a> {
    args: &'a PyramidArgs,
    device: Arc<dyn Device>,
    scene: Scene,
}

/// Renders every strategy alone, writes the images and two sheets, and prints the means.
///
/// # Errors
/// If the scene cannot be read, the device fails, or a file cannot be written.
pub fn run(args: &PyramidArgs) -> Result<()> {
    let scene = midway_import::load(&args.scene)?.scene;
    let device = open_device(&args.device, &OpenOptions::default())?;
    fs::create_dir_all(&args.output).with_context(|| args.output.display().to_string())?;
    let job = Job { args, device, scene };
    let (mut raw_rows, mut weighted_rows) = (Vec::new(), Vec::new());
    println!("{:>3} {:>3} {:>12} {:>12}", "s", "t", "raw", "weighted");
    let mut total = 0.0;
    for n_vertices in 2..=args.max_vertices {
        let (mut raw_cells, mut weighted_cells) = (Vec::new(), Vec::new());
        for (s, t) in strategies(n_vertices) {
            let (raw, weighted) = (job.cell(s, t, true)?, job.cell(s, t, false)?);
            let means = [&raw, &weighted].map(|cell| mean_luminance(&cell.image));
            println!("{s:>3} {t:>3} {:>12.6} {:>12.6}", means[0], means[1]);
            total += means[1];
            raw_cells.push(raw);
            weighted_cells.push(weighted);
        }
        raw_rows.push(raw_cells);
        weighted_rows.push(weighted_cells);
    }
    let whole = mean_luminance(&job.render(None)?);
    println!("weighted, all strategies: {total:.6}; rendered together: {whole:.6}");
    job.write_sheet("raw", raw_rows)?;
    job.write_sheet("weighted", weighted_rows)
}

/// The strategies of `bdpt` with this many vertices: (1, 1), a light seen directly, is left to s = 0.
fn strategies(n_vertices: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..n_vertices).map(move |s| (s, n_vertices - s)).filter(|pair| *pair != (1, 1))
}

impl Job<'_> {
    fn cell(&self, s: u32, t: u32, raw: bool) -> Result<Cell> {
        let image = self.render(Some(OneStrategy { s, t, raw }))?;
        let caption = format!("s={s} t={t}");
        let name = format!("s{s}t{t}-{}.exr", if raw { "raw" } else { "weighted" });
        let mut metadata = Metadata::new();
        metadata.set("strategy", caption.as_str());
        write_exr(&self.args.output.join(name), &image, None, &metadata)?;
        Ok(Cell { caption, image })
    }

    fn render(&self, one_strategy: Option<OneStrategy>) -> Result<Image> {
        let settings = RenderSettings {
            width: self.args.size,
            height: self.args.size,
            integrator: IntegratorSettings { integrator: Integrator::Bdpt, ..IntegratorSettings::default() },
            max_path_length: Some(self.args.max_vertices - 1),
            one_strategy,
            ..RenderSettings::default()
        };
        let mut renderer = Renderer::new(self.device.clone(), &self.scene, &self.scene.cameras[0], settings)?;
        while renderer.samples() < self.args.spp {
            renderer.step(self.args.spp - renderer.samples())?;
        }
        let stats = renderer.stats()?;
        ensure!(stats.rejected == 0, "{} contributions were rejected: {one_strategy:?}", stats.rejected);
        Ok(renderer.image()?)
    }

    fn write_sheet(&self, name: &str, rows: Vec<Vec<Cell>>) -> Result<()> {
        let scene = self.args.scene.file_stem().unwrap_or_default().to_string_lossy();
        let path: &Path = &self.args.output.join(name).with_extension("png");
        let display = Display { exposure: self.args.exposure, ..Display::default() };
        Sheet { title: format!("{scene}, {name}"), rows }.write(path, display)?;
        println!("written: {}", path.display());
        Ok(())
    }
}

fn mean_luminance(image: &Image) -> f64 {
    let [r, g, b] = image.mean();
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_every_strategy_of_its_length() {
        assert_eq!(strategies(2).collect::<Vec<_>>(), [(0, 2)]);
        assert_eq!(strategies(4).collect::<Vec<_>>(), [(0, 4), (1, 3), (2, 2), (3, 1)]);
    }
}
