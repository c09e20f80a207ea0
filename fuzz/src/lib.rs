//! What the fuzz targets share: bytes become a scene in a folder of the process's own, and are read.

use std::{fs, path::PathBuf};

/// A triangle, for scenes that name a mesh.
pub const PLY: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
/// The same.
pub const OBJ: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// Files in a folder, the first of which is a scene that is read. Whatever comes of it, it is no
/// panic, no hang and no allocation beyond what the files justify.
pub fn load(files: &[(&str, &[u8])]) {
    let folder = folder();
    for (name, bytes) in files {
        fs::write(folder.join(name), bytes).expect("the folder is there");
    }
    if let Some((scene, _)) = files.first() {
        let (result, warnings) = midway_import::load_with(&folder.join(scene), &midway_import::Options::default());
        let lines = warnings.iter().map(ToString::to_string).chain(result.err().map(|e| e.to_string()));
        lines.for_each(|line| assert!(!line.contains(char::is_control), "{line:?}"));
    }
}

/// In memory where the system has such a place.
fn folder() -> PathBuf {
    let memory = PathBuf::from("/dev/shm");
    let root = if memory.is_dir() { memory } else { std::env::temp_dir() };
    let folder = root.join(format!("midway-fuzz-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder can be made");
    folder
}

/// A GLB of a triangle whose JSON says `more` and whose buffer, after the triangle's 36 bytes,
/// holds `data`: view 1.
pub fn glb(more: &str, data: &[u8]) -> Vec<u8> {
    let positions = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut binary: Vec<u8> = positions.iter().flat_map(|x| x.to_le_bytes()).collect();
    binary.extend(data);
    let n = data.len();
    let mut text = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],"buffers":[{{"byteLength":{}}}],{}}}"#,
        binary.len(),
        more.replace("DATA", &n.to_string()),
    )
    .into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((text.len() as u32 + binary.len() as u32 + 28).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

/// The bytes as an image on a triangle.
pub fn load_image(data: &[u8]) {
    const MORE: &str = r#""bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":DATA}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
        "images":[{"bufferView":1}],"textures":[{"source":0}],
        "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}},"normalTexture":{"index":0}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}]"#;
    load(&[("scene.glb", &glb(MORE, data))]);
}
