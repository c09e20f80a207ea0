//! `midway bench sampling`: where random numbers come from, how joins choose, where their light paths
//! come from, and what the joins keep in memory.

use midway_render::{Integrator, IntegratorSettings, Join, JoinChoice, LightPaths, RenderSettings, Rng};
use serde_json::{Value, json};

use super::measured::{Bench, Until, failure, finish, open};
use crate::{args::SamplingArgs, console, status::Outcome};

/// Measures each scene.
///
/// # Errors
/// As the scene or the device says.
pub fn run(args: &SamplingArgs) -> Outcome {
    let device = open(&args.device)?;
    let mut rows = Vec::new();
    for path in &args.scenes {
        let bench = Bench::load(&device, path, &args.root, args.size.size())?;
        console::note(&format!("scene: {}", bench.name));
        let mut plain = [None; 2];
        for (name, settings) in variants(&bench) {
            measure(
                &bench,
                &name,
                &settings,
                [Until::Samples(args.spp), Until::Time(args.time)],
                &mut plain,
                &mut rows,
            )?;
        }
        memory(&bench, &mut rows)?;
    }
    finish(args.json, &*device, rows)
}

fn bdpt() -> IntegratorSettings {
    IntegratorSettings { integrator: Integrator::Bdpt, ..Default::default() }
}

/// What is compared: the generator with `path` and `full`, the choice of joins, the pool and its size.
fn variants(bench: &Bench) -> Vec<(String, RenderSettings)> {
    let mut variants = Vec::new();
    for (name, integrator) in [("path", Integrator::Path), ("full", Integrator::Bdpt)] {
        let integrator = IntegratorSettings { integrator, ..Default::default() };
        for rng in [Rng::Sobol, Rng::Hash, Rng::Table(1 << 16)] {
            let settings = RenderSettings { rng, ..bench.settings(integrator) };
            variants.push((format!("{name} rng={}", rng.describe()), settings));
        }
    }
    let bounded = RenderSettings { max_path_length: Some(8), ..bench.settings(bdpt()) };
    variants.push(("full max-path-length=8".to_owned(), bounded));
    for k in [1, 3, 8] {
        for (name, join_choice) in [("uniform", JoinChoice::Uniform), ("importance", JoinChoice::Importance)]
        {
            let k_step = IntegratorSettings { join: Join::KStep, k, join_choice, ..bdpt() };
            variants.push((format!("k-step k={k} {name}"), bench.settings(k_step)));
            let pool = IntegratorSettings { light_paths: LightPaths::Pool(None), ..k_step };
            variants.push((format!("pool k-step k={k} {name}"), bench.settings(pool)));
        }
    }
    let n_pixels = {
        let settings = bench.settings(bdpt());
        settings.width * settings.height
    };
    for (name, n) in [("1/16", n_pixels / 16), ("1/4", n_pixels / 4), ("1", n_pixels), ("4", n_pixels * 4)] {
        let light_paths = LightPaths::Pool(Some(n.max(1)));
        let pool = IntegratorSettings { join: Join::KStep, light_paths, ..bdpt() };
        variants.push((format!("pool of {name} x the pixels, k-step k=3"), bench.settings(pool)));
    }
    variants
}

/// At equal samples and at equal time. `plain`: the means that the first of all has by each; what another has
/// beyond them and their noise is its bias, which an error from two seeds does not see.
fn measure(
    bench: &Bench,
    name: &str,
    settings: &RenderSettings,
    ends: [Until; 2],
    plain: &mut [Option<f64>; 2],
    rows: &mut Vec<Value>,
) -> Outcome {
    for ((equal, until), plain) in [("samples", ends[0]), ("time", ends[1])].into_iter().zip(plain) {
        let measured = bench.measure(settings.clone(), until)?;
        let first = *plain.get_or_insert(measured.mean);
        let (mean, error) = (measured.mean / first, measured.mean_error / first);
        let line = measured.line(&format!("{name}, equal {equal}"));
        console::note(&format!("{line}  mean {mean:.4} ({error:.4})"));
        rows.push(
            measured.json(
                &json!({ "scene": bench.name, "variant": name, "equal": equal, "mean_over_first": mean }),
            ),
        );
    }
    Ok(())
}

/// Bytes that light vertices take, against the bound of path lengths.
fn memory(bench: &Bench, rows: &mut Vec<Value>) -> Outcome {
    let joins = [("full", Join::Full), ("k-step", Join::KStep), ("single-step", Join::SingleStep)];
    for (name, join) in joins {
        for bound in [Some(2), Some(4), Some(8), Some(16), None] {
            let integrator = IntegratorSettings { join, ..bdpt() };
            let settings = RenderSettings { max_path_length: bound, ..bench.settings(integrator) };
            let renderer = bench.renderer(settings)?;
            let vertices = |(label, bytes): (&str, u64)| label.contains("light vertices").then_some(bytes);
            let bytes: u64 = renderer.plan().items().filter_map(vertices).sum();
            let mean = renderer.stats().map_err(failure)?.mean_light_vertices;
            let length = bound.map_or("unbounded".to_owned(), |n| n.to_string());
            console::note(&format!(
                "{name}, path length {length}: light vertices {bytes} bytes, {mean:.2} a path"
            ));
            rows.push(json!({
                "scene": bench.name, "variant": name, "max_path_length": bound,
                "light_vertex_bytes": bytes, "mean_light_vertices": mean,
            }));
        }
    }
    Ok(())
}
