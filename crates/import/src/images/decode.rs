//! One image file, from bytes to texels.

use std::{
    fmt, fs,
    io::{BufRead, BufReader, Cursor, Read, Seek},
    path::Path,
    sync::Arc,
};

use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use midway_scene::{Image, Texels};

use super::{Encoding, extension, ktx};

/// The most texels in one image: 16384 x 16384.
pub(super) const MAX_TEXELS: u64 = 1 << 28;
/// The longest side.
const MAX_SIDE: u32 = 1 << 16;
/// What decoding may take for each texel: sixteen bytes of floats, twice, and change.
const BYTES_PER_TEXEL: u64 = 40;
/// The largest finite value of 16 bits, in place of infinity.
const BRIGHTEST: f32 = 65504.0;
/// Of the start of a file: enough for every magic number.
const MAGIC_BYTES: u64 = 32;

/// Why an image cannot be used.
#[derive(Clone, Debug)]
pub(super) enum Problem {
    Unreadable(String),
    Unknown,
    Damaged(String),
    TooLarge { width: u32, height: u32 },
    BeyondFiles { width: u32, height: u32 },
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(why) => write!(f, "the image cannot be read ({why})"),
            Self::Unknown => write!(f, "the image is in no format that is read ({FORMATS})"),
            Self::Damaged(why) => write!(f, "the image is damaged ({why})"),
            Self::TooLarge { width, height } => {
                write!(f, "the image's {width} x {height} texels are too many")
            }
            Self::BeyondFiles { width, height } => {
                write!(f, "the image's {width} x {height} texels are more than files of this size hold")
            }
        }
    }
}

const FORMATS: &str = "PNG, JPEG, WebP, HDR, EXR, KTX2, TGA, BMP";

/// Values as the file has them, RGBA.
pub(super) struct Decoded {
    width: u32,
    height: u32,
    values: Values,
    /// What was repaired.
    pub note: Option<&'static str>,
}

pub(super) enum Values {
    Bytes(Arc<[[u8; 4]]>),
    Words(Arc<[[u16; 4]]>),
    Floats(Arc<[[f32; 4]]>),
    Ready(Texels),
}

enum Format {
    Image(ImageFormat),
    Ktx2,
}

impl Format {
    /// By how the file begins; TGA, which begins with nothing in particular, by its extension.
    fn of(start: &[u8], extension: Option<&str>) -> Result<Self, Problem> {
        if start.starts_with(ktx::MAGIC) {
            return Ok(Self::Ktx2);
        }
        match image::guess_format(start) {
            Ok(format) if format.reading_enabled() => Ok(Self::Image(format)),
            _ if extension == Some("tga") => Ok(Self::Image(ImageFormat::Tga)),
            _ => Err(Problem::Unknown),
        }
    }
}

fn damaged(error: impl fmt::Display) -> Problem {
    // One line, whatever a decoder says.
    let line: String =
        error.to_string().chars().take(160).map(|c| if c.is_control() { ' ' } else { c }).collect();
    Problem::Damaged(line)
}

/// Width and height by the header of a file.
pub(super) fn size_of_file(path: &Path) -> Result<[u32; 2], Problem> {
    let unreadable = |e: std::io::Error| Problem::Unreadable(e.to_string());
    let mut file = BufReader::new(fs::File::open(path).map_err(unreadable)?);
    let mut start = Vec::new();
    file.by_ref().take(MAGIC_BYTES).read_to_end(&mut start).map_err(unreadable)?;
    file.rewind().map_err(unreadable)?;
    size_of(file, &start, extension(path).as_deref())
}

/// Width and height by the header.
pub(super) fn size(bytes: &[u8], extension: Option<&str>) -> Result<[u32; 2], Problem> {
    size_of(Cursor::new(bytes), bytes, extension)
}

fn size_of(
    mut reader: impl BufRead + Seek,
    start: &[u8],
    extension: Option<&str>,
) -> Result<[u32; 2], Problem> {
    let [width, height] = match Format::of(start, extension)? {
        Format::Ktx2 => ktx::size(&mut reader)?,
        Format::Image(format) => {
            let mut reader = ImageReader::with_format(reader, format);
            reader.limits(limits(0));
            let (width, height) = reader.into_dimensions().map_err(damaged)?;
            [width, height]
        }
    };
    if width == 0 || height == 0 {
        return Err(damaged("it has no texels"));
    }
    if width.max(height) > MAX_SIDE || u64::from(width) * u64::from(height) > MAX_TEXELS {
        return Err(Problem::TooLarge { width, height });
    }
    Ok([width, height])
}

/// What a decoder may allocate.
fn limits(texels: u64) -> Limits {
    /// For tables and rows.
    const FREE_BYTES: u64 = 16 << 20;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(texels * BYTES_PER_TEXEL + FREE_BYTES);
    limits
}

/// All texels, as they are stored: orientation in EXIF and colour profiles do not count, as glTF has
/// it.
pub(super) fn decode(bytes: &[u8], extension: Option<&str>) -> Result<Decoded, Problem> {
    let [width, height] = size(bytes, extension)?;
    let format = match Format::of(bytes, extension)? {
        Format::Ktx2 => {
            return Ok(Decoded::from_values([width, height], ktx::decode(bytes, [width, height])?));
        }
        Format::Image(format) => format,
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits(u64::from(width) * u64::from(height)));
    let mut decoder = reader.into_decoder().map_err(damaged)?;
    decoder.set_limits(limits(u64::from(width) * u64::from(height))).map_err(damaged)?;
    let pixels = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    if format == ImageFormat::Jpeg && !ends_a_jpeg(bytes) {
        return Err(damaged("it is cut short"));
    }
    Ok(Decoded::from_pixels(pixels))
}

/// Decoders fill what a JPEG lacks with grey, and say nothing: whether its end marker is there,
/// padding aside.
fn ends_a_jpeg(bytes: &[u8]) -> bool {
    const END: [u8; 2] = [0xff, 0xd9];
    bytes.windows(2).rev().any(|w| w == END)
}

impl Decoded {
    fn from_pixels(pixels: DynamicImage) -> Self {
        let size = [pixels.width(), pixels.height()];
        let values = match pixels.color() {
            ColorType::Rgb32F | ColorType::Rgba32F => {
                Values::Floats(pixels.into_rgba32f().into_raw().as_chunks().0.into())
            }
            ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
                Values::Words(pixels.into_rgba16().into_raw().as_chunks().0.into())
            }
            _ => Values::Bytes(pixels.into_rgba8().into_raw().as_chunks().0.into()),
        };
        Self::from_values(size, values)
    }

    /// As a file has them, floats made finite.
    fn from_values([width, height]: [u32; 2], mut values: Values) -> Self {
        let mut note = None;
        if let Values::Floats(floats) = &mut values
            && !floats.as_flattened().iter().all(|x| x.is_finite())
        {
            make_finite(Arc::make_mut(floats).as_flattened_mut());
            note = Some("texels that are NaN are taken as 0, infinite ones as 65504");
        }
        Self { width, height, values, note }
    }

    pub fn ready(image: &Image) -> Self {
        let Image { width, height, texels, .. } = image.clone();
        Self { width, height, values: Values::Ready(texels), note: None }
    }

    /// The image that these values are, so understood.
    pub fn image(&self, name: String, encoding: Encoding) -> Image {
        let texels = match (&self.values, encoding) {
            (Values::Bytes(values), Encoding::Srgb) => Texels::Srgb8(values.clone()),
            (Values::Bytes(values), _) => Texels::Linear8(values.clone()),
            (Values::Words(values), Encoding::Srgb) => Texels::Linear16(linear_words(values)),
            (Values::Words(values), _) => Texels::Linear16(values.clone()),
            (Values::Floats(values), _) => Texels::Float(values.clone()),
            (Values::Ready(texels), _) => texels.clone(),
        };
        Image { name, width: self.width, height: self.height, texels }
    }
}

/// Undoes the sRGB curve of colours, alpha left alone.
fn linear_words(values: &[[u16; 4]]) -> Arc<[[u16; 4]]> {
    let table: Vec<u16> = (0..=u16::MAX).map(linear_word).collect();
    values
        .iter()
        .map(|&[r, g, b, a]| {
            let [r, g, b] = [r, g, b].map(|x| table[usize::from(x)]);
            [r, g, b, a]
        })
        .collect()
}

/// IEC 61966-2-1, for a word.
fn linear_word(word: u16) -> u16 {
    let x = f64::from(word) / 65535.0;
    let linear = if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    (linear * 65535.0).round() as u16
}

fn make_finite(values: &mut [f32]) {
    for value in values.iter_mut().filter(|x| !x.is_finite()) {
        *value = if value.is_nan() { 0.0 } else { BRIGHTEST.copysign(*value) };
    }
}

#[cfg(test)]
mod tests {
    use midway_scene::srgb_to_linear;

    use super::*;

    #[test]
    fn words_follow_the_curve_of_bytes() {
        for byte in 0..=255u8 {
            let word = f32::from(linear_word(u16::from(byte) * 257)) / 65535.0;
            // Half a step of 16 bits.
            assert!((word - srgb_to_linear(byte)).abs() <= 0.5 / 65535.0 + 1e-7, "{byte}");
        }
    }

    #[test]
    fn what_is_not_finite_is_replaced() {
        let mut values = [1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        make_finite(&mut values);
        assert_eq!(values, [1.0, 0.0, BRIGHTEST, -BRIGHTEST]);
    }
}
