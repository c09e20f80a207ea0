//! How a material scatters.

use glam::Vec3;
use midway_scene::{
    Channel, CoatNormal, ColorInput, ConductorFresnel, MAX_DISPERSION, MetallicRoughness, Roughness,
    ScalarInput, Surface,
};

use super::{Base, F0, Reader, glossiness};
use crate::{ImportError, gltf::json::Json, images::Encoding, warning::WarningKind};

/// The least attenuation colour: a channel that is black at some distance absorbs this much.
const LEAST_ATTENUATION: f32 = 1e-7;

impl Reader<'_, '_> {
    pub(super) fn surface(&mut self, material: &Json, base: &Base) -> Result<Surface, ImportError> {
        let mut model =
            MetallicRoughness { base_color: self.base_color(base)?, ..MetallicRoughness::default() };
        if let Some(extension) = material.extension(glossiness::EXTENSION) {
            self.glossiness(&extension, &mut model)?;
            return Ok(Surface::MetallicRoughness(Box::new(model)));
        }
        model.metallic = 1.0.into();
        if let Some(pbr) = material.get("pbrMetallicRoughness") {
            let texture = "metallicRoughnessTexture";
            model.metallic = self.scalar(&pbr, ("metallicFactor", 1.0), (texture, Channel::B))?;
            model.roughness = self.scalar(&pbr, ("roughnessFactor", 1.0), (texture, Channel::G))?;
        }
        self.specular(material, &mut model)?;
        self.transmission(material, &mut model)?;
        self.ior(material, &mut model)?;
        self.dispersion(material, &mut model)?;
        self.coat(material, &mut model)?;
        self.sheen(material, &mut model)?;
        self.anisotropy(material, &mut model)?;
        Ok(simplest(model))
    }

    fn specular(&mut self, material: &Json, model: &mut MetallicRoughness) -> Result<(), ImportError> {
        let Some(specular) = material.extension("KHR_materials_specular") else {
            return Ok(());
        };
        model.specular = self.scalar(&specular, ("specularFactor", 1.0), ("specularTexture", Channel::A))?;
        let colour = Vec3::from_array(specular.floats_or("specularColorFactor", [1.0; 3])?);
        if colour.min_element() < 0.0 {
            self.warnings.add(
                WarningKind::Repaired,
                specular.pointer(),
                "negative specular colours are taken as 0",
            );
        }
        let colour = colour.max(Vec3::ZERO) + Vec3::ZERO;
        model.specular_color =
            self.textures.color(colour, &specular, "specularColorTexture", self.warnings)?;
        Ok(())
    }

    /// 0 stands for an index beyond all bounds: all light is reflected that `KHR_materials_specular` lets.
    fn ior(&mut self, material: &Json, model: &mut MetallicRoughness) -> Result<(), ImportError> {
        let Some(extension) = material.extension("KHR_materials_ior") else {
            return Ok(());
        };
        let ior = extension.float_or("ior", model.ior)?;
        if ior > 0.0 {
            model.ior = ior;
        } else if ior < 0.0 {
            let message = "indices of refraction below 0 are taken as 1.5";
            self.warnings.add(WarningKind::Repaired, extension.pointer(), message);
        } else {
            // By the default index it is the colour that reflects it.
            model.specular_color.value /= F0;
            if model.transmission.value > 0.0 {
                let message = "what transmits by an index of refraction of 0 bends light as by 1.5";
                self.warnings.add(WarningKind::Approximation, extension.pointer(), message);
            }
        }
        Ok(())
    }

    fn transmission(&mut self, material: &Json, model: &mut MetallicRoughness) -> Result<(), ImportError> {
        let Some(transmission) = material.extension("KHR_materials_transmission") else {
            return Ok(());
        };
        let texture = ("transmissionTexture", Channel::R);
        model.transmission = self.scalar(&transmission, ("transmissionFactor", 0.0), texture)?;
        let Some(volume) = material.extension("KHR_materials_volume") else {
            return Ok(());
        };
        if volume.get("thicknessTexture").is_some() {
            let message = "thickness textures are not used: light travels through what is modelled";
            self.warnings.add(WarningKind::Texture, volume.pointer(), message);
        }
        model.thin = volume.float_or("thicknessFactor", 0.0)? <= 0.0;
        if !model.thin && model.transmission.value > 0.0 {
            model.sigma_a = self.absorption(&volume)?;
        }
        Ok(())
    }

    /// Of what has an inside: a thin wall bends no colour.
    fn dispersion(&mut self, material: &Json, model: &mut MetallicRoughness) -> Result<(), ImportError> {
        let Some(extension) = material.extension("KHR_materials_dispersion") else {
            return Ok(());
        };
        let dispersion = extension.float_or("dispersion", 0.0)?;
        let bounded = dispersion.clamp(0.0, MAX_DISPERSION);
        if bounded != dispersion {
            let message = format!("dispersion is taken as within 0 to {MAX_DISPERSION}");
            self.warnings.add(WarningKind::Repaired, extension.pointer(), message);
        }
        if !model.thin && model.transmission.value > 0.0 {
            model.dispersion = bounded;
        }
        Ok(())
    }

    /// σ_a = -ln(attenuationColor) / attenuationDistance (KHR_materials_volume).
    fn absorption(&mut self, volume: &Json) -> Result<Vec3, ImportError> {
        let colour = Vec3::from_array(volume.floats_or("attenuationColor", [1.0; 3])?);
        let colour = self.fraction(volume, colour);
        let Some(distance) = volume.get("attenuationDistance") else {
            return Ok(Vec3::ZERO);
        };
        let metres = distance.float()?;
        if metres <= 0.0 {
            return Err(distance.malformed("a distance above 0 is expected here"));
        }
        let sigma_a = -colour.max(Vec3::splat(LEAST_ATTENUATION)).map(f32::ln) / metres;
        // -ln(1) is -0.
        let sigma_a = sigma_a.max(Vec3::ZERO) + Vec3::ZERO;
        if sigma_a.is_finite() {
            return Ok(sigma_a);
        }
        Err(distance.malformed("the distance is too small for its absorption to be a number"))
    }

    fn coat(&mut self, material: &Json, model: &mut MetallicRoughness) -> Result<(), ImportError> {
        let Some(coat) = material.extension("KHR_materials_clearcoat") else {
            return Ok(());
        };
        model.clearcoat = self.scalar(&coat, ("clearcoatFactor", 0.0), ("clearcoatTexture", Channel::R))?;
        let texture = ("clearcoatRoughnessTexture", Channel::G);
        model.clearcoat_roughness = self.scalar(&coat, ("clearcoatRoughnessFactor", 0.0), texture)?;
        if model.clearcoat.value > 0.0 {
            let map = self.normal_map(&coat, "clearcoatNormalTexture")?;
            model.clearcoat_normal = map.map_or(CoatNormal::Mesh, CoatNormal::Map);
        }
        Ok(())
    }

    fn sheen(&mut self, material: &Json, model: &mut MetallicRoughness) -> Result<(), ImportError> {
        let Some(sheen) = material.extension("KHR_materials_sheen") else {
            return Ok(());
        };
        let colour = Vec3::from_array(sheen.floats_or("sheenColorFactor", [0.0; 3])?);
        let colour = self.fraction(&sheen, colour);
        if colour == Vec3::ZERO {
            return Ok(());
        }
        model.sheen_color = self.textures.color(colour, &sheen, "sheenColorTexture", self.warnings)?;
        let texture = ("sheenRoughnessTexture", Channel::A);
        model.sheen_roughness = self.scalar(&sheen, ("sheenRoughnessFactor", 0.0), texture)?;
        Ok(())
    }

    fn anisotropy(&mut self, material: &Json, model: &mut MetallicRoughness) -> Result<(), ImportError> {
        let Some(anisotropy) = material.extension("KHR_materials_anisotropy") else {
            return Ok(());
        };
        let texture = ("anisotropyTexture", Channel::B);
        model.anisotropy = self.scalar(&anisotropy, ("anisotropyStrength", 0.0), texture)?;
        model.anisotropy_rotation = anisotropy.float_or("anisotropyRotation", 0.0)?;
        if model.anisotropy.value > 0.0 {
            let (key, encoding) = ("anisotropyTexture", Encoding::Linear);
            model.anisotropy_direction = self.textures.texture(&anisotropy, key, encoding, self.warnings)?;
        }
        Ok(())
    }
}

/// That of a material of which nothing is said.
pub(super) fn plain() -> Surface {
    simplest(MetallicRoughness { metallic: 1.0.into(), ..MetallicRoughness::default() })
}

/// Whether a factor is a value everywhere.
fn is(input: &ScalarInput, value: f32) -> bool {
    input.value == value && (input.texture.is_none() || value == 0.0)
}

fn is_color(input: &ColorInput, value: Vec3) -> bool {
    input.value == value && (input.texture.is_none() || value == Vec3::ZERO)
}

/// The surface with the fewest parts that scatters as the model does.
fn simplest(model: MetallicRoughness) -> Surface {
    let bare = is(&model.clearcoat, 0.0) && is_color(&model.sheen_color, Vec3::ZERO);
    let round = is(&model.anisotropy, 0.0);
    let opaque = is(&model.transmission, 0.0);
    if bare && opaque && is(&model.metallic, 0.0) && is(&model.specular, 0.0) {
        return Surface::Diffuse { reflectance: model.base_color };
    }
    let roughness = Roughness {
        along: model.roughness.clone(),
        across: model.roughness.clone(),
        squared: true,
        single_bounce: false,
    };
    if bare && round && is(&model.metallic, 1.0) {
        return Surface::Conductor { fresnel: ConductorFresnel::Schlick { f0: model.base_color }, roughness };
    }
    let clear = is(&model.transmission, 1.0) && is(&model.metallic, 0.0);
    let plain = is(&model.specular, 1.0) && is_color(&model.specular_color, Vec3::ONE);
    if bare && round && clear && plain {
        return Surface::Dielectric {
            ior: model.ior,
            dispersion: model.dispersion,
            reflection: Vec3::ONE.into(),
            transmission: model.base_color,
            sigma_a: model.sigma_a,
            thin: model.thin,
            roughness,
        };
    }
    Surface::MetallicRoughness(Box::new(model))
}
