//! A GPU, through wgpu on Vulkan, Metal or DX12.

pub(crate) mod adapter;
mod cache;
mod clock;
mod fault;
mod pipeline;
mod run;
mod staging;
mod texels;

use std::{
    collections::HashMap,
    path::Path,
    sync::{Arc, Mutex, OnceLock, PoisonError},
    time::Instant,
};

use wgsl_cpu::Kernel;

use crate::{
    BoundKernel, Buffer, BufferUsage, Command, Device, DeviceError, DeviceInfo, Pipeline, RunTiming,
    check::{self, Check},
    device::run_then_read,
    resource::DeviceId,
};
use adapter::Found;
use cache::PipelineCache;
use clock::Clock;
use fault::{Fault, Faults};
use pipeline::{Bound, Ready};
use run::Stopwatch;
use staging::{STAGING_BYTES, Staging};
use texels::Texels;

/// The most commands in one submission: the GPU works on one while the next is recorded.
const SUBMIT_COMMANDS: usize = 128;

/// Live bindings a DX12 device makes room for, at a cost in memory for each.
const MAX_LIVE_BINDINGS: u32 = 16 << 10;

/// The address of a kernel's record, and its overrides with their values' bits.
type LoadedKey = (usize, Vec<(&'static str, u64)>);

/// A GPU that is open.
pub struct GpuDevice {
    id: DeviceId,
    info: DeviceInfo,
    device: wgpu::Device,
    queue: wgpu::Queue,
    faults: Faults,
    cache: Option<PipelineCache>,
    staging: Mutex<Staging>,
    /// Pipelines by the address of their kernel's record and by their overrides, so that each is
    /// compiled once.
    loaded: Mutex<HashMap<LoadedKey, Pipeline>>,
    /// Made by the first timed run; held while one is under way.
    clock: OnceLock<Mutex<Clock>>,
}

impl GpuDevice {
    /// Opens an adapter with all that it has to give. Compiled pipelines are kept in
    /// `cache_folder`, or in the platform's folder for caches.
    pub(crate) fn open(found: Found, cache_folder: Option<&Path>) -> Result<Self, DeviceError> {
        let Found { info, adapter } = found;
        let wanted = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::PIPELINE_CACHE;
        let limits = adapter.limits();
        let request = wgpu::DeviceDescriptor {
            label: Some("midway"),
            required_features: adapter.features() & wanted,
            required_limits: wgpu::Limits {
                max_non_sampler_bindings: limits.max_non_sampler_bindings.min(MAX_LIVE_BINDINGS),
                ..limits
            },
            ..Default::default()
        };
        let opened = pollster::block_on(adapter.request_device(&request));
        let (device, queue) = opened.map_err(|error| DeviceError::OpenFailed {
            device: info.name.clone(),
            message: error.to_string(),
        })?;
        let faults = Faults::of(&device);
        let cache = faults.guard(&device, || PipelineCache::open(&device, &adapter.get_info(), cache_folder));
        Ok(Self {
            id: DeviceId::unique(),
            info,
            device,
            queue,
            faults,
            // Without one the kernels are compiled at each start.
            cache: cache.ok().flatten(),
            staging: Mutex::default(),
            loaded: Mutex::default(),
            clock: OnceLock::new(),
        })
    }

    fn check(&self) -> Check<'_> {
        Check { id: self.id, info: &self.info }
    }

    /// Makes calls of wgpu; what they report is about `action`.
    fn guard<T>(&self, action: &'static str, calls: impl FnOnce() -> T) -> Result<T, DeviceError> {
        self.faults.guard(&self.device, calls).map_err(|fault| self.error(action, fault))
    }

    fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), DeviceError> {
        self.faults.wait(&self.device, submission).map_err(|fault| self.error("wait", fault))
    }

    fn error(&self, action: &'static str, fault: Fault) -> DeviceError {
        let device = self.info.name.clone();
        match fault {
            Fault::Lost(message) => DeviceError::Lost { device, message },
            Fault::Refused(message) => DeviceError::Refused { device, action, message },
            Fault::OutOfMemory => {
                DeviceError::Refused { device, action, message: "its memory is full".into() }
            }
        }
    }

    fn buffer<'a>(&self, buffer: &'a Buffer) -> Result<&'a wgpu::Buffer, DeviceError> {
        buffer.inner.downcast_ref().ok_or_else(|| self.foreign("buffer", &buffer.label))
    }

    fn texels<'a>(&self, buffer: &'a Buffer) -> Result<&'a Texels, DeviceError> {
        buffer.inner.downcast_ref().ok_or_else(|| self.foreign("texel store", &buffer.label))
    }

    fn ready<'a>(&self, pipeline: &'a Pipeline) -> Result<&'a Ready, DeviceError> {
        pipeline.inner.downcast_ref().ok_or_else(|| self.foreign("pipeline", pipeline.kernel.name))
    }

    fn bound<'a>(&self, bound: &'a BoundKernel) -> Result<&'a Bound, DeviceError> {
        bound.inner.downcast_ref().ok_or_else(|| self.foreign("bound kernel", bound.kernel.name))
    }

    fn foreign(&self, what: &'static str, name: &str) -> DeviceError {
        DeviceError::Foreign { device: self.info.name.clone(), what, name: name.into() }
    }

    fn create_texels(&self, label: &str, bytes: u64) -> Result<Buffer, DeviceError> {
        self.check().size(label, bytes, texels::max_bytes(&self.device.limits()))?;
        let store = self.allocate(label, bytes, || Texels::new(&self.device, label, bytes))?;
        let usage = BufferUsage::Texels;
        Ok(Buffer { label: label.into(), bytes, usage, device: self.id, inner: Arc::new(store) })
    }

    /// Makes something that takes memory.
    fn allocate<T>(&self, label: &str, bytes: u64, make: impl FnOnce() -> T) -> Result<T, DeviceError> {
        self.faults.guard(&self.device, make).map_err(|fault| match fault {
            Fault::OutOfMemory => {
                let device = self.info.name.clone();
                DeviceError::OutOfMemory { device, label: label.into(), bytes }
            }
            fault => self.error("create a buffer", fault),
        })
    }

    /// Hands bytes to the queue.
    fn enqueue(&self, buffer: &Buffer, offset: u64, data: &[u8]) -> Result<(), DeviceError> {
        if buffer.usage == BufferUsage::Texels {
            self.texels(buffer)?.write(&self.queue, offset, data);
        } else {
            self.queue.write_buffer(self.buffer(buffer)?, offset, data);
        }
        Ok(())
    }

    fn read(&self, source: &wgpu::Buffer, range: (u64, u64), out: &mut Vec<u8>) -> Result<(), DeviceError> {
        let mut staging = self.staging.lock().unwrap_or_else(PoisonError::into_inner);
        let context = (&self.device, &self.queue, &self.faults);
        staging.read(context, source, range, out).map_err(|fault| self.error("read a buffer", fault))
    }
}

impl Device for GpuDevice {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn create_buffer(&self, label: &str, bytes: u64, usage: BufferUsage) -> Result<Buffer, DeviceError> {
        use wgpu::BufferUsages as Usages;
        let (limit, uses) = match usage {
            BufferUsage::Storage => (self.info.max_binding_bytes, Usages::STORAGE),
            BufferUsage::Indirect => (self.info.max_binding_bytes, Usages::STORAGE | Usages::INDIRECT),
            BufferUsage::Uniform => (self.device.limits().max_uniform_buffer_binding_size, Usages::UNIFORM),
            BufferUsage::Texels => return self.create_texels(label, bytes),
        };
        self.check().size(label, bytes, limit)?;
        let descriptor = wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes,
            usage: uses | Usages::COPY_SRC | Usages::COPY_DST,
            mapped_at_creation: false,
        };
        let buffer = self.allocate(label, bytes, || self.device.create_buffer(&descriptor))?;
        Ok(Buffer { label: label.into(), bytes, usage, device: self.id, inner: Arc::new(buffer) })
    }

    fn write_buffer(&self, buffer: &Buffer, offset: u64, data: &[u8]) -> Result<(), DeviceError> {
        self.check().write(buffer, offset, data)?;
        let mut at = offset;
        for portion in data.chunks(STAGING_BYTES as usize) {
            let submission = self.guard("write a buffer", || {
                self.enqueue(buffer, at, portion)?;
                // A full portion is sent on its way, so that the next one finds its room free.
                Ok((portion.len() as u64 == STAGING_BYTES).then(|| self.queue.submit([])))
            })??;
            if let Some(submission) = submission {
                self.wait(submission)?;
            }
            at += portion.len() as u64;
        }
        Ok(())
    }

    fn read_buffer(&self, buffer: &Buffer, offset: u64, bytes: u64) -> Result<Vec<u8>, DeviceError> {
        self.check().range(buffer, offset, bytes)?;
        self.check().plain(buffer)?;
        let mut out = check::host_memory(&buffer.label, bytes)?;
        self.read(self.buffer(buffer)?, (offset, bytes), &mut out)?;
        Ok(out)
    }

    fn load_specialised(
        &self,
        kernel: &'static Kernel,
        overrides: &[(&'static str, f64)],
    ) -> Result<Pipeline, DeviceError> {
        self.check().kernel(kernel)?;
        let bits = overrides.iter().map(|&(name, value)| (name, value.to_bits())).collect();
        let key = (std::ptr::from_ref(kernel).addr(), bits);
        let loaded = || self.loaded.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pipeline) = loaded().get(&key) {
            return Ok(pipeline.clone());
        }
        // Compiled without the lock: several threads may load kernels at once.
        let ready = Ready::new(self, kernel, overrides)?;
        let workgroup_size = ready.workgroup_size;
        let pipeline = Pipeline { kernel, workgroup_size, device: self.id, inner: Arc::new(ready) };
        loaded().insert(key, pipeline.clone());
        Ok(pipeline)
    }

    fn bind(&self, pipeline: &Pipeline, buffers: &[&Buffer]) -> Result<BoundKernel, DeviceError> {
        self.check().bindings(pipeline, buffers)?;
        let bound = Bound::new(self, pipeline, buffers)?;
        let buffers = buffers.iter().map(|&buffer| buffer.clone()).collect();
        let Pipeline { kernel, workgroup_size, .. } = *pipeline;
        Ok(BoundKernel { kernel, workgroup_size, buffers, device: self.id, inner: Arc::new(bound) })
    }

    fn run(&self, commands: &[Command], timed: bool) -> Result<RunTiming, DeviceError> {
        commands.iter().try_for_each(|command| self.check().command(command))?;
        if timed && self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return self.run_timed(commands);
        }
        let start = Instant::now();
        let mut stopwatch = Stopwatch::default();
        for part in self.submit(commands)? {
            self.wait(part.submission)?;
            stopwatch.ended(part.submitted);
        }
        Ok(RunTiming { wall: start.elapsed(), longest_part: stopwatch.longest, dispatches: Vec::new() })
    }

    fn run_and_read(
        &self,
        commands: &[Command],
        timed: bool,
        buffer: &Buffer,
        (offset, bytes): (u64, u64),
    ) -> Result<(RunTiming, Vec<u8>), DeviceError> {
        if timed {
            return run_then_read(self, commands, timed, buffer, (offset, bytes));
        }
        commands.iter().try_for_each(|command| self.check().command(command))?;
        let start = Instant::now();
        let mut stopwatch = Stopwatch::default();
        let mut parts = self.submit(commands)?;
        let last = parts.pop();
        for part in parts {
            self.wait(part.submission)?;
            stopwatch.ended(part.submitted);
        }
        // Waits for the last part too.
        let read = self.read_buffer(buffer, offset, bytes)?;
        if let Some(last) = last {
            stopwatch.ended(last.submitted);
        }
        let longest_part = stopwatch.longest;
        Ok((RunTiming { wall: start.elapsed(), longest_part, dispatches: Vec::new() }, read))
    }
}

#[cfg(test)]
mod tests {
    use super::{GpuDevice, adapter};
    use crate::{BufferUsage, Command, Device, DeviceError};

    #[test]
    fn a_lost_device_is_an_error_and_no_panic() {
        let Some(found) = adapter::enumerate().into_iter().next() else {
            println!("did not run: no adapter");
            return;
        };
        let folder = tempfile::tempdir().expect("a temporary folder");
        let gpu = GpuDevice::open(found, Some(folder.path())).expect("a listed device opens");
        let buffer = gpu.create_buffer("data", 64, BufferUsage::Storage).expect("created");
        gpu.device.destroy();
        for timed in [true, true, false] {
            let error = gpu.run(&[Command::Clear(buffer.clone())], timed).expect_err("lost");
            assert!(matches!(error, DeviceError::Lost { .. }), "{error}");
            let write = Command::Write { to: buffer.clone(), offset: 0, data: [1; 4].into() };
            let error = gpu.run_and_read(&[write], timed, &buffer, (0, 4)).expect_err("lost");
            assert!(matches!(error, DeviceError::Lost { .. }), "{error}");
        }
        let error = gpu.read_buffer(&buffer, 0, 4).expect_err("lost");
        assert!(matches!(error, DeviceError::Lost { .. }), "{error}");
        let error = gpu.create_buffer("more", 64, BufferUsage::Storage).expect_err("lost");
        assert!(matches!(error, DeviceError::Lost { .. }), "{error}");
    }
}
