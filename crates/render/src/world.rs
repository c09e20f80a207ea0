//! Which geometry lies in the world as it is, and which is placed: how kernels number triangles.

use glam::{DAffine3, DMat3, Vec3};
use midway_accel::{BuildOptions, Hit, Level, MAX_REFERENCES, Placement, TwoLevel, Width, mesh_options};
use midway_device::DeviceKind;
use midway_scene::{Bounds, PlacedMesh, Scene, WorldTriangle};
use rayon::prelude::*;

use crate::RenderError;

/// Meshes with several instances are baked into the world, the smallest first, as long as that adds
/// no more triangles than this, or than the scene stores: traversal is faster without instances.
const LEAST_BAKING_BUDGET: u64 = 1 << 18;

/// How much a transform there and back, and where it leads, may multiply rounding by. Rays leave
/// surfaces by 256 units in the last place (`offset_origin`); an eighth of that is for transforms.
const MAX_AMPLIFICATION: f64 = 32.0;

/// Triangles from which a GPU is quicker by the wide hierarchy. Measured (bench/NOTES.md): 36 triangles are
/// 17 % slower by it, 262,000 are 7 % quicker; nothing between.
const WIDE_ON_GPUS: usize = 10_000;

/// Which hierarchy is built: the one place to change it. Both are measured by `midway bench rays`. The
/// CPU's own traversal knows the wide one alone.
pub(crate) fn hierarchy_of(kind: DeviceKind, scene: &Scene) -> Width {
    let n_triangles: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    match kind {
        DeviceKind::Gpu if n_triangles < WIDE_ON_GPUS => Width::Binary,
        DeviceKind::Cpu | DeviceKind::Gpu | DeviceKind::SoftwareGpu => Width::Wide,
    }
}

/// The world's triangles by their ids: of baked instances first, then instance by instance those of
/// placed meshes, which share one copy of their geometry.
pub struct World<'a> {
    scene: &'a Scene,
    layout: Layout,
}

/// How a world numbers its triangles: all of it but the scene itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Baked ones first.
    parts: Vec<Part>,
    n_baked_parts: usize,
    /// Triangles of baked instances.
    pub n_baked: u32,
    /// The scene's meshes that are placed.
    pub meshes: Vec<u32>,
}

/// An instance, and the id of its first triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Index into the scene's instances.
    pub instance: u32,
    /// Id of its first triangle; the others follow.
    pub first_id: u32,
}

impl std::ops::Deref for World<'_> {
    type Target = Layout;

    fn deref(&self) -> &Layout {
        &self.layout
    }
}

impl<'a> World<'a> {
    /// The world of a scene whose layout is known.
    pub fn of_layout(scene: &'a Scene, layout: Layout) -> Self {
        Self { scene, layout }
    }

    /// Decides what is baked: what is there once, what emits (lights are triangles in the world), and
    /// of the rest the smallest, and what f32 cannot place well, as far as a budget goes.
    ///
    /// # Errors
    /// If there are more triangles than ids, or more to bake than a hierarchy can address.
    pub fn new(scene: &'a Scene) -> Result<Self, RenderError> {
        let is_baked = choose_baked(scene);
        let mut instances: Vec<u32> = (0..scene.instances.len() as u32).collect();
        instances.sort_by_key(|&i| !is_baked[i as usize]);
        let n_baked_parts = is_baked.iter().filter(|&&baked| baked).count();
        let mut parts = Vec::with_capacity(instances.len());
        let (mut next, mut n_baked) = (0u64, 0);
        for (place, instance) in instances.into_iter().enumerate() {
            let first_id = u32::try_from(next).map_err(|_| too_many_ids())?;
            parts.push(Part { instance, first_id });
            next += mesh_of(scene, instance).triangles.len() as u64;
            if place < n_baked_parts {
                n_baked = next;
            }
        }
        if n_baked > MAX_REFERENCES as u64 {
            let references = n_baked as usize;
            return Err(midway_accel::AccelError::TooManyTriangles { references }.into());
        }
        // The last id is the kernels' NONE.
        if next >= u64::from(u32::MAX) {
            return Err(too_many_ids());
        }
        let mut meshes: Vec<u32> =
            parts[n_baked_parts..].iter().map(|p| scene.instances[p.instance as usize].mesh).collect();
        meshes.sort_unstable();
        meshes.dedup();
        Ok(Self { scene, layout: Layout { parts, n_baked_parts, n_baked: n_baked as u32, meshes } })
    }

    /// The instances that are baked, in the order of their ids.
    pub fn baked(&self) -> impl Iterator<Item = PlacedMesh<'a>> + '_ {
        self.parts[..self.n_baked_parts].iter().map(|part| self.scene.placed(part.instance))
    }

    /// The others, in the order of their ids.
    pub fn placed(&self) -> &[Part] {
        &self.parts[self.n_baked_parts..]
    }

    /// How it numbers triangles.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// Vertices of the baked triangles.
    pub fn baked_positions(&self) -> Vec<[Vec3; 3]> {
        let mut positions = Vec::with_capacity(self.n_baked as usize);
        for placed in self.baked() {
            positions.par_extend((0..placed.n_triangles()).into_par_iter().map(|t| placed.positions(t)));
        }
        positions
    }

    /// The triangle of an id.
    ///
    /// # Panics
    /// Where there is none.
    pub fn triangle(&self, id: u32) -> WorldTriangle {
        let part = self.parts[self.parts.partition_point(|part| part.first_id <= id) - 1];
        self.scene.placed(part.instance).triangle(id - part.first_id)
    }

    /// The id of what a ray met.
    pub fn id_of(&self, hit: &Hit) -> u32 {
        hit.placement.map_or(0, |placement| self.placed()[placement as usize].first_id) + hit.triangle
    }

    /// Every triangle whose material emits, with its id: all of them are baked.
    pub fn emissive(&self) -> impl Iterator<Item = (u32, WorldTriangle)> + '_ {
        let emits = |placed: &PlacedMesh| self.scene.materials[placed.mesh().material as usize].is_emissive();
        let parts = self.parts[..self.n_baked_parts].iter().zip(self.baked());
        parts.filter(move |(_, placed)| emits(placed)).flat_map(|(part, placed)| {
            (0..placed.n_triangles()).map(move |t| (part.first_id + t, placed.triangle(t)))
        })
    }

    /// The hierarchies over it; `positions` as [`World::baked_positions`] has them.
    ///
    /// # Errors
    /// If there is too much to address.
    pub fn build(&self, positions: &[[Vec3; 3]], width: Width) -> Result<TwoLevel, RenderError> {
        let bottom = |&mesh: &u32| {
            let alone = self.scene.mesh_alone(mesh);
            let triangles: Vec<[Vec3; 3]> =
                (0..alone.n_triangles()).into_par_iter().map(|t| alone.positions(t)).collect();
            Level::build(width, &triangles, &[], &mesh_options(width))
        };
        let meshes = self.meshes.iter().map(bottom).collect::<Result<Vec<_>, _>>()?;
        let placements = self.placed().iter().map(|part| {
            let mesh = self.scene.instances[part.instance as usize].mesh;
            Placement {
                mesh: self.meshes.partition_point(|&m| m < mesh) as u32,
                world_from_mesh: *self.scene.placed(part.instance).world_from_mesh(),
            }
        });
        Ok(TwoLevel::build(width, positions, meshes, placements.collect(), &BuildOptions::default())?)
    }
}

fn too_many_ids() -> RenderError {
    RenderError::Settings("the instances of the scene have more than 2^32 - 2 triangles".to_owned())
}

fn mesh_of(scene: &Scene, instance: u32) -> &midway_scene::Mesh {
    &scene.meshes[scene.instances[instance as usize].mesh as usize]
}

/// For each instance whether its triangles are stored in the world.
fn choose_baked(scene: &Scene) -> Vec<bool> {
    let mut n_uses = vec![0u64; scene.meshes.len()];
    scene.instances.iter().for_each(|i| n_uses[i.mesh as usize] += 1);
    let n_stored: u64 = scene
        .meshes
        .iter()
        .zip(&n_uses)
        .filter(|(_, n)| **n > 0)
        .map(|(m, _)| m.triangles.len() as u64)
        .sum();
    let mut budget = n_stored.max(LEAST_BAKING_BUDGET);
    let mut bakes: Vec<bool> = scene
        .meshes
        .iter()
        .zip(&n_uses)
        .map(|(mesh, &n)| n <= 1 || scene.materials[mesh.material as usize].is_emissive())
        .collect();
    let extra = |mesh: usize| (n_uses[mesh] - 1) * scene.meshes[mesh].triangles.len() as u64;
    let mut by_size: Vec<usize> = (0..bakes.len()).filter(|&mesh| !bakes[mesh]).collect();
    by_size.sort_by_key(|&mesh| extra(mesh));
    for mesh in by_size {
        if extra(mesh) > budget {
            break;
        }
        budget -= extra(mesh);
        bakes[mesh] = true;
    }
    let mut is_baked: Vec<bool> = scene.instances.iter().map(|i| bakes[i.mesh as usize]).collect();
    if is_baked.iter().all(|&baked| baked) {
        return is_baked;
    }
    let bounds = scene.bounds();
    for index in 0..is_baked.len() as u32 {
        let n_triangles = mesh_of(scene, index).triangles.len() as u64;
        if !is_baked[index as usize]
            && n_triangles <= budget
            && amplification(scene.placed(index).world_from_mesh(), &bounds) > MAX_AMPLIFICATION
        {
            budget -= n_triangles;
            is_baked[index as usize] = true;
        }
    }
    is_baked
}

/// How many times the rounding of a world's coordinates a point there and back may be off:
/// ‖|A| |A⁻¹|‖ (Bauer and Skeel) times the distance from the mesh's origin, against the world's size.
/// Infinite where the scale alone leaves f32 little room for products of lengths.
fn amplification(world_from_mesh: &DAffine3, bounds: &Bounds) -> f64 {
    let linear = world_from_mesh.matrix3;
    let absolute = |m: DMat3| DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
    let product = absolute(linear) * absolute(linear.inverse());
    let rows = product.transpose();
    let condition =
        [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.element_sum()).into_iter().fold(0.0, f64::max);
    let size = bounds.min.abs().max(bounds.max.abs()).max_element();
    let moved = world_from_mesh.translation.abs().max_element();
    let scale = absolute(linear).to_cols_array().into_iter().fold(0.0, f64::max);
    if !(1e-9..=1e9).contains(&scale) {
        return f64::INFINITY;
    }
    condition * (1.0 + moved / f64::from(size).max(f64::MIN_POSITIVE))
}
