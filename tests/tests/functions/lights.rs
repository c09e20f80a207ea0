//! Lights that are not surfaces: samplers against their densities, and the environment of a packed
//! scene against a sky in f64.

use std::f64::consts::{PI, TAU};

use bytemuck::{Zeroable, bytes_of, cast_slice};
use glam::DVec3;
use midway_device::{Device, DeviceKind};
use midway_kernels::{constants::PROBE_STRIDE, layout::Params, native::lib};
use midway_render::{PackedScene, RenderSettings};
use midway_tests::{
    estimate::{cpu, gpu},
    lit::{self, SKY, Sky},
};
use wgsl_cpu::runtime::Vec2;

use crate::{
    chi_square::{Cap, ChiSquare, histogram, histogram2},
    support::{Random, assert_near, double, single},
    twins::{
        compare::{Results, Tolerance, compare},
        device,
    },
};

const N: u64 = 400_000;
/// Words of an invocation.
const STRIDE: usize = 4 * PROBE_STRIDE as usize;

/// Polar: the square of the chord to the axis and the angle about it are both uniform.
fn cone_histogram(angle: f64, height: f64, random: &mut Random) -> Vec<u64> {
    let axis = random.direction();
    let across = axis.any_orthonormal_vector();
    let chord2 = 4.0 * (0.5 * angle).sin().powi(2);
    let polar = (0..N).map(|_| {
        let d = double(lib::sample_cone(single(axis), height as f32, random.unit2()));
        let turns = d.dot(axis.cross(across)).atan2(d.dot(across)) / TAU;
        let share = (d - axis).length_squared() / chord2;
        assert!(share <= 1.001 || height > 0.5 * chord2, "{d} is outside the cone");
        ((share as f32).min(0.999_999), ((turns - turns.floor()) as f32).min(0.999_999))
    });
    histogram2(20, polar)
}

#[test]
fn cone_directions_are_uniform() {
    let mut random = Random::new(20);
    for angle in [0.01, 0.3, PI / 2.0, 2.5, PI] {
        let height = 2.0 * (0.5 * angle).sin().powi(2);
        let observed = cone_histogram(angle, height, &mut random);
        ChiSquare::uniform(&observed).assert_holds(&format!("sample_cone of {angle}"));
    }
    let wide = cone_histogram(0.3, 1.02 * 2.0 * 0.15f64.sin().powi(2), &mut random);
    ChiSquare::uniform(&wide).assert_rejects("a cone too wide by 1 %");
}

#[test]
fn linear_places_have_their_density() {
    const BINS: usize = 40;
    let mut random = Random::new(21);
    for (a, b) in [(0.0, 1.0), (1.0, 0.0), (3.0, 5.0), (2.0, 2.0), (0.0, 0.0), (1e-30, 1e30)] {
        let places = (0..N).map(|_| lib::sample_linear(random.unit(), a, b));
        let observed = histogram(BINS, places);
        let (a, b) = if a + b > 0.0 { (f64::from(a), f64::from(b)) } else { (1.0, 1.0) };
        let mass = |i: usize| {
            let middle = (i as f64 + 0.5) / BINS as f64;
            (a + (b - a) * middle) / (0.5 * (a + b)) / BINS as f64 * N as f64
        };
        let expected: Vec<f64> = (0..BINS).map(mass).collect();
        ChiSquare::of(&observed, &expected).assert_holds(&format!("sample_linear from {a} to {b}"));
    }
}

/// A spot's share of its intensity by the formulas of glTF, pbrt and Mitsuba.
#[test]
fn cones_fall_off_as_their_formats_say() {
    let mut random = Random::new(22);
    let (inner, outer) = (0.4f64, 1.1f64);
    for _ in 0..2000 {
        let (axis, direction) = (random.direction(), random.direction());
        let angle = axis.angle_between(direction);
        let place = ((angle.cos() - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
        for (falloff, expected) in [
            (lib::FALLOFF_NONE, 1.0),
            (lib::FALLOFF_COSINE_SQUARED, place * place),
            (lib::FALLOFF_SMOOTHSTEP, place * place * (3.0 - 2.0 * place)),
            (lib::FALLOFF_ANGLE, ((outer - angle) / (outer - inner)).clamp(0.0, 1.0)),
        ] {
            let by_angle = falloff == lib::FALLOFF_ANGLE;
            let at = |angle: f64| if by_angle { angle as f32 } else { (1.0 - angle.cos()) as f32 };
            let cone = lib::Cone { axis: single(axis), falloff, full: at(inner), zero: at(outer) };
            let share = lib::cone_falloff(cone, single(direction));
            assert_near(share.into(), expected, 2e-6, &format!("falloff {falloff} at {angle}"));
        }
    }
}

/// Rows of the probe: a drawn direction and its density; its radiance; radiance and density of
/// another direction.
fn probe_environment(device: &dyn Device, packed: &PackedScene, directions: &[DVec3]) -> Vec<u32> {
    let params = Params { environment_at: packed.environment_at, ..Params::zeroed() };
    let mut inputs = vec![0f32; directions.len() * STRIDE];
    for (row, direction) in inputs.chunks_mut(STRIDE).zip(directions) {
        row[..3].copy_from_slice(&direction.as_vec3().to_array());
    }
    let zeros = vec![0u32; inputs.len()];
    let buffers: [(&str, &[u8]); 4] = [
        ("params", bytes_of(&params)),
        ("scene", cast_slice(&packed.scene)),
        ("probe_in", cast_slice(&inputs)),
        ("probe_out", cast_slice(&zeros)),
    ];
    let mut outputs = device::run(device, "probe_environment", &buffers, directions.len() as u32);
    outputs.remove("probe_out").expect("every probe writes probe_out")
}

fn numbers(words: &[u32], field: usize) -> (DVec3, f64) {
    let [x, y, z, w] = [0, 1, 2, 3].map(|i| f64::from(f32::from_bits(words[4 * field + i])));
    (DVec3::new(x, y, z), w)
}

fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

#[test]
fn environment_directions_have_their_density() {
    let known = lit::sky();
    let packed =
        PackedScene::new(&known.scene, &known.scene.cameras[0], &RenderSettings::default(), DeviceKind::Cpu)
            .expect("packs");
    let mut random = Random::new(23);
    let directions: Vec<DVec3> = (0..N).map(|_| random.direction()).collect();
    let words = probe_environment(&*cpu(), &packed, &directions);
    let inverse_total = f64::from(f32::from_bits(packed.scene[packed.environment_at as usize + 3][0]));
    let sky = Sky::default();
    let size = Vec2::new(SKY[0] as u32, SKY[1] as u32);
    let pdf = |d: DVec3| {
        let own = single(sky.environment_from_world * d);
        let row = lib::environment_place(own, size).cell.y;
        let ratio = lib::environment_density_ratio(own, row, size.y);
        luminance(sky.radiance(d)) * inverse_total * f64::from(ratio)
    };
    for (row, other) in words.chunks(STRIDE).zip(&directions) {
        let ((drawn, drawn_pdf), (drawn_radiance, _)) = (numbers(row, 0), numbers(row, 1));
        assert_near(drawn.length(), 1.0, 1e-6, "length");
        let (radiance, other_pdf) = numbers(row, 2);
        // As `probe_unit` makes it.
        let other = (other + DVec3::Z * 1e-3).normalize();
        for (d, radiance, actual) in [(drawn, drawn_radiance, drawn_pdf), (other, radiance, other_pdf)] {
            let expected = sky.radiance(d);
            assert_near((radiance - expected).length(), 0.0, 1e-4 * (1.0 + expected.length()), "radiance");
            // Between two rows of cells the density has a step of a few per cent.
            assert_near(actual, pdf(d), 0.1 * pdf(d), "density");
        }
    }
    let mut drawn = words.chunks(STRIDE).map(|row| numbers(row, 0).0);
    Cap::sphere().test(N, || drawn.next(), pdf).assert_holds("draw_environment");
    let mut drawn = words.chunks(STRIDE).map(|row| numbers(row, 0).0);
    let mirrored = |d: DVec3| pdf(d * DVec3::new(-1.0, 1.0, 1.0));
    Cap::sphere().test(N, || drawn.next(), mirrored).assert_rejects("the sky seen in a mirror");
}

#[test]
fn environments_agree_on_both_devices() {
    let Some(gpu) = gpu() else { return };
    let known = lit::sky();
    let packed =
        PackedScene::new(&known.scene, &known.scene.cameras[0], &RenderSettings::default(), DeviceKind::Cpu)
            .expect("packs");
    let mut random = Random::new(24);
    let directions: Vec<DVec3> = (0..20_011).map(|_| random.direction()).collect();
    let results = |device: &dyn Device| Results {
        device: device.info().name.clone(),
        words: probe_environment(device, &packed, &directions),
    };
    // Rounding may choose another cell of the alias table, or another row for the density.
    let tolerance = Tolerance::Float { relative: 1e-4, absolute: 1e-4, outliers: 1e-3 };
    let compared = compare(&results(&*cpu()), &results(&*gpu), STRIDE, tolerance);
    assert!(compared.is_ok(), "{}", compared.unwrap_err());
}
