//! `EXT_meshopt_compression`: views of buffers that are compressed, each decoded whole.
//!
//! The bitstreams and filters are those of the extension's specification (appendices A and B),
//! version 0 of attributes and 0 and 1 of triangles; the pure Rust crates of it are unmaintained.
//! Nothing is allocated beyond what the compressed bytes can stand for.

mod attributes;
mod filters;
mod indices;

use std::sync::Arc;

use super::{buffers::slice, json::Json};
use crate::ImportError;

/// The extension, and its ratified form with the same streams.
pub(super) const EXTENSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The extension of a view or of a buffer.
pub(super) fn extension<'a>(of: &Json<'a>) -> Option<Json<'a>> {
    EXTENSIONS.iter().find_map(|name| of.extension(name))
}

/// Decodes a view's extension out of the document's buffers.
pub(super) fn decode(extension: &Json, buffers: &[Option<Arc<[u8]>>]) -> Result<Arc<[u8]>, ImportError> {
    let buffer = extension.required("buffer")?;
    let bytes = buffers[buffer.index("buffer", buffers.len())?]
        .as_ref()
        .ok_or_else(|| buffer.malformed("the buffer has neither a URI nor a GLB chunk"))?;
    let offset = extension.unsigned_or("byteOffset", 0)?;
    let length = extension.required("byteLength")?.unsigned()?;
    let stream = slice(bytes, offset, length).ok_or_else(|| ImportError::Truncated {
        place: extension.place(),
        what: "the compressed view",
        needed: offset.saturating_add(length),
        available: bytes.len() as u64,
    })?;
    let stride = extension.required("byteStride")?.unsigned()?;
    let count = extension.required("count")?.unsigned()?;
    let (Ok(stride), Ok(count)) = (usize::try_from(stride), usize::try_from(count)) else {
        return Err(extension.malformed("its count or its stride is too large"));
    };
    let mode = extension.required("mode")?;
    let decoded = match mode.string()? {
        "ATTRIBUTES" => attributes::decode(stream, count, stride),
        "TRIANGLES" => indices::triangles(stream, count, stride),
        "INDICES" => indices::sequence(stream, count, stride),
        _ => return Err(mode.malformed("a mode is ATTRIBUTES, TRIANGLES or INDICES")),
    };
    let mut decoded = decoded.map_err(|problem| extension.malformed(problem))?;
    if let Some(filter) = extension.get("filter") {
        filters::apply(filter.string()?, &mut decoded, stride)
            .map_err(|problem| filter.malformed(problem))?;
    }
    Ok(decoded.into())
}

/// The next bytes of a stream.
struct Reader<'a>(&'a [u8]);

const CUT_SHORT: &str = "its compressed data is cut short";

impl<'a> Reader<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], &'static str> {
        let (taken, rest) = self.0.split_at_checked(n).ok_or(CUT_SHORT)?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, &'static str> {
        Ok(self.take(1)?[0])
    }

    /// A whole number by groups of seven bits, the least first.
    fn varint(&mut self) -> Result<u32, &'static str> {
        let mut value = 0;
        for shift in (0..32).step_by(7) {
            let byte = self.byte()?;
            value |= u32::from(byte & 127) << shift;
            if byte < 128 {
                return Ok(value);
            }
        }
        Err("its compressed data has a number that is too long")
    }

    /// A signed difference from `last`: the lowest bit is the sign.
    fn index(&mut self, last: u32) -> Result<u32, &'static str> {
        Ok(last.wrapping_add(unzigzag(self.varint()?)))
    }
}

fn unzigzag(v: u32) -> u32 {
    (v >> 1) ^ (v & 1).wrapping_neg()
}
