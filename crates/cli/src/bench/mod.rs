//! `midway bench`: measurements, one file for each.

mod rays;

use crate::{
    args::{Bench, BenchArgs},
    status::Outcome,
};

/// Measures what was asked for.
///
/// # Errors
/// As the measurement says.
pub fn run(args: &BenchArgs) -> Outcome {
    match &args.what {
        Bench::Rays(args) => rays::run(args),
    }
}
