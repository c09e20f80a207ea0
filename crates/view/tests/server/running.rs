//! A server under test, and browsers without a page.

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
use midway_import::Variants;
use midway_render::RenderSettings;
use midway_scene::Scene;
use midway_view::{Address, Server, Session, Start};
use serde_json::{Value, json};
use tokio::net::TcpStream as Socket;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async, tungstenite::Message};

pub const SIZE: u32 = 24;
/// Nothing here takes long; a machine that is busy may.
pub const DEADLINE: Duration = Duration::from_secs(60);

pub struct Running {
    pub url: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Running {
    pub fn start(ip: Option<IpAddr>, read_only: bool) -> Self {
        Self::of(&own_scene("cornell-box.gltf"), None, ip, read_only)
    }

    pub fn of(path: &Path, variant: Option<u32>, ip: Option<IpAddr>, read_only: bool) -> Self {
        let mut import = midway_import::load(path).expect("loads");
        if let Some(materials) = variant.and_then(|variant| import.variants.materials(Some(variant))) {
            import
                .scene
                .meshes
                .iter_mut()
                .zip(materials)
                .for_each(|(mesh, material)| mesh.material = material);
        }
        let name = path.file_name().expect("has a name").to_string_lossy().into_owned();
        let start = Start { name, variants: import.variants, variant, ..start(import.scene, SIZE) };
        Self::serving(Session::start(start).expect("starts"), ip, read_only)
    }

    /// To whoever comes, with a film of `side` by `side`.
    pub fn showing(scene: Scene, side: u32) -> Self {
        Self::serving(Session::start(start(scene, side)).expect("starts"), None, false)
    }

    pub fn serving(session: Session, ip: Option<IpAddr>, read_only: bool) -> Self {
        let address = Address { ip, port: 0 };
        let server = Server::listen(address, session, read_only, |_| {}).expect("listens");
        let (url, stop) = (server.urls().remove(0), Arc::new(AtomicBool::new(false)));
        let asked = Arc::clone(&stop);
        let thread =
            std::thread::spawn(move || server.serve(move || asked.load(Ordering::Relaxed)).expect("serves"));
        Self { url, stop, thread: Some(thread) }
    }

    pub fn address(&self) -> SocketAddr {
        let rest = self.url.strip_prefix("http://").expect("a web address");
        let host = rest.split('/').next().unwrap_or(rest);
        let port = host.rsplit(':').next().unwrap_or_default().parse().expect("a port");
        SocketAddr::new(Ipv4Addr::LOCALHOST.into(), port)
    }

    /// The answer's status, head and body.
    pub fn ask(&self, request: &str, body: &[u8]) -> (u16, String, Vec<u8>) {
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

    pub fn get(&self, path: &str, headers: &str) -> (u16, String, Vec<u8>) {
        let host = self.address();
        self.ask(&format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n{headers}\r\n"), b"")
    }

    /// The picture as a file.
    pub fn saved(&self, format: &str) -> Vec<u8> {
        let (status, _, file) = self.get(&format!("/save/{format}"), "");
        assert_eq!(status, 200, "{}", String::from_utf8_lossy(&file));
        file
    }

    pub fn put(&self, path: &str, key: &str, body: &[u8]) -> u16 {
        let (host, n) = (self.address(), body.len());
        let head = format!(
            "PUT {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\nContent-Length: {n}\r\nX-Midway-Key: {key}\r\n\r\n"
        );
        self.ask(&head, body).0
    }

    pub async fn browser(&self) -> Browser {
        let (socket, _) = connect_async(format!("ws://{}/ws", self.address())).await.expect("connects");
        let mut browser = Browser { socket, key: String::new() };
        browser.key = browser.told("hello").await["key"].as_str().expect("a key").to_owned();
        browser
    }
}

fn start(scene: Scene, side: u32) -> Start {
    Start {
        device: Arc::new(CpuDevice::new(Some(1)).expect("starts")),
        scene,
        name: "scene".to_owned(),
        variants: Variants::default(),
        variant: None,
        settings: RenderSettings { width: side, height: side, ..RenderSettings::default() },
        hold: Duration::from_millis(33),
        reference: None,
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

pub fn own_scene(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name)
}

pub struct Browser {
    pub socket: WebSocketStream<MaybeTlsStream<Socket>>,
    pub key: String,
}

impl Browser {
    pub async fn next(&mut self) -> Message {
        let next = tokio::time::timeout(DEADLINE, self.socket.next()).await.expect("in time");
        next.expect("is open").expect("is well")
    }

    /// The next message of a type; frames are taken on the way.
    pub async fn told(&mut self, kind: &str) -> Value {
        self.told_that(|message| message["type"] == kind).await
    }

    pub async fn told_that(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
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
    pub async fn frame_of(&mut self, input: u32) -> Vec<u8> {
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

    pub async fn ask(&mut self, request: Value) {
        self.socket.send(Message::text(request.to_string())).await.expect("sends");
    }
}

pub fn look(input: u32) -> Value {
    json!({ "type": "look", "eye": [0.1, 1.0, 3.5], "target": [0, 1, 0], "up": [0, 1, 0], "input": input })
}
