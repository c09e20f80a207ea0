//! What is around a scene, apart from the scene.

use crate::{Environment, Image, Scene};

/// What may be put around a scene in place of what it has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surround {
    /// None: nothing, black. An index of an image in it only says that there is one.
    pub environment: Option<Environment>,
    /// The environment's image, where it has one.
    pub image: Option<Image>,
}

impl Surround {
    /// What is around a valid scene.
    pub fn of(scene: &Scene) -> Self {
        Self { environment: scene.environment, image: scene.environment_image().cloned() }
    }
}
