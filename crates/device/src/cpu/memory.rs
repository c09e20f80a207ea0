//! Zeroed, aligned host memory that invocations on several threads share.

use std::{
    alloc::{Layout, alloc_zeroed, dealloc},
    cell::UnsafeCell,
    mem::ManuallyDrop,
    ptr::NonNull,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

/// Buffers start on a cache line.
const ALIGNMENT: usize = 64;

/// What the allocator itself is asked for. Above it, its zeroed memory is no longer fresh pages of
/// the system but written word by word, and a large buffer would cost its whole size at start-up.
const ALLOCATOR_ALIGNMENT: usize = 16;

/// How many bytes a device's buffers may take, and take now.
#[derive(Debug)]
pub(super) struct Budget {
    pub(super) limit: u64,
    taken: AtomicU64,
}

impl Budget {
    pub(super) fn new(limit: u64) -> Arc<Self> {
        Arc::new(Self { limit, taken: AtomicU64::new(0) })
    }

    fn take(&self, bytes: u64) -> bool {
        let fits = |taken: u64| taken.checked_add(bytes).filter(|&sum| sum <= self.limit);
        self.taken.fetch_update(Ordering::Relaxed, Ordering::Relaxed, fits).is_ok()
    }

    fn give_back(&self, bytes: u64) {
        self.taken.fetch_sub(bytes, Ordering::Relaxed);
    }
}

/// Kernels load four words at once.
const VECTOR_ALIGNMENT: usize = 16;

/// One buffer's words.
#[derive(Debug)]
pub(super) struct Memory {
    source: Source,
    first: NonNull<UnsafeCell<u32>>,
    n_words: usize,
    budget: Arc<Budget>,
}

/// Where the words came from, and go when they are done with.
#[derive(Debug)]
enum Source {
    /// The allocator.
    Block(NonNull<u8>, Layout),
    /// A list of this capacity that was handed over.
    List(usize),
}

// SAFETY: the block is owned by this value alone; `UnsafeCell` leaves it to the accesses, which the
// device serialises, to be free of races.
unsafe impl Send for Memory {}
// SAFETY: as above.
unsafe impl Sync for Memory {}

impl Memory {
    /// Zeroed memory of `bytes`, a positive multiple of 4; none if the budget or the allocator has
    /// none left.
    pub(super) fn zeroed(bytes: u64, budget: &Arc<Budget>) -> Option<Self> {
        let size = usize::try_from(bytes).ok()?.checked_add(ALIGNMENT)?;
        let layout = Layout::from_size_align(size, ALLOCATOR_ALIGNMENT).ok()?;
        if !budget.take(bytes) {
            return None;
        }
        // SAFETY: the layout's size is at least `ALIGNMENT`, so not zero.
        let Some(block) = NonNull::new(unsafe { alloc_zeroed(layout) }) else {
            budget.give_back(bytes);
            return None;
        };
        let to_alignment = block.as_ptr().align_offset(ALIGNMENT);
        // SAFETY: `to_alignment` is below `ALIGNMENT`, by which the block is longer than `bytes`.
        let first = unsafe { block.add(to_alignment) }.cast();
        let source = Source::Block(block, layout);
        Some(Self { source, first, n_words: (bytes / 4) as usize, budget: budget.clone() })
    }

    /// The memory of `words`, taken over; the words again where there are none, the budget has none left,
    /// or they do not lie as kernels need them.
    pub(super) fn of(words: Vec<[u32; 4]>, budget: &Arc<Budget>) -> Result<Self, Vec<[u32; 4]>> {
        let bytes = size_of_val(words.as_slice()) as u64;
        let lies_well = words.as_ptr().addr().is_multiple_of(VECTOR_ALIGNMENT);
        if words.is_empty() || !lies_well || !budget.take(bytes) {
            return Err(words);
        }
        let mut words = ManuallyDrop::new(words);
        let source = Source::List(words.capacity());
        // SAFETY: a list's pointer is never null. It is to all of the list's capacity.
        let first = unsafe { NonNull::new_unchecked(words.as_mut_ptr()) }.cast();
        Ok(Self { source, first, n_words: words.len() * 4, budget: budget.clone() })
    }

    /// The buffer as cells.
    pub(super) fn words(&self) -> &[UnsafeCell<u32>] {
        // SAFETY: `n_words` zeroed, aligned words start at `first` and live as long as `self`.
        unsafe { std::slice::from_raw_parts(self.first.as_ptr(), self.n_words) }
    }

    /// Where the buffer starts.
    pub(super) fn as_mut_ptr(&self) -> *mut u8 {
        self.first.as_ptr().cast()
    }

    /// The length in bytes.
    pub(super) fn len(&self) -> usize {
        self.n_words * 4
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        match self.source {
            // SAFETY: allocated in `zeroed` with this layout and freed only here.
            Source::Block(block, layout) => unsafe { dealloc(block.as_ptr(), layout) },
            Source::List(capacity) => {
                let first = self.first.as_ptr().cast::<[u32; 4]>();
                // SAFETY: the parts that `of` took a list apart into, put together only here.
                drop(unsafe { Vec::from_raw_parts(first, self.n_words / 4, capacity) });
            }
        }
        self.budget.give_back(self.len() as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::{ALIGNMENT, Budget, Memory};

    #[test]
    fn memory_is_zeroed_aligned_and_counted() {
        let budget = Budget::new(4096);
        let memory = Memory::zeroed(4000, &budget).expect("within the budget");
        assert_eq!(memory.words().len(), 1000);
        assert!(memory.as_mut_ptr().addr().is_multiple_of(ALIGNMENT));
        // SAFETY: nothing else accesses the memory.
        assert!(memory.words().iter().all(|word| unsafe { *word.get() } == 0));
        assert!(Memory::zeroed(100, &budget).is_none(), "over the budget");
        drop(memory);
        assert!(Memory::zeroed(4096, &budget).is_some(), "what was dropped is free again");
    }

    #[test]
    fn a_list_is_taken_over_and_counted() {
        let budget = Budget::new(64);
        let mut words = Vec::with_capacity(9);
        words.extend((0..3).map(|i| [i, i, i, 7 * i]));
        let place = words.as_ptr().addr();
        let memory = match Memory::of(words, &budget) {
            Ok(memory) => memory,
            // An allocator may lay four words anywhere; then they are copied.
            Err(words) => return assert!(!words.as_ptr().addr().is_multiple_of(16)),
        };
        assert_eq!((memory.as_mut_ptr().addr(), memory.len()), (place, 48));
        // SAFETY: nothing else accesses the memory.
        assert_eq!(unsafe { *memory.words()[11].get() }, 14);
        let refused = Memory::of(vec![[1; 4]; 2], &budget).expect_err("over the budget");
        assert_eq!(refused, [[1; 4]; 2]);
        assert!(Memory::of(Vec::new(), &budget).is_err());
        drop(memory);
        assert!(Memory::zeroed(64, &budget).is_some(), "what was dropped is free again");
    }

    #[test]
    fn an_impossible_size_is_no_memory() {
        let budget = Budget::new(u64::MAX);
        assert!(Memory::zeroed(u64::MAX - 3, &budget).is_none());
        assert!(Memory::zeroed(1 << 62, &budget).is_none());
        assert!(Memory::zeroed(64, &budget).is_some(), "a failure takes nothing from the budget");
    }
}
