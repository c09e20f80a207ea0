//! Buffers by the names that kernels know them by.

use std::collections::HashMap;

use midway_device::{BoundKernel, Buffer, Command, Device, DeviceError, Pipeline};
use midway_kernels::kernel;

use crate::RenderError;

/// Compiled kernels, each loaded once.
#[derive(Clone)]
pub struct Pipelines(HashMap<&'static str, Pipeline>);

impl Pipelines {
    /// Loads the named kernels.
    pub fn load(device: &dyn Device, names: &[&'static str]) -> Result<Self, DeviceError> {
        names
            .iter()
            .map(|&name| Ok((name, device.load_kernel(kernel(name))?)))
            .collect::<Result<_, _>>()
            .map(Self)
    }

    /// Loads one more, unless it is there.
    pub fn add(&mut self, device: &dyn Device, name: &'static str) -> Result<(), DeviceError> {
        if !self.0.contains_key(name) {
            self.0.insert(name, device.load_kernel(kernel(name))?);
        }
        Ok(())
    }
}

/// Buffers that a kernel's bindings are looked up in.
#[derive(Clone, Default)]
pub struct BufferSet(HashMap<&'static str, Buffer>);

impl BufferSet {
    /// Adds or replaces a buffer.
    pub fn insert(&mut self, name: &'static str, buffer: Buffer) {
        self.0.insert(name, buffer);
    }

    /// The named buffer, which the caller inserted before.
    pub fn get(&self, name: &str) -> &Buffer {
        &self.0[name]
    }

    /// A kernel of `pipelines` with this set's buffers.
    pub fn bind(
        &self,
        device: &dyn Device,
        pipelines: &Pipelines,
        name: &str,
    ) -> Result<BoundKernel, RenderError> {
        let pipeline = &pipelines.0[name];
        let buffers: Vec<&Buffer> = pipeline.kernel().bindings.iter().map(|b| self.get(b.name)).collect();
        Ok(device.bind(pipeline, &buffers)?)
    }
}

/// Invocations of a workgroup, in every kernel.
const WORKGROUP: u32 = midway_kernels::constants::WORKGROUP;
/// Workgroups in a row of a two-dimensional grid, as the kernels count them.
const ROW: u32 = midway_kernels::constants::GRID_ROW / WORKGROUP;

/// A dispatch over `n` invocations.
pub fn dispatch(bound: &BoundKernel, n: u32) -> Command {
    let groups = n.div_ceil(WORKGROUP).max(1);
    Command::Dispatch { bound: bound.clone(), groups: [groups.min(ROW), groups.div_ceil(ROW), 1] }
}

/// A dispatch whose grid plan kernels wrote at `word` of `args`.
pub fn dispatch_indirect(bound: &BoundKernel, args: &Buffer, word: u32) -> Command {
    Command::DispatchIndirect { bound: bound.clone(), args: args.clone(), offset: u64::from(word) * 4 }
}
