//! Material files: what their lines say.

use std::{collections::HashMap, path::Path};

use glam::Vec3;
use midway_scene::Material;

use super::{
    maps::{Map, Maps, Origin},
    text::{Line, joined, lines},
};
use crate::{
    ImportError,
    warning::{WarningKind, Warnings},
};

/// Materials, by name.
#[derive(Default)]
pub(super) struct Library(HashMap<String, Parameters>);

impl Library {
    /// The surface that a name stands for; none where the name is not known.
    pub fn material(&self, name: &str, maps: &mut Maps) -> Result<Option<Material>, ImportError> {
        self.0.get(name).map(|parameters| parameters.material(maps)).transpose()
    }

    /// Adds the materials of a file's text; one of a name that is known takes its place.
    pub fn read(
        &mut self,
        scene: &Path,
        origin: Origin,
        text: &str,
        warnings: &mut Warnings,
    ) -> Result<(), ImportError> {
        let (file, text) = (scene.with_file_name(origin.library), joined(text));
        let mut current: Option<Parameters> = None;
        for line in lines(&file, &text) {
            if line.keyword == "newmtl" {
                self.finish(current.take());
                let (name, place) = (line.rest.to_owned(), line.short_place());
                current = Some(Parameters { name, place, ..Parameters::default() });
            } else if let Some(parameters) = &mut current {
                parameters.line(&line, origin, warnings)?;
            } else {
                return Err(line.malformed("\"newmtl\" is expected before this"));
            }
        }
        self.finish(current);
        Ok(())
    }

    fn finish(&mut self, parameters: Option<Parameters>) {
        if let Some(parameters) = parameters {
            self.0.insert(parameters.name.clone(), parameters);
        }
    }
}

/// What a material's lines say.
#[derive(Default)]
pub(super) struct Parameters {
    pub name: String,
    pub place: String,
    pub diffuse: Option<Vec3>,
    pub specular: Option<Vec3>,
    pub emission: Option<Vec3>,
    pub filter: Option<Vec3>,
    pub exponent: Option<f32>,
    pub ior: Option<f32>,
    pub dissolve: Option<f32>,
    pub illum: Option<u32>,
    /// Of the extension for physically based rendering: Pr, Pm, Ps, Pc, Pcr, aniso, anisor.
    pub physical: HashMap<&'static str, f32>,
    /// By the keyword in small letters.
    pub maps: HashMap<&'static str, Map>,
}

const PHYSICAL: [&str; 7] = ["Pr", "Pm", "Ps", "Pc", "Pcr", "aniso", "anisor"];
/// Maps that are used.
const MAPS: [&str; 8] = ["map_kd", "map_ks", "map_ke", "map_d", "map_pr", "map_pm", "map_ps", "norm"];
const UNUSED_MAPS: [&str; 5] = ["bump", "disp", "decal", "refl", "displacement"];

impl Parameters {
    fn line(&mut self, line: &Line, origin: Origin, warnings: &mut Warnings) -> Result<(), ImportError> {
        match line.keyword {
            "Kd" => self.diffuse = colour(line, warnings)?,
            "Ks" => self.specular = colour(line, warnings)?,
            "Ke" => self.emission = colour(line, warnings)?,
            "Tf" => self.filter = colour(line, warnings)?,
            "Ns" => self.exponent = Some(line.finite()?[0]),
            "Ni" => self.ior = Some(line.finite()?[0]),
            // `d -halo 0.5` fades with the angle: its number is the last word.
            "d" => self.dissolve = line.words().next_back().and_then(|w| w.parse().ok()),
            "Tr" => self.dissolve = self.dissolve.or(Some(1.0 - line.finite()?[0])),
            "illum" => {
                // Some write `2.0`.
                let illum =
                    line.rest.parse::<f32>().ok().filter(|i| i.fract() == 0.0 && (0.0..1e6).contains(i));
                let illum = illum.ok_or_else(|| line.malformed("a whole number is expected"))?;
                self.illum = Some(illum as _);
            }
            // Ambient light is what a renderer computes.
            "Ka" | "map_Ka" => {}
            keyword => match PHYSICAL.iter().find(|name| **name == keyword) {
                Some(name) => {
                    self.physical.insert(name, line.finite()?[0]);
                }
                None => self.map(line, origin, warnings)?,
            },
        }
        Ok(())
    }

    fn map(&mut self, line: &Line, origin: Origin, warnings: &mut Warnings) -> Result<(), ImportError> {
        let keyword = line.keyword.to_ascii_lowercase();
        let keyword = if keyword == "map_kn" { "norm" } else { &keyword };
        match MAPS.iter().find(|name| **name == keyword) {
            Some(name) => {
                self.maps.insert(name, Map::parse(line, origin, warnings)?);
            }
            None => warn_of_unused(line, warnings),
        }
        Ok(())
    }

    pub fn warn(&self, kind: WarningKind, message: &str, warnings: &mut Warnings) {
        warnings.add(kind, self.place.clone(), message);
    }

    pub fn fraction(&self, value: Vec3, warnings: &mut Warnings) -> Vec3 {
        let clamped = value.clamp(Vec3::ZERO, Vec3::ONE);
        if clamped != value {
            self.warn(WarningKind::Repaired, "colours outside 0 to 1 are clamped", warnings);
        }
        clamped
    }
}

/// One number stands for all three; none for what is not RGB.
fn colour(line: &Line, warnings: &mut Warnings) -> Result<Option<Vec3>, ImportError> {
    if matches!(line.words().next(), Some("spectral" | "xyz")) {
        let message = "colours as spectra or CIE XYZ are not used";
        warnings.add(WarningKind::Unused, line.short_place(), message);
        return Ok(None);
    }
    match line.finite()?[..] {
        [grey] => Ok(Some(Vec3::splat(grey))),
        [r, g, b, ..] => Ok(Some(Vec3::new(r, g, b))),
        _ => Err(line.malformed("one number or three are expected")),
    }
}

fn warn_of_unused(line: &Line, warnings: &mut Warnings) {
    let keyword: String = line.keyword.chars().take(40).filter(|c| !c.is_control()).collect();
    let lower = keyword.to_ascii_lowercase();
    let texture = lower.starts_with("map_") || UNUSED_MAPS.contains(&lower.as_str());
    let (kind, what) =
        if texture { (WarningKind::Texture, "the texture ") } else { (WarningKind::Unused, "") };
    warnings.add(kind, line.short_place(), format!("{what}\"{keyword}\" is not used"));
}
