//! pbrt-v3's materials.

use glam::Vec3;
use midway_scene::{ColorInput, ConductorFresnel, MetallicRoughness, Opacity, Roughness, Surface};

use super::materials::Definition;
use crate::{ImportError, disney, metals::ComplexIor, warning::WarningKind};

/// pbrt-v3's `TrowbridgeReitzDistribution::RoughnessToAlpha`.
pub(super) fn alpha_of_roughness(roughness: f32) -> f32 {
    let x = roughness.max(1e-3).ln();
    1.621_42 + x * (0.819_955 + x * (0.173_4 + x * (0.017_120_1 + x * 0.000_640_711)))
}

/// The surface of a v3 material; none where it is not one.
pub(super) fn surface(material: &mut Definition, kind: &str) -> Result<Option<Surface>, ImportError> {
    Ok(Some(match kind {
        "matte" => matte(material)?,
        "plastic" => plastic(material)?,
        "glass" => glass(material)?,
        "mirror" => mirror(material)?,
        "metal" => metal(material)?,
        "uber" => uber(material)?,
        "substrate" => substrate(material)?,
        "translucent" => {
            material.params.ignore(&["transmit", "roughness", "remaproughness", "Ks"]);
            material.approximated("\"translucent\" is rendered as diffuse, without what it transmits");
            let reflect = material.albedo("reflect", 0.5)?;
            let mut reflectance = material.albedo("Kd", 0.25)?;
            reflectance.value *= reflect.value;
            Surface::Diffuse { reflectance }
        }
        "disney" => disney(material)?,
        _ => return Ok(None),
    }))
}

fn matte(material: &mut Definition) -> Result<Surface, ImportError> {
    if material.scalar("sigma")?.is_some_and(|sigma| sigma.input.value != 0.0) {
        material
            .approximated("Oren and Nayar's rough diffuse surfaces (\"sigma\") are rendered as Lambert's");
    }
    Ok(Surface::Diffuse { reflectance: material.albedo("Kd", 0.5)? })
}

fn roughness(material: &mut Definition, default: f32) -> Result<Roughness, ImportError> {
    material.roughness_by("", default, alpha_of_roughness)
}

/// pbrt-v3 adds the coat's reflection to the base and has neither take from the other.
fn plastic(material: &mut Definition) -> Result<Surface, ImportError> {
    material.approximated("diffuse and glossy lobes that add up are rendered as a base under a coat");
    Ok(Surface::Plastic {
        reflectance: material.albedo("Kd", 0.25)?,
        specular: material.albedo("Ks", 0.25)?,
        ior: 1.5,
        nonlinear: false,
        roughness: roughness(material, 0.1)?,
    })
}

/// Smooth where neither roughness is given, and perfectly so at 0 even if remapped.
fn glass(material: &mut Definition) -> Result<Surface, ImportError> {
    let zero_stays = |x: f32| if x == 0.0 { 0.0 } else { alpha_of_roughness(x) };
    Ok(Surface::Dielectric {
        ior: material.reader.ior(material.params, &["eta", "index"], 1.5)?,
        dispersion: 0.0,
        reflection: material.albedo("Kr", 1.0)?,
        transmission: material.albedo("Kt", 1.0)?,
        sigma_a: Vec3::ZERO,
        thin: false,
        roughness: material.roughness_by("", 0.0, zero_stays)?,
    })
}

/// The same reflectance at all angles: a metal of η = 0 reflects everything, tinted.
fn mirror(material: &mut Definition) -> Result<Surface, ImportError> {
    let tint = material.albedo("Kr", 0.9)?;
    let fresnel = ConductorFresnel::Complex { eta: Vec3::ZERO, k: Vec3::ONE, tint };
    Ok(Surface::Conductor { fresnel, roughness: Roughness::smooth() })
}

fn metal(material: &mut Definition) -> Result<Surface, ImportError> {
    let ComplexIor { eta, k } = material.complex_ior("eta", "k")?;
    let fresnel = ConductorFresnel::Complex { eta, k, tint: Vec3::ONE.into() };
    Ok(Surface::Conductor { fresnel, roughness: roughness(material, 0.01)? })
}

/// The strongest of its lobes: glass by `Kt`, a mirror by `Kr`, else a base under a coat.
fn uber(material: &mut Definition) -> Result<Surface, ImportError> {
    let [transmitted, reflected] = [material.albedo("Kt", 0.0)?, material.albedo("Kr", 0.0)?];
    let diffuse = material.albedo("Kd", 0.25)?;
    let glossy = material.albedo("Ks", 0.25)?;
    let ior = material.reader.ior(material.params, &["eta", "index"], 1.5)?;
    let alpha = roughness(material, 0.1)?;
    material.approximated("\"uber\" is rendered by the strongest of its lobes, or as a base under a coat");
    let [kt, kr, kd] = [&transmitted, &reflected, &diffuse].map(|c| c.value.max_element());
    Ok(if kt > 0.0 && kt >= kd {
        Surface::Dielectric {
            ior,
            dispersion: 0.0,
            reflection: reflected,
            transmission: transmitted,
            sigma_a: Vec3::ZERO,
            thin: false,
            roughness: Roughness::smooth(),
        }
    } else if kr > kd {
        let fresnel = ConductorFresnel::Complex { eta: Vec3::ZERO, k: Vec3::ONE, tint: reflected };
        Surface::Conductor { fresnel, roughness: Roughness::smooth() }
    } else if glossy.value == Vec3::ZERO {
        Surface::Diffuse { reflectance: diffuse }
    } else {
        Surface::Plastic { reflectance: diffuse, specular: glossy, ior, nonlinear: false, roughness: alpha }
    })
}

/// How much of "uber" is there: the rest lets light straight through.
pub(super) fn opacity(material: &mut Definition) -> Result<Opacity, ImportError> {
    let ColorInput { value, texture } = material.albedo("opacity", 1.0)?;
    if value.min_element() < value.max_element() {
        material.warn(WarningKind::Alpha, "coloured opacity is rendered as grey");
    }
    let grey = value.element_sum() / 3.0;
    if grey == 1.0 && texture.is_none() {
        return Ok(Opacity::Opaque);
    }
    let texture = texture.map(|texture| (texture, midway_scene::Channel::G));
    Ok(Opacity::Blend(midway_scene::ScalarInput { value: grey, texture }))
}

/// Ashikhmin and Shirley's: `Ks` is the coat's reflectance at normal incidence.
fn substrate(material: &mut Definition) -> Result<Surface, ImportError> {
    material.approximated("\"substrate\" is rendered as a base under a dielectric of that reflectance");
    let mut specular = material.albedo("Ks", 0.5)?;
    let f0 = specular.value.max_element().min(0.95);
    if f0 > 0.0 {
        specular.value /= specular.value.max_element();
    }
    let root = f0.sqrt();
    Ok(Surface::Plastic {
        reflectance: material.albedo("Kd", 0.5)?,
        specular,
        ior: ((1.0 + root) / (1.0 - root)).max(1.0 + 1e-3),
        nonlinear: false,
        roughness: roughness(material, 0.1)?,
    })
}

/// Burley's, by glTF's model, which leaves out what it has no word for.
fn disney(material: &mut Definition) -> Result<Surface, ImportError> {
    material.params.ignore(&["speculartint", "scatterdistance", "flatness", "difftrans"]);
    material.approximated("\"disney\" is rendered by glTF's metallic-roughness model");
    let base_color = material.albedo("color", 0.5)?;
    let mut scalar = |name: &str, default: f32| -> Result<_, ImportError> {
        let scalar = material.scalar(name)?.unwrap_or(default.into());
        Ok(material.textures.map(&scalar, |x| x))
    };
    let (metallic, roughness) = (scalar("metallic", 0.0)?, scalar("roughness", 0.5)?);
    let (anisotropy, sheen) = (scalar("anisotropic", 0.0)?, scalar("sheen", 0.0)?);
    let (tint, gloss) = (scalar("sheentint", 0.5)?, scalar("clearcoatgloss", 1.0)?);
    let (mut clearcoat, transmission) = (scalar("clearcoat", 0.0)?, scalar("spectrans", 0.0)?);
    // Burley's coat has a quarter of the strength, as in pbrt's disney.cpp.
    clearcoat.value *= 0.25;
    let images = &mut material.textures.images;
    let clearcoat_roughness = disney::coat_roughness(images, &gloss);
    let sheen = disney::sheen(images, &base_color, &tint, &sheen);
    if !sheen.is_whole {
        material.warn(WarningKind::Texture, disney::SHEEN_IN_PART);
    }
    Ok(Surface::MetallicRoughness(Box::new(MetallicRoughness {
        base_color,
        metallic,
        roughness,
        ior: material.reader.ior(material.params, &["eta"], 1.5)?,
        transmission,
        thin: material.params.bool_or("thin", false)?,
        clearcoat,
        clearcoat_roughness,
        sheen_color: sheen.color,
        sheen_roughness: 0.5.into(),
        anisotropy,
        ..MetallicRoughness::default()
    })))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roughness_by_the_book() {
        // 1.62142 at ln 1 = 0, and small where smooth.
        assert_eq!(alpha_of_roughness(1.0), 1.621_42);
        assert!((alpha_of_roughness(0.1) - 0.461_8).abs() <= 1e-3, "{}", alpha_of_roughness(0.1));
        assert!((0.0..0.05).contains(&alpha_of_roughness(0.0)), "{}", alpha_of_roughness(0.0));
    }
}
