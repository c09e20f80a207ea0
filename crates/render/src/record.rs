//! The rays that a render traces, read back bounce by bounce: for measuring.

use midway_device::{Buffer, Device};
use midway_kernels::constants as k;

use crate::RenderError;

/// What one bounce of a batch traces. A ray is two vec4: origin and t_max; direction.
#[derive(Clone, Debug, Default)]
pub struct BounceRays {
    /// Of the paths under way, in the order of their queue.
    pub closest: Vec<[f32; 4]>,
    /// Towards lights and light vertices, in the order in which they were pushed.
    pub shadow: Vec<[f32; 4]>,
}

/// The buffers of a lane that rays are in.
pub struct Recorder {
    /// State of the paths.
    pub paths: Buffer,
    /// Which are under way.
    pub queues: Buffer,
    /// Rays that wait for visibility.
    pub shadow_rays: Buffer,
    /// How many of each.
    pub counters: Buffer,
}

impl Recorder {
    /// The rays of the queued paths that are about to be traced. `n_paths`: of the batch.
    pub fn queued(&self, device: &dyn Device, n_paths: u32) -> Result<Vec<[f32; 4]>, RenderError> {
        let counters: Vec<u32> = words(device, &self.counters, 0, u64::from(k::N_COUNTERS) * 4)?;
        let [n, front, parity] =
            [k::COUNT_IN, k::COUNT_FRONT, k::COUNT_PARITY].map(|count| counters[count as usize]);
        let half = u64::from(n_paths) * 4;
        let queue: Vec<u32> = words(device, &self.queues, u64::from(parity) * half, half)?;
        // Those that have just started lie at the end, the first of them last.
        let (going, rest) = queue.split_at(front as usize);
        let queued = going.iter().chain(rest.iter().rev().take((n - front) as usize));
        let stride = k::PATH_STRIDE as usize;
        let paths: Vec<[f32; 4]> =
            words(device, &self.paths, 0, u64::from(n_paths) * u64::from(k::PATH_STRIDE) * 16)?;
        let state = queued.map(|&id| &paths[id as usize * stride..][..stride]);
        // Paths with joins still to make stay where they are.
        let moves = state.filter(|path| path[1][3].to_bits() >> 16 == 0);
        Ok(moves.flat_map(|path| pair(path[0], path[1], f32::MAX)).collect())
    }

    /// The shadow rays that were traced last.
    pub fn shadow(&self, device: &dyn Device) -> Result<Vec<[f32; 4]>, RenderError> {
        let n: Vec<u32> = words(device, &self.counters, u64::from(k::COUNT_SHADOW_TRACE) * 4, 4)?;
        let stride = k::SHADOW_STRIDE as usize;
        let rays: Vec<[f32; 4]> =
            words(device, &self.shadow_rays, 0, u64::from(n[0]) * u64::from(k::SHADOW_STRIDE) * 16)?;
        Ok(rays.chunks_exact(stride).flat_map(|ray| pair(ray[0], ray[1], k::SEGMENT_END)).collect())
    }
}

fn pair([x, y, z, _]: [f32; 4], [dx, dy, dz, _]: [f32; 4], t_max: f32) -> [[f32; 4]; 2] {
    [[x, y, z, t_max], [dx, dy, dz, 0.0]]
}

fn words<T: bytemuck::AnyBitPattern + bytemuck::NoUninit>(
    device: &dyn Device,
    buffer: &Buffer,
    offset: u64,
    bytes: u64,
) -> Result<Vec<T>, RenderError> {
    if bytes == 0 {
        return Ok(Vec::new());
    }
    Ok(bytemuck::pod_collect_to_vec(&device.read_buffer(buffer, offset, bytes)?))
}
