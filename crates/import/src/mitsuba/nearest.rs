//! BSDFs without a counterpart: the nearest, and what is said of it.

use glam::Vec3;
use midway_scene::{ColorInput, Material, MetallicRoughness, Opacity, Roughness, ScalarInput, Surface};

use super::{Loader, bsdf::relative_ior, document::Class, indices, node::Node, value::Quantity};
use crate::{ImportError, warning::WarningKind};

type Result<T> = std::result::Result<T, ImportError>;

/// Reflectance at normal incidence of a dielectric of index 1.5.
const F0: f32 = 0.04;

impl Loader<'_> {
    /// A surface near to that of a plugin that has no counterpart.
    pub(super) fn nearest(&mut self, node: Node) -> Result<Surface> {
        match node.plugin() {
            "principled" | "principledthin" => self.principled(node),
            "phong" => {
                let exponent = node.float_or("exponent", 30.0)?.max(0.0);
                let message = "Phong's BRDF is rendered as metallic-roughness of the same exponent";
                self.warn(WarningKind::Approximation, node, message);
                self.glossy(node, (2.0 / (exponent + 2.0)).sqrt())
            }
            "ward" => {
                let message = "Ward's BRDF is rendered as metallic-roughness";
                self.warn(WarningKind::Approximation, node, message);
                node.disregard(&["variant"]);
                let (u, v) = (node.float_or("alpha_u", 0.1)?, node.float_or("alpha_v", 0.1)?);
                self.glossy(node, (u.max(0.0) * v.max(0.0)).sqrt())
            }
            "roughdiffuse" => {
                let message = "rough diffuse surfaces are rendered as diffuse";
                self.warn(WarningKind::Approximation, node, message);
                node.disregard(&["alpha", "use_fast_approx"]);
                Ok(Surface::Diffuse { reflectance: self.color(node, "reflectance", Quantity::Share, 0.5)? })
            }
            "difftrans" => {
                let message = "diffuse transmission is rendered as diffuse reflection on both sides";
                self.warn(WarningKind::Approximation, node, message);
                Ok(Surface::Diffuse { reflectance: self.color(node, "transmittance", Quantity::Share, 0.5)? })
            }
            other => {
                let message = format!("BSDFs of type {other:?} are rendered as diffuse grey");
                self.warn(WarningKind::Approximation, node, &message);
                Ok(Surface::diffuse(Vec3::splat(0.5)))
            }
        }
    }

    /// A diffuse base with a coloured lobe on it, of the same reflectance at normal incidence.
    fn glossy(&mut self, node: Node, alpha: f32) -> Result<Surface> {
        let specular = self.color(node, "specular_reflectance", Quantity::Share, 0.2)?;
        let specular_color = ColorInput { value: specular.value / F0, texture: specular.texture };
        Ok(Surface::MetallicRoughness(Box::new(MetallicRoughness {
            base_color: self.color(node, "diffuse_reflectance", Quantity::Share, 0.5)?,
            roughness: alpha.min(1.0).sqrt().into(),
            specular_color,
            ..MetallicRoughness::default()
        })))
    }

    /// Disney's model. Its roughness is perceptual, as glTF's; its coat has a quarter of the strength.
    fn principled(&mut self, node: Node) -> Result<Surface> {
        let message = "principled BSDFs are rendered as metallic-roughness";
        self.warn(WarningKind::Approximation, node, message);
        node.disregard(&[
            "main_specular_sampling_rate",
            "clearcoat_sampling_rate",
            "diffuse_reflectance_sampling_rate",
            "spec_tint",
            "flatness",
            "diff_trans",
        ]);
        let base_color = self.color(node, "base_color", Quantity::Share, 0.5)?;
        let sheen = self.scalar(node, "sheen", 0.0)?.value;
        let tint = self.scalar(node, "sheen_tint", 0.0)?.value;
        let gloss = self.scalar(node, "clearcoat_gloss", 0.0)?.value;
        let mut clearcoat = self.scalar(node, "clearcoat", 0.0)?;
        clearcoat.value *= 0.25;
        Ok(Surface::MetallicRoughness(Box::new(MetallicRoughness {
            metallic: self.scalar(node, "metallic", 0.0)?,
            roughness: self.scalar(node, "roughness", 0.5)?,
            ior: principled_ior(node)?,
            transmission: self.scalar(node, "spec_trans", 0.0)?,
            thin: node.plugin() == "principledthin",
            clearcoat,
            clearcoat_roughness: (0.1 + (0.001 - 0.1) * gloss).sqrt().into(),
            sheen_color: (Vec3::ONE.lerp(base_color.value, tint) * sheen).into(),
            sheen_roughness: ScalarInput::from(0.5),
            anisotropy: self.scalar(node, "anisotropic", 0.0)?,
            base_color,
            ..MetallicRoughness::default()
        })))
    }

    /// Of two, the one with the greater weight; where the other one is nothing, a share of it.
    pub(super) fn mixture(&mut self, node: Node, depth: usize) -> Result<Material> {
        let parts = node.all(Class::Bsdf)?;
        if let ("blendbsdf", &[first, second]) = (node.plugin(), &parts[..]) {
            let weight = self.scalar(node, "weight", 0.5)?;
            let is_nothing = |part: Node| part.plugin() == "null";
            if is_nothing(first) && !is_nothing(second) {
                return self.in_part(second, weight, depth);
            }
            if is_nothing(second) && weight.texture.is_none() {
                return self.in_part(first, (1.0 - weight.value).into(), depth);
            }
            self.warn_of_mixture(node);
            return self.bsdf(if weight.value > 0.5 { second } else { first }, depth + 1);
        }
        let weights = node.text("weights")?.and_then(super::value::numbers).unwrap_or_default();
        let weight = |i: usize| weights.get(i).copied().unwrap_or(0.0);
        let most = (0..parts.len()).reduce(|a, b| if weight(b) > weight(a) { b } else { a });
        let most = most.ok_or_else(|| node.malformed("it mixes nothing"))?;
        self.warn_of_mixture(node);
        self.bsdf(parts[most], depth + 1)
    }

    fn warn_of_mixture(&mut self, node: Node) {
        let message = "of mixed BSDFs the one with the greatest weight is rendered";
        self.warn(WarningKind::Approximation, node, message);
    }

    fn in_part(&mut self, node: Node, share: ScalarInput, depth: usize) -> Result<Material> {
        let mut material = self.bsdf(node, depth + 1)?;
        if material.opacity == Opacity::Opaque {
            material.opacity = Opacity::Blend(share);
        }
        Ok(material)
    }

    /// A coat on a diffuse surface is plastic; on others it is left out.
    pub(super) fn coating(&mut self, node: Node, depth: usize) -> Result<Material> {
        let mut material = self.nested(node, depth)?;
        let roughness = match node.plugin() {
            "roughcoating" => self.roughness(node)?,
            _ => Roughness::smooth(),
        };
        let specular = self.color(node, "specular_reflectance", Quantity::Share, 1.0)?;
        let ior = relative_ior(node, indices::GLASS)?;
        node.disregard(&["thickness"]);
        match material.surface {
            Surface::Diffuse { reflectance } => {
                let message = "coats on diffuse surfaces are rendered as plastic, clear all through";
                self.warn(WarningKind::Approximation, node, message);
                material.surface =
                    Surface::Plastic { reflectance, specular, ior, nonlinear: true, roughness };
            }
            _ => self.warn(WarningKind::Approximation, node, "coats on what is not diffuse are left out"),
        }
        Ok(material)
    }
}

/// By `eta`, or the index that has the reflectance 0.08 `specular` at normal incidence.
fn principled_ior(node: Node) -> Result<f32> {
    if let Some(eta) = node.float("eta")? {
        return if eta > 0.0 { Ok(eta) } else { Err(node.malformed("\"eta\" has to be above 0")) };
    }
    let specular = node.float_or("specular", 0.5)?.clamp(0.0, 1.0);
    Ok(2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0)
}
