//! What lies last among the words of `scene`: the lights, the tree over them, the environment. Nothing before
//! it depends on what is around the scene.

use std::sync::Arc;

use glam::Vec3;
use midway_kernels::constants as k;
use midway_scene::{LightGroups, Sphere, Surround};

use super::{
    Words,
    environment::pack_environment,
    light_tree::{LightTreeAt, pack_light_tree},
    lights::pack_lights,
    textures::mean_color,
};
use crate::{
    LightSampling, RenderError, environment::EnvironmentMap, light_tree::LightTree, lights::Lights,
    medium::MediumFinder, world::World,
};

/// What of the kernels depends on it.
pub(super) const FEATURES: u32 = k::FEATURE_ENVIRONMENT | k::FEATURE_LIGHT_TREE;

/// All that shines, ready to be packed.
pub(super) struct Lighting {
    pub lights: Lights,
    tree: Option<LightTree>,
    environment: Option<EnvironmentMap>,
    groups: LightGroups,
}

/// Where it is among the words.
pub(super) struct LightingAt {
    pub lights: u32,
    pub n_lights: u32,
    pub tree: LightTreeAt,
    /// The kernels' NONE where there is no environment.
    pub environment: u32,
    pub groups: Vec<Arc<str>>,
}

impl Lighting {
    /// Of a valid scene in something valid around it, whatever the scene has there. `sphere` is around all
    /// triangles.
    ///
    /// # Errors
    /// If the environment has more texels than kernels can address.
    pub fn of(
        world: &World<'_>,
        surround: &Surround,
        sphere: Sphere,
        sampling: LightSampling,
    ) -> Result<Self, RenderError> {
        let scene = world.scene();
        let environment = EnvironmentMap::of(surround)?;
        let emissions: Vec<Vec3> = scene.materials.iter().map(|m| mean_color(scene, &m.emission)).collect();
        let lights = Lights::collect(scene, world.emissive(), sphere, environment.as_ref(), |triangle| {
            emissions[triangle.material as usize]
        });
        let tree = LightTree::wanted(sampling, &lights, world, sphere.radius);
        let groups = scene.light_groups_under(environment.is_some());
        Ok(Self { lights, tree, environment, groups })
    }

    /// Of [`FEATURES`].
    pub fn features(&self) -> u32 {
        let has_tree = self.tree.as_ref().is_some_and(|tree| !tree.nodes.is_empty());
        let has = [(self.environment.is_some(), k::FEATURE_ENVIRONMENT), (has_tree, k::FEATURE_LIGHT_TREE)];
        has.iter().filter(|(has, _)| *has).fold(0, |all, (_, bit)| all | bit)
    }

    /// Groups of lights, at least one.
    pub fn n_groups(&self) -> u32 {
        self.groups.names.len() as u32
    }

    /// Appends it. `media`: none where no material has an inside.
    pub fn pack(self, world: &World<'_>, media: Option<&MediumFinder<'_>>, words: &mut Words) -> LightingAt {
        let lights = words.next();
        pack_lights(&self.lights, &self.groups, world, media, words);
        let tree = pack_light_tree(self.tree.as_ref(), words);
        let environment = self.environment.as_ref().map_or(k::NONE, |_| words.next());
        if let Some(environment) = &self.environment {
            pack_environment(environment, self.lights.environment(), words);
        }
        let n_lights = self.lights.lights.len() as u32;
        LightingAt { lights, n_lights, tree, environment, groups: self.groups.names }
    }
}
