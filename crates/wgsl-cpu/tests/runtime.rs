//! The runtime against the WGSL specification, where values are special.

use wgsl_cpu::runtime::{self as rt, Mat, Number, Scalar, Vec2, Vec3, Vec4};

#[test]
fn min_max_and_clamp_prefer_numbers() {
    for (a, b) in [(f32::NAN, 2.0), (2.0, f32::NAN)] {
        assert_eq!(rt::min(a, b), 2.0);
        assert_eq!(rt::max(a, b), 2.0);
    }
    assert!(rt::min(f32::NAN, f32::NAN).is_nan());
    assert_eq!(rt::clamp(f32::NAN, -1.0, 1.0), -1.0);
    assert_eq!(
        rt::clamp(Vec3::new(-5.0, 0.5, f32::INFINITY), Vec3::splat(0.0), Vec3::splat(1.0)),
        Vec3::new(0.0, 0.5, 1.0)
    );
    // Where `low > high`, the specification's formula gives `high`; `Ord::clamp` panics.
    assert_eq!(rt::clamp(5, 10, 3), 3);
    assert_eq!(rt::saturate(f32::NAN), 0.0);
    assert_eq!(rt::min(Vec2::new(1u32, 9), Vec2::splat(5)), Vec2::new(1, 5));
}

#[test]
fn conversions_clamp() {
    assert_eq!(rt::to_i32(f32::NAN), 0);
    assert_eq!(rt::to_u32(f32::NAN), 0);
    assert_eq!(rt::to_i32(f32::INFINITY), 2147483520);
    assert_eq!(rt::to_i32(f32::NEG_INFINITY), i32::MIN);
    assert_eq!(rt::to_i32(-2147483648.0f32), i32::MIN);
    assert_eq!(rt::to_u32(f32::INFINITY), 4294967040);
    assert_eq!(rt::to_u32(-1.5f32), 0);
    assert_eq!(rt::to_i32(Vec2::new(-1.75f32, 1.75)), Vec2::new(-1, 1));
    assert!(rt::to_bool(f32::NAN) && !rt::to_bool(-0.0f32));
    assert_eq!(rt::to_f32(u32::MAX), 4294967296.0);
    assert_eq!(rt::bitcast_u32(Vec2::new(1.0f32, -0.0)), Vec2::new(0x3f80_0000, 0x8000_0000));
    assert_eq!(rt::bitcast_f32(0x7fc0_1234u32).to_bits(), 0x7fc0_1234);
    assert_eq!(true.bits(), 1);
}

#[test]
fn integers_divide_by_zero_to_themselves() {
    assert_eq!((rt::div(7u32, 0), rt::rem(7u32, 0)), (7, 0));
    assert_eq!((rt::div(i32::MIN, -1), rt::rem(i32::MIN, -1)), (i32::MIN, 0));
    assert_eq!((rt::div(-7, 2), rt::rem(-7, 2)), (-3, -1));
    assert_eq!(Vec3::new(7, i32::MIN, 9) / Vec3::new(0, -1, 2), Vec3::new(7, i32::MIN, 4));
    assert_eq!(Vec2::new(u32::MAX, 1) + 2u32, Vec2::new(1, 3));
    assert_eq!(-Vec2::new(i32::MIN, 5), Vec2::new(i32::MIN, -5));
    assert_eq!(rt::abs(i32::MIN), i32::MIN);
    assert_eq!((rt::sign(-3), rt::sign(0u32), rt::sign(9u32), rt::sign(-2.5)), (-1, 0, 1, -1.0));
    assert_eq!(rt::sign(f32::NAN), 0.0);
}

#[test]
fn float_remainders_have_the_sign_of_the_first() {
    assert_eq!(rt::rem(7.5f32, 2.0), 1.5);
    assert_eq!(rt::rem(-7.5f32, 2.0), -1.5);
    assert_eq!(Vec2::new(7.5, -1.0) % Vec2::new(-2.0, 3.0), Vec2::new(1.5, -1.0));
    assert!(rt::rem(1.0f32, 0.0).is_nan());
}

#[test]
fn rounding_is_to_even() {
    let halves = [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5].map(rt::round::<f32>);
    assert_eq!(halves, [-2.0, -2.0, 0.0, 0.0, 2.0, 2.0]);
    assert_eq!(rt::fract(-0.25f32), 0.75);
    assert_eq!(rt::trunc(-1.75f32), -1.0);
}

#[test]
fn exponents_are_exact_at_the_ends() {
    for x in [1.0f32, -3.75, f32::MIN_POSITIVE, f32::from_bits(1), f32::MAX, -f32::from_bits(0x7f_ffff)] {
        let parts = rt::frexp(x);
        assert!((0.5..1.0).contains(&parts.fract.abs()), "{x}: {parts:?}");
        assert_eq!(rt::ldexp(parts.fract, parts.exp), x);
    }
    assert_eq!((rt::frexp(0.0f32).fract, rt::frexp(0.0f32).exp), (0.0, 0));
    assert_eq!(rt::ldexp(1.0f32, 200), f32::INFINITY);
    assert_eq!(rt::ldexp(1.0f32, -149), f32::from_bits(1));
    assert_eq!(rt::ldexp(f32::from_bits(1), 149), 1.0);
    assert_eq!(rt::ldexp(1.0f32, i32::MIN), 0.0);
    let split = rt::modf(Vec2::new(-1.25f32, 3.0));
    assert_eq!((split.fract, split.whole), (Vec2::new(-0.25, 0.0), Vec2::new(-1.0, 3.0)));
}

#[test]
fn every_half_survives() {
    for half in 0..=u16::MAX {
        let value = rt::f16_to_f32(half);
        let exponent = half >> 10 & 0x1f;
        match exponent {
            31 if half & 0x3ff != 0 => assert!(value.is_nan()),
            31 => assert!(value.is_infinite()),
            0 => assert_eq!(value.abs(), f32::from(half & 0x3ff) * (-24.0f32).exp2()),
            _ => {
                let significand = 1.0 + f32::from(half & 0x3ff) / 1024.0;
                assert_eq!(value.abs(), significand * (f32::from(exponent) - 15.0).exp2());
            }
        }
        if !value.is_nan() {
            assert_eq!(rt::f32_to_f16(value), half);
            assert_eq!(value.is_sign_negative(), half >= 0x8000);
        }
    }
    assert!(rt::f16_to_f32(rt::f32_to_f16(f32::NAN)).is_nan());
}

#[test]
fn halves_round_to_even() {
    let ulp = (-10.0f32).exp2();
    assert_eq!(rt::f32_to_f16(1.0 + 0.5 * ulp), 0x3c00);
    assert_eq!(rt::f32_to_f16(1.0 + 1.5 * ulp), 0x3c02);
    assert_eq!(rt::f32_to_f16(65519.0), 0x7bff);
    assert_eq!(rt::f32_to_f16(65520.0), 0x7c00);
    assert_eq!(rt::f32_to_f16(-1e30), 0xfc00);
    assert_eq!(rt::f32_to_f16((-25.0f32).exp2()), 0, "half of the least, to even");
    assert_eq!(rt::f32_to_f16(1.5 * (-25.0f32).exp2()), 1);
    assert_eq!(rt::f32_to_f16(1.5 * (-24.0f32).exp2()), 2, "to even");
}

#[test]
fn packing_clamps() {
    assert_eq!(rt::pack4x8unorm(Vec4::new(-1.0, 2.0, 0.5, f32::NAN)), 0x0080_ff00);
    assert_eq!(rt::pack4x8snorm(Vec4::new(-2.0, 2.0, 0.0, 1.0)), 0x7f00_7f81);
    assert_eq!(rt::unpack4x8snorm(0x8000_0080), Vec4::new(-1.0, 0.0, 0.0, -1.0));
    assert_eq!(rt::unpack2x16unorm(0xffff_0000), Vec2::new(0.0, 1.0));
    assert_eq!(rt::pack4x_i8_clamp(Vec4::new(-1000, 1000, -1, 5)), 0x05ff_7f80);
    assert_eq!(rt::pack4x_u8_clamp(Vec4::new(1000, 1, 2, 3)), 0x0302_01ff);
    assert_eq!(rt::unpack4x_i8(0xff7f_8001), Vec4::new(1, -128, 127, -1));
    assert_eq!(rt::pack4x_u8(rt::unpack4x_u8(0xdead_beef)), 0xdead_beef);
    assert_eq!(rt::pack4x_i8(rt::unpack4x_i8(0xdead_beef)), 0xdead_beef);
}

#[test]
fn bits_are_counted_from_either_end() {
    assert_eq!(rt::first_leading_bit(Vec3::new(0u32, 1, 0x8000_0000)), Vec3::new(u32::MAX, 0, 31));
    assert_eq!(rt::first_leading_bit(Vec3::new(0, -1, i32::MIN)), Vec3::new(-1, -1, 30));
    assert_eq!(rt::first_trailing_bit(Vec2::new(0, 12)), Vec2::new(-1, 2));
    assert_eq!((rt::count_leading_zeros(0u32), rt::count_trailing_zeros(0)), (32, 32));
    assert_eq!(rt::extract_bits(0xffu32, 40, 3), 0);
    assert_eq!(rt::extract_bits(-2, 28, 100), -1);
    assert_eq!(rt::extract_bits(5u32, 1, 0), 0);
    assert_eq!(rt::insert_bits(0u32, u32::MAX, 30, 9), 0xc000_0000);
    assert_eq!(rt::insert_bits(7, -1, 32, 4), 7);
    assert_eq!(rt::insert_bits(0u32, 0xabcd_1234, 0, 32), 0xabcd_1234);
    assert_eq!(rt::shift_left(Vec2::new(1u32, 1), Vec2::new(33, 31)), Vec2::new(2, 0x8000_0000));
    assert_eq!(rt::shift_right(Vec2::new(-8, -8), Vec2::new(1, 32)), Vec2::new(-4, -8));
}

#[test]
fn indexes_out_of_range_are_the_last() {
    assert_eq!([rt::index(2u32, 3), rt::index(3u32, 3), rt::index(-1i32, 3)], [2, 2, 2]);
    let mut v = Vec4::new(1, 2, 3, 4);
    *v.at_mut(9u32) += 10;
    assert_eq!((v.at(3u32), v.at(-5i32), v.at(0i32)), (14, 14, 1));
}

#[test]
fn matrices_multiply_from_both_sides() {
    let m = Mat::new([Vec3::new(1.0f32, 2.0, 3.0), Vec3::new(4.0, 5.0, 6.0)]);
    assert_eq!(m * Vec2::new(1.0, 10.0), Vec3::new(41.0, 52.0, 63.0));
    assert_eq!(Vec3::new(1.0, 0.0, 2.0) * m, Vec2::new(7.0, 16.0));
    assert_eq!(rt::transpose(m).columns[2], Vec2::new(3.0, 6.0));
    assert_eq!((m * rt::transpose(m)).columns[0], Vec3::new(17.0, 22.0, 27.0));
    let square = Mat::new([
        Vec4::new(2.0, 1.0, 0.0, 3.0),
        Vec4::new(0.0, 1.0, 4.0, 1.0),
        Vec4::new(5.0, 0.0, 1.0, 2.0),
        Vec4::new(1.0, 3.0, 2.0, 1.0),
    ]);
    // By cofactors along the first row.
    assert_eq!(rt::determinant(square), -114.0);
    assert_eq!(rt::determinant(rt::transpose(square)), -114.0);
    assert_eq!(rt::determinant(Mat::new([Vec2::new(1.0, 2.0), Vec2::new(3.0, 4.0)])), -2.0);
}

#[test]
fn geometry_at_its_edges() {
    let down = Vec3::new(0.0, 0.0, -1.0);
    let up = Vec3::new(0.0, 0.0, 1.0);
    assert_eq!(rt::reflect(down, up), up);
    assert_eq!(rt::refract(down, up, 0.5), down);
    let grazing = rt::normalize(Vec3::new(1.0, 0.0, -0.1));
    assert_eq!(rt::refract(grazing, up, 1.5), rt::zero());
    assert_eq!(rt::face_forward(up, up, up), down);
    assert_eq!(rt::length(-3.0f32), 3.0);
    assert_eq!(rt::distance(Vec2::new(3.0, 0.0), Vec2::new(0.0, 4.0)), 5.0);
    assert_eq!(rt::dot(Vec2::new(u32::MAX, 2), Vec2::new(2, 3)), 4);
    assert_eq!(rt::mix(Vec2::new(0.0, 10.0), Vec2::splat(20.0), Vec2::new(0.5, 1.0)), Vec2::new(10.0, 20.0));
    assert_eq!(rt::step(Vec2::new(1.0, 2.0), Vec2::splat(1.0)), Vec2::new(1.0, 0.0));
    assert_eq!(rt::smoothstep(0.0, 2.0, 1.0f32), 0.5);
}

#[test]
fn selections_and_comparisons_go_by_component() {
    let (a, b) = (Vec3::new(1.0, f32::NAN, 3.0), Vec3::new(2.0, 1.0, 3.0));
    assert_eq!(rt::less(a, b), Vec3::new(true, false, false));
    assert_eq!(rt::not_equal(a, b), Vec3::new(true, true, false));
    assert_eq!(rt::select(a, b, rt::less_equal(a, b)).x, 2.0);
    assert!(rt::any(rt::equal(a, b)) && !rt::all(rt::equal(a, b)));
    assert_eq!(!Vec2::new(true, false) | Vec2::splat(false), Vec2::new(false, true));
    assert_eq!(Number::min(3u32, 4), 3);
}
