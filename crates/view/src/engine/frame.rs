//! Frames: how much of the film is rendered in one, and what is shown of it.

use std::time::{Duration, Instant};

use midway_film::{Display, Image};
use midway_render::{Crop, Hold, Join, Load, RenderSettings};

use super::{Engine, Half, MAX_SAMPLES, REST, hold_limits};
use crate::{ViewError, frame::Pixels, layers, protocol::Layer};

/// A frame that refines lasts about this long, so that input waits no longer.
const REFINE: Duration = Duration::from_millis(80);
/// A frame in motion that has not ended after this many times its time is given up for a smaller one.
const MOVING_LATE: u32 = 4;
/// How long a camera at rest is taken to move so that a small picture is shown ahead.
const PREVIEW: Duration = Duration::from_millis(30);

impl Engine {
    /// Renders one frame, or a part of one, and gives its pixels; none where it was stopped or its pass
    /// goes on in the next.
    ///
    /// # Errors
    /// If the device fails.
    pub fn frame(&mut self) -> Result<Option<Pixels>, ViewError> {
        let start = Instant::now();
        let moving = self.is_moving();
        let load = self.hold.load();
        if moving && self.pass_done().is_some() {
            self.restart()?;
        }
        if self.pass_done().is_none() {
            self.apply(if moving { load } else { Load { k: u32::MAX, samples: 1, scale: 1.0 } })?;
        }
        if let Some(camera) = self.next_camera.take() {
            for half in [Some(&mut self.left), self.right.as_mut()].into_iter().flatten() {
                half.renderer.set_camera(&self.scene, &camera)?;
                half.begin();
            }
        }
        let samples = if moving { u64::from(load.samples) } else { u64::MAX >> 1 };
        let time = if moving { self.hold_time } else { REFINE };
        let patience = match moving {
            true if self.hold.is_least() => Duration::MAX,
            true => time * MOVING_LATE,
            false => time,
        };
        let before = self.samples();
        self.haste.begin(!moving);
        let rendered = self.render(samples.min(MAX_SAMPLES), time, patience);
        self.haste.begin(false);
        if !rendered? {
            return Ok(None);
        }
        let after = self.samples();
        let shows = match moving {
            true => before[0] != after[0] && before[1] != after[1],
            false => before != after && self.has_picture(),
        };
        if !shows {
            self.put_off(moving)?;
            return Ok(None);
        }
        self.previewed &= moving;
        let pixels = self.pixels(moving)?;
        self.frame_time = start.elapsed();
        if moving {
            // Fewer than asked for where the time was over.
            let samples = (after[0] - before[0]).clamp(1, u64::from(load.samples)) as u32;
            self.hold.observe(Load { samples, ..load }, self.frame_time);
        }
        Ok(Some(pixels))
    }

    /// A pass has outlasted its frame. In motion it is given up for the smallest there is; at rest it goes
    /// on, but where it is the first a small picture is shown ahead.
    fn put_off(&mut self, moving: bool) -> Result<(), ViewError> {
        if moving {
            self.hold = Hold::new(hold_limits(&self.settings, self.hold_time));
            return self.restart();
        }
        if self.left.renderer.samples() == 0 && !self.previewed {
            self.previewed = true;
            self.moved_at = Instant::now().checked_sub(REST - PREVIEW);
        }
        Ok(())
    }

    /// Whether it was not stopped. In a split whoever has had less time renders, until both have had
    /// theirs.
    fn render(&mut self, samples: u64, time: Duration, patience: Duration) -> Result<bool, ViewError> {
        let Some(right) = &mut self.right else { return self.left.render(samples, time, patience) };
        let start = Instant::now();
        let first = (self.left.renderer.samples(), right.renderer.samples());
        loop {
            let spent = start.elapsed();
            let both = self.left.renderer.samples() != first.0 && right.renderer.samples() != first.1;
            if (both && spent >= time) || spent >= patience {
                return Ok(true);
            }
            let half = if self.left.seconds <= right.seconds { &mut self.left } else { &mut *right };
            if !half.render(samples, time / 8, (patience - spent).min(time))? {
                self.restart()?;
                return Ok(false);
            }
        }
    }

    /// Cuts the renderers to a load.
    fn apply(&mut self, load: Load) -> Result<(), ViewError> {
        let scaled = |side: u32| ((side as f32 * load.scale) as u32).max(1);
        let whole = &self.settings;
        let crop = whole.crop.map(|c| Crop {
            x: scaled(c.x).min(scaled(whole.width) - 1),
            y: scaled(c.y).min(scaled(whole.height) - 1),
            width: scaled(c.width),
            height: scaled(c.height),
        });
        let (width, height) = (scaled(whole.width), scaled(whole.height));
        let crop = if load.scale >= 1.0 { whole.crop } else { crop.map(|c| inside(c, width, height)) };
        let halves = [(Some(&mut self.left), whole.integrator.k), (self.right.as_mut(), self.right_k)];
        for (half, k) in halves.into_iter().filter_map(|(half, k)| Some((half?, k))) {
            let mut integrator = half.renderer.settings().integrator;
            if integrator.joins() == Some(Join::KStep) {
                integrator.k = load.k.min(k);
            }
            let aovs = whole.aovs.clone();
            let settings = RenderSettings { width, height, crop, integrator, aovs, ..whole.clone() };
            let before = half.renderer.samples();
            half.renderer.set_settings(settings)?;
            if half.renderer.samples() < before {
                half.begin();
            }
        }
        Ok(())
    }

    /// Samples of both halves; without a split the one stands for both.
    fn samples(&self) -> [u64; 2] {
        let left = self.left.renderer.samples();
        [left, self.right.as_ref().map_or(left, |half| half.renderer.samples())]
    }

    /// The share that is done of a pass that is under way; none between passes.
    pub(super) fn pass_done(&self) -> Option<f64> {
        let right = self.right.as_ref().and_then(|half| half.renderer.pass_done());
        self.left.renderer.pass_done().or(right)
    }

    /// Brings the picture's pass that is under way nearer to its end, for as long as a frame lasts, and begins
    /// none.
    ///
    /// # Errors
    /// If the device fails.
    pub fn end_pass(&mut self) -> Result<(), ViewError> {
        if self.left.renderer.pass_done().is_some() {
            self.haste.begin(true);
            let rendered = self.left.render(1, REFINE, REFINE);
            self.haste.begin(false);
            if !rendered? {
                self.restart()?; // it was stopped, and both halves are of as much time
            }
        }
        Ok(())
    }

    /// Whether there is a picture of full size, and the view rests.
    pub fn rests(&self) -> bool {
        !self.is_moving() && self.is_whole() && self.has_picture()
    }

    /// Whether a pass has ended that can be shown, of both where two are compared.
    pub fn has_picture(&self) -> bool {
        self.samples().iter().all(|samples| *samples > 0)
    }

    /// The samples so far, as they are shown.
    ///
    /// # Errors
    /// If the device fails.
    pub fn pixels(&mut self, moving: bool) -> Result<Pixels, ViewError> {
        let display = Display { exposure: self.shown.exposure, tone_map: self.shown.tone_map.into() };
        let (layer, mix) = (self.shown.layer, self.mix.clone());
        let picture = |half: &mut Half| -> Result<Vec<u8>, ViewError> {
            match layer {
                Layer::Beauty => {
                    half.renderer.set_mix(&mix);
                    Ok(half.renderer.display(display)?)
                }
                _ => layers::picture(&half.renderer, layer),
            }
        };
        let mut pictures = vec![picture(&mut self.left)?];
        if let Some(half) = &mut self.right {
            pictures.push(picture(half)?);
        }
        let window = self.left.renderer.settings().window();
        Ok(Pixels { input: self.input, width: window.width, height: window.height, pictures, moving })
    }

    /// The picture's radiance.
    ///
    /// # Errors
    /// If the device fails.
    pub fn image(&self) -> Result<Image, ViewError> {
        Ok(self.left.renderer.image()?)
    }

    /// The picture's radiance with the mix of its lights.
    ///
    /// # Errors
    /// If the device fails.
    pub fn mixed_image(&self) -> Result<Image, ViewError> {
        let mixes = !self.mix.is_empty();
        Ok(if mixes { self.left.renderer.mixed_image(&self.mix)? } else { self.left.renderer.image()? })
    }
}

fn inside(crop: Crop, width: u32, height: u32) -> Crop {
    Crop { width: crop.width.min(width - crop.x), height: crop.height.min(height - crop.y), ..crop }
}

#[cfg(test)]
mod tests {
    use crate::engine::tests::{engine_of, scene};

    /// Where a pass lasts longer than a frame, the frame in which it ends is not a whole one longer.
    #[test]
    fn the_rest_of_a_long_pass_is_a_frame() {
        let mut engine = engine_of(scene(), 512);
        let mut n_left = 0;
        while engine.left.renderer.samples() < 4 {
            let (before, was_left) = (engine.left.renderer.samples(), engine.pass_done().is_some());
            engine.frame().unwrap();
            // A small picture is shown ahead of the first pass.
            if engine.is_whole() && was_left {
                n_left += 1;
                let added = engine.left.renderer.samples().saturating_sub(before);
                assert!(added <= 1, "{added} passes in one frame");
            }
        }
        assert!(n_left > 0, "no pass lasted");
    }
}
