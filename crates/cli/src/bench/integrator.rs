//! `midway bench integrator`: the time of each kernel, and rays a second over all of them.

use midway_device::DeviceKind;
use serde_json::{Value, json};

use super::{
    equal_time::integrators,
    measured::{Bench, Until, failure, finish, open, run_until},
};
use crate::{args::IntegratorBenchArgs, console, status::Outcome};

/// Measures each scene.
///
/// # Errors
/// As the scene or the device says.
pub fn run(args: &IntegratorBenchArgs) -> Outcome {
    let device = open(&args.device)?;
    if device.info().kind == DeviceKind::Cpu {
        console::note("kernels' times add up over threads");
    }
    let mut rows = Vec::new();
    for path in &args.scenes {
        let bench = Bench::load(&device, path, args.size.size())?;
        console::note(&format!("scene: {}", bench.name));
        for (name, integrator) in integrators() {
            if args.only.iter().any(|one| one == name) {
                rows.push(measure(&bench, name, bench.settings(integrator), args.spp)?);
            }
        }
    }
    finish(args.json, &*device, rows)
}

/// Twice the same samples: first for their time, then kernel by kernel, since timestamps cost some.
fn measure(bench: &Bench, name: &str, settings: midway_render::RenderSettings, spp: u64) -> Outcome<Value> {
    let mut renderer = bench.renderer(settings)?;
    renderer.restart().map_err(failure)?;
    let before = renderer.stats().map_err(failure)?.rays;
    let wall = run_until(&mut renderer, Until::Samples(spp))?;
    let rays = renderer.stats().map_err(failure)?.rays - before;
    renderer.restart().map_err(failure)?;
    renderer.time_kernels();
    run_until(&mut renderer, Until::Samples(spp))?;
    let times = renderer.kernel_times();
    let kernels: f64 = times.values().map(|time| time.as_secs_f64()).sum();
    let rate = |seconds: f64| if seconds > 0.0 { rays as f64 * 1e-6 / seconds } else { 0.0 };
    let traversal: f64 = ["trace_closest", "trace_shadow"]
        .iter()
        .filter_map(|kernel| times.get(kernel))
        .map(|time| time.as_secs_f64())
        .sum();
    console::note(&format!(
        "{name}: {:.1} Mrays/s by the clock, {:.1} over all kernels, {:.1} while tracing",
        rate(wall.as_secs_f64()),
        rate(kernels),
        rate(traversal)
    ));
    for (kernel, time) in &times {
        let share = 100.0 * time.as_secs_f64() / kernels.max(f64::MIN_POSITIVE);
        console::note(&format!("  {kernel:<18} {:>10.3} ms {share:>5.1} %", time.as_secs_f64() * 1e3));
    }
    let milliseconds: serde_json::Map<String, Value> =
        times.iter().map(|(kernel, time)| ((*kernel).to_owned(), json!(time.as_secs_f64() * 1e3))).collect();
    Ok(json!({
        "scene": bench.name, "integrator": name, "rays": rays, "seconds": wall.as_secs_f64(),
        "mrays_per_second": rate(wall.as_secs_f64()), "mrays_per_second_of_kernels": rate(kernels),
        "mrays_per_second_tracing": rate(traversal), "kernel_ms": milliseconds,
    }))
}
