//! This machine's cores: translated kernels on a pool of threads.

mod memory;
mod workers;

use std::{
    cell::Cell,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    thread::available_parallelism,
    time::Instant,
};

use sysinfo::{MemoryRefreshKind, RefreshKind, System};
use wgsl_cpu::{Invocations, Kernel, Storage};

use crate::{
    BoundKernel, Buffer, BufferUsage, Command, Device, DeviceError, DeviceInfo, DeviceKind, Pipeline,
    RunTiming,
    check::{self, Check},
    device::copy_to_buffer,
    resource::{DeviceId, Inner},
};
use memory::{Budget, Memory};
use workers::Workers;

thread_local! {
    /// The device one of whose lanes this thread is.
    static LANE_OF: Cell<Option<DeviceId>> = const { Cell::new(None) };
}

/// Marks this thread as a lane until it is dropped.
struct InLane(Option<DeviceId>);

impl InLane {
    fn of(device: DeviceId) -> Self {
        Self(LANE_OF.replace(Some(device)))
    }
}

impl Drop for InLane {
    fn drop(&mut self) {
        LANE_OF.set(self.0);
    }
}

/// The right to access buffers: of the whole device, or of a lane while the device is split.
struct Access<'a>(#[allow(dead_code, reason = "held, not read")] Option<MutexGuard<'a, ()>>);

/// The name `--device` takes.
const NAME: &str = "cpu";

/// The device that every machine has.
pub struct CpuDevice {
    id: DeviceId,
    info: DeviceInfo,
    budget: Arc<Budget>,
    workers: Workers,
    /// Held while any buffer is read or written, so that no two calls touch the same words.
    access: Mutex<()>,
}

impl CpuDevice {
    /// Starts `threads` threads, or one for each core.
    ///
    /// # Errors
    /// [`DeviceError::OpenFailed`] if the system refuses to start them.
    pub fn new(threads: Option<usize>) -> Result<Self, DeviceError> {
        let info = Self::describe(threads);
        let workers = Workers::new(n_threads(threads))
            .map_err(|error| DeviceError::OpenFailed { device: NAME.into(), message: error.to_string() })?;
        let budget = Budget::new(info.max_buffer_bytes);
        Ok(Self { id: DeviceId::unique(), info, budget, workers, access: Mutex::new(()) })
    }

    /// What [`CpuDevice::new`] would open, without starting threads.
    pub(crate) fn describe(threads: Option<usize>) -> DeviceInfo {
        let memory = total_memory();
        let addressable = (isize::MAX as u64) & !3;
        let max_bytes = memory.unwrap_or(addressable).min(addressable);
        let threads = n_threads(threads);
        DeviceInfo {
            name: NAME.into(),
            kind: DeviceKind::Cpu,
            backend: format!("native, {threads} thread{}", if threads == 1 { "" } else { "s" }),
            memory_bytes: memory,
            max_buffer_bytes: max_bytes,
            max_binding_bytes: max_bytes,
            max_storage_buffers: u32::MAX,
            wide_workgroup: 64,
        }
    }

    fn check(&self) -> Check<'_> {
        Check { id: self.id, info: &self.info }
    }

    /// Excludes all other accesses to this device's buffers. A kernel that panicked has left them
    /// in a state that is arbitrary but valid. On a lane `for_each_lane` holds the lock.
    fn access(&self) -> Access<'_> {
        let lock = || self.access.lock().unwrap_or_else(PoisonError::into_inner);
        Access((!self.on_lane()).then(lock))
    }

    fn on_lane(&self) -> bool {
        LANE_OF.get() == Some(self.id)
    }

    fn memory<'a>(&self, buffer: &'a Buffer) -> Result<&'a Memory, DeviceError> {
        buffer.inner.downcast_ref().ok_or_else(|| DeviceError::Foreign {
            device: self.info.name.clone(),
            what: "buffer",
            name: buffer.label.to_string(),
        })
    }

    /// Runs one command that passed its check, while `access` is held.
    fn execute(&self, command: &Command, access: &Access<'_>) -> Result<(), DeviceError> {
        match command {
            Command::Dispatch { bound, groups } => self.dispatch(bound, *groups),
            Command::DispatchIndirect { bound, args, offset } => {
                let mut groups = [0; 3];
                let words = &self.memory(args)?.words()[(*offset / 4) as usize..];
                for (axis, word) in groups.iter_mut().zip(words) {
                    // SAFETY: no other access is under way while `access` is held.
                    *axis = unsafe { *word.get() };
                }
                check::grid(bound.kernel, groups)?;
                self.dispatch(bound, groups)
            }
            Command::Clear(buffer) => {
                let memory = self.memory(buffer)?;
                // SAFETY: the whole of one buffer, accessed by nothing else while `access` is held.
                unsafe { memory.as_mut_ptr().write_bytes(0, memory.len()) };
                Ok(())
            }
            Command::Copy { from, from_offset, to, to_offset, bytes } => {
                let (source, target) = (self.memory(from)?, self.memory(to)?);
                // SAFETY: the check found both ranges inside their buffers and the buffers
                // distinct; nothing else accesses them while `access` is held.
                unsafe {
                    let source = source.as_mut_ptr().add(*from_offset as usize);
                    let target = target.as_mut_ptr().add(*to_offset as usize);
                    target.copy_from_nonoverlapping(source, *bytes as usize);
                }
                Ok(())
            }
            Command::Write { to, offset, data } => self.put(to, *offset, data, access),
        }
    }

    /// Writes to a range that passed its check, while `access` is held.
    fn put(
        &self,
        buffer: &Buffer,
        offset: u64,
        data: &[u8],
        _access: &Access<'_>,
    ) -> Result<(), DeviceError> {
        let memory = self.memory(buffer)?;
        // SAFETY: the range is inside the buffer and nothing else accesses it while `access` is held.
        unsafe {
            memory.as_mut_ptr().add(offset as usize).copy_from_nonoverlapping(data.as_ptr(), data.len());
        }
        Ok(())
    }

    fn dispatch(&self, bound: &BoundKernel, grid: [u32; 3]) -> Result<(), DeviceError> {
        let bindings = bound
            .buffers
            .iter()
            .map(|buffer| Ok(Storage::new(self.memory(buffer)?.words())))
            .collect::<Result<Vec<_>, DeviceError>>()?;
        let native = bound.kernel.native;
        // The grid's check made sure that the product fits.
        let n_groups = grid.iter().product();
        let run = |first, count| {
            // SAFETY: `bind` found each buffer at least as long as its binding asks for and no
            // written one bound twice; `access` is held, so that only this dispatch touches them,
            // or other lanes' as the contract of `for_each_lane` allows.
            unsafe { native(&bindings, Invocations { first, count, grid }) }
        };
        if !self.on_lane() {
            self.workers.share(n_groups, run);
        } else if n_groups > 0 {
            run(0, n_groups);
        }
        Ok(())
    }
}

impl Device for CpuDevice {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn create_buffer(&self, label: &str, bytes: u64, usage: BufferUsage) -> Result<Buffer, DeviceError> {
        self.check().size(label, bytes, self.budget.limit)?;
        let memory = Memory::zeroed(bytes, &self.budget).ok_or_else(|| DeviceError::OutOfMemory {
            device: self.info.name.clone(),
            label: label.into(),
            bytes,
        })?;
        Ok(Buffer { label: label.into(), bytes, usage, device: self.id, inner: Arc::new(memory) })
    }

    fn create_buffer_of(
        &self,
        label: &str,
        words: Vec<[u32; 4]>,
        usage: BufferUsage,
    ) -> Result<Buffer, DeviceError> {
        let bytes = size_of_val(words.as_slice()) as u64;
        self.check().size(label, bytes, self.budget.limit)?;
        let memory = match Memory::of(words, &self.budget) {
            Ok(memory) => memory,
            Err(words) => return copy_to_buffer(self, label, &words, usage),
        };
        Ok(Buffer { label: label.into(), bytes, usage, device: self.id, inner: Arc::new(memory) })
    }

    fn write_buffer(&self, buffer: &Buffer, offset: u64, data: &[u8]) -> Result<(), DeviceError> {
        self.check().write(buffer, offset, data)?;
        self.put(buffer, offset, data, &self.access())
    }

    fn read_buffer(&self, buffer: &Buffer, offset: u64, bytes: u64) -> Result<Vec<u8>, DeviceError> {
        self.check().range(buffer, offset, bytes)?;
        self.check().plain(buffer)?;
        let memory = self.memory(buffer)?;
        let mut out = check::host_memory(&buffer.label, bytes)?;
        let _access = self.access();
        // SAFETY: the range is inside the buffer and nothing writes it meanwhile.
        out.extend_from_slice(unsafe {
            std::slice::from_raw_parts(memory.as_mut_ptr().add(offset as usize), bytes as usize)
        });
        Ok(out)
    }

    fn load_specialised(
        &self,
        kernel: &'static Kernel,
        _overrides: &[(&'static str, f64)],
    ) -> Result<Pipeline, DeviceError> {
        self.check().kernel(kernel)?;
        Ok(Pipeline { kernel, workgroup_size: kernel.workgroup_size, device: self.id, inner: nothing() })
    }

    fn bind(&self, pipeline: &Pipeline, buffers: &[&Buffer]) -> Result<BoundKernel, DeviceError> {
        self.check().bindings(pipeline, buffers)?;
        let buffers = buffers.iter().map(|&buffer| buffer.clone()).collect();
        let Pipeline { kernel, workgroup_size, .. } = *pipeline;
        Ok(BoundKernel { kernel, workgroup_size, buffers, device: self.id, inner: nothing() })
    }

    fn lanes(&self) -> usize {
        self.workers.n_threads()
    }

    unsafe fn for_each_lane(&self, work: &(dyn Fn(usize) + Sync)) {
        let _access = self.access();
        self.workers.each(&|lane| {
            let _lane = InLane::of(self.id);
            work(lane);
        });
    }

    fn run(&self, commands: &[Command], timed: bool) -> Result<RunTiming, DeviceError> {
        commands.iter().try_for_each(|command| self.check().command(command))?;
        let access = self.access();
        let start = Instant::now();
        let mut dispatches = Vec::new();
        for command in commands {
            let command_start = Instant::now();
            self.execute(command, &access)?;
            if let (true, Command::Dispatch { bound, .. } | Command::DispatchIndirect { bound, .. }) =
                (timed, command)
            {
                dispatches.push((bound.kernel.name, command_start.elapsed()));
            }
        }
        let wall = start.elapsed();
        Ok(RunTiming { wall, longest_part: wall, dispatches })
    }
}

/// The device's own part of a pipeline: the kernel's record says it all.
fn nothing() -> Inner {
    Arc::new(())
}

fn n_threads(asked: Option<usize>) -> usize {
    asked.unwrap_or_else(|| available_parallelism().map_or(1, |n| n.get())).max(1)
}

/// The memory of this machine, or of the container that the process is confined to.
fn total_memory() -> Option<u64> {
    let memory = RefreshKind::nothing().with_memory(MemoryRefreshKind::nothing().with_ram());
    let system = System::new_with_specifics(memory);
    let confined = system.cgroup_limits().map_or(u64::MAX, |limits| limits.total_memory);
    let total = system.total_memory().min(confined) & !3;
    (total > 0).then_some(total)
}
