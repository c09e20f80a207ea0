//! `midway bench rays`.

use std::{path::Path, time::Duration};

use midway_device::{OpenOptions, open_device};
use midway_render::{
    RenderError,
    rays::{HierarchyReport, RayReport, RaysOptions, bench_rays, generated_scene},
};
use midway_scene::Scene;
use serde_json::{Value, json};

use super::measured::check_measured;
use crate::{
    args::{RaysArgs, RootArg},
    console, scene_file,
    status::{Failure, OrStatus, Outcome, Status},
};

/// In place of a file's name: a generated scene of so many triangles.
const GENERATED: &str = "generated:";
/// Beyond this a generated scene is no use: hierarchies address 2^27 triangles.
const MOST_GENERATED: u32 = 1 << 26;
/// Measured runs of each variant.
const ROUNDS: u32 = 7;

/// Measures every variant and prints a row for each.
///
/// # Errors
/// [`Status::Input`] for the scene, [`Status::Device`] for the device.
pub fn run(args: &RaysArgs) -> Outcome {
    let scene = load(&args.scene, &args.root)?;
    let open = OpenOptions { threads: args.threads.map(|n| n as usize), ..OpenOptions::default() };
    let device = open_device(&args.device, &open).or_status(Status::Device)?;
    console::note(&format!("device: {} ({})", device.info().name, device.info().backend));
    let options = RaysOptions { n_rays: args.rays, rounds: ROUNDS, only: args.only.clone() };
    let mut hierarchies = Vec::new();
    let mut rows: Vec<Value> = Vec::new();
    console::note(&header());
    let tell_hierarchy = |report: &HierarchyReport| {
        console::note(&hierarchy_line(report));
        hierarchies.push(hierarchy_json(report));
    };
    let tell = |report: &RayReport| {
        console::note(&line(report));
        rows.push(row_json(report));
    };
    bench_rays(&device, &scene, &options, tell_hierarchy, tell).map_err(failure)?;
    check_measured(&args.only, rows.len())?;
    if !args.json {
        return Ok(());
    }
    let result = json!({
        "scene": args.scene.to_string_lossy(),
        "triangles": scene.counts().triangles,
        "device": device.info().name,
        "backend": device.info().backend,
        "hierarchies": hierarchies,
        "rows": rows,
    });
    console::output(&result.to_string())
}

fn load(scene: &Path, root: &RootArg) -> Outcome<Scene> {
    let Some(count) = scene.to_str().and_then(|name| name.strip_prefix(GENERATED)) else {
        return Ok(scene_file::load(scene, root)?.scene);
    };
    scene_file::refuse_root(root)?;
    match count.parse() {
        Ok(n) if (1..=MOST_GENERATED).contains(&n) => Ok(generated_scene(n)),
        _ => Err(Failure::usage(format!("{GENERATED}N takes a number of triangles up to {MOST_GENERATED}"))),
    }
}

fn failure(error: RenderError) -> Failure {
    let status = match error {
        RenderError::Device(_) => Status::Device,
        _ => Status::Input,
    };
    Failure::new(status, error)
}

fn splits(spatial: bool) -> &'static str {
    if spatial { "splits" } else { "plain" }
}

fn header() -> String {
    format!(
        "{:<12} {:<7} {:<14} {:<8} {:>10} {:>17} {:>12} {:>6} {:>9}",
        "variant", "tree", "rays", "asks", "Mrays/s", "least to most", "/CPU second", "hit", "differ"
    )
}

fn line(report: &RayReport) -> String {
    let [least, most] = report.mrays_per_second_range();
    format!(
        "{:<12} {:<7} {:<14} {:<8} {:>10.2} {:>17} {:>12} {:>5.1}% {:>9}",
        report.variant,
        splits(report.spatial_splits),
        report.rays,
        report.question.name(),
        report.mrays_per_second(),
        format!("{least:.2} to {most:.2}"),
        report.mrays_per_cpu_second().map_or_else(|| "-".to_owned(), |rate| format!("{rate:.3}")),
        100.0 * report.hit_share,
        report.n_different,
    )
}

fn row_json(report: &RayReport) -> Value {
    let [least, most] = report.mrays_per_second_range();
    json!({
        "variant": report.variant,
        "spatial_splits": report.spatial_splits,
        "rays": report.rays,
        "question": report.question.name(),
        "n_rays": report.n_rays,
        "seconds": report.times.iter().map(Duration::as_secs_f64).collect::<Vec<_>>(),
        "mrays_per_second": report.mrays_per_second(),
        "mrays_per_second_least": least,
        "mrays_per_second_most": most,
        "mrays_per_cpu_second": report.mrays_per_cpu_second(),
        "hit_share": report.hit_share,
        "n_different": report.n_different,
    })
}

fn hierarchy_line(report: &HierarchyReport) -> String {
    format!(
        "hierarchy: {} {}: built in {:.2} s, {} nodes, {:.1} MB, {:.3} slots a triangle, {} levels, SAH {:.2}",
        report.name,
        splits(report.spatial_splits),
        report.build_time.as_secs_f64(),
        report.nodes,
        report.bytes as f64 * 1e-6,
        report.slots_per_triangle,
        report.depth,
        report.sah_cost,
    )
}

fn hierarchy_json(report: &HierarchyReport) -> Value {
    json!({
        "name": report.name,
        "spatial_splits": report.spatial_splits,
        "build_seconds": report.build_time.as_secs_f64(),
        "bytes": report.bytes,
        "nodes": report.nodes,
        "slots_per_triangle": report.slots_per_triangle,
        "levels": report.depth,
        "sah_cost": report.sah_cost,
    })
}
