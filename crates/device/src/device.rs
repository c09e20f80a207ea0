//! The interface that every device offers.

use std::time::Duration;

use wgsl_cpu::Kernel;

use crate::{BoundKernel, Buffer, BufferUsage, Command, DeviceError, Pipeline};

/// Whether a device is hardware made for it or a stand-in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceKind {
    /// This machine's cores, through the translated kernels.
    Cpu,
    /// A discrete, integrated or virtual GPU.
    Gpu,
    /// A GPU driver that runs on the CPU (lavapipe); used only when named.
    SoftwareGpu,
}

/// What `midway devices` prints.
#[derive(Clone, Debug)]
pub struct DeviceInfo {
    /// The name `--device` takes.
    pub name: String,
    /// What it is.
    pub kind: DeviceKind,
    /// Backend and driver, for people.
    pub backend: String,
    /// Memory in bytes where the backend says.
    pub memory_bytes: Option<u64>,
    /// The largest single buffer, in bytes.
    pub max_buffer_bytes: u64,
    /// The largest storage binding, in bytes; never more than `max_buffer_bytes`.
    pub max_binding_bytes: u64,
    /// Storage buffers a kernel may bind.
    pub max_storage_buffers: u32,
    /// Invocations of a workgroup for kernels that hold and read much.
    pub wide_workgroup: u32,
}

/// How long a run took, and each of its dispatches where the device can tell.
#[derive(Clone, Debug, Default)]
pub struct RunTiming {
    /// From submission to the end, as this process saw it.
    pub wall: Duration,
    /// The longest of the parts that it was submitted in, or more: a device may work on one while the next is
    /// recorded. All of it where there are no parts.
    pub longest_part: Duration,
    /// `(kernel name, time on the device)` in order of the dispatches; empty if not measured.
    pub dispatches: Vec<(&'static str, Duration)>,
}

impl RunTiming {
    /// The longest dispatch, by which callers size the next ones; none if not measured.
    pub fn longest_dispatch(&self) -> Option<(&'static str, Duration)> {
        self.dispatches.iter().copied().max_by_key(|&(_, time)| time)
    }
}

/// Runs kernels. All calls may block; [`Device::run`] returns when the work is finished.
///
/// A device may be shared between threads. Runs, reads and writes of one device exclude each other
/// or are queued in the order of the calls.
pub trait Device: Send + Sync {
    /// What it is.
    fn info(&self) -> &DeviceInfo;

    /// Allocates a zeroed buffer of `bytes`, a positive multiple of 4.
    ///
    /// # Errors
    /// [`DeviceError::OutOfMemory`], [`DeviceError::BufferTooLarge`] or [`DeviceError::BufferSize`].
    fn create_buffer(&self, label: &str, bytes: u64, usage: BufferUsage) -> Result<Buffer, DeviceError>;

    /// A buffer that holds `words`, at least one. Where the device's memory is the host's, it is theirs: they
    /// are not copied.
    ///
    /// # Errors
    /// As [`Device::create_buffer`], or if the device is lost.
    fn create_buffer_of(
        &self,
        label: &str,
        words: Vec<[u32; 4]>,
        usage: BufferUsage,
    ) -> Result<Buffer, DeviceError> {
        copy_to_buffer(self, label, &words, usage)
    }

    /// Copies `data` into the buffer at `offset` bytes, before any later [`Device::run`]. Offset
    /// and length are multiples of 4.
    ///
    /// # Errors
    /// If the range is outside the buffer or the device is lost.
    fn write_buffer(&self, buffer: &Buffer, offset: u64, data: &[u8]) -> Result<(), DeviceError>;

    /// Reads bytes back. Offset and length are multiples of 4.
    ///
    /// # Errors
    /// If the range is outside the buffer or the device is lost.
    fn read_buffer(&self, buffer: &Buffer, offset: u64, bytes: u64) -> Result<Vec<u8>, DeviceError>;

    /// Makes a kernel ready to run, its overrides at their defaults. Kernels may be loaded by several
    /// threads at once.
    ///
    /// # Errors
    /// As [`Device::load_specialised`].
    fn load_kernel(&self, kernel: &'static Kernel) -> Result<Pipeline, DeviceError> {
        self.load_specialised(kernel, &[])
    }

    /// The same with values for some of its WGSL `override`s, by name: constants to a GPU's compiler,
    /// which leaves out what they make unreachable. The CPU has each kernel compiled once, with the
    /// defaults: a value may only exclude what is never asked for, or be a workgroup's size.
    ///
    /// # Errors
    /// If the kernel exceeds the device's limits or its driver refuses it; on a GPU also if it has no
    /// such override.
    fn load_specialised(
        &self,
        kernel: &'static Kernel,
        overrides: &[(&'static str, f64)],
    ) -> Result<Pipeline, DeviceError>;

    /// Binds buffers, in the order of [`Kernel::bindings`]. The bound kernel keeps them alive.
    ///
    /// # Errors
    /// If their number, usage or size does not fit the kernel's bindings, or one buffer is bound
    /// twice and one of the two is read-write.
    fn bind(&self, pipeline: &Pipeline, buffers: &[&Buffer]) -> Result<BoundKernel, DeviceError>;

    /// How many lists of commands run best at once, each on a lane of its own: the CPU's threads,
    /// 1 on a GPU.
    fn lanes(&self) -> usize {
        1
    }

    /// Calls `work(lane)` for each lane, at once where the device can. Within it this device's calls
    /// run on that lane alone and do not exclude those of other lanes; calls from outside wait.
    ///
    /// # Safety
    ///
    /// No lane may access plainly, by a command or a call, what another writes in the meantime:
    /// memory that lanes share is read only, or touched by kernels' atomics alone.
    unsafe fn for_each_lane(&self, work: &(dyn Fn(usize) + Sync)) {
        (0..self.lanes()).for_each(work);
    }

    /// Runs the commands in order and waits for the end. `timed` asks for [`RunTiming::dispatches`].
    ///
    /// Dispatches are not split: on a GPU that also draws a desktop one that lasts longer than the
    /// driver's watchdog allows loses the device. Callers size them by
    /// [`RunTiming::longest_part`], or by [`RunTiming::longest_dispatch`].
    ///
    /// All commands are checked before the first one runs, except the grids of indirect
    /// dispatches: kernels that write these keep each axis at or below 65535. The CPU device reports
    /// a larger one; a GPU's behaviour is undefined.
    ///
    /// # Errors
    /// If a command is refused (then none has run) or the device is lost.
    fn run(&self, commands: &[Command], timed: bool) -> Result<RunTiming, DeviceError>;

    /// [`Device::run`], then [`Device::read_buffer`] of `bytes` at `offset` of `buffer`: a GPU is waited for
    /// once.
    ///
    /// # Errors
    /// Those of both.
    fn run_and_read(
        &self,
        commands: &[Command],
        timed: bool,
        buffer: &Buffer,
        (offset, bytes): (u64, u64),
    ) -> Result<(RunTiming, Vec<u8>), DeviceError> {
        run_then_read(self, commands, timed, buffer, (offset, bytes))
    }
}

/// A run and a read, one after the other.
pub(crate) fn run_then_read(
    device: &(impl Device + ?Sized),
    commands: &[Command],
    timed: bool,
    buffer: &Buffer,
    (offset, bytes): (u64, u64),
) -> Result<(RunTiming, Vec<u8>), DeviceError> {
    let timing = device.run(commands, timed)?;
    Ok((timing, device.read_buffer(buffer, offset, bytes)?))
}

/// A new buffer that holds a copy of `words`, at least one.
pub(crate) fn copy_to_buffer(
    device: &(impl Device + ?Sized),
    label: &str,
    words: &[[u32; 4]],
    usage: BufferUsage,
) -> Result<Buffer, DeviceError> {
    let bytes = bytemuck::cast_slice(words);
    let buffer = device.create_buffer(label, bytes.len() as u64, usage)?;
    device.write_buffer(&buffer, 0, bytes)?;
    Ok(buffer)
}
