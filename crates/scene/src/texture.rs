//! Images, and the places on surfaces where their texels count.

use std::sync::{Arc, LazyLock};

use glam::{Mat3, Vec2, Vec3};

/// Texels in memory. Row 0 is the top one: v = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The file's name for it, or empty.
    pub name: String,
    /// Texels in a row, > 0.
    pub width: u32,
    /// Rows, > 0.
    pub height: u32,
    /// width x height texels.
    pub texels: Texels,
}

/// The values of an image, RGBA, row by row; shared between images that read one file in two ways.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// Colour by the sRGB curve, alpha linear.
    Srgb8(Arc<[[u8; 4]]>),
    /// Linear, 255 is 1.
    Linear8(Arc<[[u8; 4]]>),
    /// Linear, 65535 is 1.
    Linear16(Arc<[[u16; 4]]>),
    /// Linear, any finite value.
    Float(Arc<[[f32; 4]]>),
}

impl Texels {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Srgb8(t) | Self::Linear8(t) => t.len(),
            Self::Linear16(t) => t.len(),
            Self::Float(t) => t.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A texel as linear RGBA.
    ///
    /// # Panics
    ///
    /// Where `index` is out of range.
    pub fn linear(&self, index: usize) -> [f32; 4] {
        match self {
            Self::Srgb8(t) => {
                let [r, g, b, a] = t[index];
                [srgb_to_linear(r), srgb_to_linear(g), srgb_to_linear(b), f32::from(a) / 255.0]
            }
            Self::Linear8(t) => t[index].map(|x| f32::from(x) / 255.0),
            Self::Linear16(t) => t[index].map(|x| f32::from(x) / 65535.0),
            Self::Float(t) => t[index],
        }
    }
}

/// IEC 61966-2-1, for one byte: by a table, as images have millions of them.
pub fn srgb_to_linear(byte: u8) -> f32 {
    static TABLE: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|byte| srgb_curve(byte as u8)));
    TABLE[usize::from(byte)]
}

fn srgb_curve(byte: u8) -> f32 {
    let x = f64::from(byte) / 255.0;
    let linear = if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

/// How an image lies on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Index into [`crate::Scene::images`].
    pub image: u32,
    /// Which of [`crate::Mesh::uvs`], 0 or 1.
    pub uv_set: u32,
    /// Maps (u, v, 1) of the mesh to those of the image; affine.
    pub image_from_uv: Mat3,
    /// What lies beyond the image along u and v.
    pub wrap: [Wrap; 2],
    /// Between texels.
    pub filter: Filter,
}

impl Texture {
    /// An image on the first UV set, repeated, bilinear.
    pub fn new(image: u32) -> Self {
        Self {
            image,
            uv_set: 0,
            image_from_uv: Mat3::IDENTITY,
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Bilinear,
        }
    }

    /// Where a point of the mesh lies on the image; [0, 1]² is the image.
    pub fn place(&self, uv: Vec2) -> Vec2 {
        self.image_from_uv.transform_point2(uv)
    }
}

/// What lies beyond an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image again, every other time mirrored.
    Mirror,
    /// Its edge.
    Clamp,
    /// Zero.
    Black,
}

/// What lies between texels' centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// The four nearest, blended.
    #[default]
    Bilinear,
}

/// A colour: a value, times a texture's RGB where there is one. Of what is at most 1 the product is cut
/// off there, and the value of one with a texture may be greater.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorInput {
    /// Linear Rec. 709.
    pub value: Vec3,
    /// Multiplies it.
    pub texture: Option<Texture>,
}

/// A number: a value, times one channel of a texture where there is one; cut off as a colour is.
#[derive(Clone, Debug, PartialEq)]
pub struct ScalarInput {
    /// The value.
    pub value: f32,
    /// Multiplies it.
    pub texture: Option<(Texture, Channel)>,
}

/// A channel of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Red.
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Alpha.
    A,
}

impl From<Vec3> for ColorInput {
    fn from(value: Vec3) -> Self {
        Self { value, texture: None }
    }
}

impl From<f32> for ScalarInput {
    fn from(value: f32) -> Self {
        Self { value, texture: None }
    }
}
