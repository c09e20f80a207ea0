//! Textures: an image, how it is sampled, and where it lies.

use std::{collections::HashMap, sync::Arc};

use glam::{Mat3, Vec2, Vec3};
use midway_scene::{Channel, ColorInput, Filter, Image, ScalarInput, Texture, Wrap};

use super::{buffers::Buffers, json::Json};
use crate::{
    ImportError,
    files::{self, SceneFolder},
    images::{Bytes, Encoding, Images},
    warning::{WarningKind, Warnings},
};

/// Extensions that name another image for those who can read it, by which comes first.
const OTHER_SOURCES: [&str; 2] = ["KHR_texture_basisu", "EXT_texture_webp"];
const CLAMP_TO_EDGE: u64 = 33071;
const MIRRORED_REPEAT: u64 = 33648;
const REPEAT: u64 = 10497;
const NEAREST: u64 = 9728;
const LINEAR: u64 = 9729;

/// The document's textures, and the images that materials ask for.
pub(super) struct Textures<'a> {
    textures: Vec<Json<'a>>,
    samplers: Vec<Json<'a>>,
    images: Vec<Json<'a>>,
    buffers: &'a Buffers<'a>,
    folder: &'a SceneFolder,
    /// Images in buffers and data URIs, by the file's index.
    embedded: HashMap<usize, Bytes>,
    store: Images,
}

impl<'a> Textures<'a> {
    pub fn new(
        root: &Json<'a>,
        buffers: &'a Buffers<'a>,
        folder: &'a SceneFolder,
        file_bytes: u64,
    ) -> Result<Self, ImportError> {
        let mut store = Images::default();
        store.hold(buffers.total_bytes().saturating_add(file_bytes));
        Ok(Self {
            textures: root.items("textures")?,
            samplers: root.items("samplers")?,
            images: root.items("images")?,
            buffers,
            folder,
            embedded: HashMap::new(),
            store,
        })
    }

    /// The images that textures ask for, in the order of [`Texture::image`].
    pub fn into_images(self, warnings: &mut Warnings) -> Vec<Image> {
        self.store.decode(warnings)
    }

    /// A factor, times the member `key` of `holder` as a colour.
    pub fn color(
        &mut self,
        value: Vec3,
        holder: &Json,
        key: &str,
        warnings: &mut Warnings,
    ) -> Result<ColorInput, ImportError> {
        Ok(ColorInput { value, texture: self.texture(holder, key, Encoding::Srgb, warnings)? })
    }

    /// A factor, times one channel of the member `key` of `holder`.
    pub fn scalar(
        &mut self,
        value: f32,
        holder: &Json,
        (key, channel): (&str, Channel),
        warnings: &mut Warnings,
    ) -> Result<ScalarInput, ImportError> {
        let texture = self.texture(holder, key, Encoding::Linear, warnings)?;
        Ok(ScalarInput { value, texture: texture.map(|t| (t, channel)) })
    }

    /// A member that is a texture; none where it is absent or cannot be used.
    pub fn texture(
        &mut self,
        holder: &Json,
        key: &str,
        encoding: Encoding,
        warnings: &mut Warnings,
    ) -> Result<Option<Texture>, ImportError> {
        let Some(info) = holder.get(key) else {
            return Ok(None);
        };
        let index = info.required("index")?;
        let texture = self.textures[index.index("texture", self.textures.len())?].clone();
        let Some((uv_set, image_from_uv)) = placement(&info, warnings)? else {
            return Ok(None);
        };
        let Some(image) = self.image(&texture, encoding, warnings)? else {
            return Ok(None);
        };
        let (wrap, filter) = self.sampler(&texture)?;
        Ok(Some(Texture { image, uv_set, image_from_uv, wrap, filter }))
    }

    fn sampler(&self, texture: &Json) -> Result<([Wrap; 2], Filter), ImportError> {
        let Some(index) = texture.get("sampler") else {
            return Ok(Default::default());
        };
        let sampler = &self.samplers[index.index("sampler", self.samplers.len())?];
        let wrap = |key| {
            let mode = sampler.unsigned_or(key, REPEAT)?;
            Ok(match mode {
                REPEAT => Wrap::Repeat,
                MIRRORED_REPEAT => Wrap::Mirror,
                CLAMP_TO_EDGE => Wrap::Clamp,
                _ => return Err(sampler.malformed(format!("{mode} is no wrap mode"))),
            })
        };
        let filter = match sampler.unsigned_or("magFilter", LINEAR)? {
            NEAREST => Filter::Nearest,
            LINEAR => Filter::Bilinear,
            other => return Err(sampler.malformed(format!("{other} is no filter for magnification"))),
        };
        Ok(([wrap("wrapS")?, wrap("wrapT")?], filter))
    }

    /// The scene's image of a texture.
    fn image(
        &mut self,
        texture: &Json,
        encoding: Encoding,
        warnings: &mut Warnings,
    ) -> Result<Option<u32>, ImportError> {
        let other = OTHER_SOURCES.iter().find_map(|name| texture.extension(name)?.get("source"));
        let Some(source) = other.or_else(|| texture.get("source")) else {
            let message = "textures without an image are left out";
            warnings.add(WarningKind::Texture, texture.pointer(), message);
            return Ok(None);
        };
        let index = source.index("image", self.images.len())?;
        let image = self.images[index].clone();
        if let Some(uri) = image.get("uri") {
            let text = uri.string()?;
            if files::strip_data_scheme(text).is_none() {
                let path = files::decode_uri(text, &uri.place())?;
                return self.store.file(self.folder, &path, encoding, &uri.place(), warnings);
            }
        }
        let bytes = match self.embedded.get(&index) {
            Some(known) => known.clone(),
            None => self.embed(&image, index)?,
        };
        Ok(Some(self.store.bytes(bytes, encoding, image.name(), &image.place())))
    }

    /// The bytes of an image in a buffer or a data URI.
    fn embed(&mut self, image: &Json, index: usize) -> Result<Bytes, ImportError> {
        let bytes = match (image.get("uri"), image.get("bufferView")) {
            (Some(uri), _) => {
                let data = files::strip_data_scheme(uri.string()?).unwrap_or_default();
                let buffer: Arc<[u8]> = files::decode_data(data, &uri.place())?.into();
                Bytes { start: 0, end: buffer.len(), buffer }
            }
            (None, Some(view)) => self.buffers.shared(&view)?,
            (None, None) => return Err(image.malformed("an image has a \"uri\" or a \"bufferView\"")),
        };
        self.embedded.insert(index, bytes.clone());
        Ok(bytes)
    }
}

/// The UV set of a texture reference and its `KHR_texture_transform`; none where the set is one
/// that meshes have no room for.
fn placement(info: &Json, warnings: &mut Warnings) -> Result<Option<(u32, Mat3)>, ImportError> {
    let mut set = info.unsigned_or("texCoord", 0)?;
    let mut image_from_uv = Mat3::IDENTITY;
    if let Some(transform) = info.extension("KHR_texture_transform") {
        set = transform.unsigned_or("texCoord", set)?;
        let offset = Vec2::from_array(transform.floats_or("offset", [0.0; 2])?);
        let scale = Vec2::from_array(transform.floats_or("scale", [1.0; 2])?);
        // Counter-clockwise as seen on the image, whose v points down: clockwise in (u, v).
        let rotation = Mat3::from_angle(-transform.float_or("rotation", 0.0)?);
        image_from_uv = Mat3::from_translation(offset) * rotation * Mat3::from_scale(scale);
    }
    if set > 1 {
        let message = "textures on a third or later set of texture coordinates are left out";
        warnings.add(WarningKind::Texture, info.pointer(), message);
        return Ok(None);
    }
    if !image_from_uv.is_finite() {
        return Err(info.malformed("the texture's transform is not finite"));
    }
    Ok(Some((set as u32, image_from_uv)))
}
