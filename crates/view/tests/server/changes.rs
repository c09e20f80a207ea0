//! Changes of the scene that is shown, while its picture goes on.

use std::path::{Path, PathBuf};

use midway_film::ExrFile;
use serde_json::{Value, json};
use tokio_tungstenite::tungstenite::Message;

use crate::running::{Browser, Running, look};

/// A large triangle in front of the camera, with `n` small ones behind it, that glows red by default and in its
/// first variant, blue in the second, and reflects in the third.
fn glowing(folder: &Path, n: usize) -> PathBuf {
    let mut positions = vec![-9.0f32, -9.0, -2.0, 9.0, -9.0, -2.0, 0.0, 9.0, -2.0];
    positions.extend((0..n).flat_map(|i| {
        let (x, y) = ((i % 1000) as f32, (i / 1000) as f32);
        [x, y, 9.0, x + 0.5, y, 9.0, x, y + 0.5, 9.0]
    }));
    let length = 4 * positions.len();
    let glow = |color: [u8; 3]| json!({ "emissiveFactor": color });
    let mappings = [0, 1, 2].map(|i| json!({ "material": i, "variants": [i] }));
    let names = ["Red", "Blue", "Grey"].map(|name| json!({ "name": name }));
    let document = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_materials_variants"],
        "extensions": { "KHR_materials_variants": { "variants": names } },
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "mesh": 0 }, { "camera": 0 }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0,
            "extensions": { "KHR_materials_variants": { "mappings": mappings } } }] }],
        "materials": [glow([1, 0, 0]), glow([0, 0, 1]), {}],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3 * (n + 1), "type": "VEC3" }],
        "bufferViews": [{ "buffer": 0, "byteLength": length }],
        "buffers": [{ "byteLength": length, "uri": "glow.bin" }],
    });
    let bytes: Vec<u8> = positions.into_iter().flat_map(f32::to_le_bytes).collect();
    std::fs::write(folder.join("glow.bin"), bytes).expect("writes");
    let path = folder.join("glow.gltf");
    std::fs::write(&path, document.to_string()).expect("writes");
    path
}

/// The mean of the picture that the server saves, and the variant that it says it is of.
fn saved(server: &Running) -> ([f64; 3], Option<String>) {
    let exr = server.saved("exr");
    let file = ExrFile::from_bytes(Path::new("saved.exr"), &exr).expect("an EXR");
    (file.image().expect("has a picture").mean(), file.metadata.text("variant").map(str::to_owned))
}

#[tokio::test]
async fn a_variant_of_materials_is_chosen_and_what_else_was_asked_for_stays() {
    let folder = tempfile::tempdir().expect("a folder");
    let server = Running::of(&glowing(folder.path(), 0), Some(0), None, false);
    let mut browser = server.browser().await;
    let scene = browser.told("scene").await;
    assert_eq!((&scene["variants"], &scene["variant"]), (&json!(["Red", "Blue", "Grey"]), &json!(0)));
    browser.ask(json!({ "type": "environment", "strength": 0.5, "rotation": 30 })).await;
    let around = browser.told_that(|m| m["type"] == "scene" && m["environment"]["rotation"] == 30.0).await;
    assert_eq!(around["groups"].as_array().expect("a list").len(), 2);
    browser
        .ask(json!({ "type": "split", "right": { "integrator": "bdpt", "join": "k-step", "k": 2 } }))
        .await;
    browser.ask(json!({ "type": "mix", "factors": [[1, 1, 1], [1, 1, 1]] })).await;
    for (index, name, mean, groups) in [
        (Some(1), Some("Blue"), [0.5, 0.5, 1.5], 2),
        (Some(0), Some("Red"), [1.5, 0.5, 0.5], 2),
        (Some(2), Some("Grey"), [0.5; 3], 1),
        (None, None, [1.5, 0.5, 0.5], 2),
    ] {
        browser.ask(json!({ "type": "variant", "index": index })).await;
        let scene = browser.told_that(|m| m["type"] == "scene" && m["variant"] == json!(index)).await;
        assert_eq!(scene["environment"], json!({ "strength": 0.5, "rotation": 30.0 }));
        assert_eq!(scene["groups"].as_array().expect("a list").len(), groups);
        let status =
            browser.told_that(|m| m["type"] == "status" && m["right"]["samples"].as_u64() > Some(2)).await;
        assert_eq!((&status["right"]["method"]["k"], &status["failure"]), (&json!(2), &Value::Null));
        let (seen, variant) = saved(&server);
        assert_eq!(variant.as_deref(), name);
        for (seen, expected) in seen.into_iter().zip(mean) {
            // All three are white: besides what it emits, each reflects what is all around.
            assert!((seen - expected).abs() <= 0.05, "{name:?}: {seen} for {expected}");
        }
    }
    browser.ask(json!({ "type": "variant", "index": 3 })).await;
    assert!(browser.told("refused").await["reason"].as_str().expect("said").contains("no such variant"));
    assert_eq!(server.browser().await.told("scene").await["variant"], Value::Null);
}

/// A frame that shows `input` comes, and no scene message as `is_changed` wants it before.
async fn goes_on(browser: &mut Browser, input: u32, is_changed: impl Fn(&Value) -> bool) {
    browser.ask(look(input)).await;
    loop {
        match browser.next().await {
            Message::Binary(bytes) => {
                browser.ask(json!({ "type": "decoded" })).await;
                if bytes[8..12] == input.to_le_bytes() {
                    return;
                }
            }
            Message::Text(text) => {
                let message: Value = serde_json::from_str(&text).expect("JSON");
                assert!(!(message["type"] == "scene" && is_changed(&message)), "it was not waited for");
            }
            _ => {}
        }
    }
}

/// A sky in RGBE that is white above and black below, by rows that are not compressed.
fn sky(width: usize, height: usize) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    for row in 0..height {
        let texel = if row < height / 2 { [128, 128, 128, 129] } else { [0; 4] };
        bytes.extend(texel.repeat(width));
    }
    bytes
}

/// What takes long to prepare is prepared beside the picture, which answers meanwhile; of what is asked for
/// until it is ready the last comes.
#[tokio::test]
async fn the_picture_goes_on_while_a_sky_is_prepared() {
    let server = Running::start(None, false);
    let mut browser = server.browser().await;
    assert_eq!(server.put("/upload/4/sky.hdr", &browser.key, &sky(4096, 2048)), 204);
    browser.ask(json!({ "type": "open", "batch": 4, "path": "sky.hdr" })).await;
    browser.told_that(|m| m["type"] == "scene" && m["environment"]["strength"] == 1.0).await;
    let around = |rotation: u32| json!({ "type": "environment", "strength": 0.5, "rotation": rotation });
    browser.ask(around(10)).await;
    goes_on(&mut browser, 7, |scene| scene["environment"]["strength"] == 0.5).await;
    for rotation in 11..=40 {
        browser.ask(around(rotation)).await;
    }
    let mut shown = Vec::new();
    while shown.last() != Some(&40.0) {
        let scene = browser.told("scene").await;
        shown.extend(scene["environment"]["rotation"].as_f64());
        shown.dedup(); // it is told anew where the view has come to rest
    }
    assert!(shown.len() <= 3, "those between are left out: {shown:?}");
}

#[tokio::test]
async fn the_picture_goes_on_while_a_variant_is_prepared() {
    let folder = tempfile::tempdir().expect("a folder");
    let server = Running::of(&glowing(folder.path(), 300_000), Some(0), None, false);
    let mut browser = server.browser().await;
    browser.told("scene").await;
    browser.ask(json!({ "type": "variant", "index": 1 })).await;
    goes_on(&mut browser, 7, |scene| scene["variant"] == 1).await;
    for index in [2, 0, 2, 1, 0] {
        browser.ask(json!({ "type": "variant", "index": index })).await;
    }
    browser.told_that(|m| m["type"] == "scene" && m["variant"] == 1).await;
    let next = browser.told_that(|m| m["type"] == "scene" && m["variant"] != 1).await;
    assert_eq!(next["variant"], 0, "those between are left out");
    assert_eq!(saved(&server).1.as_deref(), Some("Red"));
}

#[tokio::test]
async fn an_environment_that_cannot_be_had_leaves_the_picture() {
    let server = Running::start(None, false);
    let mut browser = server.browser().await;
    let whole = sky(64, 32);
    let files = [("cut.hdr", &whole[..20]), ("other.exr", b"no image".as_slice()), ("empty.hdr", &[])];
    for (input, (name, bytes)) in (1..).zip(files) {
        assert_eq!(server.put(&format!("/upload/6/{name}"), &browser.key, bytes), 204);
        browser.ask(json!({ "type": "open", "batch": 6, "path": name })).await;
        let reason = browser.told("refused").await["reason"].as_str().expect("said").to_owned();
        assert!(!reason.is_empty() && !reason.contains('\n'), "{reason}");
        browser.ask(look(input)).await;
        browser.frame_of(input).await;
    }
    assert_eq!(server.browser().await.told("scene").await["environment"]["strength"], 0.0);
}
