// What of a material varies over the surface: a record of textures beside the material's own.

#include "bindings/textures.wgsl"

/// vec4 per material: a word for each slot; then normal scale, opacity, cutoff, and as bits the mode
/// (2) and behind it which slots `add_textures` is to look up.
const SLOTS_STRIDE: u32 = 6u;
/// A slot's word is a texture's index and, in its two lowest bits, a channel; NONE for no texture.
const N_SLOTS: u32 = 20u;
/// Albedo, F0, the tint of what is transmitted.
const SLOT_COLOR: u32 = 0u;
const SLOT_NORMAL: u32 = 1u;
const SLOT_OPACITY: u32 = 2u;
const SLOT_EMISSION: u32 = 3u;
const SLOT_ROUGHNESS: u32 = 4u;
const SLOT_ROUGHNESS_ACROSS: u32 = 5u;
const SLOT_METALLIC: u32 = 6u;
const SLOT_TRANSMISSION: u32 = 7u;
const SLOT_SPECULAR: u32 = 8u;
const SLOT_SPECULAR_COLOR: u32 = 9u;
const SLOT_CLEARCOAT: u32 = 10u;
const SLOT_CLEARCOAT_ROUGHNESS: u32 = 11u;
const SLOT_SHEEN_COLOR: u32 = 12u;
const SLOT_SHEEN_ROUGHNESS: u32 = 13u;
const SLOT_ANISOTROPY: u32 = 14u;
/// Red and green: along the tangent and the bitangent, from -1 to 1.
const SLOT_ANISOTROPY_DIRECTION: u32 = 15u;
const SLOT_CLEARCOAT_NORMAL: u32 = 16u;

// The record's mode, the low bits of the last word
const OPACITY_NONE: u32 = 0u;
const OPACITY_MASK: u32 = 1u;
const OPACITY_BLEND: u32 = 2u;
const OPACITY_BITS: u32 = 2u;

// Further bits of a material's flags.
/// It has a texture in a slot that its scattering, its emission or its normal takes.
const MATERIAL_TEXTURED: u32 = 0x10000u;
/// It is not everywhere there.
const MATERIAL_CUTOUT: u32 = 0x40000u;

/// A material's word for a slot.
fn load_slot(material: u32, slot: u32) -> u32 {
    return bitcast<u32>(scene[params.slots_at + material * SLOTS_STRIDE + slot / 4u][slot % 4u]);
}

/// Which slots of a material have textures, but for the one of its opacity, which rays look up: a bit each.
fn textured_slots(material: u32) -> u32 {
    return bitcast<u32>(load_slot_numbers(material).w) >> OPACITY_BITS;
}

/// Normal scale, opacity, cutoff, mode and textured slots (as bits).
fn load_slot_numbers(material: u32) -> vec4<f32> {
    return scene[params.slots_at + material * SLOTS_STRIDE + SLOTS_STRIDE - 1u];
}

/// The texture in a slot at a point, RGBA; white where there is none.
fn slot_rgba(material: u32, slot: u32, uv0: vec2<f32>, uv1: vec2<f32>) -> vec4<f32> {
    let word = load_slot(material, slot);
    if (word == NONE) {
        return vec4<f32>(1.0);
    }
    return sample_texture(word >> 2u, uv0, uv1);
}

/// Its channel that the slot names; 1 where there is none.
fn slot_value(material: u32, slot: u32, uv0: vec2<f32>, uv1: vec2<f32>) -> f32 {
    let word = load_slot(material, slot);
    if (word == NONE) {
        return 1.0;
    }
    return sample_texture(word >> 2u, uv0, uv1)[word & 3u];
}
