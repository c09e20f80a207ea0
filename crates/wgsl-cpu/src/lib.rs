//! WGSL kernels on the bare CPU.
//!
//! Two halves. [`runtime`] is what translated kernels and the device that runs them need: vectors,
//! storage cells, WGSL's own arithmetic, and the [`Kernel`] record. `translate` (feature
//! `translate`, for build scripts) turns a validated WGSL module into Rust source that uses it.

pub mod runtime;
#[cfg(feature = "translate")]
pub mod translate;

pub use runtime::{Binding, BindingKind, Invocations, Kernel, NativeEntry, Storage};
