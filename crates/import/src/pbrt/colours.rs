//! Parameters that are spectra, as linear Rec. 709.

use glam::{DMat3, DVec3, Vec3};

use super::{
    lex::shortened,
    params::{Param, Params, Values},
};
use crate::{
    ImportError,
    files::SceneFolder,
    metals,
    spectrum::{self, Spectrum, in_gamut, rgb_from_xyz, xyz_from_xy},
};

/// The colour space that `rgb` values are in: chromaticities of red, green, blue and white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ColourSpace([(f64, f64); 4]);

const D65: (f64, f64) = (0.3127, 0.3290);

impl ColourSpace {
    pub const SRGB: Self = Self([(0.64, 0.33), (0.3, 0.6), (0.15, 0.06), D65]);

    /// By the name that `ColorSpace` gives.
    pub fn named(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "srgb" => Some(Self::SRGB),
            "dci-p3" => Some(Self([(0.68, 0.32), (0.265, 0.69), (0.15, 0.06), D65])),
            "rec2020" => Some(Self([(0.708, 0.292), (0.17, 0.797), (0.131, 0.046), D65])),
            "aces2065-1" => {
                Some(Self([(0.7347, 0.2653), (0.0, 1.0), (0.0001, -0.077), (0.321_68, 0.337_67)]))
            }
            _ => None,
        }
    }

    /// Of light: what it measures, its white point kept.
    fn emitted(self, rgb: DVec3) -> DVec3 {
        if self == Self::SRGB {
            return rgb;
        }
        let [r, g, b, white] = self.0.map(|(x, y)| xyz_from_xy(x, y));
        let primaries = DMat3::from_cols(r, g, b);
        rgb_from_xyz(primaries * (primaries.inverse() * white * rgb))
    }

    /// Of a surface: white stays white.
    fn reflected(self, rgb: DVec3) -> DVec3 {
        if self == Self::SRGB {
            return rgb;
        }
        self.emitted(rgb) / self.emitted(DVec3::ONE)
    }
}

/// What a spectrum is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// Of a surface, in [0, 1] once all factors are known.
    Albedo,
    /// η, k, absorption: at least 0.
    Unbounded,
    /// Of a light. In pbrt-v4 a light's spectrum is scaled so that the film shows a luminance of 1
    /// nit as 1: what is not RGB has Y = 1. In pbrt-v3 it counts as it is.
    Illuminant,
}

/// Which version's meaning parameters have, where the two differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Version {
    V3,
    V4,
}

/// What spectra are read with.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a> {
    pub folder: &'a SceneFolder,
    pub version: Version,
    pub colour_space: ColourSpace,
}

impl Reader<'_> {
    /// A spectrum by name; none where it is missing or a texture.
    pub fn colour(&self, params: &Params, name: &str, of: Use) -> Result<Option<Vec3>, ImportError> {
        match params.get(name) {
            Some(param) if param.kind != "texture" => self.value(params, param, of).map(Some),
            _ => Ok(None),
        }
    }

    pub fn colour_or(
        &self,
        params: &Params,
        name: &str,
        of: Use,
        default: Vec3,
    ) -> Result<Vec3, ImportError> {
        Ok(self.colour(params, name, of)?.unwrap_or(default))
    }

    fn value(&self, params: &Params, param: &Param, of: Use) -> Result<Vec3, ImportError> {
        let rgb = match &param.values {
            Values::Numbers(numbers) => self.numeric(params, param, numbers, of)?,
            Values::Strings(names) if names.len() == 1 => self.named(params, &names[0], of)?,
            _ => {
                return Err(params.malformed(format!("\"{}\" has to be a spectrum", shortened(&param.name))));
            }
        };
        let rgb = in_gamut(rgb);
        if !rgb.is_finite() {
            return Err(params.malformed(format!("a number of \"{}\" is too large", shortened(&param.name))));
        }
        Ok(rgb)
    }

    fn numeric(
        &self,
        params: &Params,
        param: &Param,
        numbers: &[f64],
        of: Use,
    ) -> Result<DVec3, ImportError> {
        match (param.kind.as_str(), numbers) {
            ("rgb" | "color", &[r, g, b]) => {
                let rgb = DVec3::new(r, g, b);
                let space = self.colour_space;
                Ok(if of == Use::Illuminant { space.emitted(rgb) } else { space.reflected(rgb) })
            }
            ("xyz", &[x, y, z]) => Ok(rgb_from_xyz(DVec3::new(x, y, z))),
            ("float" | "integer" | "rgb" | "color", &[grey]) => Ok(DVec3::splat(grey)),
            ("blackbody", &[kelvin]) if kelvin > 0.0 => Ok(self.blackbody(kelvin, 1.0)),
            ("blackbody", &[kelvin, scale]) if kelvin > 0.0 => Ok(self.blackbody(kelvin, scale)),
            ("spectrum", pairs) if !pairs.is_empty() && pairs.len().is_multiple_of(2) => {
                let samples = pairs.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
                let spectrum = Spectrum::new(samples);
                Ok(spectrum.map_or(DVec3::ZERO, |s| self.spectrum(&s, of)))
            }
            (kind, _) => {
                let (kind, name) = (shortened(kind), shortened(&param.name));
                let problem =
                    format!("\"{name}\" has the wrong number of values, or bad ones, for a \"{kind}\"");
                Err(params.malformed(problem))
            }
        }
    }

    fn blackbody(&self, kelvin: f64, scale: f64) -> DVec3 {
        let rgb = match self.version {
            Version::V3 => spectrum::blackbody_peak_one(kelvin),
            Version::V4 => spectrum::blackbody(kelvin),
        };
        rgb.as_dvec3() * scale
    }

    fn spectrum(&self, spectrum: &Spectrum, of: Use) -> DVec3 {
        if of != Use::Illuminant {
            return spectrum.weighted();
        }
        let rgb = spectrum.emission();
        // Rec. 709's luminance.
        let luminance = rgb.dot(DVec3::new(0.212_639, 0.715_169, 0.072_192));
        if self.version == Version::V4 && luminance > 0.0 { rgb / luminance } else { rgb }
    }

    /// A spectrum that pbrt knows by name, or a file.
    fn named(&self, params: &Params, name: &str, of: Use) -> Result<DVec3, ImportError> {
        let light = name.strip_prefix("stdillum-").or(name.strip_prefix("illum-"));
        if let Some(rgb) = light.and_then(spectrum::illuminant) {
            return Ok(rgb.as_dvec3());
        }
        if let Some(metal) = name.strip_prefix("metal-") {
            let (symbol, which) = metal.rsplit_once('-').unwrap_or((metal, ""));
            if let Some(ior) = metals::metal(symbol) {
                return Ok(if which == "k" { ior.k } else { ior.eta }.as_dvec3());
            }
        }
        if let Some(ior) = metals::glass(name) {
            return Ok(DVec3::splat(f64::from(ior)));
        }
        let bytes = self.folder.read_text(name, &params.place)?;
        let spectrum = Spectrum::parse(&String::from_utf8_lossy(&bytes)).ok_or_else(|| {
            let problem = format!("\"{}\" does not hold wavelengths and values", shortened(name));
            params.malformed(problem)
        })?;
        Ok(self.spectrum(&spectrum, of))
    }

    /// An index of refraction: a number, or a glass.
    pub fn ior(&self, params: &Params, names: &[&str], default: f32) -> Result<f32, ImportError> {
        for name in names {
            // Green stands for a glass that disperses.
            if let Some(rgb) = self.colour(params, name, Use::Unbounded)? {
                if rgb.y > 0.0 {
                    return Ok(rgb.y);
                }
                return Err(params.malformed(format!("\"{name}\" has to be above 0")));
            }
        }
        Ok(default)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colour_spaces_share_their_white() {
        for name in ["dci-p3", "rec2020", "aces2065-1", "sRGB"] {
            let space = ColourSpace::named(name).unwrap();
            let white = space.reflected(DVec3::ONE);
            assert!((white - DVec3::ONE).abs().max_element() <= 1e-12, "{name}: {white}");
        }
        let p3 = ColourSpace::named("DCI-P3").unwrap();
        // The P3 red in Rec. 709 by ITU-R BT.2407's method.
        let red = p3.emitted(DVec3::X);
        assert!((red - DVec3::new(1.2249, -0.0420, -0.0196)).abs().max_element() <= 1e-3, "{red}");
        assert_eq!(ColourSpace::named("cmyk"), None);
    }
}
