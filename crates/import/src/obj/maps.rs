//! Texture statements: a file and how it lies.

use std::path::Path;

use glam::{Mat3, Vec2, Vec3};
use midway_scene::{Channel, ColorInput, ScalarInput, Texture, Wrap};

use super::text::Line;
use crate::{
    ImportError, Place,
    files::SceneFolder,
    images::{Encoding, Images},
    warning::{WarningKind, Warnings},
};

/// What a `map_` line says.
#[derive(Clone)]
pub(super) struct Map {
    /// From the scene's folder.
    pub file: String,
    place: Place,
    offset: Vec2,
    scale: Vec2,
    clamp: bool,
    /// `-bm`: what a normal map's slopes are multiplied by.
    pub strength: f32,
    pub channel: Option<Channel>,
}

/// Where maps are turned into textures.
pub(super) struct Maps<'m> {
    pub folder: &'m SceneFolder,
    pub images: &'m mut Images,
    pub warnings: &'m mut Warnings,
}

/// A material file: its maps' names are relative to it.
#[derive(Clone, Copy)]
pub(super) struct Origin<'o> {
    /// Its name, from the scene's folder.
    pub library: &'o str,
    pub folder: &'o SceneFolder,
}

impl Map {
    /// Options, then a file name that may hold spaces.
    pub fn parse(line: &Line, origin: Origin, warnings: &mut Warnings) -> Result<Self, ImportError> {
        let mut map = Self {
            file: String::new(),
            place: line.place(),
            offset: Vec2::ZERO,
            scale: Vec2::ONE,
            clamp: false,
            strength: 1.0,
            channel: None,
        };
        let mut rest = line.rest;
        while rest.starts_with('-') {
            let (option, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
            rest = map.option(option, after.trim_start(), line, warnings)?;
        }
        if rest.is_empty() {
            return Err(line.malformed("a file's name is expected"));
        }
        map.file = origin.beside(rest);
        Ok(map)
    }

    /// Reads an option's values, and returns what follows.
    fn option<'t>(
        &mut self,
        option: &str,
        rest: &'t str,
        line: &Line,
        warnings: &mut Warnings,
    ) -> Result<&'t str, ImportError> {
        let word = |text: &'t str| {
            let (word, after) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
            (word, after.trim_start())
        };
        // One to three numbers, as many as there are.
        let vector = |default: f32| {
            let (mut v, mut rest) = (Vec3::splat(default), rest);
            for i in 0..3 {
                let (first, after) = word(rest);
                let Some(x) = first.parse::<f32>().ok().filter(|x| x.is_finite()) else { break };
                v[i] = x;
                rest = after;
            }
            (v.truncate(), rest)
        };
        let (first, after) = word(rest);
        let number = || {
            let number = first.parse::<f32>().ok().filter(|x| x.is_finite());
            number.ok_or_else(|| line.malformed(format!("a number is expected after {option}")))
        };
        let after = match option {
            "-o" => {
                let (offset, after) = vector(0.0);
                self.offset = offset;
                return Ok(after);
            }
            "-s" => {
                let (scale, after) = vector(1.0);
                self.scale = scale;
                return Ok(after);
            }
            "-clamp" => {
                self.clamp = first == "on";
                return Ok(after);
            }
            "-bm" => {
                self.strength = number()?;
                return Ok(after);
            }
            "-imfchan" => {
                self.channel = match first {
                    "r" => Some(Channel::R),
                    "g" => Some(Channel::G),
                    "b" => Some(Channel::B),
                    "m" => Some(Channel::A),
                    _ => None,
                };
                return Ok(after);
            }
            "-t" => vector(0.0).1,
            "-mm" => word(after).1,
            "-blendu" | "-blendv" | "-boost" | "-texres" | "-type" | "-cc" | "-colorspace" => after,
            _ => return Err(line.malformed("an option that textures do not have")),
        };
        warnings.add(
            WarningKind::Texture,
            line.short_place(),
            format!("textures' option {option} is not used"),
        );
        Ok(after)
    }
}

impl Origin<'_> {
    /// The path of a file that is named in the material file.
    fn beside(&self, name: &str) -> String {
        let name = name.trim().trim_matches('"').replace('\\', "/");
        let name = match name.strip_prefix("//") {
            Some(on_network) => on_network.rsplit('/').next().unwrap_or_default(),
            None => reachable(&name, self.folder),
        };
        let library = self.library.replace('\\', "/");
        let folder = Path::new(&library).parent().unwrap_or(Path::new(""));
        folder.join(name).to_string_lossy().into_owned()
    }
}

/// A file's name, by slashes alone. Exporters write their author's folders: of an absolute path, of
/// whatever system, only the name counts, unless the file is there and may be read.
pub(super) fn reachable<'n>(name: &'n str, folder: &SceneFolder) -> &'n str {
    let is_on_network = name.starts_with("//");
    let is_absolute = name.starts_with('/') || name.as_bytes().get(1) == Some(&b':');
    if is_absolute && !is_on_network && !folder.holds(name) {
        return name.rsplit('/').next().unwrap_or_default();
    }
    name
}

impl Maps<'_> {
    /// The texture of a map; none where its file is missing.
    pub fn texture(&mut self, map: &Map, encoding: Encoding) -> Result<Option<Texture>, ImportError> {
        let image = self.images.file(self.folder, &map.file, encoding, &map.place, self.warnings)?;
        // v grows upwards in the file and downwards in the mesh.
        let offset = Vec2::new(map.offset.x, 1.0 - map.scale.y - map.offset.y);
        let image_from_uv = Mat3::from_translation(offset) * Mat3::from_scale(map.scale);
        let wrap = if map.clamp { Wrap::Clamp } else { Wrap::Repeat };
        Ok(image.map(|image| Texture { image_from_uv, wrap: [wrap; 2], ..Texture::new(image) }))
    }

    /// A colour, times a map.
    pub fn color(&mut self, value: Vec3, map: Option<&Map>) -> Result<ColorInput, ImportError> {
        let texture = match map {
            Some(map) => self.texture(map, Encoding::Srgb)?,
            None => None,
        };
        Ok(ColorInput { value, texture })
    }

    /// A number, times a channel of a map: the one that it names, or else `channel`.
    pub fn scalar(
        &mut self,
        value: f32,
        map: Option<&Map>,
        channel: Channel,
    ) -> Result<ScalarInput, ImportError> {
        let texture = match map {
            Some(map) => self.texture(map, Encoding::Linear)?.map(|t| (t, map.channel.unwrap_or(channel))),
            None => None,
        };
        Ok(ScalarInput { value, texture })
    }
}
