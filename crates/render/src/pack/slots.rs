//! What of a material varies over the surface: a record of textures beside the material's own.

use midway_kernels::constants as k;
use midway_scene::{
    Channel, CoatNormal, ColorInput, ConductorFresnel, Material, MetallicRoughness, Opacity, Roughness,
    ScalarInput, Scene, Surface, Texture,
};

use super::{
    Word4,
    textures::{PackedImages, TextureTable},
};

/// A material's record: a texture and its channel for each input (`SLOT_*` in WGSL), then the scale of
/// the normal map, opacity, cutoff, and the mode with a bit for each slot to be looked up.
pub type Slots = [Word4; k::SLOTS_STRIDE as usize];

/// Collects a material's textures.
struct Writer<'a> {
    words: [u32; k::N_SLOTS as usize],
    scene: &'a Scene,
    images: &'a mut PackedImages,
    table: &'a mut TextureTable,
}

/// The record of a material's textures, and the `MATERIAL_*` flags that say what is in it.
pub fn pack_slots(
    scene: &Scene,
    material: &Material,
    images: &mut PackedImages,
    table: &mut TextureTable,
) -> (Slots, u32) {
    let mut writer = Writer { words: [k::NONE; k::N_SLOTS as usize], scene, images, table };
    writer.surface(&material.surface);
    writer.color(k::SLOT_EMISSION, &material.emission);
    let scale = material.normal_map.as_ref().map_or(0.0, |map| {
        writer.texture(k::SLOT_NORMAL, &map.texture, Channel::R);
        map.scale
    });
    let textured = writer.textured();
    let (opacity, cutoff, mode) = match &material.opacity {
        _ if is_absent(material) => (0.0, 0.0, k::OPACITY_BLEND),
        Opacity::Opaque => (1.0, 0.0, k::OPACITY_NONE),
        Opacity::Mask(input, cutoff) => (writer.scalar(k::SLOT_OPACITY, input), *cutoff, k::OPACITY_MASK),
        Opacity::Blend(input) => (writer.scalar(k::SLOT_OPACITY, input), 0.0, k::OPACITY_BLEND),
    };
    let flags = [(textured != 0, k::MATERIAL_TEXTURED), (mode != k::OPACITY_NONE, k::MATERIAL_CUTOUT)];
    let flags = flags.iter().filter(|(set, _)| *set).fold(0, |all, (_, flag)| all | flag);
    let mut record = Slots::default();
    record.as_flattened_mut()[..writer.words.len()].copy_from_slice(&writer.words);
    record[k::SLOTS_STRIDE as usize - 1] =
        [scale.to_bits(), opacity.to_bits(), cutoff.to_bits(), mode | textured << k::OPACITY_BITS];
    (record, flags)
}

/// Whether rays of every kind pass a material everywhere.
pub fn is_absent(material: &Material) -> bool {
    material.surface == Surface::Null && !material.is_emissive()
}

impl Writer<'_> {
    /// A bit for each slot that has a texture.
    fn textured(&self) -> u32 {
        self.words
            .iter()
            .enumerate()
            .filter(|(_, word)| **word != k::NONE)
            .fold(0, |all, (i, _)| all | 1 << i)
    }

    fn texture(&mut self, slot: u32, texture: &Texture, channel: Channel) {
        let channel = match channel {
            Channel::R => 0,
            Channel::G => 1,
            Channel::B => 2,
            Channel::A => 3,
        };
        self.words[slot as usize] = self.table.index(self.images, self.scene, texture) << 2 | channel;
    }

    fn color(&mut self, slot: u32, input: &ColorInput) {
        if let Some(texture) = &input.texture {
            self.texture(slot, texture, Channel::R);
        }
    }

    fn scalar(&mut self, slot: u32, input: &ScalarInput) -> f32 {
        if let Some((texture, channel)) = &input.texture {
            self.texture(slot, texture, *channel);
        }
        input.value
    }

    fn roughness(&mut self, roughness: &Roughness) {
        self.scalar(k::SLOT_ROUGHNESS, &roughness.along);
        self.scalar(k::SLOT_ROUGHNESS_ACROSS, &roughness.across);
    }

    fn surface(&mut self, surface: &Surface) {
        match surface {
            Surface::Null => {}
            Surface::Diffuse { reflectance } => self.color(k::SLOT_COLOR, reflectance),
            Surface::Conductor { fresnel, roughness } => {
                match fresnel {
                    ConductorFresnel::Schlick { f0: color }
                    | ConductorFresnel::Complex { tint: color, .. } => {
                        self.color(k::SLOT_COLOR, color);
                    }
                }
                self.roughness(roughness);
            }
            Surface::Dielectric { reflection, transmission, roughness, .. } => {
                self.color(k::SLOT_COLOR, transmission);
                self.color(k::SLOT_SPECULAR_COLOR, reflection);
                self.roughness(roughness);
            }
            Surface::Plastic { reflectance, specular, roughness, .. } => {
                self.color(k::SLOT_COLOR, reflectance);
                self.color(k::SLOT_SPECULAR_COLOR, specular);
                self.roughness(roughness);
            }
            Surface::MetallicRoughness(model) => self.metallic_roughness(model),
        }
    }

    fn metallic_roughness(&mut self, model: &MetallicRoughness) {
        self.color(k::SLOT_COLOR, &model.base_color);
        self.color(k::SLOT_SPECULAR_COLOR, &model.specular_color);
        self.color(k::SLOT_SHEEN_COLOR, &model.sheen_color);
        for (slot, input) in [
            (k::SLOT_METALLIC, &model.metallic),
            (k::SLOT_ROUGHNESS, &model.roughness),
            (k::SLOT_ROUGHNESS_ACROSS, &model.roughness),
            (k::SLOT_SPECULAR, &model.specular),
            (k::SLOT_TRANSMISSION, &model.transmission),
            (k::SLOT_CLEARCOAT, &model.clearcoat),
            (k::SLOT_CLEARCOAT_ROUGHNESS, &model.clearcoat_roughness),
            (k::SLOT_SHEEN_ROUGHNESS, &model.sheen_roughness),
            (k::SLOT_ANISOTROPY, &model.anisotropy),
        ] {
            self.scalar(slot, input);
        }
        if let CoatNormal::Map(map) = &model.clearcoat_normal {
            self.texture(k::SLOT_CLEARCOAT_NORMAL, &map.texture, Channel::R);
        }
        if let Some(texture) = &model.anisotropy_direction {
            self.texture(k::SLOT_ANISOTROPY_DIRECTION, texture, Channel::R);
        }
    }
}
