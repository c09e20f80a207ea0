//! `midway view`, as typed.

use std::{net::IpAddr, path::PathBuf};

use clap::Args;

use super::{RootArg, values::LightGroupsArg};

/// `midway view`.
#[derive(Args, Debug)]
pub struct ViewArgs {
    /// The scene (.gltf, .glb, .obj, .ply, .pbrt, .xml); none: drop one on the page.
    pub scene: Option<PathBuf>,
    /// Where its files lie.
    #[command(flatten)]
    pub root: RootArg,

    /// Take the materials of this variant of the scene's, by its name; `midway info` lists them
    /// [default: the materials that the file shows by itself]
    #[arg(long, value_name = "NAME", requires = "scene")]
    pub variant: Option<String>,

    /// Where the page is; 0 takes any free port.
    #[arg(long, value_name = "N", default_value_t = 7410, help_heading = "Server")]
    pub port: u16,
    /// Do not open a browser; print the address.
    #[arg(long, help_heading = "Server")]
    pub no_open: bool,
    /// Listen at this address of the machine (0.0.0.0: at all), not at loopback. Browsers then need a token, which is
    /// printed and good once. What is sent is not encrypted: prefer a tunnel (`ssh -L`).
    #[arg(long, value_name = "IP", help_heading = "Server")]
    pub bind: Option<IpAddr>,

    /// Pixels across [default: the camera's, or from the height and the camera]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=8192), help_heading = "Image")]
    pub width: Option<u32>,
    /// Pixels down [default: the camera's, or from the width and the camera, or 512]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=8192), help_heading = "Image")]
    pub height: Option<u32>,
    /// How long a frame is to take while the camera moves, in milliseconds: K and resolution fall to
    /// hold it.
    #[arg(long, value_name = "MS", default_value_t = 33, value_parser = clap::value_parser!(u32).range(1..=10_000), help_heading = "Image")]
    pub hold: u32,
    /// Keep groups of lights apart from the start, and put lights into groups by their names, as
    /// `midway render` does.
    #[arg(long, value_name = "NAME=LIGHT+LIGHT,…", num_args = 0..=1, require_equals = true, default_missing_value = "", help_heading = "Image")]
    pub light_groups: Option<LightGroupsArg>,
    /// Plot the error against this image (EXR) instead of estimating it.
    #[arg(long, value_name = "EXR", help_heading = "Image")]
    pub reference: Option<PathBuf>,

    /// `auto` takes a GPU if there is one, else the CPU; see `midway devices`.
    #[arg(long, value_name = "auto|cpu|gpu|NAME", default_value = "auto", help_heading = "Device")]
    pub device: String,
    /// Threads of the CPU device [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096), help_heading = "Device")]
    pub threads: Option<u32>,
}
