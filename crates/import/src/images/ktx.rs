//! KTX 2.0 with Basis Universal (ETC1S or UASTC), as `KHR_texture_basisu` has it.

use std::{io::Read, sync::Arc};

use basisu::{DecodeFlags, TargetFormat, Transcoder};

use super::decode::Problem;

/// How a file begins (KTX 2.0 specification, section 3.1).
pub(super) const MAGIC: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";
/// The header, and the index's entry for level 0.
const HEADER_BYTES: usize = 80 + 24;
/// Bytes for each texel that any scheme inflates to: UASTC's is 1, HDR's less than 16.
const BYTES_PER_TEXEL: u64 = 16;

fn damaged(why: &str) -> Problem {
    Problem::Damaged(why.to_owned())
}

/// Width and height of the largest level, by the header.
pub(super) fn size(reader: &mut impl Read) -> Result<[u32; 2], Problem> {
    let mut header = [0; HEADER_BYTES];
    reader.read_exact(&mut header).map_err(|_| damaged("its header is cut short"))?;
    let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| header[at + i]));
    let [width, height] = [word(20), word(24)];
    let [depth, layers, faces] = [word(28), word(32), word(36)];
    if depth > 0 || layers > 1 || faces != 1 {
        return Err(damaged("it is no two-dimensional image"));
    }
    // The decoder steps over pairs by their padded length, past the end where that is not padded.
    let [pairs_at, pairs_bytes] = [word(56), word(60)];
    if pairs_bytes > 0 && !pairs_at.wrapping_add(pairs_bytes).is_multiple_of(4) {
        return Err(damaged("its keys and values do not end at a multiple of 4"));
    }
    let inflated = u64::from(word(96)) | u64::from(word(100)) << 32;
    // Blocks of the smallest images are larger than these.
    let texels = u64::from(width.max(64)) * u64::from(height.max(64));
    if inflated > texels * BYTES_PER_TEXEL {
        return Err(damaged("its first level is longer than its size allows"));
    }
    Ok([width, height])
}

/// The texels of the largest level.
pub(super) fn decode(bytes: &[u8]) -> Result<Arc<[[u8; 4]]>, Problem> {
    let error = |e: basisu::Error| Problem::Damaged(format!("KTX2: {e:?}"));
    let transcoder = Transcoder::new(bytes).map_err(error)?;
    let rgba = transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(error)?;
    Ok(rgba.as_chunks().0.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Found by the fuzz target: such a file made the decoder panic.
    #[test]
    fn pairs_that_end_between_words_are_refused() {
        let header = |pairs_bytes: u32| {
            let mut header = [0; HEADER_BYTES];
            let words = [(20, 4u32), (24, 4), (36, 1), (56, HEADER_BYTES as u32), (60, pairs_bytes)];
            for (at, word) in words {
                header[at..at + 4].copy_from_slice(&word.to_le_bytes());
            }
            header
        };
        assert_eq!(size(&mut &header(8)[..]).unwrap(), [4, 4]);
        assert!(size(&mut &header(7)[..]).is_err());
    }
}
