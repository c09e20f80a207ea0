//! Bad files give one clear line that says what, where and what to do; none panics or hangs.

mod common;

use std::{fs, path::Path, time::Instant};

use common::{Folder, data_uri, glb, load_bytes, load_json, triangle, triangle_bytes, triangle_with};
use midway_import::{ImportError, Options, load, load_with};
use midway_scene::Scene;
use serde_json::{Value, json};

/// Asserts the kind of an error, and that its line says these words.
macro_rules! assert_error {
    ($result:expr, $kind:pat, $($words:expr),* $(,)?) => {{
        let error = $result.unwrap_err();
        let line = error.to_string();
        assert!(matches!(error, $kind), "{error:?}");
        assert!(!line.contains('\n'), "{line}");
        $(assert!(line.contains($words), "{line:?} does not say {:?}", $words);)*
    }};
}

#[test]
fn no_such_file() {
    let folder = Folder::new();
    for name in ["none.gltf", "none.obj", "none.xyz", "none/none.glb"] {
        assert_error!(load(&folder.path(name)), ImportError::NotFound { .. }, name, "check the path");
    }
}

#[test]
fn not_a_file_that_can_be_read() {
    let folder = Folder::new();
    fs::create_dir(folder.path("folder.gltf")).unwrap();
    assert_error!(load(&folder.path("folder.gltf")), ImportError::Unreadable { .. }, "not a regular file");
}

#[test]
fn unsupported_formats_are_named() {
    let error = load_bytes("scene.fbx", "Kaydara");
    assert_error!(error, ImportError::UnsupportedFormat { .. }, "scene.fbx", ".glb", ".obj");
    assert_error!(load_bytes("noextension", ""), ImportError::UnsupportedFormat { .. },);
}

#[test]
fn glb_is_known_by_its_content() {
    let mut document = triangle();
    document["buffers"] = json!([{"byteLength": 78}]);
    let bytes = glb(&document, &triangle_bytes());
    for name in ["scene.glb", "scene.gltf", "scene.bin", "scene"] {
        load_bytes(name, &bytes).unwrap();
    }
}

#[test]
fn truncation_anywhere_is_an_error() {
    let mut document = triangle();
    document["buffers"] = json!([{"byteLength": 78}]);
    let bytes = glb(&document, &triangle_bytes());
    for length in 0..bytes.len() {
        assert!(load_bytes("scene.glb", &bytes[..length]).is_err(), "at {length}");
    }
    let cut = load_bytes("scene.glb", &bytes[..bytes.len() - 5]);
    assert_error!(cut, ImportError::Truncated { .. }, "scene.glb", "cut short");
    let text = triangle().to_string();
    for length in (0..text.len()).step_by(7) {
        assert!(load_bytes("scene.gltf", &text[..length]).is_err(), "at {length}");
    }
}

/// Every byte of a GLB changed in several ways: whatever comes of it, it is no panic.
#[test]
fn damage_anywhere_is_survived() {
    let mut document = triangle();
    document["buffers"] = json!([{"byteLength": 78}]);
    let bytes = glb(&document, &triangle_bytes());
    let folder = Folder::new();
    for at in 0..bytes.len() {
        for value in [0, 0xff, b'9', b'-', bytes[at] ^ 1] {
            let mut damaged = bytes.clone();
            damaged[at] = value;
            let _ = load(&folder.write("scene.glb", &damaged));
        }
    }
}

#[test]
fn buffers_shorter_than_announced() {
    let short = triangle_with("/buffers/0/byteLength", json!(79));
    assert_error!(load_json(&short), ImportError::Truncated { .. }, "#/buffers/0/byteLength", "79", "78");
    for (pointer, value) in [
        ("/bufferViews/0/byteLength", json!(100)),
        ("/bufferViews/0/byteOffset", json!(u64::MAX)),
        ("/accessors/0/count", json!(4)),
        ("/accessors/0/count", json!(u64::MAX)),
        ("/accessors/0/byteOffset", json!(1)),
        ("/accessors/0/byteOffset", json!(u64::MAX)),
        ("/bufferViews/2/byteStride", json!(4)),
        ("/bufferViews/2/byteStride", json!(u64::MAX)),
    ] {
        let result = load_json(&triangle_with(pointer, value));
        assert!(matches!(result, Err(ImportError::Truncated { .. })), "{pointer}: {result:?}");
    }
}

#[test]
fn indices_of_nothing() {
    for pointer in [
        "/scene",
        "/scenes/0/nodes/0",
        "/nodes/0/mesh",
        "/nodes/1/camera",
        "/meshes/0/primitives/0/indices",
        "/meshes/0/primitives/0/material",
        "/meshes/0/primitives/0/attributes/POSITION",
        "/meshes/0/primitives/0/attributes/NORMAL",
        "/accessors/0/bufferView",
        "/bufferViews/0/buffer",
    ] {
        for index in [7, 1 << 32, u64::MAX] {
            let result = load_json(&triangle_with(pointer, json!(index)));
            assert_error!(result, ImportError::OutOfRange { .. }, &format!("#{pointer}"));
        }
        for wrong in [json!(-1), json!(0.5), json!("0"), json!(null), json!([])] {
            let result = load_json(&triangle_with(pointer, wrong));
            assert_error!(result, ImportError::Malformed { .. }, &format!("#{pointer}"));
        }
    }
}

#[test]
fn vertex_indices_past_the_end() {
    let mut bytes = triangle_bytes();
    bytes[76] = 3;
    let document = triangle_with("/buffers/0/uri", json!(data_uri(&bytes)));
    assert_error!(load_json(&document), ImportError::OutOfRange { .. }, "vertex 3", "there are 3");
    let obj = load_bytes("scene.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
    assert_error!(obj, ImportError::OutOfRange { .. }, "scene.obj:4", "vertex 4", "there are 3");
}

#[test]
fn vertices_that_are_no_numbers() {
    for (bad, at) in [(f32::NAN, 12), (f32::INFINITY, 16), (f32::NEG_INFINITY, 20)] {
        let mut bytes = triangle_bytes();
        bytes[at..at + 4].copy_from_slice(&bad.to_le_bytes());
        let document = triangle_with("/buffers/0/uri", json!(data_uri(&bytes)));
        let words = ["attributes/POSITION", "vertex position 1", "repair the mesh"];
        assert_error!(load_json(&document), ImportError::NotFinite { .. }, words[0], words[1], words[2]);
        let obj = load_bytes("scene.obj", format!("v 0 0 0\nv {bad} 0 0\nv 0 1 0\nf 1 2 3\n"));
        assert_error!(obj, ImportError::NotFinite { .. }, "scene.obj:2", "vertex 2");
    }
}

#[test]
fn vertices_too_far_away() {
    for (x, y) in [("1e38", "0"), ("-1e38", "1e38"), ("3e38", "-3e38"), ("1e19", "0")] {
        let obj = load_bytes("scene.obj", format!("v {x} 0 0\nv 1 {y} 0\nv 0 1 0\nf 1 2 3\n"));
        assert_error!(obj, ImportError::InvalidScene { .. }, "scene.obj", "from its origin");
    }
}

#[test]
fn network_uris_are_not_followed() {
    for uri in ["http://example.org/a.bin", "HTTPS://example.org/a.bin", "//example.org/a.bin", "ftp://a/b"] {
        let result = load_json(&triangle_with("/buffers/0/uri", json!(uri)));
        assert_error!(result, ImportError::NetworkUri { .. }, "#/buffers/0/uri", uri);
        let obj = load_bytes("scene.obj", format!("mtllib {uri}\nv 0 0 0\nf 1 1 1\n"));
        assert_error!(obj, ImportError::NetworkUri { .. }, "scene.obj:1", uri);
    }
}

#[test]
fn files_outside_the_folder_are_not_read() {
    let folder = Folder::new();
    folder.write("outside.bin", triangle_bytes());
    let absolute = folder.path("outside.bin").display().to_string();
    let uris = [
        "../outside.bin",
        "a/../../outside.bin",
        "%2e%2e/outside.bin",
        "..%2Foutside.bin",
        &absolute,
        &format!("file://{absolute}"),
        "C:/outside.bin",
    ];
    for uri in uris {
        let document = triangle_with("/buffers/0/uri", json!(uri));
        let scene = folder.write("scenes/scene.gltf", document.to_string());
        assert_error!(load(&scene), ImportError::UnsafePath { .. }, "#/buffers/0/uri", "folder");
    }
    let scene = folder.write("scenes/scene.obj", "mtllib ../outside.mtl\nv 0 0 0\nf 1 1 1\n");
    assert_error!(load(&scene), ImportError::UnsafePath { .. }, "scene.obj:1");
}

#[cfg(unix)]
#[test]
fn links_do_not_lead_outside() {
    let folder = Folder::new();
    folder.write("outside/buffer.bin", triangle_bytes());
    fs::create_dir(folder.path("scenes")).unwrap();
    std::os::unix::fs::symlink(folder.path("outside/buffer.bin"), folder.path("scenes/link.bin")).unwrap();
    std::os::unix::fs::symlink(folder.path("outside"), folder.path("scenes/folder")).unwrap();
    for uri in ["link.bin", "folder/buffer.bin"] {
        let document = triangle_with("/buffers/0/uri", json!(uri));
        let scene = folder.write("scenes/scene.gltf", document.to_string());
        assert_error!(load(&scene), ImportError::UnsafePath { .. }, uri);
    }
}

fn load_under(root: &Path, scene: &Path) -> Result<Scene, ImportError> {
    let options = Options { root: Some(root.to_owned()), ..Options::default() };
    load_with(scene, &options).0.map(|(scene, _)| scene)
}

#[test]
fn files_anywhere_in_a_root_are_read_and_none_outside_of_it() {
    let folder = Folder::new();
    folder.write("root/buffers/a.bin", triangle_bytes());
    folder.write("outside.bin", triangle_bytes());
    let root = folder.path("root");
    let absolute = folder.path("root/buffers/a.bin").display().to_string();
    let outside = folder.path("outside.bin").display().to_string();
    let scene = |uri: &str| {
        let document = triangle_with("/buffers/0/uri", json!(uri));
        folder.write("root/scenes/scene.gltf", document.to_string())
    };
    for uri in ["../buffers/a.bin", "%2e%2e/buffers/a.bin", "../../root/buffers/a.bin", &absolute] {
        assert_error!(load(&scene(uri)), ImportError::UnsafePath { .. }, "a.bin", "allow a folder");
        load_under(&root, &scene(uri)).unwrap_or_else(|e| panic!("{e}"));
    }
    let uris = ["../../outside.bin", "..%2F../outside.bin", &outside, "../../none.bin", "/none.bin"];
    for uri in uris.into_iter().chain([&*format!("file://{absolute}")]) {
        assert_error!(load_under(&root, &scene(uri)), ImportError::UnsafePath { .. }, ".bin");
    }
    assert_error!(load_under(&root, &scene("http://a.org/a")), ImportError::NetworkUri { .. }, "a.org");
    assert_error!(load_under(&root, &scene("../none.bin")), ImportError::MissingBuffer { .. }, "none.bin");
}

#[test]
fn a_scene_lies_in_its_root() {
    let folder = Folder::new();
    let scene = folder.write("scenes/scene.gltf", triangle().to_string());
    fs::create_dir(folder.path("other")).unwrap();
    for root in ["other", "scenes/scene.gltf"] {
        let result = load_under(&folder.path(root), &scene);
        assert_error!(result, ImportError::OutsideRoot { .. }, "scene.gltf", root, "name one that holds");
    }
    assert_error!(load_under(&folder.path("none"), &scene), ImportError::NotFound { .. }, "none: no such");
    load_under(folder.0.path(), &scene).unwrap();
}

#[cfg(unix)]
#[test]
fn links_lead_to_the_root_and_not_out_of_a_root() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new();
    folder.write("outside.bin", triangle_bytes());
    folder.write("root/a.bin", triangle_bytes());
    symlink(folder.path("outside.bin"), folder.path("root/link.bin")).unwrap();
    symlink(folder.path("root"), folder.path("alias")).unwrap();
    let alias = folder.path("alias");
    let by_alias = alias.join("a.bin").display().to_string();
    for (uri, is_read) in [("../link.bin", false), ("../a.bin", true), (&by_alias, true)] {
        let document = triangle_with("/buffers/0/uri", json!(uri));
        folder.write("root/scenes/scene.gltf", document.to_string());
        match load_under(&alias, &alias.join("scenes/scene.gltf")) {
            Err(ImportError::UnsafePath { .. }) => assert!(!is_read, "{uri}"),
            result => assert!(is_read && result.is_ok(), "{uri}: {result:?}"),
        }
    }
}

#[test]
fn files_inside_the_folder_are_read() {
    let folder = Folder::new();
    folder.write("buffers/a b.bin", triangle_bytes());
    for uri in ["buffers/a%20b.bin", "./buffers/a b.bin", "x/../buffers/a b.bin"] {
        let document = triangle_with("/buffers/0/uri", json!(uri));
        load(&folder.write("scene.gltf", document.to_string())).unwrap();
    }
}

#[test]
fn missing_buffers_are_named() {
    for uri in ["none.bin", "none/none.bin", ".", "a\u{0}b", "%00"] {
        let result = load_json(&triangle_with("/buffers/0/uri", json!(uri)));
        assert_error!(result, ImportError::MissingBuffer { .. }, "#/buffers/0/uri", "beside the scene");
    }
}

#[test]
fn required_extensions_that_are_unknown() {
    for name in ["MSFT_lod", "VENDOR_unheard_of"] {
        let mut document = triangle();
        document["extensionsRequired"] = json!([name]);
        assert_error!(load_json(&document), ImportError::UnsupportedExtension { .. }, name, "without");
    }
    let mut document = triangle();
    document["extensionsRequired"] = json!(["KHR_materials_ior", "KHR_mesh_quantization"]);
    load_json(&document).unwrap();
}

#[test]
fn nothing_to_render() {
    let mut documents = vec![json!({"asset": {"version": "2.0"}})];
    documents.push(triangle_with("/scenes/0/nodes", json!([1])));
    documents.push(triangle_with("/meshes/0/primitives/0/mode", json!(1)));
    for document in documents {
        assert_error!(load_json(&document), ImportError::EmptyScene { .. }, "scene.gltf");
    }
    for text in ["", "# nothing\n", "v 0 0 0\nv 1 0 0\nl 1 2\n"] {
        assert_error!(load_bytes("scene.obj", text), ImportError::EmptyScene { .. }, "scene.obj");
    }
}

#[test]
fn loops_in_the_node_tree() {
    let mut looped = triangle();
    looped["nodes"] = json!([{"mesh": 0, "children": [1]}, {"children": [0]}]);
    assert_error!(load_json(&looped), ImportError::Malformed { .. }, "#/nodes/", "two parents");
    let mut deep = triangle();
    let n = 100_000;
    deep["scenes"][0]["nodes"] = json!([0]);
    let mut chain: Vec<Value> = (1..n).map(|i| json!({"children": [i]})).collect();
    chain.push(json!({"mesh": 0}));
    deep["nodes"] = chain.into();
    load_json(&deep).unwrap();
}

/// Small files that ask for much.
#[test]
fn explosions_are_refused_at_once() {
    let start = Instant::now();
    let mut zeros = triangle_with("/accessors/0/count", json!(1u64 << 40));
    zeros["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    zeros["meshes"][0]["primitives"] = json!([{"attributes": {"POSITION": 0}}]);
    assert_error!(load_json(&zeros), ImportError::TooBig { .. }, "limit");

    let mut many = triangle();
    many["meshes"][0]["primitives"] = vec![many["meshes"][0]["primitives"][0].clone(); 3000].into();
    many["nodes"] = vec![json!({"mesh": 0}); 3000].into();
    many["scenes"][0]["nodes"] = (0..3000).collect();
    assert_error!(load_json(&many), ImportError::TooBig { .. }, "too many meshes");

    let nested = format!("{}{}", "[".repeat(1 << 20), "]".repeat(1 << 20));
    assert_error!(load_bytes("scene.gltf", nested), ImportError::Malformed { .. }, "JSON");
    assert!(start.elapsed().as_secs_f32() <= 5.0);
}

#[test]
fn gltf_that_breaks_its_rules() {
    for (pointer, value) in [
        ("/asset/version", json!("1.0")),
        ("/asset/version", json!(2.0)),
        ("/asset", json!(null)),
        ("/nodes", json!({})),
        ("/accessors/0/componentType", json!(5124)),
        ("/accessors/0/type", json!("VEC2")),
        ("/accessors/2/componentType", json!(5126)),
        ("/bufferViews/0/byteStride", json!(8)),
        ("/accessors/1/count", json!(2)),
        ("/buffers/0/uri", json!("data:no comma")),
        ("/buffers/0/uri", json!("data:;base64,????")),
        ("/buffers/0/uri", json!("%ff.bin")),
        ("/nodes/0/scale", json!([1, 1])),
        ("/nodes/0/matrix", json!([1, 2, 3])),
        ("/nodes/0/matrix", json!(vec![0.5; 16])),
        ("/nodes/0/translation", json!([1e300, 0, 0])),
        ("/cameras/0/perspective/yfov", json!(4)),
        ("/materials/0/emissiveFactor", json!(["a", 0, 0])),
        ("/meshes/0/primitives", json!(0)),
    ] {
        let result = load_json(&triangle_with(pointer, value));
        assert!(matches!(result, Err(ImportError::Malformed { .. })), "{pointer}: {result:?}");
    }
}

#[test]
fn obj_that_breaks_its_rules() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (line, place) in [
        ("f 1 2 x", "scene.obj:4"),
        ("f 1 2 /", "scene.obj:4"),
        ("v 1 2", "scene.obj:4"),
        ("vn a b c", "scene.obj:4"),
        ("v", "scene.obj:4"),
    ] {
        let result = load_bytes("scene.obj", format!("{triangle}{line}\n"));
        assert_error!(result, ImportError::Malformed { .. }, place);
    }
    for index in ["0", "-4", "4", "9223372036854775807", "-9223372036854775808", "1//1", "1/1"] {
        let result = load_bytes("scene.obj", format!("{triangle}f 1 2 {index}\n"));
        assert_error!(result, ImportError::OutOfRange { .. }, "scene.obj:4");
    }
    for (line, word) in [
        ("Kd", "Kd"),
        ("Kd 1 x 0", "Kd"),
        ("Kd 1 2", "three"),
        ("Ke nan 0 0", "finite"),
        ("illum x", "whole"),
    ] {
        let folder = Folder::new();
        folder.write("m.mtl", format!("newmtl a\n{line}\n"));
        let scene = folder.write("scene.obj", format!("mtllib m.mtl\n{triangle}f 1 2 3\n"));
        assert_error!(load(&scene), ImportError::Malformed { .. }, "m.mtl:2", word);
    }
}
