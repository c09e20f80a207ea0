//! pbrt of either version, beside which lies a mesh.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    midway_fuzz::load(&[("scene.pbrt", data), ("m.ply", midway_fuzz::PLY)]);
});
