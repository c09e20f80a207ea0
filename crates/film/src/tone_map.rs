//! From scene-linear radiance to what a display shows.

/// How values beyond the display's range are brought into it. All work on linear Rec. 709 and give
/// linear Rec. 709 in [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Clipped at 1.
    #[default]
    Linear,
    /// AgX, its base look: Sobotka's transform in Wrensch's polynomial fit (sixth degree).
    Agx,
    /// ACES: the RRT and sRGB ODT in Hill's fit.
    Aces,
    /// Khronos PBR Neutral: leaves colours below 0.8 nearly as they are.
    PbrNeutral,
}

/// Exposure, then a tone map, then the sRGB transfer curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// In stops: values are multiplied by 2 to this power.
    pub exposure: f32,
    /// How the result is brought into [0, 1].
    pub tone_map: ToneMap,
}

impl Display {
    /// The sRGB-encoded colour in [0, 1]. A pixel that is not finite shows as magenta: it must be
    /// seen.
    #[must_use]
    pub fn encode(&self, linear: [f32; 3]) -> [f32; 3] {
        if linear.iter().any(|value| !value.is_finite()) {
            return [1.0, 0.0, 1.0];
        }
        let scale = self.exposure.exp2();
        let exposed = linear.map(|value| (value * scale).clamp(0.0, f32::MAX));
        let mapped = match self.tone_map {
            ToneMap::Linear => exposed,
            ToneMap::Agx => agx(exposed),
            ToneMap::Aces => aces(exposed),
            ToneMap::PbrNeutral => pbr_neutral(exposed),
        };
        mapped.map(|value| srgb_from_linear(value.clamp(0.0, 1.0)))
    }

    /// [`Display::encode`], rounded to 8 bits.
    #[must_use]
    pub fn encode_u8(&self, linear: [f32; 3]) -> [u8; 3] {
        self.encode(linear).map(|value| (value * 255.0 + 0.5) as u8)
    }
}

/// IEC 61966-2-1's curve, for values in [0, 1].
pub(crate) fn srgb_from_linear(value: f32) -> f32 {
    if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`srgb_from_linear`].
pub(crate) fn linear_from_srgb(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// `rows` times the column vector `v`.
pub(crate) fn transform(rows: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// The range of AgX's log2 encoding, in stops.
const AGX_MIN_EV: f32 = -12.473_93;
const AGX_MAX_EV: f32 = 4.026_069;

const AGX_INSET: [[f32; 3]; 3] = [
    [0.842_479_05, 0.078_433_6, 0.079_223_745],
    [0.042_328_242, 0.878_468_64, 0.079_166_13],
    [0.042_375_654, 0.078_433_6, 0.879_143],
];

const AGX_OUTSET: [[f32; 3]; 3] = [
    [1.196_879, -0.098_020_88, -0.099_029_74],
    [-0.052_896_85, 1.151_903_1, -0.098_961_174],
    [-0.052_971_635, -0.098_043_45, 1.151_073_7],
];

fn agx(colour: [f32; 3]) -> [f32; 3] {
    let curved = transform(&AGX_INSET, colour).map(|value| {
        let log = value.max(1e-10).log2().clamp(AGX_MIN_EV, AGX_MAX_EV);
        agx_contrast((log - AGX_MIN_EV) / (AGX_MAX_EV - AGX_MIN_EV))
    });
    transform(&AGX_OUTSET, curved).map(|value| value.max(0.0).powf(2.2))
}

/// The sigmoid in AgX's log space, as a polynomial.
fn agx_contrast(x: f32) -> f32 {
    let x2 = x * x;
    let x4 = x2 * x2;
    15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232
}

const ACES_INPUT: [[f32; 3]; 3] =
    [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];

const ACES_OUTPUT: [[f32; 3]; 3] =
    [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];

fn aces(colour: [f32; 3]) -> [f32; 3] {
    // Beyond 1e6 the fit is at its limit of 1 and its squares would overflow.
    let curved = transform(&ACES_INPUT, colour.map(|value| value.min(1e6)))
        .map(|v| (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081));
    transform(&ACES_OUTPUT, curved)
}

/// Where PBR Neutral begins to compress: 0.8 less the 0.04 that a dielectric reflects.
const NEUTRAL_START: f32 = 0.76;
const NEUTRAL_DESATURATION: f32 = 0.15;

fn pbr_neutral(colour: [f32; 3]) -> [f32; 3] {
    let least = colour[0].min(colour[1]).min(colour[2]);
    let offset = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let colour = colour.map(|value| value - offset);
    let peak = colour[0].max(colour[1]).max(colour[2]);
    if peak < NEUTRAL_START {
        return colour;
    }
    let d = 1.0 - NEUTRAL_START;
    let new_peak = 1.0 - d * d / (peak + d - NEUTRAL_START);
    let grey = 1.0 - 1.0 / (NEUTRAL_DESATURATION * (peak - new_peak) + 1.0);
    colour.map(|value| value * (new_peak / peak) * (1.0 - grey) + new_peak * grey)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [ToneMap; 4] = [ToneMap::Linear, ToneMap::Agx, ToneMap::Aces, ToneMap::PbrNeutral];

    #[test]
    fn srgb_curve_has_its_known_values_and_inverse() {
        assert!((srgb_from_linear(0.18) - 0.461_356).abs() <= 1e-5);
        assert!((srgb_from_linear(1.0) - 1.0).abs() <= 1e-6);
        for i in 0..=100 {
            let value = i as f32 / 100.0;
            assert!((linear_from_srgb(srgb_from_linear(value)) - value).abs() <= 1e-6);
        }
    }

    #[test]
    fn exposure_is_in_stops() {
        let display = Display { exposure: 1.0, tone_map: ToneMap::Linear };
        assert_eq!(display.encode_u8([0.5, 0.25, 2.0]), [255, 188, 255]);
    }

    #[test]
    fn grey_stays_grey_rises_and_ends_near_white() {
        for tone_map in ALL {
            let display = Display { exposure: 0.0, tone_map };
            let mut last = -1.0;
            for i in 0..200 {
                let [r, g, b] = display.encode([10.0_f32.powf(i as f32 * 0.03 - 3.0); 3]);
                assert!((r - g).abs() <= 2e-3 && (g - b).abs() <= 2e-3, "{tone_map:?}");
                assert!(g >= last - 1e-4, "{tone_map:?} falls at step {i}");
                last = g;
            }
            assert!(last >= 0.95, "{tone_map:?} ends at {last}");
        }
    }

    #[test]
    fn extremes_stay_in_range_and_nan_is_magenta() {
        for tone_map in ALL {
            let display = Display { exposure: 3.0, tone_map };
            for colour in [[f32::MAX; 3], [-5.0, 0.0, 1e30], [0.0; 3], [1e-40; 3]] {
                let encoded = display.encode(colour);
                assert!(
                    encoded.iter().all(|v| (0.0..=1.0).contains(v)),
                    "{tone_map:?} {colour:?} {encoded:?}"
                );
            }
            assert_eq!(display.encode_u8([0.1, f32::NAN, 0.1]), [255, 0, 255]);
        }
    }
}
