//! Reading buffers back through one mapped buffer that is kept.

use std::sync::mpsc;

use super::fault::{Fault, Faults};

/// The most that is in flight between host and device at once.
pub(super) const STAGING_BYTES: u64 = 64 << 20;

/// The least a staging buffer holds.
const MIN_BYTES: u64 = 64 << 10;

/// The mapped buffer, made when first needed and grown with what is read.
#[derive(Default)]
pub(super) struct Staging {
    buffer: Option<wgpu::Buffer>,
}

impl Staging {
    /// Appends `bytes` at `offset` of `source` to `out`, in portions.
    pub(super) fn read(
        &mut self,
        (device, queue, faults): (&wgpu::Device, &wgpu::Queue, &Faults),
        source: &wgpu::Buffer,
        (offset, bytes): (u64, u64),
        out: &mut Vec<u8>,
    ) -> Result<(), Fault> {
        let end = offset + bytes;
        let mut offset = offset;
        while offset < end {
            let portion = (end - offset).min(STAGING_BYTES);
            let staging = self.with_room(device, faults, portion)?;
            let submission = faults.guard(device, || {
                let mut encoder = device.create_command_encoder(&Default::default());
                encoder.copy_buffer_to_buffer(source, offset, &staging, 0, portion);
                queue.submit([encoder.finish()])
            })?;
            let (told, mapped) = mpsc::channel();
            faults.guard(device, || {
                staging.map_async(wgpu::MapMode::Read, ..portion, move |result| {
                    // The receiver is gone only if the wait below failed already.
                    let _ = told.send(result);
                });
            })?;
            faults.wait(device, submission)?;
            let refused = |error: &dyn std::fmt::Display| Fault::Refused(error.to_string());
            // Another thread's wait may have taken the callback and be about to call it.
            mapped.recv().map_err(|error| refused(&error))?.map_err(|error| refused(&error))?;
            let view = staging.get_mapped_range(..portion).map_err(|error| refused(&error))?;
            out.extend_from_slice(&view);
            drop(view);
            staging.unmap();
            self.buffer = Some(staging);
            offset += portion;
        }
        Ok(())
    }

    /// Takes the buffer out; it is put back once it is unmapped again.
    fn with_room(
        &mut self,
        device: &wgpu::Device,
        faults: &Faults,
        bytes: u64,
    ) -> Result<wgpu::Buffer, Fault> {
        if let Some(buffer) = self.buffer.take().filter(|buffer| buffer.size() >= bytes) {
            return Ok(buffer);
        }
        faults.guard(device, || {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("readback"),
                size: bytes.next_power_of_two().max(MIN_BYTES),
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        })
    }
}
