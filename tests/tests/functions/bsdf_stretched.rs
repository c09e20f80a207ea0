//! White surfaces of facets of two α in a white furnace, over all that they may be.

use glam::DVec3;
use midway_kernels::native::lib::{self, Material, RawMaterial};
use midway_tests::statistics::Estimate;
use wgsl_cpu::runtime::{Vec2, Vec3, Vec4};

use crate::support::{Random, double, finish, raw, single};

/// What a furnace may take or add: the table is within 0.01 of what facets lose, and the rest is room for
/// what lies between its entries.
const TOLERANCE: f64 = 0.02;
/// The same of dielectrics and plastic, whose base is lit by what their facets let through: that is known
/// within 0.04 where the smaller α is under an eighth of the larger.
const TOLERANCE_OF_BASES: f64 = 0.04;
/// The same of metals under a coat or a sheen: `layers_between` shares out what those let through by one α
/// for facets of both, and falls short towards grazing by 0.035 and 0.067 (by 0.01 where there is one α).
const TOLERANCE_OF_LAYERS: f64 = 0.08;
/// Samples of an albedo: its standard error is under a hundredth.
const N: usize = 3_000;
const MODES: [u32; 2] = [lib::TRANSPORT_RADIANCE, lib::TRANSPORT_IMPORTANCE];
const COSINES: [f64; 6] = [0.03, 0.1, 0.2, 0.45, 0.75, 1.0];
/// Degrees from the direction of the larger α.
const AZIMUTHS: [f64; 6] = [0.0, 25.0, 50.0, 70.0, 83.0, 90.0];

/// Metallic-roughness, white, of a roughness and a strength of anisotropy.
fn brushed(roughness: f32, strength: f32, metallic: f32) -> RawMaterial {
    RawMaterial {
        flags: lib::MATERIAL_SQUARED,
        roughness: Vec2::splat(roughness),
        metallic,
        k_or_coat: Vec3::new(0.0, 0.0, strength),
        ..raw(lib::SURFACE_METALLIC_ROUGHNESS)
    }
}

fn wo(cosine: f64, degrees: f64) -> DVec3 {
    midway_tests::stretched::direction(cosine, degrees.to_radians())
}

fn albedo(material: Material, wo: DVec3, mode: u32, random: &mut Random) -> Estimate {
    let place = lib::Frame { tangent: single(DVec3::X), ..crate::support::frame(DVec3::Z, DVec3::Z) };
    let weights: Vec<f64> = (0..N)
        .map(|_| {
            let sampled = lib::bsdf_sample(material, place, single(wo), random.unit3(), mode);
            if sampled.pdf > 0.0 { double(sampled.weight).max_element() } else { 0.0 }
        })
        .collect();
    Estimate::of(&weights)
}

/// Where a surface is not white, by more than the tolerance and 3 standard errors.
fn not_white(material: Material, tolerance: f64, random: &mut Random) -> Vec<String> {
    let mut found = Vec::new();
    for (cosine, azimuth) in COSINES.iter().flat_map(|&c| AZIMUTHS.map(|a| (c, a))) {
        for mode in MODES {
            let albedo = albedo(material, wo(cosine, azimuth), mode, random);
            let error = 3.0 * albedo.standard_error;
            let is_white = (albedo.mean - 1.0).abs() <= tolerance + error;
            if !is_white {
                found.push(format!("{:.4} +- {error:.4} at {cosine}, {azimuth}°", albedo.mean));
            }
        }
    }
    found
}

fn assert_white(name: &str, raw: RawMaterial, tolerance: f64, random: &mut Random) {
    let found = not_white(finish(raw), tolerance, random);
    assert!(found.is_empty(), "{name}: {found:?}");
}

/// A metal that loses across what another does along, one blended by the azimuth alone, and one that gives
/// back as much as facets of one α would.
#[test]
fn other_losses_are_rejected() {
    let mut random = Random::new(123);
    let metal = finish(brushed(0.2, 1.0, 1.0));
    let mut swapped = metal;
    swapped.curves.across = finish(brushed(0.2, 0.5, 1.0)).curves.a;
    let mut by_azimuth = metal;
    by_azimuth.curves.stretch.x = 1.0;
    // As it was before there was a table of two α: that of the mean.
    let one = finish(RawMaterial { roughness: Vec2::splat(0.52), ..raw(lib::SURFACE_CONDUCTOR) });
    let mut by_mean = metal;
    by_mean.ms_front = one.ms_front;
    for (name, other) in [("across", swapped), ("by azimuth", by_azimuth), ("by mean", by_mean)] {
        let found = not_white(other, TOLERANCE, &mut random);
        println!("{name}: {} of {}: {:?}", found.len(), 2 * COSINES.len() * AZIMUTHS.len(), found.first());
        assert!(!found.is_empty(), "{name} passes for white");
    }
}

#[test]
fn stretched_metals_are_white() {
    let mut random = Random::new(120);
    for roughness in [0.05, 0.2, 0.35, 0.5, 0.7, 0.9] {
        for strength in [0.1, 0.3, 0.5, 0.7, 0.85, 1.0] {
            let name = format!("metal, roughness {roughness}, strength {strength}");
            assert_white(&name, brushed(roughness, strength, 1.0), TOLERANCE, &mut random);
        }
    }
}

/// The larger α may be either.
#[test]
fn metals_of_two_roughnesses_are_white() {
    let mut random = Random::new(121);
    for (along, across) in [(0.02, 0.1), (0.1, 0.02), (0.05, 0.9), (0.9, 0.05), (0.4, 0.6), (0.001, 1.0)] {
        let metal = RawMaterial { roughness: Vec2::new(along, across), ..raw(lib::SURFACE_CONDUCTOR) };
        assert_white(&format!("metal {along} by {across}"), metal, TOLERANCE, &mut random);
    }
}

/// What is below stretched facets, beside them, or over them.
#[test]
fn stretched_surfaces_of_other_kinds_are_white() {
    let mut random = Random::new(122);
    for (roughness, strength) in [(0.2, 1.0), (0.3, 0.7), (0.6, 0.9), (0.4, 0.3), (0.5, 0.0)] {
        let about = |kind: &str| format!("{kind}, roughness {roughness}, strength {strength}");
        let plain = brushed(roughness, strength, 0.0);
        let metal = brushed(roughness, strength, 1.0);
        assert_white(&about("dielectric"), plain, TOLERANCE_OF_BASES, &mut random);
        assert_white(&about("thin"), RawMaterial { transmission: 1.0, ..plain }, TOLERANCE, &mut random);
        let alpha = lib::interface_alpha(plain);
        let plastic = RawMaterial { roughness: alpha, ..raw(lib::SURFACE_PLASTIC) };
        assert_white(&about("plastic"), plastic, TOLERANCE_OF_BASES, &mut random);
        let coated = RawMaterial { k_or_coat: Vec3::new(1.0, 0.5, strength), ..metal };
        assert_white(&about("coat 0.5 on metal"), coated, TOLERANCE_OF_LAYERS, &mut random);
        let velvet = RawMaterial { eta_or_sheen: Vec4::new(0.5, 0.5, 0.5, 0.7), ..metal };
        assert_white(&about("sheen on metal"), velvet, TOLERANCE_OF_LAYERS, &mut random);
    }
}
