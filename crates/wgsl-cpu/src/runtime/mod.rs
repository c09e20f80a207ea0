//! What translated kernels use at run time.

mod kernel;
mod storage;

pub use kernel::{Binding, BindingKind, Invocations, Kernel, NativeEntry};
pub use storage::Storage;
