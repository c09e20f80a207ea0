//! The materials that the scene's meshes have.

use std::sync::Arc;

use midway_device::Device;
use midway_render::Hold;
use midway_scene::Scene;

use super::{Engine, half_of, hold_limits};
use crate::ViewError;

impl Engine {
    /// Gives each mesh the material of that index. What emits and what is opaque may change with them, so
    /// the scene is taken to the device anew. After an error all is as it was.
    ///
    /// # Errors
    /// If they are not as many as meshes, or the scene cannot be rendered with them.
    pub fn dress(&mut self, device: &Arc<dyn Device>, materials: &[u32]) -> Result<(), ViewError> {
        if materials.len() != self.scene.meshes.len() {
            return Err(ViewError::Refused("these materials are another scene's".into()));
        }
        let groups = self.scene.light_groups().names;
        let before: Vec<u32> = self.scene.meshes.iter().map(|mesh| mesh.material).collect();
        let scene = Arc::make_mut(&mut self.scene);
        put_on(scene, materials);
        let same_groups = scene.light_groups().names == groups;
        let mut settings = self.settings.clone();
        settings.light_groups &= same_groups;
        self.left = match half_of(device, scene, &self.camera, &settings, &self.haste) {
            Ok(half) => half,
            Err(error) => {
                put_on(scene, &before);
                return Err(error);
            }
        };
        if !same_groups {
            self.mix.clear();
        }
        self.settings = settings;
        self.hold = Hold::new(hold_limits(&self.settings, self.hold_time));
        self.previewed = false;
        self.split_again()
    }
}

fn put_on(scene: &mut Scene, materials: &[u32]) {
    for (mesh, &material) in scene.meshes.iter_mut().zip(materials) {
        mesh.material = material;
    }
}
