//! Browsers that look and steer.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use midway_film::ExrFile;
use midway_scene::Projection;
use serde_json::{Value, json};

use crate::running::{Running, SIZE, look, own_scene};

fn picture_of(frame: &[u8]) -> image::RgbImage {
    let length = u32::from_le_bytes(frame[24..28].try_into().expect("four")) as usize;
    image::load_from_memory(&frame[28..28 + length]).expect("a JPEG").to_rgb8()
}

#[tokio::test]
async fn frames_show_what_was_asked_and_figures_say_so() {
    let server = Running::start(None, false);
    let mut browser = server.browser().await;
    let scene = browser.told("scene").await;
    assert_eq!(scene["name"], "cornell-box.gltf");
    assert_eq!(scene["variants"], json!([]));
    browser.ask(look(7)).await;
    // On a busy machine the first frames are of 3 x 3 pixels and one sample, which find hardly any light.
    let picture = loop {
        let picture = picture_of(&browser.frame_of(7).await);
        if picture.width() >= SIZE / 2 {
            break picture;
        }
    };
    assert!(picture.pixels().any(|pixel| pixel.0.iter().any(|byte| *byte > 60)), "black");
    let method = json!({ "integrator": "bdpt", "join": "k-step", "k": 5 });
    browser.ask(json!({ "type": "render", "method": method })).await;
    let status =
        browser.told_that(|m| m["type"] == "status" && m["left"]["samples"].as_u64() > Some(8)).await;
    assert!(status["left"]["integrator"].as_str().expect("said").contains("k=5"), "{status}");
    assert_eq!(status["left"]["size"], json!([SIZE, SIZE]));
    browser.ask(json!({ "type": "split", "right": { "integrator": "path" } })).await;
    let split =
        browser.told_that(|m| m["type"] == "status" && m["right"]["samples"].as_u64() > Some(2)).await;
    let seconds = |half: &str| split[half]["seconds"].as_f64().expect("a number");
    assert!((seconds("left") / seconds("right")).ln().abs() <= 1.0, "{split}");
    browser.ask(json!({ "type": "pick", "x": 0.5, "y": 0.5 })).await;
    assert!(browser.told("picked").await["point"].is_array());
}

#[tokio::test]
async fn one_browser_steers_and_another_may_take_over() {
    let server = Running::start(None, false);
    let mut first = server.browser().await;
    assert_eq!(first.told("role").await["steers"], true);
    let mut second = server.browser().await;
    assert_eq!(second.told("role").await["steers"], false);
    second.ask(look(1)).await;
    assert!(second.told("refused").await["reason"].as_str().expect("said").contains("steers"));
    assert_eq!(server.put("/upload/1/a.glb", &second.key, b"x"), 403);
    second.ask(json!({ "type": "take" })).await;
    second.told_that(|m| m["type"] == "role" && m["steers"] == true).await;
    second.ask(look(2)).await;
    second.frame_of(2).await;
    drop(second);
    first.told_that(|m| m["type"] == "role" && m["steers"] == true).await;
}

/// Who comes while another steers, or comes back, begins with the view as it is, not as the scene has it.
#[tokio::test]
async fn whoever_comes_is_told_the_view_that_rests() {
    let server = Running::start(None, false);
    let mut first = server.browser().await;
    let began = first.told("scene").await["view"].clone();
    // Of a scene that has given way to this one.
    let mut stale = look(1);
    stale["opened"] = json!(7);
    first.ask(stale).await;
    first.ask(json!({ "type": "restart" })).await;
    first.told_that(|m| m["type"] == "status" && m["left"]["samples"].as_u64() > Some(4)).await;
    assert_eq!(server.browser().await.told("scene").await["view"], began);
    first.ask(look(2)).await;
    let rests = first.told_that(|m| m["type"] == "scene" && m["view"] != began).await;
    let second = server.browser().await.told("scene").await;
    assert_eq!(second["view"], rests["view"]);
    let eye: Vec<f64> =
        second["view"]["eye"].as_array().expect("three").iter().filter_map(|x| x.as_f64()).collect();
    assert!(eye.iter().zip([0.1, 1.0, 3.5]).all(|(told, asked)| (told - asked).abs() < 1e-5), "{eye:?}");
}

/// What is begun anew while it is paused has a first picture, and no more.
#[tokio::test]
async fn what_begins_anew_while_paused_has_a_picture() {
    let server = Running::start(None, false);
    let mut browser = server.browser().await;
    let samples = |status: &Value| status["left"]["samples"].as_u64().expect("a number");
    browser.told_that(|m| m["type"] == "status" && samples(m) > 1000).await;
    browser.ask(json!({ "type": "pause", "paused": true })).await;
    let before = samples(&browser.told_that(|m| m["type"] == "status" && m["paused"] == true).await);
    for change in [
        json!({ "type": "restart" }),
        json!({ "type": "show", "exposure": 0, "tone_map": "agx", "layer": "albedo" }),
    ] {
        browser.ask(change).await;
        let status = browser.told_that(|m| m["type"] == "status" && (1..before).contains(&samples(m))).await;
        let later = browser.told("status").await;
        assert_eq!(samples(&later), samples(&browser.told("status").await), "{status}");
    }
}

#[tokio::test]
async fn a_browser_that_takes_nothing_stalls_nobody() {
    let server = Running::start(None, false);
    let mut steering = server.browser().await;
    let _deaf = [server.browser().await, server.browser().await];
    for input in 1..=30 {
        let asked = Instant::now();
        steering.ask(look(input)).await;
        steering.frame_of(input).await;
        assert!(asked.elapsed() < Duration::from_secs(5), "frame {input} took {:?}", asked.elapsed());
    }
}

#[tokio::test]
async fn a_picture_to_be_looked_at_cannot_be_changed() {
    let server = Running::start(None, true);
    let mut browser = server.browser().await;
    assert_eq!(browser.told("role").await["read_only"], true);
    for request in [look(1), json!({ "type": "take" }), json!({ "type": "restart" })] {
        browser.ask(request).await;
        browser.told("refused").await;
    }
    assert_eq!(server.put("/upload/1/a.glb", &browser.key, b"x"), 403);
}

/// A camera with parallel rays sees more or less by the height of its film, not by where it stands.
#[tokio::test]
async fn parallel_rays_zoom_by_the_height_of_the_film() {
    let mut scene = midway_import::load(&own_scene("cornell-box.gltf")).expect("loads").scene;
    scene.cameras[0].projection = Projection::Orthographic { height: 600.0 };
    let server = Running::showing(scene, SIZE);
    let mut browser = server.browser().await;
    let told = browser.told("scene").await;
    assert_eq!(told["view"]["height"], 600.0);
    let mut seen = Vec::new();
    for (input, height) in [(1, 600.0), (2, 4000.0)] {
        let (eye, target) = ([278, 273, -800], [278, 273, 0]);
        let up = [0, 1, 0];
        let view = json!({ "type": "look", "eye": eye, "target": target, "up": up, "height": height, "input": input });
        browser.ask(view).await;
        browser.frame_of(input).await;
        let exr = server.saved("exr");
        let image = ExrFile::from_bytes(Path::new("saved.exr"), &exr).expect("an EXR").image();
        seen.push(image.expect("has a picture").pixels.iter().filter(|pixel| pixel[1] > 0.0).count());
    }
    assert!(seen[0] > 10 * seen[1], "{seen:?}");
}
