//! What the flags put around the scene in place of its own environment.

use glam::{Mat3, Vec3};
use midway_scene::Environment;

use crate::{
    args::RenderArgs,
    scene_file::LoadedScene,
    status::{OrStatus, Outcome, Status},
};

/// Replaces the scene's environment where `--env` or `--background` is given.
///
/// # Errors
/// [`Status::Input`], naming the file.
pub fn replace(args: &RenderArgs, loaded: &mut LoadedScene) -> Outcome {
    if let Some(path) = &args.env {
        let (image, warnings) = midway_import::load_environment(path).or_status(Status::Input)?;
        loaded.warn(&warnings);
        let index = loaded.scene.images.len() as u32;
        loaded.scene.images.push(image);
        let turn = Mat3::from_rotation_y(args.env_rotation.unwrap_or_default().to_radians());
        loaded.scene.environment =
            Some(Environment { radiance: Vec3::ONE, image: Some(index), world_from_environment: turn });
    } else if let Some(color) = args.background {
        let radiance = Vec3::from_array(color.0);
        loaded.scene.environment =
            Some(Environment { radiance, image: None, world_from_environment: Mat3::IDENTITY });
    }
    Ok(())
}
