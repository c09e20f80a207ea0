//! Holds a target time for each frame, by what a frame is made of: K, samples, resolution.
//!
//! Pure logic: a caller times each frame and renders the next one with what [`Hold::load`] says. The
//! time of a frame of *n* full-size samples, each with K joins a vertex, is taken to be c + n (a + b K);
//! c, a and b are fitted to the frames seen, recent ones most, each by its relative error. c is what a
//! GPU takes to be told of a frame's many small dispatches, however few pixels it has. What the
//! controller chooses depends on times alone, so that every frame is as unbiased as its K is.

use std::time::Duration;

use glam::{DMat3, DVec3};

/// Of older frames' weight this much is left after a frame.
const MEMORY: f64 = 0.8;
/// A frame that is off its prediction by more than this factor, though its load was that of the frame
/// before, says that another scene or another view has begun: what came before is as good as forgotten.
const SURPRISE: f64 = 1.3;
/// How firmly the last fit is believed where the frames seen do not tell c, a and b apart.
const TRUST: f64 = 0.01;
/// Before any frame, K joins are taken to cost this share of a sample each.
const FIRST_JOIN_COST: f64 = 0.25;
/// And this share of the first frame is taken to be what any frame costs.
const FIRST_FIXED_COST: f64 = 0.25;
/// A frame is planned to take this share of the target, so that few frames miss it.
const AIM: f64 = 0.9;
/// A load that is in time is kept until another is predicted to do this many times the work.
const WORTH: f64 = 1.25;
/// From one frame to the next a prediction grows by this factor at most: a side that doubles.
const GROWTH: f64 = 4.0;
/// And K by this one: before other values of K were seen its cost is a guess.
const K_GROWTH: u32 = 2;
/// A side's scale is a multiple of one over this, so that films change size seldom.
const SCALE_STEPS: f32 = 8.0;

/// What a frame is rendered with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Joins a vertex.
    pub k: u32,
    /// Samples of each pixel.
    pub samples: u32,
    /// Of each side of the image, in (0, 1].
    pub scale: f32,
}

impl Load {
    /// Samples of full-size frames, without K.
    fn size(&self) -> f64 {
        f64::from(self.samples) * f64::from(self.scale).powi(2)
    }
}

/// What a controller may choose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoldLimits {
    /// How long a frame is to last.
    pub target: Duration,
    /// The smallest K, > 0.
    pub least_k: u32,
    /// The K wanted where there is time for it, at least `least_k`.
    pub most_k: u32,
    /// Samples of a pixel in a frame at most, > 0.
    pub most_samples: u32,
    /// The smallest scale of a side, in (0, 1]; 1 leaves resolution alone.
    pub least_scale: f32,
}

/// What the costs of a frame are multiplied by.
fn terms(load: Load) -> DVec3 {
    DVec3::new(1.0, load.size(), load.size() * f64::from(load.k))
}

/// The controller.
#[derive(Clone, Debug)]
pub struct Hold {
    limits: HoldLimits,
    load: Load,
    /// Seconds of a frame without samples, of a sample without joins, and of one join a vertex of it.
    cost: DVec3,
    /// Normal equations of the fit, and their right side.
    squares: DMat3,
    products: DVec3,
    /// The load of the last frame seen.
    last: Option<Load>,
    /// Whether frames of two sizes were seen: else nothing tells c from a.
    told_apart: bool,
}

impl Hold {
    /// Starts with the smallest load: the first frame is never late by much.
    pub fn new(limits: HoldLimits) -> Self {
        let load = Load { k: limits.least_k, samples: 1, scale: limits.least_scale };
        Self {
            limits,
            load,
            cost: DVec3::ZERO,
            squares: DMat3::ZERO,
            products: DVec3::ZERO,
            last: None,
            told_apart: false,
        }
    }

    /// What the next frame is to be rendered with.
    pub fn load(&self) -> Load {
        self.load
    }

    /// Whether the next frame's load is the smallest that there is.
    pub fn is_least(&self) -> bool {
        let Load { k, samples, scale } = self.load;
        k <= self.limits.least_k && samples == 1 && scale <= self.limits.least_scale
    }

    /// Changes what may be chosen, and keeps what is known of costs.
    pub fn set_limits(&mut self, limits: HoldLimits) {
        self.limits = limits;
        self.load.k = self.load.k.clamp(limits.least_k, limits.most_k);
        self.load.samples = self.load.samples.clamp(1, limits.most_samples);
        self.load.scale = self.load.scale.clamp(limits.least_scale, 1.0);
        if self.last.is_some() {
            self.choose();
        }
    }

    /// How long a frame of `load` is expected to last, in seconds; 0 before the first observation.
    pub fn predict(&self, load: Load) -> f64 {
        self.cost.dot(terms(load))
    }

    /// Learns how long a frame of `load` took (it may be another than [`Hold::load`] asked for), and
    /// chooses the next.
    pub fn observe(&mut self, load: Load, time: Duration) {
        let seconds = time.as_secs_f64().max(1e-9);
        let x = terms(load);
        if self.last.is_none() {
            let sample = (1.0 - FIRST_FIXED_COST) * seconds / (x.y + FIRST_JOIN_COST * x.z);
            self.cost = DVec3::new(FIRST_FIXED_COST * seconds, sample, FIRST_JOIN_COST * sample);
        }
        let off = seconds / self.predict(load);
        if self.last == Some(load) && !(1.0 / SURPRISE..=SURPRISE).contains(&off) {
            self.cost *= off;
            self.squares = DMat3::ZERO;
            self.products = DVec3::ZERO;
            self.told_apart = false;
        }
        self.told_apart |= self.last.is_some_and(|last| last.size() != load.size());
        self.last = Some(load);
        // Each frame counts by its relative error: rows are divided by the time.
        let row = x / seconds;
        self.squares = self.squares * MEMORY + DMat3::from_cols(row * row.x, row * row.y, row * row.z);
        self.products = self.products * MEMORY + row;
        self.fit();
        self.choose();
    }

    /// Least squares with the last fit as a prior, each unknown scaled by its own diagonal. Costs are
    /// not negative: one that would be is left out, and the rest fitted again.
    fn fit(&mut self) {
        let diagonal = DVec3::new(self.squares.x_axis.x, self.squares.y_axis.y, self.squares.z_axis.z);
        let prior = TRUST * diagonal; // > 0: a frame was seen
        let mut matrix = self.squares + DMat3::from_diagonal(prior);
        let mut right = self.products + prior * self.cost;
        for _ in 0..3 {
            self.cost = matrix.inverse() * right;
            let Some(negative) = (0..3).find(|&i| self.cost[i] < 0.0) else { return };
            for other in (0..3).filter(|&other| other != negative) {
                matrix.col_mut(negative)[other] = 0.0;
                matrix.col_mut(other)[negative] = 0.0;
            }
            right[negative] = 0.0;
        }
        self.cost = self.cost.max(DVec3::ZERO);
    }

    fn choose(&mut self) {
        let limits = self.limits;
        let target = limits.target.as_secs_f64();
        let ideal = self.ideal(target * AIM, self.limits.most_k);
        let now = self.predict(self.load);
        if !self.told_apart && now < target * AIM && ideal.size() <= self.load.size() && self.load.scale < 1.0
        {
            // The next size tells whether it is size that costs.
            self.load.scale = (self.load.scale + 1.0 / SCALE_STEPS).min(1.0);
            return;
        }
        let gain = (self.predict(ideal) - self.cost.x) / (now - self.cost.x).max(f64::MIN_POSITIVE);
        if now <= target && gain <= WORTH && self.no_better(ideal) {
            return;
        }
        // Slower at once, faster in steps: a wrong fit then costs one frame a little.
        let most = (self.cost.x + (now - self.cost.x) * GROWTH).min(target * AIM);
        let most_k = self.limits.most_k.min(self.load.k.saturating_mul(K_GROWTH));
        self.load = self.ideal(most.max(f64::MIN_POSITIVE), most_k);
    }

    /// Whether a load that is in time is left alone: it is, unless the other has the K that is
    /// wanted or the full resolution, and this one has not.
    fn no_better(&self, ideal: Load) -> bool {
        let is_whole = self.load.scale >= 1.0 || ideal.scale < 1.0;
        let has_k = self.load.k >= self.limits.most_k || ideal.k < self.limits.most_k;
        is_whole && has_k
    }

    /// The best load predicted within `budget` seconds, or the smallest: first full resolution, then
    /// K up to `most_k`, then more samples.
    fn ideal(&self, budget: f64, most_k: u32) -> Load {
        let HoldLimits { least_k, most_samples, least_scale, .. } = self.limits;
        let [fixed, sample, join] = self.cost.to_array();
        let budget = (budget - fixed).max(0.0);
        let smallest = sample + join * f64::from(least_k);
        if smallest > budget {
            let scale = (budget / smallest).sqrt() as f32;
            let scale = ((scale * SCALE_STEPS).floor() / SCALE_STEPS).clamp(least_scale, 1.0);
            return Load { k: least_k, samples: 1, scale };
        }
        let k = if join > 0.0 { ((budget - sample) / join) as u32 } else { most_k };
        let k = k.clamp(least_k, most_k);
        let fitting = budget / (sample + join * f64::from(k)).max(f64::MIN_POSITIVE);
        let samples = if k == self.limits.most_k { fitting as u32 } else { 1 };
        Load { k, samples: samples.clamp(1, most_samples), scale: 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TARGET: f64 = 0.033;

    fn limits() -> HoldLimits {
        HoldLimits {
            target: Duration::from_secs_f64(TARGET),
            least_k: 1,
            most_k: 16,
            most_samples: 64,
            least_scale: 0.25,
        }
    }

    /// Frames of a machine whose sample costs `a` and whose join costs `b` seconds, with 5 % noise.
    fn play(hold: &mut Hold, n: usize, a: f64, b: f64) -> Vec<(Load, f64)> {
        play_fixed(hold, n, 0.0, a, b)
    }

    /// The same with `c` seconds for any frame.
    fn play_fixed(hold: &mut Hold, n: usize, c: f64, a: f64, b: f64) -> Vec<(Load, f64)> {
        (0..n)
            .map(|i| {
                let load = hold.load();
                let noise = 1.0 + 0.05 * ((i as f64 * 12.9898).sin() * 43_758.547).fract();
                let seconds = (c + load.size() * (a + b * f64::from(load.k))) * noise;
                hold.observe(load, Duration::from_secs_f64(seconds));
                (load, seconds)
            })
            .collect()
    }

    /// A GPU is as slow at a sixty-fourth of the pixels as at a quarter.
    #[test]
    fn what_any_frame_costs_does_not_keep_frames_small() {
        let smallest = HoldLimits { least_scale: 0.125, ..limits() };
        let mut hold = Hold::new(smallest);
        let frames = play_fixed(&mut hold, 60, 0.021, 0.012, 0.000_2);
        assert!(hold.load().scale >= 0.625, "{:?}", hold.load());
        let times = settled(&frames);
        let late = times.iter().filter(|time| **time > 1.1 * TARGET).count();
        assert!(late <= 2 && median(times.clone()) <= TARGET, "{late} late, {times:?}");
        // All of it goes to K where there is room.
        let mut hold = Hold::new(smallest);
        play_fixed(&mut hold, 60, 0.010, 0.006, 0.002);
        assert!(hold.load().scale >= 1.0 && (3..=8).contains(&hold.load().k), "{:?}", hold.load());
    }

    #[test]
    fn a_frame_that_cannot_be_shorter_is_left_at_the_smallest() {
        let mut hold = Hold::new(HoldLimits { least_scale: 0.125, ..limits() });
        let frames = play_fixed(&mut hold, 60, 0.030, 0.5, 0.0);
        assert!(hold.load().scale <= 0.25, "{:?}", hold.load());
        let changes = frames.windows(2).skip(10).filter(|pair| pair[0].0 != pair[1].0).count();
        assert!(changes <= 6, "{changes} changes");
    }

    fn median(mut times: Vec<f64>) -> f64 {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    }

    fn settled(frames: &[(Load, f64)]) -> Vec<f64> {
        frames.iter().skip(10).map(|frame| frame.1).collect()
    }

    #[test]
    fn k_takes_the_time_that_there_is() {
        let mut hold = Hold::new(limits());
        let frames = play(&mut hold, 60, 0.010, 0.003);
        let times = settled(&frames);
        let median = median(times.clone());
        assert!((0.7 * TARGET..=TARGET).contains(&median), "{median}");
        assert!(times.iter().all(|time| *time <= 1.1 * TARGET), "{times:?}");
        let last = hold.load();
        assert_eq!((last.scale, last.samples), (1.0, 1));
        assert!((4..=7).contains(&last.k), "{last:?}");
    }

    #[test]
    fn a_settled_load_stays() {
        let mut hold = Hold::new(limits());
        play(&mut hold, 20, 0.010, 0.003);
        let frames = play(&mut hold, 200, 0.010, 0.003);
        let changes = frames.windows(2).filter(|pair| pair[0].0 != pair[1].0).count();
        assert!(changes <= 4, "{changes} changes");
    }

    #[test]
    fn a_fast_machine_takes_more_samples_of_the_wanted_k() {
        let mut hold = Hold::new(limits());
        let frames = play(&mut hold, 40, 0.000_5, 0.000_1);
        let last = hold.load();
        assert_eq!((last.k, last.scale), (16, 1.0));
        assert!(last.samples >= 8, "{last:?}");
        assert!(median(settled(&frames)) <= TARGET);
    }

    #[test]
    fn a_slow_machine_lowers_resolution_and_no_further_than_allowed() {
        let mut hold = Hold::new(limits());
        let frames = play(&mut hold, 40, 0.6, 0.02);
        assert_eq!(hold.load(), Load { k: 1, samples: 1, scale: 0.25 });
        let hold_fast = play(&mut hold, 40, 0.05, 0.005);
        assert!(hold.load().scale > 0.25 && hold.load().scale < 1.0, "{:?}", hold.load());
        assert!(median(settled(&hold_fast)) <= TARGET && frames.len() == 40);
    }

    #[test]
    fn a_slowdown_costs_one_late_frame() {
        let mut hold = Hold::new(limits());
        play(&mut hold, 40, 0.010, 0.003);
        let frames = play(&mut hold, 40, 0.015, 0.006);
        let late = frames.iter().filter(|frame| frame.1 > 1.1 * TARGET).count();
        assert!(late <= 3, "{late} late");
        assert!(hold.load().k < 5);
    }

    #[test]
    fn growth_is_stepwise() {
        let mut hold = Hold::new(HoldLimits { least_scale: 1.0, ..limits() });
        let frames = play(&mut hold, 20, 0.000_5, 0.000_1);
        let grows = |pair: &[(Load, f64)]| pair[1].1 <= 4.5 * pair[0].1;
        assert!(frames.windows(2).all(grows), "{frames:?}");
    }

    #[test]
    fn limits_hold_from_the_moment_they_are_set() {
        let mut hold = Hold::new(limits());
        play(&mut hold, 40, 0.000_5, 0.000_1);
        hold.set_limits(HoldLimits { most_k: 3, most_samples: 2, ..limits() });
        assert!(hold.load().k <= 3 && hold.load().samples <= 2);
        let frames = play(&mut hold, 10, 0.0, 0.0);
        assert!(frames.iter().all(|(load, _)| load.k <= 3 && load.samples <= 2));
    }
}
