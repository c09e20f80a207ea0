//! Textures, and the colours and numbers that they vary.

use glam::{Mat3, Mat4, Vec2, Vec3};
use midway_scene::{Channel, ColorInput, Filter, Image, ScalarInput, Texels, Texture, Wrap};

use super::{
    Loader, MAX_DEPTH,
    document::{BLACK_BODY, Class},
    node::Node,
    transform,
    value::{Quantity, spectrum_plugin},
};
use crate::{
    ImportError,
    images::{CUT_TO_ONE, Encoding, LEAST_CUT},
    warning::WarningKind,
};

/// A texture, and what multiplies it.
struct Scaled {
    scale: Vec3,
    texture: Option<Texture>,
    channel: Channel,
}

impl Loader<'_> {
    /// A colour by name: a value, or a texture. Shares are kept within 0 and 1.
    pub(super) fn color(
        &mut self,
        node: Node,
        name: &str,
        quantity: Quantity,
        default: f32,
    ) -> Result<ColorInput, ImportError> {
        let input = match node.child(name)? {
            Some(child) if child.class() == Class::Texture => {
                let Scaled { scale, texture, .. } = self.texture(child, quantity, 0)?;
                ColorInput { value: scale, texture }
            }
            _ => node.color(name, quantity)?.unwrap_or(Vec3::splat(default)).into(),
        };
        if quantity != Quantity::Share {
            return Ok(input);
        }
        let value = match &input.texture {
            Some(texture) => {
                self.images.scaled(texture.image, input.value.extend(0.0).to_array(), node.place());
                input.value
            }
            None => self.cut(node, input.value),
        };
        Ok(ColorInput { value, ..input })
    }

    /// A share that no texture multiplies.
    fn cut(&mut self, node: Node, value: Vec3) -> Vec3 {
        if value.max_element() > LEAST_CUT {
            self.warn(WarningKind::Repaired, node, CUT_TO_ONE);
        }
        value.min(Vec3::ONE)
    }

    /// A number in [0, 1] by name: a value, or a channel of a texture.
    pub(super) fn scalar(
        &mut self,
        node: Node,
        name: &str,
        default: f32,
    ) -> Result<ScalarInput, ImportError> {
        let input = match node.child(name)? {
            Some(child) if child.class() == Class::Texture => {
                let scaled = self.texture(child, Quantity::Share, 0)?;
                let value = scaled.scale.x;
                ScalarInput { value, texture: scaled.texture.map(|texture| (texture, scaled.channel)) }
            }
            _ => {
                let color = node.color(name, Quantity::Share)?.unwrap_or(Vec3::splat(default));
                // Of a colour the luminance, as Mitsuba takes it.
                let luminance = color.dot(Vec3::new(0.212_671, 0.715_16, 0.072_169));
                let value = if color == Vec3::splat(color.x) { color.x } else { luminance };
                value.into()
            }
        };
        let value = match &input.texture {
            Some((texture, channel)) => {
                let mut by = [0.0; 4];
                by[*channel as usize] = input.value;
                self.images.scaled(texture.image, by, node.place());
                input.value
            }
            None => self.cut(node, Vec3::splat(input.value)).x,
        };
        Ok(ScalarInput { value, ..input })
    }

    /// A texture object.
    fn texture(&mut self, node: Node, quantity: Quantity, depth: usize) -> Result<Scaled, ImportError> {
        if depth > MAX_DEPTH {
            return Err(node.malformed("textures refer to each other without end"));
        }
        match node.plugin() {
            "bitmap" => self.bitmap(node),
            "checkerboard" => self.checkerboard(node, quantity),
            "scale" => {
                let inner = node.first(Class::Texture)?;
                let inner = inner.ok_or_else(|| node.malformed("it scales no texture"))?;
                let by =
                    node.color("scale", Quantity::Unbounded)?.or(node.color("value", Quantity::Unbounded)?);
                let inner = self.texture(inner, quantity, depth + 1)?;
                Ok(Scaled { scale: inner.scale * by.unwrap_or(Vec3::ONE), ..inner })
            }
            // What it holds, under an illuminant whose white is white.
            "d65" if node.first(Class::Texture)?.is_some() => {
                let inner =
                    node.first(Class::Texture)?.ok_or_else(|| node.malformed("it holds no texture"))?;
                let by = node.float_or("scale", 1.0)?.max(0.0);
                let inner = self.texture(inner, quantity, depth + 1)?;
                Ok(Scaled { scale: inner.scale * by, ..inner })
            }
            // Releases since 2 write values as objects too.
            plugin @ ("uniform" | "d65" | "blackbody" | "irregular" | "regular") => {
                let color = spectrum_plugin(plugin, &node.values()).and_then(|value| value.color(quantity));
                let scale = color.ok_or_else(|| node.malformed("it has no value that is read"))?;
                if scale.min_element() < 0.0 {
                    return Err(node.malformed("its value is below 0"));
                }
                if plugin == "blackbody" {
                    self.warn(WarningKind::Approximation, node, BLACK_BODY);
                }
                Ok(Scaled { scale, texture: None, channel: Channel::R })
            }
            "srgb" | "rgb" | "constant" => {
                let color = match node.color("color", quantity)? {
                    Some(color) => Some(color),
                    None => node.color("value", quantity)?,
                };
                let scale = color.ok_or_else(|| node.malformed("it has no value"))?;
                Ok(Scaled { scale, texture: None, channel: Channel::R })
            }
            other => {
                let message =
                    format!("textures of type {other:?} are not rendered: middle grey stands for them");
                self.warn(WarningKind::Texture, node, &message);
                Ok(Scaled { scale: Vec3::splat(0.5), texture: None, channel: Channel::R })
            }
        }
    }

    fn bitmap(&mut self, node: Node) -> Result<Scaled, ImportError> {
        let linear = node.boolean_or("raw", false)? || self.is_linear_by_gamma(node)?;
        let encoding = if linear { Encoding::Linear } else { Encoding::Srgb };
        self.image_texture(node, encoding)
    }

    /// A bitmap that holds normals.
    pub(super) fn normals(&mut self, node: Node) -> Result<Option<Texture>, ImportError> {
        if node.plugin() != "bitmap" {
            let message = "normal maps that are no bitmaps are not used";
            self.warn(WarningKind::Texture, node, message);
            return Ok(None);
        }
        node.disregard(&["raw", "gamma"]);
        Ok(self.image_texture(node, Encoding::Normal)?.texture)
    }

    fn image_texture(&mut self, node: Node, encoding: Encoding) -> Result<Scaled, ImportError> {
        node.disregard(&["format", "max_anisotropy", "cache"]);
        let name = node.filename()?;
        let image = self.images.file(&self.folder, &name, encoding, node.place(), self.warnings)?;
        let texture = match image {
            Some(image) => Some(Texture {
                image_from_uv: self.image_from_uv(node)?,
                wrap: self.wrap(node)?,
                filter: self.filter(node)?,
                ..Texture::new(image)
            }),
            None => None,
        };
        let channel = match node.text("channel")? {
            None | Some("r" | "x" | "y") => Channel::R,
            Some("g") => Channel::G,
            Some("b") => Channel::B,
            Some("a") => Channel::A,
            Some(other) => return Err(node.malformed(format!("there is no channel {other:?}"))),
        };
        Ok(Scaled { scale: Vec3::ONE, texture, channel })
    }

    /// Release 0.6: gamma 1 is linear, 0 or less or none is sRGB.
    fn is_linear_by_gamma(&mut self, node: Node) -> Result<bool, ImportError> {
        let gamma = node.float_or("gamma", 0.0)?;
        if gamma > 0.0 && gamma != 1.0 {
            let message = "images with a gamma of their own are taken as sRGB";
            self.warn(WarningKind::Approximation, node, message);
        }
        Ok(gamma == 1.0)
    }

    fn image_from_uv(&mut self, node: Node) -> Result<Mat3, ImportError> {
        let to_uv = transform::of_uv(node.transform("to_uv")?.unwrap_or(Mat4::IDENTITY));
        // Release 0.6: scaled, then moved.
        let pair = |x: &str, y: &str, default: f32| {
            Ok::<_, ImportError>(Vec2::new(node.float_or(x, default)?, node.float_or(y, default)?))
        };
        let scale = pair("uscale", "vscale", 1.0)?;
        let offset = pair("uoffset", "voffset", 0.0)?;
        Ok(Mat3::from_translation(offset) * Mat3::from_scale(scale) * to_uv)
    }

    fn wrap(&mut self, node: Node) -> Result<[Wrap; 2], ImportError> {
        let both = node.text("wrap_mode")?;
        let mut of = |name: &str| {
            Ok(match node.text(name)?.or(both).unwrap_or("repeat") {
                "repeat" => Wrap::Repeat,
                "mirror" => Wrap::Mirror,
                "clamp" => Wrap::Clamp,
                "zero" | "black" => Wrap::Black,
                "one" | "white" => {
                    let message = "textures that are white beyond their edges are clamped there";
                    self.warn(WarningKind::Approximation, node, message);
                    Wrap::Clamp
                }
                other => return Err(node.malformed(format!("there is no wrap mode {other:?}"))),
            })
        };
        Ok([of("wrap_mode_u")?, of("wrap_mode_v")?])
    }

    fn filter(&mut self, node: Node) -> Result<Filter, ImportError> {
        match node.text("filter_type")?.unwrap_or("bilinear") {
            "nearest" => Ok(Filter::Nearest),
            "bilinear" => Ok(Filter::Bilinear),
            "ewa" | "trilinear" => {
                let message = "textures filtered over their footprint are filtered bilinearly";
                self.warn(WarningKind::Approximation, node, message);
                Ok(Filter::Bilinear)
            }
            other => Err(node.malformed(format!("there is no filter {other:?}"))),
        }
    }

    /// Four texels: `color0` where u and v are in the same half.
    fn checkerboard(&mut self, node: Node, quantity: Quantity) -> Result<Scaled, ImportError> {
        let mut square = |name: &str, default: f32| {
            if node.child(name)?.is_some_and(|child| child.class() == Class::Texture) {
                node.disregard_textures()?;
                let message = "textures in the squares of a checkerboard are not used";
                self.warn(WarningKind::Texture, node, message);
                return Ok(Vec3::splat(default));
            }
            Ok::<_, ImportError>(node.color(name, quantity)?.unwrap_or(Vec3::splat(default)))
        };
        let [a, b] = [square("color0", 0.4)?, square("color1", 0.2)?].map(|c| c.extend(1.0).to_array());
        let image = self.images.ready(Image {
            name: node.id().to_owned(),
            width: 2,
            height: 2,
            texels: Texels::Float([a, b, b, a].into()),
        });
        let image_from_uv = self.image_from_uv(node)?;
        let texture = Texture { image_from_uv, filter: Filter::Nearest, ..Texture::new(image) };
        Ok(Scaled { scale: Vec3::ONE, texture: Some(texture), channel: Channel::R })
    }
}
