//! `midway bench integrator`: the time of each kernel, and rays a second over all of them, beside those of the
//! same rays traced with nothing between.

use std::time::Duration;

use midway_device::DeviceKind;
use midway_render::{KernelTime, RenderSettings, Renderer, rays::replay};
use serde_json::{Value, json};

use super::{
    equal_time::integrators,
    measured::{Bench, Until, check_only, failure, finish, open, run_until},
};
use crate::{args::IntegratorBenchArgs, console, status::Outcome};

/// Measures each scene.
///
/// # Errors
/// As the scene or the device says.
pub fn run(args: &IntegratorBenchArgs) -> Outcome {
    check_only(&args.only, &integrators().iter().map(|(name, _)| *name).collect::<Vec<_>>())?;
    let device = open(&args.device)?;
    if device.info().kind == DeviceKind::Cpu {
        console::note("kernels' times add up over threads");
    }
    let mut rows = Vec::new();
    for path in &args.scenes {
        let bench = Bench::load(&device, path, &args.root, args.size.size())?;
        console::note(&format!("scene: {}", bench.name));
        for (name, integrator) in integrators() {
            if args.only.iter().any(|one| one == name) {
                rows.push(measure(&bench, name, bench.settings(integrator), args.spp)?);
            }
        }
    }
    finish(args.json, &*device, rows)
}

/// Twice the same samples: first for their time, then kernel by kernel, since timestamps cost some. Last the
/// rays of a sample of each pixel, bare.
fn measure(bench: &Bench, name: &str, settings: RenderSettings, spp: u64) -> Outcome<Value> {
    let has_pool = settings.integrator.uses_pool();
    let mut renderer = bench.renderer(settings)?;
    renderer.restart().map_err(failure)?;
    let before = renderer.stats().map_err(failure)?.rays;
    let wall = run_until(&mut renderer, Until::Samples(spp))?;
    let rays = renderer.stats().map_err(failure)?.rays - before;
    renderer.restart().map_err(failure)?;
    renderer.time_kernels();
    run_until(&mut renderer, Until::Samples(spp))?;
    let times = renderer.kernel_times();
    let seconds = |time: Duration| time.as_secs_f64();
    let kernels: f64 = times.values().map(|time| seconds(time.total)).sum();
    let rate = |seconds: f64| if seconds > 0.0 { rays as f64 * 1e-6 / seconds } else { 0.0 };
    let traversal: f64 = ["trace_closest", "trace_shadow"]
        .iter()
        .filter_map(|kernel| times.get(kernel))
        .map(|time| seconds(time.total))
        .sum();
    let longest = times.values().map(|time| seconds(time.longest)).fold(0.0, f64::max) * 1e3;
    let bare = if has_pool { None } else { Some(bare_rate(bench, &mut renderer)?) };
    let reached = bare.map(|bare| rate(seconds(wall)) / bare);
    let beside = match (bare, reached) {
        (Some(bare), Some(reached)) => format!("; its rays bare {bare:.1}, of which it reaches {reached:.3}"),
        _ => String::new(),
    };
    console::note(&format!(
        "{name}: {:.1} Mrays/s by the clock, {:.1} over all kernels, {:.1} while tracing{beside}; longest dispatch \
         {longest:.1} ms",
        rate(seconds(wall)),
        rate(kernels),
        rate(traversal),
    ));
    for (kernel, time) in &times {
        let share = 100.0 * seconds(time.total) / kernels.max(f64::MIN_POSITIVE);
        let [total, longest] = [time.total, time.longest].map(|time| seconds(time) * 1e3);
        console::note(&format!("  {kernel:<18} {total:>10.3} ms {share:>5.1} %, longest {longest:.3} ms"));
    }
    let milliseconds = |of: fn(&KernelTime) -> Duration| -> serde_json::Map<String, Value> {
        times.iter().map(|(kernel, time)| ((*kernel).to_owned(), json!(seconds(of(time)) * 1e3))).collect()
    };
    Ok(json!({
        "scene": bench.name, "integrator": name, "rays": rays, "seconds": seconds(wall),
        "mrays_per_second": rate(seconds(wall)), "mrays_per_second_of_kernels": rate(kernels),
        "mrays_per_second_tracing": rate(traversal), "mrays_per_second_replayed": bare,
        "over_replay": reached, "kernel_ms": milliseconds(|time| time.total),
        "longest_dispatch_ms": milliseconds(|time| time.longest),
    }))
}

/// Millions of rays a second where those of a sample of each pixel are traced with nothing between. Rays of a
/// pool are not recorded.
fn bare_rate(bench: &Bench, renderer: &mut Renderer) -> Outcome<f64> {
    let recorded = renderer.record_rays().map_err(failure)?;
    let replay = replay(renderer.device(), bench.scene(), recorded).map_err(failure)?;
    Ok(replay.n_rays as f64 * 1e-6 / replay.time.as_secs_f64().max(f64::MIN_POSITIVE))
}
