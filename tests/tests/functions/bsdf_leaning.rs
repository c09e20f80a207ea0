//! Surfaces whose shading normal leans away from the geometry's: energy, and paths from both ends.

use glam::DVec3;
use midway_kernels::native::lib::{self, Frame, Material, RawMaterial};
use midway_tests::statistics::Estimate;
use wgsl_cpu::runtime::Vec3;

use crate::{
    models::{self, Model},
    support::{self, Random, double, frame, single},
};

/// Samples of an albedo: its standard error is a few thousandths.
const N_ALBEDO: usize = 8_000;
/// Pairs of directions from one end.
const N_PAIRS: usize = 60_000;
/// A correct surface is off by more than this, in standard errors, once in 10,000 comparisons.
const BOUND: f64 = 3.9;

/// A shading normal that leans along x, by degrees.
fn leaning(degrees: f64) -> Frame {
    frame(DVec3::Z, seen_at(degrees))
}

/// A direction in the plane in which normals lean, by degrees from the geometric normal.
fn seen_at(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(sin, 0.0, cos)
}

/// What comes back in a white furnace, of radiance: refracted radiance counts as n times denser as its
/// medium is.
fn albedo(material: Material, place: Frame, wo: DVec3, random: &mut Random) -> Estimate {
    let eta = f64::from(lib::relative_index(material, true));
    let weights: Vec<f64> = (0..N_ALBEDO)
        .map(|_| {
            let u = random.unit3();
            let sampled = lib::bsdf_sample(material, place, single(wo), u, lib::TRANSPORT_RADIANCE);
            let bent = sampled.transmitted && lib::bends(material);
            let weight = double(sampled.weight).max_element() * if bent { eta * eta } else { 1.0 };
            if sampled.pdf > 0.0 { weight } else { 0.0 }
        })
        .collect();
    Estimate::of(&weights)
}

/// Smooth ones beside the models.
fn all() -> Vec<Model> {
    let named = |name: &str, material| Model { name: name.to_owned(), material, loss: 0.02, gain: 0.02 };
    let mut all = models::all();
    all.push(named("white", support::diffuse([1.0; 3])));
    all.push(named("mirror", support::mirror([1.0; 3])));
    all.push(named("glass", support::glass([1.0; 3], 1.5)));
    all.push(named("sheet", support::sheet([1.0; 3], 1.5)));
    let tin = RawMaterial { color: Vec3::new(0.6, 0.5, 0.4), ..support::raw(lib::SURFACE_CONDUCTOR) };
    all.push(Model { loss: f64::NAN, ..named("tin", support::finish(tin)) });
    all
}

/// From everywhere, where the normal faces away too, white stays white; nothing is created.
#[test]
fn leaning_normals_neither_darken_nor_brighten() {
    let mut random = Random::new(110);
    for model in all() {
        for lean in [5.0, 20.0, 45.0] {
            for view in [-85.0, -75.0, -50.0, -20.0, 0.0, 40.0, 70.0, 85.0] {
                let albedo = albedo(model.material, leaning(lean), seen_at(view), &mut random);
                let (mean, error) = (albedo.mean, 3.0 * albedo.standard_error);
                let about = format!("{} leans {lean} seen at {view}: {mean:.3} +- {error:.3}", model.name);
                println!("{about}");
                assert!(mean <= 1.0 + model.gain + error, "{about}");
                assert!(model.loss.is_nan() || mean >= 1.0 - model.loss - error, "{about}");
            }
        }
    }
}

/// Smooth functions of where light comes from and goes to, that tell directions apart.
fn patterns(camera: DVec3, light: DVec3) -> [f64; 4] {
    let both = camera.dot(light);
    [1.0, 1.0 + both, (1.0 + light.x) * (1.0 - camera.x), if light.z * camera.z > 0.0 { 1.0 } else { 0.0 }]
}

/// ∫∫ f(camera, light) cos cos over all pairs of directions, each pattern in turn: one end drawn by its
/// cosine, the other by bsdf_sample.
fn pairs(material: Material, place: Frame, mode: u32, random: &mut Random) -> [Estimate; 4] {
    let mut values: [Vec<f64>; 4] = Default::default();
    for _ in 0..N_PAIRS {
        let up = lib::sample_cosine_hemisphere(random.unit2());
        let wo = if random.chance(0.5) { up } else { -up };
        let sampled = lib::bsdf_sample(material, place, wo, random.unit3(), mode);
        let (wo, wi) = (double(wo), double(sampled.wi));
        let found = if mode == lib::TRANSPORT_RADIANCE { patterns(wo, wi) } else { patterns(wi, wo) };
        let weight = if sampled.pdf > 0.0 { double(sampled.weight).element_sum() } else { 0.0 };
        for (values, found) in values.iter_mut().zip(found) {
            values.push(weight * found);
        }
    }
    values.map(|values| Estimate::of(&values))
}

/// Camera paths and light paths find the same light between the same directions, delta lobes included,
/// however normals lean.
#[test]
fn paths_from_both_ends_scatter_alike() {
    let mut random = Random::new(111);
    for model in all() {
        for lean in [10.0, 50.0] {
            let place = leaning(lean);
            let [camera, light] = [lib::TRANSPORT_RADIANCE, lib::TRANSPORT_IMPORTANCE]
                .map(|mode| pairs(model.material, place, mode, &mut random));
            for (pattern, (a, b)) in camera.iter().zip(&light).enumerate() {
                let error = (a.mean - b.mean).abs();
                assert!(
                    error <= BOUND * a.standard_error.hypot(b.standard_error) + 1e-5,
                    "{} leans {lean}, pattern {pattern}: {} from the camera, {} from the light",
                    model.name,
                    a.mean,
                    b.mean
                );
            }
        }
    }
}
