//! What properties hold, as the file writes it.

use std::collections::HashMap;

use glam::{Mat4, Vec3};

use super::transform;
use crate::spectrum::{Spectrum, blackbody, in_gamut};

/// The value of a property.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Boolean(bool),
    Integer(i64),
    Float(f32),
    Text(String),
    Vector(Vec3),
    /// Linear Rec. 709.
    Rgb(Vec3),
    /// The same for all wavelengths.
    Constant(f32),
    Spectrum(Spectrum),
    Transform(Mat4),
}

/// What a spectrum is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    /// A share of light: seen under D65, so that 1 is white.
    Share,
    /// Light, or an index of refraction: no illuminant, as Mitsuba's RGB mode has it.
    Unbounded,
}

impl Value {
    /// Linear Rec. 709; none where it is no colour. A constant is white.
    pub fn color(&self, quantity: Quantity) -> Option<Vec3> {
        match self {
            Self::Rgb(rgb) => Some(*rgb),
            Self::Constant(value) | Self::Float(value) => Some(Vec3::splat(*value)),
            Self::Integer(value) => Some(Vec3::splat(*value as f32)),
            Self::Spectrum(spectrum) => Some(match quantity {
                Quantity::Share => in_gamut(spectrum.weighted()),
                Quantity::Unbounded => spectrum.emission().as_vec3().max(Vec3::ZERO),
            }),
            _ => None,
        }
    }
}

/// Numbers separated by commas, white space or both; none where one is not a finite number.
pub(super) fn numbers(text: &str) -> Option<Vec<f32>> {
    let words = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
    words.map(number).collect()
}

/// A finite number.
pub(super) fn number(text: &str) -> Option<f32> {
    text.trim().parse().ok().filter(|x: &f32| x.is_finite())
}

/// Three numbers.
pub(super) fn triple(text: &str) -> Option<Vec3> {
    match numbers(text)?[..] {
        [x, y, z] => Some(Vec3::new(x, y, z)),
        _ => None,
    }
}

/// `#rrggbb` (by the sRGB curve), one number or three.
pub(super) fn rgb(text: &str) -> Option<Vec3> {
    if let Some(hex) = text.trim().strip_prefix('#') {
        let digits = (hex.len() == 6).then(|| u32::from_str_radix(hex, 16).ok()).flatten()?;
        let [_, r, g, b] = digits.to_be_bytes();
        return Some(Vec3::from([r, g, b].map(midway_scene::srgb_to_linear)));
    }
    match numbers(text)?[..] {
        [grey] => Some(Vec3::splat(grey)),
        [r, g, b] => Some(Vec3::new(r, g, b)),
        _ => None,
    }
}

/// Three numbers by the sRGB curve (`<srgb>`), or `#rrggbb`.
pub(super) fn srgb(text: &str) -> Option<Vec3> {
    let decode = |x: f32| if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    let value = rgb(text)?;
    Some(if text.trim().starts_with('#') { value } else { value.map(decode) })
}

/// One number, three (linear RGB), or `wavelength:value` pairs in nanometres.
pub(super) fn spectrum(text: &str) -> Option<Value> {
    if text.contains(':') {
        let words = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
        let pair = |word: &str| {
            let (wavelength, value) = word.split_once(':')?;
            Some((f64::from(number(wavelength)?), f64::from(number(value)?)))
        };
        return Spectrum::new(words.map(pair).collect::<Option<_>>()?).map(Value::Spectrum);
    }
    if text.trim().starts_with('#') {
        return rgb(text).map(Value::Rgb);
    }
    match numbers(text)?[..] {
        [constant] => Some(Value::Constant(constant)),
        [r, g, b] => Some(Value::Rgb(Vec3::new(r, g, b))),
        _ => None,
    }
}

/// A spectrum by the name and the properties of its plugin; none where they do not say one.
pub(super) fn spectrum_plugin(plugin: &str, properties: &HashMap<String, Value>) -> Option<Value> {
    let float = |name: &str| match properties.get(name)? {
        Value::Float(x) | Value::Constant(x) => Some(*x),
        Value::Integer(i) => Some(*i as f32),
        _ => None,
    };
    let list = |name: &str| match properties.get(name)? {
        Value::Text(text) => numbers(text),
        _ => None,
    };
    let sampled = |wavelengths: Vec<f32>, values: Vec<f32>| {
        let pairs = wavelengths.into_iter().zip(values).map(|(l, v)| (f64::from(l), f64::from(v)));
        Spectrum::new(pairs.collect()).map(Value::Spectrum)
    };
    let scale = float("scale").unwrap_or(1.0);
    match plugin {
        "uniform" => Some(match properties.get("value").or(properties.get("color")) {
            // A colour in it is a colour, as some write one.
            Some(color @ (Value::Rgb(_) | Value::Spectrum(_))) => color.clone(),
            _ => Value::Constant(float("value").unwrap_or(1.0)),
        }),
        "d65" => Some(match properties.get("color").or(properties.get("value")) {
            Some(color) => Value::Rgb(color.color(Quantity::Unbounded)? * scale),
            None => Value::Constant(scale),
        }),
        "blackbody" => {
            let kelvin = float("temperature").unwrap_or(5000.0);
            (kelvin > 0.0).then(|| Value::Rgb(blackbody(f64::from(kelvin)) * scale))
        }
        "irregular" => {
            let (wavelengths, values) = (list("wavelengths")?, list("values")?);
            (wavelengths.len() == values.len()).then(|| sampled(wavelengths, values))?
        }
        "regular" => {
            let bound =
                |name: &str| float(&format!("wavelength_{name}")).or(float(&format!("lambda_{name}")));
            let (first, last, values) = (bound("min")?, bound("max")?, list("values")?);
            let step = (last - first) / values.len().saturating_sub(1).max(1) as f32;
            sampled((0..values.len()).map(|i| first + step * i as f32).collect(), values)
        }
        _ => None,
    }
}

/// The value of a property's element by its attributes; none where they do not say one, or the
/// element is no property.
pub(super) fn parse<'a>(tag: &str, attribute: impl Fn(&str) -> Option<&'a str>) -> Option<Value> {
    let text = attribute("value");
    match tag {
        "boolean" => match text?.trim().to_ascii_lowercase().as_str() {
            "true" => Some(Value::Boolean(true)),
            "false" => Some(Value::Boolean(false)),
            _ => None,
        },
        "integer" | "long" => text?.trim().parse().ok().map(Value::Integer),
        "float" | "double" => number(text?).map(Value::Float),
        "string" => text.map(|text| Value::Text(text.to_owned())),
        "vector" | "point" => match text {
            Some(text) => triple(text),
            None => transform::xyz(&attribute, 0.0),
        }
        .map(Value::Vector),
        "rgb" => rgb(text?).map(Value::Rgb),
        "srgb" => srgb(text?).map(Value::Rgb),
        "spectrum" => spectrum(text?),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(tag: &str, text: &'static str) -> Option<Value> {
        parse(tag, |name| (name == "value").then_some(text))
    }

    #[test]
    fn values_are_read_in_every_spelling() {
        let grey = Some(Value::Rgb(Vec3::splat(0.25)));
        assert_eq!(of("rgb", "0.25"), grey);
        assert_eq!(of("rgb", " 0.25, .25 0.25 "), grey);
        assert_eq!(of("rgb", "#ff0000"), Some(Value::Rgb(Vec3::X)));
        assert_eq!(of("srgb", "1, 0, 0"), Some(Value::Rgb(Vec3::X)));
        assert_eq!(of("spectrum", "0.5"), Some(Value::Constant(0.5)));
        assert_eq!(of("spectrum", "1 2 3"), Some(Value::Rgb(Vec3::new(1.0, 2.0, 3.0))));
        assert_eq!(of("boolean", "True"), Some(Value::Boolean(true)));
        assert_eq!(of("point", "1 2 3"), Some(Value::Vector(Vec3::new(1.0, 2.0, 3.0))));
        let only_y = parse("vector", |name| (name == "y").then_some("2"));
        assert_eq!(only_y, Some(Value::Vector(Vec3::Y * 2.0)));
    }

    #[test]
    fn what_is_no_value_is_refused() {
        let bad = [
            ("float", "NaN"),
            ("float", "1e999"),
            ("float", "one"),
            ("integer", "1.5"),
            ("integer", "99999999999999999999"),
            ("boolean", "yes"),
            ("rgb", "#ff00"),
            ("rgb", "#ggffff"),
            ("rgb", "1 2"),
            ("rgb", "inf"),
            ("spectrum", "400:1, 500"),
            ("spectrum", "400:"),
            ("spectrum", ""),
            ("point", "1 2"),
            ("nonsense", "1"),
        ];
        for (tag, text) in bad {
            assert_eq!(of(tag, text), None, "{tag} {text}");
        }
    }
}
