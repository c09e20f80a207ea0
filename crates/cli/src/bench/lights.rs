//! `midway bench lights`: next-event estimation by a tree over lights against that by their power, for the
//! same time, as lights grow.

use midway_render::{
    Integrator, IntegratorSettings, LightSampling, RenderSettings,
    rays::{add_lamps, add_point_lights, generated_scene},
};
use midway_scene::Scene;
use serde_json::json;

use super::measured::{Bench, Measured, Until, finish, open};
use crate::{args::LightsArgs, console, status::Outcome};

/// Of the scene, in balls of 1024: several lights of the most for each.
const TRIANGLES: u32 = 1 << 20;

/// Measures each kind of light by each integrator.
///
/// # Errors
/// As the device says.
pub fn run(args: &LightsArgs) -> Outcome {
    let device = open(&args.device)?;
    let mut rows = Vec::new();
    let kinds: [(&str, fn(&mut Scene, u32)); 2] = [("points", add_point_lights), ("lamps", add_lamps)];
    let integrators = [("path", Integrator::Path), ("full", Integrator::Bdpt)];
    let asked =
        |kind: &str, integrator: &str| args.only.iter().all(|word| [kind, integrator].contains(&&**word));
    for (kind, add) in kinds {
        for &n in &args.lights {
            let chosen: Vec<_> = integrators.iter().filter(|(name, _)| asked(kind, name)).collect();
            if chosen.is_empty() {
                continue;
            }
            let mut scene = generated_scene(TRIANGLES);
            add(&mut scene, n);
            let bench = Bench::of(&device, format!("{n} {kind}"), scene, args.size.size())?;
            for (name, integrator) in chosen {
                let integrator = IntegratorSettings { integrator: *integrator, ..Default::default() };
                let mut measure = |sampling, how| {
                    let settings = RenderSettings { light_sampling: sampling, ..bench.settings(integrator) };
                    let measured = bench.measure(settings, Until::Time(args.time))?;
                    console::note(&measured.line(&format!("{} {name} {how}", bench.name)));
                    let about = json!({ "lights": n, "kind": kind, "integrator": name, "sampling": how });
                    rows.push(measured.json(&about));
                    Outcome::Ok(measured)
                };
                let (power, tree) =
                    (measure(LightSampling::Power, "power")?, measure(LightSampling::Tree, "tree")?);
                tell(&format!("{} {name}", bench.name), &power, &tree);
            }
        }
    }
    finish(args.json, &*device, rows)
}

fn tell(what: &str, power: &Measured, tree: &Measured) {
    console::note(&format!(
        "{what}: by the tree {:.2} x the samples, {:.3} x the relMSE, trimmed {:.3} x",
        tree.samples / power.samples,
        tree.error.relmse / power.error.relmse,
        tree.error.relmse_trimmed / power.error.relmse_trimmed,
    ));
}
