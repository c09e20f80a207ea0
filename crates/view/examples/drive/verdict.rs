//! What a soak has seen, and whether the server took it well.

use serde_json::{Value, json};

/// A wait for a frame that is due is shorter than this, in seconds.
pub const STALL: f64 = 1.0;
/// Memory grows by no more than this share.
const GROWTH: f64 = 0.05;

/// What clients have seen; numbers of all.
#[derive(Debug, Default)]
pub struct Seen {
    pub frames: u64,
    /// Seconds.
    pub longest_wait: f64,
    /// Waits of [`STALL`] or more: with what the server's process had of the processors meanwhile, and the
    /// last requests.
    pub stalls: Vec<Value>,
    /// Requests of all kinds, nonsense included.
    pub requests: u64,
    pub nonsense: u64,
    /// Nonsense that was not refused.
    pub unanswered: u64,
    pub uploads: u64,
    pub saves: u64,
    pub naps: u64,
    pub vanished: u64,
    /// Errors of the server's, or a lost connection.
    pub failures: Vec<String>,
}

impl Seen {
    /// With what another has seen.
    pub fn and(mut self, other: Self) -> Self {
        for (sum, more) in [
            (&mut self.frames, other.frames),
            (&mut self.requests, other.requests),
            (&mut self.nonsense, other.nonsense),
            (&mut self.unanswered, other.unanswered),
            (&mut self.uploads, other.uploads),
            (&mut self.saves, other.saves),
            (&mut self.naps, other.naps),
            (&mut self.vanished, other.vanished),
        ] {
            *sum += more;
        }
        self.longest_wait = self.longest_wait.max(other.longest_wait);
        self.stalls.extend(other.stalls);
        self.failures.extend(other.failures);
        self
    }
}

/// A soak.
#[derive(Debug, Default)]
pub struct Report {
    pub seconds: f64,
    pub clients: u32,
    pub seen: Seen,
    /// The server's, in MiB, at even times.
    pub memory: Vec<f64>,
}

impl Report {
    /// Highest of a sixth early on, and of the last sixth: requests come and go in between.
    fn early_and_late(&self) -> (f64, f64) {
        let sixth = self.memory.len() / 6;
        (peak(&self.memory[sixth..2 * sixth]), peak(&self.memory[self.memory.len() - sixth..]))
    }

    /// All of it.
    pub fn json(&self) -> Value {
        let ((early, late), seen) = (self.early_and_late(), &self.seen);
        json!({
            "seconds": self.seconds, "clients": self.clients, "frames": seen.frames, "requests": seen.requests,
            "nonsense": seen.nonsense, "uploads": seen.uploads, "saves": seen.saves, "naps": seen.naps,
            "vanished": seen.vanished, "longest_wait_s": seen.longest_wait, "stalls": seen.stalls,
            "memory_mib_peaks": self.memory.chunks(5).map(peak).collect::<Vec<_>>(),
            "memory_mib_early": early, "memory_mib_late": late, "growth": late / early - 1.0,
            "reasons": self.reasons(),
        })
    }

    /// What is not as it should be; nothing where all is.
    pub fn reasons(&self) -> Vec<String> {
        let ((early, late), seen) = (self.early_and_late(), &self.seen);
        let mut reasons = seen.failures.clone();
        let holds = late <= early * (1.0 + GROWTH); // where there is no number it does not
        if !holds {
            reasons.push(format!(
                "memory grew from {early:.1} to {late:.1} MiB, by more than {} %",
                100.0 * GROWTH
            ));
        }
        if !seen.stalls.is_empty() {
            let (n, longest) = (seen.stalls.len(), seen.longest_wait);
            reasons.push(format!("{n} waits for a frame of {STALL} s or more, the longest {longest:.2} s"));
        }
        if seen.unanswered > 0 {
            reasons.push(format!("{} bad messages were not refused", seen.unanswered));
        }
        if seen.frames == 0 {
            reasons.push("no frame came".to_owned());
        }
        reasons
    }
}

fn peak(part: &[f64]) -> f64 {
    part.iter().copied().fold(f64::NAN, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn well() -> Report {
        let memory = (0..60).map(|i| 100.0 + f64::from(i % 5)).collect();
        Report { seconds: 60.0, clients: 3, seen: Seen { frames: 9, ..Seen::default() }, memory }
    }

    #[test]
    fn a_server_that_takes_it_well_passes() {
        assert!(well().reasons().is_empty(), "{:?}", well().reasons());
        let falling = Report { memory: (0..60).map(|i| 200.0 - f64::from(i)).collect(), ..well() };
        assert!(falling.reasons().is_empty());
    }

    #[test]
    fn what_is_not_well_is_told() {
        let with = |seen: Seen| Report { seen: Seen { frames: 9, ..seen }, ..well() };
        let growing = Report { memory: (0..60).map(|i| 100.0 + 0.2 * f64::from(i)).collect(), ..well() };
        for (report, told) in [
            (growing, "memory grew"),
            (Report { memory: vec![], ..well() }, "memory grew"),
            (Report { seen: Seen::default(), ..well() }, "no frame"),
            (with(Seen { stalls: vec![json!({})], ..Seen::default() }), "1 waits"),
            (with(Seen { unanswered: 2, ..Seen::default() }), "2 bad messages"),
            (with(Seen { failures: vec!["the server has gone".into()], ..Seen::default() }), "has gone"),
        ] {
            let reasons = report.reasons();
            assert!(reasons.len() == 1 && reasons[0].contains(told), "{told}: {reasons:?}");
        }
    }
}
