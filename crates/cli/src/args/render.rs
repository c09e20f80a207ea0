//! `midway render`, as typed.

use std::{path::PathBuf, time::Duration};

use clap::Args;

use super::{
    RootArg,
    values::{
        AovArg, ColorArg, CropArg, FilterArg, IntegratorArg, JoinArg, JoinChoiceArg, LightGroupsArg,
        LightPathsArg, LightSamplingArg, MisArg, ProgressArg, RngArg, ToneMapArg, Vec3Arg, duration,
        finite_f32, non_negative_f32, positive_f32, stops,
    },
};

/// `midway render`.
#[derive(Args, Debug)]
pub struct RenderArgs {
    /// The scene (.gltf, .glb, .obj, .ply, .pbrt, .xml).
    pub scene: PathBuf,
    /// Where its files lie.
    #[command(flatten)]
    pub root: RootArg,

    /// Where to write (.exr or .png; the other is written beside it). Given more than once: these
    /// files and no others [default: the scene's name, here]
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    pub output: Vec<PathBuf>,
    /// Write the image so far every so often (`5s`, `2m`).
    #[arg(long, value_name = "TIME", value_parser = duration, help_heading = "Output")]
    pub snapshot_every: Option<Duration>,
    /// Show the image while it renders in tev, which listens at this address (its own is
    /// 127.0.0.1:14158).
    #[arg(long, value_name = "HOST:PORT", help_heading = "Output")]
    pub display: Option<String>,
    /// Show it on the viewer's page at this port of this machine, read only [default port: 7410]
    #[arg(long, value_name = "PORT", num_args = 0..=1, require_equals = true, default_missing_value = "7410", help_heading = "Output")]
    pub serve: Option<u16>,
    /// Brighten the PNG by this many stops.
    #[arg(
        long, value_name = "STOPS", default_value_t = 0.0, value_parser = stops,
        allow_negative_numbers = true, help_heading = "Output"
    )]
    pub exposure: f32,
    /// How the PNG brings bright colours into range.
    #[arg(
        long,
        value_enum,
        value_name = "CURVE",
        default_value_t,
        hide_possible_values = false,
        help_heading = "Output"
    )]
    pub tone_map: ToneMapArg,

    /// Layers beside the picture in the EXR: all, none, or any of albedo, normal, depth, position,
    /// variance and samples.
    #[arg(long, value_name = "all|none|LIST", default_value = "none", help_heading = "Output")]
    pub aov: AovArg,

    /// A layer in the EXR for what each group of lights adds, `Combined_NAME`: of each light by itself,
    /// or of lights put together by their names, where `*` stands for any text. At most 16; the others
    /// share the last.
    #[arg(long, value_name = "NAME=LIGHT+LIGHT,…", num_args = 0..=1, require_equals = true, default_missing_value = "", help_heading = "Output")]
    pub light_groups: Option<LightGroupsArg>,

    /// Take the materials of this variant of the scene's, by its name; `midway info` lists them
    /// [default: the materials that the file shows by itself]
    #[arg(long, value_name = "NAME", help_heading = "Image")]
    pub variant: Option<String>,
    /// Samples per pixel [default: 64, or no limit with --time]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=u32::MAX as u64), help_heading = "Image")]
    pub spp: Option<u64>,
    /// Stop after this much rendering (`10s`, `500ms`, `2m`); with --spp, whichever is first.
    #[arg(long, value_name = "TIME", value_parser = duration, help_heading = "Image")]
    pub time: Option<Duration>,
    /// The same seed on the same device gives the same image, bit for bit.
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Image")]
    pub seed: u32,
    /// Pixels across [default: the camera's, or from the height and the camera]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=65_535), help_heading = "Image")]
    pub width: Option<u32>,
    /// Pixels down [default: the camera's, or from the width and the camera, or 512]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=65_535), help_heading = "Image")]
    pub height: Option<u32>,
    /// Render only this part of the frame, in pixels from its top left.
    #[arg(long, value_name = "X,Y,W,H", help_heading = "Image")]
    pub crop: Option<CropArg>,
    /// What a pixel is the mean over.
    #[arg(long, value_enum, value_name = "FILTER", default_value_t, help_heading = "Image")]
    pub filter: FilterArg,
    /// The filter's full width, up to 16 [default: 1 for box, 3 for blackman-harris]
    #[arg(long, value_name = "PIXELS", value_parser = positive_f32, help_heading = "Image")]
    pub filter_width: Option<f32>,

    /// The camera, by its name in the scene or its index from 0.
    #[arg(long, value_name = "NAME|INDEX", help_heading = "Camera")]
    pub camera: Option<String>,
    /// Look from here instead of through a camera of the scene.
    #[arg(
        long,
        value_name = "X,Y,Z",
        allow_hyphen_values = true,
        requires = "target",
        conflicts_with = "camera",
        help_heading = "Camera"
    )]
    pub eye: Option<Vec3Arg>,
    /// Look at this point.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "eye", help_heading = "Camera")]
    pub target: Option<Vec3Arg>,
    /// The direction that is up in the image [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "eye", help_heading = "Camera")]
    pub up: Option<Vec3Arg>,
    /// Vertical field of view, in degrees [default: the camera's, or 40]
    #[arg(long, value_name = "DEGREES", value_parser = positive_f32, help_heading = "Camera")]
    pub fov: Option<f32>,
    /// Look along parallel rays; this much of the scene is as high as the image.
    #[arg(long, value_name = "HEIGHT", value_parser = positive_f32, conflicts_with = "fov", help_heading = "Camera")]
    pub ortho: Option<f32>,
    /// Radius of the lens, 0 for a pinhole [default: the camera's, or 0]
    #[arg(long, value_name = "LENGTH", value_parser = non_negative_f32, help_heading = "Camera")]
    pub lens_radius: Option<f32>,
    /// Distance along the view at which things are sharp [default: the camera's, or to the target]
    #[arg(long, value_name = "LENGTH", value_parser = positive_f32, help_heading = "Camera")]
    pub focus_distance: Option<f32>,

    /// Light from all around by an image of latitude and longitude (.hdr, .exr), in place of the
    /// scene's own.
    #[arg(long, value_name = "FILE", help_heading = "Lights")]
    pub env: Option<PathBuf>,
    /// Turn it about the vertical, counter-clockwise seen from above.
    #[arg(
        long, value_name = "DEGREES", value_parser = finite_f32, requires = "env",
        allow_negative_numbers = true, help_heading = "Lights"
    )]
    pub env_rotation: Option<f32>,
    /// The same radiance from all around, in place of the scene's own environment.
    #[arg(long, value_name = "R,G,B", conflicts_with = "env", help_heading = "Lights")]
    pub background: Option<ColorArg>,

    /// How light is transported.
    #[arg(short, long, value_enum, value_name = "NAME", default_value_t, help_heading = "Integrator")]
    pub integrator: IntegratorArg,
    /// How camera and light paths meet (bdpt) [default: full]
    #[arg(long, value_enum, value_name = "JOIN", help_heading = "Integrator")]
    pub join: Option<JoinArg>,
    /// Light vertices joined to each camera vertex (k-step) [default: 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Integrator")]
    pub k: Option<u32>,
    /// How these are chosen (k-step) [default: uniform]
    #[arg(long, value_enum, value_name = "CHOICE", help_heading = "Integrator")]
    pub join_choice: Option<JoinChoiceArg>,
    /// One light path a sample, or a pool of P made for each pass (bdpt) [default: per-sample]
    #[arg(long, value_name = "per-sample|pool|pool:P", help_heading = "Integrator")]
    pub light_paths: Option<LightPathsArg>,
    /// By what a light is chosen where lights are sampled (path, bdpt).
    #[arg(long, value_enum, value_name = "CHOICE", default_value_t, help_heading = "Integrator")]
    pub light_sampling: LightSamplingArg,
    /// How the strategies are weighted [default: power]
    #[arg(long, value_enum, value_name = "HEURISTIC", help_heading = "Integrator")]
    pub mis: Option<MisArg>,
    /// Sample lights at camera vertices, s = 1 (bdpt) [default: on; off with single-step]
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", help_heading = "Integrator")]
    pub nee: Option<bool>,
    /// Splat light vertices onto the film, t = 1 (bdpt) [default: on; off with single-step]
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", help_heading = "Integrator")]
    pub splat: Option<bool>,

    /// Sobol points, evenly spread and scrambled; a hash, independent; or, biased, a table of N numbers
    /// used again and again.
    #[arg(long, value_name = "sobol|hash|table:N", default_value = "sobol", help_heading = "Integrator")]
    pub rng: RngArg,

    /// Drop paths of more than N segments. Darkens.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Bias (all of it written to the header)")]
    pub max_path_length: Option<u32>,
    /// Cut each contribution at this radiance. Darkens.
    #[arg(long, value_name = "RADIANCE", value_parser = positive_f32, help_heading = "Bias (all of it written to the header)")]
    pub clamp: Option<f32>,

    /// `auto` takes a GPU if there is one, else the CPU; see `midway devices`. `all` GPUs, or names with
    /// commas between them, share the samples.
    #[arg(
        long,
        value_name = "auto|cpu|gpu|all|NAME[,NAME]",
        default_value = "auto",
        help_heading = "Device"
    )]
    pub device: String,
    /// Threads of the CPU device [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096), help_heading = "Device")]
    pub threads: Option<u32>,

    /// Say nothing but errors.
    #[arg(short, long, conflicts_with = "verbose", help_heading = "Messages")]
    pub quiet: bool,
    /// Say more: the memory plan, the scene's contents.
    #[arg(short, long, help_heading = "Messages")]
    pub verbose: bool,
    /// `auto`: a bar on a terminal; `plain`: lines; `json`: one object a line on standard output.
    #[arg(long, value_enum, value_name = "STYLE", default_value_t, help_heading = "Messages")]
    pub progress: ProgressArg,

    /// Measure the image against this one (EXR) while it renders.
    #[arg(long, value_name = "EXR", help_heading = "Measuring")]
    pub reference: Option<PathBuf>,
    /// Write seconds, samples, RMSE and relMSE to this file as it renders.
    #[arg(long, value_name = "CSV", requires = "reference", help_heading = "Measuring")]
    pub errors: Option<PathBuf>,
}
