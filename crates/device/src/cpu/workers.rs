//! Sharing a dispatch's workgroups among threads.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// Up to so many workgroups run on the caller's thread: waking others costs more.
const INLINE_GROUPS: u32 = 2;

/// How many portions each thread takes of a dispatch, so that those that drew cheap ones help out.
const PORTIONS_PER_THREAD: u32 = 16;

/// The most workgroups in a portion, so that the end of a long dispatch stays balanced.
const MAX_PORTION: u32 = 256;

/// The caller's thread and those that help it.
pub(super) struct Workers {
    n_threads: u32,
    /// The helpers; none for a single thread.
    pool: Option<ThreadPool>,
}

impl Workers {
    /// `n_threads` in all, at least 1, the caller's included.
    pub(super) fn new(n_threads: usize) -> Result<Self, ThreadPoolBuildError> {
        let helpers = n_threads.saturating_sub(1);
        let pool = (helpers > 0).then(|| {
            ThreadPoolBuilder::new()
                .num_threads(helpers)
                .thread_name(|i| format!("midway-cpu-{}", i + 1))
                .build()
        });
        let n_threads = u32::try_from(helpers + 1).unwrap_or(u32::MAX);
        Ok(Self { n_threads, pool: pool.transpose()? })
    }

    /// How many threads there are, the caller's included.
    pub(super) fn n_threads(&self) -> usize {
        self.n_threads as usize
    }

    /// Calls `work(index)` once on each thread.
    pub(super) fn each(&self, work: &(dyn Fn(usize) + Sync)) {
        let Some(pool) = &self.pool else { return work(0) };
        pool.in_place_scope(|scope| {
            for index in 1..self.n_threads() {
                scope.spawn(move |_| work(index));
            }
            work(0);
        });
    }

    /// Calls `run(first, count)` on portions that together are `0..n_groups`, each once, and
    /// returns when all are done.
    pub(super) fn share(&self, n_groups: u32, run: impl Fn(u32, u32) + Sync) {
        let Some(pool) = self.pool.as_ref().filter(|_| n_groups > INLINE_GROUPS) else {
            if n_groups > 0 {
                run(0, n_groups);
            }
            return;
        };
        let n_portions = self.n_threads.saturating_mul(PORTIONS_PER_THREAD);
        let portion = n_groups.div_ceil(n_portions).clamp(1, MAX_PORTION);
        let n_portions = n_groups.div_ceil(portion);
        let next = AtomicU32::new(0);
        let work = || {
            // The counter passes `n_portions` at most once for each thread, so it cannot wrap.
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                if index >= n_portions {
                    break;
                }
                let first = index * portion;
                run(first, portion.min(n_groups - first));
            }
        };
        let helpers = (self.n_threads - 1).min(n_portions - 1);
        pool.in_place_scope(|scope| {
            for _ in 0..helpers {
                scope.spawn(|_| work());
            }
            work();
        });
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::Workers;

    #[test]
    fn every_workgroup_runs_once() {
        for n_threads in [0, 1, 2, 5] {
            let workers = Workers::new(n_threads).expect("threads");
            for n_groups in [0, 1, 2, 3, 63, 64, 1000, 70_001] {
                let ran: Vec<AtomicU32> = (0..n_groups).map(|_| AtomicU32::new(0)).collect();
                workers.share(n_groups, |first, count| {
                    assert!(count > 0);
                    for group in &ran[first as usize..(first + count) as usize] {
                        group.fetch_add(1, Ordering::Relaxed);
                    }
                });
                assert!(ran.iter().all(|n| n.load(Ordering::Relaxed) == 1), "{n_threads} {n_groups}");
            }
        }
    }
}
