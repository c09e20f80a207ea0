//! Shapes that Mitsuba knows by formula, as meshes in their own frame. Curved ones are as fine as keeps
//! silhouettes within 3 · 10⁻⁴ of a radius, and widened until their area, and so what they emit, is right.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use midway_scene::Mesh;

use crate::geometry::scaled_normal;

/// Segments about an axis, and from pole to pole.
const AROUND: u32 = 128;
const ALONG: u32 = 64;

/// From (-1, -1, 0) to (1, 1, 0), facing +z.
pub(super) fn rectangle() -> Mesh {
    let uvs = vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    Mesh {
        positions: uvs.iter().map(|uv| (2.0 * *uv - 1.0).extend(0.0)).collect(),
        normals: vec![Vec3::Z; 4],
        uvs: [uvs, vec![]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// From (-1, -1, -1) to (1, 1, 1), faces with the texture coordinates that Mitsuba gives them.
pub(super) fn cube() -> Mesh {
    // Each face's normal, the way u grows, and the way v does.
    let faces = [
        (Vec3::NEG_Y, Vec3::Z, Vec3::X),
        (Vec3::Y, Vec3::NEG_X, Vec3::NEG_Z),
        (Vec3::X, Vec3::Y, Vec3::NEG_Z),
        (Vec3::Z, Vec3::Y, Vec3::X),
        (Vec3::NEG_X, Vec3::Y, Vec3::Z),
        (Vec3::NEG_Z, Vec3::NEG_Y, Vec3::X),
    ];
    let mut mesh = Mesh::default();
    for (normal, u, v) in faces {
        let first = mesh.positions.len() as u32;
        for uv in [Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO] {
            mesh.positions.push(normal + u * (2.0 * uv.x - 1.0) + v * (2.0 * uv.y - 1.0));
            mesh.normals.push(normal);
            mesh.uvs[0].push(uv);
        }
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    mesh
}

/// Of radius 1; u about z, v from +z.
pub(super) fn sphere() -> Mesh {
    let mut mesh = grid(ALONG, |u, v| {
        let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = ((TAU * u).sin_cos(), (PI * v).sin_cos());
        let normal = Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta);
        (normal, normal)
    });
    widen(&mut mesh, 4.0 * PI, Vec3::ONE);
    mesh
}

/// Of radius 1 along z from 0 to 1, open at both ends, facing away from its axis.
pub(super) fn cylinder() -> Mesh {
    let mut mesh = grid(1, |u, v| {
        let (sin, cos) = (TAU * u).sin_cos();
        (Vec3::new(cos, sin, v), Vec3::new(cos, sin, 0.0))
    });
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    // Its area grows with the radius, and not with its square.
    let area = area(&mesh);
    let by = (f64::from(TAU) / area) as f32;
    mesh.positions.iter_mut().for_each(|p| *p *= Vec3::new(by, by, 1.0));
    mesh
}

/// Of radius 1 in z = 0, facing +z; u from the centre, v about it.
pub(super) fn disk() -> Mesh {
    let mut mesh = grid(1, |u, v| {
        let (sin, cos) = (TAU * u).sin_cos();
        (Vec3::new(cos, sin, 0.0) * v, Vec3::Z)
    });
    mesh.uvs[0].iter_mut().for_each(|uv| *uv = Vec2::new(uv.y, uv.x));
    widen(&mut mesh, PI, Vec3::new(1.0, 1.0, 0.0));
    mesh
}

/// A surface over (u, v) in [0, 1]², `rows` segments along v, its front where the normals point.
fn grid(rows: u32, point: impl Fn(f32, f32) -> (Vec3, Vec3)) -> Mesh {
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=AROUND {
            let (u, v) = (column as f32 / AROUND as f32, row as f32 / rows as f32);
            let (position, normal) = point(u, v);
            mesh.positions.push(position);
            mesh.normals.push(normal);
            mesh.uvs[0].push(Vec2::new(u, v));
        }
    }
    let at = |row: u32, column: u32| row * (AROUND + 1) + column;
    for row in 0..rows {
        for column in 0..AROUND {
            let corners =
                [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
            let [a, b, c, d] = corners;
            let triangles = [[a, b, c], [a, c, d]].into_iter().filter(|t| has_area(&mesh, *t));
            let triangles: Vec<_> = triangles.collect();
            mesh.triangles.extend(triangles);
        }
    }
    mesh
}

/// At a pole one of two triangles has none.
fn has_area(mesh: &Mesh, triangle: [u32; 3]) -> bool {
    triangle_area(mesh, triangle) > 1e-9
}

fn triangle_area(mesh: &Mesh, triangle: [u32; 3]) -> f64 {
    0.5 * scaled_normal(&mesh.positions, triangle).length()
}

fn area(mesh: &Mesh) -> f64 {
    mesh.triangles.iter().map(|&t| triangle_area(mesh, t)).sum()
}

/// Scales along `axes` so that the area is as given.
fn widen(mesh: &mut Mesh, to: f32, axes: Vec3) {
    let by = (f64::from(to) / area(mesh)).sqrt() as f32;
    let scale = axes * by + (Vec3::ONE - axes);
    mesh.positions.iter_mut().for_each(|p| *p *= scale);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_and_silhouettes_are_right() {
        let cases =
            [(sphere(), 4.0 * PI), (cylinder(), TAU), (disk(), PI), (cube(), 24.0), (rectangle(), 4.0)];
        for (mesh, expected) in cases {
            assert!(
                (area(&mesh) / f64::from(expected) - 1.0).abs() <= 1e-5,
                "{} is not {expected}",
                area(&mesh)
            );
        }
        let radii = sphere().positions.iter().map(|p| (p.length() - 1.0).abs()).fold(0.0, f32::max);
        assert!(radii <= 5e-4, "{radii}");
    }

    #[test]
    fn fronts_face_where_normals_point() {
        for (mesh, n_least) in
            [(sphere(), 16_000), (cylinder(), 256), (disk(), 128), (cube(), 12), (rectangle(), 2)]
        {
            assert!(mesh.triangles.len() >= n_least);
            for &[a, b, c] in &mesh.triangles {
                let [p, q, r] = [a, b, c].map(|i| mesh.positions[i as usize]);
                assert!((q - p).cross(r - p).dot(mesh.normals[a as usize]) > 0.0, "{p} {q} {r}");
            }
        }
    }

    /// Texture coordinates that Mitsuba 3.9.1 gives at these points.
    #[test]
    fn texture_coordinates_lie_as_in_mitsuba() {
        let near = |mesh: Mesh, point: Vec3, uv: Vec2| {
            let distance = |i: &usize| mesh.positions[*i].distance(point);
            let at = (0..mesh.positions.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
            assert!(mesh.uvs[0][at].distance(uv) <= 0.02, "{point}: {}", mesh.uvs[0][at]);
        };
        near(sphere(), Vec3::new(-0.9747, 0.1, 0.2), Vec2::new(0.4837, 0.4359));
        near(sphere(), Vec3::new(0.1, 0.2, -0.9747), Vec2::new(0.1762, 0.9282));
        near(disk(), Vec3::new(-0.6, 0.8, 0.0), Vec2::new(1.0, 0.3524));
        near(cylinder(), Vec3::new(0.1, -0.995, 0.0), Vec2::new(0.7659, 0.0));
        near(cube(), Vec3::new(1.0, -1.0, -1.0), Vec2::Y);
        near(rectangle(), Vec3::new(-1.0, 1.0, 0.0), Vec2::Y);
    }
}
