//! `midway bench baseline`: `bdpt` (join `full`) as the renderer does it, in queues and small kernels, beside
//! its plainest form, one kernel with a thread for each sample.

use std::time::{Duration, Instant};

use midway_render::{Integrator, IntegratorSettings, Megakernel, Renderer};
use serde_json::{Value, json};

use super::measured::{Bench, SEEDS, Until, failure, finish, open, run_until};
use crate::{args::BaselineArgs, console, status::Outcome};

/// Measures each scene.
///
/// # Errors
/// As the scene or the device says.
pub fn run(args: &BaselineArgs) -> Outcome {
    let device = open(&args.device)?;
    let mut rows = Vec::new();
    for path in &args.scenes {
        let bench = Bench::load(&device, path, &args.root, args.size.size())?;
        console::note(&format!("scene: {}", bench.name));
        rows.push(measure(&bench, args)?);
    }
    finish(args.json, &*device, rows)
}

/// Both render the same samples in turn, again and again, so that a machine's mood is in both.
fn measure(bench: &Bench, args: &BaselineArgs) -> Outcome<Value> {
    let full = IntegratorSettings { integrator: Integrator::Bdpt, ..IntegratorSettings::default() };
    let mut renderer = bench.renderer(bench.settings(full))?;
    let start = Instant::now();
    let mut kernel = renderer.megakernel().map_err(failure)?;
    let compiled = start.elapsed().as_secs_f64();
    console::note(&format!("the one kernel is compiled and has its memory after {compiled:.1} s"));
    let rays = [count_queues(&mut renderer, args.spp)?, count_one_kernel(&mut kernel, args.spp)?];
    let ratio = mean_ratio(&renderer, &kernel)?;
    time_one_kernel(&mut kernel, args.spp)?; // launches find their size
    let (mut by_queues, mut by_one_kernel) = (Vec::new(), Vec::new());
    for _ in 0..args.rounds {
        by_queues.push(time_queues(&mut renderer, args.spp)?);
        by_one_kernel.push(time_one_kernel(&mut kernel, args.spp)?);
    }
    let n_samples = u64::from(args.size.width) * u64::from(args.size.height) * u64::from(args.spp);
    let queues = Rate { n_samples, rays: rays[0], seconds: median(by_queues) };
    let one_kernel = Rate { n_samples, rays: rays[1], seconds: median(by_one_kernel) };
    let faster = one_kernel.seconds / queues.seconds;
    console::note(&queues.line("queues"));
    console::note(&one_kernel.line("one kernel"));
    console::note(&format!(
        "queues are {faster:.3} x as fast; the images' means are {ratio:.6} x each other's"
    ));
    Ok(json!({
        "scene": bench.name, "samples": args.spp, "rounds": args.rounds, "queues": queues.json(),
        "one_kernel": one_kernel.json(), "one_kernel_ready_seconds": compiled, "speed_ratio": faster,
        "mean_ratio": ratio,
    }))
}

/// What took how long.
struct Rate {
    /// Each a light path and a camera path.
    n_samples: u64,
    rays: u64,
    seconds: f64,
}

impl Rate {
    fn msamples_per_second(&self) -> f64 {
        self.n_samples as f64 * 1e-6 / self.seconds
    }

    fn mrays_per_second(&self) -> f64 {
        self.rays as f64 * 1e-6 / self.seconds
    }

    fn line(&self, what: &str) -> String {
        format!(
            "{what:<12} {:>8.3} s {:>8.2} Msamples/s {:>8.1} Mrays/s {:>6.2} rays a sample",
            self.seconds,
            self.msamples_per_second(),
            self.mrays_per_second(),
            self.rays as f64 / self.n_samples as f64
        )
    }

    fn json(&self) -> Value {
        json!({
            "seconds": self.seconds, "rays": self.rays, "msamples_per_second": self.msamples_per_second(),
            "mrays_per_second": self.mrays_per_second(),
        })
    }
}

fn time_queues(renderer: &mut Renderer, samples: u32) -> Outcome<Duration> {
    renderer.restart_with_seed(SEEDS[0]).map_err(failure)?;
    run_until(renderer, Until::Samples(samples.into()))
}

fn time_one_kernel(kernel: &mut Megakernel, samples: u32) -> Outcome<Duration> {
    kernel.restart_with_seed(SEEDS[0]).map_err(failure)?;
    let start = Instant::now();
    kernel.render(samples).map_err(failure)?;
    Ok(start.elapsed())
}

fn count_queues(renderer: &mut Renderer, samples: u32) -> Outcome<u64> {
    let before = renderer.stats().map_err(failure)?.rays;
    time_queues(renderer, samples)?;
    Ok(renderer.stats().map_err(failure)?.rays - before)
}

fn count_one_kernel(kernel: &mut Megakernel, samples: u32) -> Outcome<u64> {
    kernel.count_rays(true);
    time_one_kernel(kernel, samples)?;
    kernel.count_rays(false);
    Ok(kernel.totals().map_err(failure)?.rays)
}

/// Of the images that hold the same samples.
fn mean_ratio(renderer: &Renderer, kernel: &Megakernel) -> Outcome<f64> {
    let sum = |mean: [f64; 3]| mean.iter().sum::<f64>();
    let [one_kernel, queues] = [kernel.image(), renderer.image()].map(|image| image.map_err(failure));
    Ok(sum(one_kernel?.mean()) / sum(queues?.mean()))
}

fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    times[times.len() / 2].as_secs_f64() // at least one round
}
