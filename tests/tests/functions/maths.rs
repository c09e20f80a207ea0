//! Small maths: errors as their comments claim them, frames, offsets, fixed point.

use glam::DVec3;
use midway_kernels::native::lib;
use wgsl_cpu::runtime::Vec3;

use crate::support::{Random, assert_near, double, single};

/// The largest error of `f` against `exact` over `n` even steps from `low` to `high`.
fn largest_error(low: f32, high: f32, n: u32, error: impl Fn(f32) -> f64) -> f64 {
    (0..=n).map(|i| error(low + (high - low) * (i as f32 / n as f32))).fold(0.0, |a, b| {
        assert!(!b.is_nan(), "an error is NaN");
        a.max(b)
    })
}

#[test]
fn sine_and_cosine_keep_their_claims() {
    let quarter = std::f32::consts::FRAC_PI_4;
    let sine = largest_error(-quarter, quarter, 1_000_000, |x| {
        (f64::from(lib::sin_quarter(x)) - f64::from(x).sin()).abs()
    });
    let cosine = largest_error(-quarter, quarter, 1_000_000, |x| {
        (f64::from(lib::cos_quarter(x)) - f64::from(x).cos()).abs()
    });
    println!("largest errors: sine {sine:e}, cosine {cosine:e}");
    assert!(sine <= 1e-7, "sine is off by {sine:e}");
    assert!(cosine <= 1e-7, "cosine is off by {cosine:e}");
}

#[test]
fn circle_and_angle_keep_their_claims() {
    let circle = largest_error(-1.0, 1.0, 1_000_000, |turns| {
        let exact = (f64::from(turns) * std::f64::consts::TAU).sin_cos();
        let point = lib::unit_circle(turns);
        (f64::from(point.x) - exact.1).abs().max((f64::from(point.y) - exact.0).abs())
    });
    let angle = largest_error(-1.0, 1.0, 1_000_000, |turns| {
        let (y, x) = (f64::from(turns) * 3.1).sin_cos();
        let (y, x) = ((1e3 * y) as f32, (1e3 * x) as f32);
        (f64::from(lib::angle_of(y, x)) - f64::from(y).atan2(f64::from(x))).abs()
    });
    println!("largest errors: circle {circle:e}, angle {angle:e}");
    assert!(circle <= 3e-7, "the circle is off by {circle:e}");
    assert!(angle <= 5e-7, "the angle is off by {angle:e}");
    assert_eq!(lib::angle_of(0.0, 0.0), 0.0);
}

#[test]
fn exponential_keeps_its_claim() {
    let error = |x: f32| {
        let exact = f64::from(x).exp();
        (f64::from(lib::exp_negative(x)) - exact).abs() / exact
    };
    let near = largest_error(-1.0, 0.0, 1_000_000, error);
    let far = largest_error(-87.0, 0.0, 1_000_000, error);
    println!("largest relative errors: to -1 {near:e}, to -87 {far:e}");
    assert!(near <= 3e-7, "off by {near:e}");
    assert!(far <= 4e-6, "off by {far:e}");
    assert_eq!(lib::exp_negative(0.0), 1.0);
    assert_eq!(lib::exp_negative(-0.0), 1.0);
    for x in [-88.5, -200.0, -1e30, f32::NEG_INFINITY] {
        let tail = lib::exp_negative(x);
        assert!((0.0..=1e-37).contains(&tail), "exp({x}) is {tail:e}");
    }
}

#[test]
fn finite_means_neither_nan_nor_infinite() {
    for (x, finite) in [
        (0.0, true),
        (-0.0, true),
        (f32::MAX, true),
        (f32::MIN_POSITIVE / 2.0, true),
        (f32::INFINITY, false),
        (f32::NEG_INFINITY, false),
        (f32::NAN, false),
        (-f32::NAN, false),
    ] {
        assert_eq!(lib::is_finite(x), finite, "{x}");
    }
}

#[test]
fn safe_inverse_is_finite_and_keeps_signs() {
    for d in [0.0, -0.0, 1e-38, -1e-38, 1e-45, 1e-20, -1e-20, 1e-3, -0.5, 1.0] {
        let inverse = lib::safe_inverse(Vec3::new(d, 1.0, -d)).x;
        assert!(inverse.is_finite(), "1 / {d:e} is {inverse}");
        assert_eq!(inverse > 0.0, d >= 0.0, "the sign of 1 / {d:e}");
        if d.abs() >= 1e-20 {
            assert_eq!(inverse, 1.0 / d);
        }
    }
}

#[test]
fn frames_are_orthonormal_and_right_handed() {
    let mut random = Random::new(50);
    let poles =
        [DVec3::Z, -DVec3::Z, DVec3::X, -DVec3::Y, DVec3::new(1e-8, 0.0, -1.0), DVec3::new(0.0, 1e-4, -1.0)];
    let normals = poles.map(DVec3::normalize).into_iter().chain((0..50_000).map(|_| random.direction()));
    for n in normals {
        let n = single(n);
        let [x, y, z] = lib::frame_from_normal(n).columns.map(double);
        assert_eq!(single(z), n, "the third column is the normal");
        let products = [x.dot(y), x.dot(z), y.dot(z), x.dot(x) - 1.0, y.dot(y) - 1.0];
        assert!(products.iter().all(|p| p.abs() <= 1e-6), "{n:?}: {products:?}");
        assert!(x.cross(y).dot(z) > 0.999, "{n:?}: left-handed");
    }
}

/// The moved point lies on the normal's side, off by an ulp or more, and not far.
#[test]
fn offsets_move_to_the_normals_side() {
    let mut random = Random::new(51);
    for i in 0..200_000 {
        let scale = 10f64.powf(random.between(-4.0, 5.0));
        let mut p = single(random.direction() * scale);
        if i % 3 == 0 {
            p.y = 0.0;
        }
        let n = single(random.direction());
        let moved = lib::offset_origin(p, n);
        let (by, normal) = (double(moved) - double(p), double(n));
        assert!(by.dot(normal) > 0.0, "{p:?} along {n:?} went to {moved:?}");
        let ulps = (0..3u32).map(|c| (i64::from(p.at(c).to_bits()) - i64::from(moved.at(c).to_bits())).abs());
        let largest = normal.abs().max_element();
        assert!(ulps.max() >= Some(1), "{p:?} did not move along a component of {largest}");
        let bound = 1.8 * (double(p).abs().max_element() * 256.0 * 2f64.powi(-23) + 1.0 / 65_536.0);
        assert!(by.length() <= bound, "{p:?} moved by {}", by.length());
        for (by, n) in by.to_array().into_iter().zip(normal.to_array()) {
            assert!(by * n >= 0.0, "a component went against the normal");
        }
        // Off a wall by more than f32 resolves along it: a shadow ray from afar still ends before it.
        let resolved = double(p).abs().max_element() * 2f64.powi(-24);
        assert!(by.length() >= 64.0 * resolved, "{p:?} moved by {} only", by.length());
    }
}

/// Off a plane through a point computed in f32, the moved point is on the plane's right side: what
/// the offset is for.
#[test]
fn offsets_clear_the_triangle_that_a_point_was_computed_on() {
    let mut random = Random::new(52);
    for _ in 0..50_000 {
        let centre = random.direction() * 10f64.powf(random.between(-1.0, 3.0));
        let vertices = [0; 3].map(|_| single(centre + random.direction() * random.between(0.1, 1.0)));
        let [a, b, c] = vertices;
        let (u, v) = (random.unit() * 0.5, random.unit() * 0.5);
        let p = a + (b - a) * u + (c - a) * v;
        let normal = (double(b) - double(a)).cross(double(c) - double(a));
        if normal.length() < 1e-3 {
            continue;
        }
        let normal = normal.normalize();
        for side in [1.0, -1.0] {
            let moved = double(lib::offset_origin(p, single(normal * side)));
            let height = (moved - double(a)).dot(normal) * side;
            assert!(height > 0.0, "{p:?} of {vertices:?} is {height:e} above its triangle");
        }
    }
}

#[test]
fn fixed_point_is_exact_from_an_eight_bit_fraction_up() {
    let mut random = Random::new(53);
    for _ in 0..200_000 {
        let value = 2f32.powf(random.between(-8.0, 31.9) as f32) * 1.000_01;
        let fixed = lib::to_fixed(value);
        let exact = f64::from(fixed.y) + f64::from(fixed.x) / 4_294_967_296.0;
        assert_eq!(exact, f64::from(value));
        // Two roundings: of the low word and of the sum.
        assert_near(f64::from(lib::from_fixed(fixed.x, fixed.y)) / exact, 1.0, 1.2e-7, "from_fixed");
    }
    assert_eq!(lib::to_fixed(0.0).to_array(), [0, 0]);
    assert_eq!(lib::to_fixed(1.0).to_array(), [0, 1]);
    assert_eq!(lib::to_fixed(0.5).to_array(), [1 << 31, 0]);
    assert_eq!(lib::to_fixed(lib::FIXED_MAX).to_array(), [0, 4_294_967_040]);
    assert_eq!(lib::from_fixed(u32::MAX, 0), 1.0);
}

/// Below that it is the quantum that is lost, never more, and never the order.
#[test]
fn fixed_point_is_monotonic_and_truncates_to_the_quantum() {
    let mut random = Random::new(54);
    let word = |value: f32| {
        let fixed = lib::to_fixed(value);
        (u64::from(fixed.y) << 32) | u64::from(fixed.x)
    };
    for _ in 0..200_000 {
        let value = 10f32.powf(random.between(-12.0, 9.6) as f32);
        let next = f32::from_bits(value.to_bits() + 1);
        assert!(word(value) <= word(next), "{value:e}");
        let quanta = f64::from(value) * 4_294_967_296.0;
        assert_eq!(word(value) as f64, quanta.floor(), "{value:e}");
    }
}

#[test]
fn luminance_of_grey_is_grey() {
    assert_near(f64::from(lib::luminance(Vec3::splat(0.5))), 0.5, 1e-7, "grey");
    assert_eq!(lib::max3(Vec3::new(1.0, 3.0, 2.0)), 3.0);
}
