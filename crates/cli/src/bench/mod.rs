//! `midway bench`: measurements, one file for each.

mod baseline;
mod curves;
mod equal_time;
mod hold;
mod integrator;
mod lights;
mod measured;
mod rays;
mod sampling;
mod scaling;
mod tables;

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
        Bench::EqualTime(args) => equal_time::run(args),
        Bench::Sampling(args) => sampling::run(args),
        Bench::Scaling(args) => scaling::run(args),
        Bench::Lights(args) => lights::run(args),
        Bench::Hold(args) => hold::run(args),
        Bench::Integrator(args) => integrator::run(args),
        Bench::Baseline(args) => baseline::run(args),
        Bench::Tables(args) => tables::run(args),
    }
}
