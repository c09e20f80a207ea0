//! What translated kernels use at run time: WGSL's types and its semantics, on plain values.
//!
//! Translated source names all of it through `wgsl_cpu::runtime`; programs need only the records
//! that the crate's root exports, and the vectors to call translated functions.

mod atomic;
mod bits;
mod geometry;
mod index;
mod kernel;
mod math;
mod matrix;
mod number;
mod pack;
mod storage;
mod vector;

pub use atomic::{Atomic, AtomicWord, ExchangeResult};
pub use bits::*;
pub use geometry::*;
pub use index::{AsIndex, index};
pub use kernel::{Binding, BindingKind, Invocation, Invocations, Kernel, NativeEntry, check_bindings};
pub use math::*;
pub use matrix::{Mat, Square, Transpose, determinant, transpose};
pub use number::{Number, Scalar, Signed, Zero, div, rem, zero};
pub use pack::*;
pub use storage::{Place, Storage, Stored, TEXEL_BYTES, TEXEL_COLUMNS, TEXEL_ROWS};
pub use vector::*;
