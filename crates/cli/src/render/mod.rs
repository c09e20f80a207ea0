//! `midway render`: from flags to files.

mod environment;
mod flags;
mod frame;
mod header;
mod job;
mod live;
mod outputs;
mod progress;
mod schedule;
mod session;
mod watch;

use std::{panic::resume_unwind, path::Path, thread, time::Duration};

use midway_device::{Bytes, MemoryPlan, OpenOptions, open_devices};
use midway_film::{Display, ToneMap, check_writable};
use midway_scene::Scene;

use crate::{
    args::{IntegratorArg, RenderArgs, ToneMapArg},
    info,
    interrupt::Interrupt,
    scene_file,
    status::{Failure, OrStatus, Outcome, Status},
};

use self::{
    frame::Frame, job::RenderJob, live::Live, outputs::Outputs, progress::Reporter, schedule::Limits,
    session::Session, watch::ErrorMeter,
};

pub use self::job::failure;

/// Samples per pixel where nothing else says when to stop.
const DEFAULT_SAMPLES: u64 = 64;

/// Renders. All that can be refused is refused before the first pass, cheapest first.
///
/// # Errors
/// With the [`Status`] of what went wrong.
pub fn run(args: &RenderArgs) -> Outcome<Status> {
    flags::check(args)?;
    let outputs = Outputs::plan(&args.output, &args.scene, display(args))?;
    if !args.aov.0.is_empty() && !outputs.hold_layers() {
        return Err(Failure::usage("--aov works with an .exr output only"));
    }
    if args.light_groups.is_some() && !outputs.hold_layers() {
        return Err(Failure::usage("--light-groups works with an .exr output only"));
    }
    args.errors.as_deref().map_or(Ok(()), check_writable)?;
    let interrupt = Interrupt::install()?;
    let reporter = Reporter::new(args.progress, args.quiet);
    let options = OpenOptions { threads: args.threads.map(|n| n as usize), ..OpenOptions::default() };
    // A driver takes as long to start as a scene to be read.
    let (scene, devices) = thread::scope(|scope| {
        let devices = scope.spawn(|| open_devices(&args.device, &options));
        let scene = load(args, &reporter);
        (scene, devices.join().unwrap_or_else(|panic| resume_unwind(panic)))
    });
    let (scene, devices) = (scene?, devices.or_status(Status::Device)?);
    let frame = Frame::resolve(args, &scene)?;
    let new_meter = |reference: &Path| ErrorMeter::new(reference, args.errors.as_deref(), &frame);
    let meter = args.reference.as_deref().map(new_meter).transpose()?;
    let settings = job::settings(args, &frame);
    let info = job::common_info(&devices);
    let mut header = header::of_request(args, &scene, &frame, &info);
    reporter.note(&format!("device: {} ({})", info.name, info.backend));
    let tell = |plan: &MemoryPlan| match args.verbose {
        true => reporter.note(&format!("memory:\n{plan}")),
        false => reporter.note(&format!("memory: {}", Bytes(plan.total()))),
    };
    let is_auto = args.integrator == IntegratorArg::Auto;
    let also = if is_auto { midway_render::settings_ahead(&settings) } else { Vec::new() };
    let mut job = RenderJob::start(&devices, &scene, &frame, &settings, &also, tell)?;
    if is_auto {
        let choice = job.choose()?.describe();
        reporter.note(&format!("auto, error for the same work: {choice}"));
        tell(job.memory());
        header.set("auto", choice);
    }

    let name = args.scene.file_name().unwrap_or_default().to_string_lossy();
    let tev = args.display.as_ref().map(|address| live::Tev::connect(address, &name, &frame)).transpose()?;
    let serve = |port| live::Served::start(port, &scene, &name, &frame, display(args));
    let live = Live { tev, served: args.serve.map(serve).transpose()? };
    let session = Session {
        live,
        device: info,
        limits: limits(args.spp, args.time),
        snapshots: watch::SnapshotClock::new(args.snapshot_every),
        framing: frame.framing(),
        outputs,
        reporter,
        meter,
        header,
    };
    session.announce(&job, &frame)?;
    session.render(job, &interrupt)
}

/// The scene as the flags have it; tells what was left out of it.
fn load(args: &RenderArgs, reporter: &Reporter) -> Outcome<Scene> {
    let mut loaded = scene_file::load_variant(&args.scene, &args.root, args.variant.as_deref())?;
    environment::replace(args, &mut loaded)?;
    loaded.warnings().iter().for_each(|warning| reporter.warning(warning));
    scene_file::group_lights(&mut loaded.scene, args.light_groups.as_ref())?;
    if args.verbose {
        info::to_lines(&loaded).iter().for_each(|line| reporter.note(line));
    }
    Ok(loaded.scene)
}

/// 64 samples, unless something else says when to stop.
fn limits(samples: Option<u64>, time: Option<Duration>) -> Limits {
    let samples = samples.or(if time.is_some() { None } else { Some(DEFAULT_SAMPLES) });
    Limits { samples, time }
}

fn display(args: &RenderArgs) -> Display {
    let tone_map = match args.tone_map {
        ToneMapArg::Linear => ToneMap::Linear,
        ToneMapArg::Agx => ToneMap::Agx,
        ToneMapArg::Aces => ToneMap::Aces,
        ToneMapArg::PbrNeutral => ToneMap::PbrNeutral,
    };
    Display { exposure: args.exposure, tone_map }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_default_only_where_there_is_no_time() {
        let second = Some(Duration::from_secs(1));
        assert_eq!(limits(None, None), Limits { samples: Some(64), time: None });
        assert_eq!(limits(None, second), Limits { samples: None, time: second });
        assert_eq!(limits(Some(4), second), Limits { samples: Some(4), time: second });
    }
}
