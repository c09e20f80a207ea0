//! Passes: the same number of samples of every pixel, at once or in parts.

use std::{
    sync::atomic::Ordering,
    time::{Duration, Instant},
};

use midway_kernels::layout::Params;

use super::{Renderer, batches::Batch};
use crate::RenderError;

/// A pass that is not over: the film holds some of its samples.
pub(super) struct Pass {
    params: Params,
    n_samples: u32,
    n_places: u32,
    /// Places that are on the film: all before this one.
    next: u32,
    /// Time spent on them.
    spent: Duration,
}

impl Renderer {
    /// Renders one pass: at least one sample of every pixel, at most `max_samples`. Returns how many:
    /// 0 where the pass was stopped ([`Renderer::stop_when`]), and with it all samples are forgotten.
    ///
    /// # Errors
    /// If the device fails.
    pub fn step(&mut self, max_samples: u64) -> Result<u64, RenderError> {
        loop {
            if let Some(samples) = self.step_within(max_samples, Duration::MAX)? {
                return Ok(samples);
            }
        }
    }

    /// As [`Renderer::step`], but left after about `time`, between two batches, where the pass is not
    /// over: none then, and the next call goes on with it. Meanwhile the image is the one before it, and
    /// what changes the renderer forgets the pass with all samples, or brings it to its end first.
    ///
    /// # Errors
    /// If the device fails.
    pub fn step_within(&mut self, max_samples: u64, time: Duration) -> Result<Option<u64>, RenderError> {
        let start = Instant::now();
        let mut pass = match self.pass.take() {
            Some(pass) => pass,
            None => {
                if time < Duration::MAX && self.samples > 0 {
                    self.write_resolve_params()?;
                    self.device.run(&[self.resolve_shown()?], false)?;
                }
                self.begin_pass(max_samples)?
            }
        };
        let params = pass.params;
        pass.next = self.for_each_batch(pass.next..pass.n_places, start, time, |device, lane, batch| {
            let Batch { first: first_path, n_paths, n_places } = batch;
            self.render_batch(device, lane, Params { first_path, n_paths, n_places, ..params })
        })?;
        pass.spent += start.elapsed();
        if self.kept.stop.swap(false, Ordering::Relaxed) {
            self.restart()?;
            return Ok(Some(0));
        }
        if pass.next < pass.n_places {
            self.pass = Some(pass);
            return Ok(None);
        }
        self.last_pass = Some((pass.n_samples, pass.spent));
        self.count_samples(pass.n_samples)?;
        self.next_sample += u64::from(pass.n_samples);
        Ok(Some(u64::from(pass.n_samples)))
    }

    /// The share of the pass under way that is done, in [0, 1); none between passes.
    pub fn pass_done(&self) -> Option<f64> {
        self.pass.as_ref().map(|pass| f64::from(pass.next) / f64::from(pass.n_places))
    }

    /// Counts `n` samples that are on the film, and measures its layers after them.
    pub(super) fn count_samples(&mut self, n: u32) -> Result<(), RenderError> {
        let params = Params { first_sample: self.samples as u32, ..self.base };
        self.aovs.measure(&*self.device, &params, n)?;
        self.samples += u64::from(n);
        Ok(())
    }

    fn begin_pass(&self, max_samples: u64) -> Result<Pass, RenderError> {
        let n_samples = self.next_pass(max_samples);
        let params = Params { first_sample: self.next_sample as u32, ..self.base };
        if self.pool.is_some() {
            self.trace_pool(&params)?;
        }
        Ok(Pass { params, n_samples, n_places: params.n_pixels * n_samples, next: 0, spent: Duration::ZERO })
    }

    /// Samples of the next pass, of at most `max_samples`.
    pub(super) fn next_pass(&self, max_samples: u64) -> u32 {
        let largest = self.aovs.largest_pass(self.samples).min(max_samples.max(1));
        self.samples_per_pass().min(u32::try_from(largest).unwrap_or(u32::MAX))
    }

    /// Samples of a pass: a pool is made for one sample of every pixel; else as many as fill the lanes.
    fn samples_per_pass(&self) -> u32 {
        if self.pool.is_some() {
            return 1;
        }
        self.samples_to_fill()
    }
}
