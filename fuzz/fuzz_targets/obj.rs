//! Geometry, a zero byte, and a material library.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let end = data.iter().position(|&b| b == 0).unwrap_or(data.len());
    let (geometry, materials) = data.split_at(end);
    let materials = materials.strip_prefix(&[0]).unwrap_or_default();
    midway_fuzz::load(&[("scene.obj", geometry), ("m.mtl", materials)]);
});
