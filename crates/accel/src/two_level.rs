//! Two levels: one hierarchy over the world's own triangles and over placements of meshes, and one
//! for each mesh, in the mesh's frame.

use glam::{DAffine3, DMat3, Vec3};
use midway_scene::Bounds;

use crate::{
    AccelError, BuildOptions, Child, Hierarchy, Hit, Level, MAX_REFERENCES, Quality, Width,
    traverse::traverse,
};

/// How meshes for [`TwoLevel`] are to be built: no deeper than leaves a stack room for the world,
/// and for [`MARKS`].
pub fn mesh_options(width: Width) -> BuildOptions {
    BuildOptions {
        spatial_splits: true,
        quality: Quality::Balanced,
        max_leaf_size: 4,
        max_depth: width.stack_size() - MARKS - width.balanced_depth(),
    }
}

/// What a stack holds beside what waits of both levels: its bottom, what is left of a leaf, and where the
/// ray leaves the mesh.
const MARKS: usize = 3;

/// Placed boxes are taken from so many levels of a mesh's hierarchy that these have up to 64 nodes: they
/// are tight.
const fn bounds_levels(width: Width) -> u32 {
    match width {
        Width::Binary => 6,
        Width::Wide => 2,
    }
}

/// A mesh in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Index into [`TwoLevel::meshes`].
    pub mesh: u32,
    /// Not singular.
    pub world_from_mesh: DAffine3,
}

/// A hierarchy over a world in which meshes are placed.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoLevel {
    /// Over the world's triangles, and over `placements` as its instances.
    pub world: Level,
    /// Over the triangles of each placed mesh.
    pub meshes: Vec<Level>,
    /// Where they are.
    pub placements: Vec<Placement>,
}

impl TwoLevel {
    /// Builds the world's hierarchy over its own triangles and the placements; `meshes` are of the same
    /// width, and were built with [`mesh_options`].
    ///
    /// # Errors
    ///
    /// As [`crate::build`].
    ///
    /// # Panics
    ///
    /// Where a placement's mesh is not one of `meshes`, or one of these is of another width or deeper
    /// than [`mesh_options`] allow.
    pub fn build(
        width: Width,
        triangles: &[[Vec3; 3]],
        meshes: Vec<Level>,
        placements: Vec<Placement>,
        options: &BuildOptions,
    ) -> Result<Self, AccelError> {
        assert!(meshes.iter().all(|mesh| mesh.width() == width), "meshes are of another kind");
        let deepest = meshes.iter().map(Level::max_depth).max().unwrap_or(0);
        assert!(deepest <= mesh_options(width).max_depth, "a mesh's hierarchy is too deep");
        let bounds: Vec<Bounds> = placements.iter().map(|p| p.bounds(&meshes)).collect();
        let taken = if placements.is_empty() { 1 } else { MARKS + deepest };
        let room = width.stack_size() - taken;
        let options = BuildOptions { max_depth: options.max_depth.min(room), ..*options };
        let world = Level::build(width, triangles, &bounds, &options)?;
        let two_level = Self { world, meshes, placements };
        let n_slots: usize = two_level.slots().map(|bvh| bvh.primitives().len()).sum();
        let references = n_slots.max(two_level.first_record() as usize + 4 * two_level.placements.len());
        // All are referred to by 32 bits; in the binary hierarchy slots are by 27, and two values are marks.
        let most = if width == Width::Binary { MAX_REFERENCES - 2 } else { u32::MAX as usize };
        if n_slots > most || references > u32::MAX as usize {
            return Err(AccelError::TooManyTriangles { references });
        }
        Ok(two_level)
    }

    /// Where the record of the first placement is, in vec4 of [`TwoLevel::nodes`].
    fn first_record(&self) -> u64 {
        self.slots().map(|bvh| (bvh.n_nodes() * bvh.width().node_vec4()) as u64).sum()
    }

    /// Where the record of a placement is, in vec4 of [`TwoLevel::nodes`].
    pub fn record(&self, placement: u32) -> u32 {
        self.first_record() as u32 + 4 * placement
    }

    /// Around each placement.
    pub fn placement_bounds(&self) -> Vec<Bounds> {
        self.placements.iter().map(|p| p.bounds(&self.meshes)).collect()
    }

    /// Leaf slots of both levels, the world's first, then those of each mesh.
    pub fn slots(&self) -> impl Iterator<Item = &Level> {
        std::iter::once(&self.world).chain(&self.meshes)
    }

    /// All nodes as kernels read them: the world's, those of each mesh, with references into all
    /// nodes and all [`TwoLevel::slots`], and behind them four vec4 for each placement
    /// ([`TwoLevel::record`]):
    ///
    /// | vec4 | x, y, z | w |
    /// |---|---|---|
    /// | 0, 1, 2 | a row of mesh_from_world without translation | x, y, z of what it moves the mesh by |
    /// | 3 | the mesh's root, the placement's of `first_ids`, 0 | 0 |
    ///
    /// A point p in the world is at rows · (p - moved by) in the mesh. `first_ids`: for each
    /// placement, what is added to a mesh's triangle to name it in the world.
    pub fn nodes(&self, first_ids: &[u32]) -> Vec<[u32; 4]> {
        let mut words = Vec::with_capacity(self.first_record() as usize + 4 * self.placements.len());
        let mut roots = Vec::with_capacity(self.meshes.len());
        let (mut first_node, mut first_slot) = (0, 0);
        for (level, bvh) in self.slots().enumerate() {
            if level > 0 {
                roots.push(first_node);
            }
            bvh.append_nodes(first_node, first_slot, &mut words);
            first_node += bvh.n_nodes() as u32;
            first_slot += bvh.primitives().len() as u32;
        }
        for (placement, &first_id) in self.placements.iter().zip(first_ids) {
            words.extend(placement.record(roots[placement.mesh as usize], first_id));
        }
        words
    }

    /// The closest hit with 0 < t < `t_max`, as [`crate::closest_hit`] finds it. `triangle` gives the
    /// vertices of a mesh's triangle.
    ///
    /// # Panics
    ///
    /// Where `triangles` are fewer than were built over.
    pub fn closest_hit(
        &self,
        triangles: &[[Vec3; 3]],
        triangle: impl Fn(u32, u32) -> [Vec3; 3],
        origin: Vec3,
        dir: Vec3,
        t_max: f32,
    ) -> Option<Hit> {
        let placed = |index: u32, limit: f32| {
            let Placement { mesh, world_from_mesh } = self.placements[index as usize];
            let mesh_from_world = world_from_mesh.inverse();
            let origin = mesh_from_world.transform_point3(origin.as_dvec3()).as_vec3();
            let dir = mesh_from_world.transform_vector3(dir.as_dvec3()).as_vec3();
            let bvh = &self.meshes[mesh as usize];
            let hit = traverse(bvh, |t| triangle(mesh, t), |_, _| None, origin, dir, limit)?;
            Some(Hit { placement: Some(index), ..hit })
        };
        traverse(&self.world, |t| triangles[t as usize], placed, origin, dir, t_max)
    }
}

impl Placement {
    fn bounds(&self, meshes: &[Level]) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        let mesh = &meshes[self.mesh as usize];
        let (around, n_levels) = (mesh.bounds(), bounds_levels(mesh.width()));
        let mut open = vec![(around, Child::Inner(0), 0)];
        while let Some((inside, child, level)) = open.pop() {
            match child {
                Child::Inner(node) if level < n_levels => {
                    open.extend(mesh.children(node).map(|(bounds, child)| (bounds, child, level + 1)));
                }
                _ => {
                    // Boxes of a byte a plane may reach beyond the mesh.
                    let (min, max) = (inside.min.max(around.min), inside.max.min(around.max));
                    bounds = bounds.union(Bounds { min, max }.transformed(&self.world_from_mesh));
                }
            }
        }
        bounds
    }

    fn record(&self, root: u32, first_id: u32) -> [[u32; 4]; 4] {
        let DAffine3 { matrix3, translation } = self.world_from_mesh;
        let rows: DMat3 = matrix3.inverse().transpose();
        let row = |row: glam::DVec3, moved: f64| {
            let [x, y, z] = row.as_vec3().to_array();
            [x, y, z, moved as f32].map(f32::to_bits)
        };
        [
            row(rows.x_axis, translation.x),
            row(rows.y_axis, translation.y),
            row(rows.z_axis, translation.z),
            [root, first_id, 0, 0],
        ]
    }
}
