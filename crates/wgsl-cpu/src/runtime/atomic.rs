//! Atomic words of storage. WGSL's atomics are relaxed.

use std::{
    marker::PhantomData,
    sync::atomic::{AtomicU32, Ordering::Relaxed},
};

use super::Number;

/// `u32` and `i32`: what WGSL's `atomic<T>` may hold.
pub trait AtomicWord: Number {
    /// The word's bits.
    fn to_word(self) -> u32;
    /// The value of such bits.
    fn from_word(word: u32) -> Self;
}

impl AtomicWord for u32 {
    #[inline(always)]
    fn to_word(self) -> u32 {
        self
    }
    #[inline(always)]
    fn from_word(word: u32) -> Self {
        word
    }
}

impl AtomicWord for i32 {
    #[inline(always)]
    fn to_word(self) -> u32 {
        self as u32
    }
    #[inline(always)]
    fn from_word(word: u32) -> Self {
        word as i32
    }
}

/// WGSL's result of `atomicCompareExchangeWeak`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExchangeResult<T> {
    /// What was there before.
    pub old_value: T,
    /// Whether it was replaced.
    pub exchanged: bool,
}

/// A place that holds an `atomic<T>`. Every change returns the value from before.
#[derive(Clone, Copy, Debug)]
pub struct Atomic<'a, T> {
    word: &'a AtomicU32,
    value: PhantomData<T>,
}

impl<'a, T: AtomicWord> Atomic<'a, T> {
    /// The atomic that keeps its value in `word`.
    #[inline(always)]
    pub fn new(word: &'a AtomicU32) -> Self {
        Self { word, value: PhantomData }
    }

    /// `atomicLoad`.
    #[inline(always)]
    pub fn load(self) -> T {
        T::from_word(self.word.load(Relaxed))
    }

    /// `atomicStore`.
    #[inline(always)]
    pub fn store(self, value: T) {
        self.word.store(value.to_word(), Relaxed);
    }

    /// `atomicAdd`, wrapping.
    #[inline(always)]
    pub fn fetch_add(self, value: T) -> T {
        T::from_word(self.word.fetch_add(value.to_word(), Relaxed))
    }

    /// `atomicSub`, wrapping.
    #[inline(always)]
    pub fn fetch_sub(self, value: T) -> T {
        T::from_word(self.word.fetch_sub(value.to_word(), Relaxed))
    }

    /// `atomicAnd`.
    #[inline(always)]
    pub fn fetch_and(self, value: T) -> T {
        T::from_word(self.word.fetch_and(value.to_word(), Relaxed))
    }

    /// `atomicOr`.
    #[inline(always)]
    pub fn fetch_or(self, value: T) -> T {
        T::from_word(self.word.fetch_or(value.to_word(), Relaxed))
    }

    /// `atomicXor`.
    #[inline(always)]
    pub fn fetch_xor(self, value: T) -> T {
        T::from_word(self.word.fetch_xor(value.to_word(), Relaxed))
    }

    /// `atomicMin`.
    #[inline(always)]
    pub fn fetch_min(self, value: T) -> T {
        self.replace(|old| old.min(value))
    }

    /// `atomicMax`.
    #[inline(always)]
    pub fn fetch_max(self, value: T) -> T {
        self.replace(|old| old.max(value))
    }

    /// `atomicExchange`.
    #[inline(always)]
    pub fn exchange(self, value: T) -> T {
        T::from_word(self.word.swap(value.to_word(), Relaxed))
    }

    /// `atomicCompareExchangeWeak`; never fails spuriously.
    #[inline(always)]
    pub fn compare_exchange(self, compare: T, value: T) -> ExchangeResult<T> {
        let result = self.word.compare_exchange(compare.to_word(), value.to_word(), Relaxed, Relaxed);
        let (Ok(old) | Err(old)) = result;
        ExchangeResult { old_value: T::from_word(old), exchanged: result.is_ok() }
    }

    /// Replaces the value by a function of it; does not write where nothing changes.
    #[inline(always)]
    fn replace(self, new: impl Fn(T) -> T) -> T {
        let changed = |word| Some(new(T::from_word(word)).to_word()).filter(|&new| new != word);
        let (Ok(old) | Err(old)) = self.word.fetch_update(Relaxed, Relaxed, changed);
        T::from_word(old)
    }
}
