//! Material files: what each `illum` and its colours come to.

use std::{collections::HashMap, path::Path};

use glam::Vec3;
use midway_scene::{Material, Roughness, Surface};

use super::text::{Line, joined, lines};
use crate::{
    ImportError,
    warning::{WarningKind, Warnings},
};

/// Highlights sharper than this are nearer to a mirror than to nothing: a Phong exponent of 32 is
/// a roughness of about a quarter.
const MIRROR_EXPONENT: f32 = 32.0;

/// Materials, by name.
#[derive(Default)]
pub(super) struct Library(HashMap<String, Material>);

impl Library {
    pub fn get(&self, name: &str) -> Option<&Material> {
        self.0.get(name)
    }

    /// Adds a file's materials; one of a name that is known takes its place.
    pub fn read(&mut self, file: &Path, text: &str, warnings: &mut Warnings) -> Result<(), ImportError> {
        let text = joined(text);
        let mut current: Option<Parameters> = None;
        for line in lines(file, &text) {
            if line.keyword == "newmtl" {
                self.finish(current.take(), warnings);
                let (name, place) = (line.rest.to_owned(), line.short_place());
                current = Some(Parameters { name, place, ..Parameters::default() });
            } else if let Some(parameters) = &mut current {
                parameters.line(&line, warnings)?;
            } else {
                return Err(line.malformed("\"newmtl\" is expected before this"));
            }
        }
        self.finish(current, warnings);
        Ok(())
    }

    fn finish(&mut self, parameters: Option<Parameters>, warnings: &mut Warnings) {
        if let Some(parameters) = parameters {
            self.0.insert(parameters.name.clone(), parameters.material(warnings));
        }
    }
}

/// What a material's lines say.
#[derive(Default)]
struct Parameters {
    name: String,
    place: String,
    diffuse: Option<Vec3>,
    specular: Option<Vec3>,
    emission: Option<Vec3>,
    filter: Option<Vec3>,
    exponent: Option<f32>,
    ior: Option<f32>,
    dissolve: Option<f32>,
    illum: Option<u32>,
}

impl Parameters {
    fn line(&mut self, line: &Line, warnings: &mut Warnings) -> Result<(), ImportError> {
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
                let illum = line.rest.parse().map_err(|_| line.malformed("a whole number is expected"))?;
                self.illum = Some(illum);
            }
            // Ambient light is what a renderer computes.
            "Ka" => {}
            other => warn_of_unused(other, line, warnings),
        }
        Ok(())
    }

    fn material(self, warnings: &mut Warnings) -> Material {
        let surface = self.surface(warnings);
        // Sides are not in the format; the front is where the corners run counter-clockwise.
        let emission = self.emission.unwrap_or(Vec3::ZERO).max(Vec3::ZERO) + Vec3::ZERO;
        Material { name: self.name, ..Material::new(surface).emitting(emission) }
    }

    fn warn(&self, kind: WarningKind, message: &str, warnings: &mut Warnings) {
        warnings.add(kind, self.place.clone(), message);
    }

    fn surface(&self, warnings: &mut Warnings) -> Surface {
        let zero = Vec3::ZERO;
        let diffuse = self.fraction(self.diffuse.unwrap_or(zero), warnings);
        let specular = self.fraction(self.specular.unwrap_or(zero), warnings);
        if self.is_glass(warnings) {
            return self.glass(warnings);
        }
        // Models 0 and 1 have no specular term.
        let has_specular = specular.max_element() > 0.0 && self.illum.is_none_or(|i| i >= 2);
        let sharp = self.exponent.unwrap_or(0.0) >= MIRROR_EXPONENT;
        let outshines = sharp && specular.max_element() > diffuse.max_element();
        if has_specular && (matches!(self.illum, Some(3 | 5 | 8)) || outshines) {
            if diffuse.max_element() > 0.0 {
                let message = "materials that are a mirror before all are rendered without their Kd";
                self.warn(WarningKind::Approximation, message, warnings);
            }
            return Surface::mirror(specular);
        }
        if has_specular {
            let message = "the highlights of diffuse materials (Ks) are left out";
            self.warn(WarningKind::Approximation, message, warnings);
        }
        Surface::diffuse(diffuse)
    }

    /// By its illumination model, or because it is more clear than not and bends light.
    fn is_glass(&self, warnings: &mut Warnings) -> bool {
        if matches!(self.illum, Some(4 | 6 | 7 | 9)) {
            return true;
        }
        let dissolve = self.dissolve.unwrap_or(1.0);
        if dissolve >= 1.0 {
            return false;
        }
        let glass = dissolve <= 0.5 && self.ior.is_some_and(|n| n > 1.0);
        let message = if glass {
            "clear materials (d up to 0.5, with Ni) are rendered as glass"
        } else {
            "transparency (d or Tr) is not used: the surface is rendered as opaque"
        };
        self.warn(WarningKind::Alpha, message, warnings);
        glass
    }

    fn glass(&self, warnings: &mut Warnings) -> Surface {
        let ior = match self.ior {
            Some(ior) if ior > 0.0 => ior,
            _ => {
                let message = "glass without an index of refraction (Ni) above 0 has that of glass, 1.5";
                self.warn(WarningKind::Repaired, message, warnings);
                1.5
            }
        };
        let mut tint = self.fraction(self.filter.unwrap_or(Vec3::ONE), warnings);
        if tint == Vec3::ZERO {
            let message = "glass that lets nothing through (Tf 0 0 0) is taken as clear";
            self.warn(WarningKind::Repaired, message, warnings);
            tint = Vec3::ONE;
        }
        Surface::Dielectric {
            ior,
            reflection: Vec3::ONE.into(),
            transmission: tint.into(),
            sigma_a: Vec3::ZERO,
            thin: false,
            roughness: Roughness::smooth(),
        }
    }

    fn fraction(&self, value: Vec3, warnings: &mut Warnings) -> Vec3 {
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

fn warn_of_unused(keyword: &str, line: &Line, warnings: &mut Warnings) {
    let keyword: String = keyword.chars().take(40).filter(|c| !c.is_control()).collect();
    let texture =
        keyword.starts_with("map_") || matches!(&keyword[..], "bump" | "disp" | "decal" | "refl" | "norm");
    let (kind, what) =
        if texture { (WarningKind::Texture, "the texture ") } else { (WarningKind::Unused, "") };
    warnings.add(kind, line.short_place(), format!("{what}\"{keyword}\" is not used"));
}
