//! Spectra, and the linear Rec. 709 they come to.
//!
//! Matching functions are the multi-lobe fit of C. Wyman, P.-P. Sloan, P. Shirley, "Simple Analytic
//! Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2), 2013, eq. 4.

use glam::{DMat3, DVec3, Vec3, dvec3};

/// Where the matching functions are more than nothing, nanometres.
const FIRST: usize = 360;
const LAST: usize = 830;
/// ∫ ȳ dλ of the fit, nanometres.
const Y_INTEGRAL: f64 = 106.944;
/// The standard illuminant D65 from 380 to 780 nm, every 10 nm (CIE 15:2004, table T.1).
const D65: [f64; 41] = [
    49.98, 54.65, 82.75, 91.49, 93.43, 86.68, 104.86, 117.01, 117.81, 114.86, 115.92, 108.81, 109.35, 107.80,
    104.79, 107.69, 104.41, 104.05, 100.00, 96.33, 95.79, 88.69, 90.01, 89.60, 87.70, 83.29, 83.70, 80.03,
    80.21, 82.28, 78.28, 69.72, 71.61, 74.35, 61.60, 69.89, 75.09, 63.59, 46.42, 66.81, 63.38,
];

/// Chromaticities of standard illuminants (CIE 15:2004, tables T.3 and T.6.1; ACES TB-2014-004).
const ILLUMINANTS: [(&str, f64, f64); 16] = [
    ("A", 0.447_58, 0.407_45),
    ("D50", 0.345_67, 0.358_50),
    ("D65", 0.312_72, 0.329_03),
    ("acesD60", 0.321_68, 0.337_67),
    ("F1", 0.313_10, 0.337_27),
    ("F2", 0.372_08, 0.375_29),
    ("F3", 0.409_10, 0.394_30),
    ("F4", 0.440_18, 0.403_29),
    ("F5", 0.313_79, 0.345_31),
    ("F6", 0.377_90, 0.388_35),
    ("F7", 0.312_92, 0.329_33),
    ("F8", 0.345_88, 0.358_75),
    ("F9", 0.374_17, 0.372_81),
    ("F10", 0.346_09, 0.359_86),
    ("F11", 0.380_52, 0.377_13),
    ("F12", 0.436_95, 0.404_41),
];

/// Values at wavelengths, straight between them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spectrum {
    /// Nanometres and value, by rising wavelength; never empty.
    samples: Vec<(f64, f64)>,
}

impl Spectrum {
    /// None where there are no samples or a number is not finite.
    pub fn new(mut samples: Vec<(f64, f64)>) -> Option<Self> {
        let finite = samples.iter().all(|(l, v)| l.is_finite() && v.is_finite());
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        (finite && !samples.is_empty()).then_some(Self { samples })
    }

    /// A text of wavelengths and values, `#` to the end of a line left out (`.spd`).
    pub fn parse(text: &str) -> Option<Self> {
        let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
        let words = lines.flat_map(|line| line.split(|c: char| c.is_whitespace() || c == ','));
        let numbers: Result<Vec<f64>, _> = words.filter(|w| !w.is_empty()).map(str::parse).collect();
        let numbers = numbers.ok()?;
        let pairs = numbers.chunks_exact(2);
        if !pairs.remainder().is_empty() {
            return None;
        }
        Self::new(pairs.map(|pair| (pair[0], pair[1])).collect())
    }

    /// Its value; beyond its ends that of the nearer one.
    fn at(&self, wavelength: f64) -> f64 {
        let after = self.samples.partition_point(|(l, _)| *l <= wavelength);
        let last = self.samples.len() - 1;
        let ((l0, v0), (l1, v1)) = (self.samples[after.saturating_sub(1)], self.samples[after.min(last)]);
        if l1 > l0 { v0 + (v1 - v0) * ((wavelength - l0) / (l1 - l0)).clamp(0.0, 1.0) } else { v0 }
    }

    fn covers(&self, wavelength: f64) -> bool {
        self.samples[0].0 <= wavelength && wavelength <= self.samples[self.samples.len() - 1].0
    }

    /// What is emitted, nothing beyond its ends: linear Rec. 709 by ∫ x̄ L dλ / ∫ ȳ dλ and so on,
    /// so that an equal-energy spectrum of 1 has Y = 1. May be negative.
    pub fn emission(&self) -> DVec3 {
        rgb_from_xyz(integrate(|l| if self.covers(l) { self.at(l) } else { 0.0 }) / Y_INTEGRAL)
    }

    /// What is reflected, absorbed or refracted: under D65, so that 1 everywhere is (1, 1, 1).
    /// May be negative.
    pub fn weighted(&self) -> DVec3 {
        let white = rgb_from_xyz(integrate(d65));
        rgb_from_xyz(integrate(|l| self.at(l) * d65(l))) / white
    }
}

/// D65, 100 at 560 nm.
fn d65(wavelength: f64) -> f64 {
    let at = ((wavelength - 380.0) / 10.0).clamp(0.0, 40.0);
    let below = (at as usize).min(39);
    D65[below] + (D65[below + 1] - D65[below]) * (at - below as f64)
}

fn integrate(value: impl Fn(f64) -> f64) -> DVec3 {
    (FIRST..=LAST).map(|l| l as f64).map(|l| matching(l) * value(l)).sum()
}

/// x̄, ȳ, z̄.
fn matching(wavelength: f64) -> DVec3 {
    let lobe = |centre: f64, below: f64, above: f64| {
        let t = (wavelength - centre) * if wavelength < centre { below } else { above };
        (-0.5 * t * t).exp()
    };
    dvec3(
        0.362 * lobe(442.0, 0.0624, 0.0374) + 1.056 * lobe(599.8, 0.0264, 0.0323)
            - 0.065 * lobe(501.1, 0.0490, 0.0382),
        0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322),
        1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725),
    )
}

/// Linear Rec. 709 of CIE XYZ (IEC 61966-2-1).
pub(crate) fn rgb_from_xyz(xyz: DVec3) -> DVec3 {
    DMat3::from_cols_array_2d(&[
        [3.240_454_2, -0.969_266_0, 0.055_643_4],
        [-1.537_138_5, 1.876_010_8, -0.204_025_9],
        [-0.498_531_4, 0.041_556_0, 1.057_225_2],
    ]) * xyz
}

/// XYZ of a chromaticity, Y = 1.
pub(crate) fn xyz_from_xy(x: f64, y: f64) -> DVec3 {
    dvec3(x / y, 1.0, (1.0 - x - y) / y)
}

/// Linear Rec. 709 of a black body of a temperature in kelvin, > 0; its luminance Y is 1, and
/// what is beyond the gamut is cut off.
pub(crate) fn blackbody(kelvin: f64) -> Vec3 {
    let xyz = integrate(|l| planck(l, kelvin));
    in_gamut(rgb_from_xyz(xyz / xyz.y.max(f64::MIN_POSITIVE)))
}

/// The same, scaled so that the spectrum's greatest value is 1 (pbrt-v3).
pub(crate) fn blackbody_peak_one(kelvin: f64) -> Vec3 {
    // Wien's displacement law, in nanometre kelvins.
    let peak = planck(2.897_772_1e6 / kelvin, kelvin);
    in_gamut(rgb_from_xyz(integrate(|l| planck(l, kelvin) / peak) / Y_INTEGRAL))
}

/// Planck's law, up to a constant that is near enough 1 for the numbers to be held.
fn planck(nanometres: f64, kelvin: f64) -> f64 {
    // h c / k_B, in nanometre kelvins.
    const C2: f64 = 1.438_776_877e7;
    (nanometres / 500.0).powi(-5) / (C2 / (nanometres * kelvin)).exp_m1()
}

/// Linear Rec. 709 of a standard illuminant by name (`A`, `D65`, `F11`, `acesD60`), Y = 1.
pub(crate) fn illuminant(name: &str) -> Option<Vec3> {
    let (_, x, y) = ILLUMINANTS.iter().find(|(known, ..)| known.eq_ignore_ascii_case(name))?;
    Some(in_gamut(rgb_from_xyz(xyz_from_xy(*x, *y))))
}

/// Negative parts cut off.
pub(crate) fn in_gamut(rgb: DVec3) -> Vec3 {
    rgb.max(DVec3::ZERO).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Vec3, b: [f32; 3], tolerance: f32) {
        assert!((a - Vec3::from_array(b)).abs().max_element() <= tolerance, "{a} is not {b:?}");
    }

    #[test]
    fn constant_spectra() {
        let one = Spectrum::new(vec![(300.0, 1.0), (900.0, 1.0)]).unwrap();
        near(one.weighted().as_vec3(), [1.0; 3], 1e-6);
        // Illuminant E in Rec. 709; the fit is good to 0.8 %.
        near(one.emission().as_vec3(), [1.2048, 0.9484, 0.9087], 0.008);
        assert!((matching_sum() - Y_INTEGRAL).abs() <= 0.01, "{}", matching_sum());
    }

    fn matching_sum() -> f64 {
        integrate(|_| 1.0).y
    }

    #[test]
    fn illuminants_and_black_bodies() {
        near(illuminant("D65").unwrap(), [1.0; 3], 2e-3);
        // Illuminant A is a black body of 2856 K.
        let a = illuminant("a").unwrap();
        near(blackbody(2856.0), a.to_array(), 0.025);
        assert!(a.x > a.y && a.y > a.z);
        let daylight = Spectrum::new((380..=780).map(|l| (f64::from(l), d65(f64::from(l)))).collect());
        let rgb = daylight.unwrap().emission();
        near((rgb / rgb.y).as_vec3(), [1.0; 3], 0.01);
        // The peak of 5000 K lies at 580 nm: its luminance is near that of a constant 1.
        let peak_one = blackbody_peak_one(5000.0).as_dvec3();
        assert!((peak_one.dot(dvec3(0.2126, 0.7152, 0.0722)) - 0.98).abs() <= 0.02, "{peak_one}");
        assert_eq!(illuminant("Z"), None);
    }

    #[test]
    fn samples_in_any_order_and_files() {
        let ramp = Spectrum::parse("# nm value\n700 2 \n 400,1\n").unwrap();
        assert_eq!([ramp.at(300.0), ramp.at(400.0), ramp.at(550.0), ramp.at(800.0)], [1.0, 1.0, 1.5, 2.0]);
        let rgb = ramp.weighted();
        assert!(rgb.x > rgb.y && rgb.y > rgb.z && rgb.z > 1.0 && rgb.x < 2.0, "{rgb}");
        for bad in ["", "400", "400 x", "400 nan", "# only"] {
            assert_eq!(Spectrum::parse(bad), None, "{bad:?}");
        }
        assert_eq!(Spectrum::parse("500 3").unwrap().at(100.0), 3.0);
    }
}
