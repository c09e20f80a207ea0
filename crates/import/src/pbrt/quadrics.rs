//! Surfaces of revolution, as triangles with true normals.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec2, dvec2};
use midway_scene::Mesh;

use super::params::Params;
use crate::ImportError;

/// Quadrilaterals around a full turn: a circle's area is met within 0.1 %.
const AROUND: usize = 96;
/// Quadrilaterals along a profile that is curved.
const ALONG: usize = 48;

/// A quadric by its type; none where it is not one.
pub(super) fn read(kind: &str, params: &Params) -> Result<Option<Mesh>, ImportError> {
    let number = |name: &str, default: f64| -> Result<f64, ImportError> {
        Ok(params.float(name)?.map_or(default, f64::from))
    };
    let phi_max = number("phimax", 360.0)?.clamp(0.0, 360.0).to_radians();
    let positive = |name: &str, value: f64| {
        if value > 0.0 { Ok(value) } else { Err(params.malformed(format!("\"{name}\" has to be above 0"))) }
    };
    let radius = positive("radius", number("radius", 1.0)?)?;
    Ok(Some(match kind {
        "sphere" => {
            let z = [number("zmin", -radius)?, number("zmax", radius)?].map(|z| z.clamp(-radius, radius));
            let angle = z.map(|z| (z / radius).clamp(-1.0, 1.0).acos());
            let (from, to) = if z[0] < z[1] { (angle[0], angle[1]) } else { (angle[1], angle[0]) };
            revolve(phi_max, ALONG, |v| {
                let (sin, cos) = (from + (to - from) * v).sin_cos();
                (dvec2(sin, cos) * radius, dvec2(sin, cos))
            })
        }
        "disk" => {
            let (height, inner) = (number("height", 0.0)?, number("innerradius", 0.0)?);
            revolve(phi_max, 1, |v| (dvec2(radius + (inner - radius) * v, height), dvec2(0.0, 1.0)))
        }
        "cylinder" => {
            let (z0, z1) = (number("zmin", -1.0)?, number("zmax", 1.0)?);
            revolve(phi_max, 1, |v| (dvec2(radius, z0 + (z1 - z0) * v), dvec2(1.0, 0.0)))
        }
        "cone" => {
            let height = positive("height", number("height", 1.0)?)?;
            let normal = dvec2(height, radius).normalize();
            revolve(phi_max, ALONG, |v| (dvec2(radius * (1.0 - v), height * v), normal))
        }
        "paraboloid" => {
            let (z0, z1) = (number("zmin", 0.0)?.max(0.0), positive("zmax", number("zmax", 1.0)?)?);
            revolve(phi_max, ALONG, |v| {
                let z = z0 + (z1 - z0) * v;
                let r = radius * (z / z1).sqrt();
                (dvec2(r, z), dvec2(2.0 * r * z1 / (radius * radius), -1.0).normalize())
            })
        }
        _ => return Ok(None),
    }))
}

/// A profile (distance from the axis and height, and the normal) for v from 0 to 1, turned about z by
/// `phi_max` radians. The front is where the normals point, and u goes with the angle.
fn revolve(phi_max: f64, along: usize, profile: impl Fn(f64) -> (DVec2, DVec2)) -> Mesh {
    let around = ((AROUND as f64 * phi_max / TAU).ceil() as usize).max(1);
    let closed = phi_max >= TAU - 1e-6;
    let mut mesh = Mesh::default();
    let rows: Vec<(DVec2, DVec2)> = (0..=along).map(|j| profile(j as f64 / along as f64)).collect();
    for (j, (place, normal)) in rows.iter().enumerate() {
        for i in 0..=around {
            // The seam is the same points, to the last bit.
            let turn = if closed { i % around } else { i };
            let (sin, cos) = (phi_max * turn as f64 / around as f64).sin_cos();
            let turned = |p: &DVec2| DVec3::new(p.x * cos, p.x * sin, p.y).as_vec3();
            mesh.positions.push(turned(place));
            mesh.normals.push(turned(normal).normalize());
            mesh.uvs[0].push(Vec2::new(i as f32 / around as f32, j as f32 / along as f32));
        }
    }
    let vertex = |i: usize, j: usize| (j * (around + 1) + i) as u32;
    // A row that has shrunk to the axis has no edge.
    let is_point =
        |j: usize| rows[j].0.x.abs() <= 1e-9 * rows.iter().map(|r| r.0.x.abs()).fold(0.0, f64::max);
    for j in 0..along {
        for i in 0..around {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            if !is_point(j) {
                mesh.triangles.push([a, b, c]);
            }
            if !is_point(j + 1) {
                mesh.triangles.push([a, c, d]);
            }
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use std::{f64::consts::PI, path::Path};

    use super::{super::lex::Lexer, *};

    fn shape(kind: &str, text: &str) -> Mesh {
        let params = Params::read(&mut Lexer::new(Path::new("a.pbrt"), text)).unwrap();
        read(kind, &params).unwrap().unwrap()
    }

    /// The area, every triangle facing as its normals do.
    fn area(mesh: &Mesh) -> f64 {
        let triangle = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3());
            let normal = t.iter().map(|&i| mesh.normals[i as usize].as_dvec3()).sum::<DVec3>();
            let cross = (b - a).cross(c - a);
            assert!(cross.dot(normal) > 0.0, "{a} {b} {c} {normal}");
            cross.length() / 2.0
        };
        mesh.triangles.iter().map(triangle).sum()
    }

    #[test]
    fn areas_are_those_of_the_books() {
        let slanted = PI * 2.0 * (4.0f64 + 9.0).sqrt();
        let bowl = PI / 6.0 * ((1.0f64 + 4.0).powf(1.5) - 1.0);
        for (kind, text, wanted) in [
            ("sphere", "\"float radius\" 2", 16.0 * PI),
            ("sphere", "\"float zmin\" 0 \"float phimax\" 180", PI),
            ("sphere", "\"float zmin\" -0.5 \"float zmax\" 0.5", 2.0 * PI),
            ("disk", "\"float radius\" 3 \"float innerradius\" 1", 8.0 * PI),
            ("disk", "\"float phimax\" 90", PI / 4.0),
            ("cylinder", "\"float zmax\" 2", 6.0 * PI),
            ("cone", "\"float radius\" 2 \"float height\" 3", slanted),
            ("paraboloid", "", bowl),
        ] {
            let found = area(&shape(kind, text));
            assert!((found / wanted - 1.0).abs() <= 2e-3, "{kind} {text}: {found} is not {wanted}");
        }
    }

    #[test]
    fn seams_close() {
        let mesh = shape("sphere", "");
        let row: Vec<_> = mesh.positions[AROUND + 1..2 * (AROUND + 1)].to_vec();
        assert_eq!(row[0], row[AROUND]);
        assert!(mesh.positions.iter().all(|p| (p.length() - 1.0).abs() <= 1e-6));
    }

    #[test]
    fn radii_have_to_be_positive() {
        let params = Params::read(&mut Lexer::new(Path::new("a.pbrt"), "\"float radius\" 0")).unwrap();
        assert!(read("sphere", &params).is_err());
    }
}
