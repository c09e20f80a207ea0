//! Images that are computed from others, texel by texel: what a scene says of textures and materials has
//! one texture for each value.

use glam::{Vec2, Vec3};
use midway_scene::{Channel, ColorInput, Filter, Image, ScalarInput, Texels, Texture, Wrap};
use rayon::prelude::*;

use super::{Images, MAX_TEXELS, Request};
use crate::warning::{WarningKind, Warnings};

/// What a computation takes: a colour, or a number, which is a grey to it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Input {
    Color(ColorInput),
    Scalar(ScalarInput),
}

/// A function of colours; the result counts within 0 and 1.
type Function = Box<dyn Fn(&[Vec3]) -> Vec3 + Send + Sync>;

/// An image to be computed.
pub(super) struct Computed {
    operands: Vec<Operand>,
    function: Function,
    wrap: [Wrap; 2],
    filter: Filter,
}

/// A value, times the colours of an image, or one channel of it.
#[derive(Clone, Copy)]
struct Operand {
    value: Vec3,
    image: Option<(u32, Option<Channel>)>,
}

impl Images {
    /// A function of inputs, the result within 0 and 1. None where it would take more than an image: where
    /// textures lie on a surface in different ways, or end in black.
    pub fn computed(
        &mut self,
        inputs: &[Input],
        function: impl Fn(&[Vec3]) -> Vec3 + Send + Sync + 'static,
    ) -> Option<ColorInput> {
        let operands: Vec<Operand> = inputs.iter().map(Input::operand).collect();
        let mut textures = inputs.iter().filter_map(Input::texture);
        let Some(first) = textures.next() else {
            let values: Vec<Vec3> = operands.iter().map(|operand| operand.value).collect();
            return Some(function(&values).clamp(Vec3::ZERO, Vec3::ONE).into());
        };
        let lies_alike = |other: &Texture| Texture { image: first.image, ..other.clone() } == *first;
        if first.wrap.contains(&Wrap::Black) || !textures.all(lies_alike) {
            return None;
        }
        let (wrap, filter) = (first.wrap, first.filter);
        let computed = Computed { operands, function: Box::new(function), wrap, filter };
        self.requests.push(Request::Computed(computed));
        let texture = Texture { image: self.requests.len() as u32 - 1, ..first.clone() };
        Some(ColorInput { value: Vec3::ONE, texture: Some(texture) })
    }

    /// The same of a number, a grey in the function.
    pub fn computed_scalar(
        &mut self,
        inputs: &[Input],
        function: impl Fn(&[Vec3]) -> Vec3 + Send + Sync + 'static,
    ) -> Option<ScalarInput> {
        let ColorInput { value, texture } = self.computed(inputs, function)?;
        Some(ScalarInput { value: value.y, texture: texture.map(|texture| (texture, Channel::G)) })
    }
}

impl Input {
    fn texture(&self) -> Option<&Texture> {
        match self {
            Self::Color(color) => color.texture.as_ref(),
            Self::Scalar(scalar) => scalar.texture.as_ref().map(|(texture, _)| texture),
        }
    }

    fn operand(&self) -> Operand {
        match self {
            Self::Color(ColorInput { value, texture }) => {
                Operand { value: *value, image: texture.as_ref().map(|texture| (texture.image, None)) }
            }
            Self::Scalar(ScalarInput { value, texture }) => Operand {
                value: Vec3::splat(*value),
                image: texture.as_ref().map(|(texture, channel)| (texture.image, Some(*channel))),
            },
        }
    }
}

impl From<ColorInput> for Input {
    fn from(color: ColorInput) -> Self {
        Self::Color(color)
    }
}

impl From<ScalarInput> for Input {
    fn from(scalar: ScalarInput) -> Self {
        Self::Scalar(scalar)
    }
}

impl Computed {
    /// The image, from those before it, as large as the largest of them; or as one texel, and a warning, where
    /// there is no room for so many.
    pub fn image(&self, images: &[Image], room: &mut u64, warnings: &mut Warnings) -> Image {
        let [width, height] = self.size(images);
        let n_texels = u64::from(width) * u64::from(height);
        if n_texels > (*room).min(MAX_TEXELS) {
            let message = "textures that are mixtures of others are too large: they have one colour";
            warnings.add(WarningKind::Texture, "", message);
            return self.of_size(images, [1, 1]);
        }
        *room -= n_texels;
        self.of_size(images, [width, height])
    }

    fn size(&self, images: &[Image]) -> [u32; 2] {
        let sizes = self.operands.iter().filter_map(|operand| operand.image).map(|(image, _)| {
            let Image { width, height, .. } = images[image as usize];
            [width, height]
        });
        sizes.fold([1, 1], |[width, height], [w, h]| [width.max(w), height.max(h)])
    }

    fn of_size(&self, images: &[Image], [width, height]: [u32; 2]) -> Image {
        let word = |x: f32| (x.clamp(0.0, 1.0) * 65535.0).round() as u16;
        let texel = |index: u32| {
            let place = Vec2::new((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
            let uv = place / Vec2::new(width as f32, height as f32);
            let values: Vec<Vec3> =
                self.operands.iter().map(|operand| self.value(operand, images, uv)).collect();
            (self.function)(&values).extend(1.0).to_array().map(word)
        };
        let texels: Vec<[u16; 4]> = (0..width * height).into_par_iter().map(texel).collect();
        Image { name: "computed".to_owned(), width, height, texels: Texels::Linear16(texels.into()) }
    }

    fn value(&self, operand: &Operand, images: &[Image], uv: Vec2) -> Vec3 {
        let Some((image, channel)) = operand.image else { return operand.value };
        let rgba = self.lookup(&images[image as usize], uv);
        let rgb = match channel {
            None => Vec3::new(rgba[0], rgba[1], rgba[2]),
            Some(channel) => Vec3::splat(rgba[channel as usize]),
        };
        operand.value * rgb
    }

    /// An image's colour at a place, as textures are looked up.
    fn lookup(&self, image: &Image, uv: Vec2) -> [f32; 4] {
        let size = Vec2::new(image.width as f32, image.height as f32);
        let shift = if self.filter == Filter::Nearest { 0.0 } else { 0.5 };
        let place = uv * size - shift;
        let corner = place.floor();
        let texel = |dx: i64, dy: i64| {
            let x = wrapped(corner.x as i64 + dx, image.width, self.wrap[0]);
            let y = wrapped(corner.y as i64 + dy, image.height, self.wrap[1]);
            image.texels.linear((y * image.width + x) as usize)
        };
        let part = place - corner;
        if self.filter == Filter::Nearest || part == Vec2::ZERO {
            return texel(0, 0);
        }
        let [a, b, c, d] = [texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)];
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        std::array::from_fn(|i| mix(mix(a[i], b[i], part.x), mix(c[i], d[i], part.x), part.y))
    }
}

/// A row's or a column's number within an image, at most one beside it.
fn wrapped(index: i64, n: u32, wrap: Wrap) -> u32 {
    let n = i64::from(n);
    let within = match wrap {
        Wrap::Repeat => index.rem_euclid(n),
        // One beyond the edge is the edge's own image.
        Wrap::Mirror | Wrap::Clamp | Wrap::Black => index.clamp(0, n - 1),
    };
    within as u32
}
