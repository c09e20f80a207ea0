//! `midway bench scaling`: what a million samples cost as one thing grows: triangles, lights, pixels,
//! the bound of path lengths, K.

use std::sync::Arc;

use midway_device::Device;
use midway_render::{
    Integrator, IntegratorSettings, Join, LightPaths, RenderSettings,
    rays::{add_point_lights, generated_scene},
};
use midway_scene::Scene;
use serde_json::json;

use super::{
    curves::{Curve, write_svg},
    measured::{Bench, Until, check_only, finish, open},
};
use crate::{args::ScalingArgs, console, status::Outcome};

/// Triangles of the scenes in which something else grows.
const TRIANGLES: u32 = 100_000;
const LIGHTS: u32 = 1;
const SIDE: u32 = 256;

/// Measures each curve.
///
/// # Errors
/// As the device says, or if the picture cannot be written.
pub fn run(args: &ScalingArgs) -> Outcome {
    let all = curves_of(args.largest);
    check_only(&args.only, &all.iter().map(|(name, _)| *name).collect::<Vec<_>>())?;
    let device = open(&args.device)?;
    let (mut curves, mut rows) = (Vec::new(), Vec::new());
    for (name, points) in all {
        if !args.only.is_empty() && !args.only.iter().any(|one| one == name) {
            continue;
        }
        let mut curve = Curve { name, points: Vec::new() };
        for (n, point) in points {
            let cost = measure(&device, &point, args.spp)?;
            console::note(&format!(
                "{name} {n}: {:.4} s and {:.2} Mrays for a million samples",
                cost[0], cost[1]
            ));
            rows.push(json!({
                "curve": name, "n": n, "seconds_per_million_samples": cost[0],
                "mrays_per_million_samples": cost[1], "relmse": cost[2],
            }));
            curve.points.push([f64::from(n), cost[0]]);
        }
        if curve.points.len() > 1 {
            let exponent = curve.exponent();
            console::note(&format!("{name}: cost grows as n^{exponent:.3}"));
            rows.push(json!({ "curve": name, "exponent": exponent }));
        }
        curves.push(curve);
    }
    if let Some(path) = &args.svg {
        write_svg(path, "seconds for a million samples", &curves)?;
    }
    finish(args.json, &*device, rows)
}

/// One measurement.
#[derive(Clone, Copy)]
struct Point {
    triangles: u32,
    lights: u32,
    side: u32,
    max_path_length: Option<u32>,
    k: Option<u32>,
}

/// Each curve: what grows, and the points.
fn curves_of(largest: u32) -> Vec<(&'static str, Vec<(u32, Point)>)> {
    let usual = Point { triangles: TRIANGLES, lights: LIGHTS, side: SIDE, max_path_length: None, k: None };
    let decades = |most: u32| (0..).map(|i| 10_u32.pow(i)).take_while(move |n| *n <= most);
    let from = |values: Vec<u32>, point: fn(Point, u32) -> Point| {
        values.into_iter().map(|n| (n, point(usual, n))).collect()
    };
    vec![
        ("triangles", from(decades(largest).skip(3).collect(), |p, n| Point { triangles: n, ..p })),
        ("lights", from(decades(100_000).collect(), |p, n| Point { lights: n, ..p })),
        ("pixels along a side", from(vec![64, 128, 256, 512, 1024], |p, n| Point { side: n, ..p })),
        ("path length", from(vec![2, 4, 8, 16, 32], |p, n| Point { max_path_length: Some(n), ..p })),
        ("K", from(vec![1, 2, 4, 8, 16, 32], |p, n| Point { k: Some(n), ..p })),
    ]
}

/// Seconds and millions of rays for a million samples, and the error of the image. K is that of a pool,
/// whose draws are never fewer.
fn measure(device: &Arc<dyn Device>, point: &Point, spp: u64) -> Outcome<[f64; 3]> {
    let scene = lit_scene(point.triangles, point.lights);
    let bench = Bench::of(device, "generated".to_owned(), scene, [point.side; 2])?;
    let full = IntegratorSettings { integrator: Integrator::Bdpt, ..Default::default() };
    let integrator = point.k.map_or(full, |k| IntegratorSettings {
        join: Join::KStep,
        k,
        light_paths: LightPaths::Pool(None),
        ..full
    });
    let settings = RenderSettings { max_path_length: point.max_path_length, ..bench.settings(integrator) };
    let measured = bench.measure(settings, Until::Samples(spp))?;
    let millions = measured.samples * f64::from(point.side).powi(2) * 1e-6;
    Ok([measured.seconds / millions, measured.rays * 1e-6 / millions, measured.error.relmse])
}

/// Balls among point lights.
fn lit_scene(triangles: u32, lights: u32) -> Scene {
    let mut scene = generated_scene(triangles);
    add_point_lights(&mut scene, lights);
    scene
}
