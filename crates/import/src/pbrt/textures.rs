//! `Texture` directives: images where there are images, values where they fold, else the nearest.
//!
//! Images lie on surfaces with v upwards in pbrt and downwards in the scene.

use std::collections::HashMap;

use glam::{Mat3, Vec3};
use midway_scene::{Channel, ColorInput, Filter, Image, ScalarInput, Texels, Texture, Wrap};

use super::{
    colours::{Reader, Use},
    lex::shortened,
    params::Params,
};
use crate::{
    ImportError,
    images::{CUT_TO_ONE, Encoding, Images, LEAST_CUT},
    warning::{WarningKind, Warnings},
};

/// A float texture.
#[derive(Clone)]
pub(super) struct Scalar {
    pub input: ScalarInput,
    /// What `input` refers to, for functions of it.
    image: Option<Image>,
}

/// Named textures, and the images that they and others need.
#[derive(Default)]
pub(super) struct Textures {
    pub images: Images,
    colours: HashMap<String, ColorInput>,
    scalars: HashMap<String, Scalar>,
    baked: HashMap<Baking, (u32, Image)>,
}

/// What makes a texture's image of a file's: where all is the same it is made once.
#[derive(PartialEq, Eq, Hash)]
struct Baking {
    file: String,
    encoding: Encoding,
    /// The bits of the factor.
    scale: u32,
    invert: bool,
    is_scalar: bool,
}

impl From<f32> for Scalar {
    fn from(value: f32) -> Self {
        Self { input: value.into(), image: None }
    }
}

impl Textures {
    /// Reads a definition.
    pub fn define(
        &mut self,
        [name, kind, class]: [&str; 3],
        params: &Params,
        reader: &Reader,
        warnings: &mut Warnings,
    ) -> Result<(), ImportError> {
        let mut definition = Definition { textures: self, params, reader, warnings };
        match kind {
            "float" => {
                let scalar = definition.scalar(class)?;
                self.scalars.insert(name.to_owned(), scalar);
            }
            "spectrum" | "color" => {
                let colour = definition.colour(class)?;
                self.colours.insert(name.to_owned(), colour);
            }
            other => {
                let problem =
                    format!("a texture is \"float\" or \"spectrum\", and not \"{}\"", shortened(other));
                return Err(params.malformed(problem));
            }
        }
        params.warn_of_unused(&format!("textures \"{class}\""), warnings);
        Ok(())
    }

    /// A parameter that is a spectrum or names a texture, within 0 and 1.
    pub fn albedo(
        &mut self,
        params: &Params,
        name: &str,
        default: f32,
        reader: &Reader,
        warnings: &mut Warnings,
    ) -> Result<ColorInput, ImportError> {
        let input = self.factor(params, name, default, reader, warnings)?;
        if let Some(texture) = &input.texture {
            self.images.scaled(texture.image, input.value.extend(0.0).to_array(), &params.place);
            return Ok(input);
        }
        if input.value.max_element() > LEAST_CUT {
            warnings.add(WarningKind::Repaired, params.place.short(), CUT_TO_ONE);
        }
        Ok(input.value.min(Vec3::ONE).into())
    }

    /// The same, which may be greater than 1 before it is multiplied.
    fn factor(
        &self,
        params: &Params,
        name: &str,
        default: f32,
        reader: &Reader,
        warnings: &mut Warnings,
    ) -> Result<ColorInput, ImportError> {
        let Some(texture) = params.texture(name)? else {
            return Ok(reader.colour_or(params, name, Use::Albedo, Vec3::splat(default))?.into());
        };
        if let Some(known) = self.colours.get(texture) {
            return Ok(known.clone());
        }
        missing(params, texture, warnings);
        Ok(Vec3::splat(default).into())
    }

    /// A parameter that is a number or names a float texture; none where it is missing.
    pub fn scalar(
        &mut self,
        params: &Params,
        name: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<Scalar>, ImportError> {
        let Some(texture) = params.texture(name)? else {
            return Ok(params.float(name)?.map(Scalar::from));
        };
        let known = self.scalars.get(texture).cloned();
        if known.is_none() {
            missing(params, texture, warnings);
        }
        Ok(known)
    }

    /// A function of a float texture that is not linear, the result in [0, 1].
    pub fn map(&mut self, scalar: &Scalar, f: impl Fn(f32) -> f32) -> ScalarInput {
        let f = |x: f32| f(x).clamp(0.0, 1.0);
        let (Some(image), Some((texture, channel))) = (&scalar.image, &scalar.input.texture) else {
            return f(scalar.input.value).into();
        };
        let value = scalar.input.value;
        let mapped = transformed(&mut self.images, image, |[x, _, _, a]| {
            let y = f(value * if *channel == Channel::A { a } else { x });
            [y, y, y, 1.0]
        });
        let texture = Texture { image: self.images.ready(mapped), ..texture.clone() };
        ScalarInput { value: 1.0, texture: Some((texture, Channel::R)) }
    }

    /// An image file on the whole of a surface's (u, v).
    pub fn plain(
        &mut self,
        file: &str,
        encoding: Encoding,
        params: &Params,
        reader: &Reader,
        warnings: &mut Warnings,
    ) -> Result<Option<Texture>, ImportError> {
        let image = self.images.file(reader.folder, file, encoding, &params.place, warnings)?;
        Ok(image.map(|image| Texture { image_from_uv: flipped([1.0, 1.0, 0.0, 0.0]), ..Texture::new(image) }))
    }
}

fn missing(params: &Params, texture: &str, warnings: &mut Warnings) {
    let message =
        format!("the texture \"{}\" is not defined: the default takes its place", shortened(texture));
    warnings.add(WarningKind::Texture, params.place.short(), message);
}

/// Image from (u, v) by pbrt's scales and offsets, v turned over.
fn flipped([su, sv, du, dv]: [f32; 4]) -> Mat3 {
    Mat3::from_cols_array(&[su, 0.0, 0.0, 0.0, -sv, 0.0, du, 1.0 - dv, 1.0])
}

/// A function of each texel, cut off at 0 and 1, in 16 bits; of the middle one where there is no room for all.
fn transformed(images: &mut Images, image: &Image, f: impl Fn([f32; 4]) -> [f32; 4]) -> Image {
    let word = |x: f32| (x.clamp(0.0, 1.0) * 65535.0).round() as u16;
    if !images.has_room(image.texels.len() as u64) {
        let middle = (image.height / 2) as usize * image.width as usize + (image.width / 2) as usize;
        let texels = Texels::Linear16([f(image.texels.linear(middle)).map(word)].into());
        return Image { name: image.name.clone(), width: 1, height: 1, texels };
    }
    let texels = (0..image.texels.len()).map(|i| f(image.texels.linear(i)).map(word)).collect();
    Image { texels: Texels::Linear16(texels), ..image.clone() }
}

/// A texture being defined.
struct Definition<'a> {
    textures: &'a mut Textures,
    params: &'a Params,
    reader: &'a Reader<'a>,
    warnings: &'a mut Warnings,
}

impl Definition<'_> {
    fn approximated(&mut self, message: impl Into<String>) {
        self.warnings.add(WarningKind::Approximation, self.params.place.short(), message);
    }

    fn input(&mut self, name: &str, default: f32) -> Result<ColorInput, ImportError> {
        self.textures.factor(self.params, name, default, self.reader, self.warnings)
    }

    fn number(&mut self, name: &str, default: f32) -> Result<Scalar, ImportError> {
        Ok(self.textures.scalar(self.params, name, self.warnings)?.unwrap_or(default.into()))
    }

    fn colour(&mut self, class: &str) -> Result<ColorInput, ImportError> {
        match class {
            "constant" => self.input("value", 1.0),
            "imagemap" => self.colour_image(),
            "checkerboard" => {
                let tex = [self.input("tex1", 1.0)?, self.input("tex2", 0.0)?];
                let [a, b] = tex.map(|t| self.flat(t));
                let texture = self.checkerboard(a, b)?;
                Ok(ColorInput { value: Vec3::ONE, texture: Some(texture) })
            }
            "scale" => {
                let (a, b) = if self.params.has("tex1") {
                    (self.input("tex1", 1.0)?, self.input("tex2", 1.0)?)
                } else {
                    let scale = self.number("scale", 1.0)?.input;
                    let texture = scale.texture.map(|(texture, _)| texture);
                    (self.input("tex", 1.0)?, ColorInput { value: Vec3::splat(scale.value), texture })
                };
                Ok(self.product(a, b))
            }
            "mix" | "directionmix" => {
                let (a, b) = (self.input("tex1", 0.0)?, self.input("tex2", 1.0)?);
                let amount = self.amount(class)?;
                Ok(self.blend(a, b, amount))
            }
            "bilerp" => {
                let mut mean = Vec3::ZERO;
                for corner in ["v00", "v01", "v10", "v11"] {
                    mean += self.reader.colour_or(self.params, corner, Use::Albedo, Vec3::ZERO)? / 4.0;
                }
                self.approximated("textures \"bilerp\" are rendered as their mean");
                Ok(mean.into())
            }
            "dots" => {
                self.approximated("textures \"dots\" are rendered without the dots");
                self.input("outside", 1.0)
            }
            other => {
                self.stand_in(other);
                Ok(Vec3::splat(0.5).into())
            }
        }
    }

    fn scalar(&mut self, class: &str) -> Result<Scalar, ImportError> {
        match class {
            "constant" => Ok(self.params.float_or("value", 1.0)?.into()),
            "imagemap" => self.scalar_image(),
            "checkerboard" => {
                let (a, b) = (self.number("tex1", 1.0)?.input.value, self.number("tex2", 0.0)?.input.value);
                let texture = self.checkerboard(Vec3::splat(a), Vec3::splat(b))?;
                let image = checker_image(Vec3::splat(a), Vec3::splat(b));
                let input = ScalarInput { value: 1.0, texture: Some((texture, Channel::R)) };
                Ok(Scalar { input, image: Some(image) })
            }
            "scale" => {
                let names = if self.params.has("tex1") { ["tex1", "tex2"] } else { ["tex", "scale"] };
                let (mut a, b) = (self.number(names[0], 1.0)?, self.number(names[1], 1.0)?);
                let value = a.input.value * b.input.value;
                if a.input.texture.is_none() {
                    a = b;
                } else if b.input.texture.is_some() {
                    self.approximated("products of two images are rendered as the first");
                }
                a.input.value = value;
                Ok(a)
            }
            "mix" | "directionmix" => {
                let (a, b) = (self.number("tex1", 0.0)?, self.number("tex2", 1.0)?);
                let amount = self.amount(class)?;
                let amount = if amount.texture.is_some() {
                    self.approximated("mixtures of numbers by an image are rendered as half and half");
                    0.5
                } else {
                    amount.value
                };
                if a.image.is_none() && b.image.is_none() {
                    return Ok((a.input.value + (b.input.value - a.input.value) * amount).into());
                }
                self.approximated("mixtures of images are rendered as the one there is more of");
                Ok(if amount < 0.5 { a } else { b })
            }
            other => {
                self.stand_in(other);
                Ok(0.5.into())
            }
        }
    }

    fn stand_in(&mut self, class: &str) {
        self.params.ignore(&[
            "octaves",
            "roughness",
            "scale",
            "variation",
            "mapping",
            "value",
            "tex1",
            "tex2",
            "inside",
            "filename",
            "encoding",
            "v00",
            "v01",
            "v10",
            "v11",
        ]);
        let message = format!("textures \"{}\" are rendered as a grey of 0.5", shortened(class));
        self.warnings.add(WarningKind::Texture, self.params.place.short(), message);
    }

    /// How much of the second there is in a mixture.
    fn amount(&mut self, class: &str) -> Result<ScalarInput, ImportError> {
        if class == "directionmix" {
            self.params.ignore(&["dir"]);
            self.approximated("mixtures by direction are rendered as the same from all");
            return Ok(0.5.into());
        }
        if self.params.texture("amount")?.is_some() {
            return Ok(self.number("amount", 0.5)?.input);
        }
        let grey = self.reader.colour_or(self.params, "amount", Use::Albedo, Vec3::splat(0.5))?;
        Ok(grey.y.clamp(0.0, 1.0).into())
    }

    fn blend(&mut self, a: ColorInput, b: ColorInput, amount: ScalarInput) -> ColorInput {
        // Images are of values within 0 and 1: what is more multiplies them.
        let most = a.value.max_element().max(b.value.max_element()).max(1.0);
        let within = |input: &ColorInput| ColorInput { value: input.value / most, ..input.clone() };
        let inputs = [within(&a).into(), within(&b).into(), amount.clone().into()];
        let lerp = |values: &[Vec3]| values[0] + (values[1] - values[0]) * values[2].min(Vec3::ONE);
        if let Some(blended) = self.textures.images.computed(&inputs, lerp) {
            return ColorInput { value: blended.value * most, ..blended };
        }
        self.approximated(
            "mixtures of images that lie in different ways are rendered as the one there is more of",
        );
        if amount.value < 0.5 { a } else { b }
    }

    fn product(&mut self, a: ColorInput, b: ColorInput) -> ColorInput {
        let value = (a.value * b.value).max(Vec3::ZERO);
        let (Some(first), Some(second)) = (&a.texture, &b.texture) else {
            return ColorInput { value, texture: a.texture.or(b.texture) };
        };
        let inputs = [first, second]
            .map(|texture| ColorInput { value: Vec3::ONE, texture: Some(texture.clone()) }.into());
        if let Some(texture) = self.textures.images.computed(&inputs, |values| values[0] * values[1]) {
            return ColorInput { value, ..texture };
        }
        self.approximated("products of images that lie in different ways are rendered as the first");
        ColorInput { value, texture: a.texture }
    }

    fn flat(&mut self, input: ColorInput) -> Vec3 {
        if input.texture.is_some() {
            self.approximated("images within a checkerboard are rendered as white");
        }
        input.value
    }

    fn checkerboard(&mut self, a: Vec3, b: Vec3) -> Result<Texture, ImportError> {
        if self.params.float_or("dimension", 2.0)? != 2.0 {
            self.approximated("checkerboards of three dimensions are rendered by (u, v)");
        }
        self.params.ignore(&["aamode"]);
        let [su, sv, du, dv] = self.mapping()?;
        let image = self.textures.images.ready(checker_image(a, b));
        let image_from_uv = Mat3::from_cols_array(&[su, 0.0, 0.0, 0.0, sv, 0.0, du, dv, 2.0]) * 0.5;
        Ok(Texture { image_from_uv, filter: Filter::Nearest, ..Texture::new(image) })
    }

    /// Scales and offsets of (u, v).
    fn mapping(&mut self) -> Result<[f32; 4], ImportError> {
        if self.params.string("mapping")?.unwrap_or("uv") != "uv" {
            self.params.ignore(&["v1", "v2"]);
            self.approximated("textures mapped by a sphere, a cylinder or a plane are mapped by (u, v)");
        }
        let mut numbers = [1.0, 1.0, 0.0, 0.0];
        for (number, name) in numbers.iter_mut().zip(["uscale", "vscale", "udelta", "vdelta"]) {
            *number = self.params.float_or(name, *number)?;
        }
        Ok(numbers)
    }

    fn wrap(&mut self) -> Result<Wrap, ImportError> {
        Ok(match self.params.string("wrap")?.unwrap_or("repeat") {
            "repeat" => Wrap::Repeat,
            "clamp" => Wrap::Clamp,
            "black" => Wrap::Black,
            _ => {
                self.approximated("images wrapped otherwise than repeat, clamp or black are repeated");
                Wrap::Repeat
            }
        })
    }

    fn filter(&mut self) -> Result<Filter, ImportError> {
        self.params.ignore(&["maxanisotropy", "trilinear"]);
        Ok(match self.params.string("filter")? {
            Some("point") => Filter::Nearest,
            _ => Filter::Bilinear,
        })
    }

    fn encoding(&mut self) -> Result<Encoding, ImportError> {
        if !self.params.bool_or("gamma", true)? {
            return Ok(Encoding::Linear);
        }
        Ok(match self.params.string("encoding")?.unwrap_or("sRGB") {
            "linear" => Encoding::Linear,
            encoding => {
                if encoding != "sRGB" {
                    self.approximated("images of another gamma are read as sRGB");
                }
                Encoding::Srgb
            }
        })
    }

    /// What an image file is laid on a surface by, but for the image.
    fn layout(&mut self) -> Result<Texture, ImportError> {
        let wrap = self.wrap()?;
        let image_from_uv = flipped(self.mapping()?);
        Ok(Texture { image: 0, uv_set: 0, image_from_uv, wrap: [wrap; 2], filter: self.filter()? })
    }

    fn file(&self) -> Result<&str, ImportError> {
        let file = self.params.string("filename")?;
        file.ok_or_else(|| self.params.malformed("an \"imagemap\" needs a \"filename\""))
    }

    fn colour_image(&mut self) -> Result<ColorInput, ImportError> {
        let (layout, encoding) = (self.layout()?, self.encoding()?);
        let scale = self.params.float_or("scale", 1.0)?;
        let invert = self.params.bool_or("invert", false)?;
        let place = &self.params.place;
        let file = self.file()?.to_owned();
        if !invert && scale >= 0.0 {
            let image =
                self.textures.images.file(self.reader.folder, &file, encoding, place, self.warnings)?;
            let texture = image.map(|image| Texture { image, ..layout });
            return Ok(ColorInput { value: Vec3::splat(scale), texture });
        }
        let baking = Baking { file, encoding, scale: scale.to_bits(), invert, is_scalar: false };
        let bake = |(): &(), [r, g, b, a]: [f32; 4]| {
            let rgb = Vec3::new(r, g, b) * scale;
            let rgb = if invert { Vec3::ONE - rgb } else { rgb };
            rgb.clamp(Vec3::ZERO, Vec3::ONE).extend(a).to_array()
        };
        let Some((image, _)) = self.baked(baking, |_| (), bake)? else {
            return Ok(Vec3::ONE.into());
        };
        Ok(ColorInput { value: Vec3::ONE, texture: Some(Texture { image, ..layout }) })
    }

    /// pbrt takes the alpha channel of an image that has one other than 1, else the mean of the
    /// colours.
    fn scalar_image(&mut self) -> Result<Scalar, ImportError> {
        let (layout, encoding) = (self.layout()?, self.encoding()?);
        let scale = self.params.float_or("scale", 1.0)?;
        let invert = self.params.bool_or("invert", false)?;
        let file = self.file()?.to_owned();
        // Factors up to 1 are part of the texels: of floats above 1 more is left.
        let is_factor = !invert && scale > 1.0;
        let (value, scale) = if is_factor { (scale, 1.0) } else { (1.0, scale) };
        let baking = Baking { file, encoding, scale: scale.to_bits(), invert, is_scalar: true };
        let has_alpha = |image: &Image| (0..image.texels.len()).any(|i| image.texels.linear(i)[3] < 1.0);
        let bake = |has_alpha: &bool, [r, g, b, a]: [f32; 4]| {
            let x = scale * if *has_alpha { a } else { (r + g + b) / 3.0 };
            let x = if invert { 1.0 - x } else { x }.max(0.0);
            [x, x, x, 1.0]
        };
        let Some((index, baked)) = self.baked(baking, has_alpha, bake)? else {
            return Ok(1.0.into());
        };
        let texture = Texture { image: index, ..layout };
        Ok(Scalar { input: ScalarInput { value, texture: Some((texture, Channel::R)) }, image: Some(baked) })
    }

    /// A function of each texel of a file and of what is known of all, and its index.
    fn baked<T>(
        &mut self,
        baking: Baking,
        of_all: impl Fn(&Image) -> T,
        f: impl Fn(&T, [f32; 4]) -> [f32; 4],
    ) -> Result<Option<(u32, Image)>, ImportError> {
        if let Some(known) = self.textures.baked.get(&baking) {
            return Ok(Some(known.clone()));
        }
        let Some(image) = self.read_now(&baking.file, baking.encoding)? else { return Ok(None) };
        let all = of_all(&image);
        let images = &mut self.textures.images;
        let baked = transformed(images, &image, |texel| f(&all, texel));
        let made = (images.ready(baked.clone()), baked);
        self.textures.baked.insert(baking, made.clone());
        Ok(Some(made))
    }

    /// None, and a warning, where there is no such image or it is damaged.
    fn read_now(&mut self, file: &str, encoding: Encoding) -> Result<Option<Image>, ImportError> {
        match self.textures.images.read_now(self.reader.folder, file, encoding, &self.params.place) {
            Ok(image) => Ok(Some(image)),
            Err(
                error @ (ImportError::MissingBuffer { .. }
                | ImportError::Malformed { .. }
                | ImportError::Unreadable { .. }),
            ) => {
                let message = format!("the image \"{}\" cannot be read and is left out", shortened(file));
                let kind = match error {
                    ImportError::MissingBuffer { .. } => WarningKind::MissingFile,
                    _ => WarningKind::Texture,
                };
                self.warnings.add(kind, self.params.place.short(), message);
                Ok(None)
            }
            Err(other) => Err(other),
        }
    }
}

fn checker_image(a: Vec3, b: Vec3) -> Image {
    let [a, b] = [a, b].map(|c| c.extend(1.0).to_array());
    Image { name: "checkerboard".to_owned(), width: 2, height: 2, texels: Texels::Float([a, b, b, a].into()) }
}
