//! Mitsuba's binary meshes (`.serialized`), versions 3 and 4: each a header and a stream of zlib; at the
//! end of the file where each begins, and how many there are.

use std::io::{BufRead, BufReader, Read};

use flate2::read::ZlibDecoder;
use glam::{Vec2, Vec3, Vec4};
use midway_scene::Mesh;

use crate::{ImportError, Place, geometry::MAX_TRIANGLES};

type Result<T> = std::result::Result<T, ImportError>;

const MAGIC: u16 = 0x041c;
/// What a mesh says it holds.
const HAS_NORMALS: u32 = 0x1;
const HAS_UVS: u32 = 0x2;
const HAS_COLORS: u32 = 0x8;
/// It is flat, whatever normals it has.
const HAS_FACE_NORMALS: u32 = 0x10;
const IS_DOUBLE: u32 = 0x2000;
/// Deflate makes at most so many bytes of one.
const MOST_INFLATED: u64 = 1032;
/// A name's bytes that are read over.
const LONGEST_NAME: u64 = 1 << 16;

/// The mesh with an index in a file, and whether it is to be shaded flat; texture coordinates as the file has them.
///
/// # Errors
///
/// Where there is no such mesh, or the file is damaged or announces more than it holds.
pub(super) fn read(bytes: &[u8], index: i64, place: &Place) -> Result<(Mesh, bool)> {
    let malformed = |problem: &str| ImportError::Malformed { place: place.clone(), problem: problem.into() };
    let start = start_of(bytes, index, place)?;
    let header = bytes.get(start..start + 4).ok_or_else(|| malformed("a serialized mesh has no header"))?;
    let word = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]);
    let version = word(2);
    if word(0) != MAGIC || !matches!(version, 3 | 4) {
        return Err(malformed("it is no serialized mesh of version 3 or 4"));
    }
    let deflated = &bytes[start + 4..];
    let limit = deflated.len() as u64 * MOST_INFLATED;
    let mut stream = Stream { inner: BufReader::new(ZlibDecoder::new(deflated)), limit, place };
    stream.mesh(version)
}

/// Where a mesh begins, by the list at the end of the file.
fn start_of(bytes: &[u8], index: i64, place: &Place) -> Result<usize> {
    let truncated = |needed: u64| ImportError::Truncated {
        place: place.clone(),
        what: "the list of serialized meshes",
        needed,
        available: bytes.len() as u64,
    };
    let tail = bytes.last_chunk::<4>().ok_or_else(|| truncated(4))?;
    let n = u64::from(u32::from_le_bytes(*tail));
    let version = bytes.get(2..4).map_or(0, |v| u16::from_le_bytes([v[0], v[1]]));
    let size = if version == 4 { 8 } else { 4 };
    let out_of_range =
        || ImportError::OutOfRange { place: place.clone(), what: "serialized mesh", index, len: n };
    let which = u64::try_from(index).ok().filter(|i| *i < n).ok_or_else(out_of_range)?;
    // n < 2³², so this does not overflow.
    let from_end = (n - which) * size + 4;
    let at = (bytes.len() as u64).checked_sub(from_end).ok_or_else(|| truncated(n * size + 4))? as usize;
    let offset = &bytes[at..at + size as usize];
    let start = offset.iter().rev().fold(0u64, |value, &byte| value << 8 | u64::from(byte));
    usize::try_from(start).ok().filter(|start| *start < bytes.len()).ok_or_else(|| truncated(start))
}

/// What a mesh's stream inflates to.
struct Stream<'a> {
    inner: BufReader<ZlibDecoder<&'a [u8]>>,
    /// More bytes than it can hold.
    limit: u64,
    place: &'a Place,
}

impl Stream<'_> {
    fn mesh(&mut self, version: u16) -> Result<(Mesh, bool)> {
        let flags = u32::from_le_bytes(self.array()?);
        if version == 4 {
            self.skip_name()?;
        }
        let n_vertices = u64::from_le_bytes(self.array()?);
        let n_triangles = u64::from_le_bytes(self.array()?);
        self.check("vertices", n_vertices, u64::from(u32::MAX))?;
        self.check("triangles", n_triangles, MAX_TRIANGLES)?;
        let is_double = flags & IS_DOUBLE != 0;
        let mut floats = |has: bool, each: u64, what: &'static str| {
            if has { self.floats(n_vertices * each, is_double, what) } else { Ok(Vec::new()) }
        };
        let positions = floats(true, 3, "vertex")?;
        let normals = floats(flags & HAS_NORMALS != 0, 3, "normal")?;
        let uvs = floats(flags & HAS_UVS != 0, 2, "texture coordinate")?;
        let colors = floats(flags & HAS_COLORS != 0, 3, "colour")?;
        let triangles = self.triangles(n_triangles, n_vertices)?;
        let vectors = |values: &[f32]| values.chunks_exact(3).map(Vec3::from_slice).collect::<Vec<_>>();
        let color = |rgb: Vec3| -> Vec4 { rgb.extend(1.0) };
        let mesh = Mesh {
            positions: vectors(&positions),
            normals: vectors(&normals),
            uvs: [uvs.chunks_exact(2).map(Vec2::from_slice).collect(), Vec::new()],
            colors: vectors(&colors).into_iter().map(color).collect(),
            triangles,
            ..Mesh::default()
        };
        Ok((mesh, flags & HAS_FACE_NORMALS != 0))
    }

    fn check(&self, what: &str, n: u64, limit: u64) -> Result<()> {
        if n <= limit {
            return Ok(());
        }
        let what = format!("a serialized mesh of {n} {what}");
        Err(ImportError::TooBig { place: self.place.clone(), what, limit })
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let bytes = self.bytes(N as u64)?;
        bytes.try_into().map_err(|_| self.damaged("it ends too soon"))
    }

    /// So many bytes; memory grows with what the stream holds, whatever it announces.
    fn bytes(&mut self, n: u64) -> Result<Vec<u8>> {
        let truncated = |available: u64| ImportError::Truncated {
            place: self.place.clone(),
            what: "a serialized mesh",
            needed: n,
            available,
        };
        if n > self.limit {
            return Err(truncated(self.limit));
        }
        let mut bytes = Vec::new();
        let read = self.inner.by_ref().take(n).read_to_end(&mut bytes);
        match read {
            Ok(_) if bytes.len() as u64 == n => Ok(bytes),
            Ok(_) => Err(truncated(bytes.len() as u64)),
            Err(error) => Err(self.damaged(&error.to_string())),
        }
    }

    fn damaged(&self, problem: &str) -> ImportError {
        let problem = format!("a serialized mesh is damaged ({problem})");
        ImportError::Malformed { place: self.place.clone(), problem }
    }

    fn skip_name(&mut self) -> Result<()> {
        let mut name = Vec::new();
        let read = self.inner.by_ref().take(LONGEST_NAME).read_until(0, &mut name);
        match read {
            Ok(_) if name.last() == Some(&0) => Ok(()),
            Ok(_) => Err(self.damaged("its name has no end")),
            Err(error) => Err(self.damaged(&error.to_string())),
        }
    }

    fn floats(&mut self, n: u64, is_double: bool, what: &'static str) -> Result<Vec<f32>> {
        let bytes = self.bytes(n * if is_double { 8 } else { 4 })?;
        let floats: Vec<f32> = if is_double {
            let (chunks, _) = bytes.as_chunks::<8>();
            chunks.iter().map(|chunk| f64::from_le_bytes(*chunk) as f32).collect()
        } else {
            let (chunks, _) = bytes.as_chunks::<4>();
            chunks.iter().map(|chunk| f32::from_le_bytes(*chunk)).collect()
        };
        match floats.iter().position(|x| !x.is_finite()) {
            None => Ok(floats),
            Some(at) => {
                let index = at as u64 / if what == "texture coordinate" { 2 } else { 3 };
                Err(ImportError::NotFinite { place: self.place.clone(), what, index })
            }
        }
    }

    fn triangles(&mut self, n: u64, n_vertices: u64) -> Result<Vec<[u32; 3]>> {
        let bytes = self.bytes(n * 12)?;
        let (chunks, _) = bytes.as_chunks::<4>();
        let indices: Vec<u32> = chunks.iter().map(|chunk| u32::from_le_bytes(*chunk)).collect();
        if let Some(&bad) = indices.iter().find(|&&i| u64::from(i) >= n_vertices) {
            let (place, index) = (self.place.clone(), i64::from(bad));
            return Err(ImportError::OutOfRange { place, what: "vertex", index, len: n_vertices });
        }
        Ok(indices.as_chunks::<3>().0.to_vec())
    }
}
