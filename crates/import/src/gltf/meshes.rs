//! Meshes: one of the scene's for each primitive of the file's.

use std::collections::HashMap;

use midway_scene::Mesh;

use super::{
    accessors::Accessors,
    attributes::{Attributes, morph_weights, warn_of_attributes},
    draco,
    json::Json,
    variants::Variants,
    warn_of_extensions,
};
use crate::{
    ImportError,
    warning::{WarningKind, Warnings},
};

/// The document's meshes, read where a node asks for them.
pub(super) struct Meshes<'a> {
    definitions: Vec<Json<'a>>,
    /// The scene's meshes of each of the file's that was read, by the weights of its morph targets
    /// as bits.
    read: HashMap<(usize, Vec<u32>), Vec<u32>>,
    list: Vec<Mesh>,
    accessors: Accessors<'a>,
    n_materials: usize,
    variants: &'a Variants,
    /// What all of them mean for `list`.
    offered: crate::Variants,
    /// The place in `offered` of each primitive that was read.
    offered_at: HashMap<String, u32>,
    uses_default_material: bool,
}

/// `mode` of a primitive.
const TRIANGLES: u64 = 4;
const TRIANGLE_STRIP: u64 = 5;
const TRIANGLE_FAN: u64 = 6;

impl<'a> Meshes<'a> {
    pub fn new(
        root: &Json<'a>,
        accessors: Accessors<'a>,
        n_materials: usize,
        variants: &'a Variants,
    ) -> Result<Self, ImportError> {
        Ok(Self {
            definitions: root.items("meshes")?,
            read: HashMap::new(),
            list: Vec::new(),
            accessors,
            n_materials,
            variants,
            offered: crate::Variants::new(variants.names().to_vec()),
            offered_at: HashMap::new(),
            uses_default_material: false,
        })
    }

    /// Whether a mesh has the material after the file's own, which is the default one.
    pub fn uses_default_material(&self) -> bool {
        self.uses_default_material
    }

    /// The scene's meshes, and what the file's variants mean for them.
    pub fn into_parts(self) -> (Vec<Mesh>, crate::Variants) {
        (self.list, self.offered)
    }

    /// Triangles of one of the scene's meshes.
    pub fn n_triangles(&self, mesh: u32) -> u64 {
        self.list[mesh as usize].triangles.len() as u64
    }

    pub fn accessors(&self) -> &Accessors<'a> {
        &self.accessors
    }

    /// The scene's meshes for the mesh of a node, its morph targets as the node or else the mesh
    /// weighs them.
    pub fn of(
        &mut self,
        node: &Json,
        index: &Json,
        warnings: &mut Warnings,
    ) -> Result<Vec<u32>, ImportError> {
        let i = index.index("mesh", self.definitions.len())?;
        let definition = self.definitions[i].clone();
        let weights = morph_weights(node, &definition)?;
        let key = (i, weights.iter().map(|w| w.to_bits()).collect());
        if let Some(known) = self.read.get(&key) {
            return Ok(known.clone());
        }
        warn_of_extensions(&definition, warnings)?;
        let mut own = Vec::new();
        for primitive in definition.required("primitives")?.elements()? {
            if let Some(mesh) = self.primitive(&primitive, definition.name(), &weights, warnings)? {
                own.push(self.list.len() as u32);
                self.list.push(mesh);
                self.offer(&primitive)?;
            }
        }
        self.read.insert(key, own.clone());
        Ok(own)
    }

    /// None for what is not triangles.
    fn primitive(
        &mut self,
        primitive: &Json,
        name: String,
        weights: &[f32],
        warnings: &mut Warnings,
    ) -> Result<Option<Mesh>, ImportError> {
        let mode = primitive.unsigned_or("mode", TRIANGLES)?;
        if !(TRIANGLES..=TRIANGLE_FAN).contains(&mode) {
            warnings.add(WarningKind::Primitive, primitive.pointer(), "points and lines are not rendered");
            return Ok(None);
        }
        warn_of_extensions(primitive, warnings)?;
        let attributes = primitive.required("attributes")?;
        warn_of_attributes(primitive, &attributes, warnings)?;
        let Some(position) = attributes.get("POSITION") else {
            warnings.add(
                WarningKind::Primitive,
                primitive.pointer(),
                "primitives without positions are not rendered",
            );
            return Ok(None);
        };
        let geometry = draco::geometry(primitive, &self.accessors, &position)?;
        let (n_vertices, corners) = match &geometry {
            Some(geometry) => (geometry.n_vertices() as u64, geometry.triangles()),
            None => {
                let n = self.accessors.count(&position)?;
                (n, self.corners(primitive, mode, n)?)
            }
        };
        if corners.is_empty() {
            warnings.add(
                WarningKind::Primitive,
                primitive.pointer(),
                "primitives with no triangle are left out",
            );
            return Ok(None);
        }
        let material = self.material(primitive)?;
        let vertices = Vertices::choose(corners, n_vertices);
        let source = Attributes {
            primitive,
            attributes,
            accessors: &self.accessors,
            geometry,
            picks: vertices.picks,
            n_vertices,
            weights,
        };
        let mesh = Mesh { name, triangles: vertices.triangles, material, ..Mesh::default() };
        source.fill(mesh, warnings).map(Some)
    }

    fn material(&mut self, primitive: &Json) -> Result<u32, ImportError> {
        let of_variant = self.variants.material(primitive)?;
        if let Some(index) = of_variant.or_else(|| primitive.get("material")) {
            return Ok(index.index("material", self.n_materials)? as u32);
        }
        self.uses_default_material = true;
        Ok(self.n_materials as u32)
    }

    /// Notes what each variant would give the mesh that was read last.
    fn offer(&mut self, primitive: &Json) -> Result<(), ImportError> {
        if self.variants.names().is_empty() {
            return Ok(());
        }
        let place = match self.offered_at.get(primitive.pointer()) {
            Some(&place) => place,
            None => {
                let own = match primitive.get("material") {
                    Some(index) => index.index("material", self.n_materials)?,
                    None => {
                        self.uses_default_material = true;
                        self.n_materials
                    }
                };
                let choices = self.variants.choices(primitive, own as u32, self.n_materials);
                let place = self.offered.add(choices);
                self.offered_at.insert(primitive.pointer().to_owned(), place);
                place
            }
        };
        self.offered.add_mesh(place);
        Ok(())
    }

    /// The vertices of each triangle, checked.
    fn corners(&self, primitive: &Json, mode: u64, n_vertices: u64) -> Result<Vec<[u32; 3]>, ImportError> {
        let indices = match primitive.get("indices") {
            None => {
                self.accessors.charge(primitive, n_vertices)?;
                (0..u32::try_from(n_vertices).unwrap_or(u32::MAX)).collect()
            }
            Some(index) => {
                let indices = self.accessors.indices(&index)?;
                if let Some(&bad) = indices.iter().find(|&&i| u64::from(i) >= n_vertices) {
                    let (place, index) = (index.place(), i64::from(bad));
                    return Err(ImportError::OutOfRange { place, what: "vertex", index, len: n_vertices });
                }
                indices
            }
        };
        if mode != TRIANGLES {
            self.accessors.charge(primitive, indices.len() as u64 * 2)?;
        }
        Ok(match mode {
            TRIANGLE_STRIP => indices
                .windows(3)
                .enumerate()
                .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
                .collect(),
            TRIANGLE_FAN => indices.windows(2).skip(1).map(|w| [indices[0], w[0], w[1]]).collect(),
            _ => indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
        })
    }
}

/// Triangles over those vertices that a primitive uses: files share one long accessor between
/// many primitives.
struct Vertices {
    triangles: Vec<[u32; 3]>,
    /// Which of the accessor's vertices, or all.
    picks: Option<Vec<u32>>,
}

impl Vertices {
    fn choose(mut triangles: Vec<[u32; 3]>, n_vertices: u64) -> Self {
        if triangles.len() as u64 * 3 >= n_vertices / 2 {
            return Self { triangles, picks: None };
        }
        let mut picks = Vec::new();
        let mut renumbered = HashMap::new();
        for corner in triangles.as_flattened_mut() {
            let original = *corner;
            *corner = *renumbered.entry(original).or_insert_with(|| {
                picks.push(original);
                picks.len() as u32 - 1
            });
        }
        Self { triangles, picks: Some(picks) }
    }
}
