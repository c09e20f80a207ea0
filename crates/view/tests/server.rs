//! The server as strangers and browsers meet it.

use std::{
    io::{Read, Write},
    net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream},
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread::JoinHandle,
    time::{Duration, Instant},
};

use futures_util::{SinkExt, StreamExt};
use midway_device::CpuDevice;
use midway_film::ExrFile;
use midway_render::RenderSettings;
use midway_view::{Address, Server, Session, Start};
use serde_json::{Value, json};
use tokio::net::TcpStream as Socket;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async, tungstenite::Message};

const SIZE: u32 = 24;
/// Nothing here takes long; a machine that is busy may.
const DEADLINE: Duration = Duration::from_secs(60);

struct Running {
    url: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Running {
    fn start(ip: Option<IpAddr>, read_only: bool) -> Self {
        Self::of(&own_scene("cornell-box.gltf"), None, ip, read_only)
    }

    fn of(path: &Path, variant: Option<u32>, ip: Option<IpAddr>, read_only: bool) -> Self {
        let settings = RenderSettings { width: SIZE, height: SIZE, ..RenderSettings::default() };
        let mut import = midway_import::load(path).expect("loads");
        if let Some(materials) = variant.and_then(|variant| import.variants.materials(Some(variant))) {
            import
                .scene
                .meshes
                .iter_mut()
                .zip(materials)
                .for_each(|(mesh, material)| mesh.material = material);
        }
        let session = Session::start(Start {
            device: Arc::new(CpuDevice::new(Some(1)).expect("starts")),
            scene: import.scene,
            name: path.file_name().expect("has a name").to_string_lossy().into_owned(),
            variants: import.variants,
            variant,
            settings,
            hold: Duration::from_millis(33),
            reference: None,
        });
        let address = Address { ip, port: 0 };
        let server = Server::listen(address, session.expect("starts"), read_only, |_| {}).expect("listens");
        let (url, stop) = (server.url(), Arc::new(AtomicBool::new(false)));
        let asked = Arc::clone(&stop);
        let thread =
            std::thread::spawn(move || server.serve(move || asked.load(Ordering::Relaxed)).expect("serves"));
        Self { url, stop, thread: Some(thread) }
    }

    fn address(&self) -> SocketAddr {
        let rest = self.url.strip_prefix("http://").expect("a web address");
        let port = rest.split('/').next().unwrap_or(rest).parse::<SocketAddr>().expect("an address").port();
        SocketAddr::new(Ipv4Addr::LOCALHOST.into(), port)
    }

    /// The answer's status, head and body.
    fn ask(&self, request: &str, body: &[u8]) -> (u16, String, Vec<u8>) {
        let mut stream = TcpStream::connect(self.address()).expect("connects");
        stream.set_read_timeout(Some(DEADLINE)).expect("sets");
        stream.write_all(request.as_bytes()).expect("sends");
        // The server may refuse before it has read all.
        let _ = stream.write_all(body);
        let mut answer = vec![0; 4096];
        let n = stream.read(&mut answer).unwrap_or(0);
        answer.truncate(n);
        // What asks for an upgrade is not closed.
        if !request.contains("Upgrade:") {
            let _ = stream.read_to_end(&mut answer);
        }
        let split = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap_or(answer.len());
        let head = String::from_utf8_lossy(&answer[..split]).into_owned();
        let status = head.split(' ').nth(1).and_then(|s| s.parse().ok()).unwrap_or(0);
        (status, head, answer.get(split + 4..).unwrap_or_default().to_vec())
    }

    fn get(&self, path: &str, headers: &str) -> (u16, String, Vec<u8>) {
        let host = self.address();
        self.ask(&format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n{headers}\r\n"), b"")
    }

    fn put(&self, path: &str, key: &str, body: &[u8]) -> u16 {
        let (host, n) = (self.address(), body.len());
        let head = format!(
            "PUT {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\nContent-Length: {n}\r\nX-Midway-Key: {key}\r\n\r\n"
        );
        self.ask(&head, body).0
    }

    async fn browser(&self) -> Browser {
        let (socket, _) = connect_async(format!("ws://{}/ws", self.address())).await.expect("connects");
        let mut browser = Browser { socket, key: String::new() };
        browser.key = browser.told("hello").await["key"].as_str().expect("a key").to_owned();
        browser
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().expect("no panic");
        }
    }
}

fn own_scene(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name)
}

struct Browser {
    socket: WebSocketStream<MaybeTlsStream<Socket>>,
    key: String,
}

impl Browser {
    async fn next(&mut self) -> Message {
        let next = tokio::time::timeout(DEADLINE, self.socket.next()).await.expect("in time");
        next.expect("is open").expect("is well")
    }

    /// The next message of a type; frames are taken on the way.
    async fn told(&mut self, kind: &str) -> Value {
        self.told_that(|message| message["type"] == kind).await
    }

    async fn told_that(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        while start.elapsed() < DEADLINE {
            match self.next().await {
                Message::Text(text) => {
                    let message: Value = serde_json::from_str(&text).expect("JSON");
                    if wanted(&message) {
                        return message;
                    }
                }
                Message::Binary(_) => self.ask(json!({ "type": "decoded" })).await,
                _ => {}
            }
        }
        panic!("it was never told");
    }

    /// Frames until one shows this input.
    async fn frame_of(&mut self, input: u32) -> Vec<u8> {
        loop {
            if let Message::Binary(bytes) = self.next().await {
                self.ask(json!({ "type": "decoded" })).await;
                assert_eq!(&bytes[..4], b"MWF1");
                if u32::from_le_bytes(bytes[8..12].try_into().expect("four")) == input {
                    return bytes.to_vec();
                }
            }
        }
    }

    async fn ask(&mut self, request: Value) {
        self.socket.send(Message::text(request.to_string())).await.expect("sends");
    }
}

fn look(input: u32) -> Value {
    json!({ "type": "look", "eye": [0.1, 1.0, 3.5], "target": [0, 1, 0], "up": [0, 1, 0], "input": input })
}

#[test]
fn the_page_is_there_for_its_own_name_alone() {
    let server = Running::start(None, false);
    let (status, head, body) = server.get("/", "");
    assert_eq!(status, 200);
    assert!(String::from_utf8_lossy(&body).contains("<title>Midway</title>"));
    for needed in ["content-security-policy", "nosniff", "no-store"] {
        assert!(head.contains(needed), "{head}");
    }
    assert_eq!(server.get("/main.js", "").0, 200);
    assert_eq!(server.get("/", "Origin: http://evil.example\r\n").0, 403);
    for host in ["evil.example", "evil.example:7410", "192.0.2.1"] {
        assert_eq!(
            server.ask(&format!("GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"), b"").0,
            403
        );
    }
    let upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
                   Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
    let (host, evil) = (server.address(), "Origin: http://evil.example\r\n");
    assert_eq!(server.ask(&format!("GET /ws HTTP/1.1\r\nHost: {host}\r\n{upgrade}{evil}\r\n"), b"").0, 403);
}

#[test]
fn no_path_leads_out() {
    let server = Running::start(None, false);
    for path in [
        "/../Cargo.toml",
        "/%2e%2e/%2e%2e/etc/passwd",
        "/..%2f..%2fetc/passwd",
        "/page/main.js",
        "/save/sh",
        "/upload",
    ] {
        let (status, _, body) = server.get(path, "");
        assert!((400..500).contains(&status), "{path}: {status}");
        assert!(!String::from_utf8_lossy(&body).contains("root:"), "{path}");
    }
}

#[test]
fn elsewhere_a_token_is_needed() {
    let server = Running::start(Some(Ipv4Addr::UNSPECIFIED.into()), false);
    assert_eq!(server.get("/", "").0, 401);
    assert_eq!(server.get("/?token=guess", "").0, 401);
    assert_eq!(server.get("/save/exr", "").0, 401);
    let query = server.url.split_once('?').expect("a token").1.to_owned();
    let (status, head, _) = server.get(&format!("/?{query}"), "");
    assert_eq!(status, 303);
    let cookie = head.lines().find_map(|line| line.strip_prefix("set-cookie: ")).expect("a cookie");
    let cookie = cookie.split(';').next().expect("a pair");
    assert_eq!(server.get("/", &format!("Cookie: {cookie}\r\n")).0, 200);
    assert_eq!(server.get(&format!("/?{query}"), "").0, 401, "a token is good once");
}

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
async fn bad_messages_are_refused_and_nothing_breaks() {
    let server = Running::start(None, false);
    let mut browser = server.browser().await;
    let mut word = 1u32;
    let mut noise = || {
        word ^= word << 13;
        word ^= word >> 17;
        word ^= word << 5;
        char::from(b' ' + (word % 95) as u8)
    };
    for length in [0, 1, 7, 100, 5000] {
        let text: String = (0..length).map(|_| noise()).collect();
        browser.socket.send(Message::text(text)).await.expect("sends");
        assert!(browser.told("refused").await["reason"].as_str().expect("said").contains("bad message"));
    }
    browser.socket.send(Message::binary(vec![1, 2, 3])).await.expect("sends");
    browser.told("refused").await;
    for request in [
        json!({ "type": "look", "eye": [0, 0, 0], "target": [0, 0, 0], "up": [0, 1, 0] }),
        json!({ "type": "render", "size": [0, 10] }),
        json!({ "type": "render", "method": { "integrator": "bdpt", "join": "k-step", "k": 4_000_000_000u32 } }),
        json!({ "type": "region", "window": [20, 20, 4_294_967_295u32, 9] }),
        json!({ "type": "environment", "strength": -1, "rotation": 0 }),
        json!({ "type": "variant", "index": 0 }),
        json!({ "type": "variant", "index": null }),
        json!({ "type": "open", "batch": 1, "path": "../../etc/passwd" }),
    ] {
        browser.ask(request.clone()).await;
        assert!(browser.told("refused").await["reason"].is_string(), "{request}");
    }
    browser.ask(look(3)).await;
    browser.frame_of(3).await;
    // Longer than any message may be: the connection is closed.
    let long = Message::text("x".repeat(1 << 20));
    let _ = browser.socket.send(long).await;
    let closed = async {
        while let Some(Ok(message)) = browser.socket.next().await {
            drop(message);
        }
    };
    tokio::time::timeout(DEADLINE, closed).await.expect("it is closed");
    server.browser().await.frame_of(3).await;
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
    let (status, _, exr) = server.get("/save/exr", "");
    assert_eq!(status, 200);
    let file = ExrFile::from_bytes(Path::new("saved.exr"), &exr).expect("an EXR");
    let image = file.image().expect("has a picture");
    assert_eq!(image.size(), [SIZE as usize; 2]);
    assert!(!image.is_black());
    let (status, _, png) = server.get("/save/png", "");
    assert!(status == 200 && png.starts_with(b"\x89PNG"));
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

/// A large triangle in front of the camera that glows red by default and in its first variant, blue in the
/// second, and reflects in the third.
fn glowing(folder: &Path) -> std::path::PathBuf {
    let positions = [-9.0f32, -9.0, -2.0, 9.0, -9.0, -2.0, 0.0, 9.0, -2.0];
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
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36, "uri": "glow.bin" }],
    });
    std::fs::write(folder.join("glow.bin"), positions.map(f32::to_le_bytes).as_flattened()).expect("writes");
    let path = folder.join("glow.gltf");
    std::fs::write(&path, document.to_string()).expect("writes");
    path
}

/// The mean of the picture that the server saves, and the variant that it says it is of.
fn saved(server: &Running) -> ([f64; 3], Option<String>) {
    let (status, _, exr) = server.get("/save/exr", "");
    assert_eq!(status, 200);
    let file = ExrFile::from_bytes(Path::new("saved.exr"), &exr).expect("an EXR");
    (file.image().expect("has a picture").mean(), file.metadata.text("variant").map(str::to_owned))
}

#[tokio::test]
async fn a_variant_of_materials_is_chosen_and_what_else_was_asked_for_stays() {
    let folder = tempfile::tempdir().expect("a folder");
    let server = Running::of(&glowing(folder.path()), Some(0), None, false);
    let mut browser = server.browser().await;
    let scene = browser.told("scene").await;
    assert_eq!((&scene["variants"], &scene["variant"]), (&json!(["Red", "Blue", "Grey"]), &json!(0)));
    browser.ask(json!({ "type": "environment", "strength": 0.5, "rotation": 30 })).await;
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
