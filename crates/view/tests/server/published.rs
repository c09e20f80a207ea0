//! A render that runs elsewhere, looked at.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use midway_device::{CpuDevice, Device};
use midway_film::Display;
use midway_render::{RenderSettings, RenderStats, Renderer};
use midway_view::Publisher;
use serde_json::json;
use tokio_tungstenite::tungstenite::Message;

use crate::running::{Running, SIZE, own_scene};

#[tokio::test]
async fn a_render_that_runs_elsewhere_is_seen() {
    let scene = midway_import::load(&own_scene("cornell-box.gltf")).expect("loads").scene;
    let camera = scene.cameras[0].clone();
    let mut publisher =
        Publisher::start(&scene, "cornell-box.gltf", &camera, Display::default()).expect("starts");
    let server = Running::serving(publisher.session(), None, true);
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    let render = std::thread::spawn(move || {
        let device: Arc<dyn Device> = Arc::new(CpuDevice::new(Some(1)).expect("starts"));
        let info = device.info().clone();
        let settings = RenderSettings { width: SIZE, height: SIZE, ..RenderSettings::default() };
        let mut renderer = Renderer::new(device, &scene, &camera, settings).expect("starts");
        while !asked.load(Ordering::Relaxed) {
            renderer.step(1).expect("renders");
            publisher.publish(&mut renderer, &RenderStats::default(), 1.0, &info).expect("publishes");
            std::thread::sleep(Duration::from_millis(10));
        }
    });
    let mut browser = server.browser().await;
    assert_eq!(browser.told("scene").await["name"], "cornell-box.gltf");
    let mut frames = 0;
    while frames < 3 {
        if let Message::Binary(_) = browser.next().await {
            frames += 1;
            browser.ask(json!({ "type": "decoded" })).await;
        }
    }
    assert!(browser.told("status").await["left"]["samples"].as_u64() > Some(0));
    stop.store(true, Ordering::Relaxed);
    render.join().expect("no panic");
}
