//! What can go wrong on a device.

use crate::units::Bytes;

/// What can go wrong on a device. Each message is one line: what, where, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// No device has the name asked for.
    #[error("no device is called '{asked}'; this machine has: {}", .available.join(", "))]
    UnknownDevice {
        /// What was asked for.
        asked: String,
        /// The names of what there is.
        available: Vec<String>,
    },
    /// Several devices' names contain what was asked for.
    #[error("'{asked}' could be any of: {}; give more of the name", .matches.join(", "))]
    AmbiguousDevice {
        /// What was asked for.
        asked: String,
        /// The names that contain it.
        matches: Vec<String>,
    },
    /// Several names mean the same device.
    #[error("device '{device}' was given twice")]
    GivenTwice {
        /// The device's name.
        device: String,
    },
    /// A GPU was asked for and there is none.
    #[error(
        "no GPU was found (is its driver with Vulkan, Metal or DX12 installed?); this machine has: {}",
        .available.join(", ")
    )]
    NoGpu {
        /// The names of what there is.
        available: Vec<String>,
    },
    /// The device is there but its driver, or the system, would not open it.
    #[error("device '{device}' cannot be opened: {message}")]
    OpenFailed {
        /// The device's name.
        device: String,
        /// What the driver said.
        message: String,
    },
    /// The device's memory is full.
    #[error(
        "device '{device}' has no memory left for '{label}' of {}; ask for a smaller image or batch",
        Bytes(*.bytes)
    )]
    OutOfMemory {
        /// The device's name.
        device: String,
        /// The buffer's label.
        label: String,
        /// The size asked for.
        bytes: u64,
    },
    /// One buffer is larger than the device can address.
    #[error(
        "'{label}' needs {} in one buffer and device '{device}' takes at most {}; split it into pages",
        Bytes(*.bytes), Bytes(*.limit)
    )]
    BufferTooLarge {
        /// The device's name.
        device: String,
        /// The buffer's label.
        label: String,
        /// The size asked for.
        bytes: u64,
        /// The largest size possible.
        limit: u64,
    },
    /// A buffer's size is zero or no multiple of 4.
    #[error("buffer '{label}' of {bytes} bytes: sizes are positive multiples of 4 bytes")]
    BufferSize {
        /// The buffer's label.
        label: String,
        /// The size asked for.
        bytes: u64,
    },
    /// All buffers together are larger than the device's memory.
    #[error(
        "{} are needed and device '{device}' has {} to give (largest: {largest}); {advice}",
        Bytes(*.total), Bytes(*.usable)
    )]
    PlanTooLarge {
        /// The device's name.
        device: String,
        /// The sum of the plan.
        total: u64,
        /// How much of the device's memory may be planned.
        usable: u64,
        /// The largest items and their sizes.
        largest: String,
        /// What would fit.
        advice: String,
    },
    /// The device's limits or its driver do not accept a kernel.
    #[error("device '{device}' refuses kernel `{kernel}`: {message}")]
    KernelRefused {
        /// The device's name.
        device: String,
        /// The kernel's name.
        kernel: &'static str,
        /// Which limit, or what the driver said.
        message: String,
    },
    /// A kernel binds more storage buffers than the device has slots for.
    #[error("kernel `{kernel}` binds {count} storage buffers and device '{device}' takes at most {limit}")]
    TooManyStorageBuffers {
        /// The device's name.
        device: String,
        /// The kernel's name.
        kernel: &'static str,
        /// How many it binds.
        count: u32,
        /// How many the device takes.
        limit: u32,
    },
    /// The buffers given do not fit a kernel's bindings.
    #[error("kernel `{kernel}`, binding `{binding}`: {reason}")]
    BindingMismatch {
        /// The kernel's name.
        kernel: &'static str,
        /// The binding's WGSL name.
        binding: &'static str,
        /// What does not fit.
        reason: String,
    },
    /// The number of buffers given is not that of a kernel's bindings.
    #[error("kernel `{kernel}` has {expected} bindings and {given} buffers were given")]
    BindingCount {
        /// The kernel's name.
        kernel: &'static str,
        /// Its number of bindings.
        expected: usize,
        /// The number of buffers given.
        given: usize,
    },
    /// A byte range is outside its buffer or not made of whole 4-byte words.
    #[error(
        "{bytes} bytes at byte {offset} of buffer '{label}': not whole 4-byte words within its {size} bytes"
    )]
    Range {
        /// The buffer's label.
        label: String,
        /// Where the range starts, in bytes.
        offset: u64,
        /// The range's length in bytes.
        bytes: u64,
        /// The buffer's size in bytes.
        size: u64,
    },
    /// A texel store was to be read, cleared or copied.
    #[error("'{label}' is a texel store: it can be written and bound only")]
    TexelStore {
        /// The store's label.
        label: String,
    },
    /// A copy's source and destination are the same buffer.
    #[error("a copy within buffer '{label}': source and destination must be distinct buffers")]
    CopyWithin {
        /// The buffer's label.
        label: String,
    },
    /// A grid has more workgroups along an axis, or in all, than devices can index.
    #[error(
        "kernel `{kernel}` over {groups:?} workgroups: at most 65535 along an axis and 2^32 - 1 in all; \
         fold the grid into two dimensions or split it"
    )]
    DispatchTooLarge {
        /// The kernel's name.
        kernel: &'static str,
        /// Workgroups along x, y, z.
        groups: [u32; 3],
    },
    /// The buffer that should hold an indirect dispatch's grid cannot.
    #[error("kernel `{kernel}` cannot take its grid from buffer '{label}': {reason}")]
    IndirectArgs {
        /// The kernel's name.
        kernel: &'static str,
        /// The buffer's label.
        label: String,
        /// Why not.
        reason: &'static str,
    },
    /// A buffer, pipeline or bound kernel was made by another device.
    #[error("{what} '{name}' was made by another device than '{device}'")]
    Foreign {
        /// The device's name.
        device: String,
        /// `buffer`, `pipeline` or `bound kernel`.
        what: &'static str,
        /// Its label or kernel.
        name: String,
    },
    /// The device stopped working; nothing on it can be read any more.
    #[error("device '{device}' was lost: {message}; open it again and go on from the last checkpoint")]
    Lost {
        /// The device's name.
        device: String,
        /// What the driver said.
        message: String,
    },
    /// The driver refused a call that passed all of this crate's own checks.
    #[error("device '{device}' refused to {action}: {message}")]
    Refused {
        /// The device's name.
        device: String,
        /// What was attempted.
        action: &'static str,
        /// What the driver said.
        message: String,
    },
}
