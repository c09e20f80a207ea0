//! Scattering: directions against their density, choices of lobe against their chances.

use glam::DVec3;
use midway_kernels::native::lib::{self, Material};

use crate::{
    chi_square::{Cap, ChiSquare},
    support::{Random, assert_near, bsdf_eval, bsdf_pdf, diffuse, double, frame, glass, sheet, single},
};

const N: u64 = 400_000;

/// What scatters where: a material between its normals, seen from `wo`.
#[derive(Clone, Copy, Debug)]
struct Place {
    ng: DVec3,
    ns: DVec3,
    wo: DVec3,
}

impl Place {
    fn sample(&self, material: Material, random: &mut Random, mode: u32) -> lib::BsdfSample {
        lib::bsdf_sample(material, frame(self.ng, self.ns), single(self.wo), random.unit3(), mode)
    }

    fn pdf(&self, material: Material, wi: DVec3, mode: u32) -> f64 {
        f64::from(bsdf_pdf(material, frame(self.ng, self.ns), single(self.wo), single(wi), mode))
    }

    /// Places with the shading normal tilted by up to `tilt`, on both sides, grazing ones too.
    fn several(random: &mut Random, tilt: f64) -> Vec<Self> {
        let place = |(i, cosine): (usize, f64)| {
            let ng = random.direction();
            let ns = if tilt > 0.0 { random.tilted(ng, tilt) } else { ng };
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            let tangent = ng.any_orthonormal_vector();
            let wo = (ng * (side * cosine) + tangent * (1.0 - cosine * cosine).sqrt()).normalize();
            Self { ng, ns, wo }
        };
        [0.98, 0.7, 0.4, 0.3, 0.1, 0.05].into_iter().enumerate().map(place).collect()
    }

    fn test_diffuse(&self, random: &mut Random, mode: u32, pdf: impl Fn(DVec3) -> f64) -> ChiSquare {
        let sample = || {
            let sampled = self.sample(diffuse([0.5; 3]), random, mode);
            (sampled.pdf > 0.0).then(|| double(sampled.wi))
        };
        Cap::sphere().test(N, sample, pdf)
    }
}

#[test]
fn diffuse_directions_have_their_density() {
    let mut random = Random::new(30);
    for tilt in [0.0, 0.3, 0.7] {
        for place in Place::several(&mut random, tilt) {
            for mode in [lib::TRANSPORT_RADIANCE, lib::TRANSPORT_IMPORTANCE] {
                let pdf = |wi| place.pdf(diffuse([0.5; 3]), wi, mode);
                let test = place.test_diffuse(&mut random, mode, pdf);
                assert!(test.holds(), "{place:?}: {test}");
            }
        }
    }
}

#[test]
fn wrong_diffuse_densities_are_rejected() {
    let mut random = Random::new(31);
    let ng = DVec3::Z;
    let place = Place { ng, ns: random.tilted(ng, 0.5), wo: DVec3::new(0.6, 0.0, 0.8) };
    let about = |n: DVec3| move |wi: DVec3| wi.dot(n).max(0.0) / std::f64::consts::PI;
    let mut test = |pdf: &dyn Fn(DVec3) -> f64| place.test_diffuse(&mut random, lib::TRANSPORT_RADIANCE, pdf);
    test(&about(place.ng)).assert_rejects("cosine to the geometric normal");
    test(&about(place.ns)).assert_rejects("nothing rejected below the surface");
    let uniform = |wi: DVec3| if wi.z > 0.0 { 0.5 / std::f64::consts::PI } else { 0.0 };
    test(&uniform).assert_rejects("a uniform hemisphere");
}

/// The sample carries the density that `bsdf_pdf` gives, and its weight is f cos / pdf.
#[test]
fn diffuse_samples_carry_their_own_density_and_weight() {
    let mut random = Random::new(32);
    let material = diffuse([0.2, 0.5, 0.9]);
    for _ in 0..2000 {
        for place in Place::several(&mut random, 0.5) {
            let sampled = place.sample(material, &mut random, lib::TRANSPORT_IMPORTANCE);
            if sampled.pdf == 0.0 {
                continue;
            }
            assert!(!sampled.is_delta && !sampled.transmitted);
            let wi = double(sampled.wi);
            // Both are cosines of unit vectors over π, which rounding moves by some 1e-7.
            let pdf = place.pdf(material, wi, lib::TRANSPORT_IMPORTANCE);
            assert_near(f64::from(sampled.pdf), pdf, 2e-7, "pdf");
            let (at, wo) = (frame(place.ng, place.ns), single(place.wo));
            let reverse = bsdf_pdf(material, at, sampled.wi, wo, lib::TRANSPORT_RADIANCE);
            assert_near(f64::from(sampled.pdf_rev), f64::from(reverse), 2e-7, "reverse pdf");
            let f = double(bsdf_eval(material, at, wo, sampled.wi, lib::TRANSPORT_IMPORTANCE));
            let expected = f * double(at.ng).dot(wi).abs();
            let actual = double(sampled.weight) * f64::from(sampled.pdf);
            // f is over the cosine of the light, which wo leads to.
            let tolerance = 2e-7 / place.wo.dot(place.ng).abs();
            assert!(
                (actual - expected).abs().max_element() <= tolerance,
                "{place:?}: {actual}, not {expected}"
            );
        }
    }
}

/// How often a lobe is chosen: its chance, and what the sample then weighs.
#[test]
fn dielectrics_choose_lobes_by_fresnel() {
    let mut random = Random::new(33);
    for (ior, cos_o, side) in
        [(1.5, 0.9, 1.0), (1.5, 0.2, 1.0), (1.5, 0.9, -1.0), (2.4, 0.5, 1.0), (1.33, 0.05, 1.0)]
    {
        let place = face_on(cos_o, side);
        let material = glass([0.8, 0.9, 1.0], ior);
        let eta = if side > 0.0 { ior } else { 1.0 / ior };
        let chance = f64::from(lib::fresnel_dielectric(cos_o as f32, eta).x);
        let reflected = count_reflected(&place, material, &mut random);
        let expected = [chance * N as f64, (1.0 - chance) * N as f64];
        ChiSquare::of(&[reflected, N - reflected], &expected).assert_holds(&format!("{ior} at {cos_o}"));
        let swapped = [expected[1], expected[0]];
        ChiSquare::of(&[reflected, N - reflected], &swapped).assert_rejects("swapped chances");
    }
}

/// Both faces of a thin sheet, with all bounces between them summed one by one.
#[test]
fn thin_sheets_choose_lobes_by_the_series_of_their_bounces() {
    let mut random = Random::new(34);
    for (cos_o, side) in [(1.0, 1.0), (0.5, 1.0), (0.1, -1.0)] {
        let place = face_on(cos_o, side);
        let material = sheet([1.0; 3], 1.5);
        let r = f64::from(lib::fresnel_dielectric(cos_o as f32, 1.5).x);
        let series: f64 = r + (0..60).map(|i| (1.0 - r).powi(2) * r * r.powi(2 * i)).sum::<f64>();
        let reflected = count_reflected(&place, material, &mut random);
        let expected = [series * N as f64, (1.0 - series) * N as f64];
        ChiSquare::of(&[reflected, N - reflected], &expected).assert_holds(&format!("thin at {cos_o}"));
    }
}

fn face_on(cos_o: f64, side: f64) -> Place {
    let wo = DVec3::new((1.0 - cos_o * cos_o).sqrt(), 0.0, cos_o * side);
    Place { ng: DVec3::Z, ns: DVec3::Z, wo }
}

fn count_reflected(place: &Place, material: Material, random: &mut Random) -> u64 {
    (0..N)
        .filter(|_| {
            let sampled = place.sample(material, random, lib::TRANSPORT_RADIANCE);
            assert!(sampled.is_delta && sampled.pdf == 1.0, "{sampled:?}");
            !sampled.transmitted
        })
        .count() as u64
}
