//! What shading reads of a scene (`scene` in WGSL): all that needs no hierarchy, and the lights behind it,
//! whose media a hierarchy tells.

use glam::Vec3;
use midway_kernels::constants as k;
use midway_scene::{Camera, LightGroups, Sphere};

use super::{
    PackedScene, Word4,
    environment::pack_environment,
    geometry::{SurfacesAt, pack_surfaces},
    light_tree::pack_light_tree,
    lights::pack_lights,
    materials::{albedo_tables, pack_material},
    medium_or_none,
    slots::pack_slots,
    textures::{PackedImages, TextureTable, mean_color, srgb_table},
};
use crate::{
    RenderError, RenderSettings, environment::EnvironmentMap, features::scene_features,
    light_tree::LightTree, lights::Lights, medium::MediumFinder, world::World,
};

/// The words so far, and what is to be packed behind them.
pub(super) struct Shading {
    words: Vec<Word4>,
    images: PackedImages,
    surfaces: SurfacesAt,
    random_at: u32,
    n_random: u32,
    slots_at: u32,
    textures_at: u32,
    srgb_at: u32,
    sphere: Sphere,
    lights: Lights,
    tree: Option<LightTree>,
    environment: Option<EnvironmentMap>,
    groups: LightGroups,
    features: u32,
}

impl Shading {
    /// Everything of a valid scene but the records of its lights.
    ///
    /// # Errors
    /// If the images or the environment have more texels than kernels can address.
    pub fn pack(world: &World<'_>, settings: &RenderSettings) -> Result<Self, RenderError> {
        let scene = world.scene();
        let sphere = scene.bounds().sphere();
        let environment = EnvironmentMap::of(scene)?;
        let emissions: Vec<Vec3> = scene.materials.iter().map(|m| mean_color(scene, &m.emission)).collect();
        let lights = Lights::collect(scene, world.emissive(), sphere, environment.as_ref(), |triangle| {
            emissions[triangle.material as usize]
        });
        let mut images = PackedImages::default();
        let mut textures = TextureTable::default();
        let mut words = albedo_tables();
        let mut slots = Vec::new();
        for material in &scene.materials {
            let (record, flags) = pack_slots(scene, material, &mut images, &mut textures);
            words.extend(pack_material(material, flags));
            slots.extend(record);
        }
        images.check()?;
        let surfaces = pack_surfaces(world, &lights, &mut words);
        let random = settings.rng.table();
        let mut append = |part: &mut dyn Iterator<Item = Word4>| {
            let at = words.len() as u32;
            words.extend(part);
            at
        };
        let random_at = append(&mut (0..random.unwrap_or(0)).map(pregenerated_numbers));
        let slots_at = append(&mut slots.into_iter());
        let textures_at = append(&mut textures.words().iter().copied());
        let srgb_at = append(&mut srgb_table().into_iter());
        let set = [
            (!world.placed().is_empty(), k::FEATURE_INSTANCES),
            (surfaces.has_attributes, k::FEATURE_ATTRIBUTES),
            (!textures.words().is_empty(), k::FEATURE_TEXTURES),
            (random.is_some(), k::FEATURE_RANDOM_TABLE),
        ];
        let features =
            set.iter().filter(|(has, _)| *has).fold(scene_features(scene), |all, (_, bit)| all | bit);
        let tree = LightTree::wanted(settings.light_sampling, &lights, world, sphere.radius);
        let groups = scene.light_groups();
        let n_random = random.unwrap_or(0);
        Ok(Self {
            words,
            images,
            surfaces,
            random_at,
            n_random,
            slots_at,
            textures_at,
            srgb_at,
            sphere,
            lights,
            tree,
            environment,
            groups,
            features,
        })
    }

    /// With the lights behind it: all of a packed scene but hierarchies, as seen by a camera. `media`: none
    /// where no material has an inside.
    pub fn with_lights(
        self,
        world: &World<'_>,
        media: Option<&MediumFinder<'_>>,
        camera: &Camera,
    ) -> PackedScene {
        let mut words = self.words;
        let lights_at = words.len() as u32;
        pack_lights(&self.lights, &self.groups, world, media, &mut words);
        let tree_at = pack_light_tree(self.tree.as_ref(), &mut words);
        let environment_at = self.environment.as_ref().map_or(k::NONE, |_| words.len() as u32);
        if let Some(environment) = &self.environment {
            pack_environment(environment, self.lights.environment(), &mut words);
        }
        let forward = camera.world_from_camera.transform_vector3(Vec3::NEG_Z);
        let has_tree = if tree_at.nodes == k::NONE { 0 } else { k::FEATURE_LIGHT_TREE };
        PackedScene {
            nodes: Vec::new(),
            triangles: Vec::new(),
            scene: words,
            lights_at,
            light_tree_at: tree_at.nodes,
            light_ways_at: tree_at.ways,
            environment_at,
            sphere: self.sphere,
            surfaces_at: self.surfaces.surfaces,
            instances_at: self.surfaces.instances,
            random_at: self.random_at,
            n_lights: self.lights.lights.len() as u32,
            n_baked: if world.placed().is_empty() { k::NONE } else { world.n_baked },
            n_instances: world.placed().len() as u32,
            n_random: self.n_random,
            images: self.images,
            textures_at: self.textures_at,
            srgb_at: self.srgb_at,
            slots_at: self.slots_at,
            light_groups: self.groups.names,
            camera_medium: medium_or_none(media, camera.position(), forward),
            features: self.features | has_tree,
            media: None,
        }
    }
}

/// Four numbers in [0, 1) for an entry of the table: the kernels' own hash of its index.
fn pregenerated_numbers(index: u32) -> Word4 {
    midway_kernels::native::random4(index, 0, 0, 0x7ab1e).map(f32::to_bits)
}
