//! PLY (Stanford): text and binary of either byte order; polygons of any number of corners.
//!
//! Every element takes at least a byte of the file, so that no count in a header can ask for more
//! than the file holds.

mod body;
mod header;

use std::path::Path;

use glam::{Mat4, Vec2, Vec3, Vec4};
use midway_scene::{Instance, Mesh, Scene};

use crate::{
    ImportError, Place, default_material, files,
    geometry::{MAX_TRIANGLES, repair_normals, triangulate},
    warning::{WarningKind, Warnings},
};
use body::Body;
use header::{Element, Header, Property, Scalar};

/// A PLY file as a scene of one mesh: diffuse grey, or of its vertices' colours.
pub(crate) fn load(path: &Path, warnings: &mut Warnings) -> Result<Scene, ImportError> {
    let bytes = files::read_scene(path, false)?;
    let mut mesh = read(&bytes, &Place::new(path, ""), warnings)?;
    // Its writers have v grow upwards.
    mesh.uvs[0].iter_mut().for_each(|uv| uv.y = 1.0 - uv.y);
    let mut material = default_material();
    if !mesh.colors.is_empty() {
        // Colours multiply it.
        material.surface = midway_scene::Surface::diffuse(Vec3::ONE);
    }
    Ok(Scene {
        meshes: vec![mesh],
        instances: vec![Instance { mesh: 0, world_from_mesh: Mat4::IDENTITY, light_group: None }],
        materials: vec![material],
        ..Scene::default()
    })
}

/// The mesh in a PLY file, of material 0. Texture coordinates are as the file has them; colours of
/// whole numbers are sRGB, of floats linear.
///
/// # Errors
///
/// [`ImportError`] where the file breaks its format's rules or ends too soon.
pub(crate) fn read(file: &[u8], place: &Place, warnings: &mut Warnings) -> Result<Mesh, ImportError> {
    let header = header::parse(file, place)?;
    let mut reader = Reader {
        body: Body::new(&file[header.bytes..], header.format),
        mesh: Mesh::default(),
        faces: Vec::new(),
        corners: Vec::new(),
        place,
    };
    reader.elements(&header, warnings)?;
    reader.finish(warnings)
}

struct Reader<'a> {
    body: Body<'a>,
    mesh: Mesh,
    /// How many of `corners` each face has.
    faces: Vec<u32>,
    corners: Vec<u32>,
    place: &'a Place,
}

/// What a vertex's number is: which of [`SLOTS`].
type Slot = Option<usize>;

/// Places of a vertex's numbers, by the names that files give them.
const SLOTS: [&[&str]; 12] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx", "normal_x"],
    &["ny", "normal_y"],
    &["nz", "normal_z"],
    &["u", "s", "texture_u", "texture_s"],
    &["v", "t", "texture_v", "texture_t"],
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
    &["alpha", "a", "diffuse_alpha"],
];

fn slot(property: &Property) -> Slot {
    if property.length.is_some() {
        return None;
    }
    SLOTS.iter().position(|names| names.contains(&property.name.as_str()))
}

impl Reader<'_> {
    fn malformed(&self, problem: impl Into<String>) -> ImportError {
        ImportError::Malformed { place: self.place.clone(), problem: problem.into() }
    }

    fn ended(&self, element: &Element) -> ImportError {
        self.malformed(format!(
            "its {} {:?} are cut short, or hold no numbers",
            element.count,
            shortened(&element.name)
        ))
    }

    fn elements(&mut self, header: &Header, warnings: &mut Warnings) -> Result<(), ImportError> {
        for element in header.elements.iter().filter(|e| !e.properties.is_empty()) {
            // Each takes a byte at least.
            if element.count > self.body.len() as u64 {
                return Err(self.ended(element));
            }
            match element.name.as_str() {
                "vertex" if self.mesh.positions.is_empty() => self.vertices(element)?,
                "face" => self.polygons(element)?,
                "tristrips" => self.strips(element)?,
                other => {
                    if element.count > 0 {
                        let message = format!("{:?} elements are not used", shortened(other));
                        warnings.add(WarningKind::Unused, self.place.short(), message);
                    }
                    self.skip(element)?;
                }
            }
        }
        Ok(())
    }

    fn skip(&mut self, element: &Element) -> Result<(), ImportError> {
        for _ in 0..element.count {
            for property in &element.properties {
                self.skip_property(property).ok_or_else(|| self.ended(element))?;
            }
        }
        Ok(())
    }

    fn skip_property(&mut self, property: &Property) -> Option<()> {
        let n = match property.length {
            Some(length) => length_of(self.body.next(length)?)?,
            None => 1,
        };
        (0..n).try_for_each(|_| self.body.next(property.kind).map(drop))
    }

    fn vertices(&mut self, element: &Element) -> Result<(), ImportError> {
        if element.count > u64::from(u32::MAX) {
            let (place, what) = (self.place.clone(), "too many vertices".to_owned());
            return Err(ImportError::TooBig { place, what, limit: u64::from(u32::MAX) });
        }
        let slots: Vec<Slot> = element.properties.iter().map(slot).collect();
        let has = |range: std::ops::Range<usize>| range.into_iter().all(|i| slots.contains(&Some(i)));
        if !has(0..3) {
            return Err(self.malformed("its vertices have no x, y and z"));
        }
        let (normals, uvs, colors) = (has(3..6), has(6..8), has(8..11));
        let scales: Vec<Option<f64>> = element.properties.iter().map(|p| whole_scale(p.kind)).collect();
        for index in 0..element.count {
            let mut v = [0.0; SLOTS.len()];
            v[11] = 1.0;
            for ((property, slot), scale) in element.properties.iter().zip(&slots).zip(&scales) {
                let Some(slot) = *slot else {
                    self.skip_property(property).ok_or_else(|| self.ended(element))?;
                    continue;
                };
                let value = self.body.next(property.kind).ok_or_else(|| self.ended(element))?;
                v[slot] = match (slot, scale) {
                    (8..11, Some(scale)) => linear_from_srgb(value / scale),
                    (11, Some(scale)) => value / scale,
                    _ => value,
                };
            }
            let v = v.map(|x| x as f32);
            if !v.iter().all(|x| x.is_finite()) {
                return Err(ImportError::NotFinite { place: self.place.clone(), what: "vertex", index });
            }
            self.mesh.positions.push(Vec3::new(v[0], v[1], v[2]));
            if normals {
                self.mesh.normals.push(Vec3::new(v[3], v[4], v[5]));
            }
            if uvs {
                self.mesh.uvs[0].push(Vec2::new(v[6], v[7]));
            }
            if colors {
                self.mesh.colors.push(Vec4::new(v[8], v[9], v[10], v[11]));
            }
        }
        Ok(())
    }

    fn polygons(&mut self, element: &Element) -> Result<(), ImportError> {
        for _ in 0..element.count {
            for property in &element.properties {
                let is_corners = matches!(property.name.as_str(), "vertex_indices" | "vertex_index");
                if let (Some(length), true) = (property.length, is_corners) {
                    let n = self.list(length, property.kind).ok_or_else(|| self.ended(element))?;
                    self.faces.push(n);
                } else {
                    self.skip_property(property).ok_or_else(|| self.ended(element))?;
                }
            }
        }
        Ok(())
    }

    /// Appends a list to the corners, and says how many they are.
    fn list(&mut self, length: Scalar, kind: Scalar) -> Option<u32> {
        let n = length_of(self.body.next(length)?)?;
        for _ in 0..n {
            // What is no index is found out of range with those that are too large.
            self.corners.push(self.body.next_index(kind)?);
        }
        u32::try_from(n).ok()
    }

    /// Strips of triangles with -1 between them.
    fn strips(&mut self, element: &Element) -> Result<(), ImportError> {
        for _ in 0..element.count {
            for property in &element.properties {
                let start = self.corners.len();
                match property.length {
                    Some(length) => self.list(length, property.kind).map(drop),
                    None => self.skip_property(property),
                }
                .ok_or_else(|| self.ended(element))?;
                let strip = self.corners.split_off(start);
                for run in strip.split(|&i| i == u32::MAX) {
                    for (i, w) in run.windows(3).enumerate() {
                        let triangle = if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
                        self.corners.extend(triangle);
                        self.faces.push(3);
                    }
                }
            }
        }
        Ok(())
    }

    fn finish(mut self, warnings: &mut Warnings) -> Result<Mesh, ImportError> {
        let n_vertices = self.mesh.positions.len();
        if let Some(bad) = self.corners.iter().find(|&&i| i as usize >= n_vertices) {
            let (place, index) = (self.place.clone(), i64::from(*bad as i32));
            return Err(ImportError::OutOfRange { place, what: "vertex", index, len: n_vertices as u64 });
        }
        let n_triangles: u64 = self.faces.iter().map(|n| u64::from(n.saturating_sub(2))).sum();
        if n_triangles > MAX_TRIANGLES {
            let (place, what) = (self.place.clone(), format!("it has {n_triangles} triangles"));
            return Err(ImportError::TooBig { place, what, limit: MAX_TRIANGLES });
        }
        self.mesh.triangles = self.triangles(n_triangles as usize, warnings);
        let mesh = &mut self.mesh;
        if repair_normals(&mesh.positions, &mesh.triangles, &mut mesh.normals) > 0 {
            let message = "normals of length 0 are replaced by those of their faces";
            warnings.add(WarningKind::Repaired, self.place.short(), message);
        }
        Ok(self.mesh)
    }

    fn triangles(&self, n_triangles: usize, warnings: &mut Warnings) -> Vec<[u32; 3]> {
        let mut triangles = Vec::with_capacity(n_triangles);
        let mut rest = &self.corners[..];
        for &n in &self.faces {
            let (corners, after) = rest.split_at(n as usize);
            rest = after;
            if let &[a, b, c] = corners {
                triangles.push([a, b, c]);
                continue;
            }
            let outline: Vec<Vec3> = corners.iter().map(|&i| self.mesh.positions[i as usize]).collect();
            let (own, exact) = triangulate(&outline);
            if !exact {
                let message = "polygons that cross themselves, or are concave with over 128 corners, may come out wrong";
                warnings.add(WarningKind::Approximation, self.place.short(), message);
            }
            triangles.extend(own.iter().map(|t| t.map(|i| corners[i])));
        }
        triangles
    }
}

/// A list's length; none where it is none.
fn length_of(value: f64) -> Option<u64> {
    (value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value)).then_some(value as u64)
}

/// What stands for 1 in a colour of whole numbers; none for floats.
fn whole_scale(kind: Scalar) -> Option<f64> {
    match kind {
        Scalar::F32 | Scalar::F64 => None,
        whole => Some(2f64.powi(8 * whole.bytes() as i32) - 1.0),
    }
}

/// IEC 61966-2-1.
pub(crate) fn linear_from_srgb(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

fn shortened(name: &str) -> String {
    name.chars().take(40).map(|c| if c.is_control() { '?' } else { c }).collect()
}
