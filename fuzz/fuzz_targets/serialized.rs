//! Mitsuba's binary meshes: the mesh's index, then the file.
#![no_main]

const SCENE: &str = "<scene version='3.0.0'><shape type='serialized'><string name='filename' value='m.serialized'/>\
    <integer name='shape_index' value='INDEX'/></shape></scene>";

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((&index, meshes)) = data.split_first() else { return };
    let scene = SCENE.replace("INDEX", &(index as i8).to_string());
    midway_fuzz::load(&[("scene.xml", scene.as_bytes()), ("m.serialized", meshes)]);
});
