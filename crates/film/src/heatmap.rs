//! Error maps as pictures.

/// The magma colour map (Smith and van der Walt), in Zucker's polynomial fit: sRGB in [0, 1] for a
/// value in [0, 1]. A value that is not finite is cyan, which the map does not have.
#[must_use]
pub fn magma(value: f32) -> [f32; 3] {
    const COEFFICIENTS: [[f32; 3]; 7] = [
        [-0.002_136_485, -0.000_749_655, -0.005_386_128],
        [0.251_660_54, 0.677_523_24, 2.494_026_6],
        [8.353_717, -3.577_719_5, 0.314_467_9],
        [-27.668_734, 14.264_731, -13.649_213],
        [52.176_14, -27.943_606, 12.944_169],
        [-50.768_525, 29.046_583, 4.234_153],
        [18.655_705, -11.489_774, -5.601_961_5],
    ];
    if !value.is_finite() {
        return [0.0, 1.0, 1.0];
    }
    let t = value.clamp(0.0, 1.0);
    let horner = |i: usize| COEFFICIENTS.iter().rev().fold(0.0, |sum, c| sum * t + c[i]);
    [0, 1, 2].map(|i| horner(i).clamp(0.0, 1.0))
}

/// 8-bit sRGB of an error map, black at 0 and near white at `white` and beyond.
#[must_use]
pub fn heatmap(errors: &[f32], white: f32) -> Vec<u8> {
    let colour = |error: &f32| magma(error / white).map(|value| (value * 255.0 + 0.5) as u8);
    errors.iter().flat_map(colour).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_table_of_magma() {
        let table =
            [(0, [0.0015, 0.0005, 0.0139]), (128, [0.7163, 0.2148, 0.4753]), (255, [0.9871, 0.9914, 0.7495])];
        for (index, expected) in table {
            let found = magma(index as f32 / 255.0);
            for (a, b) in found.iter().zip(expected) {
                assert!((a - b).abs() <= 0.02, "{index}: {found:?}");
            }
        }
    }

    #[test]
    fn nan_stands_out() {
        assert_eq!(heatmap(&[f32::NAN, 0.0], 1.0)[..3], [0, 255, 255]);
        assert_eq!(magma(7.0), magma(1.0));
    }
}
