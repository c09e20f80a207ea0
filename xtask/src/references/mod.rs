//! Pictures that other renderers made of scenes that people have, and ours of the same.

mod blocks;
mod cases;

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use glam::Vec3;
use midway_device::{Device, OpenOptions, open_device};
use midway_film::{ExrFile, Image, Metadata, write_exr};
use midway_render::{Integrator, IntegratorSettings, RenderSettings, Renderer};
use midway_scene::{ConductorFresnel, Image as Texture, Scene, Surface, Texels};

use self::{
    blocks::{Ratios, ratios},
    cases::{CASES, Case, File, IGNIS, IGNIS_BOX, Metal},
};

/// `cargo xtask references`.
#[derive(Args, Debug)]
pub struct ReferencesArgs {
    /// The folder of scenes.
    #[arg(long, default_value = "../shared/scenes")]
    scenes: PathBuf,
    /// Only those whose name has this in it.
    #[arg(long)]
    only: Option<String>,
    /// Samples a pixel.
    #[arg(long, default_value_t = 64)]
    spp: u64,
    /// Seconds for each picture, if that is sooner.
    #[arg(long)]
    seconds: Option<f64>,
    /// What finds the light.
    #[arg(long, value_enum, default_value_t = Finder::Path)]
    integrator: Finder,
    /// As `midway render --device`.
    #[arg(long, default_value = "auto")]
    device: String,
    /// Write our pictures into this folder.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

/// The integrators that reach all light of these scenes.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Finder {
    Path,
    Bdpt,
}

/// Renders every scene that is there and prints how it compares. Whether each is as near as claimed.
///
/// # Errors
/// If a scene or its picture cannot be read, or the device fails.
pub fn run(args: &ReferencesArgs) -> Result<bool> {
    if !args.scenes.is_dir() {
        println!("not run: there is no folder {}", args.scenes.display());
        return Ok(true);
    }
    let device = open_device(&args.device, &OpenOptions::default())?;
    println!("{}, {:?}, at most {} samples a pixel", device.info().name, args.integrator, args.spp);
    println!("blocks of 16 x 16 pixels, ours by theirs, of the channel that is farthest off");
    println!("{:<28} {:>8} {:>8} {:>8} {:>7} {:>12}", "scene", "p10", "median", "p90", "spp", "claim");
    let mut all_near = true;
    let chosen = |case: &&Case| args.only.as_ref().is_none_or(|part| case.name.contains(part.as_str()));
    for case in CASES.iter().filter(chosen) {
        all_near &= compare(args, &device, case).with_context(|| case.name)?;
    }
    Ok(all_near)
}

/// Prints a row. Whether the claim holds.
fn compare(args: &ReferencesArgs, device: &Arc<dyn Device>, case: &Case) -> Result<bool> {
    let path = args.scenes.join(case.reference);
    if !path.is_file() {
        println!("{:<28} not run: {} is not there", case.name, path.display());
        return Ok(true);
    }
    let theirs = ExrFile::read(&path)?.image()?;
    let scene = load(&args.scenes, &case.file)?;
    let (ours, spp) = render(args, device, &scene, case, theirs.size())?;
    if let Some(folder) = &args.output {
        fs::create_dir_all(folder)?;
        let path = folder.join(case.name.replace('/', "-")).with_extension("exr");
        write_exr(&path, &ours, None, &Metadata::new())?;
    }
    let Ratios { p10, median, p90 } = ratios(&ours, &theirs)?;
    let (holds, claim) = match case.claim {
        Ok(tolerance) => {
            let holds = (median - 1.0).abs() <= tolerance;
            (holds, format!("{} % {}", tolerance * 100.0, if holds { "holds" } else { "FAILS" }))
        }
        Err(why) => (true, why.to_owned()),
    };
    println!("{:<28} {p10:>8.4} {median:>8.4} {p90:>8.4} {spp:>7} {claim:>12}", case.name);
    Ok(holds)
}

/// Ignis' scenes name meshes in two folders, one of them outside of their own, where no importer of
/// ours looks: they are read from a copy that has both in it.
fn load(scenes: &Path, file: &File) -> Result<Scene> {
    let ignis = scenes.join(IGNIS);
    let text = match file {
        File::At(path) => return Ok(midway_import::load(&scenes.join(path))?.scene),
        File::WithMetals(path, metal) => {
            let mut scene = midway_import::load(&scenes.join(path))?.scene;
            put_back(&mut scene, metal);
            return Ok(scene);
        }
        File::Ignis(name) => {
            let path = ignis.join("evaluation/mitsuba").join(name).with_extension("xml");
            fs::read_to_string(path)?.replace("../meshes/", "outer/")
        }
        File::IgnisBox => IGNIS_BOX.to_owned(),
    };
    let copy = std::env::temp_dir().join(format!("midway-references-{}", std::process::id()));
    copy_folder(&ignis.join("meshes"), &copy.join("outer"))?;
    copy_folder(&ignis.join("evaluation/meshes"), &copy.join("meshes"))?;
    fs::write(copy.join("scene.xml"), text)?;
    let loaded = midway_import::load(&copy.join("scene.xml"));
    fs::remove_dir_all(&copy)?;
    Ok(loaded?.scene)
}

/// Makes every metal by Schlick's approximation one by `metal` and of single bounces, with the same
/// reflectance at normal incidence. What divides it is put into the texels where there are any: a tint is at most 1.
fn put_back(scene: &mut Scene, metal: &Metal) {
    let (eta, k) = (Vec3::from_array(metal.eta), Vec3::from_array(metal.k));
    let (lower, upper) = (eta - Vec3::ONE, eta + Vec3::ONE);
    let f0 = (lower * lower + k * k) / (upper * upper + k * k);
    for material in &mut scene.materials {
        let Surface::Conductor { fresnel, roughness } = &mut material.surface else { continue };
        let ConductorFresnel::Schlick { f0: seen } = fresnel else { continue };
        let mut tint = seen.clone();
        match &mut tint.texture {
            Some(texture) => {
                let image = divided(&scene.images[texture.image as usize], f0);
                texture.image = scene.images.len() as u32;
                scene.images.push(image);
            }
            None => tint.value = (tint.value / f0).min(Vec3::ONE),
        }
        *fresnel = ConductorFresnel::Complex { eta, k, tint };
        roughness.single_bounce = true;
    }
}

fn divided(image: &Texture, by: Vec3) -> Texture {
    let texel = |index| {
        let [r, g, b, a] = image.texels.linear(index);
        let rgb = (Vec3::new(r, g, b) / by).min(Vec3::ONE);
        [rgb.x, rgb.y, rgb.z, a]
    };
    Texture { texels: Texels::Float((0..image.texels.len()).map(texel).collect()), ..image.clone() }
}

fn copy_folder(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from).with_context(|| from.display().to_string())? {
        let entry = entry?;
        fs::write(to.join(entry.file_name()), fs::read(entry.path())?)?;
    }
    Ok(())
}

fn render(
    args: &ReferencesArgs,
    device: &Arc<dyn Device>,
    scene: &Scene,
    case: &Case,
    [width, height]: [usize; 2],
) -> Result<(Image, u64)> {
    let integrator = match args.integrator {
        Finder::Path => Integrator::Path,
        Finder::Bdpt => Integrator::Bdpt,
    };
    let settings = RenderSettings {
        width: width as u32,
        height: height as u32,
        integrator: IntegratorSettings { integrator, ..IntegratorSettings::default() },
        max_path_length: case.longest,
        ..RenderSettings::default()
    };
    let limit = args.seconds.map(Duration::try_from_secs_f64).transpose()?;
    let mut renderer = Renderer::new(device.clone(), scene, &scene.cameras[0], settings)?;
    let start = Instant::now();
    while renderer.samples() < args.spp && limit.is_none_or(|limit| start.elapsed() < limit) {
        renderer.step(args.spp - renderer.samples())?;
    }
    Ok((renderer.image()?, renderer.samples()))
}
