//! BSDFs that have a counterpart, and what stands around them: sides, opacity, normal maps.

use glam::Vec3;
use midway_scene::{ConductorFresnel, Material, NormalMap, Opacity, Roughness, ScalarInput, Sides, Surface};

use super::{Loader, MAX_DEPTH, document::Class, indices, node::Node, value::Quantity, value::Value};
use crate::{ImportError, warning::WarningKind};

type Result<T> = std::result::Result<T, ImportError>;

impl Loader<'_> {
    /// What a BSDF comes to, emission left out. Opaque ones scatter from their front alone unless
    /// they are in a `twosided`.
    pub(super) fn bsdf(&mut self, node: Node, depth: usize) -> Result<Material> {
        if depth > MAX_DEPTH {
            return Err(node.malformed("BSDFs refer to each other without end"));
        }
        let surface = match node.plugin() {
            "diffuse" | "lambertian" => self.diffuse(node)?,
            "dielectric" => self.dielectric(node, false, Roughness::smooth())?,
            "thindielectric" => self.dielectric(node, true, Roughness::smooth())?,
            "roughdielectric" | "roughglass" => {
                let roughness = self.roughness(node)?;
                self.dielectric(node, false, roughness)?
            }
            "conductor" | "mirror" => self.conductor(node, Roughness::smooth())?,
            "roughconductor" | "roughmetal" => {
                let roughness = self.roughness(node)?;
                self.conductor(node, roughness)?
            }
            "plastic" => self.plastic(node, Roughness::smooth())?,
            "roughplastic" => {
                let roughness = self.roughness(node)?;
                self.plastic(node, roughness)?
            }
            "null" | "transparent" => Surface::Null,
            "twosided" => {
                let mut material = self.nested(node, depth)?;
                if node.all(Class::Bsdf)?.len() > 1 {
                    let message = "surfaces that differ by side have the first BSDF on both";
                    self.warn(WarningKind::Approximation, node, message);
                }
                material.scatters = Sides::Both;
                return Ok(material);
            }
            "mask" => return self.mask(node, depth),
            "normalmap" => return self.normal_map(node, depth),
            "bumpmap" | "bump" => {
                self.warn(WarningKind::Texture, node, "bump maps are not used");
                node.disregard_textures()?;
                return self.nested(node, depth);
            }
            "blendbsdf" | "mixturebsdf" => return self.mixture(node, depth),
            "coating" | "roughcoating" => return self.coating(node, depth),
            _ => self.nearest(node)?,
        };
        let both = surface.has_inside()
            || matches!(surface, Surface::Null | Surface::Dielectric { .. })
            || node.plugin() == "principledthin"
            || node.plugin() == "difftrans";
        let scatters = if both { Sides::Both } else { Sides::Front };
        Ok(Material { name: node.id().to_owned(), scatters, ..Material::new(surface) })
    }

    /// What the first BSDF in another comes to.
    pub(super) fn nested(&mut self, node: Node, depth: usize) -> Result<Material> {
        let inner = node.first(Class::Bsdf)?;
        let inner = inner.ok_or_else(|| node.malformed(format!("a {} holds no BSDF", node.plugin())))?;
        let mut material = self.bsdf(inner, depth + 1)?;
        if !node.id().is_empty() {
            material.name = node.id().to_owned();
        }
        Ok(material)
    }

    fn diffuse(&mut self, node: Node) -> Result<Surface> {
        // Release 0.2 has it under another name.
        let name = if node.has("diffuse_reflectance") { "diffuse_reflectance" } else { "reflectance" };
        Ok(Surface::Diffuse { reflectance: self.color(node, name, Quantity::Share, 0.5)? })
    }

    fn dielectric(&mut self, node: Node, thin: bool, roughness: Roughness) -> Result<Surface> {
        Ok(Surface::Dielectric {
            ior: relative_ior(node, indices::GLASS)?,
            dispersion: 0.0,
            reflection: self.color(node, "specular_reflectance", Quantity::Share, 1.0)?,
            transmission: self.color(node, "specular_transmittance", Quantity::Share, 1.0)?,
            sigma_a: Vec3::ZERO,
            thin,
            roughness,
        })
    }

    fn conductor(&mut self, node: Node, roughness: Roughness) -> Result<Surface> {
        let tint = self.color(node, "specular_reflectance", Quantity::Share, 1.0)?;
        let (eta, k) = self.complex_index(node)?;
        Ok(Surface::Conductor { fresnel: ConductorFresnel::Complex { eta, k, tint }, roughness })
    }

    /// η and k relative to what is outside. Without any, release 2 and later have a perfect mirror,
    /// and those before copper.
    fn complex_index(&mut self, node: Node) -> Result<(Vec3, Vec3)> {
        // 0 + i reflects all at every angle.
        const MIRROR: (Vec3, Vec3) = (Vec3::ZERO, Vec3::ONE);
        let outside = if node.has("ext_eta") { ior(node, "ext_eta", indices::AIR)? } else { 1.0 };
        let eta = node.color("eta", Quantity::Unbounded)?;
        let k = node.color("k", Quantity::Unbounded)?;
        if eta.is_some() || k.is_some() {
            return Ok((eta.unwrap_or(Vec3::ZERO) / outside, k.unwrap_or(Vec3::ONE) / outside));
        }
        let default = if self.is_old && node.plugin() != "mirror" { "Cu" } else { "none" };
        let name = node.text("material")?.unwrap_or(default);
        if name.eq_ignore_ascii_case("none") {
            return Ok(MIRROR);
        }
        if let Some((eta, k)) = indices::metal(name) {
            return Ok((eta / outside, k / outside));
        }
        let message = format!("the metal {name:?} is not known: copper stands for it");
        self.warn(WarningKind::Approximation, node, &message);
        indices::metal("Cu").ok_or_else(|| node.malformed("copper is not known"))
    }

    fn plastic(&mut self, node: Node, roughness: Roughness) -> Result<Surface> {
        Ok(Surface::Plastic {
            reflectance: self.color(node, "diffuse_reflectance", Quantity::Share, 0.5)?,
            specular: self.color(node, "specular_reflectance", Quantity::Share, 1.0)?,
            ior: relative_ior(node, indices::PLASTIC)?,
            nonlinear: node.boolean_or("nonlinear", false)?,
            roughness,
        })
    }

    /// α by `alpha`, or by direction.
    pub(super) fn roughness(&mut self, node: Node) -> Result<Roughness> {
        node.disregard(&["sample_visible"]);
        let default = match node.plugin() {
            "roughcoating" | "roughdielectric" | "roughconductor" | "roughplastic" => 0.1,
            _ => 0.2,
        };
        let distribution = node.text("distribution")?.unwrap_or("beckmann");
        if distribution != "ggx" {
            let message = format!("{distribution} distributions of microfacets are rendered as GGX");
            self.warn(WarningKind::Approximation, node, &message);
        }
        let isotropic = self.scalar(node, "alpha", default)?;
        let by_direction = |loader: &mut Self, name: &str| -> Result<ScalarInput> {
            let given = node.has(name) || node.child(name)?.is_some();
            if given { loader.scalar(node, name, default) } else { Ok(isotropic.clone()) }
        };
        let along = by_direction(self, "alpha_u")?;
        let across = by_direction(self, "alpha_v")?;
        Ok(Roughness { along, across, squared: false, single_bounce: true })
    }

    fn mask(&mut self, node: Node, depth: usize) -> Result<Material> {
        let mut material = self.nested(node, depth)?;
        let opacity = self.scalar(node, "opacity", 0.5)?;
        if material.opacity != Opacity::Opaque {
            self.warn(WarningKind::Alpha, node, "of masks in masks the outer one is used");
        }
        let whole = opacity.texture.is_none() && opacity.value >= 1.0;
        material.opacity = if whole { Opacity::Opaque } else { Opacity::Blend(opacity) };
        Ok(material)
    }

    fn normal_map(&mut self, node: Node, depth: usize) -> Result<Material> {
        let mut material = self.nested(node, depth)?;
        let texture = match node.first(Class::Texture)? {
            Some(texture) => self.normals(texture)?,
            None => None,
        };
        material.normal_map = texture.map(|texture| NormalMap { texture, scale: 1.0 });
        Ok(material)
    }
}

/// An index of refraction: a number, or a material's name.
fn ior(node: Node, name: &str, default: &str) -> Result<f32> {
    let by_name = |name: &str| {
        indices::dielectric(name).ok_or_else(|| node.malformed(format!("the material {name:?} is not known")))
    };
    let ior = match node.value(name) {
        Some(Value::Text(name)) => by_name(name)?,
        _ => match node.float(name)? {
            Some(ior) => ior,
            None => by_name(default)?,
        },
    };
    if ior > 0.0 { Ok(ior) } else { Err(node.malformed(format!("\"{name}\" has to be above 0"))) }
}

/// Inside over outside.
pub(super) fn relative_ior(node: Node, inside: &str) -> Result<f32> {
    Ok(ior(node, "int_ior", inside)? / ior(node, "ext_ior", indices::AIR)?)
}
