//! `midway bench lights`: next-event estimation by a tree over lights against that by their power, for the
//! same time, as lights grow or in given scenes.

use midway_render::{
    Integrator, IntegratorSettings, LightSampling, RenderSettings,
    rays::{add_lamps, add_point_lights, generated_scene},
};
use midway_scene::Scene;
use serde_json::{Value, json};

use super::measured::{Bench, Measured, Until, check_measured, finish, open};
use crate::{args::LightsArgs, console, scene_file, status::Outcome};

/// Puts so many lights into a scene.
type AddLights = fn(&mut Scene, u32);

/// Of the scene, in balls of 1024: several lights of the most for each.
const TRIANGLES: u32 = 1 << 20;

/// Measures each scene, or each kind and number of lights, by each integrator.
///
/// # Errors
/// As the scene or the device says.
pub fn run(args: &LightsArgs) -> Outcome {
    if args.scenes.is_empty() {
        scene_file::refuse_root(&args.root)?;
    }
    let device = open(&args.device)?;
    let mut rows = Vec::new();
    for path in &args.scenes {
        compare(&Bench::load(&device, path, &args.root, args.size.size())?, args, &mut rows)?;
    }
    let kinds: [(&str, AddLights); 2] = [("points", add_point_lights), ("lamps", add_lamps)];
    for (kind, add) in kinds.into_iter().filter(|_| args.scenes.is_empty()) {
        for &n in &args.lights {
            let mut scene = generated_scene(TRIANGLES);
            add(&mut scene, n);
            compare(&Bench::of(&device, format!("{n} {kind}"), scene, args.size.size())?, args, &mut rows)?;
        }
    }
    check_measured(&args.only, rows.len())?;
    finish(args.json, &*device, rows)
}

/// By each integrator that is asked for.
fn compare(bench: &Bench, args: &LightsArgs, rows: &mut Vec<Value>) -> Outcome {
    for (name, integrator) in [("path", Integrator::Path), ("full", Integrator::Bdpt)] {
        let what = format!("{} {name}", bench.name);
        if !args.only.iter().all(|word| what.split(' ').any(|part| part == word)) {
            continue;
        }
        let integrator = IntegratorSettings { integrator, ..Default::default() };
        let mut measure = |light_sampling, how| {
            let settings = RenderSettings { light_sampling, ..bench.settings(integrator) };
            let measured = bench.measure(settings, Until::Time(args.time))?;
            console::note(&measured.line(&format!("{what} {how}")));
            rows.push(measured.json(&json!({ "scene": bench.name, "integrator": name, "sampling": how })));
            Outcome::Ok(measured)
        };
        let power = measure(LightSampling::Power, "power")?;
        let tree = measure(LightSampling::Tree, "tree")?;
        tell(&what, &power, &tree);
    }
    Ok(())
}

fn tell(what: &str, power: &Measured, tree: &Measured) {
    console::note(&format!(
        "{what}: by the tree {:.2} x the samples, {:.3} x the relMSE, trimmed {:.3} x",
        tree.samples / power.samples,
        tree.error.relmse / power.error.relmse,
        tree.error.relmse_trimmed / power.error.relmse_trimmed,
    ));
}
