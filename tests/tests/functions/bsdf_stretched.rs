//! White surfaces of facets of two α in a white furnace, over all that they may be.

use glam::DVec3;
use midway_kernels::native::lib::{self, Material, RawMaterial};
use midway_tests::{statistics::Estimate, stretched_solid::Boundary};
use wgsl_cpu::runtime::{Vec2, Vec3, Vec4};

use crate::support::{Random, double, finish, raw, single};

/// What a furnace may take or add: the table is within 0.01 of what facets lose, and the rest is room for
/// what lies between its entries.
const TOLERANCE: f64 = 0.02;
/// What solids may take or add where the smaller α is under a tenth of the larger: their losses change
/// suddenly at the edge of total reflection.
const TOLERANCE_AT_EDGES: f64 = 0.03;
/// Cells along each side of the square of numbers that a loss is computed from.
const CELLS: usize = 96;
/// Samples of an albedo: its standard error is under a hundredth.
const N: usize = 3_000;
/// And of one that was found off.
const N_AGAIN: usize = 100_000;
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

fn albedo(material: Material, wo: DVec3, mode: u32, n: usize, random: &mut Random) -> Estimate {
    let place = lib::Frame { tangent: single(DVec3::X), ..crate::support::frame(DVec3::Z, DVec3::Z) };
    let weights: Vec<f64> = (0..n)
        .map(|_| {
            let sampled = lib::bsdf_sample(material, place, single(wo), random.unit3(), mode);
            let weight = if sampled.pdf > 0.0 { double(sampled.weight).max_element() } else { 0.0 };
            // In a furnace radiance is as the square of the index where it is.
            let bent = sampled.transmitted && lib::bends(material) && mode == lib::TRANSPORT_RADIANCE;
            let eta = f64::from(lib::relative_index(material, wo.z > 0.0));
            if bent { weight * eta * eta } else { weight }
        })
        .collect();
    Estimate::of(&weights)
}

/// Where a surface is not white, by more than the tolerance and 3 standard errors; of what bends from both
/// sides.
fn not_white(material: Material, tolerance: f64, random: &mut Random) -> Vec<String> {
    let mut found = Vec::new();
    let sides: &[f64] = if lib::bends(material) { &[1.0, -1.0] } else { &[1.0] };
    for (cosine, azimuth) in COSINES.iter().flat_map(|&c| AZIMUTHS.map(|a| (c, a))) {
        for (&side, mode) in sides.iter().flat_map(|side| MODES.map(|mode| (side, mode))) {
            let above = wo(cosine, azimuth);
            let mut of = |n| albedo(material, DVec3 { z: side * above.z, ..above }, mode, n, random);
            let is_white = |a: &Estimate| (a.mean - 1.0).abs() <= tolerance + 3.0 * a.standard_error;
            if is_white(&of(N)) {
                continue;
            }
            // Of ten thousand means some are off by chance, so one that is off is estimated anew.
            let again = of(N_AGAIN);
            if !is_white(&again) {
                let error = 3.0 * again.standard_error;
                found.push(format!("{:.4} +- {error:.4} at {}, {azimuth}°", again.mean, side * cosine));
            }
        }
    }
    found
}

/// Solid glass of two α.
fn glass(alpha: (f64, f64), ior: f64) -> RawMaterial {
    RawMaterial {
        flags: lib::MATERIAL_INSIDE,
        roughness: Vec2::new(alpha.0 as f32, alpha.1 as f32),
        ior: ior as f32,
        ..raw(lib::SURFACE_DIELECTRIC)
    }
}

/// The larger α first, and the denser index over the rarer.
fn boundary(alpha: (f64, f64), ior: f64) -> Boundary {
    Boundary { alpha: [alpha.0.max(alpha.1), alpha.0.min(alpha.1)], n: ior.max(1.0 / ior) }
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
    // Solids that lose as of one α, as of another index, and that give back by the means of another.
    let solid = finish(glass((1.0, 0.04), 1.5));
    let mut of_one = solid;
    of_one.curves = finish(glass((0.52, 0.5199), 1.5)).curves;
    let mut of_diamond = solid;
    of_diamond.curves = finish(glass((1.0, 0.04), 2.4)).curves;
    let mut back = solid;
    back.ms_transmit = finish(glass((0.5, 0.04), 1.5)).ms_transmit;
    // Layers that keep what they hold back, and that hold back as over other facets.
    let coated = RawMaterial { k_or_coat: Vec3::new(1.0, 0.0, 1.0), ..brushed(0.2, 1.0, 1.0) };
    let mut kept = finish(coated);
    kept.held_back = Vec3::splat(0.0);
    let over_one = RawMaterial { k_or_coat: Vec3::new(1.0, 0.0, 0.0), ..brushed(0.2, 0.0, 1.0) };
    let mut as_of_one = finish(coated);
    (as_of_one.held_back, as_of_one.curves.held) = (finish(over_one).held_back, finish(over_one).curves.held);
    for (name, other) in [
        ("what layers hold back is kept", kept),
        ("held back as over one α", as_of_one),
        ("across", swapped),
        ("by azimuth", by_azimuth),
        ("by mean", by_mean),
        ("solid of one α", of_one),
        ("solid of diamond", of_diamond),
        ("solid by another mean", back),
    ] {
        let found = not_white(other, TOLERANCE, &mut random);
        println!("{name}: {}: {:?}", found.len(), found.first());
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
        assert_white(&about("dielectric"), plain, TOLERANCE, &mut random);
        assert_white(&about("thin"), RawMaterial { transmission: 1.0, ..plain }, TOLERANCE, &mut random);
        let alpha = lib::interface_alpha(plain);
        let plastic = RawMaterial { roughness: alpha, ..raw(lib::SURFACE_PLASTIC) };
        assert_white(&about("plastic"), plastic, TOLERANCE, &mut random);
    }
}

/// Facets that lose next to nothing but close to grazing, of one α: what is given back there is a small
/// number over another.
#[test]
fn nearly_smooth_surfaces_are_white() {
    let mut random = Random::new(125);
    for alpha in [0.002, 0.0045, 0.01, 0.02, 0.03, 0.05, 0.07] {
        let rough = |kind| RawMaterial { roughness: Vec2::splat(alpha), ..raw(kind) };
        let metal = rough(lib::SURFACE_CONDUCTOR);
        assert_white(&format!("metal {alpha}"), metal, TOLERANCE, &mut random);
        assert_white(&format!("plastic {alpha}"), rough(lib::SURFACE_PLASTIC), TOLERANCE, &mut random);
        assert_white(&format!("sheet {alpha}"), rough(lib::SURFACE_DIELECTRIC), TOLERANCE, &mut random);
        for ior in [1.0 / 1.33, 1.5, 2.4] {
            let solid = glass((f64::from(alpha), f64::from(alpha)), ior);
            assert_white(&format!("glass {alpha}, {ior}"), solid, TOLERANCE, &mut random);
        }
        let pbr = RawMaterial { metallic: 0.0, ..rough(lib::SURFACE_METALLIC_ROUGHNESS) };
        assert_white(&format!("dielectric {alpha}"), pbr, TOLERANCE, &mut random);
    }
}

/// Coats, sheens, and the one over the other, on facets of one α and of two.
#[test]
fn metals_under_layers_are_white() {
    let mut random = Random::new(124);
    let coat = |roughness| (Vec4::splat(0.0), 1.0, roughness);
    let sheen = |colour: f32, roughness| (Vec4::new(colour, colour, colour, roughness), 0.0, 0.0);
    let layers = [
        ("smooth coat", coat(0.0)),
        ("coat 0.2", coat(0.2)),
        ("coat 0.5", coat(0.5)),
        ("half a coat", (Vec4::splat(0.0), 0.5, 0.1)),
        ("sheen 0.2", sheen(1.0, 0.2)),
        ("sheen 0.3", sheen(1.0, 0.3)),
        ("sheen 0.7", sheen(0.5, 0.7)),
        ("coat 0.1 and sheen 0.5", (Vec4::new(0.8, 0.8, 0.8, 0.5), 1.0, 0.1)),
    ];
    let mut failed = Vec::new();
    for roughness in [0.1, 0.14, 0.3, 0.55, 0.8, 1.0] {
        for strength in [0.0, 0.4, 0.8, 1.0] {
            for (name, (eta_or_sheen, coat, coat_roughness)) in layers {
                let metal = brushed(roughness, strength, 1.0);
                let k_or_coat = Vec3::new(coat, coat_roughness, strength);
                let layered = RawMaterial { eta_or_sheen, k_or_coat, ..metal };
                let found = not_white(finish(layered), TOLERANCE, &mut random);
                if !found.is_empty() {
                    failed.push(format!(
                        "{name} on metal, roughness {roughness}, strength {strength}: {found:?}"
                    ));
                }
            }
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

/// Pairs of α: of KHR_materials_anisotropy (roughness and strength 0.2 and 1, 0.5 and 0.7, 0.2 and 0.5, 0.7
/// and 0.9), and others, of which the larger may be either.
const SOLID_ALPHAS: [(f64, f64); 13] = [
    (1.0, 0.04),
    (1.0, 0.0025),
    (0.6175, 0.25),
    (0.28, 0.04),
    (0.907, 0.49),
    (0.02, 0.1),
    (0.1, 0.02),
    (0.05, 0.7),
    (0.3, 0.27),
    (0.1, 0.5),
    (0.02, 0.01),
    (0.006, 0.005),
    (0.005, 0.001),
];
const INDICES: [f64; 7] = [1.1, 1.2, 1.33, 1.5, 1.8, 2.1, 2.5];

/// By how much the stored means of the losses, from the rarer side and from the denser, are under the
/// losses' means: what is given back is the loss times one of them.
fn mean_ratios(material: Material) -> [f64; 2] {
    let [cells, azimuths] = [400, 16];
    let place = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
    let n = cells * azimuths;
    let stored = [material.curves.stretch.z, material.curves.stretch.w].map(|root| f64::from(root).powi(4));
    [false, true].map(|dense| {
        let of = |i: usize| {
            let root = place(i % cells, cells);
            let w = wo(root * root, 90.0 * place(i / cells, azimuths));
            4.0 * root.powi(3) * f64::from(lib::loss_at(material, !dense, single(w)))
        };
        (0..n).map(of).sum::<f64>() / n as f64 / stored[usize::from(dense)]
    })
}

/// What is given back, on either side and whichever of them is the denser, against what is lost by
/// quadrature.
#[test]
fn solids_give_back_what_quadrature_says_is_lost() {
    for alpha in SOLID_ALPHAS {
        let mut worst = [(0.0, String::new()), (0.0, String::new())];
        for n in INDICES {
            let [below, above] = [n, 1.0 / n].map(|ior| finish(glass(alpha, ior)));
            let ratios = mean_ratios(below);
            let boundary = boundary(alpha, n);
            for (cosine, azimuth) in COSINES.iter().flat_map(|&c| AZIMUTHS.map(|a| (c, a))) {
                let larger_along = wo(cosine, azimuth);
                let turned = DVec3::new(larger_along.y, larger_along.x, larger_along.z);
                let w = single(if alpha.0 > alpha.1 { larger_along } else { turned });
                for dense in [false, true] {
                    let loss = boundary.loss(larger_along, dense, CELLS);
                    let found =
                        [lib::loss_at(below, !dense, w), lib::loss_at(above, dense, w)].map(f64::from);
                    assert!((found[0] - found[1]).abs() <= 2e-5, "either side is as the other: {found:?}");
                    let error =
                        ratios.map(|ratio| (ratio * found[0] - loss).abs()).into_iter().fold(0.0, f64::max);
                    let side = &mut worst[usize::from(dense)];
                    if error > side.0 || error.is_nan() {
                        *side =
                            (error, format!("{loss:.3} is {error:.4} off at n {n}, {cosine}, {azimuth}°"));
                    }
                }
            }
        }
        println!("{alpha:?}: {worst:?}");
        let edge = alpha.0.min(alpha.1) < 0.1 * alpha.0.max(alpha.1);
        let tolerance = if edge { TOLERANCE_AT_EDGES } else { TOLERANCE };
        assert!(worst.iter().all(|(error, _)| *error <= tolerance), "α {alpha:?}: {worst:?}");
    }
}

/// From both sides and in both modes.
#[test]
fn stretched_solids_are_white() {
    let mut random = Random::new(124);
    for alpha in [(1.0, 0.04), (0.6175, 0.25), (0.04, 0.28), (0.907, 0.49), (0.02, 0.1)] {
        for ior in [1.1, 1.5, 1.0 / 1.5, 2.5] {
            let name = format!("glass {alpha:?}, index {ior}");
            let edge = alpha.1 < 0.1 * alpha.0;
            let tolerance = if edge { TOLERANCE_AT_EDGES } else { TOLERANCE };
            assert_white(&name, glass(alpha, ior), tolerance, &mut random);
        }
    }
}
