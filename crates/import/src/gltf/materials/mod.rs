//! Materials: metallic-roughness and its extensions, as the simplest surface that is the same.

mod glossiness;
mod surface;

use glam::{Vec3, Vec4};
use midway_scene::{Channel, Material, NormalMap, Opacity, ScalarInput, Sides, Surface};

use super::{json::Json, textures::Textures, warn_of_extensions};
use crate::{
    ImportError,
    images::Encoding,
    warning::{WarningKind, Warnings},
};

const UNLIT: &str = "KHR_materials_unlit";

/// Reflectance at normal incidence of a dielectric of index 1.5, which specular colours are relative to.
const F0: f32 = 0.04;

/// All materials, in the file's order.
pub(super) fn read_all(
    root: &Json,
    textures: &mut Textures,
    warnings: &mut Warnings,
) -> Result<Vec<Material>, ImportError> {
    let mut reader = Reader { textures, warnings };
    root.items("materials")?.iter().map(|definition| reader.material(definition)).collect()
}

/// That of primitives which name none: as an empty definition, a white metal as rough as can be.
pub(super) fn default_material() -> Material {
    Material::new(surface::plain())
}

struct Reader<'r, 'a> {
    textures: &'r mut Textures<'a>,
    warnings: &'r mut Warnings,
}

/// The colour of a surface by itself, with what says where it is.
struct Base<'a> {
    /// Linear RGBA.
    factor: Vec4,
    /// What holds the texture, and as which member.
    texture: Option<(Json<'a>, &'static str)>,
}

impl Reader<'_, '_> {
    fn material(&mut self, material: &Json) -> Result<Material, ImportError> {
        warn_of_extensions(material, self.warnings)?;
        if material.get("occlusionTexture").is_some() {
            let message = "occlusion textures are not used: what they stand for is computed";
            self.warnings.add(
                WarningKind::Unused,
                format!("{}/occlusionTexture", material.pointer()),
                message,
            );
        }
        let unlit = material.extension(UNLIT).is_some();
        let base = self.base(material)?;
        let mut emission = self.emission(material)?;
        let surface = if unlit {
            let message = "unlit surfaces emit their base colour as radiance, and reflect nothing";
            self.warnings.add(WarningKind::Approximation, material.pointer(), message);
            emission = self.base_color(&base)?;
            Surface::diffuse(Vec3::ZERO)
        } else {
            self.surface(material, &base)?
        };
        Ok(Material {
            name: material.name(),
            opacity: self.opacity(material, &base)?,
            normal_map: if unlit { None } else { self.normal_map(material, "normalTexture")? },
            emission,
            emits: if material.bool_or("doubleSided", false)? { Sides::Both } else { Sides::Front },
            ..Material::new(surface)
        })
    }

    fn base<'a>(&mut self, material: &Json<'a>) -> Result<Base<'a>, ImportError> {
        let (holder, factor, texture) = match material.extension(glossiness::EXTENSION) {
            Some(extension) => (Some(extension), "diffuseFactor", "diffuseTexture"),
            None => (material.get("pbrMetallicRoughness"), "baseColorFactor", "baseColorTexture"),
        };
        let Some(holder) = holder else {
            return Ok(Base { factor: Vec4::ONE, texture: None });
        };
        let factor = Vec4::from_array(holder.floats_or(factor, [1.0; 4])?);
        let rgb = self.fraction(&holder, factor.truncate());
        let alpha = self.fraction(&holder, Vec3::splat(factor.w)).x;
        Ok(Base { factor: rgb.extend(alpha), texture: Some((holder, texture)) })
    }

    fn base_color(&mut self, base: &Base) -> Result<midway_scene::ColorInput, ImportError> {
        let value = base.factor.truncate();
        match &base.texture {
            Some((holder, key)) => self.textures.color(value, holder, key, self.warnings),
            None => Ok(value.into()),
        }
    }

    /// Takes factors into the range that they have by the format.
    fn fraction(&mut self, at: &Json, value: Vec3) -> Vec3 {
        let clamped = value.clamp(Vec3::ZERO, Vec3::ONE);
        if clamped != value {
            self.warnings.add(WarningKind::Repaired, at.pointer(), "factors outside 0 to 1 are clamped");
        }
        clamped
    }

    /// A number in 0 to 1, times a channel of a texture.
    fn scalar(
        &mut self,
        holder: &Json,
        (factor, default): (&str, f32),
        texture: (&str, Channel),
    ) -> Result<ScalarInput, ImportError> {
        let value = holder.float_or(factor, default)?;
        let value = self.fraction(holder, Vec3::splat(value)).x;
        if value == 0.0 {
            // A texture would be decoded for nothing.
            return Ok(value.into());
        }
        self.textures.scalar(value, holder, texture, self.warnings)
    }

    fn emission(&mut self, material: &Json) -> Result<midway_scene::ColorInput, ImportError> {
        let factor = Vec3::from_array(material.floats_or("emissiveFactor", [0.0; 3])?);
        let extension = material.extension("KHR_materials_emissive_strength");
        let strength = extension.map_or(Ok(1.0), |e| e.float_or("emissiveStrength", 1.0))?;
        let emission = factor * strength;
        if !emission.is_finite() {
            return Err(material.malformed("its emission is not a finite number"));
        }
        if emission.min_element() < 0.0 {
            self.warnings.add(WarningKind::Repaired, material.pointer(), "negative emission is taken as 0");
        }
        let emission = emission.max(Vec3::ZERO) + Vec3::ZERO;
        if emission == Vec3::ZERO {
            // A texture would be decoded for nothing.
            return Ok(emission.into());
        }
        self.textures.color(emission, material, "emissiveTexture", self.warnings)
    }

    fn normal_map(&mut self, holder: &Json, key: &str) -> Result<Option<NormalMap>, ImportError> {
        let texture = self.textures.texture(holder, key, Encoding::Normal, self.warnings)?;
        let scale = holder.get(key).map_or(Ok(1.0), |info| info.float_or("scale", 1.0))?;
        Ok(texture.map(|texture| NormalMap { texture, scale }))
    }

    fn opacity(&mut self, material: &Json, base: &Base) -> Result<Opacity, ImportError> {
        let Some(mode) = material.get("alphaMode") else {
            return Ok(Opacity::Opaque);
        };
        let mode_name = mode.string()?;
        if mode_name == "OPAQUE" {
            return Ok(Opacity::Opaque);
        }
        let mut alpha = ScalarInput::from(base.factor.w);
        if let Some((holder, key)) = &base.texture {
            // The same texels as the colour's.
            let texture = self.textures.texture(holder, key, Encoding::Srgb, self.warnings)?;
            alpha.texture = texture.map(|t| (t, Channel::A));
        }
        match mode_name {
            "MASK" => Ok(Opacity::Mask(alpha, material.float_or("alphaCutoff", 0.5)?)),
            "BLEND" => Ok(Opacity::Blend(alpha)),
            _ => Err(mode.malformed("an alpha mode is OPAQUE, MASK or BLEND")),
        }
    }
}
