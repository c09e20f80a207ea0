//! EXR in: any flat file, whole, bounded by what its size makes plausible.

use std::{
    collections::HashMap,
    fs,
    io::Cursor,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
};

use exr::prelude::{ReadChannels, ReadLayers};
use exr::{
    block::reader::Reader,
    image::{AnyChannels, FlatSamples, Image as ExrImage, Layer, read::read},
    math::Vec2,
    meta::{
        attribute::{AttributeValue, Text},
        header::Header,
    },
};

use super::{ATTRIBUTE_PREFIX, Framing};
use crate::{FilmError, Image, Metadata, Value};

/// Longest side accepted.
const MAX_SIDE: usize = 1 << 16;
/// Deflate makes at most 1032 bytes of one; twice that leaves room for EXR's other codecs.
const MAX_EXPANSION: usize = 2048;
/// Small files may expand to this much whatever their size.
const ALWAYS_ACCEPTED_BYTES: usize = 64 << 20;

/// One plane of samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The full name: `R`, `beauty.R`, `mask.Y`; preceded by the part's name in files of many parts.
    pub name: String,
    /// Row-major from the top left, converted to f32.
    pub samples: Vec<f32>,
}

/// An EXR file in memory: every channel and Midway's metadata.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrFile {
    /// Where it came from, for messages.
    pub path: PathBuf,
    /// Pixels along x of every channel.
    pub width: usize,
    /// Pixels along y of every channel.
    pub height: usize,
    /// Where the pixels lie in the full frame; `None` if the frame is the image, or if the image
    /// is not inside it.
    pub framing: Option<Framing>,
    /// All channels, in the file's order.
    pub channels: Vec<Channel>,
    /// The `midway:` attributes, by name.
    pub metadata: Metadata,
}

type Part = Layer<AnyChannels<FlatSamples>>;

impl ExrFile {
    /// Reads a whole file.
    ///
    /// # Errors
    /// [`FilmError::Read`] if it cannot be opened, [`FilmError::Malformed`] if it is truncated,
    /// damaged, deep, subsampled, claims far more pixels than its size can hold, or has parts of
    /// different sizes.
    pub fn read(path: &Path) -> Result<Self, FilmError> {
        let bytes = fs::read(path).map_err(|source| FilmError::Read { path: path.to_owned(), source })?;
        Self::from_bytes(path, &bytes)
    }

    /// As [`ExrFile::read`], from memory; `path` is for messages.
    ///
    /// # Errors
    /// [`FilmError::Malformed`].
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, FilmError> {
        // The decoder indexes by numbers from the file; a panic in it is a malformed file.
        catch_unwind(AssertUnwindSafe(|| decode(path, bytes)))
            .unwrap_or_else(|_| Err("the decoder gave up on it".to_owned()))
            .map_err(|reason| FilmError::Malformed { path: path.to_owned(), reason })
    }

    /// The samples of a channel by its full name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|channel| channel.name == name).map(|channel| channel.samples.as_slice())
    }

    /// Layer `name` (`"se"` for `se.R`, `se.G`, `se.B`; the empty name for `R`, `G`, `B`). Three
    /// equal planes if the layer is luminance only (`mask.Y`).
    #[must_use]
    pub fn layer(&self, name: &str) -> Option<Image> {
        let full = |channel: &str| {
            if name.is_empty() { channel.to_owned() } else { format!("{name}.{channel}") }
        };
        let rgb = ["R", "G", "B"].map(|channel| self.channel(&full(channel)));
        let planes = match (rgb, self.channel(&full("Y"))) {
            ([Some(r), Some(g), Some(b)], _) => [r, g, b],
            (_, Some(y)) => [y; 3],
            _ => return None,
        };
        let pixels = (0..self.width * self.height).map(|i| planes.map(|plane| plane[i])).collect();
        Some(Image { width: self.width, height: self.height, pixels })
    }

    /// The picture itself: the nameless layer, else `beauty`, else a layer whose name ends in
    /// `Combined`, else the only layer there is.
    ///
    /// # Errors
    /// [`FilmError::MissingChannels`].
    pub fn image(&self) -> Result<Image, FilmError> {
        let layers = self.layer_names();
        let combined = layers.iter().find(|name| name.ends_with("Combined"));
        let only = (layers.len() == 1).then(|| &layers[0]);
        [Some(""), Some("beauty"), combined.map(String::as_str), only.map(String::as_str)]
            .into_iter()
            .flatten()
            .find_map(|name| self.layer(name))
            .ok_or_else(|| FilmError::MissingChannels {
                path: self.path.clone(),
                wanted: "R, G, B or Y of one layer".to_owned(),
                found: self.channels.iter().map(|channel| channel.name.clone()).collect(),
            })
    }

    /// The layers that [`ExrFile::layer`] gives an image for, in the file's order.
    #[must_use]
    pub fn layer_names(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for channel in &self.channels {
            let (layer, component) = channel.name.rsplit_once('.').unwrap_or(("", &channel.name));
            if matches!(component, "R" | "Y") && !names.iter().any(|known| known == layer) {
                names.push(layer.to_owned());
            }
        }
        names
    }
}

fn decode(path: &Path, bytes: &[u8]) -> Result<ExrFile, String> {
    let reader = Reader::read_from_buffered(Cursor::new(bytes), false).map_err(|e| e.to_string())?;
    check_plausible(reader.headers(), bytes.len())?;
    let image: ExrImage<exr::image::Layers<AnyChannels<FlatSamples>>> = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        // Pedantic about blocks: none missing, none twice, none outside the file.
        .pedantic()
        .from_chunks(reader)
        .map_err(|e| e.to_string())?;
    let first = image.layer_data.first().ok_or("it has no parts")?;
    let Vec2(width, height) = first.size;
    let framing = framing(&image, first);
    let metadata = metadata(&image.attributes.other, &first.attributes.other);
    let many = image.layer_data.len() > 1;
    let mut channels = Vec::new();
    for part in image.layer_data {
        if part.size != Vec2(width, height) {
            return Err("its parts differ in size".to_owned());
        }
        channels.extend(planes(part, many));
    }
    Ok(ExrFile { path: path.to_owned(), width, height, framing, channels, metadata })
}

/// Refuses a file before its pixels are allocated: the header alone can ask for terabytes.
fn check_plausible(headers: &[Header], file_bytes: usize) -> Result<(), String> {
    let mut decoded = 0_usize;
    for header in headers {
        let Vec2(width, height) = header.layer_size;
        if header.deep {
            return Err("it holds deep data".to_owned());
        }
        if width > MAX_SIDE || height > MAX_SIDE {
            return Err(format!("{width}x{height} pixels are more than {MAX_SIDE} along a side"));
        }
        for channel in &header.channels.list {
            if channel.sampling != Vec2(1, 1) {
                return Err(format!("its channel {} is subsampled", channel.name));
            }
            decoded = decoded.saturating_add(width * height * channel.sample_type.bytes_per_sample());
        }
    }
    let limit = file_bytes.saturating_mul(MAX_EXPANSION).max(ALWAYS_ACCEPTED_BYTES);
    if decoded > limit {
        return Err(format!("its {file_bytes} bytes cannot hold the {decoded} bytes of pixels it claims"));
    }
    Ok(())
}

fn planes(part: Part, many: bool) -> Vec<Channel> {
    let prefix = match &part.attributes.layer_name {
        Some(name) if many => format!("{}.", lossy(name)),
        _ => String::new(),
    };
    let channels = part.channel_data.list.into_iter();
    channels
        .map(|channel| {
            let samples = match channel.sample_data {
                FlatSamples::F32(samples) => samples,
                FlatSamples::F16(samples) => samples.into_iter().map(f32::from).collect(),
                FlatSamples::U32(samples) => samples.into_iter().map(|sample| sample as f32).collect(),
            };
            Channel { name: format!("{prefix}{}", lossy(&channel.name)), samples }
        })
        .collect()
}

fn framing<L>(image: &ExrImage<L>, part: &Part) -> Option<Framing> {
    let display = image.attributes.display_window;
    let corner = |data: i32, frame: i32| usize::try_from(i64::from(data) - i64::from(frame)).ok();
    let position = part.attributes.layer_position;
    let offset = [corner(position.0, display.position.0)?, corner(position.1, display.position.1)?];
    let frame = [display.size.0, display.size.1];
    let inside = offset[0] + part.size.0 <= frame[0] && offset[1] + part.size.1 <= frame[1];
    (inside && frame != [part.size.0, part.size.1]).then_some(Framing { frame, offset })
}

fn metadata(shared: &HashMap<Text, AttributeValue>, own: &HashMap<Text, AttributeValue>) -> Metadata {
    let mut entries: Vec<(String, Value)> = shared
        .iter()
        .chain(own)
        .filter_map(|(name, attribute)| {
            let name = lossy(name);
            Some((name.strip_prefix(ATTRIBUTE_PREFIX)?.to_owned(), value(attribute)?))
        })
        .collect();
    entries.sort_by(|a, b| a.0.cmp(&b.0));
    Metadata { entries }
}

fn value(attribute: &AttributeValue) -> Option<Value> {
    Some(match attribute {
        AttributeValue::Text(text) => Value::Text(lossy(text)),
        AttributeValue::I32(int) => Value::Int((*int).into()),
        AttributeValue::F32(float) => Value::Float((*float).into()),
        AttributeValue::F64(float) => Value::Float(*float),
        AttributeValue::Matrix4x4(m) => {
            Value::Matrix(std::array::from_fn(|row| std::array::from_fn(|column| m[4 * row + column])))
        }
        _ => return None,
    })
}

fn lossy(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}
