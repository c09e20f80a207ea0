//! Normals and tangents as Mitsuba makes them.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use midway_scene::Mesh;

use crate::geometry::{repair_normals, scaled_normal};

/// Faces about a point that creases are looked for among; more of them are flat.
const MOST_FACES: usize = 256;

/// How a mesh is shaded.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Shading {
    /// Without normals at vertices.
    pub flat: bool,
    /// Turned inside out.
    pub flipped: bool,
    /// v is to be counted from the other end.
    pub flips_v: bool,
    /// The bits of the angle in degrees beyond which an edge is a crease.
    pub max_angle: Option<u32>,
    /// Placed by a transform that mirrors.
    pub is_mirrored: bool,
}

/// A mesh as it is to be shaded. Mitsuba's front is where normals at vertices point, and without any
/// where corners run counter-clockwise in the world; of spheres, mirroring swaps inside and outside.
pub(super) fn shaded(mut mesh: Mesh, shading: Shading, is_sphere: bool) -> Mesh {
    if shading.flips_v {
        mesh.uvs[0].iter_mut().for_each(|uv| uv.y = 1.0 - uv.y);
    }
    let has_normals = !mesh.normals.is_empty() && !shading.flat && shading.max_angle.is_none();
    if has_normals {
        repair_normals(&mesh.positions, &mesh.triangles, &mut mesh.normals);
        turn_to_normals(&mut mesh);
    }
    let turned = shading.is_mirrored && (is_sphere || !has_normals);
    if turned != shading.flipped {
        turn(&mut mesh);
    }
    if !has_normals {
        mesh.normals.clear();
        match shading.max_angle.map(f32::from_bits) {
            _ if shading.flat => {}
            Some(angle) => crease(&mut mesh, angle),
            None => mesh.normals = smooth_normals(&mesh),
        }
    }
    mesh
}

/// Inside out.
fn turn(mesh: &mut Mesh) {
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    mesh.normals.iter_mut().for_each(|normal| *normal = -*normal);
}

/// Has corners run counter-clockwise seen from where their normals point.
fn turn_to_normals(mesh: &mut Mesh) {
    for triangle in &mut mesh.triangles {
        let normals: Vec3 = triangle.iter().map(|&i| mesh.normals[i as usize]).sum();
        if scaled_normal(&mesh.positions, *triangle).dot(normals.as_dvec3()) < 0.0 {
            triangle.swap(1, 2);
        }
    }
}

/// A corner's share of a face's normal: the angle there (Thürmer and Wüthrich 1998).
fn corner_normals(mesh: &Mesh, triangle: [u32; 3]) -> [DVec3; 3] {
    let Some(normal) = scaled_normal(&mesh.positions, triangle).try_normalize() else {
        return [DVec3::ZERO; 3];
    };
    let corners = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
    std::array::from_fn(|i| {
        let (a, b, c) = (corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]);
        normal * (b - a).angle_between(c - a)
    })
}

/// Normals at vertices: those of the faces about them, weighted by angle; +z where there is none.
fn smooth_normals(mesh: &Mesh) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for &triangle in &mesh.triangles {
        for (i, normal) in triangle.into_iter().zip(corner_normals(mesh, triangle)) {
            sums[i as usize] += normal;
        }
    }
    sums.into_iter().map(|sum| sum.try_normalize().unwrap_or(DVec3::Z).as_vec3()).collect()
}

/// Normals that are smooth up to an angle between faces, in degrees: every corner becomes a vertex.
fn crease(mesh: &mut Mesh, angle: f32) {
    let limit = f64::from(angle).to_radians().cos();
    let bits = |i: u32| mesh.positions[i as usize].to_array().map(f32::to_bits);
    let shares: Vec<[DVec3; 3]> = mesh.triangles.iter().map(|&t| corner_normals(mesh, t)).collect();
    let mut around: HashMap<[u32; 3], Vec<DVec3>> = HashMap::new();
    for (triangle, shares) in mesh.triangles.iter().zip(&shares) {
        for (&i, share) in triangle.iter().zip(shares) {
            around.entry(bits(i)).or_default().push(*share);
        }
    }
    let normal = |position: u32, own: DVec3| {
        let own = own.normalize_or_zero();
        let faces = &around[&bits(position)];
        let near = |share: &&DVec3| share.normalize_or_zero().dot(own) >= limit - 1e-9;
        let sum: DVec3 = match faces.len() {
            0..=MOST_FACES => faces.iter().filter(near).sum(),
            _ => own,
        };
        sum.try_normalize().unwrap_or(if own == DVec3::ZERO { DVec3::Z } else { own }).as_vec3()
    };
    let normals = mesh.triangles.iter().zip(&shares).flat_map(|(triangle, shares)| {
        let pairs: [(u32, DVec3); 3] = std::array::from_fn(|i| (triangle[i], shares[i]));
        pairs.map(|(position, own)| normal(position, own))
    });
    let normals: Vec<Vec3> = normals.collect();
    let corners: Vec<u32> = mesh.triangles.as_flattened().to_vec();
    mesh.positions = corners.iter().map(|&i| mesh.positions[i as usize]).collect();
    if !mesh.uvs[0].is_empty() {
        mesh.uvs[0] = corners.iter().map(|&i| mesh.uvs[0][i as usize]).collect();
    }
    mesh.triangles = (0..normals.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    mesh.normals = normals;
}

/// Tangents along growing u. Mitsuba's bitangent is normal × tangent in the world, however the
/// texture lies.
pub(super) fn add_tangents(mesh: &mut Mesh, is_mirrored: bool) {
    if mesh.uvs[0].is_empty() {
        return;
    }
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for &triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
        let [u, v, w] = triangle.map(|i| mesh.uvs[0][i as usize].as_dvec2());
        let (p, q, s, t) = (b - a, c - a, v - u, w - u);
        let determinant = s.perp_dot(t);
        let along = (p * t.y - q * s.y) * determinant.signum();
        if let Some(along) = along.try_normalize().filter(|_| determinant != 0.0) {
            triangle.into_iter().for_each(|i| sums[i as usize] += along);
        }
    }
    let sign = if is_mirrored { -1.0 } else { 1.0 };
    let tangent = |(i, sum): (usize, DVec3)| {
        let normal = mesh.normals.get(i).copied().unwrap_or(Vec3::ZERO).as_dvec3();
        let across = sum - normal * normal.dot(sum);
        let any = if normal == DVec3::ZERO { DVec3::X } else { normal.any_orthonormal_vector() };
        across.try_normalize().unwrap_or(any).as_vec3().extend(sign)
    };
    mesh.tangents = sums.into_iter().enumerate().map(tangent).collect();
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;

    const PLAIN: Shading =
        Shading { flat: false, flipped: false, flips_v: false, max_angle: None, is_mirrored: false };

    /// Two triangles that meet at a right angle along x.
    fn bent() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
            triangles: vec![[0, 1, 2], [1, 0, 3]],
            uvs: [vec![Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::NEG_Y], vec![]],
            ..Mesh::default()
        }
    }

    #[test]
    fn meshes_without_normals_are_smooth() {
        let mesh = shaded(bent(), PLAIN, false);
        // Both faces have a right angle at 0 and half of one at 1: their normals count alike.
        let between = Vec3::new(0.0, 1.0, 1.0).normalize();
        assert!((mesh.normals[0] - between).length() <= 1e-6, "{:?}", mesh.normals);
        assert_eq!(mesh.normals[2..], [Vec3::Z, Vec3::Y]);
        assert!(shaded(bent(), Shading { flat: true, ..PLAIN }, false).normals.is_empty());
    }

    #[test]
    fn creases_stay_sharp() {
        let angle = |degrees: f32| Shading { max_angle: Some(degrees.to_bits()), ..PLAIN };
        let sharp = shaded(bent(), angle(60.0), false);
        assert_eq!(sharp.normals, [[Vec3::Z; 3], [Vec3::Y; 3]].concat());
        let round = shaded(bent(), angle(100.0), false);
        assert!((round.normals[0] - Vec3::new(0.0, 1.0, 1.0).normalize()).length() <= 1e-6);
        assert_eq!(round.positions.len(), 6);
    }

    #[test]
    fn the_front_is_where_normals_point() {
        let given = Mesh { normals: vec![Vec3::NEG_Z; 4], triangles: vec![[0, 1, 2]], ..bent() };
        let mesh = shaded(given.clone(), PLAIN, false);
        assert_eq!(mesh.triangles, [[0, 2, 1]]);
        let flipped = shaded(given.clone(), Shading { flipped: true, ..PLAIN }, false);
        assert_eq!((flipped.triangles[0], flipped.normals[0]), ([0, 1, 2], Vec3::Z));
        let mirrored = Shading { is_mirrored: true, ..PLAIN };
        assert_eq!(shaded(given, mirrored, false).triangles, mesh.triangles);
        assert_eq!(shaded(bent(), mirrored, false).triangles[0], [0, 2, 1]);
    }

    #[test]
    fn tangents_lie_along_u() {
        let mut mesh = shaded(bent(), PLAIN, false);
        add_tangents(&mut mesh, true);
        assert!(mesh.tangents.iter().all(|t| (t.truncate() - Vec3::X).length() <= 1e-6 && t.w == -1.0));
    }
}
