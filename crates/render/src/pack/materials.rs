//! Materials as records of vec4: the scene's values, in the order of `bindings/material.wgsl`. What
//! follows from them is derived on the device (`finish_material`).

use glam::Vec3;
use midway_kernels::constants as k;
use midway_scene::{CoatNormal, ConductorFresnel, Material, MetallicRoughness, Roughness, Sides, Surface};

use super::{Word4, word4};
use crate::features::{has_coat_normal, is_delta, transmits_density};

/// What a record holds, in the terms of `RawMaterial`.
#[derive(Default)]
struct Record {
    kind: u32,
    flags: u32,
    color: Vec3,
    ior: f32,
    sigma_a: Vec3,
    specular_color: Vec3,
    specular: f32,
    roughness: [f32; 2],
    metallic: f32,
    transmission: f32,
    eta_or_sheen: [f32; 4],
    k_or_coat: [f32; 3],
    rotation: f32,
}

/// What the buffer starts with: tables of albedos, which `finish_material` reads.
pub(super) fn albedo_tables() -> Vec<Word4> {
    let (rows, _) = midway_kernels::ALBEDO_TABLES.as_chunks::<16>();
    let word = |row: &[u8; 16], i: usize| [row[i], row[i + 1], row[i + 2], row[i + 3]];
    rows.iter().map(|row| [0, 4, 8, 12].map(|i| u32::from_le_bytes(word(row, i)))).collect()
}

/// One record. `slot_flags`: what its record of textures holds.
pub(super) fn pack_material(material: &Material, slot_flags: u32) -> [Word4; k::MATERIAL_STRIDE as usize] {
    let record = record_of(&material.surface);
    let emits_back = if material.emits == Sides::Both { k::MATERIAL_EMITS_BACK } else { 0 };
    let transmits = if transmits_density(&material.surface) { k::MATERIAL_TRANSMITS } else { 0 };
    let spread = material.surface.ior_spread();
    let coat_normal = if has_coat_normal(material) { k::MATERIAL_COAT_NORMAL } else { 0 };
    let disperses = if spread > 0.0 { k::MATERIAL_DISPERSES } else { 0 };
    let delta = if is_delta(&material.surface) { k::MATERIAL_DELTA } else { 0 };
    let own = emits_back | front_only(material) | transmits | disperses | coat_normal | delta;
    let flags = record.flags | slot_flags | own;
    let [a, b] = record.roughness;
    let float4 = |v: [f32; 4]| v.map(f32::to_bits);
    let [x, y, z] = record.k_or_coat;
    [
        word4(record.color, record.kind),
        word4(material.emission.value, record.ior.to_bits()),
        word4(record.sigma_a, flags),
        word4(record.specular_color, record.specular.to_bits()),
        float4([a, b, record.metallic, record.transmission]),
        float4(record.eta_or_sheen),
        float4([x, y, z, sine_within_a_quarter_turn(record.rotation)]),
        float4([spread, coat_scale(&material.surface), 0.0, 0.0]),
    ]
}

/// What lets light through has two sides.
fn front_only(material: &Material) -> u32 {
    let transmits = match &material.surface {
        Surface::Dielectric { .. } | Surface::Null => true,
        Surface::MetallicRoughness(model) => model.transmission.value > 0.0,
        _ => false,
    };
    if material.scatters == Sides::Front && !transmits { k::MATERIAL_FRONT_ONLY } else { 0 }
}

/// The scale of a coat's normal map, 0 where there is none.
fn coat_scale(surface: &Surface) -> f32 {
    if let Surface::MetallicRoughness(model) = surface
        && let CoatNormal::Map(map) = &model.clearcoat_normal
    {
        return map.scale;
    }
    0.0
}

/// Half a turn changes no ellipse, so that the cosine may be taken as positive.
fn sine_within_a_quarter_turn(angle: f32) -> f32 {
    if angle.cos() < 0.0 { -angle.sin() } else { angle.sin() }
}

fn record_of(surface: &Surface) -> Record {
    let inside = if surface.has_inside() { k::MATERIAL_INSIDE } else { 0 };
    match surface {
        Surface::Diffuse { reflectance } => {
            Record { kind: k::SURFACE_DIFFUSE, color: reflectance.value, ior: 1.0, ..Record::default() }
        }
        Surface::Conductor { fresnel, roughness } => conductor(fresnel, roughness),
        Surface::Dielectric { ior, reflection, transmission, sigma_a, roughness, .. } => Record {
            kind: k::SURFACE_DIELECTRIC,
            flags: inside | facets(roughness),
            color: transmission.value,
            ior: *ior,
            sigma_a: *sigma_a,
            specular_color: reflection.value,
            specular: 1.0,
            roughness: values(roughness),
            ..Record::default()
        },
        Surface::Plastic { reflectance, specular, ior, nonlinear, roughness } => Record {
            kind: k::SURFACE_PLASTIC,
            flags: facets(roughness) | if *nonlinear { k::MATERIAL_NONLINEAR } else { 0 },
            color: reflectance.value,
            ior: *ior,
            specular_color: specular.value,
            specular: 1.0,
            roughness: values(roughness),
            ..Record::default()
        },
        Surface::MetallicRoughness(model) => metallic_roughness(model, inside | k::MATERIAL_SQUARED),
        Surface::Null => Record { kind: k::SURFACE_NULL, ior: 1.0, ..Record::default() },
    }
}

fn conductor(fresnel: &ConductorFresnel, roughness: &Roughness) -> Record {
    let plain = Record {
        kind: k::SURFACE_CONDUCTOR,
        flags: facets(roughness),
        ior: 1.0,
        roughness: values(roughness),
        ..Record::default()
    };
    match fresnel {
        ConductorFresnel::Schlick { f0 } => Record { color: f0.value, ..plain },
        ConductorFresnel::Complex { eta, k: absorption, tint } => Record {
            flags: plain.flags | k::MATERIAL_COMPLEX,
            color: tint.value,
            eta_or_sheen: eta.extend(0.0).to_array(),
            k_or_coat: absorption.to_array(),
            ..plain
        },
    }
}

fn metallic_roughness(model: &MetallicRoughness, flags: u32) -> Record {
    Record {
        kind: k::SURFACE_METALLIC_ROUGHNESS,
        flags,
        color: model.base_color.value,
        ior: model.ior,
        sigma_a: model.sigma_a,
        specular_color: model.specular_color.value,
        specular: model.specular.value,
        roughness: [model.roughness.value; 2],
        metallic: model.metallic.value,
        transmission: model.transmission.value,
        eta_or_sheen: model.sheen_color.value.extend(model.sheen_roughness.value).to_array(),
        k_or_coat: [model.clearcoat.value, model.clearcoat_roughness.value, model.anisotropy.value],
        rotation: model.anisotropy_rotation,
    }
}

fn facets(roughness: &Roughness) -> u32 {
    let squared = if roughness.squared { k::MATERIAL_SQUARED } else { 0 };
    squared | if roughness.single_bounce { k::MATERIAL_SINGLE_BOUNCE } else { 0 }
}

fn values(roughness: &Roughness) -> [f32; 2] {
    [roughness.along.value, roughness.across.value]
}
