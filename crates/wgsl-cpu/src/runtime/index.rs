//! Indexes: whatever a kernel asks for, what it gets is in range.

/// An index of WGSL's `u32` or `i32`.
pub trait AsIndex: Copy {
    /// The index itself; a negative one is beyond any array.
    fn wide(self) -> usize;

    /// The index into `len` elements (at least one), the last one if it is out of range.
    #[inline(always)]
    fn as_index(self, len: usize) -> usize {
        self.wide().min(len - 1)
    }
}

impl AsIndex for u32 {
    #[inline(always)]
    fn wide(self) -> usize {
        self as usize
    }
}

impl AsIndex for i32 {
    #[inline(always)]
    fn wide(self) -> usize {
        self as u32 as usize
    }
}

/// The index into an array of `len` elements, the last one if it is out of range.
#[inline(always)]
pub fn index(index: impl AsIndex, len: usize) -> usize {
    index.as_index(len)
}
