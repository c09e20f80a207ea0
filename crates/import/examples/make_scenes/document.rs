//! glTF documents, written.

use std::{fs, io, io::Cursor, path::Path};

use glam::{DQuat, DVec3, Vec3};
use image::{ImageFormat, RgbaImage};
use midway_scene::Camera;
use serde_json::{Value, json};

use crate::shape::Shape;

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// A glTF document in the making.
pub struct Document {
    json: Value,
    buffer: Vec<u8>,
}

impl Document {
    pub fn new(copyright: &str) -> Self {
        let json = json!({
            "asset": {
                "version": "2.0",
                "generator": "midway make_scenes",
                "copyright": copyright,
            },
            "extensionsUsed": [],
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [], "cameras": [], "meshes": [], "materials": [], "accessors": [], "bufferViews": [],
        });
        Self { json, buffer: Vec::new() }
    }

    /// Appends to a list and returns the index.
    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().expect("every list is made in new()");
        list.push(value);
        list.len() - 1
    }

    fn add_node(&mut self, node: Value) {
        let index = self.push("nodes", node);
        let roots = &mut self.json["scenes"][0]["nodes"];
        roots.as_array_mut().expect("made in new()").push(json!(index));
    }

    fn view(&mut self, bytes: impl IntoIterator<Item = [u8; 4]>, target: Option<u32>) -> usize {
        let offset = self.buffer.len();
        self.buffer.extend(bytes.into_iter().flatten());
        let length = self.buffer.len() - offset;
        let mut view = json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.push("bufferViews", view)
    }

    fn vectors(&mut self, vectors: &[DVec3]) -> usize {
        let floats: Vec<[f32; 3]> = vectors.iter().map(|v| v.as_vec3().to_array()).collect();
        let view = self.view(floats.as_flattened().iter().map(|x| x.to_le_bytes()), Some(ARRAY_BUFFER));
        let extreme = |pick: fn(f32, f32) -> f32| {
            floats.iter().copied().reduce(|a, b| [0, 1, 2].map(|i| pick(a[i], b[i])))
        };
        let accessor = json!({
            "bufferView": view, "componentType": 5126, "count": floats.len(), "type": "VEC3",
            "min": extreme(f32::min), "max": extreme(f32::max),
        });
        self.push("accessors", accessor)
    }

    /// A mesh's primitive, for any number of [`Document::place`].
    pub fn geometry(&mut self, shape: &Shape) -> Value {
        let mut attributes = json!({"POSITION": self.vectors(&shape.positions)});
        if let Some(normals) = &shape.normals {
            attributes["NORMAL"] = json!(self.vectors(normals));
        }
        if let Some(uvs) = &shape.uvs {
            let floats = uvs.as_flattened().iter().map(|x| (*x as f32).to_le_bytes());
            let view = self.view(floats, Some(ARRAY_BUFFER));
            let accessor =
                json!({"bufferView": view, "componentType": 5126, "count": uvs.len(), "type": "VEC2"});
            attributes["TEXCOORD_0"] = json!(self.push("accessors", accessor));
        }
        let indices = shape.triangles.as_flattened();
        let view = self.view(indices.iter().map(|i| i.to_le_bytes()), Some(ELEMENT_ARRAY_BUFFER));
        let accessor =
            json!({"bufferView": view, "componentType": 5125, "count": indices.len(), "type": "SCALAR"});
        json!({"attributes": attributes, "indices": self.push("accessors", accessor)})
    }

    pub fn add(&mut self, name: &str, shape: Shape, material: Value) {
        let primitive = self.geometry(&shape);
        self.place(name, primitive, material, DVec3::ZERO);
    }

    /// A mesh of one primitive, moved.
    pub fn place(&mut self, name: &str, mut primitive: Value, mut material: Value, to: DVec3) {
        for extension in material["extensions"].as_object().into_iter().flat_map(|e| e.keys()) {
            self.use_extension(extension);
        }
        material["name"] = json!(name);
        primitive["material"] = json!(self.push("materials", material));
        let mesh = self.push("meshes", json!({"name": name, "primitives": [primitive]}));
        let mut node = json!({"name": name, "mesh": mesh});
        if to != DVec3::ZERO {
            node["translation"] = json!(to.to_array());
        }
        self.add_node(node);
    }

    /// A light of `KHR_lights_punctual` at a place, shining along `direction` where it has one.
    pub fn light(&mut self, light: Value, at: DVec3, direction: DVec3) {
        const EXTENSION: &str = "KHR_lights_punctual";
        self.use_extension(EXTENSION);
        let lights = &mut self.json["extensions"][EXTENSION]["lights"];
        if lights.is_null() {
            *lights = json!([]);
        }
        let lights = lights.as_array_mut().expect("made just now");
        let name = light["name"].clone();
        lights.push(light);
        let index = lights.len() - 1;
        let rotation = DQuat::from_rotation_arc(DVec3::NEG_Z, direction.normalize());
        self.add_node(json!({
            "name": name, "translation": at.to_array(), "rotation": rotation.to_array(),
            "extensions": {EXTENSION: {"light": index}},
        }));
    }

    /// A texture of an image, for materials to refer to.
    pub fn texture(&mut self, name: &str, image: &RgbaImage) -> Value {
        let mut png = Cursor::new(Vec::new());
        image.write_to(&mut png, ImageFormat::Png).expect("PNG holds such pixels");
        let mut png = png.into_inner();
        let length = png.len();
        png.resize(length.next_multiple_of(4), 0);
        let view = self.view(png.as_chunks().0.iter().copied(), None);
        self.json["bufferViews"][view]["byteLength"] = json!(length);
        for list in ["images", "textures"] {
            if self.json[list].is_null() {
                self.json[list] = json!([]);
            }
        }
        let image = self.push("images", json!({"name": name, "bufferView": view, "mimeType": "image/png"}));
        json!({"index": self.push("textures", json!({"source": image}))})
    }

    fn use_extension(&mut self, extension: &str) {
        let used = self.json["extensionsUsed"].as_array_mut().expect("made in new()");
        if !used.contains(&json!(extension)) {
            used.push(json!(extension));
        }
    }

    pub fn look(&mut self, eye: DVec3, target: DVec3, yfov: f64, aspect: f64) {
        let placed = Camera::look_at(eye.as_vec3(), target.as_vec3(), Vec3::Y, yfov as f32)
            .expect("the eye is not at the target");
        let perspective = json!({"yfov": yfov, "aspectRatio": aspect, "znear": 0.01});
        let camera = self.push("cameras", json!({"type": "perspective", "perspective": perspective}));
        let matrix = placed.world_from_camera.to_cols_array().map(|x| x + 0.0);
        self.add_node(json!({"name": "camera", "camera": camera, "matrix": matrix}));
    }

    pub fn save(mut self, folder: &Path, name: &str) -> io::Result<()> {
        let binary = format!("{name}.bin");
        self.json["buffers"] = json!([{"uri": binary, "byteLength": self.buffer.len()}]);
        fs::write(folder.join(binary), &self.buffer)?;
        let text = serde_json::to_string_pretty(&self.json)? + "\n";
        fs::write(folder.join(format!("{name}.gltf")), text)
    }
}
