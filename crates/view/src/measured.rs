//! How far a resting picture is from the truth, against seconds.

use std::collections::VecDeque;

use midway_film::Image;

use crate::{ViewError, black, engine::Engine, layers};

/// The first measurement of noise, in samples; the next ones have this many times as many.
const MEASURE_FIRST: u64 = 4;
const MEASURE_GROWTH: f64 = 1.2;
/// Points of the plot at most; then every other one is dropped.
const MAX_POINTS: usize = 160;

/// The noise, and the plot.
#[derive(Default)]
pub struct Measured {
    /// Seconds and relMSE.
    pub points: Vec<[f64; 2]>,
    /// The last.
    pub relmse: Option<f64>,
    /// Whether that is the distance from a reference, not estimated from halves of the samples.
    pub by_reference: bool,
    next: u64,
    /// Why the picture is black, if it is.
    pub black: Option<String>,
    samples: u64,
    /// Images after some of the samples, each after twice as many as the one before: the last three.
    halves: VecDeque<(Image, u64)>,
}

impl Measured {
    /// What an image of `n` samples is compared with for its error: one that holds at most two
    /// thirds of them, where there is one about half.
    fn half_of(&mut self, image: &Image, n: u64) -> Option<&(Image, u64)> {
        if self.halves.back().is_none_or(|(last, at)| n >= 2 * at || last.size() != image.size()) {
            self.halves.push_back((image.clone(), n));
            if self.halves.len() > 3 {
                self.halves.pop_front();
            }
        }
        let fits = |(half, at): &&(Image, u64)| 3 * at <= 2 * n && half.size() == image.size();
        self.halves.iter().rev().find(fits)
    }

    /// The noise of a resting picture, now and then.
    ///
    /// # Errors
    /// If the device fails.
    pub fn measure(&mut self, engine: &Engine, reference: Option<&Image>) -> Result<(), ViewError> {
        let left = &engine.left;
        let samples = left.renderer.samples();
        if samples < self.samples {
            *self = Self::default();
        }
        let unsettled = engine.is_moving() || left.renderer.pass_done().is_some();
        if unsettled || samples < self.next.max(MEASURE_FIRST) {
            return Ok(());
        }
        let image = engine.image()?;
        let reference = reference.filter(|r| r.size() == image.size());
        self.by_reference = reference.is_some();
        let relmse = match reference {
            Some(reference) => {
                midway_film::rmse_and_relmse(&image, reference).map_or(f64::NAN, |(_, relmse)| relmse)
            }
            None => match self.half_of(&image, samples) {
                Some((half, n)) => layers::expected_relmse((&image, samples), (half, *n)),
                None => f64::NAN,
            },
        };
        self.next = ((samples as f64 * MEASURE_GROWTH) as u64).max(samples + 1);
        self.samples = samples;
        if relmse.is_finite() {
            self.relmse = Some(relmse);
            if relmse > 0.0 {
                self.points.push([left.seconds, relmse]);
            }
        }
        if self.points.len() > MAX_POINTS {
            let mut place = 0;
            self.points.retain(|_| {
                place += 1;
                place % 2 == 0
            });
        }
        self.black = black::reason(engine, &image)?;
        Ok(())
    }

    /// Says anew why the picture is black, or that it is not, after it is shown in another way.
    ///
    /// # Errors
    /// If the device fails.
    pub fn judge_black(&mut self, engine: &Engine) -> Result<(), ViewError> {
        self.black = if engine.rests() { black::reason(engine, &engine.image()?)? } else { None };
        Ok(())
    }
}
