//! What a material's lines come to: the nearest surface for each `illum` and its colours.

use std::f32::consts::TAU;

use glam::Vec3;
use midway_scene::{
    Channel, ConductorFresnel, Material, MetallicRoughness, NormalMap, Opacity, Roughness, Surface,
};

use super::{maps::Maps, mtl::Parameters};
use crate::{ImportError, images::Encoding, warning::WarningKind};

/// Highlights sharper than this and brighter than what is diffuse make a metal: a Phong exponent
/// of 32 is a roughness of about a quarter.
const METAL_EXPONENT: f32 = 32.0;
const GLASS_IOR: f32 = 1.5;

/// Of a linear colour of Rec. 709.
fn luminance(colour: Vec3) -> f32 {
    colour.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

impl Parameters {
    pub(super) fn material(&self, maps: &mut Maps) -> Result<Material, ImportError> {
        let glass = self.is_glass(maps);
        let surface = if glass { self.glass(maps) } else { self.surface(maps)? };
        // Sides are not in the format; the front is where the corners run counter-clockwise.
        let emission = self.or_white(self.emission, "map_ke").max(Vec3::ZERO) + Vec3::ZERO;
        let material = Material::new(surface);
        Ok(Material {
            name: self.name.clone(),
            emission: maps.color(emission, self.maps.get("map_ke"))?,
            opacity: if glass { Opacity::Opaque } else { self.opacity(maps)? },
            normal_map: self.normal_map(maps)?,
            ..material
        })
    }

    /// A colour; where there is a map and no colour, white; else black.
    fn or_white(&self, colour: Option<Vec3>, map: &str) -> Vec3 {
        let absent = if self.maps.contains_key(map) { Vec3::ONE } else { Vec3::ZERO };
        colour.unwrap_or(absent)
    }

    fn normal_map(&self, maps: &mut Maps) -> Result<Option<NormalMap>, ImportError> {
        let Some(map) = self.maps.get("norm") else {
            return Ok(None);
        };
        let texture = maps.texture(map, Encoding::Normal)?;
        Ok(texture.map(|texture| NormalMap { texture, scale: map.strength }))
    }

    fn opacity(&self, maps: &mut Maps) -> Result<Opacity, ImportError> {
        let dissolve = self.dissolve.filter(|d| d.is_finite()).unwrap_or(1.0).clamp(0.0, 1.0);
        let map = self.maps.get("map_d");
        if dissolve >= 1.0 && map.is_none() {
            return Ok(Opacity::Opaque);
        }
        // A picture of what is there, or the alpha of the one of its colours.
        let shared = map.zip(self.maps.get("map_kd")).is_some_and(|(d, kd)| d.file == kd.file);
        let channel = if shared { Channel::A } else { Channel::R };
        Ok(Opacity::Blend(maps.scalar(dissolve, map, channel)?))
    }

    fn surface(&self, maps: &mut Maps) -> Result<Surface, ImportError> {
        let is_physical = !self.physical.is_empty()
            || ["map_pr", "map_pm", "map_ps"].iter().any(|m| self.maps.contains_key(m));
        if is_physical {
            return self.physical(maps);
        }
        let diffuse = self.fraction(self.or_white(self.diffuse, "map_kd"), maps.warnings);
        let specular = self.fraction(self.or_white(self.specular, "map_ks"), maps.warnings);
        // Models 0 and 1 have no specular term.
        let has_specular = specular.max_element() > 0.0 && self.illum.is_none_or(|i| i >= 2);
        if !has_specular {
            return Ok(Surface::Diffuse { reflectance: maps.color(diffuse, self.maps.get("map_kd"))? });
        }
        // Exporters write these models for what is far from a mirror.
        let mirror_model = matches!(self.illum, Some(3 | 5 | 8));
        let mirror = mirror_model && luminance(specular) > luminance(diffuse);
        if mirror_model && !mirror {
            let message = "mirrors by their illum whose Kd outshines Ks are rendered as of illum 2";
            self.warn(WarningKind::Approximation, message, maps.warnings);
        }
        let sharp = self.exponent.unwrap_or(0.0) >= METAL_EXPONENT;
        let outshines = sharp && specular.max_element() > diffuse.max_element();
        if mirror || outshines || diffuse == Vec3::ZERO {
            if diffuse != Vec3::ZERO {
                let message = "materials that are a mirror before all are rendered without their Kd";
                self.warn(WarningKind::Approximation, message, maps.warnings);
            }
            let f0 = maps.color(specular, self.maps.get("map_ks"))?;
            let roughness = if mirror { Roughness::smooth() } else { self.roughness() };
            return Ok(Surface::Conductor { fresnel: ConductorFresnel::Schlick { f0 }, roughness });
        }
        let message = "highlights (Ks, Ns) are rendered as those of a coat of index Ni, or 1.5, times Ks";
        self.warn(WarningKind::Approximation, message, maps.warnings);
        Ok(Surface::Plastic {
            reflectance: maps.color(diffuse, self.maps.get("map_kd"))?,
            specular: maps.color(specular, self.maps.get("map_ks"))?,
            ior: self.ior.filter(|n| *n > 1.0).unwrap_or(GLASS_IOR),
            nonlinear: false,
            roughness: self.roughness(),
        })
    }

    /// GGX's α of a Blinn-Phong exponent: √(2 / (Ns + 2)) (Walter et al. 2007, section 5.2).
    fn roughness(&self) -> Roughness {
        let exponent = self.exponent.unwrap_or(0.0).max(0.0);
        Roughness::alpha((2.0 / (exponent + 2.0)).sqrt())
    }

    /// The extension of Pixar's and Blender's exporters.
    fn physical(&self, maps: &mut Maps) -> Result<Surface, ImportError> {
        let number = |name: &str, map: &str| {
            let absent = if self.maps.contains_key(map) { 1.0 } else { 0.0 };
            self.physical.get(name).copied().unwrap_or(absent)
        };
        let [metallic, roughness, sheen, coat, coat_roughness, anisotropy] = [
            number("Pm", "map_pm"),
            self.physical.get("Pr").copied().unwrap_or(1.0),
            number("Ps", "map_ps"),
            number("Pc", ""),
            number("Pcr", ""),
            number("aniso", ""),
        ]
        .map(|x| self.fraction(Vec3::splat(x), maps.warnings).x);
        let diffuse = self.fraction(self.or_white(self.diffuse, "map_kd"), maps.warnings);
        Ok(Surface::MetallicRoughness(Box::new(MetallicRoughness {
            base_color: maps.color(diffuse, self.maps.get("map_kd"))?,
            metallic: maps.scalar(metallic, self.maps.get("map_pm"), Channel::R)?,
            roughness: maps.scalar(roughness, self.maps.get("map_pr"), Channel::R)?,
            ior: self.ior.filter(|n| *n > 1.0).unwrap_or(GLASS_IOR),
            clearcoat: coat.into(),
            clearcoat_roughness: coat_roughness.into(),
            sheen_color: maps.color(Vec3::splat(sheen), self.maps.get("map_ps"))?,
            // The extension has none: that of cloth.
            sheen_roughness: if sheen > 0.0 { 0.3 } else { 0.0 }.into(),
            anisotropy: anisotropy.into(),
            // A part of a turn.
            anisotropy_rotation: number("anisor", "") * TAU,
            ..MetallicRoughness::default()
        })))
    }

    /// By its illumination model, or because it is more clear than not and bends light. What a map
    /// cuts out is no glass, whatever its exporter says.
    fn is_glass(&self, maps: &mut Maps) -> bool {
        if self.maps.contains_key("map_d") {
            return false;
        }
        let dissolve = self.dissolve.unwrap_or(1.0);
        if matches!(self.illum, Some(4 | 6 | 7 | 9)) {
            let diffuse = self.or_white(self.diffuse, "map_kd");
            // Filters of 0 and 1 are written for what is opaque, too.
            let filters = self.filter.is_some_and(|f| f != Vec3::ZERO && f != Vec3::ONE);
            let glass = dissolve < 1.0 || filters || diffuse == Vec3::ZERO;
            if !glass {
                let message = "glass by its illum that has a Kd and lets nothing through (d, Tf) is rendered as of illum 2";
                self.warn(WarningKind::Approximation, message, maps.warnings);
            } else if diffuse != Vec3::ZERO {
                let message = "glass by its illum is rendered clear, without its Kd";
                self.warn(WarningKind::Approximation, message, maps.warnings);
            }
            return glass;
        }
        let glass = dissolve <= 0.5 && self.ior.is_some_and(|n| n > 1.0);
        if glass {
            let message = "clear materials (d up to 0.5, with Ni) are rendered as glass";
            self.warn(WarningKind::Alpha, message, maps.warnings);
        }
        glass
    }

    fn glass(&self, maps: &mut Maps) -> Surface {
        let ior = match self.ior {
            Some(ior) if ior > 0.0 => ior,
            _ => {
                let message = "glass without an index of refraction (Ni) above 0 has that of glass, 1.5";
                self.warn(WarningKind::Repaired, message, maps.warnings);
                GLASS_IOR
            }
        };
        let mut tint = self.fraction(self.filter.unwrap_or(Vec3::ONE), maps.warnings);
        if tint == Vec3::ZERO {
            let message = "glass that lets nothing through (Tf 0 0 0) is taken as clear";
            self.warn(WarningKind::Repaired, message, maps.warnings);
            tint = Vec3::ONE;
        }
        Surface::Dielectric {
            ior,
            dispersion: 0.0,
            reflection: Vec3::ONE.into(),
            transmission: tint.into(),
            sigma_a: Vec3::ZERO,
            thin: false,
            roughness: Roughness::smooth(),
        }
    }
}
