//! `midway compare`.

use midway_film::{
    Comparison, DEFAULT_PIXELS_PER_DEGREE, ExrFile, Metadata, check_writable, compare, flip, heatmap,
    write_srgb8_png,
};
use serde_json::{Value, json};

use crate::{args::CompareArgs, console, status::Outcome};

/// Prints the errors of an image against a reference and draws them if asked.
///
/// # Errors
/// [`crate::status::Status::Input`] if an image cannot be read, `NotComparable` if sizes differ or
/// a pixel is not finite, `Output` if the heat map cannot be written.
pub fn run(args: &CompareArgs) -> Outcome {
    if let Some(path) = &args.heatmap {
        check_writable(path)?;
    }
    let test = ExrFile::read(&args.test)?.image()?;
    let reference = ExrFile::read(&args.reference)?.image()?;
    let errors = compare(&test, &reference)?;
    if let Some(path) = &args.heatmap {
        let map = flip(&test, &reference, DEFAULT_PIXELS_PER_DEGREE)?;
        write_srgb8_png(path, test.size(), &heatmap(&map, 1.0), &Metadata::new())?;
    }
    if args.json {
        return console::output(&to_json(&errors).to_string());
    }
    to_lines(&errors).iter().try_for_each(|line| console::output(line))
}

/// Numbers that JSON does not have (an infinite ratio) become null.
fn to_json(errors: &Comparison) -> Value {
    json!({
        "mae": errors.mae,
        "rmse": errors.rmse,
        "relmse": errors.relmse,
        "flip": errors.flip,
        "mean_ratio": errors.mean_ratio,
        "block_ratio": errors.block_ratio,
    })
}

fn to_lines(errors: &Comparison) -> [String; 6] {
    let [r, g, b] = errors.mean_ratio;
    let [low, median, high] = errors.block_ratio;
    [
        format!("MAE         {:.6e}", errors.mae),
        format!("RMSE        {:.6e}", errors.rmse),
        format!("relMSE      {:.6e}", errors.relmse),
        format!("FLIP        {:.6}", errors.flip),
        format!("mean ratio  {r:.6} {g:.6} {b:.6}  (red, green, blue)"),
        format!("blocks      {median:.6}  ({low:.4} to {high:.4} in four fifths of the blocks of 16 x 16)"),
    ]
}
