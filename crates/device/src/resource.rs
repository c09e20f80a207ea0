//! What devices make and run: buffers, pipelines, bound kernels, commands.

use std::{
    any::Any,
    fmt,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use wgsl_cpu::Kernel;

/// What a buffer may be used for besides copies and clears.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BufferUsage {
    /// Kernels read and write it.
    Storage,
    /// Kernels read it as `var<uniform>`.
    Uniform,
    /// A texel store: kernels read it as `texture_2d_array<u32>`, 16 bytes at a time. It may be larger
    /// than a binding, is written in whole texels, and never read back.
    Texels,
    /// Holds `[x, y, z]` workgroup counts for indirect dispatch; also storage.
    Indirect,
}

/// Tells one opened device from another, so that their resources are not mixed up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DeviceId(u64);

impl DeviceId {
    /// An identity that no other device of this process has.
    pub(crate) fn unique() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// A device's own part of a resource.
pub(crate) type Inner = Arc<dyn Any + Send + Sync>;

/// A buffer of one device. Clones share the memory.
#[derive(Clone)]
pub struct Buffer {
    pub(crate) label: Arc<str>,
    pub(crate) bytes: u64,
    pub(crate) usage: BufferUsage,
    pub(crate) device: DeviceId,
    pub(crate) inner: Inner,
}

impl Buffer {
    /// The label it was created with, for messages and debuggers.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// Size in bytes, a multiple of 4.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// What it may be used for.
    pub fn usage(&self) -> BufferUsage {
        self.usage
    }

    /// Whether both are the same memory.
    pub(crate) fn same_memory(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.inner, &other.inner)
    }
}

impl fmt::Debug for Buffer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Buffer({:?}, {} bytes, {:?})", self.label, self.bytes, self.usage)
    }
}

/// A kernel made ready on one device.
#[derive(Clone)]
pub struct Pipeline {
    pub(crate) kernel: &'static Kernel,
    pub(crate) workgroup_size: u32,
    pub(crate) device: DeviceId,
    pub(crate) inner: Inner,
}

impl Pipeline {
    /// The kernel's record.
    pub fn kernel(&self) -> &'static Kernel {
        self.kernel
    }
}

impl fmt::Debug for Pipeline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Pipeline({})", self.kernel.name)
    }
}

/// A kernel with its buffers bound, in the order of [`Kernel::bindings`].
#[derive(Clone)]
pub struct BoundKernel {
    pub(crate) kernel: &'static Kernel,
    pub(crate) workgroup_size: u32,
    pub(crate) buffers: Arc<[Buffer]>,
    pub(crate) device: DeviceId,
    pub(crate) inner: Inner,
}

impl BoundKernel {
    /// The kernel's record.
    pub fn kernel(&self) -> &'static Kernel {
        self.kernel
    }

    /// Invocations of a workgroup, as it was loaded.
    pub fn workgroup_size(&self) -> u32 {
        self.workgroup_size
    }

    /// The buffers, in the order of [`Kernel::bindings`].
    pub fn buffers(&self) -> &[Buffer] {
        &self.buffers
    }
}

impl fmt::Debug for BoundKernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "BoundKernel({}, {:?})", self.kernel.name, self.buffers)
    }
}

/// One step of a list given to [`Device::run`](crate::Device::run).
#[derive(Clone, Debug)]
pub enum Command {
    /// Run a grid of workgroups; an axis of 0 runs none.
    Dispatch {
        /// The kernel and its buffers.
        bound: BoundKernel,
        /// Workgroups along x, y, z: at most 65535 each.
        groups: [u32; 3],
    },
    /// Run the grid whose `[x, y, z]` an earlier command wrote at `offset` bytes of `args`.
    DispatchIndirect {
        /// The kernel and its buffers; `args` is not among those it writes.
        bound: BoundKernel,
        /// A buffer with [`BufferUsage::Indirect`].
        args: Buffer,
        /// In bytes, a multiple of 4.
        offset: u64,
    },
    /// Fill a buffer with zeros.
    Clear(Buffer),
    /// Copy bytes between two distinct buffers. Offsets and length are multiples of 4.
    Copy {
        /// Source.
        from: Buffer,
        /// Byte offset in the source.
        from_offset: u64,
        /// Destination.
        to: Buffer,
        /// Byte offset in the destination.
        to_offset: u64,
        /// How many bytes.
        bytes: u64,
    },
    /// Put a few of the host's bytes into a buffer, as [`Device::write_buffer`](crate::Device::write_buffer).
    Write {
        /// Destination.
        to: Buffer,
        /// In bytes, a multiple of 4 as is the length.
        offset: u64,
        /// What it will hold there.
        data: Arc<[u8]>,
    },
}
