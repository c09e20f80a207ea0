//! What both devices ask of buffers, bindings and commands before they act on them.

use wgsl_cpu::{Binding, BindingKind, Kernel, runtime::TEXEL_BYTES};

use crate::{
    BoundKernel, Buffer, BufferUsage, Command, DeviceError, DeviceInfo,
    resource::{DeviceId, Pipeline},
};

/// Workgroups along one axis of a grid that every GPU backend takes.
const MAX_GROUPS_PER_AXIS: u32 = 65535;

/// Bytes of an indirect dispatch's `[x, y, z]`.
const INDIRECT_ARGS_BYTES: u64 = 12;

/// The checks, in the name of one device.
#[derive(Clone, Copy)]
pub(crate) struct Check<'a> {
    pub(crate) id: DeviceId,
    pub(crate) info: &'a DeviceInfo,
}

impl Check<'_> {
    /// A new buffer's size against the largest one possible.
    pub(crate) fn size(&self, label: &str, bytes: u64, limit: u64) -> Result<(), DeviceError> {
        if bytes == 0 || !bytes.is_multiple_of(4) {
            return Err(DeviceError::BufferSize { label: label.into(), bytes });
        }
        if bytes > limit {
            let device = self.info.name.clone();
            return Err(DeviceError::BufferTooLarge { device, label: label.into(), bytes, limit });
        }
        Ok(())
    }

    /// That `bytes` at `offset` are whole words within the buffer, which is this device's.
    pub(crate) fn range(&self, buffer: &Buffer, offset: u64, bytes: u64) -> Result<(), DeviceError> {
        self.owns(buffer.device, "buffer", &buffer.label)?;
        let inside = offset.checked_add(bytes).is_some_and(|end| end <= buffer.bytes);
        if inside && offset.is_multiple_of(4) && bytes.is_multiple_of(4) {
            return Ok(());
        }
        Err(DeviceError::Range { label: buffer.label.to_string(), offset, bytes, size: buffer.bytes })
    }

    /// That `bytes` at `offset` of a texel store are whole texels.
    pub(crate) fn whole_texels(&self, buffer: &Buffer, offset: u64, bytes: u64) -> Result<(), DeviceError> {
        let texel = u64::from(TEXEL_BYTES);
        if buffer.usage != BufferUsage::Texels || offset.is_multiple_of(texel) && bytes.is_multiple_of(texel)
        {
            return Ok(());
        }
        Err(DeviceError::Range { label: buffer.label.to_string(), offset, bytes, size: buffer.bytes })
    }

    /// That commands and reads do not touch texel stores.
    pub(crate) fn plain(&self, buffer: &Buffer) -> Result<(), DeviceError> {
        if buffer.usage != BufferUsage::Texels {
            return Ok(());
        }
        Err(DeviceError::TexelStore { label: buffer.label.to_string() })
    }

    /// That a buffer may be written at `offset`.
    pub(crate) fn write(&self, buffer: &Buffer, offset: u64, data: &[u8]) -> Result<(), DeviceError> {
        self.range(buffer, offset, data.len() as u64)?;
        self.whole_texels(buffer, offset, data.len() as u64)
    }

    /// That a kernel binds no more storage buffers than the device takes.
    pub(crate) fn kernel(&self, kernel: &'static Kernel) -> Result<(), DeviceError> {
        let storage = kernel.bindings.iter().filter(|binding| binding.kind.is_storage());
        let count = u32::try_from(storage.count()).unwrap_or(u32::MAX);
        let limit = self.info.max_storage_buffers;
        if count > limit {
            let device = self.info.name.clone();
            return Err(DeviceError::TooManyStorageBuffers { device, kernel: kernel.name, count, limit });
        }
        Ok(())
    }

    /// That the buffers fit the pipeline's bindings and none is written under two names.
    pub(crate) fn bindings(&self, pipeline: &Pipeline, buffers: &[&Buffer]) -> Result<(), DeviceError> {
        let kernel = pipeline.kernel;
        self.owns(pipeline.device, "pipeline", kernel.name)?;
        if buffers.len() != kernel.bindings.len() {
            let (expected, given) = (kernel.bindings.len(), buffers.len());
            return Err(DeviceError::BindingCount { kernel: kernel.name, expected, given });
        }
        for (position, (binding, buffer)) in kernel.bindings.iter().zip(buffers).enumerate() {
            self.owns(buffer.device, "buffer", &buffer.label)?;
            binding_fits(binding, buffer)
                .and_then(|()| binding_is_alone(kernel, &buffers[..position], binding, buffer))
                .map_err(|reason| DeviceError::BindingMismatch {
                    kernel: kernel.name,
                    binding: binding.name,
                    reason,
                })?;
        }
        Ok(())
    }

    /// All that can be known of a command before it runs.
    pub(crate) fn command(&self, command: &Command) -> Result<(), DeviceError> {
        match command {
            Command::Dispatch { bound, groups } => {
                self.owns(bound.device, "bound kernel", bound.kernel.name)?;
                grid(bound.kernel, *groups)
            }
            Command::DispatchIndirect { bound, args, offset } => {
                self.owns(bound.device, "bound kernel", bound.kernel.name)?;
                self.range(args, *offset, INDIRECT_ARGS_BYTES)?;
                indirect_args(bound, args)
            }
            Command::Clear(buffer) => {
                self.plain(buffer)?;
                self.owns(buffer.device, "buffer", &buffer.label)
            }
            Command::Copy { from, from_offset, to, to_offset, bytes } => {
                self.range(from, *from_offset, *bytes)?;
                self.range(to, *to_offset, *bytes)?;
                self.plain(from)?;
                self.plain(to)?;
                if from.same_memory(to) {
                    return Err(DeviceError::CopyWithin { label: from.label.to_string() });
                }
                Ok(())
            }
            Command::Write { to, offset, data } => self.write(to, *offset, data),
        }
    }

    /// That a resource was made by this device.
    fn owns(&self, owner: DeviceId, what: &'static str, name: &str) -> Result<(), DeviceError> {
        if owner == self.id {
            return Ok(());
        }
        Err(DeviceError::Foreign { device: self.info.name.clone(), what, name: name.into() })
    }
}

/// That a grid's workgroups can be indexed along each axis and, by [`u32`], in all.
pub(crate) fn grid(kernel: &'static Kernel, groups: [u32; 3]) -> Result<(), DeviceError> {
    let too_long = groups.iter().any(|&axis| axis > MAX_GROUPS_PER_AXIS);
    let total = groups.iter().fold(1u64, |total, &axis| total.saturating_mul(u64::from(axis)));
    if too_long || total > u64::from(u32::MAX) {
        return Err(DeviceError::DispatchTooLarge { kernel: kernel.name, groups });
    }
    Ok(())
}

fn indirect_args(bound: &BoundKernel, args: &Buffer) -> Result<(), DeviceError> {
    let written =
        bound.kernel.bindings.iter().zip(&*bound.buffers).any(|(binding, buffer)| {
            binding.kind == BindingKind::StorageReadWrite && buffer.same_memory(args)
        });
    let reason = if args.usage != BufferUsage::Indirect {
        "it was not created for indirect dispatch"
    } else if written {
        "the kernel itself writes it"
    } else {
        return Ok(());
    };
    Err(DeviceError::IndirectArgs { kernel: bound.kernel.name, label: args.label.to_string(), reason })
}

fn binding_fits(binding: &Binding, buffer: &Buffer) -> Result<(), String> {
    let fits = match binding.kind {
        BindingKind::Uniform => buffer.usage == BufferUsage::Uniform,
        BindingKind::Texels => buffer.usage == BufferUsage::Texels,
        BindingKind::StorageRead | BindingKind::StorageReadWrite => {
            matches!(buffer.usage, BufferUsage::Storage | BufferUsage::Indirect)
        }
    };
    if !fits {
        return Err(format!(
            "it is {:?} and buffer '{}' was created as {:?}",
            binding.kind, buffer.label, buffer.usage
        ));
    }
    if buffer.bytes < binding.min_bytes {
        return Err(format!(
            "it needs at least {} bytes and buffer '{}' has {}",
            binding.min_bytes, buffer.label, buffer.bytes
        ));
    }
    Ok(())
}

fn binding_is_alone(
    kernel: &Kernel,
    earlier: &[&Buffer],
    binding: &Binding,
    buffer: &Buffer,
) -> Result<(), String> {
    let writes = |binding: &Binding| binding.kind == BindingKind::StorageReadWrite;
    let clash = kernel
        .bindings
        .iter()
        .zip(earlier)
        .find(|(other, bound)| bound.same_memory(buffer) && (writes(other) || writes(binding)));
    match clash {
        Some((other, _)) => Err(format!(
            "buffer '{}' is also bound as `{}` and one of the two is read-write",
            buffer.label, other.name
        )),
        None => Ok(()),
    }
}

/// Empty host memory with room for what is read back.
pub(crate) fn host_memory(label: &str, bytes: u64) -> Result<Vec<u8>, DeviceError> {
    let mut memory = Vec::new();
    let room = usize::try_from(bytes).ok().and_then(|bytes| memory.try_reserve_exact(bytes).ok());
    room.map(|()| memory).ok_or_else(|| DeviceError::OutOfMemory {
        device: "this machine".into(),
        label: label.into(),
        bytes,
    })
}
