//! `KHR_materials_pbrSpecularGlossiness`, the older model, in terms of the newer one.

use glam::Vec3;
use midway_scene::MetallicRoughness;

use super::{F0, Reader};
use crate::{ImportError, gltf::json::Json, warning::WarningKind};

pub(super) const EXTENSION: &str = "KHR_materials_pbrSpecularGlossiness";

impl Reader<'_, '_> {
    /// A dielectric whose reflectance at normal incidence is the specular colour. The base colour
    /// is there already.
    pub(super) fn glossiness(
        &mut self,
        extension: &Json,
        model: &mut MetallicRoughness,
    ) -> Result<(), ImportError> {
        let message = "specular-glossiness is rendered as a dielectric of its specular colour";
        self.warnings.add(WarningKind::Approximation, extension.pointer(), message);
        let specular = Vec3::from_array(extension.floats_or("specularFactor", [1.0; 3])?);
        let specular = self.fraction(extension, specular) / F0;
        let texture = "specularGlossinessTexture";
        model.specular_color = self.textures.color(specular, extension, texture, self.warnings)?;
        let glossiness = extension.float_or("glossinessFactor", 1.0)?;
        model.roughness = (1.0 - self.fraction(extension, Vec3::splat(glossiness)).x).into();
        if extension.get(texture).is_some() {
            let message = "glossiness in textures is not used: the factor alone is";
            self.warnings.add(WarningKind::Texture, format!("{}/{texture}", extension.pointer()), message);
        }
        Ok(())
    }
}
