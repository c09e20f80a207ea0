//! Writes the project's own scenes: `cargo run --release -p midway-import --example make_scenes -- scenes`.
//!
//! The Cornell box is from the measurements that Cornell University's Program of Computer Graphics
//! publishes; lengths are theirs, about a millimetre. Radiance is linear Rec. 709.

use std::{collections::HashMap, fs, io, path::Path};

use glam::{DVec3, Vec3, dvec3};
use midway_scene::Camera;
use serde_json::{Value, json};

const WHITE: [f64; 3] = [0.73, 0.73, 0.73];
const RED: [f64; 3] = [0.63, 0.065, 0.05];
const GREEN: [f64; 3] = [0.14, 0.45, 0.091];
/// Corners of a quadrilateral, in order around it.
type Quad = [DVec3; 4];
/// 20 480 triangles with smooth normals: one more level is four times the file and no other caustic.
const SPHERE_SUBDIVISIONS: usize = 5;

fn main() -> io::Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "scenes".to_owned());
    let folder = Path::new(&folder);
    fs::create_dir_all(folder)?;

    let mut cornell = cornell_box();
    add_blocks(&mut cornell);
    let ceiling_light = horizontal(278.0, 279.5, 65.0, 52.5, 548.3);
    cornell.add("light", quads(&[ceiling_light], Front::Along(DVec3::NEG_Y)), emitter([17.0, 12.0, 4.0]));
    cornell.save(folder, "cornell-box")?;

    let mut caustic = cornell_box();
    caustic.add("glass sphere", sphere(dvec3(278.0, 150.0, 280.0), 100.0), glass());
    let small_light = horizontal(278.0, 279.5, 10.0, 10.0, 548.3);
    caustic.add("light", quads(&[small_light], Front::Along(DVec3::NEG_Y)), emitter([600.0, 420.0, 140.0]));
    caustic.save(folder, "glass-caustic")?;

    let mut lamp = cornell_box();
    add_blocks(&mut lamp);
    lamp.add("shade", quads(&shade(), Front::From(dvec3(186.0, 240.0, 168.0))), diffuse(WHITE, true));
    let bulb = horizontal(186.0, 168.0, 30.0, 30.0, 170.0);
    lamp.add("light", quads(&[bulb], Front::Along(DVec3::Y)), emitter([255.0, 180.0, 60.0]));
    lamp.save(folder, "lamp")?;

    let mut glass_and_mirror = cornell_box();
    let [_, tall] = blocks();
    glass_and_mirror.add("mirror block", tall, mirror());
    glass_and_mirror.add("glass sphere", sphere(dvec3(170.0, 90.0, 180.0), 90.0), glass());
    glass_and_mirror.add(
        "light",
        quads(&[ceiling_light], Front::Along(DVec3::NEG_Y)),
        emitter([17.0, 12.0, 4.0]),
    );
    glass_and_mirror.save(folder, "cornell-glass-mirror")?;

    exterior().save(folder, "exterior")
}

/// The blocks on open ground under a light as wide as the sky: nearly all light comes straight from it.
fn exterior() -> Document {
    let mut document = Document::new();
    let ground = horizontal(278.0, 279.5, 3000.0, 3000.0, 0.0);
    document.add("ground", quads(&[ground], Front::Along(DVec3::Y)), diffuse([0.4, 0.36, 0.3], true));
    add_blocks(&mut document);
    let sky = horizontal(278.0, 279.5, 4000.0, 4000.0, 3000.0);
    document.add("light", quads(&[sky], Front::Along(DVec3::NEG_Y)), emitter([1.1, 1.2, 1.4]));
    document.look(dvec3(278.0, 400.0, -800.0), dvec3(278.0, 120.0, 250.0), 39.3077_f64.to_radians());
    document
}

/// The empty box with its camera.
fn cornell_box() -> Document {
    let walls = [
        (
            "floor",
            [(552.8, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 559.2), (549.6, 0.0, 559.2)],
            DVec3::Y,
            WHITE,
        ),
        (
            "ceiling",
            [(556.0, 548.8, 0.0), (556.0, 548.8, 559.2), (0.0, 548.8, 559.2), (0.0, 548.8, 0.0)],
            DVec3::NEG_Y,
            WHITE,
        ),
        (
            "back",
            [(549.6, 0.0, 559.2), (0.0, 0.0, 559.2), (0.0, 548.8, 559.2), (556.0, 548.8, 559.2)],
            DVec3::NEG_Z,
            WHITE,
        ),
        (
            "right",
            [(0.0, 0.0, 559.2), (0.0, 0.0, 0.0), (0.0, 548.8, 0.0), (0.0, 548.8, 559.2)],
            DVec3::X,
            GREEN,
        ),
        (
            "left",
            [(552.8, 0.0, 0.0), (549.6, 0.0, 559.2), (556.0, 548.8, 559.2), (556.0, 548.8, 0.0)],
            DVec3::NEG_X,
            RED,
        ),
    ];
    let mut document = Document::new();
    for (name, corners, front, colour) in walls {
        let quad = corners.map(|(x, y, z)| dvec3(x, y, z));
        document.add(name, quads(&[quad], Front::Along(front)), diffuse(colour, true));
    }
    document.look(dvec3(278.0, 273.0, -800.0), dvec3(278.0, 273.0, 0.0), 39.3077_f64.to_radians());
    document
}

fn add_blocks(document: &mut Document) {
    let [short, tall] = blocks();
    document.add("short block", short, diffuse(WHITE, true));
    document.add("tall block", tall, diffuse(WHITE, true));
}

/// The short block and the tall one.
fn blocks() -> [Shape; 2] {
    let short = block([(130.0, 65.0), (82.0, 225.0), (240.0, 272.0), (290.0, 114.0)], 165.0);
    let tall = block([(423.0, 247.0), (265.0, 296.0), (314.0, 456.0), (472.0, 406.0)], 330.0);
    let outward = |x, y, z| Front::From(dvec3(x, y, z));
    [quads(&short, outward(185.0, 82.0, 169.0)), quads(&tall, outward(368.0, 165.0, 351.0))]
}

/// A block's top and sides, from its measured top corners (x, z).
fn block(top: [(f64, f64); 4], height: f64) -> Vec<Quad> {
    let mut faces = vec![top.map(|(x, z)| dvec3(x, height, z))];
    for i in 0..4 {
        let ((x0, z0), (x1, z1)) = (top[i], top[(i + 1) % 4]);
        faces.push([dvec3(x0, 0.0, z0), dvec3(x0, height, z0), dvec3(x1, height, z1), dvec3(x1, 0.0, z1)]);
    }
    faces
}

/// Four walls around a lamp on the short block, open above.
fn shade() -> Vec<Quad> {
    let (x0, x1, z0, z1, y0, y1) = (141.0, 231.0, 123.0, 213.0, 165.0, 315.0);
    let wall = |xa, za, xb, zb| [dvec3(xa, y0, za), dvec3(xb, y0, zb), dvec3(xb, y1, zb), dvec3(xa, y1, za)];
    vec![wall(x0, z0, x1, z0), wall(x0, z1, x1, z1), wall(x0, z0, x0, z1), wall(x1, z0, x1, z1)]
}

/// A rectangle about a centre at a height.
fn horizontal(x: f64, z: f64, half_x: f64, half_z: f64, y: f64) -> Quad {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(a, b)| dvec3(x + a * half_x, y, z + b * half_z))
}

fn diffuse(colour: [f64; 3], double_sided: bool) -> Value {
    let [r, g, b] = colour;
    json!({
        "doubleSided": double_sided,
        "pbrMetallicRoughness":
            {"baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0},
        "extensions": {"KHR_materials_specular": {"specularFactor": 0.0}},
    })
}

/// Black, and emits from its front.
fn emitter(radiance: [f64; 3]) -> Value {
    let strength = radiance.into_iter().fold(0.0, f64::max);
    let mut material = diffuse([0.0; 3], false);
    material["emissiveFactor"] = json!(radiance.map(|c| c / strength));
    material["extensions"]["KHR_materials_emissive_strength"] = json!({"emissiveStrength": strength});
    material
}

fn glass() -> Value {
    json!({
        "pbrMetallicRoughness":
            {"baseColorFactor": [1.0, 1.0, 1.0, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.0},
        "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1.0},
            "KHR_materials_ior": {"ior": 1.5},
            "KHR_materials_volume": {"thicknessFactor": 1.0},
        },
    })
}

fn mirror() -> Value {
    json!({
        "pbrMetallicRoughness":
            {"baseColorFactor": [0.95, 0.95, 0.95, 1.0], "metallicFactor": 1.0, "roughnessFactor": 0.0},
        "extensions": {},
    })
}

/// Vertices, with normals where it is not flat.
struct Shape {
    positions: Vec<DVec3>,
    normals: Option<Vec<DVec3>>,
    triangles: Vec<[u32; 3]>,
}

/// Which side of a quadrilateral is its front.
#[derive(Clone, Copy)]
enum Front {
    /// The one that faces this way.
    Along(DVec3),
    /// The one that faces away from this point.
    From(DVec3),
}

fn quads(quads: &[Quad], front: Front) -> Shape {
    let mut shape = Shape { positions: Vec::new(), normals: None, triangles: Vec::new() };
    for quad in quads {
        let wanted = match front {
            Front::Along(direction) => direction,
            Front::From(point) => quad.iter().sum::<DVec3>() / 4.0 - point,
        };
        let mut quad = *quad;
        if (quad[1] - quad[0]).cross(quad[2] - quad[0]).dot(wanted) < 0.0 {
            quad.reverse();
        }
        let first = shape.positions.len() as u32;
        shape.positions.extend(quad);
        shape.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i| first + i)));
    }
    shape
}

/// An icosahedron, each triangle cut into four so many times, with smooth normals.
fn sphere(centre: DVec3, radius: f64) -> Shape {
    let t = f64::midpoint(1.0, 5f64.sqrt());
    let mut directions: Vec<DVec3> = Vec::new();
    for turn in 0..3 {
        for (a, b) in [(-1.0, t), (1.0, t), (-1.0, -t), (1.0, -t)] {
            let corner = [dvec3(a, b, 0.0), dvec3(0.0, a, b), dvec3(b, 0.0, a)][turn];
            directions.push(corner.normalize());
        }
    }
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..SPHERE_SUBDIVISIONS {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                directions.push((directions[a as usize] + directions[b as usize]).normalize());
                directions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    let positions = directions.iter().map(|d| centre + *d * radius).collect();
    Shape { positions, normals: Some(directions), triangles }
}

/// A glTF document in the making.
struct Document {
    json: Value,
    buffer: Vec<u8>,
}

impl Document {
    fn new() -> Self {
        let json = json!({
            "asset": {
                "version": "2.0",
                "generator": "midway make_scenes",
                "copyright": "CC0 1.0; measurements by Cornell University Program of Computer Graphics",
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

    fn view(&mut self, bytes: impl IntoIterator<Item = [u8; 4]>, target: u32) -> usize {
        let offset = self.buffer.len();
        self.buffer.extend(bytes.into_iter().flatten());
        let length = self.buffer.len() - offset;
        let view = json!({"buffer": 0, "byteOffset": offset, "byteLength": length, "target": target});
        self.push("bufferViews", view)
    }

    fn vectors(&mut self, vectors: &[DVec3]) -> usize {
        const ARRAY_BUFFER: u32 = 34962;
        let floats: Vec<[f32; 3]> = vectors.iter().map(|v| v.as_vec3().to_array()).collect();
        let view = self.view(floats.as_flattened().iter().map(|x| x.to_le_bytes()), ARRAY_BUFFER);
        let extreme = |pick: fn(f32, f32) -> f32| {
            floats.iter().copied().reduce(|a, b| [0, 1, 2].map(|i| pick(a[i], b[i])))
        };
        let accessor = json!({
            "bufferView": view, "componentType": 5126, "count": floats.len(), "type": "VEC3",
            "min": extreme(f32::min), "max": extreme(f32::max),
        });
        self.push("accessors", accessor)
    }

    fn add(&mut self, name: &str, shape: Shape, mut material: Value) {
        const ELEMENT_ARRAY_BUFFER: u32 = 34963;
        let mut attributes = json!({"POSITION": self.vectors(&shape.positions)});
        if let Some(normals) = &shape.normals {
            attributes["NORMAL"] = json!(self.vectors(normals));
        }
        let indices = shape.triangles.as_flattened();
        let view = self.view(indices.iter().map(|i| i.to_le_bytes()), ELEMENT_ARRAY_BUFFER);
        let accessor =
            json!({"bufferView": view, "componentType": 5125, "count": indices.len(), "type": "SCALAR"});
        let indices = self.push("accessors", accessor);
        for extension in material["extensions"].as_object().expect("every material has some").keys() {
            let used = self.json["extensionsUsed"].as_array_mut().expect("made in new()");
            if !used.contains(&json!(extension)) {
                used.push(json!(extension));
            }
        }
        material["name"] = json!(name);
        let material = self.push("materials", material);
        let primitive = json!({"attributes": attributes, "indices": indices, "material": material});
        let mesh = self.push("meshes", json!({"name": name, "primitives": [primitive]}));
        self.add_node(json!({"name": name, "mesh": mesh}));
    }

    fn look(&mut self, eye: DVec3, target: DVec3, yfov: f64) {
        let placed = Camera::look_at(eye.as_vec3(), target.as_vec3(), Vec3::Y, yfov as f32)
            .expect("the eye is not at the target");
        let perspective = json!({"yfov": yfov, "aspectRatio": 1.0, "znear": 0.01});
        let camera = self.push("cameras", json!({"type": "perspective", "perspective": perspective}));
        let matrix = placed.world_from_camera.to_cols_array().map(|x| x + 0.0);
        self.add_node(json!({"name": "camera", "camera": camera, "matrix": matrix}));
    }

    fn save(mut self, folder: &Path, name: &str) -> io::Result<()> {
        let binary = format!("{name}.bin");
        self.json["buffers"] = json!([{"uri": binary, "byteLength": self.buffer.len()}]);
        fs::write(folder.join(binary), &self.buffer)?;
        let text = serde_json::to_string_pretty(&self.json)? + "\n";
        fs::write(folder.join(format!("{name}.gltf")), text)
    }
}
