//! The geometry file, as lists.

use std::{collections::HashMap, path::Path};

use glam::{Vec2, Vec3};

use super::text::{Line, joined, lines};
use crate::{
    ImportError,
    ply::linear_from_srgb,
    warning::{WarningKind, Warnings},
};

/// What an OBJ file holds, indices checked.
#[derive(Default)]
pub(super) struct Obj {
    pub positions: Vec<Vec3>,
    /// Linear, one for each position, or empty where no vertex has one.
    pub colors: Vec<Vec3>,
    /// v grows downwards: (0, 0) is an image's top left.
    pub texcoords: Vec<Vec2>,
    pub normals: Vec<Vec3>,
    pub faces: Vec<Face>,
    /// Corners of all faces, one after the other.
    pub corners: Vec<Corner>,
    /// Material names in order of first use, with the line of it; the empty name is none.
    pub materials: Vec<(String, usize)>,
    /// Names of objects and groups in order of first use.
    pub groups: Vec<String>,
    /// Material files with the line that names them.
    pub libraries: Vec<(String, usize)>,
}

/// A polygon.
pub(super) struct Face {
    /// Range of [`Obj::corners`].
    pub first: usize,
    pub count: usize,
    pub material: u32,
    pub group: u32,
    /// 0 for flat.
    pub smoothing: u32,
    pub line: usize,
}

/// A corner of a polygon.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub position: u32,
    pub texcoord: Option<u32>,
    pub normal: Option<u32>,
}

/// Reads a file's lines.
pub(super) fn parse(path: &Path, text: &str, warnings: &mut Warnings) -> Result<Obj, ImportError> {
    let text = joined(text);
    let mut parser = Parser {
        obj: Obj::default(),
        material: None,
        group: None,
        smoothing: 0,
        material_indices: HashMap::new(),
        group_indices: HashMap::new(),
        warnings,
    };
    for line in lines(path, &text) {
        parser.line(&line)?;
    }
    Ok(parser.obj)
}

struct Parser<'w> {
    obj: Obj,
    /// Names in force.
    material: Option<String>,
    group: Option<String>,
    smoothing: u32,
    material_indices: HashMap<String, u32>,
    group_indices: HashMap<String, u32>,
    warnings: &'w mut Warnings,
}

impl Parser<'_> {
    fn line(&mut self, line: &Line) -> Result<(), ImportError> {
        match line.keyword {
            "v" => self.vertex(line)?,
            "vn" => {
                let normal = vector(line, &line.floats()?, "normal", self.obj.normals.len())?;
                self.obj.normals.push(normal);
            }
            "vt" => self.texcoord(line)?,
            "f" | "fo" => self.face(line)?,
            "o" | "g" => self.group = Some(line.rest.to_owned()),
            "usemtl" => self.material = Some(line.rest.to_owned()),
            "mtllib" => self.obj.libraries.push((line.rest.to_owned(), line.number)),
            "s" => {
                self.smoothing = match line.rest {
                    "off" | "0" | "" => 0,
                    group => group.parse().unwrap_or(1),
                }
            }
            "p" | "l" => self.warn(line, WarningKind::Primitive, "points and lines are not rendered"),
            other => {
                let message = format!("\"{}\" is not used", shortened(other));
                self.warn(line, WarningKind::Unused, &message);
            }
        }
        Ok(())
    }

    fn warn(&mut self, line: &Line, kind: WarningKind, message: &str) {
        self.warnings.add(kind, line.short_place(), message);
    }

    fn vertex(&mut self, line: &Line) -> Result<(), ImportError> {
        let n = self.obj.positions.len();
        let floats = line.floats()?;
        if n >= u32::MAX as usize {
            let (place, what) = (line.place(), "too many vertices".to_owned());
            return Err(ImportError::TooBig { place, what, limit: u64::from(u32::MAX) });
        }
        self.obj.positions.push(vector(line, &floats, "vertex", n)?);
        // x y z [w] r g b, by the curve that those who write colours mean.
        if let Some(at) = floats.len().checked_sub(3).filter(|at| (3..=4).contains(at)) {
            let srgb = vector(line, &floats[at..], "vertex colour", n)?;
            self.obj.colors.resize(n, Vec3::ONE);
            self.obj
                .colors
                .push(srgb.clamp(Vec3::ZERO, Vec3::ONE).map(|x| linear_from_srgb(f64::from(x)) as f32));
        } else if !self.obj.colors.is_empty() {
            self.obj.colors.push(Vec3::ONE);
        }
        Ok(())
    }

    fn texcoord(&mut self, line: &Line) -> Result<(), ImportError> {
        let floats = line.floats()?;
        let uv = Vec2::new(floats[0], 1.0 - floats.get(1).copied().unwrap_or(0.0));
        if uv.is_finite() {
            self.obj.texcoords.push(uv);
            return Ok(());
        }
        let index = self.obj.texcoords.len() as u64 + 1;
        Err(ImportError::NotFinite { place: line.place(), what: "texture coordinate", index })
    }

    fn face(&mut self, line: &Line) -> Result<(), ImportError> {
        let first = self.obj.corners.len();
        for word in line.words() {
            let corner = self.corner(line, word)?;
            self.obj.corners.push(corner);
        }
        let count = self.obj.corners.len() - first;
        if count < 3 {
            self.obj.corners.truncate(first);
            self.warn(line, WarningKind::Primitive, "faces with fewer than three corners are left out");
            return Ok(());
        }
        let material = self.current_material(line.number);
        let group = self.current_group();
        let (smoothing, line) = (self.smoothing, line.number);
        self.obj.faces.push(Face { first, count, material, group, smoothing, line });
        Ok(())
    }

    fn corner(&self, line: &Line, word: &str) -> Result<Corner, ImportError> {
        let mut fields = word.split('/');
        let mut index = |what, len| match fields.next() {
            None | Some("") => Ok(None),
            Some(field) => resolve(line, field, what, len).map(Some),
        };
        let position = index("vertex", self.obj.positions.len())?;
        let texcoord = index("texture coordinate", self.obj.texcoords.len())?;
        let normal = index("normal", self.obj.normals.len())?;
        let position = position.ok_or_else(|| line.malformed("a corner of the face names no vertex"))?;
        Ok(Corner { position, texcoord, normal })
    }

    fn current_material(&mut self, line: usize) -> u32 {
        let name = self.material.as_deref().unwrap_or_default();
        if let Some(&known) = self.material_indices.get(name) {
            return known;
        }
        let index = self.obj.materials.len() as u32;
        self.material_indices.insert(name.to_owned(), index);
        self.obj.materials.push((name.to_owned(), line));
        index
    }

    fn current_group(&mut self) -> u32 {
        let name = self.group.as_deref().unwrap_or_default();
        if let Some(&known) = self.group_indices.get(name) {
            return known;
        }
        let index = self.obj.groups.len() as u32;
        self.group_indices.insert(name.to_owned(), index);
        self.obj.groups.push(name.to_owned());
        index
    }
}

/// The first three of a line's numbers.
fn vector(line: &Line, floats: &[f32], what: &'static str, index: usize) -> Result<Vec3, ImportError> {
    let [x, y, z, ..] = floats[..] else {
        return Err(line.malformed(format!("three numbers are expected after \"{}\"", line.keyword)));
    };
    let v = Vec3::new(x, y, z);
    if v.is_finite() {
        return Ok(v);
    }
    Err(ImportError::NotFinite { place: line.place(), what, index: index as u64 + 1 })
}

/// An index as the file counts (from 1, or from the end where negative) to one from 0.
fn resolve(line: &Line, field: &str, what: &'static str, len: usize) -> Result<u32, ImportError> {
    let index: i64 =
        field.parse().map_err(|_| line.malformed(format!("\"{}\" is not an index", shortened(field))))?;
    let from_zero = if index < 0 { (len as i64).checked_add(index) } else { index.checked_sub(1) };
    from_zero
        .filter(|i| (0..len as i64).contains(i))
        .and_then(|i| u32::try_from(i).ok())
        .ok_or_else(|| ImportError::OutOfRange { place: line.place(), what, index, len: len as u64 })
}

fn shortened(word: &str) -> String {
    word.chars().take(40).map(|c| if c.is_control() { '?' } else { c }).collect()
}
