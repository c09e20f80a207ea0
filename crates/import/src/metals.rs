//! Complex indices of refraction of metals, and glasses' indices, by the names that Mitsuba and pbrt know.
//!
//! η and k are the spectra of the references below, as the refractiveindex.info database (M. N.
//! Polyanskiy, CC0) holds them, weighted by the CIE 1931 matching functions under D65, so that a
//! spectrum that is 1 everywhere gives 1 for each of R, G and B. Reflectance at normal incidence
//! computed from them is within 0.015 of the spectral one, but for gold's and copper's red, which
//! is beyond Rec. 709.

use glam::{Vec3, vec3};

/// A metal's η and k for R, G and B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ComplexIor {
    pub eta: Vec3,
    pub k: Vec3,
}

/// By chemical symbol as Mitsuba and pbrt spell it (`Au`, `CuZn`, `TiO2`), a suffix for the source
/// of the data (`Ag_palik`) disregarded; none where it is not known.
pub(crate) fn metal(name: &str) -> Option<ComplexIor> {
    let symbol = name.split('_').next().unwrap_or_default();
    let row = METALS.iter().find(|(known, ..)| known.eq_ignore_ascii_case(symbol))?;
    Some(ComplexIor { eta: row.1, k: row.2 })
}

/// Index of refraction at 589.3 nm of a glass by its catalogue name, as pbrt has them (`BK7`, or `glass-BK7`).
pub(crate) fn glass(name: &str) -> Option<f32> {
    let name = name.strip_prefix("glass-").unwrap_or(name);
    let name = name.strip_suffix("-eta").unwrap_or(name);
    GLASSES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, ior)| *ior)
}

/// Symbol, η, k.
#[expect(clippy::approx_constant, reason = "beryllium's k is near π by chance")]
const METALS: [(&str, Vec3, Vec3); 26] = [
    // P. B. Johnson, R. W. Christy, Phys. Rev. B 6, 4370 (1972).
    ("Ag", vec3(0.056, 0.055, 0.043), vec3(4.354, 3.535, 2.567)),
    ("Au", vec3(0.063, 0.498, 1.460), vec3(3.601, 2.330, 1.818)),
    ("Cu", vec3(0.178, 1.041, 1.290), vec3(3.270, 2.605, 2.366)),
    // P. B. Johnson, R. W. Christy, Phys. Rev. B 9, 5056 (1974).
    ("Co", vec3(2.247, 2.034, 1.709), vec3(4.212, 3.794, 3.232)),
    ("Cr", vec3(3.249, 3.108, 2.279), vec3(3.287, 3.338, 3.124)),
    ("Fe", vec3(2.923, 2.918, 2.545), vec3(3.074, 2.938, 2.750)),
    ("Mn", vec3(2.563, 2.380, 2.092), vec3(3.613, 3.309, 2.943)),
    ("Ni", vec3(2.021, 1.902, 1.724), vec3(4.165, 3.568, 2.885)),
    ("Pd", vec3(1.786, 1.621, 1.392), vec3(4.338, 3.811, 3.204)),
    ("Ti", vec3(2.734, 2.509, 2.236), vec3(3.824, 3.400, 3.009)),
    ("V", vec3(3.480, 3.957, 3.617), vec3(2.973, 3.082, 3.472)),
    // A. D. Rakić, Appl. Opt. 34, 4755 (1995).
    ("Al", vec3(1.473, 0.986, 0.598), vec3(7.637, 6.556, 5.346)),
    // A. D. Rakić et al., Appl. Opt. 37, 5271 (1998), Lorentz-Drude.
    ("Be", vec3(3.454, 3.339, 3.056), vec3(3.177, 3.152, 3.141)),
    ("Pt", vec3(2.335, 2.075, 1.828), vec3(4.211, 3.668, 3.087)),
    ("W", vec3(3.686, 3.443, 3.354), vec3(2.937, 2.734, 2.509)),
    // M. R. Querry, Optical constants, CRDC-CR-85034 (1985): Cu70Zn30.
    ("CuZn", vec3(0.421, 0.519, 1.123), vec3(3.656, 2.687, 1.770)),
    // T. Inagaki et al., Phys. Rev. B 23, 5246 (1981).
    ("Hg", vec3(2.021, 1.519, 1.016), vec3(5.294, 4.608, 3.790)),
    // N. V. Smith, Phys. Rev. 183, 634 (1969).
    ("K", vec3(0.054, 0.049, 0.042), vec3(1.764, 1.425, 1.018)),
    ("Na", vec3(0.049, 0.059, 0.068), vec3(2.661, 2.230, 1.751)),
    // M. Rasigni, G. Rasigni, J. Opt. Soc. Am. 67, 54 (1977).
    ("Li", vec3(0.221, 0.206, 0.242), vec3(2.971, 2.437, 1.854)),
    // M. M. Kirillova et al., Sov. Phys. JETP 33, 1210 (1971).
    ("Mo", vec3(3.470, 3.358, 2.796), vec3(3.527, 3.653, 3.528)),
    // J. H. Weaver et al., Phys. Rev. B 7, 4311 (1973).
    ("Nb", vec3(2.911, 2.910, 2.621), vec3(2.830, 2.887, 2.812)),
    // J. H. Weaver et al., Phys. Rev. B 15, 4115 (1977).
    ("Rh", vec3(2.156, 1.961, 1.722), vec3(5.671, 4.960, 4.390)),
    // D. E. Aspnes, A. A. Studna, Phys. Rev. B 27, 985 (1983).
    ("Si", vec3(3.856, 4.091, 4.749), vec3(0.018, 0.039, 0.160)),
    // R. E. Stephens, I. H. Malitson, J. Res. Natl. Bur. Stand. 49, 249 (1952).
    ("MgO", vec3(1.734, 1.741, 1.754), Vec3::ZERO),
    // J. R. Devore, J. Opt. Soc. Am. 41, 416 (1951), ordinary ray of rutile.
    ("TiO2", vec3(2.574, 2.651, 2.830), Vec3::ZERO),
];

/// Catalogue name and index at 589.3 nm (Schott).
const GLASSES: [(&str, f32); 9] = [
    ("BK7", 1.516_8),
    ("BAF10", 1.670_0),
    ("FK51A", 1.486_6),
    ("LASF9", 1.850_2),
    ("F5", 1.603_4),
    ("SF5", 1.672_7),
    ("SF10", 1.728_2),
    ("SF11", 1.784_7),
    ("fused-silica", 1.458_4),
];

#[cfg(test)]
mod tests {
    use super::*;

    fn normal_reflectance(ior: ComplexIor) -> Vec3 {
        let (n, k2) = (ior.eta, ior.k * ior.k);
        ((n - 1.0) * (n - 1.0) + k2) / ((n + 1.0) * (n + 1.0) + k2)
    }

    #[test]
    fn metals_look_as_they_do() {
        let of = |name| normal_reflectance(metal(name).unwrap());
        let [gold, copper, silver, aluminium] = ["Au", "Cu_palik", "ag", "Al"].map(of);
        assert!(gold.x > 0.95 && gold.y > 0.6 && gold.y < 0.85 && gold.z < 0.5, "{gold}");
        assert!(copper.x > 0.9 && copper.y < 0.7 && copper.z < copper.y, "{copper}");
        assert!(silver.min_element() > 0.95, "{silver}");
        assert!((aluminium - Vec3::splat(0.915)).abs().max_element() <= 0.01, "{aluminium}");
        assert_eq!(metal("unobtainium"), None);
    }

    #[test]
    fn glasses_by_either_name() {
        assert_eq!(glass("glass-BK7"), glass("BK7"));
        assert_eq!(glass("none"), None);
    }
}
