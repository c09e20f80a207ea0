//! Images in the texel store, and textures as records of vec4.

use std::collections::HashMap;

use glam::{DVec3, Mat3, Vec3};
use midway_device::{Buffer, Device};
use midway_kernels::constants as k;
use midway_scene::{ColorInput, Filter, Image, Scene, Texels, Texture, Wrap, srgb_to_linear};

use super::Word4;
use crate::RenderError;

/// A texel of the store, in bytes.
const TEXEL_BYTES: u64 = 16;

/// Images that textures refer to, with their places in the texel store. Their texels are shared with
/// the scene, and packed when they are uploaded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PackedImages {
    /// Each with its first texel, one after the other.
    placed: Vec<(Image, u32)>,
    /// The place in `placed` of each of the scene's images that has one.
    indices: HashMap<u32, usize>,
    n_texels: u64,
}

impl PackedImages {
    /// One of the scene's images with its place, which it is given where it has none.
    fn place(&mut self, scene: &Scene, image: u32) -> &(Image, u32) {
        let next = self.placed.len();
        let index = *self.indices.entry(image).or_insert(next);
        if index == next {
            let own = scene.images[image as usize].clone();
            // Whether it fits is for `check` to say.
            let at = self.n_texels as u32;
            self.n_texels += n_store_texels(&own);
            self.placed.push((own, at));
        }
        &self.placed[index]
    }

    /// That all texels can be addressed.
    ///
    /// # Errors
    /// If they are more than 32 bits can: 64 GiB.
    pub fn check(&self) -> Result<(), RenderError> {
        if self.n_texels > u64::from(u32::MAX) { Err(RenderError::TooManyTexels) } else { Ok(()) }
    }

    /// The store's size, at least one texel.
    pub fn bytes(&self) -> u64 {
        self.n_texels.max(1) * TEXEL_BYTES
    }

    /// The whole store, for devices that are handed it at once.
    pub fn to_words(&self) -> Vec<Word4> {
        let mut words: Vec<Word4> = self.placed.iter().flat_map(|(image, _)| pack_image(image)).collect();
        words.resize((self.bytes() / TEXEL_BYTES) as usize, Word4::default());
        words
    }

    /// Packs each image and writes it to the store.
    ///
    /// # Errors
    /// If the device fails.
    pub fn upload(&self, device: &dyn Device, store: &Buffer) -> Result<(), RenderError> {
        for (image, place) in &self.placed {
            let words = pack_image(image);
            device.write_buffer(store, u64::from(*place) * TEXEL_BYTES, bytemuck::cast_slice(&words))?;
        }
        Ok(())
    }
}

/// The store's texels that an image takes.
fn n_store_texels(image: &Image) -> u64 {
    let (width, height) = (u64::from(image.width), u64::from(image.height));
    match image.texels {
        Texels::Srgb8(_) | Texels::Linear8(_) => width.div_ceil(2) * height.div_ceil(2),
        Texels::Linear16(_) => width.div_ceil(2) * height,
        Texels::Float(_) => width * height,
    }
}

/// An image's texels as the store holds them (lib/texture.wgsl).
fn pack_image(image: &Image) -> Vec<Word4> {
    let mut words = vec![Word4::default(); n_store_texels(image) as usize];
    let (width, pairs) = (image.width as usize, image.width.div_ceil(2) as usize);
    match &image.texels {
        Texels::Srgb8(texels) | Texels::Linear8(texels) => {
            for (y, row) in texels.chunks_exact(width).enumerate() {
                for (x, texel) in row.iter().enumerate() {
                    words[y / 2 * pairs + x / 2][y % 2 * 2 + x % 2] = u32::from_le_bytes(*texel);
                }
            }
        }
        Texels::Linear16(texels) => {
            for (y, row) in texels.chunks_exact(width).enumerate() {
                for (x, &[r, g, b, a]) in row.iter().enumerate() {
                    let word = &mut words[y * pairs + x / 2];
                    word[x % 2 * 2] = u32::from(r) | u32::from(g) << 16;
                    word[x % 2 * 2 + 1] = u32::from(b) | u32::from(a) << 16;
                }
            }
        }
        Texels::Float(texels) => {
            for (word, texel) in words.iter_mut().zip(texels.iter()) {
                *word = texel.map(f32::to_bits);
            }
        }
    }
    words
}

/// Textures, each record once.
#[derive(Default)]
pub struct TextureTable {
    records: Vec<[Word4; k::TEXTURE_STRIDE as usize]>,
    indices: HashMap<[Word4; k::TEXTURE_STRIDE as usize], u32>,
}

impl TextureTable {
    /// The index of a texture's record; its image is given a place.
    pub fn index(&mut self, images: &mut PackedImages, scene: &Scene, texture: &Texture) -> u32 {
        let record = record(images.place(scene, texture.image), texture);
        let next = self.records.len() as u32;
        let index = *self.indices.entry(record).or_insert(next);
        if index == next {
            self.records.push(record);
        }
        index
    }

    /// All records.
    pub fn words(&self) -> &[Word4] {
        self.records.as_flattened()
    }
}

fn record((image, place): &(Image, u32), texture: &Texture) -> [Word4; k::TEXTURE_STRIDE as usize] {
    let encoding = match image.texels {
        Texels::Srgb8(_) => k::ENCODING_SRGB8,
        Texels::Linear8(_) => k::ENCODING_LINEAR8,
        Texels::Linear16(_) => k::ENCODING_LINEAR16,
        Texels::Float(_) => k::ENCODING_FLOAT,
    };
    let [wrap_u, wrap_v] = texture.wrap.map(|wrap| match wrap {
        Wrap::Repeat => k::WRAP_REPEAT,
        Wrap::Mirror => k::WRAP_MIRROR,
        Wrap::Clamp => k::WRAP_CLAMP,
        Wrap::Black => k::WRAP_BLACK,
    });
    let bilinear = u32::from(texture.filter == Filter::Bilinear);
    let bits = encoding | wrap_u << 2 | wrap_v << 4 | bilinear << 6 | texture.uv_set << 7;
    let row = |row: usize| {
        let r = Mat3::row(&texture.image_from_uv, row).to_array().map(f32::to_bits);
        [r[0], r[1], r[2], 0]
    };
    [[*place, image.width, image.height, bits], row(0), row(1)]
}

/// A colour's mean over its image, by which textured lights are weighed: positive where any texel is.
pub fn mean_color(scene: &Scene, input: &ColorInput) -> Vec3 {
    let Some(texture) = input.texture.as_ref().filter(|_| input.value != Vec3::ZERO) else {
        return input.value;
    };
    let texels = &scene.images[texture.image as usize].texels;
    let sum = (0..texels.len()).map(|i| texels.linear(i)).fold(DVec3::ZERO, |sum, [r, g, b, _]| {
        sum + DVec3::new(r.into(), g.into(), b.into()).max(DVec3::ZERO)
    });
    input.value * (sum / texels.len() as f64).as_vec3()
}

/// The sRGB curve for each byte.
pub fn srgb_table() -> [Word4; k::SRGB_TABLE_SIZE as usize] {
    std::array::from_fn(|i| std::array::from_fn(|c| srgb_to_linear((4 * i + c) as u8).to_bits()))
}
