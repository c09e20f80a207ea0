//! Damaged files of every kind: whatever comes of them, it is no panic and no hang. For a second
//! each, or as many as `MIDWAY_FUZZ_SECONDS` says; `fuzz/` does the same guided by coverage.

mod common;

use std::{
    env, fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use common::{Folder, glb, image_bytes, textured, triangle, triangle_bytes};
use image::ImageFormat;
use midway_import::{Options, load_with};
use serde_json::{Value, json};

/// What a damaged small file may take, beside other tests.
const SLOWEST: Duration = Duration::from_secs(10);

/// Marsaglia's xorshift with 64 bits.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 16) as usize % n.max(1)
    }
}

/// Values at which readers go wrong.
const ODD: [u8; 8] = [0, 1, 0x7f, 0x80, 0xff, b'9', b'-', b'"'];

/// A few bytes changed, cut out, doubled, or replaced by others of the file.
fn damage(seed: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..=random.below(4) {
        if bytes.is_empty() {
            break;
        }
        let at = random.below(bytes.len());
        let end = (at + 1 + random.below(8)).min(bytes.len());
        match random.below(6) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at..end].fill(ODD[random.below(ODD.len())]),
            2 => drop(bytes.drain(at..end)),
            3 => {
                let doubled = bytes[at..end].to_vec();
                bytes.splice(at..at, doubled);
            }
            4 => {
                let from = random.below(bytes.len() - (end - at) + 1);
                bytes.copy_within(from..from + (end - at), at);
            }
            _ => bytes.truncate(at),
        }
    }
    bytes
}

/// Damages seeds again and again, makes files of what comes of each, and reads the first.
fn survive(name: &str, seeds: &[Vec<u8>], files: impl Fn(&[u8]) -> Vec<(&'static str, Vec<u8>)>) {
    assert!(!seeds.is_empty());
    let seconds = env::var("MIDWAY_FUZZ_SECONDS").ok().and_then(|s| s.parse().ok()).unwrap_or(1);
    let (start, folder) = (Instant::now(), Folder::new());
    let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ name.len() as u64);
    let (mut n, mut n_loaded) = (0u64, 0u64);
    while start.elapsed() < Duration::from_secs(seconds) {
        let bytes = damage(&seeds[random.below(seeds.len())], &mut random);
        let paths: Vec<PathBuf> = files(&bytes).into_iter().map(|(name, b)| folder.write(name, b)).collect();
        // A panic's or a hang's cause is found again.
        let keep = env::temp_dir().join(format!("midway-damaged-{name}"));
        fs::write(&keep, &bytes).unwrap();
        let call = Instant::now();
        let (result, _) = load_with(&paths[0], &Options::default());
        assert!(call.elapsed() <= SLOWEST, "{} took {:?}", keep.display(), call.elapsed());
        match result {
            Ok(_) => n_loaded += 1,
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
        fs::remove_file(keep).unwrap();
        n += 1;
    }
    println!("{name}: {n} damaged files, {n_loaded} of them loaded all the same");
}

/// Files of the collection beside the repository, where it is there.
fn shared(names: &[&str]) -> Vec<Vec<u8>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes/gltf");
    names.iter().filter_map(|name| fs::read(root.join(name)).ok()).collect()
}

fn pixels(format: ImageFormat) -> Vec<u8> {
    let texels: Vec<[u8; 4]> = (0..60u8).map(|i| [i * 4, 255 - i, i ^ 85, 200]).collect();
    image_bytes(&texels, 10, format)
}

/// A GLB with a second view, of `data`.
fn with_data(mut document: Value, view: Value, data: &[u8]) -> Vec<u8> {
    let mut binary = triangle_bytes();
    binary.resize(104, 0);
    binary.extend(data);
    document["buffers"] = json!([{"byteLength": binary.len()}]);
    document["bufferViews"][4] = view;
    glb(&document, &binary)
}

fn image_in_glb(data: &[u8]) -> Vec<(&'static str, Vec<u8>)> {
    let mut document = textured(json!({"bufferView": 4}));
    document["bufferViews"].as_array_mut().unwrap().push(json!({}));
    let view = json!({"buffer": 0, "byteOffset": 104, "byteLength": data.len()});
    vec![("scene.glb", with_data(document, view, data))]
}

#[test]
fn gltf_and_glb() {
    let mut document = textured(json!({"uri": "a.png"}));
    document["animations"] = json!([{"channels": [], "samplers": []}]);
    document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {}}]}});
    document["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0},
        "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}});
    document["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
    document["meshes"][0]["weights"] = json!([0.5]);
    survive("gltf", &[document.to_string().into_bytes()], |bytes| vec![("scene.gltf", bytes.to_vec())]);
    let mut binary = triangle();
    binary["buffers"] = json!([{"byteLength": 78}]);
    let seeds = [glb(&binary, &triangle_bytes())];
    survive("glb", &seeds, |bytes| vec![("scene.glb", bytes.to_vec())]);
}

#[test]
fn obj_and_mtl() {
    let geometry = "mtllib m.mtl\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 1\nvn 0 0 1\no a\ns 1\nusemtl a\n\
        f 1/1/1 2/2/1 3/1/1\ns off\nusemtl b\nf -4 -3 -2 -1\nl 1 2\n";
    survive("obj", &[geometry.into()], |bytes| vec![("a.obj", bytes.to_vec())]);
    let library = "newmtl a\nKd 0.5 0.4 0.3\nKs 0.1\nNs 50\nillum 2\nKe 1 2 3\nd 0.5\nmap_Kd -s 2 2 -o 0.5 0 -clamp on a.tga\n\
        norm -bm 0.5 n.png\nnewmtl b\nPr 0.2\nPm 1\nPs 0.1\nPc 0.3\nPcr 0.1\naniso 0.2\nNi 1.4\nTf 1 1 1\n";
    survive("mtl", &[library.into()], |bytes| vec![("a.obj", geometry.into()), ("m.mtl", bytes.to_vec())]);
    // TGA begins with nothing in particular: it is known by its name alone.
    survive("tga", &[pixels(ImageFormat::Tga)], |bytes| {
        vec![("a.obj", geometry.into()), ("m.mtl", library.into()), ("a.tga", bytes.to_vec())]
    });
}

#[test]
fn ply() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        property float u\nproperty float v\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n0 0 0 0 0 255 0 0\n1 0 0 1 0 0 255 0\n1 1 0 1 1 0 0 255\n\
        0 1 0 0 1 9 9 9\n4 0 1 2 3\n";
    let mut binary =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
            .to_vec();
    binary.extend(&triangle_bytes()[..36]);
    binary.extend([4i32, 0, 1, 2, -1].iter().flat_map(|i| i.to_le_bytes()));
    survive("ply", &[text.into(), binary], |bytes| vec![("a.ply", bytes.to_vec())]);
}

#[test]
fn images() {
    let formats = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP, ImageFormat::Bmp];
    survive("image", &formats.map(pixels), image_in_glb);
    survive("hdr", &[pixels(ImageFormat::Hdr)], image_in_glb);
    survive("exr", &[pixels(ImageFormat::OpenExr)], image_in_glb);
}

#[test]
fn compressed_things() {
    let root = "gltf-transform/extensions";
    let textures = ["etc1s", "uastc", "rgba8", "rgba16_linear"].map(|kind| format!("{root}/2d_{kind}.ktx2"));
    let textures = shared(&textures.each_ref().map(String::as_str));
    let streams = shared(&[&format!("{root}/0.bin")]);
    let meshopt = shared(&[&format!("{root}/BoxMeshopt.glb")]);
    if textures.is_empty() || streams.is_empty() || meshopt.is_empty() {
        println!("did not run: there is no {root} in ../shared/scenes/gltf");
        return;
    }
    survive("ktx", &textures, image_in_glb);
    survive("meshopt", &meshopt, |bytes| vec![("a.glb", bytes.to_vec())]);
    survive("draco", &streams, |bytes| {
        let mut document = triangle();
        document["bufferViews"].as_array_mut().unwrap().extend([json!({}), json!({})]);
        document["accessors"] = json!([{"componentType": 5126, "count": 24, "type": "VEC3"}]);
        document["meshes"][0]["primitives"] = json!([{"attributes": {"POSITION": 0}, "extensions":
            {"KHR_draco_mesh_compression": {"bufferView": 4, "attributes": {"POSITION": 1}}}}]);
        let view = json!({"buffer": 0, "byteOffset": 104, "byteLength": bytes.len()});
        vec![("a.glb", with_data(document, view, bytes))]
    });
}
