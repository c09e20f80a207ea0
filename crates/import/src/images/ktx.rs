//! KTX 2.0 with Basis Universal (ETC1S or UASTC), as `KHR_texture_basisu` has it, and with plain texels.

use std::{io::Read, sync::Arc};

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use flate2::read::ZlibDecoder;
use half::f16;
use ruzstd::StreamingDecoder;

use super::decode::{Problem, Values};

/// How a file begins (KTX 2.0 specification, section 3.1).
pub(super) const MAGIC: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";
/// The header, and the index's entry for level 0.
const HEADER_BYTES: usize = 80 + 24;
/// Bytes for each texel that any scheme inflates to: UASTC's is 1, HDR's less than 16.
const BYTES_PER_TEXEL: u64 = 16;

fn damaged(why: &str) -> Problem {
    Problem::Damaged(why.to_owned())
}

/// A number of a plain format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Number {
    Byte,
    Word,
    Half,
    Float,
}

impl Number {
    fn bytes(self) -> usize {
        match self {
            Self::Byte => 1,
            Self::Word | Self::Half => 2,
            Self::Float => 4,
        }
    }
}

/// Texels that are stored as they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Plain {
    number: Number,
    channels: usize,
    /// Blue comes first.
    reversed: bool,
}

impl Plain {
    /// A `VkFormat`; none where its texels are in blocks, packed, or of integers. Whether it is one of sRGB
    /// does not count: what an image is for says that, as for other files.
    fn of(vk_format: u32) -> Option<Self> {
        let (number, channels, reversed) = match vk_format {
            9 | 15 => (Number::Byte, 1, false),
            16 | 22 => (Number::Byte, 2, false),
            23 | 29 => (Number::Byte, 3, false),
            30 | 36 => (Number::Byte, 3, true),
            37 | 43 => (Number::Byte, 4, false),
            44 | 50 => (Number::Byte, 4, true),
            70 => (Number::Word, 1, false),
            77 => (Number::Word, 2, false),
            84 => (Number::Word, 3, false),
            91 => (Number::Word, 4, false),
            76 => (Number::Half, 1, false),
            83 => (Number::Half, 2, false),
            90 => (Number::Half, 3, false),
            97 => (Number::Half, 4, false),
            100 => (Number::Float, 1, false),
            103 => (Number::Float, 2, false),
            106 => (Number::Float, 3, false),
            109 => (Number::Float, 4, false),
            _ => return None,
        };
        Some(Self { number, channels, reversed })
    }

    fn texel_bytes(self) -> usize {
        self.channels * self.number.bytes()
    }

    /// Texels of a level; what a format lacks is 0, and alpha 1, as Vulkan has it.
    fn texels(self, level: &[u8]) -> Values {
        match self.number {
            Number::Byte => Values::Bytes(self.spread(level, u8::MAX, |[b]: [u8; 1]| b)),
            Number::Word => Values::Words(self.spread(level, u16::MAX, u16::from_le_bytes)),
            Number::Half => Values::Floats(self.spread(level, 1.0, |b| f16::from_le_bytes(b).to_f32())),
            Number::Float => Values::Floats(self.spread(level, 1.0, f32::from_le_bytes)),
        }
    }

    fn spread<T: Copy + Default, const N: usize>(
        self,
        level: &[u8],
        one: T,
        number: impl Fn([u8; N]) -> T,
    ) -> Arc<[[T; 4]]> {
        let texel = |bytes: &[u8]| {
            let mut texel = [T::default(), T::default(), T::default(), one];
            for (to, from) in texel.iter_mut().zip(bytes.as_chunks().0) {
                *to = number(*from);
            }
            if self.reversed {
                texel.swap(0, 2);
            }
            texel
        };
        level.chunks_exact(self.texel_bytes()).map(texel).collect()
    }
}

fn word(header: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([0, 1, 2, 3].map(|i| header[at + i]))
}

fn long(header: &[u8], at: usize) -> u64 {
    u64::from(word(header, at)) | u64::from(word(header, at + 4)) << 32
}

/// Width and height of the largest level, by the header.
pub(super) fn size(reader: &mut impl Read) -> Result<[u32; 2], Problem> {
    let mut header = [0; HEADER_BYTES];
    reader.read_exact(&mut header).map_err(|_| damaged("its header is cut short"))?;
    let word = |at| word(&header, at);
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
    let inflated = long(&header, 96);
    // Blocks of the smallest images are larger than these.
    let texels = u64::from(width.max(64)) * u64::from(height.max(64));
    if inflated > texels.saturating_mul(BYTES_PER_TEXEL) {
        return Err(damaged("its first level is longer than its size allows"));
    }
    Ok([width, height])
}

/// The texels of the largest level, whose width and height [`size`] found.
pub(super) fn decode(bytes: &[u8], [width, height]: [u32; 2]) -> Result<Values, Problem> {
    if word(bytes, 12) != 0 {
        return plain(bytes, u64::from(width) * u64::from(height));
    }
    let error = |e: basisu::Error| Problem::Damaged(format!("KTX2: {e:?}"));
    let transcoder = Transcoder::new(bytes).map_err(error)?;
    let rgba = transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(error)?;
    Ok(Values::Bytes(rgba.as_chunks().0.into()))
}

fn plain(bytes: &[u8], n_texels: u64) -> Result<Values, Problem> {
    let vk_format = word(bytes, 12);
    let plain = Plain::of(vk_format).ok_or_else(|| {
        damaged(&format!("KTX2 of VkFormat {vk_format} is not read; Basis and plain texels are"))
    })?;
    let cut_short = || damaged("its first level is cut short");
    let (at, length) = (long(bytes, 80), long(bytes, 88));
    let end = at.checked_add(length).ok_or_else(cut_short)?;
    let range = usize::try_from(at).ok().zip(usize::try_from(end).ok()).ok_or_else(cut_short)?;
    let stored = bytes.get(range.0..range.1).ok_or_else(cut_short)?;
    // `size` bounds it.
    let expected = n_texels * plain.texel_bytes() as u64;
    let inflate = |reader: &mut dyn Read| -> Result<Vec<u8>, Problem> {
        let mut level = Vec::new();
        let read = reader.take(expected).read_to_end(&mut level);
        read.map(|_| level).map_err(|error| damaged(&error.to_string()))
    };
    let level = match word(bytes, 44) {
        0 => stored.to_vec(),
        2 => {
            let decoder = StreamingDecoder::new(stored).map_err(|error| damaged(&error.to_string()))?;
            inflate(&mut { decoder })?
        }
        3 => inflate(&mut ZlibDecoder::new(stored))?,
        scheme => return Err(damaged(&format!("KTX2's supercompression scheme {scheme} is not read"))),
    };
    if level.len() as u64 != expected {
        return Err(damaged("its first level is not as long as its size says"));
    }
    Ok(plain.texels(&level))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two texels of two bytes each, as stored by a scheme.
    fn two_texels(scheme: u32, stored: &[u8]) -> Vec<u8> {
        let mut file = vec![0; HEADER_BYTES];
        let length = stored.len() as u32;
        let words = [
            (12, 16),
            (20, 2),
            (24, 1),
            (36, 1),
            (44, scheme),
            (80, HEADER_BYTES as u32),
            (88, length),
            (96, 4),
        ];
        for (at, word) in words {
            file[at..at + 4].copy_from_slice(&u32::to_le_bytes(word));
        }
        file.extend(stored);
        file
    }

    #[test]
    fn levels_are_inflated_by_every_scheme() {
        let level = [10, 20, 30, 40];
        let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        std::io::Write::write_all(&mut zlib, &level).unwrap();
        // A frame of one segment of 4 bytes, in a single raw block.
        let zstd = [&[0x28, 0xb5, 0x2f, 0xfd, 0x20, 4, 4 << 3 | 1, 0, 0], &level[..]].concat();
        for (scheme, stored) in [(0, level.to_vec()), (2, zstd), (3, zlib.finish().unwrap())] {
            let file = two_texels(scheme, &stored);
            let Values::Bytes(texels) = decode(&file, size(&mut &file[..]).unwrap()).unwrap() else {
                panic!("scheme {scheme}")
            };
            assert_eq!(*texels, [[10, 20, 0, 255], [30, 40, 0, 255]], "scheme {scheme}");
            // Cut short, of another scheme, and longer than its size says.
            assert!(decode(&file[..file.len() - 1], [2, 1]).is_err(), "scheme {scheme}");
            assert!(decode(&two_texels(1, &stored), [2, 1]).is_err());
            assert!(decode(&file, [3, 1]).is_err(), "scheme {scheme}");
        }
    }

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

    /// Found by the fuzz target: how many bytes such texels may take did not fit into 64 bits.
    #[test]
    fn the_largest_sizes_of_a_header_are_told() {
        let mut header = [0; HEADER_BYTES];
        for (at, word) in [(20, u32::MAX), (24, u32::MAX), (36, 1)] {
            header[at..at + 4].copy_from_slice(&word.to_le_bytes());
        }
        assert_eq!(size(&mut &header[..]).unwrap(), [u32::MAX; 2]);
    }
}
