//! Typed arrays out of buffers, every bound checked before anything is allocated.

use std::cell::Cell;

use super::{
    buffers::{Buffers, slice},
    json::Json,
};
use crate::ImportError;

/// Elements that may be decoded for each byte held: one byte can be an index, and a vertex that
/// is read by several primitives is decoded by each. Beyond that a small file would ask for much.
const ELEMENTS_PER_BYTE: u64 = 4;
/// Elements that any file may have decoded.
const FREE_ELEMENTS: u64 = 1 << 20;

/// The document's accessors.
pub(super) struct Accessors<'a> {
    accessors: Vec<Json<'a>>,
    buffers: &'a Buffers<'a>,
    limit: u64,
    decoded: Cell<u64>,
}

/// Which whole numbers may stand for the components of an attribute, with `KHR_mesh_quantization`.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Integers {
    /// Of 8 or 16 bits, as they are or as fractions.
    Any,
    /// Of 8 or 16 bits, as fractions.
    Normalized,
}

impl Integers {
    fn check(self, component: Component, normalized: bool, at: &Json) -> Result<(), ImportError> {
        match component {
            Component::F32 => Ok(()),
            Component::U32 => Err(at.malformed("attributes are floats, or whole numbers of 8 or 16 bits")),
            _ if self == Self::Normalized && !normalized => {
                Err(at.malformed("whole numbers have to be normalized in this attribute"))
            }
            _ => Ok(()),
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(json: &Json) -> Result<Self, ImportError> {
        Ok(match json.unsigned()? {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            other => return Err(json.malformed(format!("{other} is not a component type"))),
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The first component in `b`, of which there are enough bytes.
    fn float(self, b: &[u8], normalized: bool) -> f32 {
        let (value, scale) = match self {
            Self::I8 => (f32::from(b[0] as i8), 127.0),
            Self::U8 => (f32::from(b[0]), 255.0),
            Self::I16 => (f32::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            Self::U16 => (f32::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            Self::U32 => (u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32, u32::MAX as f32),
            Self::F32 => return f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        };
        if normalized { (value / scale).max(-1.0) } else { value }
    }

    /// The first component in `b` as an index; only unsigned types are.
    fn index(self, b: &[u8]) -> u32 {
        match self {
            Self::U8 => u32::from(b[0]),
            Self::U16 => u32::from(u16::from_le_bytes([b[0], b[1]])),
            _ => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        }
    }
}

/// Elements at a stride, known to lie within the bytes.
struct Strided<'b> {
    bytes: &'b [u8],
    stride: usize,
    size: usize,
}

impl<'b> Strided<'b> {
    /// `count` elements of `size` bytes from `offset` in the view that `view` refers to.
    fn new(
        buffers: &'b Buffers,
        view: &Json,
        at: &Json,
        offset: u64,
        count: u64,
        size: usize,
    ) -> Result<Self, ImportError> {
        let view = buffers.view(view)?;
        let stride = view.stride.unwrap_or(size);
        if stride < size {
            return Err(at.malformed(format!("elements of {size} bytes overlap at a stride of {stride}")));
        }
        let length = match count.checked_sub(1) {
            None => 0,
            Some(gaps) => gaps.saturating_mul(stride as u64).saturating_add(size as u64),
        };
        let bytes = slice(view.bytes, offset, length).ok_or_else(|| ImportError::Truncated {
            place: at.place(),
            what: "the accessor",
            needed: offset.saturating_add(length),
            available: view.bytes.len() as u64,
        })?;
        Ok(Self { bytes, stride, size })
    }

    fn element(&self, i: usize) -> &'b [u8] {
        &self.bytes[i * self.stride..i * self.stride + self.size]
    }
}

impl<'a> Accessors<'a> {
    pub fn new(root: &Json<'a>, buffers: &'a Buffers<'a>, file_bytes: u64) -> Result<Self, ImportError> {
        let held = buffers.total_bytes().saturating_add(file_bytes);
        Ok(Self {
            accessors: root.items("accessors")?,
            buffers,
            limit: held.saturating_mul(ELEMENTS_PER_BYTE).max(FREE_ELEMENTS),
            decoded: Cell::new(0),
        })
    }

    /// What the accessors read from.
    pub fn buffers(&self) -> &'a Buffers<'a> {
        self.buffers
    }

    /// The accessor that an index refers to.
    fn get(&self, index: &Json) -> Result<&Json<'a>, ImportError> {
        Ok(&self.accessors[index.index("accessor", self.accessors.len())?])
    }

    /// How many elements an accessor has.
    pub fn count(&self, index: &Json) -> Result<u64, ImportError> {
        self.get(index)?.required("count")?.unsigned()
    }

    /// Counts what is decoded, before it is, against what a file of this size may ask for.
    pub fn charge(&self, at: &Json, elements: u64) -> Result<(), ImportError> {
        let decoded = self.decoded.get().saturating_add(elements);
        self.decoded.set(decoded);
        if decoded <= self.limit {
            return Ok(());
        }
        let what = format!("{decoded} vertices and indices in all, from a file that holds far fewer");
        Err(ImportError::TooBig { place: at.place(), what, limit: self.limit })
    }

    /// An accessor's type: `SCALAR`, `VEC2`, …
    pub fn kind(&self, index: &Json) -> Result<&'a str, ImportError> {
        self.get(index)?.required("type")?.string()
    }

    /// Vectors of `N` components, those named by `picks` or all. Whole numbers that are normalized
    /// come as the fractions that they stand for.
    pub fn vectors<const N: usize>(
        &self,
        index: &Json,
        picks: Option<&[u32]>,
        integers: Integers,
    ) -> Result<Vec<[f32; N]>, ImportError> {
        let accessor = self.get(index)?;
        self.expect_type(accessor, ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1])?;
        let component_type = accessor.required("componentType")?;
        let component = Component::of(&component_type)?;
        let normalized = accessor.bool_or("normalized", false)?;
        integers.check(component, normalized, &component_type)?;
        let count = self.count(index)?;
        let elements = self.elements(accessor, count, N * component.size())?;
        self.charge(accessor, picks.map_or(count, |p| p.len() as u64))?;
        let decode = |i: usize| -> [f32; N] {
            let Some(bytes) = elements.get(i) else {
                return [0.0; N];
            };
            std::array::from_fn(|c| component.float(&bytes[c * component.size()..], normalized))
        };
        Ok(match picks {
            Some(picks) => picks.iter().map(|&i| decode(i as usize)).collect(),
            None => (0..count as usize).map(decode).collect(),
        })
    }

    /// Indices of vertices.
    pub fn indices(&self, index: &Json) -> Result<Vec<u32>, ImportError> {
        let accessor = self.get(index)?;
        self.expect_type(accessor, "SCALAR")?;
        let component_type = accessor.required("componentType")?;
        let component = Component::of(&component_type)?;
        if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
            return Err(component_type.malformed("indices have to be unsigned whole numbers"));
        }
        let count = self.count(index)?;
        let elements = self.elements(accessor, count, component.size())?;
        self.charge(accessor, count)?;
        Ok((0..count as usize).map(|i| elements.get(i).map_or(0, |b| component.index(b))).collect())
    }

    fn expect_type(&self, accessor: &Json, expected: &str) -> Result<(), ImportError> {
        let kind = accessor.required("type")?;
        match kind.string()? {
            kind if kind == expected => Ok(()),
            other => Err(kind.malformed(format!("{expected} is expected here, and it is {other:?}"))),
        }
    }

    fn elements(&self, accessor: &Json, count: u64, size: usize) -> Result<Elements<'_>, ImportError> {
        let base = match accessor.get("bufferView") {
            Some(view) => {
                let offset = accessor.unsigned_or("byteOffset", 0)?;
                Some(Strided::new(self.buffers, &view, accessor, offset, count, size)?)
            }
            // Zeros, which a sparse accessor may replace.
            None => None,
        };
        let sparse = match accessor.get("sparse") {
            Some(sparse) => self.sparse(&sparse, count, size)?,
            None => Vec::new(),
        };
        Ok(Elements { base, sparse })
    }

    /// The elements that take others' places, by index.
    fn sparse(&self, sparse: &Json, count: u64, size: usize) -> Result<Vec<(u32, &[u8])>, ImportError> {
        let n = sparse.required("count")?.unsigned()?;
        let (indices, values) = (sparse.required("indices")?, sparse.required("values")?);
        let component = Component::of(&indices.required("componentType")?)?;
        if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
            return Err(indices.malformed("indices have to be unsigned whole numbers"));
        }
        let strided = |of: &Json, size| {
            let offset = of.unsigned_or("byteOffset", 0)?;
            Strided::new(self.buffers, &of.required("bufferView")?, of, offset, n, size)
        };
        let (at, replacements) = (strided(&indices, component.size())?, strided(&values, size)?);
        self.charge(sparse, n)?;
        let mut replaced = Vec::with_capacity(n as usize);
        for i in 0..n as usize {
            let index = component.index(at.element(i));
            if u64::from(index) >= count {
                return Err(ImportError::OutOfRange {
                    place: indices.place(),
                    what: "element",
                    index: i64::from(index),
                    len: count,
                });
            }
            replaced.push((index, replacements.element(i)));
        }
        // Of entries for the same element the last counts.
        replaced.reverse();
        replaced.sort_by_key(|(index, _)| *index);
        replaced.dedup_by_key(|(index, _)| *index);
        Ok(replaced)
    }
}

struct Elements<'b> {
    base: Option<Strided<'b>>,
    /// Sorted by index.
    sparse: Vec<(u32, &'b [u8])>,
}

impl<'b> Elements<'b> {
    /// The bytes of an element below the count; none where it is zero.
    fn get(&self, i: usize) -> Option<&'b [u8]> {
        if !self.sparse.is_empty()
            && let Ok(found) = self.sparse.binary_search_by_key(&(i as u64), |(at, _)| u64::from(*at))
        {
            return Some(self.sparse[found].1);
        }
        self.base.as_ref().map(|base| base.element(i))
    }
}
