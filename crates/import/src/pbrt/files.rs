//! Files that a scene includes, packed by gzip or not.

use std::io::Read;

use flate2::read::MultiGzDecoder;

use crate::{ImportError, Place, files::SceneFolder};

/// Bytes unpacked from each packed one, at most: meshes and text pack to a tenth, zeros to a
/// thousandth.
const MOST_PER_BYTE: u64 = 128;
/// Bytes that may be unpacked however small a file is.
const FREE_BYTES: u64 = 1 << 20;

/// A file in the folder, unpacked where it is gzip by its content.
pub(super) fn read(folder: &SceneFolder, name: &str, place: &Place) -> Result<Vec<u8>, ImportError> {
    let bytes = folder.read_unheld(name, place)?;
    if bytes.starts_with(&[0x1f, 0x8b]) { unpacked(&bytes, place) } else { Ok(bytes) }
}

pub(super) fn unpacked(packed: &[u8], place: &Place) -> Result<Vec<u8>, ImportError> {
    let limit = packed.len() as u64 * MOST_PER_BYTE + FREE_BYTES;
    let mut bytes = Vec::new();
    MultiGzDecoder::new(packed).take(limit + 1).read_to_end(&mut bytes).map_err(|e| {
        ImportError::Malformed {
            place: place.clone(),
            problem: format!("the gzip data does not unpack ({e})"),
        }
    })?;
    if bytes.len() as u64 > limit {
        let what = "a file of gzip data unpacks to more than any mesh does".to_owned();
        return Err(ImportError::TooBig { place: place.clone(), what, limit });
    }
    Ok(bytes)
}
