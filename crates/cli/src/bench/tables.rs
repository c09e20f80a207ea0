//! `midway bench tables`: the comparisons of Otte, "Efficient Implementation of Bi-directional Path
//! Tracer on GPU" (2014), as rows and pictures. RMSE is what one image is expected to have, from two.

use std::{fs, path::PathBuf, sync::Arc, time::Duration};

use midway_device::Device;
use midway_film::{Display, Metadata, ToneMap, write_png};
use midway_render::IntegratorSettings;
use serde_json::{Value, json};

use super::{
    equal_time::integrators,
    measured::{Bench, Until, finish, open},
};
use crate::{
    args::TablesArgs,
    console,
    status::{OrStatus, Outcome, Status},
};

/// Pixels of the pictures.
const SQUARE: [u32; 2] = [512, 512];
const WIDE: [u32; 2] = [768, 512];
/// Stops by which caustics are brightened, all alike.
const CAUSTIC_STOPS: f32 = 1.0;

/// One of the tables.
struct Table {
    name: &'static str,
    scene: Option<PathBuf>,
    size: [u32; 2],
    integrators: &'static [&'static str],
    seconds: &'static [u64],
    stops: f32,
}

/// Renders each table whose scene is there.
///
/// # Errors
/// As the scenes, the device or the folder say.
pub fn run(args: &TablesArgs) -> Outcome {
    let device = open(&args.device)?;
    fs::create_dir_all(&args.output).or_status(Status::Output)?;
    let mut rows = Vec::new();
    for table in tables(args) {
        match &table.scene {
            Some(scene) => render(&device, args, &table, scene, &mut rows)?,
            None => console::note(&format!("{}: no scene was given", table.name)),
        }
    }
    finish(args.json, &*device, rows)
}

fn tables(args: &TablesArgs) -> [Table; 5] {
    let own = |name: &str| Some(args.scenes.join(name));
    let joins = &["single-step", "k-step-3", "full", "path"];
    let of = |name, scene, size, integrators, seconds| Table {
        name,
        scene,
        size,
        integrators,
        seconds,
        stops: 0.0,
    };
    [
        of("1-cornell", own("cornell-glass-mirror.gltf"), SQUARE, &["path", "full"], &[5, 10]),
        of("2-sponza", args.sponza.clone(), WIDE, joins, &[5]),
        Table { stops: CAUSTIC_STOPS, ..of("3-caustic", own("glass-caustic.gltf"), SQUARE, joins, &[5, 10]) },
        of("4-sponza-sun", args.sponza_sun.clone(), WIDE, &["path", "full"], &[5, 10, 20]),
        of("6-exterior", own("exterior.gltf"), SQUARE, &["path", "full"], &[5]),
    ]
}

fn render(
    device: &Arc<dyn Device>,
    args: &TablesArgs,
    table: &Table,
    scene: &std::path::Path,
    rows: &mut Vec<Value>,
) -> Outcome {
    let bench = Bench::load(device, scene, &args.root, table.size)?;
    let chosen: Vec<(&str, IntegratorSettings)> =
        integrators().into_iter().filter(|(name, _)| table.integrators.contains(name)).collect();
    console::note(&format!("table {}: {}", table.name, bench.name));
    for &seconds in table.seconds {
        for (name, integrator) in &chosen {
            let until = args.pace.map_or(Until::Time(Duration::from_secs(seconds)), |mrays| {
                Until::Rays((f64::from(mrays) * 1e6) as u64 * seconds)
            });
            let measured = bench.measure(bench.settings(*integrator), until)?;
            console::note(&measured.line(&format!("{name}, {seconds} s")));
            rows.push(measured.json(&json!({ "table": table.name, "integrator": name, "time": seconds })));
            let display = Display { exposure: table.stops, tone_map: ToneMap::Linear };
            let picture = args.output.join(format!("{}-{name}-{seconds}s.png", table.name));
            write_png(&picture, &measured.image, display, &Metadata::new())?;
        }
    }
    Ok(())
}
