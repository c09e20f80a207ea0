//! A scene's variants of materials: listed by `info`, taken by `--variant`.

use midway_film::ExrFile;
use serde_json::{Value, json};

use crate::support::Sandbox;

/// A triangle that glows red by default and in its variant "Red lamp", blue in "Blue lamp".
fn scene() -> Sandbox {
    let positions = [-1.0f32, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0];
    let glow = |color: [u8; 3]| json!({"emissiveFactor": color});
    let document = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_variants"],
        "extensions": {"KHR_materials_variants": {"variants": [{"name": "Red lamp"}, {"name": "Blue lamp"}]}},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0, "extensions":
            {"KHR_materials_variants": {"mappings": [
                {"material": 0, "variants": [0]}, {"material": 1, "variants": [1]}]}}}]}],
        "materials": [glow([1, 0, 0]), glow([0, 0, 1])],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "scene.bin"}],
    });
    let sandbox = Sandbox::new();
    sandbox.write("scene.bin", positions.map(f32::to_le_bytes).as_flattened());
    sandbox.write("scene.gltf", document.to_string());
    sandbox
}

#[test]
fn info_lists_them_and_says_which_is_taken() {
    let sandbox = scene();
    let json = |flags: &[&str]| -> Value {
        sandbox.expect(0, &[&["info", "scene.gltf", "--json"], flags].concat()).json_lines().remove(0)
    };
    let plain = json(&[]);
    assert_eq!((&plain["variants"], &plain["variant"]), (&json!(["Red lamp", "Blue lamp"]), &Value::Null));
    assert!(!plain["warnings"].to_string().contains("variant"), "{plain}");
    let blue = json(&["--variant", "Blue lamp"]);
    assert_eq!(blue["variant"], "Blue lamp");
    assert_ne!(blue["hash"], plain["hash"]);
    let text = sandbox.expect(0, &["info", "scene.gltf"]).stdout;
    assert!(text.contains("variants   2") && text.contains("  1 Blue lamp"), "{text}");
}

#[test]
fn a_render_shows_the_one_that_is_taken() {
    let sandbox = scene();
    let mean = |flags: &[&str]| {
        let small =
            ["render", "scene.gltf", "--device", "cpu", "--width", "8", "--height", "8", "--spp", "1"];
        sandbox.expect(0, &[&small[..], &["-i", "path-naive", "-o", "out.exr"], flags].concat());
        let file = ExrFile::read(&sandbox.path("out.exr")).unwrap();
        (file.image().unwrap().mean(), file.metadata.text("variant").map(str::to_owned))
    };
    let ([r, _, b], variant) = mean(&[]);
    assert!(r > 0.0 && b == 0.0 && variant.is_none());
    let ([r, _, b], variant) = mean(&["--variant", "Blue lamp"]);
    assert!(r == 0.0 && b > 0.0 && variant.as_deref() == Some("Blue lamp"));
}

#[test]
fn an_unknown_one_is_2_and_lists_what_there_is() {
    let sandbox = scene();
    let view = ["view", "scene.gltf", "--no-open", "--port", "0", "--variant", "Green lamp"];
    for arguments in [
        &["info", "scene.gltf", "--variant", "Green lamp"][..],
        &["render", "scene.gltf", "--variant", "Green lamp"],
        &view,
    ] {
        let run = sandbox.expect(2, arguments);
        let line = run.error();
        assert!(line.contains("--variant") && line.contains(r#""Red lamp", "Blue lamp""#), "{line}");
    }
    sandbox.expect(2, &["view", "--no-open", "--variant", "Red lamp"]);
}
