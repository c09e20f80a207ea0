//! Several devices at one image: each renders samples that no other does.

use std::{
    sync::{Arc, Mutex, PoisonError},
    thread,
    time::{Duration, Instant},
};

use midway_device::{Device, MemoryPlan};
use midway_scene::{Camera, Scene};

use crate::{RenderError, RenderSettings, RenderStats, Renderer};

/// A renderer for each of several devices. Samples are numbered, and a device takes the next numbers as
/// it comes free, so that a fast one does more; films are sums of integers, so that devices which compute
/// alike give the bits that one of them would give alone.
pub struct Team {
    lead: Renderer,
    others: Vec<Renderer>,
    /// Samples that were given out.
    given: u64,
}

/// The numbers of samples that are left.
struct Left {
    next: u64,
    end: u64,
}

impl Team {
    /// As [`Renderer::with_plan`], for each of `devices` at once; `tell` is handed the plan of the first,
    /// which the others repeat. The scene is packed once for each.
    ///
    /// # Errors
    /// As [`Renderer::new`], of any of them.
    ///
    /// # Panics
    /// Without a device.
    pub fn new(
        devices: &[Arc<dyn Device>],
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
        also: &[RenderSettings],
        tell: impl FnOnce(&MemoryPlan),
    ) -> Result<Self, RenderError> {
        let (first, rest) = devices.split_first().expect("a team has a device");
        // The warm-up of `auto` is the first device's.
        let has_groups = |other: &&RenderSettings| other.light_groups == settings.light_groups;
        let ahead: Vec<_> = also.iter().filter(has_groups).cloned().collect();
        let start = |device: &Arc<dyn Device>| {
            Renderer::with_plan(Arc::clone(device), scene, camera, without_layers(settings), &ahead, |_| {})
        };
        thread::scope(|scope| {
            let others: Vec<_> = rest.iter().map(|device| scope.spawn(move || start(device))).collect();
            let lead = Renderer::with_plan(Arc::clone(first), scene, camera, settings.clone(), also, tell);
            let others = others.into_iter().map(|thread| thread.join().expect("renderers do not panic"));
            let others = others.collect::<Result<Vec<_>, _>>()?;
            Ok(Self { lead: lead?, others, given: 0 })
        })
    }

    /// Renders passes on every device: at least one on the first, then on each until `time` is over, and
    /// no more than `max_samples` in all.
    ///
    /// # Errors
    /// If a device fails; the first that does counts, and its samples of this call are lost.
    pub fn step(&mut self, max_samples: u64, time: Duration) -> Result<(), RenderError> {
        if self.others.is_empty() {
            self.given += self.lead.step(max_samples)?;
            return Ok(());
        }
        let (start, n_renderers) = (Instant::now(), self.others.len() as u64 + 1);
        let left = Mutex::new(Left { next: self.given, end: self.given.saturating_add(max_samples) });
        let work = |renderer: &mut Renderer| -> Result<(), RenderError> {
            loop {
                let (first, n) =
                    left.lock().unwrap_or_else(PoisonError::into_inner).take(renderer, n_renderers);
                if n == 0 {
                    return Ok(());
                }
                renderer.step_from(first, n)?;
                if start.elapsed() >= time {
                    return Ok(());
                }
            }
        };
        let outcome = thread::scope(|scope| {
            let others: Vec<_> =
                self.others.iter_mut().map(|renderer| scope.spawn(|| work(renderer))).collect();
            let lead = work(&mut self.lead);
            let join =
                |thread: thread::ScopedJoinHandle<'_, _>| thread.join().expect("renderers do not panic");
            others.into_iter().map(join).fold(lead, Result::and)
        });
        self.given = left.into_inner().unwrap_or_else(PoisonError::into_inner).next;
        outcome
    }

    /// Samples of every pixel so far, of all devices.
    pub fn samples(&self) -> u64 {
        self.lead.samples() + self.others.iter().map(Renderer::samples).sum::<u64>()
    }

    /// The first device's renderer, with all samples so far on its film.
    ///
    /// # Errors
    /// If a device fails.
    pub fn gathered(&mut self) -> Result<&mut Renderer, RenderError> {
        for other in &mut self.others {
            self.lead.take_samples(other)?;
        }
        Ok(&mut self.lead)
    }

    /// The first device's renderer: settings and plans.
    pub fn lead(&self) -> &Renderer {
        &self.lead
    }

    /// As [`Renderer::set_settings`], for all of them; the next pass is the first again.
    ///
    /// # Errors
    /// As [`Renderer::set_settings`].
    pub fn set_settings(&mut self, settings: &RenderSettings) -> Result<(), RenderError> {
        for other in &mut self.others {
            other.set_settings(without_layers(settings))?;
            other.restart()?;
        }
        self.lead.set_settings(settings.clone())?;
        self.given = 0;
        self.lead.restart()
    }

    /// What all of them have done.
    ///
    /// # Errors
    /// If a device fails.
    pub fn stats(&self) -> Result<RenderStats, RenderError> {
        let mut sum = self.lead.stats()?;
        for other in &self.others {
            let RenderStats { rays, rejected, overflowed, .. } = other.stats()?;
            (sum.rays, sum.rejected, sum.overflowed) =
                (sum.rays + rays, sum.rejected + rejected, sum.overflowed + overflowed);
        }
        Ok(sum)
    }
}

impl Left {
    /// The first number and the count of a renderer's next pass: at the end each has its share of them.
    fn take(&mut self, renderer: &Renderer, n_renderers: u64) -> (u64, u64) {
        let (first, left) = (self.next, self.end - self.next);
        let n = renderer.pass_of(left.div_ceil(n_renderers));
        self.next += n;
        (first, n)
    }
}

/// Layers are measured where films are gathered.
fn without_layers(settings: &RenderSettings) -> RenderSettings {
    RenderSettings { aovs: Vec::new(), ..settings.clone() }
}
