//! Against values from the authors' own C++ code (through the crate `nv-flip` 0.1.2, 67 pixels a
//! degree, the same pictures).

use super::*;

/// 64 x 48 pictures of 8-bit sRGB, made linear: gradients, noise, a checkerboard, flat colours.
fn picture(kind: u32) -> Image {
    let mut state = 12_345 + kind;
    Image::from_fn(64, 48, |x, y| {
        let (x, y) = (x as u32, y as u32);
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = state >> 24;
        let rgb = match kind {
            0 => [x * 255 / 63, y * 255 / 47, 128],
            1 => [x * 255 / 63, (y * 255 / 47) * 9 / 10, 128],
            2 => [noise, noise / 2, 255 - noise],
            3 => [if (x / 8 + y / 8) % 2 == 0 { 255 } else { 0 }; 3],
            4 => [0, 0, 0],
            5 => [255, 255, 255],
            6 => [0, 255, 0],
            7 => [0, 0, 255],
            _ => [128, 130, 132],
        };
        rgb.map(|value| linear_from_srgb(value as f32 / 255.0))
    })
}

#[test]
fn agrees_with_the_authors_code() {
    // (one, other, mean, at (0, 0), at (30, 20))
    let cases = [
        (0, 1, 0.293_725, 0.008_532, 0.246_584),
        (0, 2, 0.779_076, 0.840_682, 0.607_295),
        (3, 0, 0.936_064, 0.973_286, 0.760_239),
        (2, 3, 0.954_460, 0.972_259, 0.873_468),
        (4, 5, 0.967_392, 0.967_392, 0.967_392),
        (6, 7, 1.0, 1.0, 1.0),
        (8, 4, 0.950_050, 0.950_050, 0.950_050),
        (0, 0, 0.0, 0.0, 0.0),
    ];
    for (one, other, mean, first, inner) in cases {
        let map = flip(&picture(one), &picture(other), 67.0).unwrap();
        let found = map.iter().map(|error| f64::from(*error)).sum::<f64>() / map.len() as f64;
        // Where nothing differs but rounding, the two powers below 1 enlarge it.
        let close = |a: f32, b: f32| (a - b).abs() <= 2e-3;
        assert!((found - mean).abs() <= 2e-4, "{one}, {other}: mean {found} instead of {mean}");
        assert!(close(map[0], first) && close(map[20 * 64 + 30], inner), "{one}, {other}");
    }
}

#[test]
fn it_does_not_matter_which_is_the_reference() {
    let (a, b) = (picture(0), picture(2));
    assert_eq!(flip(&a, &b, 67.0).unwrap(), flip(&b, &a, 67.0).unwrap());
}

#[test]
fn brighter_than_the_display_is_white() {
    let (white, brighter) = (Image::filled(9, 9, [1.0; 3]), Image::filled(9, 9, [50.0; 3]));
    assert!(flip(&white, &brighter, 67.0).unwrap().iter().all(|error| *error == 0.0));
}

#[test]
fn an_image_smaller_than_the_filters_works() {
    let (a, b) = (Image::filled(1, 1, [0.2; 3]), Image::filled(1, 1, [0.9; 3]));
    let map = flip(&a, &b, 67.0).unwrap();
    assert!(map[0] > 0.1 && map[0] <= 1.0);
}
