//! What a scene needs of the kernels (`lib/features.wgsl`): a GPU compiles them without the rest.

use midway_kernels::constants as k;
use midway_scene::{
    CoatNormal, LightKind, Material, MetallicRoughness, Opacity, Roughness, ScalarInput, Scene, Surface,
};

/// The bits of `FEATURE_*` of everything that a scene has but its environment. What textures may make of a
/// value counts as there. Not of the scene's data alone: whether meshes are placed, have attributes, and whether there
/// are pre-generated numbers is for who packs them to say.
pub(crate) fn scene_features(scene: &Scene) -> u32 {
    let materials = scene.materials.iter().map(material_features);
    let lights = scene.lights.iter().map(|light| match light.kind {
        LightKind::Point { .. } | LightKind::Spot { .. } => k::FEATURE_POINT_LIGHTS,
        LightKind::Directional { .. } => k::FEATURE_DIRECTIONAL_LIGHTS,
    });
    materials.chain(lights).fold(0, |all, features| all | features)
}

fn material_features(material: &Material) -> u32 {
    // A surface that is not there is one with holes everywhere (`is_absent`).
    let cutout = material.opacity != Opacity::Opaque || material.surface == Surface::Null;
    let inside = if material.surface.has_inside() { k::FEATURE_INSIDES } else { 0 };
    let textured_light = material.is_emissive()
        && (material.emission.texture.is_some() || material.opacity != Opacity::Opaque);
    let set = [
        (cutout, k::FEATURE_CUTOUTS),
        (textured_light, k::FEATURE_TEXTURED_LIGHTS),
        (material.surface.ior_spread() > 0.0, k::FEATURE_DISPERSION),
        (has_coat_normal(material), k::FEATURE_COAT_NORMALS),
    ];
    let surface = surface_features(&material.surface);
    let stretched = surface & k::FEATURE_ANISOTROPY != 0;
    let solid = if stretched && inside != 0 { k::FEATURE_STRETCHED_SOLIDS } else { 0 };
    set.iter().filter(|(has, _)| *has).fold(surface | inside | solid, |all, (_, feature)| all | feature)
}

/// Whether a coat's normals are not those of the surface below.
pub(crate) fn has_coat_normal(material: &Material) -> bool {
    let Surface::MetallicRoughness(model) = &material.surface else { return false };
    model.clearcoat.value > 0.0
        && match &model.clearcoat_normal {
            CoatNormal::Below => false,
            CoatNormal::Mesh => material.normal_map.is_some(),
            CoatNormal::Map(_) => true,
        }
}

/// Whether any of what a surface transmits may have a density.
pub(crate) fn transmits_density(surface: &Surface) -> bool {
    surface_features(surface) & k::FEATURE_TRANSMISSION != 0
}

/// Whether nothing of a surface scatters into a density, whatever its textures say: they only multiply.
pub(crate) fn is_delta(surface: &Surface) -> bool {
    match surface {
        Surface::Conductor { roughness, .. } | Surface::Dielectric { roughness, .. } => roughness.is_smooth(),
        Surface::MetallicRoughness(model) => is_delta_metallic_roughness(model),
        Surface::Null => true,
        Surface::Diffuse { .. } | Surface::Plastic { .. } => false,
    }
}

fn is_delta_metallic_roughness(model: &MetallicRoughness) -> bool {
    let zero = |input: &ScalarInput| input.value == 0.0;
    let one = |input: &ScalarInput| input.value == 1.0 && input.texture.is_none();
    let has_diffuse = !one(&model.metallic) && !one(&model.transmission);
    let has_rough_coat = !zero(&model.clearcoat) && !zero(&model.clearcoat_roughness);
    let has_sheen = model.sheen_color.value != glam::Vec3::ZERO;
    zero(&model.roughness) && zero(&model.anisotropy) && !has_diffuse && !has_rough_coat && !has_sheen
}

fn surface_features(surface: &Surface) -> u32 {
    let interface = |kind, roughness: &Roughness, transmits: bool| {
        kind | k::FEATURE_INTERFACES | rough(roughness, transmits)
    };
    match surface {
        Surface::Diffuse { .. } => 0,
        Surface::Conductor { roughness, .. } => interface(k::FEATURE_CONDUCTOR, roughness, false),
        Surface::Dielectric { roughness, .. } => interface(k::FEATURE_DIELECTRIC, roughness, true),
        Surface::Plastic { roughness, .. } => interface(k::FEATURE_PLASTIC, roughness, false),
        Surface::MetallicRoughness(model) => metallic_roughness(model),
        Surface::Null => k::FEATURE_INTERFACES,
    }
}

fn rough(roughness: &Roughness, transmits: bool) -> u32 {
    if roughness.is_smooth() {
        return 0;
    }
    let transmission = if transmits { k::FEATURE_TRANSMISSION } else { 0 };
    let anisotropy = if roughness.along == roughness.across { 0 } else { k::FEATURE_ANISOTROPY };
    k::FEATURE_ROUGHNESS | transmission | anisotropy
}

fn metallic_roughness(model: &MetallicRoughness) -> u32 {
    let positive = |input: &ScalarInput| input.value > 0.0;
    let layers = positive(&model.clearcoat) || model.sheen_color.value.max_element() > 0.0;
    // A stretched surface is rough along its direction.
    let rough = positive(&model.roughness) || positive(&model.anisotropy);
    let set = [
        (true, k::FEATURE_METALLIC_ROUGHNESS | k::FEATURE_INTERFACES),
        (rough, k::FEATURE_ROUGHNESS),
        (positive(&model.anisotropy), k::FEATURE_ANISOTROPY),
        (rough && positive(&model.transmission), k::FEATURE_TRANSMISSION),
        // A rough coat is of facets too, and lies over what may be smooth.
        (layers, k::FEATURE_LAYERS),
    ];
    set.iter().filter(|(has, _)| *has).fold(0, |all, (_, feature)| all | feature)
}

#[cfg(test)]
mod tests {
    use midway_scene::{Channel, Texture};

    use super::*;

    #[test]
    fn smooth_metal_and_glass_are_delta_unless_a_texture_takes_some_of_it_away() {
        let plain =
            MetallicRoughness { metallic: 1.0.into(), roughness: 0.0.into(), ..MetallicRoughness::default() };
        let delta = |change: &dyn Fn(&mut MetallicRoughness)| {
            let mut model = plain.clone();
            change(&mut model);
            is_delta(&Surface::MetallicRoughness(Box::new(model)))
        };
        assert!(delta(&|_| ()));
        assert!(delta(&|m| (m.metallic, m.transmission) = (0.0.into(), 1.0.into())));
        assert!(delta(&|m| m.clearcoat = 1.0.into()), "a smooth coat");
        assert!(!delta(&|m| m.metallic = 0.5.into()));
        assert!(!delta(&|m| m.metallic.texture = Some((Texture::new(0), Channel::B))));
        assert!(!delta(&|m| m.roughness = 0.01.into()));
        assert!(!delta(&|m| m.anisotropy = 0.5.into()));
        assert!(!delta(&|m| m.sheen_color.value = glam::Vec3::splat(0.1)));
        assert!(!delta(&|m| (m.clearcoat, m.clearcoat_roughness) = (1.0.into(), 0.3.into())));
    }
}
