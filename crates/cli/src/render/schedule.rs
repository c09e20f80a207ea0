//! Pass after pass until something says stop.

use std::time::{Duration, Instant};

use midway_film::Image;

use crate::{interrupt::Interrupt, status::Outcome};

/// What is rendered, one pass at a time.
pub trait Job {
    /// Renders one pass: one or more samples per pixel, at most `limit`.
    ///
    /// # Errors
    /// If the device fails.
    fn step(&mut self, limit: u64) -> Outcome;
    /// Samples per pixel so far.
    fn samples(&self) -> u64;
    /// Rays traced so far.
    fn rays(&self) -> u64;
    /// The image so far.
    ///
    /// # Errors
    /// If the device fails.
    fn image(&mut self) -> Outcome<Image>;
}

/// When to stop; the first that is reached counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Samples per pixel.
    pub samples: Option<u64>,
    /// Time spent in passes.
    pub time: Option<Duration>,
}

/// Why the render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoppedBy {
    /// All samples are there.
    Samples,
    /// The time is over.
    Time,
    /// Ctrl-C, SIGTERM or SIGHUP.
    Interrupt,
}

impl StoppedBy {
    /// The word for files and other programs.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Time => "time",
            Self::Interrupt => "interrupt",
        }
    }
}

/// How a render stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Samples per pixel so far.
    pub samples: u64,
    /// Rays traced so far.
    pub rays: u64,
    /// Time spent in passes; measuring and writing are not in it.
    pub rendering: Duration,
    /// When it will stop.
    pub limits: Limits,
}

impl State {
    /// The part that is done, in [0, 1].
    pub fn fraction(&self) -> f64 {
        let samples = self.limits.samples.map_or(0.0, |limit| self.samples as f64 / limit as f64);
        let time = self.limits.time.map_or(0.0, |limit| self.seconds() / limit.as_secs_f64());
        samples.max(time).clamp(0.0, 1.0)
    }

    /// Seconds left at the present pace; `None` before there is one.
    pub fn seconds_left(&self) -> Option<f64> {
        let fraction = self.fraction();
        (fraction > 0.0).then(|| self.seconds() * (1.0 - fraction) / fraction)
    }

    /// Seconds spent in passes.
    pub fn seconds(&self) -> f64 {
        self.rendering.as_secs_f64()
    }

    /// Millions of rays a second.
    pub fn mrays_per_second(&self) -> f64 {
        if self.rendering.is_zero() { 0.0 } else { self.rays as f64 * 1e-6 / self.seconds() }
    }
}

/// Renders passes until a limit is reached or `interrupt` is pressed. `after_pass` may look at the
/// job; its time does not count. A time limit ends at whichever pass boundary is nearest to it, but
/// not before the first.
///
/// # Errors
/// Those of the job and of `after_pass`.
pub fn run<J: Job + ?Sized>(
    job: &mut J,
    limits: Limits,
    interrupt: &Interrupt,
    mut after_pass: impl FnMut(&mut J, &State) -> Outcome,
) -> Outcome<(StoppedBy, State)> {
    let mut last_pass = Duration::ZERO;
    let mut state = State { samples: job.samples(), rays: job.rays(), rendering: Duration::ZERO, limits };
    loop {
        if let Some(reason) = reason_to_stop(&state, last_pass, interrupt) {
            return Ok((reason, state));
        }
        let left = limits.samples.map_or(u64::MAX, |limit| limit - state.samples);
        let start = Instant::now();
        job.step(left)?;
        last_pass = start.elapsed();
        state.rendering += last_pass;
        (state.samples, state.rays) = (job.samples(), job.rays());
        after_pass(job, &state)?;
    }
}

fn reason_to_stop(state: &State, last_pass: Duration, interrupt: &Interrupt) -> Option<StoppedBy> {
    if interrupt.is_pressed() {
        return Some(StoppedBy::Interrupt);
    }
    if state.limits.samples.is_some_and(|limit| state.samples >= limit) {
        return Some(StoppedBy::Samples);
    }
    let nearest = state.rendering + last_pass / 2;
    (state.samples > 0 && state.limits.time.is_some_and(|limit| nearest >= limit)).then_some(StoppedBy::Time)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status::{Failure, Status};

    /// Takes two samples a pass, a millisecond each.
    struct FakeJob {
        samples: u64,
        fails_at: u64,
    }

    impl Job for FakeJob {
        fn step(&mut self, limit: u64) -> Outcome {
            if self.samples >= self.fails_at {
                return Err(Failure::new(Status::Device, "lost"));
            }
            std::thread::sleep(Duration::from_millis(1));
            self.samples += limit.min(2);
            Ok(())
        }
        fn samples(&self) -> u64 {
            self.samples
        }
        fn rays(&self) -> u64 {
            self.samples * 1000
        }
        fn image(&mut self) -> Outcome<Image> {
            Ok(Image::filled(1, 1, [1.0; 3]))
        }
    }

    fn fake() -> FakeJob {
        FakeJob { samples: 0, fails_at: u64::MAX }
    }

    fn limits(samples: Option<u64>, millis: Option<u64>) -> Limits {
        Limits { samples, time: millis.map(Duration::from_millis) }
    }

    #[test]
    fn the_first_limit_stops_and_is_named() {
        let stop = |samples, millis| {
            run(&mut fake(), limits(samples, millis), &Interrupt::default(), |_, _| Ok(())).unwrap()
        };
        let (reason, state) = stop(Some(7), Some(60_000));
        assert_eq!((reason, state.samples), (StoppedBy::Samples, 7));
        let (reason, state) = stop(Some(1_000_000), Some(20));
        assert_eq!(reason, StoppedBy::Time);
        assert!(state.samples >= 2 && state.rendering < Duration::from_secs(10));
        assert_eq!(stop(None, Some(1)).0, StoppedBy::Time);
    }

    #[test]
    fn ctrl_c_finishes_the_pass() {
        let interrupt = Interrupt::default();
        let mut passes = 0;
        let outcome = run(&mut fake(), limits(Some(100), None), &interrupt, |_, _| {
            passes += 1;
            if passes == 3 {
                interrupt.press();
            }
            Ok(())
        });
        let (reason, state) = outcome.unwrap();
        assert_eq!((reason, state.samples), (StoppedBy::Interrupt, 6));
    }

    #[test]
    fn a_failing_device_ends_the_render() {
        let mut job = FakeJob { samples: 0, fails_at: 4 };
        let outcome = run(&mut job, limits(Some(100), None), &Interrupt::default(), |_, _| Ok(()));
        assert_eq!(outcome.unwrap_err().status, Status::Device);
    }

    #[test]
    fn what_happens_between_passes_costs_no_rendering_time() {
        let pause = |_: &mut FakeJob, _: &State| {
            std::thread::sleep(Duration::from_millis(50));
            Ok(())
        };
        let (_, state) = run(&mut fake(), limits(Some(8), None), &Interrupt::default(), pause).unwrap();
        assert!(state.rendering < Duration::from_millis(150), "{:?}", state.rendering);
    }

    #[test]
    fn the_time_left_follows_the_nearer_limit() {
        let rendering = Duration::from_secs(2);
        let state = State { samples: 10, rays: 4_000_000, rendering, limits: limits(Some(100), Some(4000)) };
        assert_eq!(state.fraction(), 0.5);
        assert_eq!(state.seconds_left(), Some(2.0));
        assert_eq!(state.mrays_per_second(), 2.0);
    }
}
