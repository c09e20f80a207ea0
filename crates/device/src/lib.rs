//! What runs any kernel handed to it: a GPU through wgpu, or this machine's cores.
//!
//! A [`Device`] owns buffers and compiled kernels and runs lists of [`Command`]s in order: each
//! command sees all that earlier ones wrote. It knows no kernel by name.
//!
//! [`open_device`] picks a device by the name a user gave, [`list_devices`] says what there is,
//! and [`MemoryPlan`] says before anything is allocated whether it would fit.

mod check;
mod cpu;
mod device;
mod error;
mod gpu;
mod plan;
mod resource;
mod select;
mod units;

pub use cpu::CpuDevice;
pub use device::{Device, DeviceInfo, DeviceKind, RunTiming};
pub use error::DeviceError;
pub use gpu::GpuDevice;
pub use plan::MemoryPlan;
pub use resource::{BoundKernel, Buffer, BufferUsage, Command, Pipeline};
pub use select::{OpenOptions, keep_drivers_quiet, list_devices, open_device, open_devices};
pub use units::Bytes;
pub use wgsl_cpu::{Binding, BindingKind, Kernel};
