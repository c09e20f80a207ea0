//! Which medium a point lies in, by the surfaces a ray from it crosses.

use glam::Vec3;
use midway_accel::TwoLevel;
use midway_scene::{Camera, Material, Scene};

use crate::world::{Layout, World};

/// Crossings followed at most; beyond it the point counts as outside.
const MAX_CROSSINGS: usize = 256;

/// Finds the medium of points in a scene.
pub struct MediumFinder<'a> {
    /// The hierarchies over `world`.
    pub two_level: &'a TwoLevel,
    /// Vertices of the world's baked triangles.
    pub positions: &'a [[Vec3; 3]],
    /// All triangles.
    pub world: &'a World<'a>,
}

impl<'a> MediumFinder<'a> {
    /// Of a world in which any material has an inside; else there is nothing to find.
    pub fn new(two_level: &'a TwoLevel, positions: &'a [[Vec3; 3]], world: &'a World<'a>) -> Option<Self> {
        any_medium(world).then_some(Self { two_level, positions, world })
    }

    /// The material whose inside the point lies in, by the boundaries crossed on the way out along
    /// `direction`: each crossed from inside without having been entered on the way encloses the
    /// point; the first met is the innermost.
    pub fn medium_at(&self, point: Vec3, direction: Vec3) -> Option<u32> {
        let scene = self.world.scene();
        let vertices = |mesh: u32, t: u32| scene.mesh_alone(self.world.meshes[mesh as usize]).positions(t);
        let mut entered: Vec<u32> = Vec::new();
        let mut origin = point;
        for _ in 0..MAX_CROSSINGS {
            let hit = self.two_level.closest_hit(self.positions, vertices, origin, direction, f32::MAX)?;
            let triangle = self.world.triangle(self.world.id_of(&hit));
            let normal = triangle.geometric_normal()?;
            let material = triangle.material;
            if is_boundary(&scene.materials[material as usize]) {
                if normal.dot(direction) < 0.0 {
                    entered.push(material);
                } else if let Some(place) = entered.iter().rposition(|&m| m == material) {
                    entered.remove(place);
                } else {
                    return Some(material);
                }
            }
            let step = hit.t * (1.0 + 1e-5);
            origin += direction * step.max(f32::MIN_POSITIVE);
        }
        None
    }
}

/// What is kept to find the medium of cameras that come later.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraMedia {
    two_level: TwoLevel,
    positions: Vec<[Vec3; 3]>,
    layout: Layout,
}

impl CameraMedia {
    /// Of a world in which any material has an inside; else there is nothing to find.
    pub fn keep(world: &World<'_>, two_level: TwoLevel, positions: Vec<[Vec3; 3]>) -> Option<Self> {
        any_medium(world).then(|| Self { two_level, positions, layout: world.layout().clone() })
    }

    /// Finds media in the world that was packed.
    pub fn finder<'a>(&'a self, world: &'a World<'a>) -> MediumFinder<'a> {
        MediumFinder { two_level: &self.two_level, positions: &self.positions, world }
    }

    /// The medium that a camera is in. `scene` is the one that was packed.
    pub fn of_camera(&self, scene: &Scene, camera: &Camera) -> Option<u32> {
        let world = World::of_layout(scene, self.layout.clone());
        self.finder(&world)
            .medium_at(camera.position(), camera.world_from_camera.transform_vector3(Vec3::NEG_Z))
    }
}

fn any_medium(world: &World<'_>) -> bool {
    world.scene().materials.iter().any(is_boundary)
}

fn is_boundary(material: &Material) -> bool {
    material.surface.has_inside()
}
