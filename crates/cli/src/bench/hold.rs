//! `midway bench hold`: frame times, K and resolution while the camera moves and the renderer holds a
//! target.

use std::time::{Duration, Instant};

use glam::{Mat4, Vec3};
use midway_render::{Hold, HoldLimits, Integrator, IntegratorSettings, Join, Load, RenderSettings};
use midway_scene::{Camera, Scene};
use serde_json::json;

use super::measured::{Bench, failure, finish, open};
use crate::{args::HoldArgs, console, status::Outcome};

/// The K wanted where there is time for it, and samples of a frame at most.
const MOST_K: u32 = 16;
const MOST_SAMPLES: u32 = 64;
/// Of each side, where the whole film takes too long by K = 1.
const LEAST_SCALE: f32 = 0.125;
/// Of the picture's height or width that the camera moves through, and how many times a minute.
const SWAY: f32 = 0.1;
const TURNS_PER_SECOND: f32 = 0.1;

/// One frame.
struct Frame {
    at: f64,
    seconds: f64,
    k: u32,
    samples: u32,
    scale: f32,
}

/// Moves the camera for the time asked for.
///
/// # Errors
/// As the scene or the device says.
pub fn run(args: &HoldArgs) -> Outcome {
    let device = open(&args.device)?;
    let bench = Bench::load(&device, &args.scene, &args.root, args.size.size())?;
    let frames = frames(&bench, args)?;
    let mut times: Vec<f64> = frames.iter().map(|frame| frame.seconds * 1e3).collect();
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
    let ks = frames.iter().map(|frame| frame.k);
    let (least, most) = (ks.clone().min().unwrap_or(0), ks.max().unwrap_or(0));
    let scales = frames.iter().map(|frame| frame.scale);
    let (smallest, largest) = (scales.clone().fold(1.0, f32::min), scales.fold(0.0, f32::max));
    console::note(&format!(
        "{} frames in {:?}: median {:.2} ms, p99 {:.2} ms, longest {:.2} ms, target {} ms; K {least} to {most}, scale {smallest} to {largest}",
        frames.len(),
        args.time,
        at(0.5),
        at(0.99),
        at(1.0),
        args.ms
    ));
    let rows = frames
        .iter()
        .map(|f| json!({ "at": f.at, "ms": f.seconds * 1e3, "k": f.k, "samples": f.samples, "scale": f.scale }))
        .chain([
            json!({ "median_ms": at(0.5), "p99_ms": at(0.99), "longest_ms": at(1.0), "target_ms": args.ms }),
        ]);
    finish(args.json, &*device, rows.collect())
}

fn frames(bench: &Bench, args: &HoldArgs) -> Outcome<Vec<Frame>> {
    let k_step =
        IntegratorSettings { integrator: Integrator::Bdpt, join: Join::KStep, k: 1, ..Default::default() };
    let whole = bench.settings(k_step);
    let mut renderer = bench.renderer(whole.clone())?;
    let mut hold = Hold::new(HoldLimits {
        target: Duration::from_secs_f32(args.ms * 1e-3),
        least_k: 1,
        most_k: MOST_K,
        most_samples: MOST_SAMPLES,
        least_scale: LEAST_SCALE,
    });
    let (start, mut frames) = (Instant::now(), Vec::new());
    while start.elapsed() < args.time {
        let at = start.elapsed().as_secs_f64();
        let (load, begin) = (hold.load(), Instant::now());
        let side = |pixels: u32| ((pixels as f32 * load.scale) as u32).max(1);
        let mut settings =
            RenderSettings { width: side(whole.width), height: side(whole.height), ..whole.clone() };
        settings.integrator.k = load.k;
        renderer.set_settings(settings).map_err(failure)?;
        renderer
            .set_camera(bench.scene(), &swayed(bench.scene(), bench.camera(), at as f32))
            .map_err(failure)?;
        while renderer.samples() < u64::from(load.samples) {
            renderer.step(u64::from(load.samples) - renderer.samples()).map_err(failure)?;
        }
        renderer.image().map_err(failure)?;
        let seconds = begin.elapsed();
        hold.observe(load, seconds);
        let Load { k, samples, scale } = load;
        frames.push(Frame { at, seconds: seconds.as_secs_f64(), k, samples, scale });
    }
    Ok(frames)
}

/// The camera on an ellipse about its place, across its view.
fn swayed(scene: &Scene, camera: &Camera, seconds: f32) -> Camera {
    let radius = SWAY * scene.bounds().diagonal().length() * 0.5;
    let angle = std::f32::consts::TAU * TURNS_PER_SECOND * seconds;
    let offset = Vec3::new(radius * angle.cos(), 0.5 * radius * angle.sin(), 0.0);
    Camera { world_from_camera: camera.world_from_camera * Mat4::from_translation(offset), ..camera.clone() }
}
