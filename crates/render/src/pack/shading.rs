//! What shading reads of a scene (`scene` in WGSL): all that needs no hierarchy, and what shines behind it,
//! whose media a hierarchy tells. What kernels must know of it comes first, so that they can be compiled while
//! the hierarchy is built.

use glam::Vec3;
use midway_kernels::constants as k;
use midway_scene::{Camera, Sphere, Surround};

use super::{
    PackedScene, Word4, Words,
    geometry::{has_attributes, pack_surfaces},
    lighting::Lighting,
    materials::{albedo_tables, pack_material},
    medium_or_none,
    slots::{Slots, pack_slots},
    textures::{PackedImages, TextureTable, srgb_table},
};
use crate::{RenderError, RenderSettings, features::scene_features, medium::MediumFinder, world::World};

/// What is known of it before any triangle is packed.
pub(super) struct Shading {
    /// Tables of albedos, then materials.
    words: Vec<Word4>,
    slots: Vec<Slots>,
    textures: TextureTable,
    images: PackedImages,
    n_random: u32,
    sphere: Sphere,
    lighting: Lighting,
    /// `FEATURE_*` of all that shading reads.
    pub features: u32,
}

impl Shading {
    /// Of a valid scene.
    ///
    /// # Errors
    /// If the images or the environment have more texels than kernels can address.
    pub fn of(world: &World<'_>, settings: &RenderSettings) -> Result<Self, RenderError> {
        let scene = world.scene();
        let sphere = scene.bounds().sphere();
        let lighting = Lighting::of(world, &Surround::of(scene), sphere, settings.light_sampling)?;
        let mut images = PackedImages::default();
        let mut textures = TextureTable::default();
        let mut words = albedo_tables();
        let mut slots = Vec::new();
        for material in &scene.materials {
            let (record, flags) = pack_slots(scene, material, &mut images, &mut textures);
            words.extend(pack_material(material, flags));
            slots.push(record);
        }
        images.check()?;
        let random = settings.rng.table();
        let set = [
            (!world.placed().is_empty(), k::FEATURE_INSTANCES),
            (has_attributes(world), k::FEATURE_ATTRIBUTES),
            (!textures.words().is_empty(), k::FEATURE_TEXTURES),
            (random.is_some(), k::FEATURE_RANDOM_TABLE),
        ];
        let features = set
            .iter()
            .filter(|(has, _)| *has)
            .fold(scene_features(scene) | lighting.features(), |all, (_, bit)| all | bit);
        let n_random = random.unwrap_or(0);
        Ok(Self { words, slots, textures, images, n_random, sphere, lighting, features })
    }

    /// Groups of lights, at least one.
    pub fn n_light_groups(&self) -> u32 {
        self.lighting.n_groups()
    }

    /// All of a packed scene but hierarchies, as seen by a camera. `media`: none where no material has an
    /// inside.
    pub fn pack(self, world: &World<'_>, media: Option<&MediumFinder<'_>>, camera: &Camera) -> PackedScene {
        let mut words = self.words;
        let surfaces = pack_surfaces(world, &self.lighting.lights, &mut words);
        let mut append = |part: &mut dyn Iterator<Item = Word4>| {
            let at = words.len() as u32;
            words.extend(part);
            at
        };
        let random_at = append(&mut (0..self.n_random).map(pregenerated_numbers));
        let slots_at = append(&mut self.slots.into_iter().flatten());
        let textures_at = append(&mut self.textures.words().iter().copied());
        let srgb_at = append(&mut srgb_table().into_iter());
        let mut words = Words { first: 0, words };
        let at = self.lighting.pack(world, media, &mut words);
        let forward = camera.world_from_camera.transform_vector3(Vec3::NEG_Z);
        PackedScene {
            nodes: Vec::new(),
            triangles: Vec::new(),
            scene: words.words,
            lights_at: at.lights,
            light_tree_at: at.tree.nodes,
            light_ways_at: at.tree.ways,
            environment_at: at.environment,
            sphere: self.sphere,
            surfaces_at: surfaces.surfaces,
            instances_at: surfaces.instances,
            random_at,
            n_lights: at.n_lights,
            n_baked: if world.placed().is_empty() { k::NONE } else { world.n_baked },
            n_instances: world.placed().len() as u32,
            n_random: self.n_random,
            images: self.images,
            textures_at,
            srgb_at,
            slots_at,
            light_groups: at.groups,
            camera_medium: medium_or_none(media, camera.position(), forward),
            features: self.features,
            media: None,
        }
    }
}

/// Four numbers in [0, 1) for an entry of the table: the kernels' own hash of its index.
fn pregenerated_numbers(index: u32) -> Word4 {
    midway_kernels::native::random4(index, 0, 0, 0x7ab1e).map(f32::to_bits)
}
