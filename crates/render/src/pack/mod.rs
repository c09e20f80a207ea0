//! The scene in the kernels' layouts.

mod environment;
mod geometry;
mod light_tree;
mod lights;
mod materials;
mod normals;
mod slots;
mod textures;

use std::sync::Arc;

use glam::Vec3;
use midway_accel::Width;
use midway_device::DeviceKind;
use midway_kernels::constants as k;
use midway_scene::{Camera, Scene, Sphere};

use self::{
    environment::pack_environment,
    geometry::{pack_surfaces, pack_triangles},
    light_tree::pack_light_tree,
    lights::pack_lights,
    materials::{albedo_tables, pack_material},
    slots::pack_slots,
    textures::{PackedImages, TextureTable, mean_color, srgb_table},
};
use crate::{
    RenderError, RenderSettings,
    environment::EnvironmentMap,
    features::scene_features,
    light_tree::LightTree,
    lights::Lights,
    medium::{CameraMedia, MediumFinder},
    world::{World, hierarchy_of},
};

/// A vec4 as bits, so that no float move touches an integer.
type Word4 = [u32; 4];

/// Everything about a scene that kernels read, ready to be copied to a device.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedScene {
    /// Nodes of the hierarchies, and placements (`nodes` in WGSL).
    pub nodes: Vec<Word4>,
    /// Leaf slots (`triangles` in WGSL).
    pub triangles: Vec<Word4>,
    /// Tables of albedos, materials, lights, the environment, surfaces, instances, random numbers
    /// (`scene` in WGSL).
    pub scene: Vec<Word4>,
    /// Where lights start in `scene`, in vec4.
    pub lights_at: u32,
    /// Where the tree over lights starts, or the kernels' NONE where they are drawn by power alone.
    pub light_tree_at: u32,
    /// Where the ways to its leaves start.
    pub light_ways_at: u32,
    /// Where the environment starts, or the kernels' NONE.
    pub environment_at: u32,
    /// Around all triangles.
    pub sphere: Sphere,
    /// Where surfaces start.
    pub surfaces_at: u32,
    /// Where instances start.
    pub instances_at: u32,
    /// Where pre-generated random numbers start.
    pub random_at: u32,
    /// How many lights there are.
    pub n_lights: u32,
    /// Triangles stored as they are in the world, or the kernels' NONE where all are.
    pub n_baked: u32,
    /// Instances that share their mesh's geometry.
    pub n_instances: u32,
    /// How many pre-generated numbers there are.
    pub n_random: u32,
    /// The images, for the texel store (`texels` in WGSL).
    pub images: PackedImages,
    /// Where textures start in `scene`.
    pub textures_at: u32,
    /// Where the table of the sRGB curve starts.
    pub srgb_at: u32,
    /// Where materials' records of textures start.
    pub slots_at: u32,
    /// Groups of lights, at least one.
    pub light_groups: Vec<Arc<str>>,
    /// The medium that the camera is in, or the kernels' NONE.
    pub camera_medium: u32,
    /// What kernels need for all this: `FEATURE_*` in WGSL.
    pub features: u32,
    /// By which the medium of another camera is found, where there is any.
    pub media: Option<Arc<CameraMedia>>,
}

impl PackedScene {
    /// Packs a scene as seen by a camera for a kind of device, which decides by which hierarchy it is
    /// traversed. Of `settings` it has what is fixed from the start: pre-generated random numbers, and the
    /// tree over lights.
    ///
    /// # Errors
    /// If the scene is invalid or no hierarchy can be built over it.
    pub fn new(
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
        device: DeviceKind,
    ) -> Result<Self, RenderError> {
        scene.validate()?;
        let rng_table = settings.rng.table();
        let world = World::new(scene)?;
        let positions = world.baked_positions();
        let hierarchy = hierarchy_of(device, scene);
        let two_level = world.build(&positions, hierarchy)?;
        let sphere = scene.bounds().sphere();
        let environment = EnvironmentMap::of(scene)?;
        let emissions: Vec<Vec3> = scene.materials.iter().map(|m| mean_color(scene, &m.emission)).collect();
        let lights = Lights::collect(scene, world.emissive(), sphere, environment.as_ref(), |triangle| {
            emissions[triangle.material as usize]
        });
        let media = MediumFinder { two_level: &two_level, positions: &positions, world: &world };
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
        let lights_at = words.len() as u32;
        let groups = scene.light_groups();
        pack_lights(&lights, &groups, &world, &media, &mut words);
        let tree = LightTree::wanted(settings.light_sampling, &lights, &world, sphere.radius);
        let tree_at = pack_light_tree(tree.as_ref(), &mut words);
        let environment_at = environment.as_ref().map_or(k::NONE, |_| words.len() as u32);
        if let Some(environment) = &environment {
            pack_environment(environment, lights.environment(), &mut words);
        }
        let at = pack_surfaces(&world, &lights, &mut words);
        let random_at = words.len() as u32;
        words.extend((0..rng_table.unwrap_or(0)).map(pregenerated_numbers));
        let slots_at = words.len() as u32;
        words.extend(slots);
        let textures_at = words.len() as u32;
        words.extend(textures.words());
        let srgb_at = words.len() as u32;
        words.extend(srgb_table());
        let camera_medium = medium_or_none(
            &media,
            camera.position(),
            camera.world_from_camera.transform_vector3(Vec3::NEG_Z),
        );
        let set = [
            (!world.placed().is_empty(), k::FEATURE_INSTANCES),
            (at.has_attributes, k::FEATURE_ATTRIBUTES),
            (!textures.words().is_empty(), k::FEATURE_TEXTURES),
            (rng_table.is_some(), k::FEATURE_RANDOM_TABLE),
            (hierarchy == Width::Wide, k::FEATURE_WIDE),
            (tree_at.nodes != k::NONE, k::FEATURE_LIGHT_TREE),
        ];
        let features =
            set.iter().filter(|(has, _)| *has).fold(scene_features(scene), |all, (_, bit)| all | bit);
        let first_ids: Vec<u32> = world.placed().iter().map(|part| part.first_id).collect();
        Ok(Self {
            triangles: pack_triangles(&two_level, &world, &positions),
            nodes: two_level.nodes(&first_ids),
            media: CameraMedia::keep(&world, two_level, positions).map(Arc::new),
            scene: words,
            lights_at,
            light_tree_at: tree_at.nodes,
            light_ways_at: tree_at.ways,
            environment_at,
            sphere,
            surfaces_at: at.surfaces,
            instances_at: at.instances,
            random_at,
            n_lights: lights.lights.len() as u32,
            n_baked: if world.placed().is_empty() { k::NONE } else { world.n_baked },
            n_instances: world.placed().len() as u32,
            n_random: rng_table.unwrap_or(0),
            images,
            textures_at,
            srgb_at,
            slots_at,
            light_groups: groups.names,
            camera_medium,
            features,
        })
    }

    /// The same without what was copied to the device.
    pub fn without_copied(self) -> Self {
        let empty = Vec::new;
        Self { nodes: empty(), triangles: empty(), scene: empty(), images: PackedImages::default(), ..self }
    }
}

fn word4(v: Vec3, w: u32) -> Word4 {
    [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), w]
}

fn medium_or_none(media: &MediumFinder<'_>, point: Vec3, direction: Vec3) -> u32 {
    if media.any_medium() { media.medium_at(point, direction).unwrap_or(k::NONE) } else { k::NONE }
}

/// Four numbers in [0, 1) for an entry of the table: the kernels' own hash of its index.
fn pregenerated_numbers(index: u32) -> Word4 {
    midway_kernels::native::random4(index, 0, 0, 0x7ab1e).map(f32::to_bits)
}
