//! What the formats share: strips, normals, budgets.

use glam::{DVec3, Vec3};

/// The most triangles a world may have, each instance counted: their ids are 32 bits. How many may
/// be stored the acceleration structure says, and what the files hold.
pub(crate) const MAX_TRIANGLES: u64 = u32::MAX as u64 - 1;
/// The most placements of meshes.
pub(crate) const MAX_INSTANCES: u64 = 1 << 22;

/// Twice the area times the normal, without overflow.
pub(crate) fn scaled_normal(positions: &[Vec3], [a, b, c]: [u32; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|i| positions[i as usize].as_dvec3());
    (b - a).cross(c - a)
}

/// Makes normals unit; those that have no direction become the average of their faces', or +z
/// where those have none either. Returns how many had none.
pub(crate) fn repair_normals(positions: &[Vec3], triangles: &[[u32; 3]], normals: &mut [Vec3]) -> usize {
    let mut directionless = vec![false; normals.len()];
    for (n, bad) in normals.iter_mut().zip(&mut directionless) {
        match n.as_dvec3().try_normalize() {
            Some(unit) => *n = unit.as_vec3(),
            None => *bad = true,
        }
    }
    let n_bad = directionless.iter().filter(|&&bad| bad).count();
    if n_bad == 0 {
        return 0;
    }
    let mut sums = vec![DVec3::ZERO; normals.len()];
    for &triangle in triangles.iter().filter(|t| t.iter().any(|&i| directionless[i as usize])) {
        let normal = scaled_normal(positions, triangle);
        triangle.into_iter().for_each(|i| sums[i as usize] += normal);
    }
    for ((n, sum), _) in normals.iter_mut().zip(sums).zip(directionless).filter(|(_, bad)| *bad) {
        *n = sum.try_normalize().unwrap_or(DVec3::Z).as_vec3();
    }
    n_bad
}

/// The triangles of a polygon, as indices of its corners: a fan where it is convex, ears cut off
/// where it is not. False where a fan had to do though it is not convex.
pub(crate) fn triangulate(corners: &[Vec3]) -> (Vec<[usize; 3]>, bool) {
    // Cutting ears takes the cube of the number of corners at worst.
    const MOST_EARS: usize = 128;
    let n = corners.len();
    let fan = || (1..n.saturating_sub(1)).map(|i| [0, i, i + 1]).collect();
    let normal = (0..n).fold(DVec3::ZERO, |sum, i| {
        let (a, b) = (corners[i].as_dvec3(), corners[(i + 1) % n].as_dvec3());
        sum + (a - corners[0].as_dvec3()).cross(b - corners[0].as_dvec3())
    });
    let turn = |a: usize, b: usize, c: usize| {
        let [a, b, c] = [a, b, c].map(|i| corners[i].as_dvec3());
        (b - a).cross(c - a).dot(normal)
    };
    let convex = (0..n).all(|i| turn(i, (i + 1) % n, (i + 2) % n) >= 0.0);
    if n <= 3 || convex {
        return (fan(), true);
    }
    let ears = if n <= MOST_EARS { cut_ears(n, turn) } else { None };
    ears.map_or_else(|| (fan(), false), |ears| (ears, true))
}

/// None where no ear is left before three corners are: the outline crosses itself.
fn cut_ears(n: usize, turn: impl Fn(usize, usize, usize) -> f64) -> Option<Vec<[usize; 3]>> {
    let mut left: Vec<usize> = (0..n).collect();
    let mut triangles = Vec::with_capacity(n - 2);
    while left.len() > 3 {
        let m = left.len();
        let ear = (0..m).find(|&i| {
            let (a, b, c) = (left[(i + m - 1) % m], left[i], left[(i + 1) % m]);
            let inside = |p: usize| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
            turn(a, b, c) > 0.0 && !left.iter().any(|&p| ![a, b, c].contains(&p) && inside(p))
        })?;
        triangles.push([left[(ear + m - 1) % m], left[ear], left[(ear + 1) % m]]);
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]]);
    Some(triangles)
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;

    fn area(corners: &[Vec3], triangles: &[[usize; 3]]) -> f64 {
        let signed = |t: &[usize; 3]| scaled_normal(corners, t.map(|i| i as u32)).z / 2.0;
        triangles.iter().map(signed).sum()
    }

    #[test]
    fn concave_polygons_are_covered_once() {
        let l = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
        for start in 0..l.len() {
            let corners: Vec<Vec3> =
                (0..6).map(|i| l[(start + i) % 6]).map(|(x, y)| vec3(x, y, 0.0)).collect();
            let (triangles, exact) = triangulate(&corners);
            assert!(exact);
            assert_eq!(triangles.len(), 4);
            assert!(triangles.iter().all(|t| area(&corners, &[*t]) > 0.0), "start {start}");
            assert!((area(&corners, &triangles) - 3.0).abs() <= 1e-12);
        }
    }

    #[test]
    fn odd_polygons_give_a_fan() {
        assert!(triangulate(&[Vec3::ZERO, Vec3::X]).0.is_empty());
        assert_eq!(triangulate(&[Vec3::ONE; 5]).0.len(), 3);
        let crossing = [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| vec3(x, y, 0.0));
        assert_eq!(triangulate(&crossing).0.len(), 2);
        let mut comb: Vec<Vec3> =
            (0..300).map(|i| vec3(300.0 - i as f32, 1.0 + (i % 2) as f32, 0.0)).collect();
        comb.extend([Vec3::ZERO, Vec3::X * 300.0]);
        let (triangles, exact) = triangulate(&comb);
        assert_eq!((triangles.len(), exact), (300, false));
    }

    #[test]
    fn normals_without_direction_become_their_faces() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE];
        let mut normals = [Vec3::ZERO, Vec3::X * 9.0, Vec3::splat(1e-30), Vec3::ZERO];
        assert_eq!(repair_normals(&positions, &[[0, 1, 2]], &mut normals), 2);
        assert_eq!(normals[..2], [Vec3::Z, Vec3::X]);
        assert!((normals[2].length() - 1.0).abs() <= 1e-6);
        assert_eq!(normals[3], Vec3::Z);
    }
}
