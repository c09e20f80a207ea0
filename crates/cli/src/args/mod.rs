//! The command line as typed. Every flag is declared here, once.

mod bench;
mod render;
mod values;
mod view;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::status::Status;

pub use bench::{
    BaselineArgs, Bench, BenchArgs, BenchDevice, EqualTimeArgs, HoldArgs, IntegratorBenchArgs, LightsArgs,
    RaysArgs, SamplingArgs, ScalingArgs, TablesArgs,
};
pub use render::RenderArgs;
pub use values::{
    CropArg, FilterArg, IntegratorArg, JoinArg, JoinChoiceArg, LightGroupsArg, LightPathsArg,
    LightSamplingArg, MisArg, ProgressArg, RngArg, ToneMapArg, Vec3Arg,
};
pub use view::ViewArgs;

/// A bidirectional path tracer for the GPU, and for the bare CPU.
#[derive(Debug, Parser)]
#[command(name = "midway", version, after_help = exit_codes(), disable_help_subcommand = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to EXR and PNG.
    Render(Box<RenderArgs>),
    /// Look at a scene in a browser while it converges.
    View(ViewArgs),
    /// Measure how far an image is from a reference.
    Compare(CompareArgs),
    /// Say what a scene file holds.
    Info(InfoArgs),
    /// List the devices of this machine.
    Devices(DevicesArgs),
    /// Measure how fast parts of Midway are.
    Bench(BenchArgs),
}

/// `midway compare`.
#[derive(Args, Debug)]
pub struct CompareArgs {
    /// The image to judge (EXR).
    pub test: PathBuf,
    /// What it should look like (EXR).
    pub reference: PathBuf,
    /// Print one JSON object: mae, rmse, relmse, flip, mean_ratio.
    #[arg(long)]
    pub json: bool,
    /// Write the FLIP error map as a PNG in magma colours.
    #[arg(long, value_name = "PNG")]
    pub heatmap: Option<PathBuf>,
}

/// From where a scene's files may come: of each command that reads a scene.
#[derive(Args, Debug)]
pub struct RootArg {
    /// Let the scene's meshes, images and other files lie anywhere in this folder, which has to hold
    /// the scene too [default: the scene's own folder]
    #[arg(long, value_name = "FOLDER", help_heading = "Scene")]
    pub root: Option<PathBuf>,
}

/// `midway info`.
#[derive(Args, Debug)]
pub struct InfoArgs {
    /// The scene (.gltf, .glb, .obj, .ply, .pbrt, .xml).
    pub scene: PathBuf,
    /// Where its files lie.
    #[command(flatten)]
    pub root: RootArg,
    /// Take the materials of this variant of the scene's, by its name
    /// [default: the materials that the file shows by itself]
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// `midway devices`.
#[derive(Args, Debug)]
pub struct DevicesArgs {
    /// Print a JSON array.
    #[arg(long)]
    pub json: bool,
}

fn exit_codes() -> String {
    let lines = Status::ALL.map(|status| format!("  {:>2}  {}", status.code(), status.meaning()));
    format!("Exit codes:\n{}", lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_declarations_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_flag_is_in_the_help_with_a_description() {
        let cli = Cli::command();
        let nested = cli.get_subcommands().flat_map(|command| command.get_subcommands());
        for command in cli.get_subcommands().chain(nested) {
            let help = command.clone().render_help().to_string();
            for argument in command.get_arguments() {
                let name = argument.get_long().map(|long| format!("--{long}"));
                let name = name.unwrap_or_else(|| argument.get_id().to_string().to_uppercase());
                assert!(help.contains(&name), "{} does not show {name}", command.get_name());
                assert!(argument.get_help().is_some(), "{name} has no description");
            }
        }
    }
}
