//! EXR out: scan lines, 32-bit float, ZIP.

use std::{
    io::{self, Cursor},
    path::Path,
};

use exr::{
    image::{
        AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image as ExrImage, Layer,
        write::WritableImage,
    },
    math::Vec2,
    meta::{
        attribute::{AttributeValue, Compression, IntegerBounds, LineOrder, Text},
        header::{ImageAttributes, LayerAttributes},
    },
};

use super::{ATTRIBUTE_PREFIX, Channel, Framing};
use crate::{
    FilmError, Image,
    atomic::write_atomically,
    metadata::{EXACT_IN_F64, Metadata, Value},
};

/// Writes `image` as 32-bit RGB with `metadata` in the header; `None` for a whole frame. NaN and
/// infinity are written as they are.
///
/// # Errors
/// [`FilmError::BadShape`], or [`FilmError::Write`] with the old file untouched.
pub fn write_exr(
    path: &Path,
    image: &Image,
    framing: Option<Framing>,
    metadata: &Metadata,
) -> Result<(), FilmError> {
    write_exr_with(path, image, &[], framing, metadata)
}

/// As [`write_exr`], with more channels beside the image's `R`, `G` and `B`, as 32-bit floats; those
/// of a layer are named `layer.component`. All programs take the image for the picture.
///
/// # Errors
/// As [`write_exr`]; [`FilmError::BadShape`] for a channel that does not have the image's pixels too.
pub fn write_exr_with(
    path: &Path,
    image: &Image,
    channels: &[Channel],
    framing: Option<Framing>,
    metadata: &Metadata,
) -> Result<(), FilmError> {
    image.check_shape()?;
    if let Some(other) = channels.iter().find(|channel| channel.samples.len() != image.pixels.len()) {
        let (width, height, pixels) = (image.width, image.height, other.samples.len());
        return Err(FilmError::BadShape { width, height, pixels });
    }
    let bytes = encode(image, channels, framing, metadata)
        .map_err(|error| FilmError::Write { path: path.to_owned(), source: io::Error::other(error) })?;
    write_atomically(path, &bytes)
}

fn encode(
    image: &Image,
    channels: &[Channel],
    framing: Option<Framing>,
    metadata: &Metadata,
) -> exr::error::Result<Vec<u8>> {
    let framing = framing.unwrap_or(Framing { frame: image.size(), offset: [0, 0] });
    let mut attributes =
        LayerAttributes { layer_position: signed(framing.offset)?, ..LayerAttributes::default() };
    attributes.software_name = Some(text(concat!("Midway ", env!("CARGO_PKG_VERSION"))));
    for (name, value) in &metadata.entries {
        attributes.other.insert(text(&format!("{ATTRIBUTE_PREFIX}{name}")), attribute(value));
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let list = all_channels(image, channels);
    let layer = Layer::new((image.width, image.height), attributes, encoding, list);
    signed(framing.frame)?;
    let frame = IntegerBounds::new((0, 0), (framing.frame[0], framing.frame[1]));
    let file = ExrImage::new(ImageAttributes::new(frame), layer);
    let mut bytes = Vec::new();
    file.write().non_parallel().to_buffered(Cursor::new(&mut bytes))?;
    Ok(bytes)
}

/// The image's planes and the others, in the order that EXR demands.
fn all_channels(image: &Image, channels: &[Channel]) -> AnyChannels<FlatSamples> {
    let plane = |i: usize| image.pixels.iter().map(|pixel| pixel[i]).collect();
    let rgb = (0..3).map(|i| AnyChannel::new(["R", "G", "B"][i], FlatSamples::F32(plane(i))));
    let others = channels
        .iter()
        .map(|channel| AnyChannel::new(text(&channel.name), FlatSamples::F32(channel.samples.clone())));
    AnyChannels::sort(rgb.chain(others).collect())
}

/// EXR's coordinates are signed 32-bit.
fn signed(pair: [usize; 2]) -> exr::error::Result<Vec2<i32>> {
    Ok(Vec2(i32::try_from(pair[0])?, i32::try_from(pair[1])?))
}

/// EXR strings are bytes; UTF-8 is what other programs expect in them.
fn text(string: &str) -> Text {
    Text::from_slice_unchecked(string.as_bytes())
}

fn attribute(value: &Value) -> AttributeValue {
    match value {
        Value::Text(string) => AttributeValue::Text(text(string)),
        Value::Float(float) => AttributeValue::F64(*float),
        Value::Matrix(rows) => AttributeValue::Matrix4x4(std::array::from_fn(|i| rows[i / 4][i % 4])),
        Value::Int(int) => match i32::try_from(*int) {
            Ok(small) => AttributeValue::I32(small),
            Err(_) if int.abs_diff(0) <= EXACT_IN_F64.unsigned_abs() => AttributeValue::F64(*int as f64),
            Err(_) => AttributeValue::Text(text(&int.to_string())),
        },
    }
}
