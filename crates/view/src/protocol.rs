//! What browser and server say to each other over the WebSocket.
//!
//! Text messages are JSON, here. Binary ones, server to browser alone, are frames: see
//! [`crate::frame`]. A browser's messages are untrusted: unknown ones are refused, numbers are checked
//! where they are used, and [`MAX_MESSAGE`] bounds their size.

use midway_film::ToneMap;
use midway_render::{Crop, Integrator, IntegratorSettings, Join, JoinChoice, LightPaths, Mis};
use midway_scene::Scene;
use serde::{Deserialize, Serialize};

/// Bytes of a browser's message at most.
pub const MAX_MESSAGE: usize = 16 * 1024;

/// What a browser asks for.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Request {
    /// One more frame was decoded: another may be sent.
    Decoded,
    /// To steer from now on.
    Take,
    /// Another view.
    Look(View),
    /// Another integrator, K, bound of path lengths or size of the film.
    Render(Box<Wish>),
    /// Exposure, tone map and layer.
    Show(Shown),
    /// A second integrator beside the first, or none.
    Split {
        /// The second.
        right: Option<Method>,
    },
    /// Render only this part of the film, in pixels; none: all.
    Region {
        /// Left, top, width, height.
        window: Option<[u32; 4]>,
    },
    /// Stop, or go on.
    Pause {
        /// Whether to stop.
        paused: bool,
    },
    /// Forget all samples.
    Restart,
    /// What is seen at this place of the film, from 0 to 1 right and down: answered by an event, `picked`.
    Pick {
        /// Right.
        x: f32,
        /// Down.
        y: f32,
    },
    /// Open what was uploaded: a scene, or an environment.
    Open {
        /// The upload's number.
        batch: u64,
        /// The file's path in it.
        path: String,
    },
    /// The environment.
    Environment(Surroundings),
    /// Other materials.
    Variant {
        /// The place of one of the scene's variants; none: the materials that the file has by default.
        index: Option<u32>,
    },
    /// What each group of lights is multiplied by as it is shown; none: they are not kept apart.
    Mix {
        /// For each group of the scene a factor a channel, at least 0.
        factors: Option<Vec<[f32; 3]>>,
    },
}

impl Request {
    /// Whether the samples so far are worth nothing once it is carried out.
    pub fn forgets_samples(&self) -> bool {
        match self {
            Self::Look(_) | Self::Split { .. } | Self::Region { .. } | Self::Restart => true,
            Self::Render(wish) => wish.size.is_some() || wish.max_path_length.is_some(),
            // The picture goes on until these are ready.
            Self::Environment(_) | Self::Variant { .. } => false,
            Self::Decoded
            | Self::Take
            | Self::Show(_)
            | Self::Mix { .. }
            | Self::Pause { .. }
            | Self::Pick { .. }
            | Self::Open { .. } => false,
        }
    }
}

/// A view: where from, where to.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Position.
    pub eye: [f32; 3],
    /// A point in the middle of the image.
    pub target: [f32; 3],
    /// Up in the image, as far as it can be.
    pub up: [f32; 3],
    /// Vertical field of view in degrees; none: as before.
    #[serde(default)]
    pub fov: Option<f32>,
    /// Height of the film in the world, of a camera with parallel rays; none: as before.
    #[serde(default)]
    pub height: Option<f32>,
    /// Radius of the lens; none: as before.
    #[serde(default)]
    pub lens: Option<f32>,
    /// Distance at which things are sharp; none: to the target.
    #[serde(default)]
    pub focus: Option<f32>,
    /// The browser's number for this input; frames that show it carry it.
    #[serde(default)]
    pub input: u32,
    /// Which of the scenes that were opened it is of; none: whichever is shown.
    #[serde(default)]
    pub opened: Option<u32>,
}

/// What may be asked of a render; what is not said stays.
#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Wish {
    /// The integrator.
    #[serde(default)]
    pub method: Option<Method>,
    /// Edges of a path at most; 0 for no bound.
    #[serde(default)]
    pub max_path_length: Option<u32>,
    /// Pixels across and down.
    #[serde(default)]
    pub size: Option<[u32; 2]>,
    /// Milliseconds that a frame is to take while the camera moves.
    #[serde(default)]
    pub hold_ms: Option<f32>,
}

/// An integrator in the browser's words.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Method {
    /// Which.
    pub integrator: IntegratorName,
    /// The join of bdpt.
    #[serde(default)]
    pub join: JoinName,
    /// K of k-step.
    #[serde(default = "three")]
    pub k: u32,
    /// Whether K vertices are chosen by importance.
    #[serde(default)]
    pub importance: bool,
    /// Whether joins draw from a pool.
    #[serde(default)]
    pub pool: bool,
}

fn three() -> u32 {
    3
}

/// [`Integrator`] by name.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum IntegratorName {
    /// Camera paths alone.
    PathNaive,
    /// With lights sampled.
    Path,
    /// Light paths.
    Light,
    /// Both.
    Bdpt,
}

/// [`Join`] by name.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum JoinName {
    /// All with all.
    #[default]
    Full,
    /// With K.
    KStep,
    /// Last with last.
    SingleStep,
}

impl Method {
    /// In the renderer's terms.
    pub fn settings(&self) -> IntegratorSettings {
        IntegratorSettings {
            integrator: match self.integrator {
                IntegratorName::PathNaive => Integrator::PathNaive,
                IntegratorName::Path => Integrator::Path,
                IntegratorName::Light => Integrator::Light,
                IntegratorName::Bdpt => Integrator::Bdpt,
            },
            join: match self.join {
                JoinName::Full => Join::Full,
                JoinName::KStep => Join::KStep,
                JoinName::SingleStep => Join::SingleStep,
            },
            k: self.k,
            join_choice: if self.importance { JoinChoice::Importance } else { JoinChoice::Uniform },
            light_paths: if self.pool { LightPaths::Pool(None) } else { LightPaths::PerSample },
            nee: None,
            splat: None,
            mis: Mis::Power,
        }
    }

    /// In the browser's.
    pub fn of(settings: &IntegratorSettings) -> Self {
        Self {
            integrator: match settings.integrator {
                Integrator::PathNaive => IntegratorName::PathNaive,
                Integrator::Path => IntegratorName::Path,
                Integrator::Light => IntegratorName::Light,
                Integrator::Bdpt => IntegratorName::Bdpt,
            },
            join: match settings.join {
                Join::Full => JoinName::Full,
                Join::KStep => JoinName::KStep,
                Join::SingleStep => JoinName::SingleStep,
            },
            k: settings.k,
            importance: settings.join_choice == JoinChoice::Importance,
            pool: matches!(settings.light_paths, LightPaths::Pool(_)),
        }
    }
}

/// How the image is shown; changes no sample.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Shown {
    /// In stops.
    pub exposure: f32,
    /// The tone map.
    pub tone_map: ToneMapName,
    /// The layer.
    #[serde(default)]
    pub layer: Layer,
}

/// [`ToneMap`] by name.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ToneMapName {
    /// AgX.
    #[default]
    Agx,
    /// ACES.
    Aces,
    /// Khronos PBR Neutral.
    PbrNeutral,
    /// Clipped.
    Linear,
}

impl From<ToneMapName> for ToneMap {
    fn from(name: ToneMapName) -> Self {
        match name {
            ToneMapName::Agx => Self::Agx,
            ToneMapName::Aces => Self::Aces,
            ToneMapName::PbrNeutral => Self::PbrNeutral,
            ToneMapName::Linear => Self::Linear,
        }
    }
}

/// What of the image is shown.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layer {
    /// The picture.
    #[default]
    Beauty,
    /// The first surface's colour.
    Albedo,
    /// Its normal.
    Normal,
    /// Its distance.
    Depth,
    /// The standard error of each pixel, over the pixel.
    Noise,
}

/// What is around the scene.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Surroundings {
    /// Of its radiance, or of white where the scene has no environment, at least 0.
    pub strength: f32,
    /// About the vertical, in degrees.
    pub rotation: f32,
}

impl Surroundings {
    /// Of a scene as it is loaded.
    pub fn of(scene: &Scene) -> Self {
        Self { strength: if scene.environment.is_some() { 1.0 } else { 0.0 }, rotation: 0.0 }
    }
}

/// What the server says.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Reply {
    /// First: who the browser is.
    Hello {
        /// Its number.
        client: u64,
        /// What its uploads and saves carry.
        key: String,
        /// Midway's version.
        version: &'static str,
    },
    /// Whether the browser steers, and how many look.
    Role {
        /// Whether it does.
        steers: bool,
        /// All browsers.
        clients: usize,
        /// Whether nobody may.
        read_only: bool,
    },
    /// A request that could not be carried out, in a line.
    Refused {
        /// Why.
        reason: String,
    },
}

/// Crops are read as four numbers.
pub fn crop([x, y, width, height]: [u32; 4]) -> Crop {
    Crop { x, y, width, height }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Request, serde_json::Error> {
        serde_json::from_str(text)
    }

    #[test]
    fn requests_are_read() {
        assert_eq!(parse(r#"{"type":"restart"}"#).unwrap(), Request::Restart);
        let look = parse(r#"{"type":"look","eye":[0,1,2],"target":[0,0,0],"up":[0,1,0],"input":4}"#).unwrap();
        assert!(matches!(look, Request::Look(View { input: 4, .. })));
        let wish = r#"{"type":"render","method":{"integrator":"bdpt","join":"k-step","k":5}}"#;
        let Request::Render(wish) = parse(wish).unwrap() else { panic!("another") };
        let method = wish.method.unwrap();
        assert_eq!(Method::of(&method.settings()), method);
        assert_eq!(method.settings().k, 5);
    }

    #[test]
    fn other_messages_are_refused() {
        for text in [
            "",
            "[]",
            "null",
            r#"{"type":"quit"}"#,
            r#"{"type":"look"}"#,
            r#"{"type":"look","eye":[0,1],"target":[0,0,0],"up":[0,1,0]}"#,
            r#"{"type":"render","shell":"rm"}"#,
            r#"{"type":"render","method":{"integrator":"bdpt","k":-1}}"#,
            r#"{"type":"show","exposure":"1","tone_map":"agx"}"#,
            r#"{"type":"pick","x":0.5}"#,
            r#"{"type":"open","batch":-1,"path":"a.glb"}"#,
            r#"{"type":"mix","factors":[[1,2]]}"#,
            r#"{"type":"variant","index":-1}"#,
            r#"{"type":"variant","index":"Walnut"}"#,
        ] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
