//! Midway's host scene: what an importer fills and a device packs.
//!
//! Lengths are in the file's unit (glTF: metres), radiance in W·m⁻²·sr⁻¹ as linear Rec. 709 RGB.
//! Frames are right-handed; transforms read right to left (`world_from_mesh`).

mod bounds;
mod camera;
mod error;
mod flatten;
mod hash;
mod light;
mod light_groups;
mod material;
mod power;
mod surround;
mod texture;
mod validate;

use std::sync::Arc;

use glam::{Mat4, Vec2, Vec3, Vec4};

pub use bounds::{Bounds, Sphere};
pub use error::SceneError;
pub use flatten::{PlacedMesh, WorldTriangle};
pub use light::{Environment, Light, LightKind, SpotFalloff};
pub use light_groups::{LightGroupRule, LightGroups, MAX_LIGHT_GROUPS};
pub use material::{
    CoatNormal, ConductorFresnel, MAX_DISPERSION, Material, MetallicRoughness, NormalMap, Opacity, Roughness,
    Sides, Surface,
};
pub use surround::Surround;
pub use texture::{Channel, ColorInput, Filter, Image, ScalarInput, Texels, Texture, Wrap, srgb_to_linear};

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
    /// Referred to by [`Texture::image`] and [`Environment::image`].
    pub images: Vec<Image>,
    /// Lights that are not surfaces.
    pub lights: Vec<Light>,
    /// What lies beyond everything.
    pub environment: Option<Environment>,
    /// The group of lights that the environment is put into; none for its own.
    pub environment_group: Option<Arc<str>>,
}

/// A camera: looks along its -z, y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The file's name for it, or empty.
    pub name: String,
    /// Places the camera; rigid once normalised (scale is removed by the importer).
    pub world_from_camera: Mat4,
    /// What it projects by.
    pub projection: Projection,
    /// Radius of the lens; 0 for a pinhole.
    pub lens_radius: f32,
    /// Distance along the view direction at which everything is sharp, > 0.
    pub focus_distance: f32,
    /// Width over height, where the file says.
    pub aspect: Option<f32>,
    /// Width and height in pixels, where the file says.
    pub resolution: Option<[u32; 2]>,
}

/// How a camera projects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// From a point.
    Perspective {
        /// Full vertical field of view, radians, in (0, π).
        yfov: f32,
    },
    /// Along parallel rays.
    Orthographic {
        /// Of the film in the world, > 0.
        height: f32,
    },
}

/// Triangles that share a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The file's name for it, or empty.
    pub name: String,
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one a vertex, or empty for flat shading.
    pub normals: Vec<Vec3>,
    /// Two sets of texture coordinates, each one a vertex or empty; (0, 0) is the image's top left.
    pub uvs: [Vec<Vec2>; 2],
    /// Linear RGBA that multiplies base colour and opacity, one a vertex, or empty.
    pub colors: Vec<Vec4>,
    /// Unit tangents and the bitangent's sign (w), one a vertex; empty to have them follow from the
    /// texture coordinates.
    pub tangents: Vec<Vec4>,
    /// Indices into `positions`, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`].
    pub material: u32,
}

/// A mesh in the world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Instance {
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Affine; a negative determinant flips the front.
    pub world_from_mesh: Mat4,
    /// The group of lights that it is put into where it emits, or what the file calls it; none for its
    /// mesh's name.
    pub light_group: Option<Arc<str>>,
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
    /// Images, used or not.
    pub images: usize,
    /// Lights that are not surfaces, the environment left out.
    pub lights: usize,
}

impl Scene {
    /// How much it holds. Instances of meshes that do not exist count for nothing.
    pub fn counts(&self) -> Counts {
        let mut counts = Counts {
            cameras: self.cameras.len(),
            meshes: self.meshes.len(),
            instances: self.instances.len(),
            materials: self.materials.len(),
            images: self.images.len(),
            lights: self.lights.len(),
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
