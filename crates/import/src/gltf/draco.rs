//! `KHR_draco_mesh_compression`, by `draco-core`.

use std::collections::HashMap;

use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointIndex};

use super::{accessors::Accessors, json::Json};
use crate::ImportError;

pub(super) const EXTENSION: &str = "KHR_draco_mesh_compression";

/// Vertices or triangles for each compressed byte: a plane of many triangles needs little.
const ELEMENTS_PER_BYTE: u64 = 64;
/// As many as any stream may have.
const FREE_ELEMENTS: u64 = 1 << 16;
/// Bytes of attributes for each vertex: eight vectors of four floats.
const BYTES_PER_VERTEX: u64 = 128;

/// A decoded primitive.
pub(super) struct Geometry {
    mesh: Mesh,
    /// The stream's attribute of each of glTF's.
    attributes: HashMap<String, u32>,
}

/// The geometry of a primitive that has the extension; none of others. `position` is the accessor
/// that describes its vertices.
pub(super) fn geometry(
    primitive: &Json,
    accessors: &Accessors,
    position: &Json,
) -> Result<Option<Geometry>, ImportError> {
    let Some(extension) = primitive.extension(EXTENSION) else {
        return Ok(None);
    };
    let view = accessors.buffers().view(&extension.required("bufferView")?)?;
    let most = (view.bytes.len() as u64).saturating_mul(ELEMENTS_PER_BYTE).saturating_add(FREE_ELEMENTS);
    let mut limits = DecodeLimits::permissive();
    limits.max_points = accessors.count(position)?.min(most);
    limits.max_faces = most;
    limits.max_decoded_bytes = limits.max_points.saturating_mul(BYTES_PER_VERTEX);
    let mut attributes = HashMap::new();
    for (name, id) in extension.required("attributes")?.members()? {
        attributes.insert(name.to_owned(), id.unsigned()?.try_into().unwrap_or(u32::MAX));
    }
    let mut mesh = Mesh::new();
    MeshDecoder::new().decode(&mut DecoderBuffer::new(view.bytes).with_limits(limits), &mut mesh).map_err(
        |e| {
            let why: String = e.to_string().chars().take(160).filter(|c| !c.is_control()).collect();
            extension.malformed(format!("its Draco stream does not decode ({why})"))
        },
    )?;
    let n_vertices = mesh.num_points();
    if n_vertices as u64 != accessors.count(position)? {
        return Err(
            extension.malformed(format!("its Draco stream has {n_vertices} vertices, others than announced"))
        );
    }
    if mesh.faces().as_flattened().iter().any(|PointIndex(i)| *i as usize >= n_vertices) {
        return Err(extension.malformed("its Draco stream has triangles without vertices"));
    }
    Ok(Some(Geometry { mesh, attributes }))
}

impl Geometry {
    pub fn n_vertices(&self) -> usize {
        self.mesh.num_points()
    }

    pub fn triangles(&self) -> Vec<[u32; 3]> {
        self.mesh.faces().iter().map(|face| face.map(|PointIndex(i)| i)).collect()
    }

    /// An attribute by glTF's name, whole numbers that are normalized as fractions; none where the
    /// stream does not hold it, an error where it has other components.
    pub fn attribute<const N: usize>(&self, name: &str) -> Option<Result<Vec<[f32; N]>, String>> {
        let id = *self.attributes.get(name)?;
        let Some(attribute) = self.mesh.attribute_by_unique_id(id) else {
            return Some(Err(format!("the Draco stream has no attribute {id}")));
        };
        let n = usize::from(attribute.num_components());
        if n != N {
            return Some(Err(format!("the Draco stream's attribute {id} has {n} components, not {N}")));
        }
        let scale = scale(attribute);
        let values = attribute.read_f32s(self.n_vertices(), N);
        Some(Ok(values.as_chunks::<N>().0.iter().map(|v| v.map(|x| x * scale)).collect()))
    }
}

/// What a normalized attribute is multiplied by.
fn scale(attribute: &draco_core::PointAttribute) -> f32 {
    use draco_core::DataType;
    if !attribute.normalized() {
        return 1.0;
    }
    match attribute.data_type() {
        DataType::Int8 => 1.0 / 127.0,
        DataType::Uint8 => 1.0 / 255.0,
        DataType::Int16 => 1.0 / 32767.0,
        DataType::Uint16 => 1.0 / 65535.0,
        _ => 1.0,
    }
}
