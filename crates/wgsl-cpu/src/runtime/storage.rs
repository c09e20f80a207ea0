//! Raw storage cells: memory shared by the invocations of a dispatch.

use std::{cell::UnsafeCell, marker::PhantomData};

/// A view of a buffer's bytes, shared by all invocations of a dispatch. Plain `&mut` would be
/// unsound there: invocations on other threads hold it too.
#[derive(Clone, Copy, Debug)]
pub struct Storage<'a> {
    words: *const UnsafeCell<u32>,
    len_bytes: usize,
    memory: PhantomData<&'a UnsafeCell<u32>>,
}

// SAFETY: the cells are raw memory; `NativeEntry`'s contract forbids conflicting plain accesses
// and everything shared between invocations goes through atomics.
unsafe impl Send for Storage<'_> {}
// SAFETY: as above.
unsafe impl Sync for Storage<'_> {}

impl<'a> Storage<'a> {
    /// A view of `words`, which must be 16-byte aligned for vector loads.
    pub fn new(words: &'a [UnsafeCell<u32>]) -> Self {
        debug_assert!(words.as_ptr().addr().is_multiple_of(16));
        Self { words: words.as_ptr(), len_bytes: size_of_val(words), memory: PhantomData }
    }

    /// The length in bytes.
    pub fn len_bytes(&self) -> usize {
        self.len_bytes
    }
}
