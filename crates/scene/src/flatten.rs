//! The world's triangles, instances resolved.

use glam::{DAffine3, DMat3, DVec3, Mat4, Vec2, Vec3, Vec4};

use crate::{Instance, Mesh, Scene};

/// A triangle in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldTriangle {
    /// Vertices, counter-clockwise seen from the front.
    pub positions: [Vec3; 3],
    /// Unit shading normals at the vertices; none for flat shading.
    pub normals: Option<[Vec3; 3]>,
    /// Texture coordinates at the vertices, (0, 0) where the mesh has none.
    pub uvs: [[Vec2; 3]; 2],
    /// Colours at the vertices; none for white.
    pub colors: Option<[Vec4; 3]>,
    /// Unit tangents at the vertices with the bitangent's sign; none where they follow from the
    /// texture coordinates.
    pub tangents: Option<[Vec4; 3]>,
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Index into [`Scene::instances`].
    pub instance: u32,
    /// Index into the mesh's triangles.
    pub triangle: u32,
}

impl WorldTriangle {
    /// Unit geometric normal on the front side; none where the triangle has no area.
    pub fn geometric_normal(&self) -> Option<Vec3> {
        let [a, b, c] = self.positions.map(Vec3::as_dvec3);
        (b - a).cross(c - a).try_normalize().map(|n| n.as_vec3())
    }

    /// Its area; infinite where that is beyond f32.
    pub fn area(&self) -> f32 {
        let [a, b, c] = self.positions.map(Vec3::as_dvec3);
        ((b - a).cross(c - a).length() * 0.5) as f32
    }
}

impl Scene {
    /// Every triangle in the world, in the order of instances and then of triangles, which is
    /// that of all triangle indices. A transform that mirrors swaps two vertices, so that the
    /// front stays the front; normals go by the inverse transpose. As many as instances ask for:
    /// [`Scene::placed`] has one instance's.
    ///
    /// # Panics
    ///
    /// The iterator does where an index is out of range: call [`Scene::validate`] first.
    pub fn world_triangles(&self) -> impl Iterator<Item = WorldTriangle> + '_ {
        (0..self.instances.len() as u32).flat_map(|instance| {
            let placed = self.placed(instance);
            (0..placed.n_triangles()).map(move |triangle| placed.triangle(triangle))
        })
    }

    /// An instance's triangles in the world.
    ///
    /// # Panics
    ///
    /// Where an index is out of range: call [`Scene::validate`] first.
    pub fn placed(&self, instance: u32) -> PlacedMesh<'_> {
        let Instance { mesh, world_from_mesh, .. } = &self.instances[instance as usize];
        PlacedMesh::new(&self.meshes[*mesh as usize], instance, world_from_mesh)
    }

    /// A mesh's triangles in its own frame, as if an instance had it there.
    ///
    /// # Panics
    ///
    /// Where the mesh does not exist.
    pub fn mesh_alone(&self, mesh: u32) -> PlacedMesh<'_> {
        PlacedMesh::new(&self.meshes[mesh as usize], 0, &Mat4::IDENTITY)
    }
}

/// A mesh with what places it.
#[derive(Clone, Copy, Debug)]
pub struct PlacedMesh<'a> {
    mesh: &'a Mesh,
    instance: u32,
    world_from_mesh: DAffine3,
    /// The inverse transpose times a positive factor; the determinant's sign included.
    world_from_normal: DMat3,
    is_mirrored: bool,
}

impl<'a> PlacedMesh<'a> {
    fn new(mesh: &'a Mesh, instance: u32, world_from_mesh: &Mat4) -> Self {
        let world_from_mesh = DAffine3::from_mat4(world_from_mesh.as_dmat4());
        let linear = world_from_mesh.matrix3;
        // The inverse transpose times the determinant: no division by zero.
        let cofactors = DMat3::from_cols(
            linear.y_axis.cross(linear.z_axis),
            linear.z_axis.cross(linear.x_axis),
            linear.x_axis.cross(linear.y_axis),
        );
        let is_mirrored = linear.determinant() < 0.0;
        let world_from_normal = if is_mirrored { -cofactors } else { cofactors };
        Self { mesh, instance, world_from_mesh, world_from_normal, is_mirrored }
    }

    /// The mesh.
    pub fn mesh(&self) -> &'a Mesh {
        self.mesh
    }

    /// What places it.
    pub fn world_from_mesh(&self) -> &DAffine3 {
        &self.world_from_mesh
    }

    /// Whether its transform mirrors: two vertices of each triangle are swapped.
    pub fn is_mirrored(&self) -> bool {
        self.is_mirrored
    }

    /// How many triangles it has; a mesh's indices are of 32 bits, and so many a scene can name.
    pub fn n_triangles(&self) -> u32 {
        self.mesh.triangles.len() as u32
    }

    /// A triangle's vertices, as [`PlacedMesh::triangle`] has them.
    ///
    /// # Panics
    ///
    /// Where the triangle does not exist.
    pub fn positions(&self, triangle: u32) -> [Vec3; 3] {
        self.corners(triangle).map(|i| self.place(self.mesh.positions[i]))
    }

    /// A triangle.
    ///
    /// # Panics
    ///
    /// Where it does not exist.
    pub fn triangle(&self, triangle: u32) -> WorldTriangle {
        let mesh = self.mesh;
        let corners = self.corners(triangle);
        let uvs = |set: &Vec<Vec2>| if set.is_empty() { [Vec2::ZERO; 3] } else { corners.map(|i| set[i]) };
        WorldTriangle {
            positions: corners.map(|i| self.place(mesh.positions[i])),
            normals: (!mesh.normals.is_empty()).then(|| corners.map(|i| self.place_normal(mesh.normals[i]))),
            uvs: mesh.uvs.each_ref().map(uvs),
            colors: (!mesh.colors.is_empty()).then(|| corners.map(|i| mesh.colors[i])),
            tangents: (!mesh.tangents.is_empty())
                .then(|| corners.map(|i| self.place_tangent(mesh.tangents[i]))),
            material: mesh.material,
            instance: self.instance,
            triangle,
        }
    }

    fn corners(&self, triangle: u32) -> [usize; 3] {
        let [a, b, c] = self.mesh.triangles[triangle as usize].map(|i| i as usize);
        if self.is_mirrored { [a, c, b] } else { [a, b, c] }
    }

    /// A point of the mesh's frame in the world.
    pub(crate) fn place(&self, position: Vec3) -> Vec3 {
        self.world_from_mesh.transform_point3(position.as_dvec3()).as_vec3()
    }

    fn place_normal(&self, normal: Vec3) -> Vec3 {
        (self.world_from_normal * normal.as_dvec3()).try_normalize().map_or(Vec3::Z, |n| n.as_vec3())
    }

    fn place_tangent(&self, tangent: Vec4) -> Vec4 {
        let along = self.world_from_mesh.transform_vector3(tangent.truncate().as_dvec3());
        let sign = if self.is_mirrored { -1.0 } else { 1.0 };
        along.normalize_or(DVec3::X).as_vec3().extend(tangent.w * sign)
    }
}
