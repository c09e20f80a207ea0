//! A file as one mesh, for formats that bring their own materials.

use std::{collections::HashMap, path::Path};

use midway_scene::Mesh;

use super::{
    parse::{self, Corner, Obj},
    text::place_of,
};
use crate::{
    ImportError, Place,
    geometry::{MAX_TRIANGLES, triangulate},
    warning::{WarningKind, Warnings},
};

/// All faces of a file, materials, groups and smoothing disregarded. Corners that agree in position,
/// texture coordinate and normal share a vertex; normals are left out where a corner has none, texture
/// coordinates where no corner has one.
pub(crate) fn shape(path: &Path, bytes: &[u8], warnings: &mut Warnings) -> Result<Mesh, ImportError> {
    let obj = parse::parse(path, &String::from_utf8_lossy(bytes), warnings)?;
    let n_triangles: u64 = obj.faces.iter().map(|face| face.count as u64 - 2).sum();
    if n_triangles > MAX_TRIANGLES {
        let (place, what) = (Place::new(path, ""), format!("it has {n_triangles} triangles"));
        return Err(ImportError::TooBig { place, what, limit: MAX_TRIANGLES });
    }
    let has_normals = obj.corners.iter().all(|corner| corner.normal.is_some());
    let has_uvs = obj.corners.iter().any(|corner| corner.texcoord.is_some());
    let mut builder =
        Builder { obj: &obj, has_normals, has_uvs, known: HashMap::new(), mesh: Mesh::default() };
    for face in &obj.faces {
        let corners = &obj.corners[face.first..face.first + face.count];
        let outline: Vec<_> = corners.iter().map(|c| obj.positions[c.position as usize]).collect();
        let (triangles, exact) = triangulate(&outline);
        if !exact {
            let message =
                "polygons that cross themselves, or are concave with over 128 corners, may come out wrong";
            warnings.add(WarningKind::Approximation, place_of(path, face.line), message);
        }
        let vertices: Vec<u32> = corners.iter().map(|corner| builder.vertex(corner)).collect();
        builder.mesh.triangles.extend(triangles.iter().map(|t| t.map(|corner| vertices[corner])));
    }
    Ok(builder.mesh)
}

struct Builder<'a> {
    obj: &'a Obj,
    has_normals: bool,
    has_uvs: bool,
    known: HashMap<(u32, Option<u32>, Option<u32>), u32>,
    mesh: Mesh,
}

impl Builder<'_> {
    fn vertex(&mut self, corner: &Corner) -> u32 {
        let key = (corner.position, corner.texcoord, corner.normal);
        let next = self.mesh.positions.len() as u32;
        let index = *self.known.entry(key).or_insert(next);
        if index == next {
            self.mesh.positions.push(self.obj.positions[corner.position as usize]);
            if let Some(normal) = corner.normal.filter(|_| self.has_normals) {
                self.mesh.normals.push(self.obj.normals[normal as usize]);
            }
            if self.has_uvs {
                let uv = corner.texcoord.map(|uv| self.obj.texcoords[uv as usize]);
                self.mesh.uvs[0].push(uv.unwrap_or_default());
            }
        }
        index
    }
}
