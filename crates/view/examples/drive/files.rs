//! Small files for uploads: a scene with variants of its materials, a sky, and what is neither.

use serde_json::json;

/// The files of one upload; the first is to be opened.
pub fn files(which: u32) -> Vec<(&'static str, Vec<u8>)> {
    match which {
        0 => scene(),
        1 => vec![("sky.hdr", sky())],
        _ => vec![("broken.glb", b"glTF, but not really".to_vec())],
    }
}

/// A triangle that glows red, blue in a variant.
fn scene() -> Vec<(&'static str, Vec<u8>)> {
    let positions = [-9.0f32, -9.0, -2.0, 9.0, -9.0, -2.0, 0.0, 9.0, -2.0];
    let bytes: Vec<u8> = positions.into_iter().flat_map(f32::to_le_bytes).collect();
    let mappings = [0, 1].map(|i| json!({ "material": i, "variants": [i] }));
    let document = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_materials_variants"],
        "extensions": { "KHR_materials_variants": { "variants": [{ "name": "Red" }, { "name": "Blue" }] } },
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "mesh": 0 }, { "camera": 0 }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0,
            "extensions": { "KHR_materials_variants": { "mappings": mappings } } }] }],
        "materials": [{ "emissiveFactor": [1, 0, 0] }, { "emissiveFactor": [0, 0, 1] }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
        "bufferViews": [{ "buffer": 0, "byteLength": bytes.len() }],
        "buffers": [{ "byteLength": bytes.len(), "uri": "glow.bin" }],
    });
    vec![("glow.gltf", document.to_string().into_bytes()), ("glow.bin", bytes)]
}

/// In RGBE, by rows that are not compressed.
fn sky() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    bytes.extend([64, 128, 192, 129].repeat(32));
    bytes
}
