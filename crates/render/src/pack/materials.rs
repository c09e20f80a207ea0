//! Materials as records of vec4.

use glam::Vec3;
use midway_kernels::constants as k;
use midway_scene::{ConductorFresnel, Material, Sides, Surface};

use super::{Word4, word4};

/// One record. `slot_flags`: what its record of textures holds.
pub(super) fn pack_material(material: &Material, slot_flags: u32) -> [Word4; k::MATERIAL_STRIDE as usize] {
    let (kind, reflectance, ior, sigma_a, thin) = match &material.surface {
        Surface::Diffuse { reflectance } => (k::SURFACE_DIFFUSE, reflectance.value, 1.0, Vec3::ZERO, false),
        Surface::Conductor { fresnel: ConductorFresnel::Schlick { f0 }, .. } => {
            (k::SURFACE_MIRROR, f0.value, 1.0, Vec3::ZERO, false)
        }
        Surface::Dielectric { ior, transmission, sigma_a, thin, .. } => {
            (k::SURFACE_DIELECTRIC, transmission.value, *ior, *sigma_a, *thin)
        }
        _ => (k::SURFACE_DIFFUSE, Vec3::splat(0.5), 1.0, Vec3::ZERO, false),
    };
    let back = if material.emits == Sides::Both { k::MATERIAL_EMITS_BACK } else { 0 };
    let flags = slot_flags | back | if thin { k::MATERIAL_THIN } else { 0 };
    [word4(reflectance, kind), word4(material.emission.value, f32::to_bits(ior)), word4(sigma_a, flags)]
}
