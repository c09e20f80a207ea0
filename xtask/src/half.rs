//! The expected error of a render, from two files that differ by their seed alone.

use std::path::Path;

use anyhow::Result;
use midway_film::{ExrFile, Image, half_error};

/// Prints the errors of two files as one JSON object.
pub fn run(a: &Path, b: &Path) -> Result<()> {
    let error = half_error(&read(a)?, &read(b)?)?;
    let object = serde_json::json!({
        "rmse": error.rmse, "relmse": error.relmse, "relmse_trimmed": error.relmse_trimmed,
    });
    println!("{object}");
    Ok(())
}

fn read(path: &Path) -> Result<Image> {
    Ok(ExrFile::read(path)?.image()?)
}
