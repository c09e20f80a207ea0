//! What most measurements share: a scene on a device, and images of it by two seeds.

use std::{
    path::Path,
    sync::Arc,
    time::{Duration, Instant},
};

use midway_device::{Device, OpenOptions, open_device};
use midway_film::{HalfError, Image, half_error};
use midway_render::{Choice, IntegratorSettings, RenderError, RenderSettings, Renderer, Rng};
use midway_scene::{Camera, Scene};
use serde_json::{Value, json};

use crate::{
    args::{BenchDevice, RootArg},
    console, scene_file,
    status::{Failure, OrStatus, Outcome, Status},
};

/// Of the two images.
pub const SEEDS: [u32; 2] = [1, 2];

/// When an image is done.
#[derive(Clone, Copy, Debug)]
pub enum Until {
    /// At the pass whose end is nearest to it.
    Time(Duration),
    /// After this many samples of each pixel.
    Samples(u64),
    /// At the sample after which the number of rays is nearest to this.
    Rays(u64),
}

/// A scene to be measured.
pub struct Bench {
    /// The file's name without its ending.
    pub name: String,
    device: Arc<dyn Device>,
    /// Its first camera is looked through.
    scene: Scene,
    size: [u32; 2],
}

/// The mean of two images' figures, and the error that one of them is expected to have.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Of each pixel.
    pub samples: f64,
    /// Spent in passes.
    pub seconds: f64,
    /// Traced.
    pub rays: f64,
    /// From the two images.
    pub error: HalfError,
    /// Mean of all channels.
    pub mean: f64,
    /// Half of what the two images' means differ by.
    pub mean_error: f64,
    /// Bytes on the device, all of them.
    pub bytes: u64,
    /// The first of the two.
    pub image: Image,
}

/// Opens the device and names it.
///
/// # Errors
/// [`Status::Device`].
pub fn open(args: &BenchDevice) -> Outcome<Arc<dyn Device>> {
    let options = OpenOptions { threads: args.threads.map(|n| n as usize), ..OpenOptions::default() };
    let device = open_device(&args.device, &options).or_status(Status::Device)?;
    console::note(&format!("device: {} ({})", device.info().name, device.info().backend));
    Ok(device)
}

impl Bench {
    /// Reads a scene file.
    ///
    /// # Errors
    /// [`Status::Input`].
    pub fn load(device: &Arc<dyn Device>, path: &Path, root: &RootArg, size: [u32; 2]) -> Outcome<Self> {
        let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Self::of(device, name, scene_file::load(path, root)?.scene, size)
    }

    /// Takes a scene that was made in memory.
    ///
    /// # Errors
    /// [`Status::Input`] where it has no camera.
    pub fn of(device: &Arc<dyn Device>, name: String, scene: Scene, size: [u32; 2]) -> Outcome<Self> {
        if scene.cameras.is_empty() {
            return Err(Failure::new(Status::Input, format!("{name} has no camera")));
        }
        Ok(Self { name, device: device.clone(), scene, size })
    }

    /// The scene itself.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The camera that is looked through.
    pub fn camera(&self) -> &Camera {
        &self.scene.cameras[0]
    }

    /// An integrator's settings at the size of this measurement.
    pub fn settings(&self, integrator: IntegratorSettings) -> RenderSettings {
        let [width, height] = self.size;
        RenderSettings { width, height, integrator, rng: Rng::default(), ..RenderSettings::default() }
    }

    /// A renderer, everything compiled.
    ///
    /// # Errors
    /// As the renderer says.
    pub fn renderer(&self, settings: RenderSettings) -> Outcome<Renderer> {
        let mut renderer =
            Renderer::new(self.device.clone(), &self.scene, self.camera(), settings).map_err(failure)?;
        // The first pass on a GPU is small and slow: buffers are touched, batches find their size.
        renderer.step(1).map_err(failure)?;
        Ok(renderer)
    }

    /// What `auto` chooses.
    ///
    /// # Errors
    /// As the renderer says.
    pub fn choose(&self) -> Outcome<Choice> {
        let renderer = self.renderer(self.settings(IntegratorSettings::default()))?;
        midway_render::choose(&renderer).map_err(failure)
    }

    /// Renders two images.
    ///
    /// # Errors
    /// As the renderer says.
    pub fn measure(&self, settings: RenderSettings, until: Until) -> Outcome<Measured> {
        let mut renderer = self.renderer(settings)?;
        let (mut samples, mut seconds, before) = (0, Duration::ZERO, rays(&renderer)?);
        let mut image = |seed| {
            renderer.restart_with_seed(seed).map_err(failure)?;
            seconds += run_until(&mut renderer, until)?;
            samples += renderer.samples();
            renderer.image().map_err(failure)
        };
        let [a, b] = [image(SEEDS[0])?, image(SEEDS[1])?];
        let [mean_a, mean_b] = [&a, &b].map(|image| image.mean().iter().sum::<f64>() / 3.0);
        Ok(Measured {
            samples: samples as f64 / 2.0,
            seconds: seconds.as_secs_f64() / 2.0,
            rays: (rays(&renderer)? - before) as f64 / 2.0,
            error: half_error(&a, &b)?,
            mean: 0.5 * (mean_a + mean_b),
            mean_error: 0.5 * (mean_a - mean_b).abs(),
            bytes: renderer.plan().total(),
            image: a,
        })
    }
}

fn rays(renderer: &Renderer) -> Outcome<u64> {
    Ok(renderer.stats().map_err(failure)?.rays)
}

/// Renders passes until done; the time that they took.
///
/// # Errors
/// If the device fails.
pub fn run_until(renderer: &mut Renderer, until: Until) -> Outcome<Duration> {
    let (mut spent, before) = (Duration::ZERO, rays(renderer)?);
    let mut last = 0;
    loop {
        let most = match until {
            Until::Samples(n) => n - renderer.samples(),
            Until::Time(_) => u64::from(u32::MAX),
            Until::Rays(_) => 1,
        };
        let start = Instant::now();
        renderer.step(most).map_err(failure)?;
        let pass = start.elapsed();
        spent += pass;
        let done = match until {
            Until::Samples(n) => renderer.samples() >= n,
            Until::Time(limit) => spent + pass / 2 >= limit,
            Until::Rays(n) => {
                let traced = rays(renderer)? - before;
                let sample = traced - last;
                last = traced;
                traced + sample / 2 >= n
            }
        };
        if done {
            return Ok(spent);
        }
    }
}

impl Measured {
    /// Millions of rays a second.
    pub fn mrays_per_second(&self) -> f64 {
        self.rays * 1e-6 / self.seconds
    }

    /// A row for other programs, with `fields` before the figures.
    pub fn json(&self, fields: &Value) -> Value {
        let mut row = json!({
            "samples": self.samples, "seconds": self.seconds, "rays": self.rays,
            "mrays_per_second": self.mrays_per_second(),
            "rmse": self.error.rmse, "relmse": self.error.relmse,
            "relmse_trimmed": self.error.relmse_trimmed, "mean": self.mean, "mean_error": self.mean_error, "bytes": self.bytes,
        });
        if let (Some(row), Some(fields)) = (row.as_object_mut(), fields.as_object()) {
            row.extend(fields.clone());
        }
        row
    }

    /// A row for people.
    pub fn line(&self, what: &str) -> String {
        format!(
            "{what:<34} {:>8.0} samples {:>7.2} s {:>8.1} Mrays/s  RMSE {:.3e}  relMSE {:.3e}  trimmed {:.3e}",
            self.samples,
            self.seconds,
            self.mrays_per_second(),
            self.error.rmse,
            self.error.relmse,
            self.error.relmse_trimmed,
        )
    }
}

/// The exit code of each way in which a render can fail.
pub fn failure(error: RenderError) -> Failure {
    crate::render::failure(error)
}

/// That every name asked for is one of those that there are.
///
/// # Errors
/// [`Status::Usage`].
pub fn check_only(only: &[String], names: &[&str]) -> Outcome {
    match only.iter().find(|one| !names.contains(&one.as_str())) {
        Some(unknown) => Err(Failure::usage(format!("--only {unknown}: there is {}", names.join(", ")))),
        None => Ok(()),
    }
}

/// That something was measured, where words were asked for that rows have to contain.
///
/// # Errors
/// [`Status::Usage`].
pub fn check_measured(only: &[String], n_rows: usize) -> Outcome {
    if n_rows == 0 {
        return Err(Failure::usage(format!("--only {}: no row has all of these words", only.join(","))));
    }
    Ok(())
}

/// Prints a result as one JSON object where it was asked for.
///
/// # Errors
/// If standard output cannot take it.
pub fn finish(json: bool, device: &dyn Device, rows: Vec<Value>) -> Outcome {
    if !json {
        return Ok(());
    }
    let info = device.info();
    console::output(&json!({ "device": info.name, "backend": info.backend, "rows": rows }).to_string())
}
