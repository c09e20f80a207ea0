//! Small scene files, made in a folder of their own.

#![allow(dead_code, reason = "each test file uses some of these")]

use std::{fs, path::PathBuf};

use base64::{Engine, engine::general_purpose::STANDARD};
use midway_import::{Import, ImportError, load};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A folder with a scene in it.
pub struct Folder(pub TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, bytes).unwrap();
        path
    }
}

pub fn load_bytes(name: &str, bytes: impl AsRef<[u8]>) -> Result<Import, ImportError> {
    let folder = Folder::new();
    let path = folder.write(name, bytes);
    load(&path)
}

pub fn load_json(document: &Value) -> Result<Import, ImportError> {
    load_bytes("scene.gltf", document.to_string())
}

/// Three vertices, three normals, and three indices of 16 bits.
pub fn triangle_bytes() -> Vec<u8> {
    let positions = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let normals = [0.0f32, 0.0, 1.0].repeat(3);
    let mut bytes: Vec<u8> = positions.iter().chain(&normals).flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2].iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

pub fn data_uri(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes))
}

/// One lit triangle and a camera; loads without a warning.
pub fn triangle() -> Value {
    let bytes = triangle_bytes();
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 3]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]}],
        "materials": [{
            "pbrMetallicRoughness": {"metallicFactor": 0},
            "emissiveFactor": [1, 1, 1],
            "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR"}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 36},
            {"buffer": 0, "byteOffset": 72, "byteLength": 6}],
        "buffers": [{"byteLength": 78, "uri": data_uri(&bytes)}],
    })
}

/// The triangle with one value changed, by JSON pointer.
pub fn triangle_with(pointer: &str, value: Value) -> Value {
    let mut document = triangle();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = document.pointer_mut(parent).unwrap_or_else(|| panic!("no {parent}"));
    match parent {
        Value::Array(array) => array[key.parse::<usize>().unwrap()] = value,
        parent => parent[key] = value,
    }
    document
}

/// A GLB of JSON and a buffer.
pub fn glb(document: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut chunks = Vec::new();
    for (kind, data) in [(b"JSON", &text[..]), (b"BIN\0", binary)] {
        chunks.extend((data.len() as u32).to_le_bytes());
        chunks.extend(kind);
        chunks.extend(data);
    }
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2u32.to_le_bytes());
    bytes.extend((chunks.len() as u32 + 12).to_le_bytes());
    bytes.extend(chunks);
    bytes
}

/// RGBA texels as a file.
pub fn image_bytes(texels: &[[u8; 4]], width: u32, format: image::ImageFormat) -> Vec<u8> {
    let height = texels.len() as u32 / width;
    let buffer = image::RgbaImage::from_raw(width, height, texels.concat()).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    let pixels = image::DynamicImage::from(buffer);
    match format {
        image::ImageFormat::Jpeg => pixels.to_rgb8().write_to(&mut bytes, format).unwrap(),
        image::ImageFormat::Hdr => pixels.to_rgb32f().write_to(&mut bytes, format).unwrap(),
        image::ImageFormat::OpenExr => pixels.to_rgba32f().write_to(&mut bytes, format).unwrap(),
        _ => pixels.write_to(&mut bytes, format).unwrap(),
    }
    bytes.into_inner()
}

/// The triangle with texture coordinates, and a material that has `texture` as its base colour,
/// of the image with this definition.
pub fn textured(image: Value) -> Value {
    let mut bytes = triangle_bytes();
    bytes.resize(80, 0);
    bytes.extend([[0.0f32, 0.0], [1.0, 0.0], [0.0, 1.0]].as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    let mut document = triangle();
    document["buffers"] = json!([{"byteLength": 104, "uri": data_uri(&bytes)}]);
    let view = json!({"buffer": 0, "byteOffset": 80, "byteLength": 24});
    document["bufferViews"].as_array_mut().unwrap().push(view);
    let accessor = json!({"bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC2"});
    document["accessors"].as_array_mut().unwrap().push(accessor);
    document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(3);
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    document["textures"] = json!([{"source": 0}]);
    document["images"] = json!([image]);
    document
}
