//! WGSL in, Rust out, for build scripts.
//!
//! ```
//! let wgsl = "fn half_of(x: f32) -> f32 { return 0.5 * x; }";
//! let translation = wgsl_cpu::translate::translate(wgsl)?;
//! assert!(translation.rust.contains("pub fn half_of(x: f32) -> f32"));
//! # Ok::<(), wgsl_cpu::translate::TranslateError>(())
//! ```
//!
//! # What the emitted source is
//!
//! [`Translation::rust`] is the inside of a module, without inner attributes. Write it to
//! `$OUT_DIR/NAME.rs` and take it in with
//!
//! ```ignore
//! #[allow(unused, nonstandard_style, missing_docs, clippy::all)]
//! mod NAME {
//!     include!(concat!(env!("OUT_DIR"), "/NAME.rs"));
//! }
//! ```
//!
//! It holds, under the WGSL names (an underscore is appended where Rust has taken a name):
//!
//! - a struct for each WGSL struct that is used as a value, a `const` (arrays: a `static`) for each
//!   module constant, a `pub fn` for each function. Functions take and return values;
//!   `ptr<function, T>` is `&mut T`; those that reach buffers take `globals: &Globals<'_>` first,
//!   those that reach `var<private>` then take `private: &mut Private`;
//! - if there are buffers, `pub const BINDINGS: &[Binding]`, sorted by slot, and `Globals`, made of
//!   [`Storage`](crate::Storage)s in that order;
//! - if there is an entry point, `pub const WORKGROUP_SIZE: u32`, `pub const WORKGROUP_OVERRIDE:
//!   Option<&str>` (as in [`Kernel`](crate::Kernel)) and `pub unsafe fn entry(bindings:
//!   &[Storage<'_>], invocations: Invocations)`, a [`NativeEntry`](crate::NativeEntry).
//!
//! A module with an entry point is cut down to what that reaches: functions, constants and
//! bindings that it does not use are left out. A module without one is a library: all is kept.

mod call;
mod control;
mod error;
mod expression;
mod function;
mod literal;
mod math;
mod module;
mod names;
mod place;
mod reach;
mod reflect;
mod schedule;
mod statement;
mod types;

use naga::valid::{Capabilities, ValidationFlags, Validator};

pub use error::{Location, TranslateError};
pub use reflect::{
    BindingInfo, ConstantInfo, EntryInfo, MemberInfo, ScalarType, ScalarValue, StructInfo, TypeInfo,
};

/// A translated module: Rust source and what a host needs to know about the WGSL.
#[derive(Clone, Debug)]
pub struct Translation {
    /// The Rust source; see [the module's page](self) for what it holds.
    pub rust: String,
    /// The compute entry point, if the module has one.
    pub entry: Option<EntryInfo>,
    /// The buffers used, sorted by slot.
    pub bindings: Vec<BindingInfo>,
    /// All structs of the module, used or not, with their layout in buffers.
    pub structs: Vec<StructInfo>,
    /// All named constants of the module, used or not.
    pub constants: Vec<ConstantInfo>,
}

/// A function that is written by hand for the CPU: its translation has the WGSL's signature and passes all
/// arguments, `globals` first where it reaches buffers, to a macro.
#[derive(Clone, Copy, Debug)]
pub struct Native {
    /// The WGSL function's name.
    pub function: &'static str,
    /// The path of the macro, expanded in the emitted module.
    pub path: &'static str,
}

/// Translates a linked WGSL module, which has one compute entry point or none.
///
/// # Errors
/// As [`translate_with`].
pub fn translate(wgsl: &str) -> Result<Translation, TranslateError> {
    translate_with(wgsl, &[])
}

/// As [`translate`], with functions that are written by hand; a name that the module lacks is none.
///
/// # Errors
/// [`TranslateError`], with the line in `wgsl`, if the module does not parse, is not valid, or uses
/// what the CPU does not have (the crate's README names the supported subset).
pub fn translate_with(wgsl: &str, natives: &[Native]) -> Result<Translation, TranslateError> {
    let module = naga::front::wgsl::parse_str(wgsl).map_err(|error| TranslateError::parse(wgsl, &error))?;
    // What WGSL has without extensions; `pack2x16float` is an extension to naga alone.
    let info = Validator::new(ValidationFlags::all(), Capabilities::SHADER_FLOAT16_IN_FLOAT32)
        .validate(&module)
        .map_err(|error| TranslateError::validation(wgsl, &error))?;
    module::translate(wgsl, &module, &info, natives).map_err(|unsupported| unsupported.at(wgsl))
}
