//! Compressed geometry and textures of the collection beside the repository, against what they
//! were made from.

mod common;

use std::{
    fs,
    path::{Path, PathBuf},
};

use common::{Folder, data_uri, load_json, textured};
use glam::vec3;
use midway_import::load;
use midway_scene::{Scene, Texels};
use serde_json::json;

/// None, and a word about it, where the collection is absent.
fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes/gltf").join(name);
    if !path.exists() {
        println!("did not run: there is no {name} in ../shared/scenes/gltf");
        return None;
    }
    Some(path)
}

fn scene(path: &Path) -> Scene {
    let import = load(path).unwrap_or_else(|e| panic!("{e}"));
    let damaged = import.warnings.iter().find(|w| w.message.contains("damaged"));
    assert!(damaged.is_none(), "{damaged:?}");
    import.scene
}

/// The same file with its uncompressed stand-in, which is there for those who lack the extension
/// (its normals are as they were before the filter: they are looked at on a box).
#[test]
fn meshopt_comes_to_its_fallback() {
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let Some(folder) = shared(&format!("gltf-pipeline/extensions/{name}/meshopt-fallback")) else {
            return;
        };
        let copy = Folder::new();
        for entry in fs::read_dir(&folder).unwrap().flatten() {
            copy.write(entry.file_name().to_str().unwrap(), fs::read(entry.path()).unwrap());
        }
        let text = fs::read_to_string(copy.path("meshopt-fallback.gltf")).unwrap();
        let plain = copy.write("plain.gltf", text.replace(name, "EXT_unknown"));
        let (compressed, plain) = (scene(&copy.path("meshopt-fallback.gltf")), scene(&plain));
        assert_eq!(compressed.meshes.len(), plain.meshes.len());
        for (a, b) in compressed.meshes.iter().zip(&plain.meshes) {
            assert_eq!(a.positions, b.positions);
            // Which of its corners a triangle begins with is the encoder's to choose.
            let turned = |t: &[u32; 3]| {
                let least = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
                [0, 1, 2].map(|i| t[(least + i) % 3])
            };
            assert!(a.triangles.iter().map(turned).eq(b.triangles.iter().map(turned)));
        }
    }
    let Some(bare) = shared("gltf-transform/extensions/BoxMeshopt.glb") else { return };
    is_a_box(&scene(&bare));
}

/// A cube with sides of 1 about the origin.
fn is_a_box(scene: &Scene) {
    assert_eq!(scene.counts().triangles, 12);
    let bounds = scene.bounds();
    // Positions are quantized.
    assert!(bounds.min.distance(vec3(-0.5, -0.5, -0.5)) <= 1e-3, "{bounds:?}");
    assert!(bounds.max.distance(vec3(0.5, 0.5, 0.5)) <= 1e-3, "{bounds:?}");
    for t in scene.world_triangles() {
        let normal = t.geometric_normal().unwrap();
        assert!(t.positions[0].dot(normal) > 0.4, "it faces inwards");
        assert!(t.normals.unwrap().iter().all(|n| n.dot(normal) >= 0.99));
    }
}

#[test]
fn draco_comes_to_a_box() {
    let Some(path) = shared("gltf-transform/extensions/BoxDraco.gltf") else { return };
    is_a_box(&scene(&path));
    let Some(heart) = shared("khronos/heart_draco.glb") else { return };
    assert_eq!(scene(&heart).counts().triangles, 180);
}

/// Both schemes of Basis Universal, from the same picture.
#[test]
fn basis_comes_to_its_picture() {
    let folder = "gltf-transform/extensions";
    let mut pictures = Vec::new();
    for name in ["2d_etc1s.ktx2", "2d_uastc.ktx2"] {
        let Some(path) = shared(&format!("{folder}/{name}")) else { return };
        let mut document = textured(json!({"uri": data_uri(&fs::read(path).unwrap())}));
        document["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]);
        document["extensionsRequired"] = json!(["KHR_texture_basisu"]);
        let import = load_json(&document).unwrap();
        assert_eq!(import.warnings, [], "{name}");
        let image = import.scene.images[0].clone();
        assert!(image.width > 1 && matches!(image.texels, Texels::Srgb8(_)));
        pictures.push(image);
    }
    let [a, b] = &pictures[..] else { panic!("two pictures") };
    assert_eq!((a.width, a.height), (b.width, b.height));
    let (mut error, mut spread) = (0.0, 0.0);
    for i in 0..a.texels.len() {
        let (a, b) = (a.texels.linear(i), b.texels.linear(i));
        error += (0..3).map(|c| (a[c] - b[c]).abs()).sum::<f32>();
        spread += (0..3).map(|c| (a[c] - 0.5).abs()).sum::<f32>();
    }
    // ETC1S is coarse; another picture would be off by as much as the values are spread.
    assert!(error <= 0.25 * spread, "{error} of {spread}");
    // In blocks of another kind: said, and done without.
    let Some(plain) = shared(&format!("{folder}/2d_bc1.ktx2")) else { return };
    let import = load_json(&textured(json!({"uri": data_uri(&fs::read(plain).unwrap())}))).unwrap();
    assert!(import.warnings[0].message.contains("KTX2"), "{:?}", import.warnings);
}

/// Each is a word in white on the same green, in plain texels: bytes of two layouts, halves and floats.
#[test]
fn plain_texels_are_read() {
    let folder = "gltf-transform/extensions";
    for name in ["2d_rgba8", "2d_rgb8", "2d_rgba16_linear", "2d_rgba32_linear"] {
        let Some(path) = shared(&format!("{folder}/{name}.ktx2")) else { return };
        let import = load_json(&textured(json!({"uri": data_uri(&fs::read(path).unwrap())}))).unwrap();
        assert_eq!(import.warnings, [], "{name}");
        let image = &import.scene.images[0];
        assert_eq!((image.width, image.height), (40, 40), "{name}");
        assert_eq!(matches!(image.texels, Texels::Float(_)), name.ends_with("linear"), "{name}");
        let is_green = |i: &usize| {
            let found = image.texels.linear(*i);
            // (77, 175, 74) of 255 by the sRGB curve, within half a step of 8 bits there.
            found.iter().zip([0.0742, 0.4287, 0.0685, 1.0]).all(|(a, b)| (a - b).abs() < 2e-3)
        };
        let greens = (0..image.texels.len()).filter(is_green).count();
        assert!(greens > image.texels.len() / 2, "{name}: {greens}");
    }
}
