//! `midway bench`, as typed.

use std::{path::PathBuf, time::Duration};

use clap::{Args, Subcommand};

use super::{
    RootArg,
    values::{duration, positive_f32},
};

/// `midway bench`.
#[derive(Args, Debug)]
pub struct BenchArgs {
    /// What to measure.
    #[command(subcommand)]
    pub what: Bench,
}

/// The measurements.
#[derive(Debug, Subcommand)]
pub enum Bench {
    /// Rays a second of each traversal kernel, over each hierarchy.
    Rays(RaysArgs),
    /// The error of every integrator after the same time, and of auto's choice.
    EqualTime(EqualTimeArgs),
    /// Random numbers, joins and pools, at equal samples and equal time.
    Sampling(SamplingArgs),
    /// What samples cost as scenes, images and paths grow.
    Scaling(ScalingArgs),
    /// The error after the same time by a tree over lights and by their power, as lights grow.
    Lights(LightsArgs),
    /// Frame times and K while the camera moves and a frame time is held.
    Hold(HoldArgs),
    /// Time and rays a second of each kernel.
    Integrator(IntegratorBenchArgs),
    /// The bidirectional integrator beside its plainest form: one kernel, a thread for each sample.
    Baseline(BaselineArgs),
    /// The comparisons of Otte's paper (2014), with pictures.
    Tables(TablesArgs),
}

/// `midway bench rays`.
#[derive(Args, Debug)]
pub struct RaysArgs {
    /// The scene, or generated:N for N triangles of bumpy balls.
    pub scene: PathBuf,
    /// Where its files lie.
    #[command(flatten)]
    pub root: RootArg,
    /// auto, cpu, gpu, or a part of a GPU's name.
    #[arg(long, value_name = "NAME", default_value = "auto")]
    pub device: String,
    /// Threads of the CPU device [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Rays of each kind; a render's own are those of a sixteenth as many paths [default: 2^24 on a GPU, 2^18 elsewhere]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(64..=1 << 27))]
    pub rays: Option<u32>,
    /// Only rows that contain each of these words (wide,splits,random,any).
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// On what is measured.
#[derive(Args, Debug)]
pub struct BenchDevice {
    /// auto, cpu, gpu, or a part of a GPU's name.
    #[arg(long, value_name = "NAME", default_value = "auto")]
    pub device: String,
    /// Threads of the CPU device [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
}

/// How large images are.
#[derive(Args, Debug)]
pub struct BenchSize {
    /// Pixels across.
    #[arg(long, value_name = "PIXELS", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=65_535))]
    pub width: u32,
    /// Pixels down.
    #[arg(long, value_name = "PIXELS", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=65_535))]
    pub height: u32,
}

impl BenchSize {
    /// Across and down.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }
}

/// `midway bench equal-time`.
#[derive(Args, Debug)]
pub struct EqualTimeArgs {
    /// The scenes; each is looked at through its first camera.
    #[arg(required = true)]
    pub scenes: Vec<PathBuf>,
    /// Where their files lie.
    #[command(flatten)]
    pub root: RootArg,
    /// How long each image takes; there are two of each integrator.
    #[arg(long, value_name = "TIME", default_value = "10s", value_parser = duration)]
    pub time: Duration,
    /// Only these integrators (path,full,k-step-3,auto).
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub only: Vec<String>,
    /// How large.
    #[command(flatten)]
    pub size: BenchSize,
    /// On what.
    #[command(flatten)]
    pub device: BenchDevice,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// `midway bench sampling`.
#[derive(Args, Debug)]
pub struct SamplingArgs {
    /// The scenes; each is looked at through its first camera.
    #[arg(required = true)]
    pub scenes: Vec<PathBuf>,
    /// Where their files lie.
    #[command(flatten)]
    pub root: RootArg,
    /// Samples of a pixel where samples are equal.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u64).range(1..=1 << 20))]
    pub spp: u64,
    /// How long each image takes where time is equal.
    #[arg(long, value_name = "TIME", default_value = "5s", value_parser = duration)]
    pub time: Duration,
    /// How large.
    #[command(flatten)]
    pub size: BenchSize,
    /// On what.
    #[command(flatten)]
    pub device: BenchDevice,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// `midway bench scaling`.
#[derive(Args, Debug)]
pub struct ScalingArgs {
    /// Triangles of the largest scene.
    #[arg(long, value_name = "N", default_value_t = 10_000_000, value_parser = clap::value_parser!(u32).range(1000..=50_000_000))]
    pub largest: u32,
    /// Samples of a pixel.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u64).range(1..=1 << 20))]
    pub spp: u64,
    /// Only these curves (triangles, lights, K, …).
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Draw the curves.
    #[arg(long, value_name = "SVG")]
    pub svg: Option<PathBuf>,
    /// On what.
    #[command(flatten)]
    pub device: BenchDevice,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// `midway bench lights`.
#[derive(Args, Debug)]
pub struct LightsArgs {
    /// Scenes, each looked at through its first camera [default: made ones with --lights]
    pub scenes: Vec<PathBuf>,
    /// Where their files lie.
    #[command(flatten)]
    pub root: RootArg,
    /// How many lights there are in a made scene.
    #[arg(long, conflicts_with = "scenes", value_name = "LIST", value_delimiter = ',', default_values_t = [1, 10, 100, 1000, 10_000], value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub lights: Vec<u32>,
    /// How long each image takes; there are two of each kind.
    #[arg(long, value_name = "TIME", default_value = "5s", value_parser = duration)]
    pub time: Duration,
    /// Only rows that contain each of these words (points,path).
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub only: Vec<String>,
    /// How large.
    #[command(flatten)]
    pub size: BenchSize,
    /// On what.
    #[command(flatten)]
    pub device: BenchDevice,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// `midway bench hold`.
#[derive(Args, Debug)]
pub struct HoldArgs {
    /// The scene; its first camera is moved.
    pub scene: PathBuf,
    /// Where its files lie.
    #[command(flatten)]
    pub root: RootArg,
    /// How long a frame is to take, in milliseconds.
    #[arg(long, value_name = "MS", default_value_t = 33.0, value_parser = positive_f32)]
    pub ms: f32,
    /// How long the camera moves.
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = duration)]
    pub time: Duration,
    /// How large.
    #[command(flatten)]
    pub size: BenchSize,
    /// On what.
    #[command(flatten)]
    pub device: BenchDevice,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// `midway bench tables`.
#[derive(Args, Debug)]
pub struct TablesArgs {
    /// Folder for the pictures.
    #[arg(short, long, value_name = "FOLDER", default_value = "tables")]
    pub output: PathBuf,
    /// The folder with the project's scenes.
    #[arg(long, value_name = "FOLDER", default_value = "scenes")]
    pub scenes: PathBuf,
    /// Sponza by an area light, for the second table.
    #[arg(long, value_name = "FILE")]
    pub sponza: Option<PathBuf>,
    /// Sponza by one directional light, for the fourth.
    #[arg(long, value_name = "FILE")]
    pub sponza_sun: Option<PathBuf>,
    /// Where their files lie.
    #[command(flatten)]
    pub root: RootArg,
    /// Trace only what a GPU of this many million rays a second would trace in the time.
    #[arg(long, value_name = "MRAYS", value_parser = positive_f32)]
    pub pace: Option<f32>,
    /// On what.
    #[command(flatten)]
    pub device: BenchDevice,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// `midway bench integrator`.
#[derive(Args, Debug)]
pub struct IntegratorBenchArgs {
    /// The scenes; each is looked at through its first camera.
    #[arg(required = true)]
    pub scenes: Vec<PathBuf>,
    /// Where their files lie.
    #[command(flatten)]
    pub root: RootArg,
    /// Only these integrators (path,full,k-step-3)
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values = ["path", "full"])]
    pub only: Vec<String>,
    /// Samples of a pixel.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u64).range(1..=1 << 20))]
    pub spp: u64,
    /// How large.
    #[command(flatten)]
    pub size: BenchSize,
    /// On what.
    #[command(flatten)]
    pub device: BenchDevice,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// `midway bench baseline`.
#[derive(Args, Debug)]
pub struct BaselineArgs {
    /// The scenes; each is looked at through its first camera.
    #[arg(required = true)]
    pub scenes: Vec<PathBuf>,
    /// Where their files lie.
    #[command(flatten)]
    pub root: RootArg,
    /// Samples of a pixel.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    pub spp: u32,
    /// How often both are timed, in turn; the median counts.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rounds: u32,
    /// How large.
    #[command(flatten)]
    pub size: BenchSize,
    /// On what.
    #[command(flatten)]
    pub device: BenchDevice,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}
