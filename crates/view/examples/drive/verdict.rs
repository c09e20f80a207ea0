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
    /// The server's memory in MiB when it rested, each time in the same state.
    pub at_rest: Vec<f64>,
    /// The most that it ever had.
    pub peak: f64,
}

impl Report {
    /// Means of the first two rests and of the last two.
    fn early_and_late(&self) -> (f64, f64) {
        let mean = |rests: Option<&[f64]>| rests.map_or(f64::NAN, |rests| 0.5 * rests.iter().sum::<f64>());
        (
            mean(self.at_rest.get(..2)),
            mean(self.at_rest.len().checked_sub(2).and_then(|n| self.at_rest.get(n..))),
        )
    }

    /// All of it.
    pub fn json(&self) -> Value {
        let ((early, late), seen) = (self.early_and_late(), &self.seen);
        json!({
            "seconds": self.seconds, "clients": self.clients, "frames": seen.frames, "requests": seen.requests,
            "nonsense": seen.nonsense, "uploads": seen.uploads, "saves": seen.saves, "naps": seen.naps,
            "vanished": seen.vanished, "longest_wait_s": seen.longest_wait, "stalls": seen.stalls,
            "memory_mib_at_rest": self.at_rest, "memory_mib_peak": self.peak, "growth": late / early - 1.0,
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

#[cfg(test)]
mod tests {
    use super::*;

    fn well() -> Report {
        let at_rest = vec![100.0, 104.0, 99.0, 101.0, 103.0, 106.0];
        Report {
            seconds: 60.0,
            clients: 3,
            seen: Seen { frames: 9, ..Seen::default() },
            at_rest,
            peak: 120.0,
        }
    }

    #[test]
    fn a_server_that_takes_it_well_passes() {
        assert!(well().reasons().is_empty(), "{:?}", well().reasons());
        let falling = Report { at_rest: (0..6).map(|i| 200.0 - f64::from(i)).collect(), ..well() };
        assert!(falling.reasons().is_empty());
    }

    #[test]
    fn what_is_not_well_is_told() {
        let with = |seen: Seen| Report { seen: Seen { frames: 9, ..seen }, ..well() };
        let growing = Report { at_rest: (0..6).map(|i| 100.0 + 2.0 * f64::from(i)).collect(), ..well() };
        for (report, told) in [
            (growing, "memory grew"),
            (Report { at_rest: vec![100.0], ..well() }, "memory grew"),
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
