//! What is written into the image's header.

use midway_device::DeviceInfo;
use midway_film::Metadata;
use midway_scene::{Projection, Scene};

use super::{frame::Frame, job::RenderJob, schedule::State};
use crate::args::RenderArgs;

/// What is known before the first pass.
pub fn of_request(args: &RenderArgs, scene: &Scene, frame: &Frame, device: &DeviceInfo) -> Metadata {
    let mut header = Metadata::new();
    let name = args.scene.file_name().unwrap_or(args.scene.as_os_str());
    header.set("scene", name.to_string_lossy().as_ref());
    header.set("scene_hash", scene.hash());
    if let Some(variant) = &args.variant {
        header.set("variant", variant.as_str());
    }
    if let Some(path) = &args.env {
        let name = path.file_name().unwrap_or(path.as_os_str());
        header.set("environment", name.to_string_lossy().as_ref());
        header.set("environment_rotation_degrees", f64::from(args.env_rotation.unwrap_or_default()));
    }
    if let Some(color) = args.background {
        let [r, g, b] = color.0;
        header.set("background", format!("{r},{g},{b}"));
    }
    header.set("seed", args.seed);
    header.set("device", format!("{} ({})", device.name, device.backend));
    header.set("width", frame.width);
    header.set("height", frame.height);
    if let Some(crop) = frame.crop {
        header.set("crop", format!("{},{},{},{}", crop.x, crop.y, crop.width, crop.height));
    }
    header.set("camera", frame.camera.name.as_str());
    // glam stores columns; files store rows.
    header.set("world_from_camera", frame.camera.world_from_camera.transpose().to_cols_array_2d());
    match frame.camera.projection {
        Projection::Perspective { yfov } => header.set("yfov_degrees", f64::from(yfov.to_degrees())),
        Projection::Orthographic { height } => header.set("orthographic_height", f64::from(height)),
    }
    if frame.camera.lens_radius > 0.0 {
        header.set("lens_radius", f64::from(frame.camera.lens_radius));
        header.set("focus_distance", f64::from(frame.camera.focus_distance));
    }
    header
}

/// `request` and how the render stands.
pub fn of_state(request: &Metadata, job: &RenderJob, state: &State) -> Metadata {
    let mut header = request.clone();
    header.set("integrator", job.integrator());
    header.set("light_sampling", job.light_sampling());
    header.set("filter", job.filter());
    header.set("rng", job.rng());
    header.set("bias", bias(&job.bias()));
    header.set("samples", i64::try_from(state.samples).unwrap_or(i64::MAX));
    header.set("seconds", state.seconds());
    header.set("rays", i64::try_from(state.rays).unwrap_or(i64::MAX));
    let stats = job.stats();
    header.set("rejected_contributions", i64::try_from(stats.rejected).unwrap_or(i64::MAX));
    header.set("mean_light_vertices", f64::from(stats.mean_light_vertices));
    header.set("light_paths_per_pass", stats.n_light_paths);
    header
}

fn bias(bias: &[String]) -> String {
    if bias.is_empty() { "none".to_owned() } else { bias.join("; ") }
}
