//! `midway view`: the scene in a browser, converging under the hand.

use std::{path::Path, time::Duration};

use midway_device::{OpenOptions, open_device};
use midway_film::ExrFile;
use midway_import::Variants;
use midway_render::RenderSettings;
use midway_scene::{Camera, Scene};
use midway_view::{Address, Server, Session, Start, ViewError, nothing};

use crate::{
    args::{RootArg, ViewArgs},
    console,
    interrupt::Interrupt,
    scene_file,
    status::{Failure, OrStatus, Outcome, Status},
};

/// Blocks of so many bytes are the system's own.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const LARGE: i32 = 64 << 10;
/// Height where neither flag nor camera says.
const DEFAULT_HEIGHT: f32 = 512.0;

/// Serves until Ctrl-C, SIGTERM or SIGHUP.
///
/// # Errors
/// With the [`Status`] of what went wrong.
pub fn run(args: &ViewArgs) -> Outcome<Status> {
    give_memory_back();
    let interrupt = Interrupt::install()?;
    let (mut scene, variants, name) = match &args.scene {
        Some(path) => {
            let (scene, variants) = load(path, &args.root, args.variant.as_deref())?;
            (scene, variants, path.file_name().unwrap_or_default().to_string_lossy().into_owned())
        }
        None => {
            scene_file::refuse_root(&args.root)?;
            (nothing(), Variants::default(), "no scene".to_owned())
        }
    };
    let taken = |name: &String| Some(name) == args.variant.as_ref();
    let variant = variants.names().iter().position(taken).map(|index| index as u32);
    scene_file::group_lights(&mut scene, args.light_groups.as_ref())?;
    let reference = match &args.reference {
        Some(path) => Some(ExrFile::read(path)?.image()?),
        None => None,
    };
    let options = OpenOptions { threads: args.threads.map(|n| n as usize), ..OpenOptions::default() };
    let device = open_device(&args.device, &options).or_status(Status::Device)?;
    console::note(&format!("device: {} ({})", device.info().name, device.info().backend));
    let [width, height] = size(args, scene.cameras.first());
    let settings = RenderSettings {
        width,
        height,
        light_groups: args.light_groups.is_some(),
        ..RenderSettings::default()
    };
    let hold = Duration::from_millis(args.hold.into());
    let session = Session::start(Start { device, scene, name, variants, variant, settings, hold, reference })
        .map_err(failure)?;
    let address = Address { ip: args.bind, port: args.port };
    let server = Server::listen(address, session, false, console::note).map_err(failure)?;
    for url in server.urls() {
        console::output(&format!("view: {url}"))?;
    }
    if !args.no_open {
        server.open_browser();
    }
    server.serve(move || interrupt.is_pressed()).map_err(failure)?;
    Ok(Status::Success)
}

/// Has glibc give memory back. It keeps an arena for each thread, and those of a viewer come and go with its
/// browsers; and it takes ever larger blocks from them once such were freed, where a small one that stays keeps
/// all below it. What comes and goes here (films, frames, files) is large.
fn give_memory_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: sets numbers of the allocator's own, under its lock.
    unsafe {
        libc::mallopt(libc::M_ARENA_MAX, 2);
        libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE);
    }
}

fn load(path: &Path, root: &RootArg, variant: Option<&str>) -> Outcome<(Scene, Variants)> {
    let loaded = scene_file::load_variant(path, root, variant)?;
    scene_file::print_warnings(&loaded.warnings());
    Ok((loaded.scene, loaded.variants))
}

/// As `midway render` has it.
fn size(args: &ViewArgs, camera: Option<&Camera>) -> [u32; 2] {
    let resolution = camera.and_then(|camera| camera.resolution);
    let aspect = resolution.map(|[width, height]| width as f32 / height as f32);
    let aspect = aspect.or(camera.and_then(|camera| camera.aspect)).unwrap_or(1.0);
    let side = |pixels: f32| pixels.round().clamp(1.0, 8192.0) as u32;
    match (args.width, args.height) {
        (Some(width), Some(height)) => [width, height],
        (Some(width), None) => [width, side(width as f32 / aspect)],
        (None, Some(height)) => [side(height as f32 * aspect), height],
        (None, None) => resolution.unwrap_or([side(DEFAULT_HEIGHT * aspect), DEFAULT_HEIGHT as u32]),
    }
}

fn failure(error: ViewError) -> Failure {
    let status = match error {
        ViewError::Render(_) => Status::Device,
        ViewError::Listen { .. } | ViewError::Refused(_) => Status::Usage,
        ViewError::Film(_) => Status::Input,
        ViewError::Io(_) => Status::Internal,
    };
    Failure::new(status, error)
}
