//! Files that are opened and saved.

use std::path::Path;

use midway_film::ExrFile;
use serde_json::{Value, json};
use tokio_tungstenite::tungstenite::Message;

use crate::running::{Running, SIZE, look, own_scene};

#[tokio::test]
async fn uploads_are_opened_and_pictures_saved() {
    let server = Running::start(None, false);
    let mut browser = server.browser().await;
    for file in ["lamp.gltf", "lamp.bin"] {
        let bytes = std::fs::read(own_scene(file)).expect("is there");
        assert_eq!(server.put(&format!("/upload/9/my%20lamp/{file}"), &browser.key, &bytes), 204);
    }
    assert_eq!(server.put("/upload/9/..%2f..%2fx.glb", &browser.key, b"x"), 400);
    assert_eq!(server.put("/upload/9/.hidden", &browser.key, b"x"), 400);
    assert_eq!(server.put("/upload/9/x.glb", "guess", b"x"), 403);
    browser.ask(json!({ "type": "open", "batch": 9, "path": "my lamp/lamp.gltf" })).await;
    browser.told_that(|m| m["type"] == "scene" && m["name"] == "lamp.gltf").await;
    browser.told_that(|m| m["type"] == "status" && m["left"]["samples"].as_u64() > Some(2)).await;
    let exr = server.saved("exr");
    let file = ExrFile::from_bytes(Path::new("saved.exr"), &exr).expect("an EXR");
    let image = file.image().expect("has a picture");
    assert_eq!(image.size(), [SIZE as usize; 2]);
    assert!(!image.is_black());
    assert!(server.saved("png").starts_with(b"\x89PNG"));
    browser.ask(json!({ "type": "open", "batch": 9, "path": "my lamp/lamp.bin" })).await;
    browser.told("refused").await;
    browser.told_that(|m| m["type"] == "status" && m["failure"].is_null()).await;
}

/// A scene that takes its time is opened beside the picture, which answers meanwhile.
#[tokio::test]
async fn the_picture_goes_on_while_a_scene_is_opened() {
    const SIDE: usize = 400;
    let server = Running::start(None, false);
    let mut browser = server.browser().await;
    let vertices = (0..SIDE * SIDE).map(|i| format!("v {} {} {}\n", i % SIDE, i / SIDE, i % 7));
    let corners = (0..SIDE * (SIDE - 1)).filter(|i| i % SIDE + 1 < SIDE).map(|i| i + 1);
    let faces = corners.map(|i| format!("f {i} {} {} {}\n", i + 1, i + 1 + SIDE, i + SIDE));
    let field: String = vertices.chain(faces).collect();
    assert_eq!(server.put("/upload/3/field.obj", &browser.key, field.as_bytes()), 204);
    browser.ask(json!({ "type": "open", "batch": 3, "path": "field.obj" })).await;
    browser.ask(look(7)).await;
    let is_field = |message: &Value| message["type"] == "scene" && message["name"] == "field.obj";
    loop {
        match browser.next().await {
            Message::Binary(bytes) => {
                browser.ask(json!({ "type": "decoded" })).await;
                if bytes[8..12] == 7u32.to_le_bytes() {
                    break;
                }
            }
            Message::Text(text) => assert!(!is_field(&serde_json::from_str(&text).expect("JSON"))),
            _ => {}
        }
    }
    let triangles = browser.told_that(is_field).await["triangles"].as_u64();
    assert_eq!(triangles, Some(2 * (SIDE as u64 - 1).pow(2)));
}

/// A PNG is what is on the screen: the layer that is chosen, pixel by pixel.
#[tokio::test]
async fn a_png_is_saved_as_it_is_shown() {
    let server = Running::start(None, false);
    let mut browser = server.browser().await;
    let mut pngs = Vec::new();
    for layer in ["normal", "depth", "beauty"] {
        browser.ask(json!({ "type": "show", "exposure": 0, "tone_map": "linear", "layer": layer })).await;
        let shows = |m: &Value| m["shown"]["layer"] == layer && m["left"]["samples"].as_u64() > Some(2);
        browser.told_that(shows).await;
        browser.ask(json!({ "type": "pause", "paused": true })).await;
        browser.told_that(|m| m["type"] == "status" && m["paused"] == true).await;
        let png = image::load_from_memory(&server.saved("png")).expect("a PNG").to_rgb8();
        let exr = ExrFile::from_bytes(Path::new("saved.exr"), &server.saved("exr")).expect("an EXR");
        if layer == "normal" {
            let normal = ["normal.X", "normal.Y", "normal.Z"].map(|name| exr.channel(name).expect(name));
            for (i, pixel) in png.pixels().enumerate() {
                let expected = normal.map(|plane| ((plane[i] * 0.5 + 0.5) * 255.0).round() as u8);
                // Either may round a half.
                assert!(pixel.0.iter().zip(expected).all(|(byte, e)| byte.abs_diff(e) <= 1), "{pixel:?}");
            }
        }
        if layer == "depth" {
            assert!(png.pixels().all(|pixel| pixel.0 == [pixel.0[0]; 3]), "depths are grey");
        }
        pngs.push(png);
        browser.ask(json!({ "type": "pause", "paused": false })).await;
    }
    assert!(pngs[0] != pngs[1] && pngs[1] != pngs[2] && pngs[0] != pngs[2]);
}

/// What is shown small for speed is not what is saved.
#[tokio::test]
async fn a_picture_is_saved_whole_while_the_view_moves() {
    const SIDE: usize = 640;
    let scene = midway_import::load(&own_scene("lamp.gltf")).expect("loads").scene;
    let server = Running::showing(scene, SIDE as u32);
    let mut browser = server.browser().await;
    for input in 1..20 {
        browser.ask(look(input)).await;
        browser.frame_of(input).await;
    }
    let exr = server.saved("exr");
    let image = ExrFile::from_bytes(Path::new("saved.exr"), &exr).expect("an EXR").image();
    assert_eq!(image.expect("has a picture").size(), [SIDE; 2]);
}

/// Without a scene the page asks for one, and shows the one that is dropped.
#[tokio::test]
async fn there_may_be_no_scene_at_first() {
    let server = Running::showing(midway_view::nothing(), SIZE);
    let mut browser = server.browser().await;
    let asks = |m: &Value| m["black"].as_str().is_some_and(|why| why.contains("Drop a .glb"));
    browser.told_that(asks).await;
    for file in ["cornell-box.gltf", "cornell-box.bin"] {
        let bytes = std::fs::read(own_scene(file)).expect("is there");
        assert_eq!(server.put(&format!("/upload/1/{file}"), &browser.key, &bytes), 204);
    }
    browser.ask(json!({ "type": "open", "batch": 1, "path": "cornell-box.gltf" })).await;
    browser.told_that(|m| m["type"] == "scene" && m["name"] == "cornell-box.gltf").await;
    let exr = server.saved("exr");
    let image = ExrFile::from_bytes(Path::new("saved.exr"), &exr).expect("an EXR").image();
    assert!(!image.expect("has a picture").is_black());
}

/// The reason of a black picture goes by how it is shown now, paused or not.
#[tokio::test]
async fn a_black_picture_says_why_as_it_is_shown_now() {
    let server = Running::start(None, false);
    let mut browser = server.browser().await;
    browser.told_that(|m| m["type"] == "status" && m["left"]["samples"].as_u64() > Some(8)).await;
    browser.ask(json!({ "type": "pause", "paused": true })).await;
    let shown = browser.told_that(|m| m["type"] == "status" && m["paused"] == true).await["shown"].clone();
    let with = |exposure: f32| {
        let mut request = shown.clone();
        request["type"] = "show".into();
        request["exposure"] = exposure.into();
        request
    };
    browser.ask(with(-40.0)).await;
    browser.told_that(|m| m["black"].as_str().is_some_and(|why| why.contains("exposure"))).await;
    browser.ask(with(0.0)).await;
    browser.told_that(|m| m["type"] == "status" && m["black"].is_null()).await;
}
