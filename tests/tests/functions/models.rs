//! Every model at several parameters: what the tests of scattering go through.

use midway_kernels::native::lib::{self, Material, RawMaterial};
use wgsl_cpu::runtime::{Vec2, Vec3, Vec4};

use crate::support::{finish, raw};

/// A material, and what it should do with light.
pub struct Model {
    pub name: String,
    pub material: Material,
    /// What a white furnace may take from it, or NAN where it absorbs on purpose.
    pub loss: f64,
    /// What it may add.
    pub gain: f64,
}

fn model(name: &str, raw: RawMaterial, loss: f64) -> Model {
    Model { name: name.to_owned(), material: finish(raw), loss, gain: 0.02 }
}

fn rough(raw: RawMaterial, along: f32, across: f32) -> RawMaterial {
    RawMaterial { roughness: Vec2::new(along, across), ..raw }
}

fn solid(raw: RawMaterial, ior: f32) -> RawMaterial {
    RawMaterial { ior, flags: raw.flags | lib::MATERIAL_INSIDE, ..raw }
}

fn stretched(raw: RawMaterial, strength: f32) -> RawMaterial {
    RawMaterial { k_or_coat: Vec3::new(0.0, 0.0, strength), ..raw }
}

fn coated(raw: RawMaterial, coat: f32, coat_roughness: f32) -> RawMaterial {
    RawMaterial { k_or_coat: Vec3::new(coat, coat_roughness, 0.0), ..raw }
}

fn coated_apart(raw: RawMaterial, coat: f32, coat_roughness: f32) -> RawMaterial {
    let raw = coated(raw, coat, coat_roughness);
    RawMaterial { flags: raw.flags | lib::MATERIAL_COAT_NORMAL, ..raw }
}

/// All of them, none of them smooth alone.
pub fn all() -> Vec<Model> {
    let white = |kind| raw(kind);
    let (metal, glass, plastic) =
        (white(lib::SURFACE_CONDUCTOR), white(lib::SURFACE_DIELECTRIC), white(lib::SURFACE_PLASTIC));
    let pbr = RawMaterial { flags: lib::MATERIAL_SQUARED, ..white(lib::SURFACE_METALLIC_ROUGHNESS) };
    let clear = RawMaterial { transmission: 1.0, ..pbr };
    let copper = RawMaterial {
        flags: lib::MATERIAL_COMPLEX,
        eta_or_sheen: Vec4::new(0.2, 0.92, 1.1, 0.0),
        k_or_coat: Vec3::new(3.91, 2.45, 2.14),
        ..metal
    };
    let velvet = RawMaterial { eta_or_sheen: Vec4::new(1.0, 1.0, 1.0, 0.7), ..pbr };
    let brushed = RawMaterial {
        metallic: 1.0,
        k_or_coat: Vec3::new(0.0, 0.0, 0.6),
        rotation: Vec2::new(0.8, 0.6),
        ..pbr
    };
    let red = RawMaterial { color: Vec3::new(0.9, 0.4, 0.1), ..plastic };
    let once = lib::MATERIAL_NONLINEAR | lib::MATERIAL_SINGLE_BOUNCE;
    vec![
        model("metal 0.2", rough(metal, 0.2, 0.2), 0.02),
        model("metal 0.5", rough(metal, 0.5, 0.5), 0.02),
        model("metal 1", rough(metal, 1.0, 1.0), 0.02),
        model("metal 0.2 by 0.5", rough(metal, 0.2, 0.5), 0.02),
        model("copper 0.3", rough(copper, 0.3, 0.3), f64::NAN),
        model("glass 0.2", rough(solid(glass, 1.5), 0.2, 0.2), 0.02),
        model("glass 0.6", rough(solid(glass, 1.5), 0.6, 0.6), 0.02),
        model("glass 1", rough(solid(glass, 1.5), 1.0, 1.0), 0.02),
        model("diamond 0.4", rough(solid(glass, 2.4), 0.4, 0.4), 0.02),
        model("bubble 0.4", rough(solid(glass, 1.0 / 1.33), 0.4, 0.4), 0.02),
        model("sheet 0.3", rough(glass, 0.3, 0.3), 0.02),
        model("sheet 0.9", rough(glass, 0.9, 0.9), 0.02),
        model("plastic 0", plastic, 0.02),
        model("plastic 0.3", rough(plastic, 0.3, 0.3), 0.02),
        model("plastic 0.8", rough(plastic, 0.8, 0.8), 0.02),
        model("red plastic", RawMaterial { flags: lib::MATERIAL_NONLINEAR, ..red }, f64::NAN),
        model("plastic 0.6 of single bounces", RawMaterial { flags: once, ..rough(red, 0.6, 0.6) }, f64::NAN),
        model("dielectric, roughness 0", pbr, 0.02),
        model("dielectric, roughness 0.5", rough(pbr, 0.5, 0.5), 0.02),
        model("dielectric, roughness 1", rough(pbr, 1.0, 1.0), 0.02),
        model("half metal", RawMaterial { metallic: 0.5, ..rough(pbr, 0.7, 0.7) }, 0.02),
        model("brushed", rough(brushed, 0.5, 0.5), 0.02),
        model("brushed hard", rough(stretched(brushed, 0.9), 0.4, 0.4), 0.02),
        model("brushed dielectric", RawMaterial { metallic: 0.0, ..rough(brushed, 0.5, 0.5) }, 0.02),
        model("plastic 0.2 by 0.6", rough(plastic, 0.2, 0.6), 0.02),
        model("coat 0 on dielectric", coated(rough(pbr, 0.6, 0.6), 1.0, 0.0), 0.02),
        model(
            "coat 0.5 on metal",
            coated(RawMaterial { metallic: 1.0, ..rough(pbr, 0.7, 0.7) }, 1.0, 0.5),
            0.02,
        ),
        model("velvet", rough(velvet, 0.8, 0.8), 0.02),
        model("thin, roughness 0.6", rough(clear, 0.6, 0.6), 0.02),
        model("thin under a coat", coated(rough(clear, 0.6, 0.6), 1.0, 0.0), 0.02),
        model("thin under velvet", RawMaterial { transmission: 1.0, ..rough(velvet, 0.6, 0.6) }, 0.02),
        model("half thin", RawMaterial { transmission: 0.5, ..rough(clear, 0.6, 0.6) }, 0.02),
        model("volume, roughness 0.6", rough(solid(clear, 1.5), 0.6, 0.6), 0.02),
        model("coated thin, smooth", coated(RawMaterial { transmission: 0.5, ..clear }, 0.7, 0.0), 0.02),
        model("coat 0 apart on dielectric", coated_apart(rough(pbr, 0.6, 0.6), 1.0, 0.0), 0.02),
        model(
            "coat 0.5 apart on metal",
            coated_apart(RawMaterial { metallic: 1.0, ..rough(pbr, 0.7, 0.7) }, 1.0, 0.5),
            0.02,
        ),
        model(
            "coat 0.4 apart, thin, smooth",
            coated_apart(RawMaterial { transmission: 0.5, ..clear }, 0.7, 0.4),
            0.02,
        ),
        model("coat 0.3 apart on velvet", coated_apart(rough(velvet, 0.8, 0.8), 0.8, 0.3), 0.02),
        model("glass 0.2 by 0.6", rough(solid(glass, 1.5), 0.2, 0.6), 0.02),
        model("bubble 0.7 by 0.3", rough(solid(glass, 1.0 / 1.33), 0.7, 0.3), 0.02),
        model("brushed volume", rough(stretched(solid(clear, 1.5), 0.7), 0.5, 0.5), 0.02),
    ]
}
