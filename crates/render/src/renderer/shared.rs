//! Samples of one image by several renderers, each with a device and a film of its own.

use super::Renderer;
use crate::RenderError;

impl Renderer {
    /// The most samples that one pass would render of `max_samples`; none of none.
    pub(crate) fn pass_of(&self, max_samples: u64) -> u64 {
        if max_samples == 0 { 0 } else { u64::from(self.next_pass(max_samples)) }
    }

    /// Renders one pass of the `n` samples numbered from `first` on; `n` is of [`Renderer::pass_of`].
    pub(crate) fn step_from(&mut self, first: u64, n: u64) -> Result<(), RenderError> {
        self.next_sample = first;
        self.step(n)?;
        Ok(())
    }

    /// Takes all samples of `other`, of the same scene and settings but for layers: film to film, as
    /// integers, so that the image has the same bits whoever rendered which samples. They count as one
    /// pass to the variance.
    pub(crate) fn take_samples(&mut self, other: &mut Self) -> Result<(), RenderError> {
        if other.samples == 0 {
            return Ok(());
        }
        let read = |renderer: &Self| renderer.device.read_buffer(&renderer.film, 0, renderer.film.bytes());
        let (mut sums, theirs) = (read(self)?, read(other)?);
        let mut overflowed = 0;
        for (sum, more) in sums.as_chunks_mut::<8>().0.iter_mut().zip(theirs.as_chunks::<8>().0) {
            let (total, overflows) = u64::from_le_bytes(*sum).overflowing_add(u64::from_le_bytes(*more));
            *sum = total.to_le_bytes();
            overflowed += u64::from(overflows);
        }
        self.device.write_buffer(&self.film, 0, &sums)?;
        self.carried.overflowed += overflowed;
        self.count_samples(u32::try_from(other.samples).unwrap_or(u32::MAX))?;
        other.restart()
    }
}
