//! The scene in the kernels' layouts.

use glam::Vec3;
use midway_accel::{BuildOptions, Bvh, build};
use midway_kernels::constants as k;
use midway_scene::{Camera, Material, Scene, Surface, WorldTriangle};

use crate::{RenderError, lights::Lights, medium::MediumFinder};

/// A vec4 as bits, so that no float move touches an integer.
type Word4 = [u32; 4];

/// Everything about a scene that kernels read, ready to be copied to a device.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedScene {
    /// Nodes of the hierarchy (`nodes` in WGSL).
    pub nodes: Vec<Word4>,
    /// Leaf slots (`triangles` in WGSL).
    pub triangles: Vec<Word4>,
    /// Materials, lights, surfaces, random numbers (`scene` in WGSL).
    pub scene: Vec<Word4>,
    /// Where lights start in `scene`, in vec4.
    pub lights_at: u32,
    /// Where surfaces start.
    pub surfaces_at: u32,
    /// Where pre-generated random numbers start.
    pub random_at: u32,
    /// How many lights there are.
    pub n_lights: u32,
    /// How many pre-generated numbers there are.
    pub n_random: u32,
    /// The medium that the camera is in, or the kernels' NONE.
    pub camera_medium: u32,
}

impl PackedScene {
    /// Packs a scene as seen by a camera. `rng_table`: how many random numbers to pre-generate.
    ///
    /// # Errors
    /// If the scene is invalid or no hierarchy can be built over it.
    pub fn new(scene: &Scene, camera: &Camera, rng_table: Option<u32>) -> Result<Self, RenderError> {
        scene.validate()?;
        let world: Vec<WorldTriangle> = scene.world_triangles().collect();
        let positions: Vec<[Vec3; 3]> = world.iter().map(|t| t.positions).collect();
        let bvh = build(&positions, &BuildOptions::default())?;
        let lights = Lights::collect(world.iter(), &scene.materials);
        let media =
            MediumFinder { bvh: &bvh, positions: &positions, triangles: &world, materials: &scene.materials };
        let mut words = Vec::new();
        for material in &scene.materials {
            words.extend(pack_material(material));
        }
        let lights_at = words.len() as u32;
        pack_lights(&lights, &world, &media, &mut words);
        let surfaces_at = words.len() as u32;
        pack_surfaces(&world, &lights, &mut words);
        let random_at = words.len() as u32;
        words.extend((0..rng_table.unwrap_or(0)).map(pregenerated_numbers));
        let camera_medium = medium_or_none(
            &media,
            camera.position(),
            camera.world_from_camera.transform_vector3(Vec3::NEG_Z),
        );
        Ok(Self {
            triangles: pack_triangles(&bvh, &positions),
            nodes: bvh.nodes,
            scene: words,
            lights_at,
            surfaces_at,
            random_at,
            n_lights: lights.lights.len() as u32,
            n_random: rng_table.unwrap_or(0),
            camera_medium,
        })
    }
}

fn word4(v: Vec3, w: u32) -> Word4 {
    [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), w]
}

fn pack_material(material: &Material) -> [Word4; k::MATERIAL_STRIDE as usize] {
    let (kind, reflectance, ior, sigma_a, thin) = match material.surface {
        Surface::Diffuse { reflectance } => (k::SURFACE_DIFFUSE, reflectance, 1.0, Vec3::ZERO, false),
        Surface::Mirror { reflectance } => (k::SURFACE_MIRROR, reflectance, 1.0, Vec3::ZERO, false),
        Surface::Dielectric { ior, tint, sigma_a, thin } => (k::SURFACE_DIELECTRIC, tint, ior, sigma_a, thin),
    };
    let back = if material.double_sided { k::MATERIAL_EMITS_BACK } else { 0 };
    let flags = back | if thin { k::MATERIAL_THIN } else { 0 };
    [word4(reflectance, kind), word4(material.emission, f32::to_bits(ior)), word4(sigma_a, flags)]
}

fn pack_triangles(bvh: &Bvh, positions: &[[Vec3; 3]]) -> Vec<Word4> {
    let mut words = Vec::with_capacity(bvh.primitives.len() * k::TRIANGLE_STRIDE as usize);
    for &primitive in &bvh.primitives {
        let [a, b, c] = positions[primitive as usize];
        words.extend([word4(a, primitive), word4(b - a, 0), word4(c - a, 0)]);
    }
    words
}

fn pack_lights(lights: &Lights, world: &[WorldTriangle], media: &MediumFinder<'_>, words: &mut Vec<Word4>) {
    for (light, entry) in lights.lights.iter().zip(&lights.table) {
        let triangle = &world[light.triangle as usize];
        let medium = triangle.geometric_normal().map_or(k::NONE, |normal| {
            let [a, b, c] = triangle.positions;
            let centre = (a + b + c) / 3.0;
            let lift = centre.abs().max_element().max((b - a).length()) * 1e-5;
            medium_or_none(media, centre + normal * lift, normal)
        });
        words.push([light.triangle, entry.pmf.to_bits(), entry.threshold.to_bits(), entry.alias]);
        words.push([light.area.to_bits(), medium, 0, 0]);
    }
}

fn medium_or_none(media: &MediumFinder<'_>, point: Vec3, direction: Vec3) -> u32 {
    if media.any_medium() { media.medium_at(point, direction).unwrap_or(k::NONE) } else { k::NONE }
}

fn pack_surfaces(world: &[WorldTriangle], lights: &Lights, words: &mut Vec<Word4>) {
    let mut light_of = vec![k::NONE; world.len()];
    for (index, light) in (0u32..).zip(&lights.lights) {
        light_of[light.triangle as usize] = index;
    }
    for (triangle, light) in world.iter().zip(light_of) {
        let [a, b, c] = triangle.positions;
        // Zero normals mean: shade with the geometric normal.
        let [n0, n1, n2] = triangle.normals.unwrap_or([Vec3::ZERO; 3]);
        words.extend([
            word4(a, triangle.material),
            word4(b - a, light),
            word4(c - a, 0),
            word4(n0, 0),
            word4(n1, 0),
            word4(n2, 0),
        ]);
    }
}

/// Four numbers in [0, 1) for an entry of the table: the kernels' own hash of its index.
fn pregenerated_numbers(index: u32) -> Word4 {
    midway_kernels::native::random4(index, 0, 0, 0x7ab1e).map(f32::to_bits)
}
