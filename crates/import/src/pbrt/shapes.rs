//! Shapes, as meshes in their own frame. The front is the side that pbrt's normal points to.

use glam::{Vec2, Vec3, Vec4};
use midway_scene::Mesh;

use super::{files, lex::shortened, params::Params, quadrics};
use crate::{
    ImportError,
    files::SceneFolder,
    geometry::{repair_normals, scaled_normal},
    ply,
    warning::{WarningKind, Warnings},
};

/// Quadrilaterals along each side of a bilinear patch that is no parallelogram.
const PATCH_SIDE: u32 = 8;

/// What a `Shape` comes to.
pub(super) struct Shape {
    pub mesh: Mesh,
    /// How many shapes it is to pbrt, which gives an area light's power to each.
    pub count: usize,
}

/// Reads a shape; none where it is left out, which is said.
pub(super) fn read(
    kind: &str,
    params: &Params,
    reverse_orientation: bool,
    folder: &SceneFolder,
    warnings: &mut Warnings,
) -> Result<Option<Shape>, ImportError> {
    let mesh = match kind {
        "trianglemesh" => triangle_mesh(params)?,
        "plymesh" => ply_mesh(params, folder, warnings)?,
        "bilinearmesh" => {
            let (mesh, count) = bilinear_mesh(params)?;
            return Ok(Some(Shape { mesh: facing(mesh, reverse_orientation, params, warnings), count }));
        }
        "loopsubdiv" => {
            let message = "subdivision surfaces are rendered as their control mesh, its normals smooth";
            warnings.add(WarningKind::Approximation, params.place.short(), message);
            params.ignore(&["levels", "nlevels", "scheme"]);
            smooth(triangle_mesh(params)?)
        }
        _ => match quadrics::read(kind, params)? {
            Some(mesh) => {
                let mesh = facing(mesh, reverse_orientation, params, warnings);
                return Ok(Some(Shape { mesh, count: 1 }));
            }
            None => {
                let message = format!("shapes \"{}\" are left out", shortened(kind));
                warnings.add(WarningKind::Primitive, params.place.short(), message);
                return Ok(None);
            }
        },
    };
    let count = mesh.triangles.len();
    Ok(Some(Shape { mesh: facing(mesh, reverse_orientation, params, warnings), count }))
}

fn triangle_mesh(params: &Params) -> Result<Mesh, ImportError> {
    let positions = params.points("P")?;
    let n = positions.len();
    let mut indices = params.indices("indices", "vertex", n)?;
    if indices.is_empty() && n == 3 {
        indices = vec![0, 1, 2];
    }
    if indices.is_empty() || !indices.len().is_multiple_of(3) {
        return Err(params.malformed("a mesh needs points (\"P\") and three \"indices\" a triangle"));
    }
    let triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    let mut mesh = Mesh { positions, triangles, ..Mesh::default() };
    vertex_data(params, &mut mesh)?;
    params.ignore(&["faceIndices", "discarddegenerateUVs"]);
    Ok(mesh)
}

/// Normals, tangents and texture coordinates, one a vertex.
fn vertex_data(params: &Params, mesh: &mut Mesh) -> Result<(), ImportError> {
    let n = mesh.positions.len();
    mesh.normals = params.points("N")?;
    let name = if params.has("uv") { "uv" } else { "st" };
    mesh.uvs[0] = params.points2(name)?;
    let tangents = params.points("S")?;
    for (what, len) in [("N", mesh.normals.len()), (name, mesh.uvs[0].len()), ("S", tangents.len())] {
        if len != 0 && len != n {
            return Err(params.malformed(format!("\"{what}\" has {len} values for {n} points")));
        }
    }
    mesh.tangents = tangents.into_iter().map(|t| t.normalize_or(Vec3::X).extend(1.0)).collect();
    Ok(())
}

fn ply_mesh(params: &Params, folder: &SceneFolder, warnings: &mut Warnings) -> Result<Mesh, ImportError> {
    let name = params.string("filename")?;
    let name = name.ok_or_else(|| params.malformed("a \"plymesh\" needs a \"filename\""))?;
    let bytes = files::read(folder, name, &params.place)?;
    if params.has("displacement") {
        params.ignore(&["displacement.edgelength", "edgelength"]);
        let message = "displacements are not used: meshes are rendered as modelled";
        warnings.add(WarningKind::Texture, params.place.short(), message);
    }
    let mut mesh = ply::read(&bytes, &params.place, warnings)?;
    if !mesh.colors.is_empty() {
        // pbrt does not look at them.
        mesh.colors.clear();
    }
    Ok(mesh)
}

/// Patches of four corners: (0, 0), (1, 0), (0, 1), (1, 1). Returns how many there are.
fn bilinear_mesh(params: &Params) -> Result<(Mesh, usize), ImportError> {
    let mut control = Mesh { positions: params.points("P")?, ..Mesh::default() };
    vertex_data(params, &mut control)?;
    let n = control.positions.len();
    let mut indices = params.indices("indices", "vertex", n)?;
    if indices.is_empty() && n == 4 {
        indices = vec![0, 1, 2, 3];
    }
    if indices.is_empty() || !indices.len().is_multiple_of(4) {
        return Err(params.malformed("a \"bilinearmesh\" needs points (\"P\") and four \"indices\" a patch"));
    }
    params.ignore(&["faceIndices"]);
    let mut mesh = Mesh::default();
    let mut all_flat = true;
    for patch in indices.chunks_exact(4) {
        all_flat &= add_patch(&control, [patch[0], patch[1], patch[2], patch[3]], &mut mesh);
    }
    if all_flat && control.normals.is_empty() {
        mesh.normals.clear();
    }
    Ok((mesh, indices.len() / 4))
}

/// Returns whether it is flat, one quadrilateral.
fn add_patch(control: &Mesh, corners: [u32; 4], mesh: &mut Mesh) -> bool {
    let corners = corners.map(|i| i as usize);
    let [p00, p10, p01, p11] = corners.map(|i| control.positions[i]);
    let extent = (p10 - p00).length().max((p01 - p00).length());
    let flat = (p11 - p10 - p01 + p00).length() <= 1e-4 * extent;
    let side = if flat { 1 } else { PATCH_SIDE };
    let first = mesh.positions.len() as u32;
    for j in 0..=side {
        for i in 0..=side {
            let (u, v) = (i as f32 / side as f32, j as f32 / side as f32);
            let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
            let blend = |list: &[Vec3]| {
                corners.iter().zip(weights).map(|(&i, weight)| list[i] * weight).sum::<Vec3>()
            };
            mesh.positions.push(blend(&control.positions));
            if !control.normals.is_empty() {
                mesh.normals.push(blend(&control.normals));
            } else {
                let (du, dv) = ((p10 - p00).lerp(p11 - p01, v), (p01 - p00).lerp(p11 - p10, u));
                mesh.normals.push(du.cross(dv));
            }
            let uvs = &control.uvs[0];
            mesh.uvs[0].push(if uvs.is_empty() {
                Vec2::new(u, v)
            } else {
                corners.iter().zip(weights).map(|(&i, weight)| uvs[i] * weight).sum()
            });
        }
    }
    for j in 0..side {
        for i in 0..side {
            let at = |i: u32, j: u32| first + j * (side + 1) + i;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    flat
}

/// Gives smooth normals: of the faces around each vertex, by area.
fn smooth(mut mesh: Mesh) -> Mesh {
    let mut sums = vec![glam::DVec3::ZERO; mesh.positions.len()];
    for &triangle in &mesh.triangles {
        let normal = scaled_normal(&mesh.positions, triangle);
        triangle.into_iter().for_each(|i| sums[i as usize] += normal);
    }
    mesh.normals = sums.into_iter().map(|n| n.normalize_or_zero().as_vec3()).collect();
    mesh
}

/// Turns the front to where pbrt has it: `ReverseOrientation` turns normals, and triangles follow
/// their normals where they have any.
fn facing(mut mesh: Mesh, reversed: bool, params: &Params, warnings: &mut Warnings) -> Mesh {
    if reversed {
        mesh.normals.iter_mut().for_each(|n| *n = -*n);
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    if mesh.normals.is_empty() {
        return mesh;
    }
    for triangle in &mut mesh.triangles {
        let normal: Vec3 = triangle.iter().map(|&i| mesh.normals[i as usize]).sum();
        if scaled_normal(&mesh.positions, *triangle).dot(normal.as_dvec3()) < 0.0 {
            triangle.swap(1, 2);
        }
    }
    if repair_normals(&mesh.positions, &mesh.triangles, &mut mesh.normals) > 0 {
        let message = "normals of length 0 are replaced by those of their faces";
        warnings.add(WarningKind::Repaired, params.place.short(), message);
    }
    mesh
}

/// Gives each triangle vertices of its own with pbrt's texture coordinates for those without:
/// (0, 0), (1, 0), (1, 1).
pub(super) fn with_default_uvs(mesh: Mesh) -> Mesh {
    if !mesh.uvs[0].is_empty() {
        return mesh;
    }
    let corners = mesh.triangles.as_flattened();
    let vectors = |list: &[Vec3]| -> Vec<Vec3> {
        if list.is_empty() { Vec::new() } else { corners.iter().map(|&i| list[i as usize]).collect() }
    };
    let tangents: Vec<Vec4> = match &mesh.tangents[..] {
        [] => Vec::new(),
        list => corners.iter().map(|&i| list[i as usize]).collect(),
    };
    let n = mesh.triangles.len() as u32;
    Mesh {
        positions: vectors(&mesh.positions),
        normals: vectors(&mesh.normals),
        tangents,
        uvs: [[Vec2::ZERO, Vec2::X, Vec2::ONE].repeat(n as usize), Vec::new()],
        triangles: (0..n).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        ..mesh
    }
}
