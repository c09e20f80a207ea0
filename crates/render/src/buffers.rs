//! Buffers by the names that kernels know them by.

use std::{
    collections::{BTreeSet, HashMap},
    thread,
};

use midway_device::{BoundKernel, Buffer, Command, Device, DeviceError, Pipeline};
use midway_kernels::kernel;

use crate::RenderError;

/// Compiles kernels, all at once; others are compiled when they are bound.
pub fn load_all(
    device: &dyn Device,
    wanted: &BTreeSet<(Pipelines, &'static str)>,
) -> Result<(), DeviceError> {
    thread::scope(|scope| {
        let load =
            |(pipelines, name): (Pipelines, &'static str)| scope.spawn(move || pipelines.load(device, name));
        let started: Vec<_> = wanted.iter().copied().map(load).collect();
        started.into_iter().try_for_each(|thread| match thread.join() {
            Ok(loaded) => loaded.map(|_| ()),
            Err(panic) => std::panic::resume_unwind(panic),
        })
    })
}

/// Kernels as a scene needs them (`FEATURE_*`); a device compiles each of them once.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Pipelines {
    features: u32,
}

impl Pipelines {
    /// Those of a scene with these features.
    pub fn new(features: u32) -> Self {
        Self { features }
    }

    /// A kernel, compiled.
    pub fn load(self, device: &dyn Device, name: &str) -> Result<Pipeline, DeviceError> {
        let kernel = kernel(name);
        let mut overrides =
            vec![("FEATURES", self.features), ("SHADE_WORKGROUP", device.info().wide_workgroup)];
        overrides.retain(|(name, _)| kernel.wgsl.contains(&format!("override {name}:")));
        let overrides: Vec<_> = overrides.into_iter().map(|(name, value)| (name, f64::from(value))).collect();
        device.load_specialised(kernel, &overrides)
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
        let pipeline = &pipelines.load(device, name)?;
        let buffers: Vec<&Buffer> = pipeline.kernel().bindings.iter().map(|b| self.get(b.name)).collect();
        Ok(device.bind(pipeline, &buffers)?)
    }
}

/// A dispatch over `n` invocations, in rows as the kernels count them.
pub fn dispatch(bound: &BoundKernel, n: u32) -> Command {
    let groups = n.div_ceil(bound.workgroup_size()).max(1);
    let row = midway_kernels::constants::GRID_ROW / bound.workgroup_size();
    Command::Dispatch { bound: bound.clone(), groups: [groups.min(row), groups.div_ceil(row), 1] }
}

/// A dispatch whose grid plan kernels wrote at `word` of `args`.
pub fn dispatch_indirect(bound: &BoundKernel, args: &Buffer, word: u32) -> Command {
    Command::DispatchIndirect { bound: bound.clone(), args: args.clone(), offset: u64::from(word) * 4 }
}
