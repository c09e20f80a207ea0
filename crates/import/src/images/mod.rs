//! Images: asked for by importers as they meet them, decoded together at the end, each once.
//!
//! An image that is missing or damaged can be done without: it is listed, and one texel that
//! changes nothing takes its place.

mod computed;
mod decode;
mod ktx;

use std::{
    collections::HashMap,
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use midway_scene::{Image, Texels};
use rayon::prelude::*;

use crate::{
    ImportError, Place,
    files::{self, SceneFolder},
    warning::{WarningKind, Warnings},
};
use computed::Computed;
pub(crate) use computed::Input;
use decode::{Decoded, MAX_TEXELS, Problem};

/// Texels that a scene may have, however small its files.
const FREE_TEXELS: u64 = 1 << 26;
/// Texels for each byte of the files beyond that: what flat colour compresses to, and no more.
const TEXELS_PER_BYTE: u64 = 512;

/// What is said where a colour or a number in [0, 1] is greater.
pub(crate) const CUT_TO_ONE: &str = "reflectances and shares above 1 are cut to 1";
/// What is less above 1 is rounding.
pub(crate) const LEAST_CUT: f32 = 1.001;

/// What the whole numbers of an image stand for. Files of floats are linear whatever is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Encoding {
    /// Colour by the sRGB curve.
    Srgb,
    /// Themselves: 0 to 1.
    Linear,
    /// A tangent-space normal map: [`Encoding::Linear`], and flat where the image is missing.
    Normal,
}

/// The images that a scene asks for.
#[derive(Default)]
pub(crate) struct Images {
    sources: Vec<Source>,
    known_sources: HashMap<Key, usize>,
    requests: Vec<Request>,
    known_requests: HashMap<(usize, Encoding), u32>,
    held_bytes: u64,
    scaled: Vec<Scaled>,
    /// What was read at once, or why it was not, each once.
    read: HashMap<(PathBuf, Encoding), Result<Image, Problem>>,
    /// The sizes of their files.
    read_files: HashMap<PathBuf, u64>,
    /// The sum of those.
    read_bytes: u64,
    /// Texels of what was read at once, and of what importers made.
    made_texels: u64,
    lacked_room: bool,
}

/// An image that is multiplied by more than 1 where the product is to be at most 1.
struct Scaled {
    image: u32,
    /// Of each channel; 0 for those that are not used.
    by: [f32; 4],
    place: String,
}

enum Source {
    File(PathBuf),
    Bytes(Bytes),
    Ready(Image),
}

/// A range of a buffer, shared.
#[derive(Clone)]
pub(crate) struct Bytes {
    /// The buffer.
    pub buffer: Arc<[u8]>,
    /// First byte.
    pub start: usize,
    /// One past the last; at most the buffer's length.
    pub end: usize,
}

#[derive(PartialEq, Eq, Hash)]
enum Key {
    File(PathBuf),
    /// Address and length: buffers are shared, and kept until all is decoded.
    Bytes(usize, usize),
}

enum Request {
    Read(Reading),
    Computed(Computed),
}

struct Reading {
    source: usize,
    encoding: Encoding,
    name: String,
    place: String,
}

impl Images {
    /// An image file in the scene's folder, by a relative path that is not percent-encoded. The
    /// index is that of the image in [`Images::decode`]'s list, the same for the same file and
    /// encoding. None, and a warning, where there is no such file.
    ///
    /// # Errors
    ///
    /// [`ImportError`] where the path leaves the folder or names another machine.
    pub fn file(
        &mut self,
        folder: &SceneFolder,
        name: &str,
        encoding: Encoding,
        place: &Place,
        warnings: &mut Warnings,
    ) -> Result<Option<u32>, ImportError> {
        let path = match folder.find(name, place) {
            Ok(path) => path,
            Err(ImportError::MissingBuffer { uri, .. }) => {
                let message = format!("the image {uri:?} does not exist: the surface is rendered without it");
                warnings.add(WarningKind::MissingFile, place.short(), message);
                return Ok(None);
            }
            Err(other) => return Err(other),
        };
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let source = self.source(Key::File(path.clone()), || Source::File(path));
        Ok(Some(self.request(source, encoding, file, place)))
    }

    /// An image that lies in a buffer.
    pub fn bytes(&mut self, bytes: Bytes, encoding: Encoding, name: String, place: &Place) -> u32 {
        let key = Key::Bytes(bytes.get().as_ptr() as usize, bytes.get().len());
        let source = self.source(key, || Source::Bytes(bytes));
        self.request(source, encoding, name, place)
    }

    /// An image that an importer made.
    pub fn ready(&mut self, image: Image) -> u32 {
        let name = image.name.clone();
        self.made_texels = self.made_texels.saturating_add(image.texels.len() as u64);
        self.sources.push(Source::Ready(image));
        self.request(self.sources.len() - 1, Encoding::Linear, name, &Place::default())
    }

    /// An image in the scene's folder, at once: for what has to be computed from it. Each is decoded once, and
    /// kept.
    ///
    /// # Errors
    ///
    /// [`ImportError`] where it is not there, leaves the folder, cannot be decoded, or has more texels than the
    /// files that were read hold.
    pub fn read_now(
        &mut self,
        folder: &SceneFolder,
        name: &str,
        encoding: Encoding,
        place: &Place,
    ) -> Result<Image, ImportError> {
        let key = (folder.find(name, place)?, encoding);
        let known = self.read.get(&key).cloned();
        let image = known.unwrap_or_else(|| {
            let image = self.read_first(&key.0, encoding);
            self.read.insert(key, image.clone());
            image
        });
        image.map_err(|problem| ImportError::Malformed { place: place.clone(), problem: problem.to_string() })
    }

    fn read_first(&mut self, path: &Path, encoding: Encoding) -> Result<Image, Problem> {
        let source = Source::File(path.to_owned());
        let [width, height] = source.size()?;
        let bytes = source.bytes_of_file();
        if self.read_files.insert(path.to_owned(), bytes).is_none() {
            self.read_bytes = self.read_bytes.saturating_add(bytes);
        }
        let n_texels = u64::from(width) * u64::from(height);
        if n_texels > self.room() {
            return Err(Problem::BeyondFiles { width, height });
        }
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let image = source.decode()?.image(file, encoding);
        self.made_texels += n_texels;
        Ok(image)
    }

    /// Whether an image of so many texels may be made yet; if not, a warning says at the end that it is one
    /// colour.
    pub fn has_room(&mut self, n_texels: u64) -> bool {
        let is_room = n_texels <= self.room();
        self.lacked_room |= !is_room;
        is_room
    }

    fn room(&self) -> u64 {
        limit(self.held_bytes.saturating_add(self.read_bytes)).saturating_sub(self.made_texels)
    }

    /// Notes that an image is multiplied where the product is to be at most 1: there it is cut off as it is
    /// used, and if any texel is, a warning says so.
    pub fn scaled(&mut self, image: u32, by: [f32; 4], place: &Place) {
        let is_float = match &self.requests[image as usize] {
            Request::Read(reading) => {
                matches!(&self.sources[reading.source], Source::Ready(Image { texels: Texels::Float(_), .. }))
            }
            Request::Computed(_) => false,
        };
        if is_float || by.iter().any(|factor| *factor > 1.0) {
            self.scaled.push(Scaled { image, by, place: place.short() });
        }
    }

    fn source(&mut self, key: Key, make: impl FnOnce() -> Source) -> usize {
        let next = self.sources.len();
        let index = *self.known_sources.entry(key).or_insert(next);
        if index == next {
            self.sources.push(make());
        }
        index
    }

    fn request(&mut self, source: usize, encoding: Encoding, name: String, place: &Place) -> u32 {
        let next = self.requests.len() as u32;
        let index = *self.known_requests.entry((source, encoding)).or_insert(next);
        if index == next {
            self.requests.push(Request::Read(Reading { source, encoding, name, place: place.short() }));
        }
        index
    }

    /// Counts bytes that hold images and are not files of their own: what may be decoded is
    /// bounded by what the files hold.
    pub fn hold(&mut self, bytes: u64) {
        self.held_bytes = self.held_bytes.saturating_add(bytes);
    }

    /// Every image that was asked for, in the order of indices. What cannot be decoded is listed
    /// and replaced.
    pub fn decode(mut self, warnings: &mut Warnings) -> Vec<Image> {
        let (admitted, mut room) = self.admit();
        self.read.clear();
        if self.lacked_room {
            let message = "textures that are made of images are too large: they have one colour";
            warnings.add(WarningKind::Texture, "", message);
        }
        let decoded: Vec<Result<Decoded, Problem>> = self
            .sources
            .par_iter()
            .zip(admitted)
            .map(|(source, ok)| ok.and_then(|()| source.decode()))
            .collect();
        let mut images = Vec::with_capacity(self.requests.len());
        for request in &self.requests {
            images.push(match request {
                Request::Read(reading) => reading.image(&decoded[reading.source], warnings),
                Request::Computed(computed) => computed.image(&images, &mut room, warnings),
            });
        }
        let mut peaks = HashMap::new();
        for Scaled { image, by, place } in self.scaled {
            let is_there = match &self.requests[image as usize] {
                Request::Read(reading) => decoded[reading.source].is_ok(),
                Request::Computed(_) => true,
            };
            let peak = peaks.entry(image).or_insert_with(|| peak(&images[image as usize]));
            if is_there && peak.iter().zip(by).any(|(x, by)| x * by > LEAST_CUT) {
                warnings.add(WarningKind::Repaired, place, CUT_TO_ONE);
            }
        }
        images
    }

    /// Whether each source may be decoded, by the size in its header, and how many texels may be made beyond
    /// that.
    fn admit(&mut self) -> (Vec<Result<(), Problem>>, u64) {
        let sizes: Vec<_> = self.sources.par_iter().map(Source::size).collect();
        let held = self.sources.iter().map(Source::bytes_of_file).fold(self.held_bytes, u64::saturating_add);
        let is_source = |path: &PathBuf| self.known_sources.contains_key(&Key::File(path.clone()));
        let read = self.read_files.iter().filter(|(path, _)| !is_source(path)).map(|(_, bytes)| *bytes);
        let limit = limit(read.fold(held, u64::saturating_add));
        let mut total = self.made_texels;
        let admit = |size: Result<[u32; 2], Problem>| {
            let [width, height] = size?;
            total = total.saturating_add(u64::from(width) * u64::from(height));
            if total <= limit { Ok(()) } else { Err(Problem::BeyondFiles { width, height }) }
        };
        let admitted = sizes.into_iter().map(admit).collect();
        (admitted, limit.saturating_sub(total))
    }
}

impl Reading {
    fn image(&self, decoded: &Result<Decoded, Problem>, warnings: &mut Warnings) -> Image {
        match decoded {
            Ok(decoded) => {
                if let Some(note) = decoded.note {
                    warnings.add(WarningKind::Repaired, self.place.clone(), note);
                }
                decoded.image(self.name.clone(), self.encoding)
            }
            Err(problem) => {
                let message = format!("{problem}: the surface is rendered without it");
                warnings.add(WarningKind::Texture, self.place.clone(), message);
                placeholder(self)
            }
        }
    }
}

/// Texels that files of so many bytes may have.
fn limit(bytes: u64) -> u64 {
    bytes.saturating_mul(TEXELS_PER_BYTE).saturating_add(FREE_TEXELS)
}

/// An image file that is named beside the scene, at once; what was repaired in it.
///
/// # Errors
///
/// [`ImportError`] where it is not there, is no image, or claims more texels than a file of its
/// size holds.
pub(crate) fn read_file(
    path: &Path,
    encoding: Encoding,
) -> Result<(Image, Option<&'static str>), ImportError> {
    let bytes = files::read_scene(path, false)?;
    let malformed = |problem: Problem| ImportError::Malformed {
        place: Place::new(path, ""),
        problem: problem.to_string(),
    };
    let extension = extension(path);
    let [width, height] = decode::size(&bytes, extension.as_deref()).map_err(malformed)?;
    if u64::from(width) * u64::from(height) > limit(bytes.len() as u64) {
        return Err(malformed(Problem::BeyondFiles { width, height }));
    }
    let decoded = decode::decode(&bytes, extension.as_deref()).map_err(malformed)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok((decoded.image(name, encoding), decoded.note))
}

impl Source {
    fn bytes_of_file(&self) -> u64 {
        match self {
            Self::File(path) => fs::metadata(path).map_or(0, |m| m.len()),
            Self::Bytes(_) | Self::Ready(_) => 0,
        }
    }

    fn size(&self) -> Result<[u32; 2], Problem> {
        match self {
            Self::File(path) => decode::size_of_file(path),
            Self::Bytes(bytes) => decode::size(bytes.get(), None),
            // Counted when it was made.
            Self::Ready(_) => Ok([0, 0]),
        }
    }

    fn decode(&self) -> Result<Decoded, Problem> {
        match self {
            Self::File(path) => {
                let bytes = fs::read(path).map_err(|e| Problem::Unreadable(e.to_string()))?;
                decode::decode(&bytes, extension(path).as_deref())
            }
            Self::Bytes(bytes) => decode::decode(bytes.get(), None),
            Self::Ready(image) => Ok(Decoded::ready(image)),
        }
    }
}

impl Bytes {
    fn get(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }
}

fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_string_lossy().to_ascii_lowercase())
}

/// The largest value of each channel.
fn peak(image: &Image) -> [f32; 4] {
    let larger = |a: [f32; 4], b: [f32; 4]| std::array::from_fn(|i| a[i].max(b[i]));
    (0..image.texels.len())
        .into_par_iter()
        .map(|index| image.texels.linear(index))
        .reduce(|| [0.0; 4], larger)
}

/// A texel that leaves a factor, or a normal, as it is.
fn placeholder(reading: &Reading) -> Image {
    let texel = if reading.encoding == Encoding::Normal { [128, 128, 255, 255] } else { [255; 4] };
    Image { name: reading.name.clone(), width: 1, height: 1, texels: Texels::Linear8([texel].into()) }
}
