//! Raw storage cells: memory shared by the invocations of a dispatch.

use std::{cell::UnsafeCell, marker::PhantomData, sync::atomic::AtomicU32};

use super::{AsIndex, Atomic, AtomicWord, Mat, Vec2, Vec3, Vec4};

/// Texels in a row of a texel store.
pub const TEXEL_COLUMNS: u32 = 4096;
/// Rows in a layer of a texel store; a store of one layer may have fewer.
pub const TEXEL_ROWS: u32 = 4096;
/// Bytes of a texel: four words.
pub const TEXEL_BYTES: u32 = 16;

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

    /// How many elements of `stride` bytes there are from byte `base` up: WGSL's `arrayLength`.
    #[inline(always)]
    pub fn array_length(&self, base: usize, stride: usize) -> u32 {
        (self.len_bytes.saturating_sub(base) / stride) as u32
    }

    /// Asks for the cache line at a byte offset, where the machine can be asked; any offset will do.
    #[inline(always)]
    pub fn prefetch(&self, offset: usize) {
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            // SAFETY: a hint that loads nothing a program sees and never faults.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(self.words.cast::<i8>().wrapping_add(offset)) };
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = offset;
    }

    /// The place at a byte offset.
    ///
    /// # Safety
    /// What is loaded or stored there lies inside the buffer.
    #[inline(always)]
    pub unsafe fn at(&self, offset: usize) -> Place<'a> {
        // SAFETY: inside the buffer, by this function's contract.
        let bytes = unsafe { UnsafeCell::raw_get(self.words).cast::<u8>().add(offset) };
        Place { bytes, memory: PhantomData }
    }

    /// The element `index` of the runtime-sized array of elements of `stride` bytes that begins at
    /// byte `base`; the last one if the index is out of range.
    ///
    /// # Safety
    /// The buffer holds at least one element, and what is loaded or stored there lies inside it.
    #[inline(always)]
    pub unsafe fn element(&self, index: impl AsIndex, base: usize, stride: usize) -> Place<'a> {
        let mut offset = base + index.wide() * stride;
        // A branch never taken costs no latency, as a minimum would.
        if offset + stride > self.len_bytes {
            offset = self.last_element(base, stride);
        }
        // SAFETY: the element is in range, and otherwise this function's contract.
        unsafe { self.at(offset) }
    }

    /// The texel of a texel store, whose rows lie one after the other, as the layers of rows do. Out of
    /// range: zeros, as WGSL allows.
    ///
    /// # Safety
    /// Nothing writes the buffer meanwhile.
    #[inline(always)]
    pub unsafe fn texel<I: AsIndex>(&self, at: Vec2<I>, layer: impl AsIndex) -> Vec4<u32> {
        let (columns, rows) = (TEXEL_COLUMNS as usize, TEXEL_ROWS as usize);
        let (x, y) = (at.x.wide(), at.y.wide());
        let offset = ((layer.wide() * rows + y) * columns + x) * TEXEL_BYTES as usize;
        if x >= columns || y >= rows || offset + TEXEL_BYTES as usize > self.len_bytes {
            return Vec4::splat(0);
        }
        // SAFETY: the texel is in range.
        unsafe { self.at(offset).load() }
    }

    /// The byte offset of the last element.
    #[cold]
    #[inline(never)]
    fn last_element(&self, base: usize, stride: usize) -> usize {
        base + (self.array_length(base, stride) as usize).saturating_sub(1) * stride
    }
}

/// A place in a buffer: where a load or store goes.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    bytes: *mut u8,
    memory: PhantomData<&'a UnsafeCell<u32>>,
}

impl<'a> Place<'a> {
    /// The place `offset` bytes further: a member.
    ///
    /// # Safety
    /// The member lies inside what this place is.
    #[inline(always)]
    pub unsafe fn at(self, offset: usize) -> Self {
        // SAFETY: inside the same buffer, by this function's contract.
        Self { bytes: unsafe { self.bytes.add(offset) }, ..self }
    }

    /// The element `index` of the array of `len` elements of `stride` bytes that this place is;
    /// the last one if the index is out of range.
    ///
    /// # Safety
    /// This place is such an array.
    #[inline(always)]
    pub unsafe fn element(self, index: impl AsIndex, len: usize, stride: usize) -> Self {
        // SAFETY: the element is in range.
        unsafe { self.at(index.as_index(len) * stride) }
    }

    /// Loads a value.
    ///
    /// # Safety
    /// This place holds a `T`, and nothing writes it meanwhile.
    #[inline(always)]
    pub unsafe fn load<T: Stored>(self) -> T {
        // SAFETY: this function's contract.
        unsafe { T::load(self.bytes) }
    }

    /// Stores a value.
    ///
    /// # Safety
    /// This place holds a `T`, and nothing else accesses it meanwhile.
    #[inline(always)]
    pub unsafe fn store<T: Stored>(self, value: T) {
        // SAFETY: this function's contract.
        unsafe { value.store(self.bytes) }
    }

    /// The atomic word here.
    ///
    /// # Safety
    /// This place holds an `atomic<T>`, which is only accessed as such.
    #[inline(always)]
    pub unsafe fn atomic<T: AtomicWord>(self) -> Atomic<'a, T> {
        // SAFETY: an aligned word, shared only as an atomic one, that lives as long as the buffer.
        Atomic::new(unsafe { AtomicU32::from_ptr(self.bytes.cast()) })
    }
}

/// A type that buffers hold, in WGSL's layout.
pub trait Stored: Copy {
    /// WGSL's `SizeOf`.
    const SIZE: usize;
    /// WGSL's `AlignOf`.
    const ALIGN: usize;
    /// The distance of the elements of an array of it.
    const STRIDE: usize = Self::SIZE.next_multiple_of(Self::ALIGN);

    /// Loads it from `bytes`.
    ///
    /// # Safety
    /// `bytes` is valid for reading [`Stored::SIZE`] bytes and aligned to 4.
    unsafe fn load(bytes: *const u8) -> Self;

    /// Stores it to `bytes`, leaving padding as it is.
    ///
    /// # Safety
    /// `bytes` is valid for writing [`Stored::SIZE`] bytes and aligned to 4.
    unsafe fn store(self, bytes: *mut u8);
}

/// Types whose Rust layout is packed words, as WGSL's: one load, one store.
macro_rules! stored_words {
    ($($t:ty, $align:literal;)*) => {$(
        impl Stored for $t {
            const SIZE: usize = size_of::<$t>();
            const ALIGN: usize = $align;
            #[inline(always)]
            unsafe fn load(bytes: *const u8) -> Self {
                // SAFETY: the words of `bytes` are such a value; alignment 4 is all it needs.
                unsafe { bytes.cast::<Self>().read() }
            }
            #[inline(always)]
            unsafe fn store(self, bytes: *mut u8) {
                // SAFETY: as for loading.
                unsafe { bytes.cast::<Self>().write(self) }
            }
        }
    )*};
    ($($scalar:ident)*) => {$(
        stored_words! {
            $scalar, 4;
            Vec2<$scalar>, 8;
            Vec3<$scalar>, 16;
            Vec4<$scalar>, 16;
        }
    )*};
}

stored_words!(f32 i32 u32);

impl<T: Stored, const N: usize> Stored for [T; N] {
    const SIZE: usize = N * T::STRIDE;
    const ALIGN: usize = T::ALIGN;
    #[inline(always)]
    unsafe fn load(bytes: *const u8) -> Self {
        // SAFETY: element `i` begins at `i * STRIDE`, inside the array.
        std::array::from_fn(|i| unsafe { T::load(bytes.add(i * T::STRIDE)) })
    }
    #[inline(always)]
    unsafe fn store(self, bytes: *mut u8) {
        for (i, element) in self.into_iter().enumerate() {
            // SAFETY: element `i` begins at `i * STRIDE`, inside the array.
            unsafe { element.store(bytes.add(i * T::STRIDE)) }
        }
    }
}

impl<V: Stored, const C: usize> Stored for Mat<V, C> {
    const SIZE: usize = C * V::STRIDE;
    const ALIGN: usize = V::ALIGN;
    #[inline(always)]
    unsafe fn load(bytes: *const u8) -> Self {
        // SAFETY: a matrix is laid out as the array of its columns.
        Self { columns: unsafe { Stored::load(bytes) } }
    }
    #[inline(always)]
    unsafe fn store(self, bytes: *mut u8) {
        // SAFETY: a matrix is laid out as the array of its columns.
        unsafe { self.columns.store(bytes) }
    }
}
