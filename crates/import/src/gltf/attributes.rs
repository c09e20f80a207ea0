//! What a primitive says of its vertices, morph targets mixed in.

use glam::{Vec2, Vec3, Vec4};
use midway_scene::Mesh;

use super::{
    accessors::{Accessors, Integers},
    draco::Geometry,
    json::Json,
};
use crate::{
    ImportError,
    geometry::repair_normals,
    warning::{WarningKind, Warnings},
};

/// Sets of texture coordinates that a mesh has room for.
const UV_SETS: [&str; 2] = ["TEXCOORD_0", "TEXCOORD_1"];
const COLOR: &str = "COLOR_0";

/// The attributes of a primitive, over those of its vertices that are used.
pub(super) struct Attributes<'p, 'a> {
    pub primitive: &'p Json<'a>,
    pub attributes: Json<'a>,
    pub accessors: &'p Accessors<'a>,
    /// Of a primitive that is compressed.
    pub geometry: Option<Geometry>,
    /// Which vertices, or all.
    pub picks: Option<Vec<u32>>,
    pub n_vertices: u64,
    /// One for each morph target.
    pub weights: &'p [f32],
}

impl Attributes<'_, '_> {
    /// Fills in what lies at vertices; the triangles are there.
    pub fn fill(&self, mut mesh: Mesh, warnings: &mut Warnings) -> Result<Mesh, ImportError> {
        mesh.positions = self.morphed("POSITION", "vertex position", Integers::Any)?;
        mesh.normals = self.morphed("NORMAL", "normal", Integers::Normalized)?;
        if repair_normals(&mesh.positions, &mesh.triangles, &mut mesh.normals) > 0 {
            let message = "normals of length 0 are replaced by those of their faces";
            warnings.add(WarningKind::Repaired, self.attributes.pointer(), message);
        }
        mesh.uvs = [self.uvs(UV_SETS[0])?, self.uvs(UV_SETS[1])?];
        mesh.colors = self.colors()?;
        mesh.tangents = self.tangents(warnings)?;
        Ok(mesh)
    }

    /// An attribute by its name; none where there is no such.
    fn vectors<const N: usize>(
        &self,
        name: &str,
        what: &'static str,
        integers: Integers,
    ) -> Result<Option<Vec<[f32; N]>>, ImportError> {
        let Some(index) = self.attributes.get(name) else {
            return Ok(None);
        };
        if let Some(own) = self.geometry.as_ref().and_then(|g| g.attribute::<N>(name)) {
            let values = own.map_err(|problem| index.malformed(problem))?;
            return self.finite(&index, self.picked(values), what).map(Some);
        }
        let count = self.accessors.count(&index)?;
        if count != self.n_vertices {
            let problem = format!("there are {count} of {name} for {} vertices", self.n_vertices);
            return Err(index.malformed(problem));
        }
        let values = self.accessors.vectors(&index, self.picks.as_deref(), integers)?;
        self.finite(&index, values, what).map(Some)
    }

    fn picked<const N: usize>(&self, values: Vec<[f32; N]>) -> Vec<[f32; N]> {
        match &self.picks {
            Some(picks) => picks.iter().map(|&i| values[i as usize]).collect(),
            None => values,
        }
    }

    fn finite<const N: usize>(
        &self,
        index: &Json,
        values: Vec<[f32; N]>,
        what: &'static str,
    ) -> Result<Vec<[f32; N]>, ImportError> {
        match values.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
            None => Ok(values),
            Some(bad) => {
                let original = self.picks.as_ref().map_or(bad as u64, |p| u64::from(p[bad]));
                Err(ImportError::NotFinite { place: index.place(), what, index: original })
            }
        }
    }

    /// Positions or normals, with the morph targets that have a weight added to them.
    fn morphed(&self, name: &str, what: &'static str, integers: Integers) -> Result<Vec<Vec3>, ImportError> {
        let base = self.vectors::<3>(name, what, integers)?.unwrap_or_default();
        let mut base: Vec<Vec3> = base.into_iter().map(Vec3::from_array).collect();
        if base.is_empty() {
            return Ok(base);
        }
        for (target, weight) in self.primitive.items("targets")?.iter().zip(self.weights) {
            let Some(index) = target.get(name).filter(|_| *weight != 0.0) else {
                continue;
            };
            let count = self.accessors.count(&index)?;
            if count != self.n_vertices {
                let problem = format!("there are {count} displacements for {} vertices", self.n_vertices);
                return Err(index.malformed(problem));
            }
            // Differences may be whole numbers of any range.
            let deltas = self.accessors.vectors::<3>(&index, self.picks.as_deref(), Integers::Any)?;
            for (value, delta) in base.iter_mut().zip(self.finite(&index, deltas, "displacement")?) {
                *value += Vec3::from_array(delta) * *weight;
            }
        }
        match base.iter().position(|v| !v.is_finite()) {
            None => Ok(base),
            Some(bad) => {
                Err(ImportError::NotFinite { place: self.primitive.place(), what, index: bad as u64 })
            }
        }
    }

    fn uvs(&self, name: &str) -> Result<Vec<Vec2>, ImportError> {
        let uvs = self.vectors::<2>(name, "texture coordinate", Integers::Any)?;
        Ok(uvs.unwrap_or_default().into_iter().map(Vec2::from_array).collect())
    }

    /// Linear RGBA; alpha is 1 where the file has none.
    fn colors(&self) -> Result<Vec<Vec4>, ImportError> {
        let Some(index) = self.attributes.get(COLOR) else {
            return Ok(Vec::new());
        };
        let colors: Vec<Vec4> = if self.accessors.kind(&index)? == "VEC3" {
            let rgb = self.vectors::<3>(COLOR, "vertex colour", Integers::Normalized)?.unwrap_or_default();
            rgb.into_iter().map(|c| Vec3::from_array(c).extend(1.0)).collect()
        } else {
            let rgba = self.vectors::<4>(COLOR, "vertex colour", Integers::Normalized)?.unwrap_or_default();
            rgba.into_iter().map(Vec4::from_array).collect()
        };
        Ok(colors.into_iter().map(|c| c.clamp(Vec4::ZERO, Vec4::ONE)).collect())
    }

    /// Unit tangents; none at all where one has no direction, so that they follow from the texture
    /// coordinates.
    fn tangents(&self, warnings: &mut Warnings) -> Result<Vec<Vec4>, ImportError> {
        let tangents = self.vectors::<4>("TANGENT", "tangent", Integers::Normalized)?.unwrap_or_default();
        let unit = |t: [f32; 4]| {
            let along = Vec3::new(t[0], t[1], t[2]).as_dvec3().try_normalize()?;
            Some(along.as_vec3().extend(if t[3] < 0.0 { -1.0 } else { 1.0 }))
        };
        let units: Option<Vec<Vec4>> = tangents.into_iter().map(unit).collect();
        if units.is_none() {
            let message = "tangents of which some have no length are computed anew";
            warnings.add(WarningKind::Repaired, self.attributes.pointer(), message);
        }
        Ok(units.unwrap_or_default())
    }
}

/// The weights of a mesh's morph targets: the node's, or else the mesh's.
pub(super) fn morph_weights(node: &Json, mesh: &Json) -> Result<Vec<f32>, ImportError> {
    let own = node.get("weights").or_else(|| mesh.get("weights"));
    own.map_or(Ok(Vec::new()), |weights| weights.elements()?.iter().map(Json::float).collect())
}

/// Attributes that are not read.
pub(super) fn warn_of_attributes(
    primitive: &Json,
    attributes: &Json,
    warnings: &mut Warnings,
) -> Result<(), ImportError> {
    for (name, index) in attributes.members()? {
        if name.starts_with("COLOR_") && name != COLOR {
            let message = "vertex colours beyond the first set are not used";
            warnings.add(WarningKind::VertexColour, index.pointer(), message);
        }
    }
    for target in primitive.items("targets")? {
        for (name, index) in target.members()? {
            if !matches!(name, "POSITION" | "NORMAL" | "TANGENT") {
                let message = "of morph targets, positions and normals are used";
                warnings.add(WarningKind::MorphTarget, index.pointer(), message);
            }
        }
    }
    Ok(())
}
