//! Midway's kernels: WGSL, its native translation, and its layouts. No GPU API is in here.
//!
//! `wgsl/` has one file for each kernel, `wgsl/lib/` the pure functions they share, `wgsl/bindings/`
//! the buffers with their accessors, `wgsl/probes/` kernels that only tests run. The build script
//! links, validates and translates them; [`layout`] and [`constants`] are generated from the WGSL.

mod traversal;

use wgsl_cpu::Kernel;

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));

/// Curves of directional albedos, which the buffer `scene` starts with: vec4 of f32, little-endian, in
/// the order of `wgsl/lib/albedo.wgsl`. Made and checked by `tests/src/albedo.rs`.
pub static ALBEDO_TABLES: &[u8] = include_bytes!("albedo.bin");

/// The kernel of that name.
///
/// # Panics
///
/// If there is none: names are written in the source, never read from input.
pub fn kernel(name: &str) -> &'static Kernel {
    KERNELS.iter().find(|kernel| kernel.name == name).unwrap_or_else(|| panic!("no kernel is called {name}"))
}

/// Structs of uniform buffers.
pub mod layout {
    include!(concat!(env!("OUT_DIR"), "/layout.rs"));
}

/// Constants of the WGSL.
pub mod constants {
    include!(concat!(env!("OUT_DIR"), "/constants.rs"));
}

/// The pure functions of `wgsl/lib`, translated: for tests, and for hosts that need the same maths.
pub mod native {
    #[allow(unused, nonstandard_style, missing_docs, clippy::all, clippy::undocumented_unsafe_blocks)]
    #[doc(hidden)]
    pub mod lib {
        include!(concat!(env!("OUT_DIR"), "/lib.rs"));
    }

    /// Two halves (IEEE binary16) as `unpack2x16float` reads them, the first in the low bits.
    pub fn pack_halves(low: f32, high: f32) -> u32 {
        wgsl_cpu::runtime::pack2x16float(wgsl_cpu::runtime::Vec2::new(low, high))
    }

    /// Four uniform numbers in [0, 1) for a counter: what kernels draw.
    pub fn random4(index: u32, sample: u32, dimension: u32, seed: u32) -> [f32; 4] {
        let u = lib::unit_float(lib::draw_bits(index, sample, dimension, seed));
        [u.x, u.y, u.z, u.w]
    }
}
