//! Times of dispatches, from the device's own timestamps.

use std::time::Duration;

use super::SUBMIT_COMMANDS;

/// A timestamp at the start and one at the end of each dispatch.
const QUERIES: u32 = 2 * SUBMIT_COMMANDS as u32;

/// Room for the timestamps of one submission.
pub(super) struct Clock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Nanoseconds a tick.
    period: f64,
}

impl Clock {
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let queries = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("dispatch times"),
            ty: wgpu::QueryType::Timestamp,
            count: QUERIES,
        });
        let resolved = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("dispatch times"),
            size: u64::from(QUERIES) * 8,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Self { queries, resolved, period: f64::from(queue.get_timestamp_period()) }
    }

    /// What the pass of a submission's dispatch number `index` writes.
    pub(super) fn writes(&self, index: u32) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * index),
            end_of_pass_write_index: Some(2 * index + 1),
        }
    }

    /// Gathers the timestamps of `n_dispatches` at the end of a submission; returns where.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder, n_dispatches: u32) -> &wgpu::Buffer {
        encoder.resolve_query_set(&self.queries, 0..2 * n_dispatches, &self.resolved, 0);
        &self.resolved
    }

    /// The durations that resolved timestamps, as read back, mean. A device whose counter went back
    /// in between took no time.
    pub(super) fn durations(&self, ticks: &[u8]) -> Vec<Duration> {
        let tick = |bytes: &[u8]| bytes.iter().rev().fold(0, |ticks, &byte| ticks << 8 | u64::from(byte));
        let pairs = ticks.chunks_exact(16).map(|pair| tick(&pair[8..]).saturating_sub(tick(&pair[..8])));
        pairs.map(|ticks| Duration::from_nanos((ticks as f64 * self.period) as u64)).collect()
    }
}
