//! BSDFs without a counterpart: the nearest, and what is said of it.

use glam::Vec3;
use midway_scene::{ColorInput, Material, MetallicRoughness, Opacity, Roughness, ScalarInput, Surface};

use super::{Loader, bsdf::relative_ior, document::Class, indices, node::Node, value::Quantity};
use crate::{
    ImportError, disney,
    mixture::{self, Mixture},
    warning::WarningKind,
};

type Result<T> = std::result::Result<T, ImportError>;

/// What weights lack that stand for all, as files write thirds.
const WEIGHT_ROUNDING: f32 = 0.01;
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
        let sheen = self.scalar(node, "sheen", 0.0)?;
        let tint = self.scalar(node, "sheen_tint", 0.0)?;
        let gloss = self.scalar(node, "clearcoat_gloss", 0.0)?;
        let sheen = disney::sheen(&mut self.images, &base_color, &tint, &sheen);
        if !sheen.is_whole {
            self.warn(WarningKind::Texture, node, disney::SHEEN_IN_PART);
        }
        let mut clearcoat = self.scalar(node, "clearcoat", 0.0)?;
        clearcoat.value *= 0.25;
        Ok(Surface::MetallicRoughness(Box::new(MetallicRoughness {
            metallic: self.scalar(node, "metallic", 0.0)?,
            roughness: self.scalar(node, "roughness", 0.5)?,
            ior: principled_ior(node)?,
            transmission: self.scalar(node, "spec_trans", 0.0)?,
            thin: node.plugin() == "principledthin",
            clearcoat,
            clearcoat_roughness: disney::coat_roughness(&mut self.images, &gloss),
            sheen_color: sheen.color,
            sheen_roughness: ScalarInput::from(0.5),
            anisotropy: self.scalar(node, "anisotropic", 0.0)?,
            base_color,
            ..MetallicRoughness::default()
        })))
    }

    /// Of two or more, their mixture where it is a material; where one of two is nothing, a share of the other.
    pub(super) fn mixture(&mut self, node: Node, depth: usize) -> Result<Material> {
        // Each once: mixtures of mixtures that refer to one twice would double with each level.
        if let Some(known) = self.mixtures.get(&node.index) {
            return Ok(known.clone());
        }
        let material = self.new_mixture(node, depth)?;
        self.mixtures.insert(node.index, material.clone());
        Ok(material)
    }

    fn new_mixture(&mut self, node: Node, depth: usize) -> Result<Material> {
        let parts = node.all(Class::Bsdf)?;
        if let ("blendbsdf", &[first, second]) = (node.plugin(), &parts[..]) {
            let weight = self.scalar(node, "weight", 0.5)?;
            let is_nothing = |part: Node| part.plugin() == "null";
            if is_nothing(first) && !is_nothing(second) {
                return self.in_part(second, weight, depth);
            }
            if is_nothing(second) {
                let of_second = [weight.clone().into()];
                if let Some(rest) = self.images.computed_scalar(&of_second, |values| Vec3::ONE - values[0]) {
                    return self.in_part(first, rest, depth);
                }
            }
            let parts = [self.bsdf(first, depth + 1)?, self.bsdf(second, depth + 1)?];
            let heaviest = usize::from(weight.value > 0.5);
            return Ok(self.mixed(node, &parts, &[1.0.into(), weight], heaviest));
        }
        let weights = node.text("weights")?.and_then(super::value::numbers).unwrap_or_default();
        let (mut materials, mut shares, mut sum, mut heaviest) = (Vec::new(), Vec::new(), 0.0, (0.0, 0));
        for (&part, weight) in parts.iter().zip(weights).filter(|(_, weight)| *weight > 0.0) {
            sum += weight;
            if weight > heaviest.0 {
                heaviest = (weight, materials.len());
            }
            materials.push(self.bsdf(part, depth + 1)?);
            // Of all until here.
            shares.push(ScalarInput::from(weight / sum));
        }
        let Some(&first) = parts.first() else {
            return Err(node.malformed("it mixes nothing"));
        };
        if materials.is_empty() {
            return self.bsdf(first, depth + 1);
        }
        let mut material = self.mixed(node, &materials, &shares, heaviest.1);
        if (sum - 1.0).abs() > WEIGHT_ROUNDING {
            self.weigh(node, &mut material, sum);
        }
        Ok(material)
    }

    /// Multiplies what a mixture scatters by the sum of its weights.
    fn weigh(&mut self, node: Node, material: &mut Material, sum: f32) {
        match &mut material.surface {
            Surface::Diffuse { reflectance } => {
                reflectance.value *= sum;
                if reflectance.texture.is_none() {
                    reflectance.value = reflectance.value.min(Vec3::ONE);
                }
            }
            _ => {
                let message = "weights of mixed BSDFs that do not add up to 1 are taken as shares";
                self.warn(WarningKind::Approximation, node, message);
            }
        }
    }

    /// Each part with its share among those until it, as one; or that which there is most of.
    fn mixed(&mut self, node: Node, parts: &[Material], shares: &[ScalarInput], heaviest: usize) -> Material {
        let mut whole = Some(Mixture { material: parts[0].clone(), is_exact: true });
        for (part, share) in parts.iter().zip(shares).skip(1) {
            whole = whole.and_then(|known| {
                let share = share.clone().into();
                let mixture = mixture::mixed(&mut self.images, [&known.material, part], &share)?;
                Some(Mixture { is_exact: mixture.is_exact && known.is_exact, ..mixture })
            });
        }
        let message = match &whole {
            Some(Mixture { is_exact: true, .. }) => None,
            Some(_) => Some("of mixed BSDFs of one type one is rendered whose parameters are mixed"),
            None => Some("of mixed BSDFs the one with the greatest weight is rendered"),
        };
        message.into_iter().for_each(|message| self.warn(WarningKind::Approximation, node, message));
        let material = whole.map_or_else(|| parts[heaviest].clone(), |mixture| mixture.material);
        Material { name: node.id().to_owned(), ..material }
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
