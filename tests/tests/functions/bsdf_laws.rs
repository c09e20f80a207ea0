//! Laws that scattering keeps: energy, reciprocity, Fresnel and Snell, the right side of surfaces.

use glam::DVec3;
use midway_kernels::native::lib::{self, BsdfSample, Material, RawMaterial};
use midway_tests::statistics::Estimate;
use wgsl_cpu::runtime::{Vec2, Vec3};

use crate::support::{
    Random, assert_near, bsdf_eval, bsdf_pdf, diffuse, double, finish, frame, glass, mirror, raw, sheet,
    single,
};

/// Fresnel's equations in f64 from angles rather than cosines: reflectance, and transmittance from
/// its own amplitudes. None at total internal reflection.
fn fresnel(cos_i: f64, eta: f64) -> Option<(f64, f64)> {
    let sin_t = (1.0 - cos_i * cos_i).sqrt() / eta;
    if sin_t >= 1.0 {
        return None;
    }
    let cos_t = (1.0 - sin_t * sin_t).sqrt();
    let (i, t) = (cos_i.acos(), sin_t.asin());
    let r = if i < 1e-4 || (i - t).abs() < 1e-12 {
        ((eta - 1.0) / (eta + 1.0)).powi(2)
    } else {
        0.5 * (((i - t).sin() / (i + t).sin()).powi(2) + ((i - t).tan() / (i + t).tan()).powi(2))
    };
    let amplitudes = [2.0 * cos_i / (cos_i + eta * cos_t), 2.0 * cos_i / (eta * cos_i + cos_t)];
    let transmitted = amplitudes.map(|a| eta * cos_t / cos_i * a * a);
    Some((r, 0.5 * (transmitted[0] + transmitted[1])))
}

/// The reference conserves energy, so it is fit to judge.
#[test]
fn reference_fresnel_conserves_energy() {
    for (cos_i, eta) in [(0.9, 1.5), (0.1, 1.5), (0.99, 0.6), (0.5, 2.4), (0.8, 1.000_1)] {
        let (r, t) = fresnel(cos_i, eta).expect("no total reflection");
        assert_near(r + t, 1.0, 1e-12, "R + T");
    }
}

/// Against f64, allowing what an input error of 2 ulp brings: near the critical angle that is much.
#[test]
fn fresnel_agrees_with_f64() {
    let mut random = Random::new(40);
    for _ in 0..100_000 {
        let eta = random.between(0.4, 2.5) as f32;
        let cos_i = random.between(1e-3, 1.0) as f32;
        let got = lib::fresnel_dielectric(cos_i, eta);
        let at = |cos_i: f64| fresnel(cos_i.min(1.0), f64::from(eta)).map_or(1.0, |(r, _)| r);
        let near = [-5e-7, 0.0, 5e-7].map(|change| at(f64::from(cos_i) + change));
        let low = near.iter().copied().fold(f64::INFINITY, f64::min) - 2e-6;
        let high = near.iter().copied().fold(0.0, f64::max) + 2e-6;
        let r = f64::from(got.x);
        assert!((low..=high).contains(&r), "cos {cos_i} eta {eta}: {r}, not in {low}..{high}");
    }
}

#[test]
fn fresnel_at_its_limits() {
    for cos_i in [0.01f32, 0.3, 0.7, 1.0] {
        let same = lib::fresnel_dielectric(cos_i, 1.0);
        assert_near(f64::from(same.x), 0.0, 1e-7, "no boundary, no reflection");
        assert_near(f64::from(same.y), f64::from(cos_i), 1e-5, "and no bending");
    }
    let grazing = lib::fresnel_dielectric(0.0, 1.5);
    assert_near(f64::from(grazing.x), 1.0, 1e-6, "grazing");
    let normal = lib::fresnel_dielectric(1.0, 1.5);
    assert_near(f64::from(normal.x), 0.04, 1e-6, "normal incidence");
    // From inside glass the critical angle is asin(1 / 1.5), whose cosine is 0.745356.
    assert_eq!(lib::fresnel_dielectric(0.745, 1.0 / 1.5).x, 1.0);
    assert_eq!(lib::fresnel_dielectric(0.745, 1.0 / 1.5).y, 0.0);
    assert!(lib::fresnel_dielectric(0.746, 1.0 / 1.5).x < 1.0);
}

/// A surface's normals and a direction, at random; `tilt` of the shading normal.
fn random_place(random: &mut Random, tilt: f64) -> [DVec3; 3] {
    let ng = random.direction();
    [ng, random.tilted(ng, tilt), random.direction()]
}

fn sample(material: Material, [ng, ns, wo]: [DVec3; 3], random: &mut Random, mode: u32) -> BsdfSample {
    lib::bsdf_sample(material, frame(ng, ns), single(wo), random.unit3(), mode)
}

#[test]
fn diffuse_reflects_its_reflectance_and_never_more() {
    let mut random = Random::new(41);
    let reflectance = 0.7;
    for tilt in [0.0, 0.3, 0.8] {
        for _ in 0..10 {
            let mut place = random_place(&mut random, tilt);
            place[2] = random.direction_about(place[0]);
            if tilt == 0.0 {
                place[1] = place[0];
            }
            let weights: Vec<f64> = (0..20_000)
                .map(|_| {
                    let sampled =
                        sample(diffuse([reflectance; 3]), place, &mut random, lib::TRANSPORT_RADIANCE);
                    f64::from(sampled.weight.x)
                })
                .collect();
            let albedo = Estimate::of(&weights);
            if tilt == 0.0 {
                // Each sample weighs the reflectance; only rejection would lose any.
                assert_near(albedo.mean, f64::from(reflectance), 1e-6, "albedo");
            }
            // What is cut off in fewer than ten samples may not have been met at all.
            let cut_off = f64::from(lib::share_cut_off(place[0].dot(place[1]) as f32));
            let unseen = if cut_off * 20_000.0 < 10.0 { cut_off } else { 0.0 };
            let bound = f64::from(reflectance) + 4.0 * albedo.standard_error + unseen + 1e-6;
            assert!(albedo.mean <= bound, "{place:?}: albedo {}", albedo.mean);
        }
    }
}

#[test]
fn diffuse_scattering_is_reciprocal() {
    let mut random = Random::new(42);
    let material = diffuse([0.3, 0.6, 0.9]);
    let mut lit = 0;
    for _ in 0..50_000 {
        let [ng, ns, wo] = random_place(&mut random, 0.6);
        let (place, wo, wi) = (frame(ng, ns), single(wo), single(random.direction()));
        let f = bsdf_eval(material, place, wo, wi, lib::TRANSPORT_RADIANCE);
        let reverse = bsdf_eval(material, place, wi, wo, lib::TRANSPORT_IMPORTANCE);
        assert_eq!(f, reverse, "{place:?} {wo:?} {wi:?}");
        let flat = bsdf_eval(material, frame(ng, ng), wo, wi, lib::TRANSPORT_RADIANCE);
        let back = bsdf_eval(material, frame(ng, ng), wi, wo, lib::TRANSPORT_RADIANCE);
        assert!((double(flat) - double(back)).length() <= 1e-6, "{flat:?} and {back:?}");
        lit += usize::from(f.x > 0.0);
        let crosses = double(wo).dot(ng) * double(wi).dot(ng) < -1e-6;
        assert!(!(crosses && f.x > 0.0), "reflection reaches the other side");
        // Where light is scattered paths from both ends find it, or they would lose it.
        let pdfs = [
            bsdf_pdf(material, place, wo, wi, lib::TRANSPORT_RADIANCE),
            bsdf_pdf(material, place, wi, wo, lib::TRANSPORT_IMPORTANCE),
        ];
        assert!(f.x == 0.0 || pdfs.iter().all(|&pdf| pdf > 0.0), "{place:?} {wo:?} {wi:?}: {pdfs:?}");
    }
    assert!(lit >= 10_000, "{lit} of 50000 pairs scatter");
}

#[test]
fn delta_lobes_have_no_eval_and_no_pdf() {
    let mut random = Random::new(43);
    for material in
        [mirror([0.9; 3]), glass([0.9; 3], 1.5), sheet([0.9; 3], 1.5), finish(raw(lib::SURFACE_NULL))]
    {
        assert!(!lib::is_connectible(material));
        let place @ [ng, ns, wo] = random_place(&mut random, 0.0);
        let sampled = sample(material, place, &mut random, lib::TRANSPORT_RADIANCE);
        let (place, wo) = (frame(ng, ns), single(wo));
        let f = bsdf_eval(material, place, wo, sampled.wi, lib::TRANSPORT_RADIANCE);
        assert_eq!(f, Vec3::splat(0.0));
        assert_eq!(bsdf_pdf(material, place, wo, sampled.wi, lib::TRANSPORT_RADIANCE), 0.0);
    }
}

/// Radiance is scaled by 1/eta² on refraction, importance is not; reflection by neither.
#[test]
fn refraction_scales_radiance_only() {
    let mut random = Random::new(44);
    let tint = [0.25, 0.5, 1.0];
    let mut refracted = [0; 2];
    for _ in 0..20_000 {
        let ior = random.between(1.05, 2.5) as f32;
        let material = glass(tint, ior);
        let [ng, _, wo] = random_place(&mut random, 0.0);
        for mode in [lib::TRANSPORT_RADIANCE, lib::TRANSPORT_IMPORTANCE] {
            let sampled = sample(material, [ng, ng, wo], &mut random, mode);
            if sampled.pdf == 0.0 || !sampled.transmitted {
                // Light paths weigh by the ratio of two cosines that are equal but for rounding.
                let ratio =
                    if mode == lib::TRANSPORT_RADIANCE { 0.0 } else { 3e-7 / wo.dot(ng).abs() as f32 };
                let tolerance = 1e-6 + ratio;
                assert!(sampled.pdf == 0.0 || (sampled.weight.x - 1.0).abs() <= tolerance, "{sampled:?}");
                continue;
            }
            refracted[mode as usize] += 1;
            let ior = f64::from(ior);
            let eta = if wo.dot(ng) > 0.0 { ior } else { 1.0 / ior };
            let scale = if mode == lib::TRANSPORT_RADIANCE { 1.0 / (eta * eta) } else { 1.0 };
            for (got, tint) in sampled.weight.to_array().into_iter().zip(tint) {
                assert_near(f64::from(got), f64::from(tint) * scale, 4e-6 * scale, "weight");
            }
        }
    }
    assert!(refracted.iter().all(|&n| n >= 5000), "{refracted:?} refractions");
}

#[test]
fn refraction_obeys_snell() {
    let mut random = Random::new(45);
    for _ in 0..50_000 {
        let ior = random.between(0.5, 2.5);
        let material = glass([1.0; 3], ior as f32);
        let [ng, _, wo] = random_place(&mut random, 0.0);
        let sampled = sample(material, [ng, ng, wo], &mut random, lib::TRANSPORT_RADIANCE);
        if sampled.pdf == 0.0 || wo.dot(ng).abs() < 1e-3 {
            continue;
        }
        let wi = double(sampled.wi);
        assert_near(wi.length(), 1.0, 1e-5, "length");
        if sampled.transmitted {
            let eta = if wo.dot(ng) > 0.0 { ior } else { 1.0 / ior };
            // The tangential parts are opposite, and shorter by eta.
            let (tangent_o, tangent_i) = (wo - ng * wo.dot(ng), wi - ng * wi.dot(ng));
            assert!((tangent_i * eta + tangent_o).length() <= 3e-6, "{wo} to {wi} through {ior}");
        } else {
            assert!((wi - (2.0 * wo.dot(ng) * ng - wo)).length() <= 2e-6, "{wo} to {wi}");
        }
    }
}

#[test]
fn ior_of_one_goes_straight_on() {
    let mut random = Random::new(46);
    for _ in 0..5000 {
        let material = glass([0.5; 3], 1.0);
        let [ng, _, wo] = random_place(&mut random, 0.0);
        let sampled = sample(material, [ng, ng, wo], &mut random, lib::TRANSPORT_RADIANCE);
        assert!(sampled.transmitted, "{sampled:?}");
        // At grazing angles rounding makes a little reflection R. Lobes are chosen by what they give, R
        // and (1 - R) / 2, so that what is transmitted weighs their sum.
        let cosine = ng.dot(wo).abs() as f32;
        let reflected = f64::from(lib::fresnel_dielectric(cosine, 1.0).x);
        assert_near(f64::from(sampled.weight.x), reflected + 0.5 * (1.0 - reflected), 1e-4, "weight");
        assert!((double(sampled.wi) + wo).length() <= 1e-4, "{wo} to {:?}", sampled.wi);
    }
}

/// Reflection stays on wo's side of the surface and transmission crosses it, by the geometric
/// normal, whatever the shading normal.
#[test]
fn delta_lobes_never_reach_the_wrong_side() {
    let mut random = Random::new(47);
    let mut n_folded = 0;
    for i in 0..100_000u32 {
        let ior = random.between(0.6, 2.0) as f32;
        let material = [mirror([0.9; 3]), glass([0.9; 3], ior), sheet([0.9; 3], ior)][i as usize % 3];
        let place @ [ng, ns, wo] = random_place(&mut random, 1.2);
        let sampled = sample(material, place, &mut random, i % 2);
        if sampled.pdf == 0.0 {
            continue;
        }
        let about_ns = 2.0 * ns.dot(wo) * ns - wo;
        n_folded += usize::from(!sampled.transmitted && double(sampled.wi).dot(about_ns) < 0.999);
        let sides = double(single(ng)).dot(double(sampled.wi)) * ng.dot(wo);
        // A direction in the surface's plane to rounding is on either side.
        let wrong = if sampled.transmitted { sides > 1e-7 } else { sides < -1e-7 };
        assert!(!wrong, "{place:?}: {sampled:?}");
        assert_near(double(sampled.wi).length(), 1.0, 1e-5, "length");
    }
    assert!(n_folded >= 1000, "{n_folded} reflections mirrored by the surface");
}

#[test]
fn mirrors_follow_schlick() {
    for (cos_o, expected) in [(1.0, 0.4), (0.5, 0.4 + 0.6 * 0.5f64.powi(5)), (1e-4, 1.0)] {
        let got = lib::fresnel_schlick(Vec3::splat(0.4), cos_o);
        assert_near(f64::from(got.x), expected, 1e-3 * expected, "Schlick");
    }
    let mut random = Random::new(48);
    for _ in 0..10_000 {
        let place = random_place(&mut random, 0.5);
        let mirror = mirror([0.9, 0.5, 0.0]);
        let sampled = sample(mirror, place, &mut random, lib::TRANSPORT_RADIANCE);
        assert!(sampled.weight.to_array().iter().all(|w| (0.0..=1.0).contains(w)), "{sampled:?}");
    }
}

#[test]
fn light_paths_owe_the_cosines_of_the_geometry() {
    let mut random = Random::new(49);
    for _ in 0..20_000 {
        let [ng, ns, wo] = random_place(&mut random, 0.6);
        let (place, wo, wi) = (frame(ng, ns), single(wo), single(random.direction()));
        let factor = |wo, wi, mode| f64::from(lib::adjoint_cosines(place, wo, wi, mode));
        assert_eq!(factor(wo, wi, lib::TRANSPORT_RADIANCE), 1.0);
        let there = factor(wo, wi, lib::TRANSPORT_IMPORTANCE);
        let back = factor(wi, wo, lib::TRANSPORT_IMPORTANCE);
        assert_near(there * back, 1.0, 1e-5, "there and back");
        let [g, o, i] = [place.ng, wo, wi].map(double);
        let expected = (g.dot(i) / g.dot(o)).abs();
        let tolerance = 1e-6 / [g.dot(i), g.dot(o)].map(f64::abs).into_iter().fold(1.0, f64::min);
        assert_near(there / expected, 1.0, tolerance, "definition");
    }
}

#[test]
fn survival_is_a_chance_below_one() {
    let rough = |raw: RawMaterial| finish(RawMaterial { roughness: Vec2::splat(0.5), ..raw });
    let black = |kind| RawMaterial { color: Vec3::splat(0.0), ..raw(kind) };
    for (material, expected) in [
        (diffuse([0.0, 0.5, 0.0]), 0.5),
        (diffuse([1.0; 3]), lib::MAX_SURVIVAL),
        (diffuse([0.0; 3]), 0.0),
        (mirror([1.0; 3]), lib::DELTA_SURVIVAL),
        (mirror([0.0; 3]), lib::MIN_SURVIVAL),
        (glass([1.0; 3], 1.5), lib::DELTA_SURVIVAL),
        (finish(raw(lib::SURFACE_NULL)), lib::DELTA_SURVIVAL),
        (rough(raw(lib::SURFACE_CONDUCTOR)), lib::MAX_SURVIVAL),
        (rough(black(lib::SURFACE_CONDUCTOR)), lib::MIN_SURVIVAL),
        (rough(raw(lib::SURFACE_DIELECTRIC)), lib::MAX_SURVIVAL),
        (finish(raw(lib::SURFACE_PLASTIC)), lib::MAX_SURVIVAL),
        (finish(raw(lib::SURFACE_METALLIC_ROUGHNESS)), lib::MAX_SURVIVAL),
    ] {
        assert_eq!(lib::survival(material), expected, "{material:?}");
    }
}

#[test]
fn roulette_leaves_the_least_throughput() {
    const LEAST: f32 = 0.25;
    let surfaces = [diffuse([0.5; 3]), mirror([1.0; 3]), glass([1.0; 3], 1.5)];
    for (material, throughput, depth) in surfaces
        .iter()
        .flat_map(|m| [1e-3, 0.1, 0.6, 40.0].map(|t| (m, t)))
        .flat_map(|(m, t)| [0, 30].map(|d| (*m, t, d)))
    {
        let chance = lib::survival_by_throughput(material, throughput, LEAST, depth);
        let case = format!("{throughput} at {depth}, {material:?}");
        let sent_on = lib::survival(material) * throughput;
        let most = if depth < lib::SURE_VERTICES { 1.0 } else { lib::most_survival(material) };
        assert!(chance > 0.0 && chance <= most, "{case}: {chance}");
        if sent_on < LEAST * most {
            // But for the step of random numbers: chances are multiples of it.
            let step = f64::from(1.0 / lib::UNIT_STEPS);
            assert_near(
                f64::from(sent_on / chance),
                f64::from(LEAST),
                1e-6 + step / f64::from(chance),
                &case,
            );
            assert_eq!((chance * lib::UNIT_STEPS).fract(), 0.0, "{case}");
        } else {
            assert_eq!(chance, most, "{case}");
        }
    }
    // Black ends every path, and no number none.
    assert_eq!(lib::survival_by_throughput(diffuse([0.0; 3]), 1.0, LEAST, 0), 0.0);
    let of_none = lib::survival_by_throughput(diffuse([0.5; 3]), f32::NAN, LEAST, 30);
    assert_eq!(of_none, lib::MAX_SURVIVAL);
}

#[test]
fn emission_is_on_the_sides_that_emit() {
    let mut light = diffuse([0.0; 3]);
    light.emission = Vec3::splat(3.0);
    assert_eq!(lib::emitted_radiance(light, 0.5).x, 3.0);
    assert_eq!(lib::emitted_radiance(light, -0.5).x, 0.0);
    light.flags = lib::MATERIAL_EMITS_BACK;
    assert_eq!(lib::emitted_radiance(light, -0.5).x, 3.0);
    assert_eq!(lib::emitted_radiance(light, 0.0).x, 0.0);
    for cosine in [-1.0, -0.5, 0.0, 0.5, 1.0] {
        for flags in [0, lib::MATERIAL_EMITS_BACK] {
            light.flags = flags;
            let emits = lib::emitted_radiance(light, cosine).x > 0.0;
            assert_eq!(emits, lib::emission_pdf_sa(cosine, flags != 0) > 0.0, "at {cosine}");
        }
    }
}
