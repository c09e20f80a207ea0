//! Buffers for running probes natively.

use std::cell::UnsafeCell;

use wgsl_cpu::{Invocations, Kernel, Storage};

/// A buffer's memory, aligned for vector loads.
pub struct Words {
    blocks: Vec<Block>,
    len: usize,
}

#[repr(C, align(16))]
struct Block([UnsafeCell<u32>; 4]);

impl Words {
    /// A buffer of these words.
    pub fn new(words: &[u32]) -> Self {
        let block = |chunk: &[u32]| {
            Block(std::array::from_fn(|i| UnsafeCell::new(chunk.get(i).copied().unwrap_or(0))))
        };
        Self { blocks: words.chunks(4).map(block).collect(), len: words.len() }
    }

    /// A buffer of these numbers.
    pub fn of_f32(values: &[f32]) -> Self {
        Self::new(&values.iter().map(|value| value.to_bits()).collect::<Vec<_>>())
    }

    /// The view that kernels take.
    pub fn storage(&self) -> Storage<'_> {
        // SAFETY: a block is four cells without padding, so that the blocks are as many cells in a
        // row, of which `len` are asked for.
        Storage::new(unsafe { std::slice::from_raw_parts(self.blocks.as_ptr().cast(), self.len) })
    }

    /// The words.
    pub fn to_vec(&mut self) -> Vec<u32> {
        let words = self.blocks.iter_mut().flat_map(|block| block.0.iter_mut().map(|cell| *cell.get_mut()));
        words.take(self.len).collect()
    }
}

/// Runs `groups` workgroups in a row on this thread.
///
/// # Panics
/// If the buffers are not those that the kernel asks for.
pub fn run_native(kernel: &Kernel, buffers: &[&Words], groups: u32) {
    let storages: Vec<Storage<'_>> = buffers.iter().map(|buffer| buffer.storage()).collect();
    let invocations = Invocations { first: 0, count: groups, grid: [groups, 1, 1] };
    // SAFETY: the kernel checks the buffers' sizes; nothing else runs while this thread does.
    unsafe { (kernel.native)(&storages, invocations) }
}
