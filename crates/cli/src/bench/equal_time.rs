//! `midway bench equal-time`: every integrator for the same time, and how near `auto` comes to the best.

use std::time::Duration;

use midway_render::{Integrator, IntegratorSettings, Join, JoinChoice, LightPaths};
use serde_json::{Value, json};

use super::measured::{Bench, Measured, Until, check_only, finish, open};
use crate::{args::EqualTimeArgs, console, status::Outcome};

/// Measures each scene.
///
/// # Errors
/// As the scene or the device says.
pub fn run(args: &EqualTimeArgs) -> Outcome {
    let names: Vec<&str> = integrators().iter().map(|(name, _)| *name).chain(["auto"]).collect();
    check_only(&args.only, &names)?;
    let device = open(&args.device)?;
    let mut rows = Vec::new();
    for path in &args.scenes {
        let bench = Bench::load(&device, path, &args.root, args.size.size())?;
        console::note(&format!("scene: {}", bench.name));
        measure_scene(&bench, args.time, &args.only, &mut rows)?;
    }
    finish(args.json, &*device, rows)
}

/// The settings that are compared, by names that are short.
pub fn integrators() -> Vec<(&'static str, IntegratorSettings)> {
    let of = |integrator| IntegratorSettings { integrator, ..Default::default() };
    let full = of(Integrator::Bdpt);
    let k_step = |k, join_choice| IntegratorSettings { join: Join::KStep, k, join_choice, ..full };
    let pool = |settings| IntegratorSettings { light_paths: LightPaths::Pool(None), ..settings };
    let single = IntegratorSettings { join: Join::SingleStep, ..full };
    vec![
        ("path", of(Integrator::Path)),
        ("light", of(Integrator::Light)),
        ("full", full),
        ("full-no-splat", IntegratorSettings { splat: Some(false), ..full }),
        ("k-step-1", k_step(1, JoinChoice::Uniform)),
        ("k-step-3", k_step(3, JoinChoice::Uniform)),
        ("k-step-8", k_step(8, JoinChoice::Uniform)),
        ("k-step-3-importance", k_step(3, JoinChoice::Importance)),
        ("single-step", single),
        ("single-step-nee-splat", IntegratorSettings { nee: Some(true), splat: Some(true), ..single }),
        ("pool-k-step-3", pool(k_step(3, JoinChoice::Uniform))),
        ("pool-full", pool(full)),
    ]
}

fn measure_scene(bench: &Bench, time: Duration, only: &[String], rows: &mut Vec<Value>) -> Outcome {
    let asked = |name: &str| only.is_empty() || only.iter().any(|one| one == name);
    let mut hand_picked: Vec<(&str, Measured)> = Vec::new();
    let mut tell = |name: &str, measured: &Measured, about: Value| {
        console::note(&measured.line(name));
        let mut row = measured.json(&json!({ "scene": bench.name, "integrator": name }));
        if let (Some(row), Some(about)) = (row.as_object_mut(), about.as_object()) {
            row.extend(about.clone());
        }
        rows.push(row);
    };
    for (name, integrator) in integrators().into_iter().filter(|(name, _)| asked(name)) {
        let measured = bench.measure(bench.settings(integrator), Until::Time(time))?;
        tell(name, &measured, json!({}));
        // The light image alone does not see everything: it is no choice for any scene.
        if integrator.integrator != Integrator::Light {
            hand_picked.push((name, measured));
        }
    }
    if !asked("auto") {
        return Ok(());
    }
    let choice = bench.choose()?;
    let measured = bench.measure(bench.settings(choice.integrator()), Until::Time(time))?;
    let best = hand_picked.iter().min_by(|a, b| a.1.error.relmse.total_cmp(&b.1.error.relmse));
    let chosen = choice.describe();
    let about = match best {
        Some((name, best)) => {
            let ratio = measured.error.relmse / best.error.relmse;
            console::note(&format!("auto: {chosen}; relMSE {ratio:.3} x that of {name}"));
            json!({ "chosen": chosen, "best": name, "over_best": ratio })
        }
        None => {
            console::note(&format!("auto: {chosen}"));
            json!({ "chosen": chosen })
        }
    };
    tell("auto", &measured, about);
    Ok(())
}
