//! What the values of flags may look like.

use std::{str::FromStr, time::Duration};

use clap::ValueEnum;
use midway_render::Aov;
use midway_scene::LightGroupRule;

/// `--integrator`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum IntegratorArg {
    /// Path or bdpt, and which, by a short warm-up.
    #[default]
    Auto,
    /// Camera paths; light only where they hit it.
    PathNaive,
    /// Camera paths that sample a light at each vertex.
    Path,
    /// Light paths, splatted onto the film.
    Light,
    /// Both, joined.
    Bdpt,
}

/// `--join`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum JoinArg {
    /// Every camera vertex with every light vertex.
    Full,
    /// Every camera vertex with K light vertices.
    KStep,
    /// The last camera vertex with the last light vertex.
    SingleStep,
}

/// `--join-choice`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum JoinChoiceArg {
    /// All alike.
    Uniform,
    /// In proportion to what they carry.
    Importance,
}

/// `--mis`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MisArg {
    /// The balance heuristic.
    Balance,
    /// The power heuristic, exponent 2.
    Power,
}

/// `--light-sampling`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum LightSamplingArg {
    /// By the tree where lights are many and lie apart.
    #[default]
    Auto,
    /// By the light's power.
    Power,
    /// By about what arrives from it, by a tree over all lights.
    Tree,
}

/// `--filter`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum FilterArg {
    /// The plain mean, 1 pixel wide.
    #[default]
    Box,
    /// Smooth, 3 pixels wide.
    BlackmanHarris,
}

/// `--progress`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ProgressArg {
    /// A bar on a terminal, nothing elsewhere.
    #[default]
    Auto,
    /// A line now and then.
    Plain,
    /// One JSON object a line.
    Json,
}

/// `--tone-map`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ToneMapArg {
    /// Clipped at 1.
    #[default]
    Linear,
    /// AgX.
    Agx,
    /// ACES.
    Aces,
    /// Khronos PBR Neutral.
    PbrNeutral,
}

/// `--light-paths`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightPathsArg {
    /// One for each sample of each pixel.
    PerSample,
    /// Made at the start of each pass: this many, or one for each pixel.
    Pool(Option<u32>),
}

impl FromStr for LightPathsArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "per-sample" => Ok(Self::PerSample),
            None if text == "pool" => Ok(Self::Pool(None)),
            Some(("pool", count)) => match count.parse() {
                Ok(count) if count > 0 => Ok(Self::Pool(Some(count))),
                _ => Err(format!("'{count}' is not a number of paths above 0")),
            },
            _ => Err("use per-sample, pool or pool:P".to_owned()),
        }
    }
}

/// `--light-groups`: which lights are put together; the others stay by themselves.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightGroupsArg(pub Vec<LightGroupRule>);

impl FromStr for LightGroupsArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let rule = |text: &str| match text.split_once('=') {
            Some((group, lights)) if !group.trim().is_empty() && !lights.is_empty() => Ok(LightGroupRule {
                group: group.trim().to_owned(),
                lights: lights.split('+').map(|name| name.trim().to_owned()).collect(),
            }),
            _ => Err(format!("'{text}' is not NAME=LIGHT+LIGHT")),
        };
        if text.is_empty() {
            return Ok(Self::default());
        }
        Ok(Self(text.split(',').map(rule).collect::<Result<_, _>>()?))
    }
}

/// `--rng`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RngArg {
    /// Evenly spread, unbiased.
    Sobol,
    /// Independent, unbiased.
    Hash,
    /// This many numbers, made beforehand.
    Table(u32),
}

impl FromStr for RngArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "sobol" => Ok(Self::Sobol),
            None if text == "hash" => Ok(Self::Hash),
            Some(("table", size)) => match size.parse() {
                Ok(size) if size > 0 => Ok(Self::Table(size)),
                _ => Err(format!("'{size}' is not a number of entries above 0")),
            },
            _ => Err("use sobol, hash or table:N".to_owned()),
        }
    }
}

/// `--crop`: a rectangle in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CropArg {
    /// Column of its left edge.
    pub x: u32,
    /// Row of its upper edge.
    pub y: u32,
    /// Pixels across, above 0.
    pub width: u32,
    /// Pixels down, above 0.
    pub height: u32,
}

impl FromStr for CropArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [x, y, width, height] = list::<u32, 4>(text).ok_or("use X,Y,WIDTH,HEIGHT in whole pixels")?;
        if width == 0 || height == 0 {
            return Err("its width and height must be above 0".to_owned());
        }
        Ok(Self { x, y, width, height })
    }
}

/// `--aov`: layers of the EXR, each once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AovArg(
    /// In the order given.
    pub Vec<Aov>,
);

impl FromStr for AovArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "none" => return Ok(Self::default()),
            "all" => return Ok(Self(Aov::ALL.to_vec())),
            _ => {}
        }
        let mut layers = Vec::new();
        for name in text.split(',').map(str::trim) {
            let Some(aov) = Aov::ALL.into_iter().find(|aov| aov.name() == name) else {
                let known = Aov::ALL.map(Aov::name).join(", ");
                return Err(format!("unknown layer '{name}': use all, none or a list of {known}"));
            };
            if !layers.contains(&aov) {
                layers.push(aov);
            }
        }
        Ok(Self(layers))
    }
}

/// A point or a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vec3Arg(
    /// x, y, z; finite.
    pub [f32; 3],
);

impl FromStr for Vec3Arg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        list::<f32, 3>(text)
            .filter(|values| values.iter().all(|value| value.is_finite()))
            .map(Self)
            .ok_or_else(|| "use X,Y,Z".to_owned())
    }
}

/// A radiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorArg(
    /// Linear R, G, B; finite and not negative.
    pub [f32; 3],
);

impl FromStr for ColorArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        list::<f32, 3>(text)
            .filter(|values| values.iter().all(|value| value.is_finite() && *value >= 0.0))
            .map(Self)
            .ok_or_else(|| "use R,G,B, each 0 or more".to_owned())
    }
}

/// A number.
pub fn finite_f32(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|x: &f32| x.is_finite()).ok_or_else(|| format!("'{text}' is not a number"))
}

fn list<T: FromStr, const N: usize>(text: &str) -> Option<[T; N]> {
    let values: Result<Vec<T>, _> = text.split(',').map(|item| item.trim().parse()).collect();
    values.ok()?.try_into().ok()
}

/// A time above zero: a number and `ms`, `s`, `m` or `h`; seconds if there is no unit.
pub fn duration(text: &str) -> Result<Duration, String> {
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let scale = match unit {
        "ms" => 1e-3,
        "" | "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(format!("unknown unit '{unit}': use ms, s, m or h")),
    };
    let seconds = number.trim().parse::<f64>().map_err(|_| format!("'{number}' is not a number"))? * scale;
    match Duration::try_from_secs_f64(seconds) {
        Ok(time) if !time.is_zero() => Ok(time),
        _ => Err("it must be above 0".to_owned()),
    }
}

/// A finite number above zero.
pub fn positive_f32(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("it must be a number above 0".to_owned()),
    }
}

/// A finite number of at least zero.
pub fn non_negative_f32(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("it must be a number of at least 0".to_owned()),
    }
}

/// An exposure that does not leave the range of f32.
pub fn stops(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value.abs() <= 100.0 => Ok(value),
        _ => Err("it must be a number of stops between -100 and 100".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations() {
        for (text, seconds) in [("10s", 10.0), ("500ms", 0.5), ("2m", 120.0), ("1.5", 1.5), ("1h", 3600.0)] {
            assert_eq!(duration(text), Ok(Duration::from_secs_f64(seconds)));
        }
        for text in ["", "s", "0s", "-1s", "nan", "inf", "1e30h", "10 years", "5x"] {
            assert!(duration(text).is_err(), "{text}");
        }
    }

    #[test]
    fn rectangles_and_points() {
        assert_eq!("1,2,3,4".parse(), Ok(CropArg { x: 1, y: 2, width: 3, height: 4 }));
        for text in ["", "1,2,3", "1,2,3,4,5", "1,2,0,4", "-1,2,3,4", "a,b,c,d"] {
            assert!(text.parse::<CropArg>().is_err(), "{text}");
        }
        assert_eq!("0, -1.5,2e3".parse(), Ok(Vec3Arg([0.0, -1.5, 2000.0])));
        assert!("0,nan,0".parse::<Vec3Arg>().is_err());
    }

    #[test]
    fn counted_choices() {
        assert_eq!("pool:8".parse(), Ok(LightPathsArg::Pool(Some(8))));
        assert_eq!("pool".parse(), Ok(LightPathsArg::Pool(None)));
        assert_eq!("table:16".parse(), Ok(RngArg::Table(16)));
        assert_eq!("sobol".parse(), Ok(RngArg::Sobol));
        for text in ["pool:0", "pool:", "pool:-1", "other", ""] {
            assert!(text.parse::<LightPathsArg>().is_err(), "{text}");
        }
        assert!("table".parse::<RngArg>().is_err());
    }

    #[test]
    fn lists_of_layers() {
        assert_eq!("none".parse(), Ok(AovArg(vec![])));
        assert_eq!("all".parse(), Ok(AovArg(Aov::ALL.to_vec())));
        assert_eq!("depth, albedo,depth".parse(), Ok(AovArg(vec![Aov::Depth, Aov::Albedo])));
        for text in ["", "depth,", "all,depth", "Depth"] {
            assert!(text.parse::<AovArg>().is_err(), "{text}");
        }
    }
}
