//! The program `midway`.
//!
//! What was typed is parsed in [`args`]; [`render`], [`view`], [`compare`], [`info`], [`devices`] and
//! [`bench`] do the work; [`status`] lists every exit code. Results for other programs go to standard output,
//! everything for people to standard error.

mod args;
mod bench;
mod compare;
mod console;
mod devices;
mod guard;
mod info;
mod interrupt;
mod light_info;
mod render;
mod scene_file;
mod status;
mod view;

use std::process::ExitCode;

use clap::Parser;

use crate::{
    args::{Cli, Command},
    status::{Outcome, Status},
};

fn main() -> ExitCode {
    // SAFETY: no other thread runs yet.
    unsafe { midway_device::keep_drivers_quiet() };
    let status = guard::catching_panics(run);
    ExitCode::from(status.code())
}

fn run() -> Status {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return report_usage(&error),
    };
    match dispatch(cli.command) {
        Ok(status) => status,
        Err(failure) => {
            console::error(&failure.to_line());
            failure.status
        }
    }
}

/// Help and version go to standard output and are no failure; the rest names the mistake.
fn report_usage(error: &clap::Error) -> Status {
    // Nothing is left to tell it to if this fails.
    let _ = error.print();
    if error.use_stderr() { Status::Usage } else { Status::Success }
}

fn dispatch(command: Command) -> Outcome<Status> {
    match command {
        Command::Render(args) => render::run(&args),
        Command::View(args) => view::run(&args),
        Command::Compare(args) => compare::run(&args).map(|()| Status::Success),
        Command::Info(args) => info::run(&args).map(|()| Status::Success),
        Command::Devices(args) => devices::run(&args).map(|()| Status::Success),
        Command::Bench(args) => bench::run(&args).map(|()| Status::Success),
    }
}
