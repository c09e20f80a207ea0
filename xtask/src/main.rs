//! Chores for developers: `cargo xtask --help` lists them.

mod font;
mod gallery;
mod half;
mod mutants;
mod pyramid;
mod references;
mod sheet;

use std::{path::PathBuf, process::ExitCode};

use anyhow::Result;
use clap::{Parser, Subcommand};

/// Midway's chores for developers.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", disable_help_subcommand = true)]
struct Cli {
    #[command(subcommand)]
    chore: Chore,
}

#[derive(Debug, Subcommand)]
enum Chore {
    /// Show that the proofs catch deliberate mistakes in the kernels.
    Mutants(mutants::MutantsArgs),
    /// Write what each strategy (s, t) contributes, raw and weighted, and print the means.
    Pyramid(pyramid::PyramidArgs),
    /// Render the project's scenes by every integrator for equal time, as one labelled picture.
    Gallery(gallery::GalleryArgs),
    /// Render scenes that other renderers have rendered, and print how the pictures compare.
    References(references::ReferencesArgs),
    /// Print the expected error of either of two independent renders, without a reference.
    Half {
        /// One render (EXR).
        a: PathBuf,
        /// The same with another seed (EXR).
        b: PathBuf,
    },
}

fn main() -> ExitCode {
    match run(Cli::parse().chore) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

/// Whether the chore found everything as it should be.
fn run(chore: Chore) -> Result<bool> {
    match chore {
        Chore::Mutants(args) => mutants::run(&args),
        Chore::Pyramid(args) => pyramid::run(&args).map(|()| true),
        Chore::Gallery(args) => gallery::run(&args).map(|()| true),
        Chore::References(args) => references::run(&args),
        Chore::Half { a, b } => half::run(&a, &b).map(|()| true),
    }
}
