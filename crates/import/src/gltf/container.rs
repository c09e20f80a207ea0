//! The binary container: JSON and one buffer in a file.

use std::path::Path;

use super::file_place;
use crate::ImportError;

/// How a GLB file begins.
pub(crate) const GLB_MAGIC: &[u8] = b"glTF";
const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// The JSON text, and the binary buffer where the file has one. A file that is not a GLB is all
/// text.
pub(super) fn open<'a>(path: &Path, file: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), ImportError> {
    if !file.starts_with(GLB_MAGIC) {
        return Ok((file, None));
    }
    let malformed = |problem: String| ImportError::Malformed { place: file_place(path), problem };
    let truncated = |what, needed: usize, available: usize| ImportError::Truncated {
        place: file_place(path),
        what,
        needed: needed as u64,
        available: available as u64,
    };
    if file.len() < HEADER_BYTES {
        return Err(truncated("its GLB header", HEADER_BYTES, file.len()));
    }
    let version = u32_at(file, 4);
    if version != 2 {
        return Err(malformed(format!("it is GLB version {version}, and 2 is read")));
    }
    let length = u32_at(file, 8) as usize;
    if length > file.len() {
        return Err(truncated("its GLB container", length, file.len()));
    }
    let mut rest = file.get(HEADER_BYTES..length).unwrap_or_default();
    let mut chunks = Vec::new();
    // The first is JSON, the second a buffer; others are to be ignored.
    while rest.len() >= CHUNK_HEADER_BYTES && chunks.len() < 2 {
        let (size, kind) = (u32_at(rest, 0) as usize, &rest[4..8]);
        let body = &rest[CHUNK_HEADER_BYTES..];
        if size > body.len() {
            return Err(truncated("a chunk of its GLB container", size, body.len()));
        }
        let (data, after) = body.split_at(size);
        chunks.push((kind, data));
        rest = after;
    }
    let json = match chunks.first() {
        Some((kind, data)) if *kind == b"JSON" => *data,
        _ => return Err(malformed("its GLB container does not begin with JSON".to_owned())),
    };
    let binary = chunks.get(1).filter(|(kind, _)| *kind == b"BIN\0").map(|(_, data)| *data);
    Ok((json, binary))
}

fn u32_at(bytes: &[u8], offset: usize) -> u32 {
    let mut word = [0; 4];
    word.copy_from_slice(&bytes[offset..offset + 4]);
    u32::from_le_bytes(word)
}
