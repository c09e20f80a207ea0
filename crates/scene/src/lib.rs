//! Midway's host scene: what an importer fills and a device packs.
//!
//! Lengths are in the file's unit (glTF: metres), radiance in W·m⁻²·sr⁻¹ as linear Rec. 709 RGB.
//! Frames are right-handed; transforms read right to left (`world_from_mesh`).

mod bounds;
mod camera;
mod error;
mod flatten;
mod hash;
mod validate;

use glam::{Mat4, Vec3};

pub use bounds::Bounds;
pub use error::SceneError;
pub use flatten::WorldTriangle;

/// Everything that is rendered. Indices are valid once [`Scene::validate`] has passed.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The first is used unless another is asked for.
    pub cameras: Vec<Camera>,
    /// Geometry in its own frame.
    pub meshes: Vec<Mesh>,
    /// Meshes placed in the world.
    pub instances: Vec<Instance>,
    /// Surfaces, referred to by [`Mesh::material`].
    pub materials: Vec<Material>,
}

/// A perspective camera: looks along its -z, y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The file's name for it, or empty.
    pub name: String,
    /// Places the camera; rigid once normalised (scale is removed by the importer).
    pub world_from_camera: Mat4,
    /// Full vertical field of view, radians, in (0, π).
    pub yfov: f32,
    /// Width over height, where the file says.
    pub aspect: Option<f32>,
}

/// Triangles that share a material.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// The file's name for it, or empty.
    pub name: String,
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one a vertex, or empty for flat shading.
    pub normals: Vec<Vec3>,
    /// Indices into `positions`, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`].
    pub material: u32,
}

/// A mesh in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Affine; a negative determinant flips the front.
    pub world_from_mesh: Mat4,
}

/// A surface: how it scatters and what it emits.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The file's name for it, or empty.
    pub name: String,
    /// How it scatters.
    pub surface: Surface,
    /// Emitted radiance, W·m⁻²·sr⁻¹; zero for none.
    pub emission: Vec3,
    /// Whether it emits from its back too (it scatters on both sides either way).
    pub double_sided: bool,
}

/// How a surface scatters.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// Lambertian on both sides, reflectance in [0, 1].
    Diffuse {
        /// Albedo.
        reflectance: Vec3,
    },
    /// A perfect mirror on both sides: reflectance at normal incidence, Schlick towards 1.
    Mirror {
        /// F0.
        reflectance: Vec3,
    },
    /// A smooth dielectric boundary.
    Dielectric {
        /// Index of refraction inside over outside, > 0.
        ior: f32,
        /// Multiplies what is transmitted, in [0, 1].
        tint: Vec3,
        /// Absorption coefficient inside, per unit length (Beer-Lambert).
        sigma_a: Vec3,
        /// A thin wall: transmits without bending and has no inside.
        thin: bool,
    },
}

/// How much a scene holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Cameras.
    pub cameras: usize,
    /// Meshes, each counted once.
    pub meshes: usize,
    /// Placements of meshes.
    pub instances: usize,
    /// Triangles in the world: a mesh's, once for each of its instances.
    pub triangles: usize,
    /// Those of `triangles` that emit.
    pub emissive_triangles: usize,
    /// Materials, used or not.
    pub materials: usize,
}

impl Scene {
    /// How much it holds. Instances of meshes that do not exist count for nothing.
    pub fn counts(&self) -> Counts {
        let mut counts = Counts {
            cameras: self.cameras.len(),
            meshes: self.meshes.len(),
            instances: self.instances.len(),
            materials: self.materials.len(),
            ..Counts::default()
        };
        for instance in &self.instances {
            let Some(mesh) = self.meshes.get(instance.mesh as usize) else {
                continue;
            };
            counts.triangles += mesh.triangles.len();
            let material = self.materials.get(mesh.material as usize);
            if material.is_some_and(Material::is_emissive) {
                counts.emissive_triangles += mesh.triangles.len();
            }
        }
        counts
    }
}

impl Material {
    /// Whether it emits anything.
    pub fn is_emissive(&self) -> bool {
        self.emission.max_element() > 0.0
    }
}
