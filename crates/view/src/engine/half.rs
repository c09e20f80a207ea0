//! A renderer with its clock, and what ends its passes early.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use midway_render::{RenderStats, Renderer};

use crate::ViewError;

/// A renderer and the time it has spent since its first sample.
pub struct Half {
    /// The renderer.
    pub renderer: Renderer,
    /// Seconds of passes since the last restart.
    pub seconds: f64,
    /// Rays that it had traced then.
    rays_before: u64,
    /// What it had counted after the last frame.
    pub stats: RenderStats,
}

impl Half {
    pub(super) fn new(renderer: Renderer) -> Self {
        Self { renderer, seconds: 0.0, rays_before: 0, stats: RenderStats::default() }
    }

    /// Rays since the last restart.
    pub fn rays(&self) -> u64 {
        self.stats.rays - self.rays_before
    }

    pub(super) fn begin(&mut self) {
        self.seconds = 0.0;
        self.rays_before = self.stats.rays;
    }

    /// Passes, until `samples` of every pixel were added or `time` is over; a first that is not over
    /// after `patience` is left, to go on in the next call. After one that was left before, whose time is not
    /// known, and where no whole one fits the rest, that is all. Whether none of them was stopped.
    pub(super) fn render(
        &mut self,
        samples: u64,
        time: Duration,
        patience: Duration,
    ) -> Result<bool, ViewError> {
        let start = Instant::now();
        let first = self.renderer.samples();
        let was_left = self.renderer.pass_done().is_some();
        let mut goes_on = true;
        loop {
            let (done, spent) = (self.renderer.samples() - first, start.elapsed());
            // As many as fit the rest of the time at the pace so far.
            let pace = done as f64 / spent.as_secs_f64().max(1e-6);
            let fit = (pace * time.saturating_sub(spent).as_secs_f64()) as u64;
            if done >= samples || (done > 0 && (was_left || fit == 0)) {
                break;
            }
            let wanted = (samples - done).min(fit.max(1));
            let patience = if done == 0 { patience.saturating_sub(spent) } else { Duration::MAX };
            match self.renderer.step_within(wanted, patience)? {
                None => break,
                Some(0) => {
                    self.begin();
                    goes_on = false;
                    break;
                }
                Some(_) => {}
            }
        }
        self.seconds += start.elapsed().as_secs_f64();
        self.stats = self.renderer.stats()?;
        Ok(goes_on)
    }
}

/// Tells a pass that refines that something better is to be done.
#[derive(Clone, Default)]
pub struct Haste {
    pub(super) stop: Arc<AtomicBool>,
    /// Frames in motion are short, and are shown whatever comes.
    refines: Arc<AtomicBool>,
}

impl Haste {
    pub(super) fn begin(&self, refines: bool) {
        self.refines.store(refines, Ordering::Relaxed);
        self.stop.store(false, Ordering::Relaxed);
    }

    /// Ends the pass that is under way, if it refines.
    pub fn stop(&self) {
        if self.refines.load(Ordering::Relaxed) {
            self.stop.store(true, Ordering::Relaxed);
        }
    }
}
