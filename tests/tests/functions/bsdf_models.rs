//! Every model, from both sides and in both modes: reciprocity, energy, samples against densities,
//! chances of delta lobes.

use glam::DVec3;
use midway_kernels::native::lib::{self, Frame, Material};
use midway_tests::statistics::Estimate;
use wgsl_cpu::runtime::Vec3;

use crate::{
    chi_square::{Cap, ChiSquare},
    models,
    support::{Random, assert_near, bsdf_eval, bsdf_pdf, double, frame, single},
};

const MODES: [u32; 2] = [lib::TRANSPORT_RADIANCE, lib::TRANSPORT_IMPORTANCE];
/// Directions of a chi-square test.
const N: u64 = 60_000;
/// Samples of an albedo: its standard error is a few thousandths.
const N_ALBEDO: usize = 8_000;

fn random_frame(random: &mut Random, tilt: f64) -> Frame {
    let ng = random.direction();
    let ns = if tilt > 0.0 { random.tilted(ng, tilt) } else { ng };
    frame(ng, ns)
}

/// wo at a cosine to ng, on the front where it is positive.
fn seen_at(place: Frame, cosine: f64) -> DVec3 {
    let ng = double(place.ng);
    let (x, y) = (ng.any_orthonormal_vector(), ng.cross(ng.any_orthonormal_vector()));
    (ng * cosine + (x * 0.6 + y * 0.8) * (1.0 - cosine * cosine).sqrt()).normalize()
}

fn index_at(material: &Material, place: Frame, wo: DVec3) -> f64 {
    f64::from(lib::relative_index(*material, double(place.ng).dot(wo) > 0.0))
}

/// Where normals do not lean f(wo, wi) = f(wi, wo), and transmission's modes differ by η²; where they do,
/// by the mode of the path that comes from the other end, which finds all light that is scattered.
#[test]
fn models_are_reciprocal() {
    let mut random = Random::new(90);
    for model in models::all() {
        let mut n_transmitted = 0;
        for i in 0..4000 {
            let leans = i % 2 == 1;
            let place = random_frame(&mut random, if leans { 0.7 } else { 0.0 });
            let (wo, wi) = (random.direction(), random.direction());
            let f = |wo, wi, mode| double(bsdf_eval(model.material, place, single(wo), single(wi), mode));
            let [radiance, importance] = MODES.map(|mode| f(wo, wi, mode));
            let reverse = f(wi, wo, lib::TRANSPORT_IMPORTANCE);
            assert_eq!(radiance, reverse, "{}", model.name);
            let pdfs = [(wo, wi, MODES[0]), (wi, wo, MODES[1])]
                .map(|(from, to, mode)| bsdf_pdf(model.material, place, single(from), single(to), mode));
            assert!(
                radiance.max_element() == 0.0 || pdfs.iter().all(|&pdf| pdf > 0.0),
                "{}: light without a density, {pdfs:?}",
                model.name
            );
            // Seen from along the surface the normal is turned towards the eye.
            let along = [wo, wi].iter().any(|w| double(place.ng).dot(*w).abs() < 1e-3);
            if leans || along {
                continue;
            }
            let crosses = double(place.ng).dot(wo) * double(place.ng).dot(wi) < 0.0;
            let bends = crosses && lib::bends(model.material);
            let eta = if bends { index_at(&model.material, place, wo) } else { 1.0 };
            let error = (importance - radiance * eta * eta).abs().max_element();
            assert!(
                error <= 4e-3 * importance.max_element() + 1e-5,
                "{}: {radiance} and {importance}, by η²",
                model.name
            );
            n_transmitted += usize::from(crosses && importance.max_element() > 0.0);
        }
        let transmits = model.material.transmit.x > 0.0 && model.material.alpha.x > 0.0;
        assert_eq!(n_transmitted > 100, transmits, "{}: {n_transmitted}", model.name);
    }
}

/// A furnace: no more comes out than goes in, and of white no less than the model's bound.
#[test]
fn models_keep_energy() {
    let mut random = Random::new(91);
    for model in models::all() {
        let place = random_frame(&mut random, 0.0);
        for cosine in [0.97, 0.6, 0.25, -0.25, -0.6, -0.97] {
            let wo = single(seen_at(place, cosine));
            let weights: Vec<f64> = (0..N_ALBEDO)
                .map(|_| {
                    let u = random.unit3();
                    let sampled = lib::bsdf_sample(model.material, place, wo, u, lib::TRANSPORT_IMPORTANCE);
                    if sampled.pdf > 0.0 { double(sampled.weight).max_element() } else { 0.0 }
                })
                .collect();
            let albedo = Estimate::of(&weights);
            let (low, high) = (1.0 - model.loss, 1.0 + model.gain);
            let error = 3.0 * albedo.standard_error;
            println!("{} at {cosine}: {:.4} +- {:.4}", model.name, albedo.mean, albedo.standard_error);
            assert!(albedo.mean <= high + error, "{} at {cosine}: {}", model.name, albedo.mean);
            assert!(
                model.loss.is_nan() || albedo.mean >= low - error,
                "{} at {cosine}: {}",
                model.name,
                albedo.mean
            );
        }
    }
}

/// A sample weighs f cos / pdf with the density it carries, and ends on the side that it says.
#[test]
fn samples_carry_their_own_density_and_weight() {
    let mut random = Random::new(92);
    for model in models::all() {
        for i in 0..3000u32 {
            let place = random_frame(&mut random, 0.4);
            let (wo, mode) = (random.direction(), MODES[i as usize % 2]);
            let sampled = lib::bsdf_sample(model.material, place, single(wo), random.unit3(), mode);
            if sampled.pdf == 0.0 {
                continue;
            }
            let wi = double(sampled.wi);
            let sides = double(place.ng).dot(wi) * double(place.ng).dot(double(single(wo)));
            assert_eq!(sampled.transmitted, sides < 0.0, "{}: {sampled:?}", model.name);
            if sampled.is_delta {
                continue;
            }
            let pdf = bsdf_pdf(model.material, place, single(wo), sampled.wi, mode);
            assert_near(f64::from(sampled.pdf / pdf), 1.0, 1e-5, &model.name);
            let other = lib::TRANSPORT_IMPORTANCE - mode;
            let reverse = bsdf_pdf(model.material, place, sampled.wi, single(wo), other);
            assert_near(
                f64::from(sampled.pdf_rev),
                f64::from(reverse),
                1e-5 * f64::from(reverse),
                &model.name,
            );
            let f = double(bsdf_eval(model.material, place, single(wo), sampled.wi, mode));
            let expected = f * double(place.ng).dot(wi).abs();
            let error = (double(sampled.weight) * f64::from(pdf) - expected).abs().max_element();
            // f is large where the light's cosine is small; rounding of the other cosine is 1e-7.
            let tolerance = 1e-5 * (1.0 + expected.max_element()) + 4e-7 * f.max_element();
            assert!(error <= tolerance, "{}: weight", model.name);
        }
    }
}

fn test_directions(
    material: Material,
    sampled: Material,
    place: Frame,
    (wo, mode): (DVec3, u32),
    random: &mut Random,
) -> ChiSquare {
    let sample = || {
        let sampled = lib::bsdf_sample(sampled, place, single(wo), random.unit3(), mode);
        (sampled.pdf > 0.0 && !sampled.is_delta).then(|| double(sampled.wi))
    };
    let pdf = |wi: DVec3| f64::from(bsdf_pdf(material, place, single(wo), single(wi), mode));
    Cap::sphere().test(N, sample, pdf)
}

/// Directions have their density, whose integral is the chance of one: what is left is the chance of
/// a delta lobe or of none.
#[test]
fn directions_have_their_density() {
    let mut random = Random::new(93);
    for model in models::all() {
        for (cosine, tilt, mode) in
            [(0.8, 0.2, MODES[0]), (-0.4, 0.0, MODES[1]), (0.3, 0.7, MODES[0]), (0.3, 0.7, MODES[1])]
        {
            let place = random_frame(&mut random, tilt);
            let wo = seen_at(place, cosine);
            let test = test_directions(model.material, model.material, place, (wo, mode), &mut random);
            test.assert_holds(&format!("{} at {cosine}, leaning {tilt}", model.name));
        }
    }
}

#[test]
fn another_roughness_or_direction_is_rejected() {
    let mut random = Random::new(94);
    // Metals: of glass the chances of its lobes would still be those of the first roughness.
    let metals = models::all().into_iter().filter(|model| model.material.kind == lib::SURFACE_CONDUCTOR);
    for model in metals {
        let place = random_frame(&mut random, 0.0);
        let wo = seen_at(place, 0.7);
        let mut other = model.material;
        if other.alpha.x < 0.1 {
            continue; // too narrow for the quadrature at another roughness
        }
        let factor = if other.alpha.x > 0.6 { 0.75 } else { 1.6 };
        other.alpha = wgsl_cpu::runtime::Vec2::splat(factor * other.alpha.x);
        let seen = (wo, MODES[0]);
        test_directions(model.material, other, place, seen, &mut random).assert_rejects(&model.name);
    }
}

/// The chance of a delta lobe by its two factors.
fn delta_chance(material: Material, front: bool, mu: f32, reflects: bool) -> f64 {
    let met = lib::aspect_at(material, front, Vec3::new(0.0, 0.0, mu), mu);
    let chances = lib::lobe_chances(material, front, mu, met);
    let reflected = lib::reflection_chance(lib::interface_split(material, front, mu));
    f64::from(chances.facets * if reflects { reflected } else { 1.0 - reflected })
}

/// A delta event and its reverse have the same chance, by reflection and by transmission.
#[test]
fn delta_lobes_are_chosen_alike_in_reverse() {
    let glass = crate::support::glass([0.9; 3], 1.5);
    let sheet = crate::support::sheet([0.9; 3], 1.5);
    let mirror = crate::support::mirror([0.9; 3]);
    let mixed = models::all().into_iter().map(|model| model.material).filter(|m| m.alpha.x == 0.0);
    let mut random = Random::new(95);
    let mut n = [0; 2];
    for material in mixed.chain([glass, sheet, mirror]) {
        for _ in 0..500 {
            let place = random_frame(&mut random, 0.0);
            let wo = single(random.direction());
            let sampled = lib::bsdf_sample(material, place, wo, random.unit3(), lib::TRANSPORT_RADIANCE);
            if sampled.pdf == 0.0 || !sampled.is_delta {
                continue;
            }
            n[usize::from(sampled.transmitted)] += 1;
            let chance = |w: DVec3| {
                let cosine = w.dot(double(place.ng));
                delta_chance(material, cosine > 0.0, cosine.abs() as f32, !sampled.transmitted)
            };
            let (there, back) = (chance(double(wo)), chance(double(sampled.wi)));
            assert_near(there, back, 1e-4, "chance of a delta lobe");
        }
    }
    assert!(n.iter().all(|&n| n > 300), "{n:?}");
}
