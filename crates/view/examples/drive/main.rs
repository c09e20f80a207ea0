//! Drives a running `midway view` without a browser, and measures it.
//!
//! `drive ADDRESS SECONDS` orbits with 60 inputs a second and prints frames a second, and the time from
//! an input's message to the decoded frame that shows it. `drive ADDRESS SECONDS CLIENTS PID` soaks: clients
//! send random requests, files and nonsense, nap and vanish, and PID's memory is compared at rest (Linux); ends with
//! status 1 and a line that says why where the server did not take it well ([`verdict`]). Prints JSON.

mod client;
mod files;
mod http;
mod measure;
mod requests;
mod soak;
mod verdict;

use std::{error::Error, process::ExitCode, time::Duration};

type Outcome<T = ()> = Result<T, Box<dyn Error + Send + Sync>>;

/// What is told where the server does not answer any more.
fn gone(error: impl std::fmt::Display) -> Box<dyn Error + Send + Sync> {
    format!("the server has gone: {error}").into()
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments).await {
        Ok(reasons) if reasons.is_empty() => ExitCode::SUCCESS,
        Ok(reasons) => {
            eprintln!("drive: {}", reasons.join("; "));
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("drive: {error}");
            ExitCode::FAILURE
        }
    }
}

/// What is not as it should be.
async fn run(arguments: &[String]) -> Outcome<Vec<String>> {
    let [address, seconds, rest @ ..] = arguments else {
        return Err("drive ADDRESS SECONDS [CLIENTS PID]".into());
    };
    let time = Duration::from_secs_f64(seconds.parse()?);
    match rest {
        [] => {
            println!("{}", measure::measure(address, time).await?);
            Ok(vec![])
        }
        [clients, pid] => {
            let report = soak::soak(address, time, clients.parse()?, pid).await?;
            println!("{}", report.json());
            Ok(report.reasons())
        }
        _ => Err("CLIENTS and PID go together".into()),
    }
}
