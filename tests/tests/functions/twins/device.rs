//! Running one kernel alone.

use std::collections::BTreeMap;

use midway_device::{BindingKind, Buffer, BufferUsage, Command, Device};
use midway_kernels::{constants::WORKGROUP, kernel};

/// What the kernel may have written: words by buffer.
pub type Outputs = BTreeMap<&'static str, Vec<u32>>;

/// Runs `n` invocations of a kernel over buffers that start with these contents.
///
/// # Panics
/// If a buffer is missing or the device refuses anything.
pub fn run(device: &dyn Device, name: &str, inputs: &[(&str, &[u8])], n: u32) -> Outputs {
    let kernel = kernel(name);
    let buffer = |binding: &midway_device::Binding| -> Buffer {
        let (_, bytes) = inputs
            .iter()
            .find(|(name, _)| *name == binding.name)
            .unwrap_or_else(|| panic!("{name} needs {}", binding.name));
        let usage = match binding.kind {
            BindingKind::Uniform => BufferUsage::Uniform,
            BindingKind::StorageRead | BindingKind::StorageReadWrite => BufferUsage::Storage,
            BindingKind::Texels => BufferUsage::Texels,
        };
        let buffer = device.create_buffer(binding.name, bytes.len() as u64, usage).expect("created");
        device.write_buffer(&buffer, 0, bytes).expect("written");
        buffer
    };
    let buffers: Vec<Buffer> = kernel.bindings.iter().map(buffer).collect();
    let pipeline = device.load_kernel(kernel).expect("loaded");
    let bound = device.bind(&pipeline, &buffers.iter().collect::<Vec<_>>()).expect("bound");
    device.run(&[Command::Dispatch { bound, groups: [n.div_ceil(WORKGROUP), 1, 1] }], false).expect("ran");
    let written = kernel.bindings.iter().zip(&buffers);
    written
        .filter(|(binding, _)| binding.kind == BindingKind::StorageReadWrite)
        .map(|(binding, buffer)| {
            let bytes = device.read_buffer(buffer, 0, buffer.bytes()).expect("read");
            (binding.name, bytes.as_chunks().0.iter().map(|&word| u32::from_le_bytes(word)).collect())
        })
        .collect()
}
