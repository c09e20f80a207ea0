//! Meshes.

use std::{collections::HashMap, f64::consts::PI};

use glam::{DVec3, dvec3};

/// Corners of a quadrilateral, in order around it.
pub type Quad = [DVec3; 4];
/// 20 480 triangles with smooth normals: one more level is four times the file and no other caustic.
const SPHERE_SUBDIVISIONS: usize = 5;

/// Vertices, with normals where it is not flat.
pub struct Shape {
    pub positions: Vec<DVec3>,
    pub normals: Option<Vec<DVec3>>,
    pub uvs: Option<Vec<[f64; 2]>>,
    pub triangles: Vec<[u32; 3]>,
}

/// Which side of a quadrilateral is its front.
#[derive(Clone, Copy)]
pub enum Front {
    /// The one that faces this way.
    Along(DVec3),
    /// The one that faces away from this point.
    From(DVec3),
}

pub fn quads(quads: &[Quad], front: Front) -> Shape {
    let mut shape = Shape { positions: Vec::new(), normals: None, uvs: None, triangles: Vec::new() };
    for quad in quads {
        let wanted = match front {
            Front::Along(direction) => direction,
            Front::From(point) => quad.iter().sum::<DVec3>() / 4.0 - point,
        };
        let mut quad = *quad;
        if (quad[1] - quad[0]).cross(quad[2] - quad[0]).dot(wanted) < 0.0 {
            quad.reverse();
        }
        let first = shape.positions.len() as u32;
        shape.positions.extend(quad);
        shape.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i| first + i)));
    }
    shape
}

/// An icosahedron, each triangle cut into four so many times, with smooth normals.
pub fn sphere(centre: DVec3, radius: f64) -> Shape {
    let t = f64::midpoint(1.0, 5f64.sqrt());
    let mut directions: Vec<DVec3> = Vec::new();
    for turn in 0..3 {
        for (a, b) in [(-1.0, t), (1.0, t), (-1.0, -t), (1.0, -t)] {
            let corner = [dvec3(a, b, 0.0), dvec3(0.0, a, b), dvec3(b, 0.0, a)][turn];
            directions.push(corner.normalize());
        }
    }
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..SPHERE_SUBDIVISIONS {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                directions.push((directions[a as usize] + directions[b as usize]).normalize());
                directions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    let positions = directions.iter().map(|d| centre + *d * radius).collect();
    Shape { positions, normals: Some(directions), uvs: None, triangles }
}

/// A sphere about the origin, of rings of longitude and latitude, so that images wrap around it.
pub fn globe(radius: f64) -> Shape {
    const COLUMNS: u32 = 64;
    const ROWS: u32 = 32;
    let mut shape = Shape { positions: vec![], normals: None, uvs: None, triangles: vec![] };
    let (mut normals, mut uvs) = (vec![], vec![]);
    for row in 0..=ROWS {
        for column in 0..=COLUMNS {
            let [u, v] = [f64::from(column) / f64::from(COLUMNS), f64::from(row) / f64::from(ROWS)];
            let (sin, cos) = (v * PI).sin_cos();
            let (z, x) = (u * 2.0 * PI).sin_cos();
            normals.push(dvec3(x * sin, cos, -z * sin));
            uvs.push([u, v]);
        }
    }
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let a = row * (COLUMNS + 1) + column;
            let c = a + COLUMNS + 1;
            // At the poles one of the two is a line.
            let both = [[a, c, c + 1], [a, c + 1, a + 1]];
            let there = [row + 1 < ROWS, row > 0];
            shape.triangles.extend(both.into_iter().zip(there).filter_map(|(t, is)| is.then_some(t)));
        }
    }
    shape.positions = normals.iter().map(|n| *n * radius).collect();
    (shape.normals, shape.uvs) = (Some(normals), Some(uvs));
    shape
}

/// A rectangle from corner to corner, an image's left lower corner at the first.
pub fn pictured(quad: Quad, repeats: f64) -> Shape {
    Shape {
        positions: quad.to_vec(),
        normals: None,
        uvs: Some(
            [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].map(|uv| uv.map(|x| x * repeats)).to_vec(),
        ),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// A rectangle about a centre at a height.
pub fn horizontal(x: f64, z: f64, half_x: f64, half_z: f64, y: f64) -> Quad {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(a, b)| dvec3(x + a * half_x, y, z + b * half_z))
}
