//! `midway bench`, as typed.

use std::path::PathBuf;

use clap::{Args, Subcommand};

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
}

/// `midway bench rays`.
#[derive(Args, Debug)]
pub struct RaysArgs {
    /// The scene, or generated:N for N triangles of bumpy balls.
    pub scene: PathBuf,
    /// auto, cpu, gpu, or a part of a GPU's name.
    #[arg(long, value_name = "NAME", default_value = "auto")]
    pub device: String,
    /// Threads of the CPU device [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Rays of each kind [default: 2^24 on a GPU, 2^18 elsewhere]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(64..=1 << 27))]
    pub rays: Option<u32>,
    /// Only rows that contain each of these words (wide,splits,random,any).
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}
