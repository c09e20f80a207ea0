//! The world's triangles, instances resolved.

use glam::{DMat3, Mat3, Vec2, Vec3, Vec4};

use crate::{Instance, Scene};

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
    /// front stays the front; normals go by the inverse transpose.
    ///
    /// # Panics
    ///
    /// The iterator does where an index is out of range: call [`Scene::validate`] first.
    pub fn world_triangles(&self) -> impl Iterator<Item = WorldTriangle> + '_ {
        (0u32..).zip(&self.instances).flat_map(|(index, instance)| self.instance_triangles(index, instance))
    }

    fn instance_triangles<'a>(
        &'a self,
        index: u32,
        instance: &'a Instance,
    ) -> impl Iterator<Item = WorldTriangle> + 'a {
        let mesh = &self.meshes[instance.mesh as usize];
        let linear = DMat3::from_mat4(instance.world_from_mesh.as_dmat4());
        // The inverse transpose times the determinant: no division by zero.
        let cofactors = DMat3::from_cols(
            linear.y_axis.cross(linear.z_axis),
            linear.z_axis.cross(linear.x_axis),
            linear.x_axis.cross(linear.y_axis),
        );
        let mirrored = linear.determinant() < 0.0;
        let normal_sign = if mirrored { -1.0 } else { 1.0 };
        (0u32..).zip(&mesh.triangles).map(move |(triangle, corners)| {
            let [a, b, c] = corners.map(|i| i as usize);
            let corners = if mirrored { [a, c, b] } else { [a, b, c] };
            let world_normal = |n: Vec3| {
                let n = cofactors * n.as_dvec3() * normal_sign;
                n.try_normalize().map_or(Vec3::Z, |n| n.as_vec3())
            };
            let world_tangent = |t: Vec4| {
                let along = Mat3::from_mat4(instance.world_from_mesh) * t.truncate();
                along.normalize_or(Vec3::X).extend(t.w * normal_sign as f32)
            };
            let uvs = |set: &Vec<Vec2>| {
                if set.is_empty() { [Vec2::ZERO; 3] } else { corners.map(|i| set[i]) }
            };
            WorldTriangle {
                positions: corners.map(|i| instance.world_from_mesh.transform_point3(mesh.positions[i])),
                normals: (!mesh.normals.is_empty()).then(|| corners.map(|i| world_normal(mesh.normals[i]))),
                uvs: mesh.uvs.each_ref().map(uvs),
                colors: (!mesh.colors.is_empty()).then(|| corners.map(|i| mesh.colors[i])),
                tangents: (!mesh.tangents.is_empty())
                    .then(|| corners.map(|i| world_tangent(mesh.tangents[i]))),
                material: mesh.material,
                instance: index,
                triangle,
            }
        })
    }
}
