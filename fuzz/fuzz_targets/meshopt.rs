//! A meshopt stream of any mode and filter.
#![no_main]

const MORE: &str = r#""bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteLength":4,"extensions":
        {"EXT_meshopt_compression":{"buffer":0,"byteOffset":36,"byteLength":DATA,"byteStride":STRIDE,"count":COUNT,
        "mode":"MODE","filter":"FILTER"}}}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]"#;
const MODES: [&str; 3] = ["ATTRIBUTES", "TRIANGLES", "INDICES"];
const FILTERS: [&str; 4] = ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"];

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((&[mode, filter, stride, low, high], stream)) = data.split_first_chunk() else { return };
    let more = MORE
        .replace("MODE", MODES[usize::from(mode) % 3])
        .replace("FILTER", FILTERS[usize::from(filter) % 4])
        .replace("STRIDE", &stride.to_string())
        .replace("COUNT", &u16::from_le_bytes([low, high]).to_string());
    midway_fuzz::load(&[("scene.glb", &midway_fuzz::glb(&more, stream))]);
});
