//! Scenes put together in code.

use std::collections::HashMap;

use glam::{Mat4, Vec3};
use midway_scene::{Camera, Instance, Material, Mesh, Scene, Surface};

/// A diffuse surface that emits from its front.
pub fn diffuse(reflectance: Vec3, emission: Vec3) -> Material {
    Material::new(Surface::diffuse(reflectance)).emitting(emission)
}

/// A mirror of the same reflectance in all directions only if it is 1.
pub fn mirror(reflectance: f32) -> Material {
    Material::new(Surface::mirror(Vec3::splat(reflectance)))
}

/// Clear glass.
pub fn glass(ior: f32) -> Material {
    Material::new(Surface::glass(ior))
}

/// Triangles without a material.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// Positions of the vertices.
    pub positions: Vec<Vec3>,
    /// Normals at the vertices, or empty.
    pub normals: Vec<Vec3>,
    /// Counter-clockwise from the front.
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// The parallelogram with a corner and two edges; its front is where u x v points.
    pub fn parallelogram(corner: Vec3, u: Vec3, v: Vec3) -> Self {
        let positions = vec![corner, corner + u, corner + u + v, corner + v];
        Self { positions, normals: Vec::new(), triangles: vec![[0, 1, 2], [0, 2, 3]] }
    }

    /// A cuboid, its fronts outside; walls in the order -x, +x, -y, +y, -z, +z, two triangles each.
    pub fn cuboid(least: Vec3, most: Vec3) -> Self {
        let size = most - least;
        let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
        let walls = [
            (least, z, y),
            (least + x, y, z),
            (least, x, z),
            (least + y, z, x),
            (least, y, x),
            (least + z, x, y),
        ];
        let mut cuboid = Self::default();
        for (corner, u, v) in walls {
            cuboid.append(&Self::parallelogram(corner, u, v));
        }
        cuboid
    }

    /// An icosahedron, each triangle cut in four so many times, on a sphere; flat, fronts outside.
    pub fn icosphere(cuts: u32, centre: Vec3, radius: f32) -> Self {
        let mut sphere = icosahedron();
        for _ in 0..cuts {
            sphere = sphere.cut();
        }
        sphere.positions.iter_mut().for_each(|p| *p = centre + radius * *p);
        sphere
    }

    /// With the normals of a sphere about `centre`.
    pub fn smooth(mut self, centre: Vec3) -> Self {
        self.normals = self.positions.iter().map(|p| (p - centre).normalize()).collect();
        self
    }

    /// With fronts and backs exchanged.
    pub fn inside_out(mut self) -> Self {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self.normals.iter_mut().for_each(|n| *n = -*n);
        self
    }

    /// The triangles whose number `keeps`, and the others.
    pub fn split(self, keeps: impl Fn(usize) -> bool) -> (Self, Self) {
        let (mut kept, mut rest) = (self.clone(), self);
        let mut index = 0..;
        kept.triangles.retain(|_| keeps(index.next().unwrap_or_default()));
        let mut index = 0..;
        rest.triangles.retain(|_| !keeps(index.next().unwrap_or_default()));
        (kept, rest)
    }

    /// The area of all triangles.
    pub fn area(&self) -> f64 {
        let corner = |i: u32| self.positions[i as usize].as_dvec3();
        let area =
            |&[a, b, c]: &[u32; 3]| 0.5 * (corner(b) - corner(a)).cross(corner(c) - corner(a)).length();
        self.triangles.iter().map(area).sum()
    }

    /// Adds another shape's triangles.
    pub fn append(&mut self, other: &Self) {
        let offset = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.normals.extend(&other.normals);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + offset)));
    }

    fn cut(&self) -> Self {
        let mut positions = self.positions.clone();
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let middle = (positions[a as usize] + positions[b as usize]).normalize();
                positions.push(middle);
                positions.len() as u32 - 1
            })
        };
        let mut triangles = Vec::with_capacity(self.triangles.len() * 4);
        for &[a, b, c] in &self.triangles {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            triangles.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        Self { positions, normals: Vec::new(), triangles }
    }
}

fn icosahedron() -> Shape {
    let golden = f32::midpoint(1.0, 5.0f32.sqrt());
    let mut positions = Vec::new();
    for axis in 0..3 {
        for (a, b) in [(-1.0, -golden), (-1.0, golden), (1.0, -golden), (1.0, golden)] {
            let mut p = [0.0; 3];
            p[axis] = a;
            p[(axis + 1) % 3] = b;
            positions.push(Vec3::from_array(p).normalize());
        }
    }
    // Faces are the triples of vertices an edge apart.
    let near = |a: usize, b: usize| positions[a].dot(positions[b]) > 0.4;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in (b + 1..12).filter(|&c| near(a, b) && near(b, c) && near(c, a)) {
                let outwards = positions[a].cross(positions[b]).dot(positions[c]) > 0.0;
                triangles.push(if outwards { [a, b, c] } else { [a, c, b] }.map(|i| i as u32));
            }
        }
    }
    Shape { positions, normals: Vec::new(), triangles }
}

/// Adds a shape of one material.
pub fn add(scene: &mut Scene, shape: Shape, material: Material) {
    scene.instances.push(Instance {
        mesh: scene.meshes.len() as u32,
        world_from_mesh: Mat4::IDENTITY,
        light_group: None,
    });
    scene.meshes.push(Mesh {
        name: String::new(),
        positions: shape.positions,
        normals: shape.normals,
        triangles: shape.triangles,
        material: scene.materials.len() as u32,
        ..Mesh::default()
    });
    scene.materials.push(material);
}

/// A camera at `eye` that looks at `target`; the field of view in degrees.
pub fn camera(eye: Vec3, target: Vec3, fov: f32) -> Camera {
    Camera::look_at(eye, target, Vec3::Y, fov.to_radians()).expect("a camera")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_closed_and_face_outwards() {
        let sphere = Shape::icosphere(3, Vec3::ONE, 2.0);
        assert_eq!(sphere.triangles.len(), 20 * 64);
        let (area, ball) = (sphere.area(), 16.0 * std::f64::consts::PI);
        assert!(area < ball && area > 0.99 * ball, "{area}");
        assert!((Shape::cuboid(-Vec3::ONE, Vec3::ONE).area() - 24.0).abs() < 1e-6);
        for (shape, centre) in [(sphere, Vec3::ONE), (Shape::cuboid(-Vec3::ONE, Vec3::ONE), Vec3::ZERO)] {
            for [a, b, c] in shape.triangles.iter().map(|t| t.map(|i| shape.positions[i as usize])) {
                assert!((b - a).cross(c - a).dot(a - centre) > 0.0);
            }
        }
    }
}
