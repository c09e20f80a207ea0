//! Mitsuba's XML, beside which lie a mesh and a material library of its own.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    midway_fuzz::load(&[("scene.xml", data), ("m.obj", midway_fuzz::OBJ), ("m.ply", midway_fuzz::PLY)]);
});
