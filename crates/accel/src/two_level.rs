//! Two levels: one hierarchy over the world's own triangles and over placements of meshes, and one
//! for each mesh, in the mesh's frame.

use glam::{DAffine3, DMat3, Vec3};
use midway_scene::Bounds;

use crate::{
    AccelError, BALANCED_DEPTH, BuildOptions, Bvh, Child, Hit, MAX_REFERENCES, Quality, STACK_SIZE,
    build_with_instances, traverse::traverse,
};

/// How meshes for [`TwoLevel`] are to be built: no deeper than leaves a stack room for the world,
/// and for a mark where the ray leaves the mesh.
pub const MESH_OPTIONS: BuildOptions = BuildOptions {
    spatial_splits: true,
    quality: Quality::Balanced,
    max_leaf_size: 4,
    max_depth: STACK_SIZE - 2 - BALANCED_DEPTH,
};

/// Placed boxes are taken from this many levels of a mesh's hierarchy, so that they are tight.
const BOUNDS_LEVELS: u32 = 6;

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
    pub world: Bvh,
    /// Over the triangles of each placed mesh.
    pub meshes: Vec<Bvh>,
    /// Where they are.
    pub placements: Vec<Placement>,
}

impl TwoLevel {
    /// Builds the world's hierarchy over its own triangles and the placements; `meshes` were built
    /// with [`MESH_OPTIONS`].
    ///
    /// # Errors
    ///
    /// As [`crate::build`].
    ///
    /// # Panics
    ///
    /// Where a placement's mesh is not one of `meshes`, or one of these is deeper than
    /// [`MESH_OPTIONS`] allow.
    pub fn build(
        triangles: &[[Vec3; 3]],
        meshes: Vec<Bvh>,
        placements: Vec<Placement>,
        options: &BuildOptions,
    ) -> Result<Self, AccelError> {
        let deepest = meshes.iter().map(|mesh| mesh.max_depth).max().unwrap_or(0);
        assert!(deepest <= MESH_OPTIONS.max_depth, "a mesh's hierarchy is too deep");
        let bounds: Vec<Bounds> = placements.iter().map(|p| p.bounds(&meshes)).collect();
        // Below the world's own levels a stack holds the mark and a mesh's levels.
        let room = if placements.is_empty() { STACK_SIZE - 1 } else { STACK_SIZE - 2 - deepest };
        let options = BuildOptions { max_depth: options.max_depth.min(room), ..*options };
        let world = build_with_instances(triangles, &bounds, &options)?;
        let two_level = Self { world, meshes, placements };
        // Slots, nodes and records are all referred to by 27 bits; two values are marks.
        let n_slots: usize = two_level.slots().map(|bvh| bvh.primitives.len()).sum();
        let n_nodes: usize = two_level.slots().map(|bvh| bvh.nodes.len() / 4).sum();
        let references = n_slots.max(n_nodes + two_level.placements.len());
        if references > MAX_REFERENCES - 2 {
            return Err(AccelError::TooManyTriangles { references });
        }
        Ok(two_level)
    }

    /// Around each placement.
    pub fn placement_bounds(&self) -> Vec<Bounds> {
        self.placements.iter().map(|p| p.bounds(&self.meshes)).collect()
    }

    /// Leaf slots of both levels, the world's first, then those of each mesh.
    pub fn slots(&self) -> impl Iterator<Item = &Bvh> {
        std::iter::once(&self.world).chain(&self.meshes)
    }

    /// All nodes as kernels read them: the world's, those of each mesh, with references into all
    /// nodes and all [`TwoLevel::slots`], and behind them four vec4 for each placement, which the
    /// world's instances refer to:
    ///
    /// | vec4 | x, y, z | w |
    /// |---|---|---|
    /// | 0, 1, 2 | a row of mesh_from_world without translation | x, y, z of what it moves the mesh by |
    /// | 3 | the mesh's root, the placement's of `first_ids`, 0 | 0 |
    ///
    /// A point p in the world is at rows · (p - moved by) in the mesh. `first_ids`: for each
    /// placement, what is added to a mesh's triangle to name it in the world.
    pub fn nodes(&self, first_ids: &[u32]) -> Vec<[u32; 4]> {
        let n_nodes: usize = self.slots().map(|bvh| bvh.nodes.len()).sum();
        let mut words = Vec::with_capacity(n_nodes + 4 * self.placements.len());
        let mut roots = Vec::with_capacity(self.meshes.len());
        let (mut n_slots, first_record) = (0, n_nodes as u32 / 4);
        for (level, bvh) in self.slots().enumerate() {
            let first_node = words.len() as u32 / 4;
            if level > 0 {
                roots.push(first_node);
            }
            words.extend(bvh.nodes.chunks_exact(4).flat_map(|node| {
                let [mut a, mut b, c, d] = [node[0], node[1], node[2], node[3]];
                for reference in [&mut a[3], &mut b[3]] {
                    *reference = moved(*reference, first_node, n_slots, first_record);
                }
                [a, b, c, d]
            }));
            n_slots += bvh.primitives.len() as u32;
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
    fn bounds(&self, meshes: &[Bvh]) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        let mesh = &meshes[self.mesh as usize];
        let mut open = vec![(mesh.bounds, Child::Inner(0), 0)];
        while let Some((inside, child, level)) = open.pop() {
            match child {
                Child::Inner(node) if level < BOUNDS_LEVELS => {
                    open.extend(mesh.children(node).map(|(bounds, child)| (bounds, child, level + 1)));
                }
                _ => bounds = bounds.union(inside.transformed(&self.world_from_mesh)),
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

/// A reference of one hierarchy as it is among all of them.
fn moved(reference: u32, first_node: u32, first_slot: u32, first_record: u32) -> u32 {
    match Child::decode(reference) {
        Child::Inner(node) => Child::Inner(first_node + node),
        Child::Leaf { first, count } => Child::Leaf { first: first_slot + first, count },
        Child::Instance(placement) => Child::Instance(first_record + placement),
    }
    .encode()
}
