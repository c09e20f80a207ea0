//! A pool of light paths shared by all lanes: its buffers and the table by (path, depth).

use midway_device::{BoundKernel, Buffer, BufferUsage, Device, MemoryPlan};
use midway_kernels::{constants as k, layout::Params};

use crate::{
    RenderError,
    buffers::{BufferSet, Pipelines, dispatch},
};

/// The kernels of a pool.
pub const POOL_KERNELS: [&str; 3] = ["scan_blocks", "scan_sums", "index_pool"];

/// How large a pool is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PoolSize {
    /// Paths in it.
    pub n_paths: u32,
    /// Slots of vertices, over all lanes.
    pub n_vertices: u32,
}

impl PoolSize {
    fn vertex_bytes(&self) -> u64 {
        u64::from(self.n_vertices) * u64::from(k::VERTEX_STRIDE) * 16
    }

    fn path_words(&self) -> u64 {
        let blocks = u64::from(self.n_paths.div_ceil(k::SCAN_BLOCK));
        u64::from(self.n_paths) * 2 + blocks + 1 + u64::from(self.n_vertices)
    }

    /// Adds the pool to a plan.
    pub fn plan(&self, plan: &mut MemoryPlan) {
        plan.fixed("pool of light vertices", self.vertex_bytes());
        plan.fixed("pool of light paths", self.path_words() * 4);
    }
}

/// A pool's buffers and the kernels that index it.
pub struct Pool {
    params: Buffer,
    scan_blocks: BoundKernel,
    scan_sums: BoundKernel,
    index_pool: BoundKernel,
}

impl Pool {
    /// Allocates a pool and adds its buffers to `shared`.
    pub fn new(
        device: &dyn Device,
        pipelines: &Pipelines,
        shared: &mut BufferSet,
        size: PoolSize,
    ) -> Result<Self, RenderError> {
        let vertices = device.create_buffer("light_vertices", size.vertex_bytes(), BufferUsage::Storage)?;
        let paths = device.create_buffer("light_paths", size.path_words() * 4, BufferUsage::Storage)?;
        let params = device.create_buffer("params", size_of::<Params>() as u64, BufferUsage::Uniform)?;
        shared.insert("light_vertices", vertices);
        shared.insert("light_paths", paths);
        let mut set = shared.clone();
        set.insert("params", params.clone());
        Ok(Self {
            params,
            scan_blocks: set.bind(device, pipelines, "scan_blocks")?,
            scan_sums: set.bind(device, pipelines, "scan_sums")?,
            index_pool: set.bind(device, pipelines, "index_pool")?,
        })
    }

    /// Makes the table of vertices, once every light path of the pass is traced.
    pub fn index(&self, device: &dyn Device, params: &Params) -> Result<(), RenderError> {
        device.write_buffer(&self.params, 0, bytemuck::bytes_of(params))?;
        let blocks = params.n_light_paths.div_ceil(k::SCAN_BLOCK);
        let commands = [
            dispatch(&self.scan_blocks, blocks),
            dispatch(&self.scan_sums, 1),
            dispatch(&self.index_pool, blocks),
        ];
        device.run(&commands, false)?;
        Ok(())
    }
}
