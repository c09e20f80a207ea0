//! A Draco stream: positions are its attribute 0 or 1.
#![no_main]

const MORE: &str = r#""bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":DATA}],
    "accessors":[{"componentType":5126,"count":COUNT,"type":"VEC3"}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"extensions":{"KHR_draco_mesh_compression":
        {"bufferView":1,"attributes":{"POSITION":ATTRIBUTE}}}}]}]"#;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((&[count, attribute], stream)) = data.split_first_chunk() else { return };
    let more = MORE.replace("COUNT", &count.to_string()).replace("ATTRIBUTE", &(attribute & 1).to_string());
    midway_fuzz::load(&[("scene.glb", &midway_fuzz::glb(&more, stream))]);
});
