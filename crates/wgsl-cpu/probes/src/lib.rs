//! Small WGSL kernels that prove `wgsl-cpu`: each is run natively, and on a GPU, and compared.

pub mod by_hand;
pub mod cases;
pub mod scene;
pub mod words;

use wgsl_cpu::Kernel;

/// A library: functions without an entry point.
#[allow(unused, unused_qualifications, nonstandard_style, missing_docs, clippy::all)]
pub mod library {
    include!(concat!(env!("OUT_DIR"), "/library.rs"));
}

/// Takes in a translated probe and makes its record.
macro_rules! probes {
    ($($(#[$doc:meta])* $name:ident $record:ident;)*) => {
        $(
            $(#[$doc])*
            #[allow(unused, unused_qualifications, nonstandard_style, missing_docs, clippy::all)]
            pub mod $name {
                include!(concat!(env!("OUT_DIR"), "/", stringify!($name), ".rs"));
            }

            $(#[$doc])*
            pub static $record: Kernel = Kernel {
                name: stringify!($name),
                wgsl: include_str!(concat!("../wgsl/", stringify!($name), ".wgsl")),
                bindings: $name::BINDINGS,
                workgroup_size: $name::WORKGROUP_SIZE,
                workgroup_override: $name::WORKGROUP_OVERRIDE,
                native: $name::entry,
            };
        )*

        /// All probes.
        pub static KERNELS: &[&Kernel] = &[$(&$record),*];
    };
}

probes! {
    /// Closest hit of rays with triangles in a BVH2, while-while.
    traverse TRAVERSE;
    /// Integer semantics.
    integers INTEGERS;
    /// Float semantics.
    floats FLOATS;
    /// Functions that may be off by some ulps.
    transcendentals TRANSCENDENTALS;
    /// Vectors and matrices.
    vectors VECTORS;
    /// Packing.
    packing PACKING;
    /// Statements.
    control CONTROL;
    /// Layouts in buffers.
    layouts LAYOUTS;
    /// Atomics.
    atomics ATOMICS;
}
