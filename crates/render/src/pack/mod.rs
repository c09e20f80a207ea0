//! The scene in the kernels' layouts.

mod environment;
mod geometry;
mod light_tree;
mod lighting;
mod lights;
mod materials;
mod normals;
mod shading;
mod slots;
mod textures;

use std::sync::Arc;

use glam::Vec3;
use midway_accel::Width;
use midway_device::DeviceKind;
use midway_kernels::constants as k;
use midway_scene::{Camera, Opacity, Scene, Sphere, Surround};
use rayon::prelude::*;

use self::{
    geometry::pack_triangles, lighting::Lighting, shading::Shading, slots::is_absent, textures::PackedImages,
};
use crate::{
    RenderError, RenderSettings,
    medium::{CameraMedia, MediumFinder},
    world::{World, hierarchy_of},
};

/// A vec4 as bits, so that no float move touches an integer.
type Word4 = [u32; 4];

/// Words of a kernels' buffer from a place in it on.
#[derive(Default)]
struct Words {
    first: u32,
    words: Vec<Word4>,
}

impl Words {
    /// The place of the next.
    fn next(&self) -> u32 {
        self.first + self.words.len() as u32
    }

    fn extend(&mut self, words: impl IntoIterator<Item = Word4>) {
        self.words.extend(words);
    }

    /// By all cores.
    fn par_extend(&mut self, words: impl IndexedParallelIterator<Item = Word4>) {
        self.words.par_extend(words);
    }
}

/// A scene on its way to be packed: what kernels must know of it to be compiled is known first, hierarchies
/// come last.
pub struct Packing<'a> {
    world: World<'a>,
    hierarchy: Width,
    shading: Shading,
}

impl<'a> Packing<'a> {
    /// Begins to pack a scene for a kind of device, which decides by which hierarchy it is traversed. Of
    /// `settings` it has what is fixed from the start: pre-generated random numbers, and the tree over lights.
    ///
    /// # Errors
    /// If the scene is invalid, or its images or environment have more texels than kernels can address.
    pub fn new(scene: &'a Scene, settings: &RenderSettings, device: DeviceKind) -> Result<Self, RenderError> {
        scene.validate()?;
        let world = World::new(scene)?;
        let hierarchy = hierarchy_of(device, scene);
        let mut shading = Shading::of(&world, settings)?;
        shading.features |= if hierarchy == Width::Wide { k::FEATURE_WIDE } else { 0 };
        Ok(Self { world, hierarchy, shading })
    }

    /// What kernels need for the scene: `FEATURE_*` in WGSL.
    pub fn features(&self) -> u32 {
        self.shading.features
    }

    /// Groups of lights, at least one.
    pub fn n_light_groups(&self) -> u32 {
        self.shading.n_light_groups()
    }

    /// Builds the hierarchies and packs everything, as seen by a camera.
    ///
    /// # Errors
    /// If no hierarchy can be built over the scene.
    pub fn finish(self, camera: &Camera) -> Result<PackedScene, RenderError> {
        let Self { world, hierarchy, shading } = self;
        let positions = world.baked_positions();
        // One after the other: at once they take a third more memory, and hardly less time.
        let two_level = world.build(&positions, hierarchy)?;
        let media = MediumFinder::new(&two_level, &positions, &world);
        let packed = shading.pack(&world, media.as_ref(), camera);
        let first_ids: Vec<u32> = world.placed().iter().map(|part| part.first_id).collect();
        Ok(PackedScene {
            triangles: pack_triangles(&two_level, &world, &positions),
            nodes: two_level.nodes(&first_ids),
            media: CameraMedia::keep(&world, two_level, positions).map(Arc::new),
            ..packed
        })
    }
}

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
    /// Packs a scene as seen by a camera, as [`Packing`] does.
    ///
    /// # Errors
    /// As [`Packing::new`] and [`Packing::finish`].
    pub fn new(
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
        device: DeviceKind,
    ) -> Result<Self, RenderError> {
        Packing::new(scene, settings, device)?.finish(camera)
    }

    /// The same scene with something else around it. Of the words of `scene` it has those from `lights_at`
    /// on alone; those before, hierarchies and images stay as they are. `scene` and `settings` are those that
    /// this was packed from, whatever is around the scene by now.
    ///
    /// # Errors
    /// If what is to be around it is invalid.
    pub fn surrounded(
        self,
        scene: &Scene,
        surround: &Surround,
        settings: &RenderSettings,
    ) -> Result<Self, RenderError> {
        surround.validate()?;
        let world = World::new(scene)?;
        let media = self.media.as_ref().map(|media| media.finder(&world));
        let lighting = Lighting::of(&world, surround, self.sphere, settings.light_sampling)?;
        let features = self.features & !lighting::FEATURES | lighting.features();
        let mut words = Words { first: self.lights_at, words: Vec::new() };
        let at = lighting.pack(&world, media.as_ref(), &mut words);
        Ok(Self {
            scene: words.words,
            light_tree_at: at.tree.nodes,
            light_ways_at: at.tree.ways,
            environment_at: at.environment,
            n_lights: at.n_lights,
            light_groups: at.groups,
            features,
            ..self.without_copied()
        })
    }

    /// The same geometry with other materials of the scene's, seen by a camera. Hierarchies and images stay as
    /// they are: `nodes` and `triangles` are left empty. None where they cannot stay: what is opaque, or what is
    /// stored where, is other than `before`, the scene that this was packed from. `scene` differs from that in
    /// [`midway_scene::Mesh::material`] alone; `settings` are those that this was packed by.
    ///
    /// # Errors
    /// If the scene is invalid.
    pub fn dressed(
        &self,
        before: &Scene,
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<Option<Self>, RenderError> {
        scene.validate()?;
        let world = World::new(scene)?;
        let solid = |scene: &Scene, mesh: usize| is_solid(scene, scene.meshes[mesh].material);
        if world.layout() != World::new(before)?.layout()
            || (0..scene.meshes.len()).any(|mesh| solid(before, mesh) != solid(scene, mesh))
        {
            return Ok(None);
        }
        let media = self.media.as_ref().map(|media| media.finder(&world));
        let packed = Shading::of(&world, settings)?.pack(&world, media.as_ref(), camera);
        let features = packed.features | self.features & k::FEATURE_WIDE;
        Ok(Some(Self { features, media: self.media.clone(), ..packed }))
    }

    /// The same without what was copied to the device.
    pub fn without_copied(self) -> Self {
        let empty = Vec::new;
        Self { nodes: empty(), triangles: empty(), scene: empty(), images: PackedImages::default(), ..self }
    }
}

/// Whether every ray that meets a material ends there.
fn is_solid(scene: &Scene, material: u32) -> bool {
    let material = &scene.materials[material as usize];
    material.opacity == Opacity::Opaque && !is_absent(material)
}

fn word4(v: Vec3, w: u32) -> Word4 {
    [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), w]
}

/// `media`: none where no material has an inside.
fn medium_or_none(media: Option<&MediumFinder<'_>>, point: Vec3, direction: Vec3) -> u32 {
    media.and_then(|media| media.medium_at(point, direction)).unwrap_or(k::NONE)
}
