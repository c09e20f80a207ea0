//! Flags that mean nothing beside others are refused rather than ignored.

use crate::{
    args::{IntegratorArg, JoinArg, LightSamplingArg, RenderArgs},
    render::job,
    status::{Failure, Outcome},
};

/// Refuses flags that the chosen integrator or join does not have.
///
/// # Errors
/// [`crate::status::Status::Usage`], naming the flag.
pub fn check(args: &RenderArgs) -> Outcome {
    let bdpt_only = [
        ("--join", args.join.is_some()),
        ("--light-paths", args.light_paths.is_some()),
        ("--nee", args.nee.is_some()),
        ("--splat", args.splat.is_some()),
    ];
    refuse(&bdpt_only, args.integrator == IntegratorArg::Bdpt, "--integrator bdpt")?;
    let k_step_only = [("--k", args.k.is_some()), ("--join-choice", args.join_choice.is_some())];
    refuse(&k_step_only, args.join == Some(JoinArg::KStep), "--join k-step")?;
    let asked = [("--light-sampling", args.light_sampling != LightSamplingArg::Auto)];
    refuse(&asked, job::integrator(args).uses_nee(), "an integrator that samples lights")
}

fn refuse(flags: &[(&str, bool)], allowed: bool, with: &str) -> Outcome {
    match flags.iter().find(|(_, given)| *given) {
        Some((flag, _)) if !allowed => Err(Failure::usage(format!("{flag} works with {with} only"))),
        _ => Ok(()),
    }
}
