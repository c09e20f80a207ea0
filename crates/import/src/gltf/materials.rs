//! Materials: metallic-roughness taken to the nearest surface that is rendered.

use glam::{Vec3, Vec4};
use midway_scene::{Material, Roughness, Sides, Surface};

use super::{json::Json, warn_of_extensions};
use crate::{
    ImportError,
    warning::{WarningKind, Warnings},
};

/// Metals less rough than this look more like a mirror, the others more like a diffuse surface.
const MIRROR_ROUGHNESS: f32 = 0.5;
/// The least attenuation colour: a channel that is black at some distance absorbs this much.
const LEAST_ATTENUATION: f32 = 1e-7;

/// All materials, in the file's order.
pub(super) fn read_all(root: &Json, warnings: &mut Warnings) -> Result<Vec<Material>, ImportError> {
    root.items("materials")?.iter().map(|definition| read(definition, warnings)).collect()
}

fn read(material: &Json, warnings: &mut Warnings) -> Result<Material, ImportError> {
    warn_of_textures(material, warnings)?;
    warn_of_extensions(material, warnings)?;
    warn_of_alpha(material, warnings)?;
    Ok(Material {
        name: material.name(),
        emission: emission(material, warnings)?.into(),
        emits: if material.bool_or("doubleSided", false)? { Sides::Both } else { Sides::Front },
        ..Material::new(surface(material, warnings)?)
    })
}

fn approximated(material: &Json, warnings: &mut Warnings, message: &str) {
    warnings.add(WarningKind::Approximation, material.pointer(), message);
}

/// Takes factors into the range that they have by the format.
fn fraction(at: &Json, value: Vec3, warnings: &mut Warnings) -> Vec3 {
    let clamped = value.clamp(Vec3::ZERO, Vec3::ONE);
    if clamped != value {
        warnings.add(WarningKind::Repaired, at.pointer(), "factors outside 0 to 1 are clamped");
    }
    clamped
}

fn surface(material: &Json, warnings: &mut Warnings) -> Result<Surface, ImportError> {
    let (mut base, mut metallic, mut roughness) = (Vec4::ONE, 1.0, 1.0);
    if let Some(pbr) = material.get("pbrMetallicRoughness") {
        base = Vec4::from_array(pbr.floats_or("baseColorFactor", [1.0; 4])?);
        metallic = pbr.float_or("metallicFactor", 1.0)?;
        roughness = pbr.float_or("roughnessFactor", 1.0)?;
    }
    let base = fraction(material, base.truncate(), warnings);
    if metallic > 0.0 && metallic < 1.0 {
        approximated(
            material,
            warnings,
            "metallic factors between 0 and 1 are rendered as the nearer of the two",
        );
    }
    if metallic >= 0.5 {
        return Ok(metal(material, base, roughness, warnings));
    }
    if let Some(glass) = dielectric(material, base, roughness, warnings)? {
        return Ok(glass);
    }
    let specular = material.extension("KHR_materials_specular");
    let layer = specular.map_or(Ok(1.0), |s| s.float_or("specularFactor", 1.0))?;
    if layer != 0.0 {
        let message = "the specular layer of non-metals is left out: they are rendered as diffuse";
        approximated(material, warnings, message);
    }
    Ok(Surface::diffuse(base))
}

fn metal(material: &Json, reflectance: Vec3, roughness: f32, warnings: &mut Warnings) -> Surface {
    if roughness >= MIRROR_ROUGHNESS {
        approximated(material, warnings, "metals with a roughness of 0.5 or more are rendered as diffuse");
        return Surface::diffuse(reflectance);
    }
    if roughness > 0.0 {
        approximated(material, warnings, "metals with a roughness below 0.5 are rendered as perfect mirrors");
    }
    Surface::mirror(reflectance)
}

/// What `KHR_materials_transmission` makes of a material; none where little is transmitted.
fn dielectric(
    material: &Json,
    tint: Vec3,
    roughness: f32,
    warnings: &mut Warnings,
) -> Result<Option<Surface>, ImportError> {
    let Some(transmission) = material.extension("KHR_materials_transmission") else {
        return Ok(None);
    };
    let factor = transmission.float_or("transmissionFactor", 0.0)?;
    if factor > 0.0 && factor < 1.0 {
        let message = "transmission factors between 0 and 1 are rendered as the nearer of the two";
        approximated(&transmission, warnings, message);
    }
    if factor < 0.5 {
        return Ok(None);
    }
    if roughness > 0.0 {
        approximated(material, warnings, "rough glass is rendered as smooth");
    }
    let thickness = match material.extension("KHR_materials_volume") {
        Some(volume) => volume.float_or("thicknessFactor", 0.0)?,
        None => 0.0,
    };
    let thin = thickness <= 0.0;
    let sigma_a = if thin { Vec3::ZERO } else { absorption(material, warnings)? };
    Ok(Some(Surface::Dielectric {
        ior: ior(material, warnings)?,
        reflection: Vec3::ONE.into(),
        transmission: tint.into(),
        sigma_a,
        thin,
        roughness: Roughness::smooth(),
    }))
}

fn ior(material: &Json, warnings: &mut Warnings) -> Result<f32, ImportError> {
    const DEFAULT: f32 = 1.5;
    let Some(extension) = material.extension("KHR_materials_ior") else {
        return Ok(DEFAULT);
    };
    let ior = extension.float_or("ior", DEFAULT)?;
    if ior > 0.0 {
        return Ok(ior);
    }
    warnings.add(WarningKind::Repaired, extension.pointer(), "indices of refraction of 0 are taken as 1.5");
    Ok(DEFAULT)
}

/// σ_a = -ln(attenuationColor) / attenuationDistance (KHR_materials_volume).
fn absorption(material: &Json, warnings: &mut Warnings) -> Result<Vec3, ImportError> {
    let Some(volume) = material.extension("KHR_materials_volume") else {
        return Ok(Vec3::ZERO);
    };
    let colour = Vec3::from_array(volume.floats_or("attenuationColor", [1.0; 3])?);
    let colour = fraction(&volume, colour, warnings);
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

fn emission(material: &Json, warnings: &mut Warnings) -> Result<Vec3, ImportError> {
    let factor = Vec3::from_array(material.floats_or("emissiveFactor", [0.0; 3])?);
    let extension = material.extension("KHR_materials_emissive_strength");
    let strength = extension.map_or(Ok(1.0), |e| e.float_or("emissiveStrength", 1.0))?;
    let emission = factor * strength;
    if !emission.is_finite() {
        return Err(material.malformed("its emission is not a finite number"));
    }
    if emission.min_element() < 0.0 {
        warnings.add(WarningKind::Repaired, material.pointer(), "negative emission is taken as 0");
    }
    Ok(emission.max(Vec3::ZERO) + Vec3::ZERO)
}

fn warn_of_alpha(material: &Json, warnings: &mut Warnings) -> Result<(), ImportError> {
    let Some(mode) = material.get("alphaMode") else {
        return Ok(());
    };
    match mode.string()? {
        "OPAQUE" => {}
        other => {
            let message = format!("alpha mode {other:?} is not used: the surface is rendered as opaque");
            warnings.add(WarningKind::Alpha, mode.pointer(), message);
        }
    }
    Ok(())
}

/// Warns of each kind of texture, in the material and in the extensions of it that are read.
fn warn_of_textures(material: &Json, warnings: &mut Warnings) -> Result<(), ImportError> {
    let mut holders = vec![material.clone()];
    holders.extend(material.get("pbrMetallicRoughness"));
    for name in super::SUPPORTED_EXTENSIONS {
        holders.extend(material.extension(name));
    }
    for holder in holders {
        for (key, value) in holder.members()? {
            if key.ends_with("Texture") {
                let instead = match key {
                    "baseColorTexture" | "emissiveTexture" => ": its factor alone is",
                    _ => "",
                };
                let message = format!("{key} is not used{instead}");
                warnings.add(WarningKind::Texture, value.pointer(), message);
            }
        }
    }
    Ok(())
}
