//! What a render says while it runs.

use std::{
    io::{self, IsTerminal},
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Value, json};

use super::schedule::State;
use crate::{args::ProgressArg, console, status::Outcome};

/// Between two lines of `--progress plain`.
const PLAIN_INTERVAL: Duration = Duration::from_secs(2);
/// Between two objects of `--progress json`.
const JSON_INTERVAL: Duration = Duration::from_millis(200);
/// Steps of the bar.
const BAR_STEPS: u64 = 1000;

/// Notes, warnings and progress, as asked for.
pub struct Reporter {
    quiet: bool,
    style: Style,
    last: Option<Instant>,
}

enum Style {
    Silent,
    Plain,
    Json,
    Bar(ProgressBar),
}

impl Reporter {
    /// `quiet` silences all but explicitly chosen progress.
    pub fn new(progress: ProgressArg, quiet: bool) -> Self {
        let style = match progress {
            ProgressArg::Plain => Style::Plain,
            ProgressArg::Json => Style::Json,
            ProgressArg::Auto if quiet || !io::stderr().is_terminal() => Style::Silent,
            ProgressArg::Auto => Style::Bar(bar()),
        };
        Self { quiet, style, last: None }
    }

    /// A line for people.
    pub fn note(&self, line: &str) {
        if !self.quiet {
            self.above_bar(|| console::note(line));
        }
    }

    /// Something that was not as it should be.
    pub fn warning(&self, line: &str) {
        if !self.quiet {
            self.above_bar(|| console::warning(line));
        }
    }

    /// An object for other programs, with `--progress json`.
    ///
    /// # Errors
    /// If standard output cannot take it.
    pub fn event(&self, name: &str, fields: &Value) -> Outcome {
        let Style::Json = self.style else { return Ok(()) };
        let mut object = json!({ "event": name });
        if let (Some(object), Some(fields)) = (object.as_object_mut(), fields.as_object()) {
            object.extend(fields.clone());
        }
        console::output(&object.to_string())
    }

    /// After a pass.
    ///
    /// # Errors
    /// If standard output cannot take it.
    pub fn progress(&mut self, state: &State) -> Outcome {
        let due = match self.style {
            Style::Silent => false,
            Style::Bar(_) => true,
            Style::Plain => self.is_due(PLAIN_INTERVAL),
            Style::Json => self.is_due(JSON_INTERVAL),
        };
        match &self.style {
            _ if !due => {}
            Style::Silent => {}
            Style::Plain => console::note(&line(state)),
            Style::Json => self.event("progress", &object(state))?,
            Style::Bar(bar) => {
                bar.set_position((state.fraction() * BAR_STEPS as f64) as u64);
                bar.set_message(line(state));
            }
        }
        Ok(())
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        if let Style::Bar(bar) = &self.style {
            bar.finish_and_clear();
        }
    }

    fn is_due(&mut self, interval: Duration) -> bool {
        let due = self.last.is_none_or(|last| last.elapsed() >= interval);
        if due {
            self.last = Some(Instant::now());
        }
        due
    }

    fn above_bar(&self, print: impl FnOnce()) {
        match &self.style {
            Style::Bar(bar) => bar.suspend(print),
            _ => print(),
        }
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(BAR_STEPS), ProgressDrawTarget::stderr());
    // The template is constant; were it wrong, indicatif's own would do.
    let style =
        ProgressStyle::with_template("{bar:24} {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.with_style(style.progress_chars("=> "))
}

/// `12 of 64 samples, 3.4 Mrays/s, 1.2 s, 5.3 s left`.
fn line(state: &State) -> String {
    let of = state.limits.samples.map_or(String::new(), |limit| format!(" of {limit}"));
    let left = state.seconds_left().map_or(String::new(), |left| format!(", {} left", seconds(left)));
    format!(
        "{}{of} samples, {:.1} Mrays/s, {}{left}",
        state.samples,
        state.mrays_per_second(),
        seconds(state.seconds())
    )
}

fn object(state: &State) -> Value {
    json!({
        "samples": state.samples,
        "samples_limit": state.limits.samples,
        "seconds": state.seconds(),
        "seconds_limit": state.limits.time.map(|limit| limit.as_secs_f64()),
        "seconds_left": state.seconds_left(),
        "fraction": state.fraction(),
        "mrays_per_second": state.mrays_per_second(),
    })
}

/// A time for people: `1.2 s`, `2 min 05 s`, `3 h 20 min`.
pub fn seconds(seconds: f64) -> String {
    if seconds < 60.0 {
        return format!("{seconds:.1} s");
    }
    let whole = seconds.round() as u64;
    let (hours, minutes, rest) = (whole / 3600, whole / 60 % 60, whole % 60);
    if hours > 0 { format!("{hours} h {minutes:02} min") } else { format!("{minutes} min {rest:02} s") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::schedule::Limits;

    #[test]
    fn a_line_has_samples_pace_and_times() {
        let limits = Limits { samples: Some(64), time: None };
        let rendering = Duration::from_secs(2);
        let mut state = State { samples: 16, rays: 10_000_000, rendering, limits };
        assert_eq!(line(&state), "16 of 64 samples, 5.0 Mrays/s, 2.0 s, 6.0 s left");
        state.limits = Limits { samples: None, time: Some(Duration::from_secs(300)) };
        assert_eq!(line(&state), "16 samples, 5.0 Mrays/s, 2.0 s, 4 min 58 s left");
        assert_eq!(seconds(12_000.0), "3 h 20 min");
    }
}
