//! What is around the scene.

use std::sync::Arc;

use glam::{Mat3, Vec3};
use midway_scene::Environment;

use super::Engine;
use crate::{ViewError, protocol::Surroundings};

/// Stands for the environment of a scene that has none.
pub(super) const WHITE: Environment =
    Environment { radiance: Vec3::ONE, image: None, world_from_environment: Mat3::IDENTITY };

impl Engine {
    /// Another strength or turn of the environment, or another environment.
    ///
    /// # Errors
    /// If the scene cannot be rendered with it.
    pub fn surround(
        &mut self,
        surroundings: Surroundings,
        image: Option<midway_scene::Image>,
    ) -> Result<(), ViewError> {
        let Surroundings { strength, rotation } = surroundings;
        if !(strength.is_finite() && (0.0..=1e6).contains(&strength) && rotation.is_finite()) {
            return Err(ViewError::Refused("an environment's strength is 0 to a million".into()));
        }
        let before = (self.scene.environment, self.scene.images.clone());
        let scene = Arc::make_mut(&mut self.scene);
        let mut base = self.base;
        if let Some(image) = image {
            scene.images.truncate(self.n_images); // one that was dropped before
            scene.images.push(image);
            base = Environment { image: Some(self.n_images as u32), ..WHITE };
        }
        let turn = Mat3::from_rotation_y(rotation.to_radians());
        scene.environment = (strength > 0.0).then(|| Environment {
            radiance: base.radiance * strength,
            world_from_environment: turn * base.world_from_environment,
            ..base
        });
        if let Err(error) = self.left.renderer.set_environment(scene) {
            (scene.environment, scene.images) = before;
            return Err(error.into());
        }
        (self.base, self.surroundings) = (base, surroundings);
        self.left.begin();
        self.split_again()
    }
}
