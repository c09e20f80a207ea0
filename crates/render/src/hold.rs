//! Holds a target time for each frame, by what a frame is made of: K, samples, resolution.
//!
//! Pure logic: a caller times each frame and renders the next one with what [`Hold::load`] says. The
//! time of a frame of *n* full-size samples, each with K joins a vertex, is taken to be n (a + b K);
//! a and b are fitted to the frames seen, recent ones most, each by its relative error. What the
//! controller chooses depends on times alone, so that every frame is as unbiased as its K is.

use std::time::Duration;

/// Of older frames' weight this much is left after a frame.
const MEMORY: f64 = 0.8;
/// A frame that is off its prediction by more than this factor says that another scene or another view
/// has begun: what came before is as good as forgotten.
const SURPRISE: f64 = 1.3;
/// How firmly the last fit is believed where the frames seen do not tell a from b.
const TRUST: f64 = 0.05;
/// Before any frame, K joins are taken to cost this share of a sample each.
const FIRST_JOIN_COST: f64 = 0.25;
/// A frame is planned to take this share of the target, so that few frames miss it.
const AIM: f64 = 0.9;
/// A load is kept while it is predicted to take between these shares of the target.
const KEEP: std::ops::RangeInclusive<f64> = 0.7..=1.0;
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

/// The controller.
#[derive(Clone, Debug)]
pub struct Hold {
    limits: HoldLimits,
    load: Load,
    /// Seconds of a sample without joins, and of one join a vertex of it.
    cost: [f64; 2],
    /// Normal equations of the fit: xx, xy, yy; and the right side.
    squares: [f64; 3],
    products: [f64; 2],
    seen: bool,
}

impl Hold {
    /// Starts with the smallest load: the first frame is never late by much.
    pub fn new(limits: HoldLimits) -> Self {
        let load = Load { k: limits.least_k, samples: 1, scale: limits.least_scale };
        Self { limits, load, cost: [0.0; 2], squares: [0.0; 3], products: [0.0; 2], seen: false }
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
        if self.seen {
            self.choose();
        }
    }

    /// How long a frame of `load` is expected to last, in seconds; 0 before the first observation.
    pub fn predict(&self, load: Load) -> f64 {
        load.size() * (self.cost[0] + self.cost[1] * f64::from(load.k))
    }

    /// Learns how long a frame of `load` took (it may be another than [`Hold::load`] asked for), and
    /// chooses the next.
    pub fn observe(&mut self, load: Load, time: Duration) {
        let seconds = time.as_secs_f64().max(1e-9);
        let x = [load.size(), load.size() * f64::from(load.k)];
        if !self.seen {
            let sample = seconds / (x[0] + FIRST_JOIN_COST * x[1]);
            self.cost = [sample, FIRST_JOIN_COST * sample];
            self.seen = true;
        }
        let off = seconds / self.predict(load);
        if !(1.0 / SURPRISE..=SURPRISE).contains(&off) {
            self.cost = self.cost.map(|cost| cost * off);
            self.squares = [0.0; 3];
            self.products = [0.0; 2];
        }
        // Each frame counts by its relative error: rows are divided by the time.
        let row = x.map(|value| value / seconds);
        for (sum, new) in self.squares.iter_mut().zip([row[0] * row[0], row[0] * row[1], row[1] * row[1]]) {
            *sum = MEMORY * *sum + new;
        }
        for (sum, new) in self.products.iter_mut().zip(row) {
            *sum = MEMORY * *sum + new;
        }
        self.fit();
        self.choose();
    }

    /// Least squares with the last fit as a prior, each unknown scaled by its own diagonal; costs are
    /// not negative.
    fn fit(&mut self) {
        let [xx, xy, yy] = self.squares;
        let (px, py) = (TRUST * xx, TRUST * yy);
        let (a, c) = (xx + px, yy + py); // > 0: a frame was seen
        let (u, v) = (self.products[0] + px * self.cost[0], self.products[1] + py * self.cost[1]);
        let determinant = a * c - xy * xy; // > 0, by Cauchy and Schwarz
        let fitted = [(u * c - v * xy) / determinant, (v * a - u * xy) / determinant];
        self.cost = match fitted {
            [sample, join] if sample < 0.0 => [0.0, (self.products[1] / yy).max(join.min(0.0))],
            [_, join] if join < 0.0 => [self.products[0] / xx, 0.0],
            both => both,
        };
    }

    fn choose(&mut self) {
        let limits = self.limits;
        let target = limits.target.as_secs_f64();
        let ideal = self.ideal(target * AIM, self.limits.most_k);
        if KEEP.contains(&(self.predict(self.load) / target)) && self.no_better(ideal) {
            return;
        }
        // Slower at once, faster in steps: a wrong fit then costs one frame a little.
        let most = (self.predict(self.load) * GROWTH).min(target * AIM);
        let most_k = self.limits.most_k.min(self.load.k.saturating_mul(K_GROWTH));
        self.load = self.ideal(most.max(f64::MIN_POSITIVE), most_k);
    }

    /// Whether a load within the kept range is left alone: it is, unless the other has the K that is
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
        let [sample, join] = self.cost;
        let smallest = sample + join * f64::from(least_k);
        if smallest > budget {
            let scale = (budget / smallest).sqrt() as f32;
            let scale = ((scale * SCALE_STEPS).floor() / SCALE_STEPS).clamp(least_scale, 1.0);
            return Load { k: least_k, samples: 1, scale };
        }
        let k = if join > 0.0 { ((budget - sample) / join) as u32 } else { most_k };
        let k = k.clamp(least_k, most_k);
        let fitting = budget / (sample + join * f64::from(k)).max(f64::MIN_POSITIVE);
        let samples = if k == most_k { fitting as u32 } else { 1 };
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
        (0..n)
            .map(|i| {
                let load = hold.load();
                let noise = 1.0 + 0.05 * ((i as f64 * 12.9898).sin() * 43_758.547).fract();
                let seconds = load.size() * (a + b * f64::from(load.k)) * noise;
                hold.observe(load, Duration::from_secs_f64(seconds));
                (load, seconds)
            })
            .collect()
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
        let frames = play(&mut hold, 40, 0.2, 0.02);
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
