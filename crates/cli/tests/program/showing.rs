//! A render shown while it runs, and the viewer from the command line.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::{TcpListener, TcpStream},
    process::Child,
    thread,
};

use crate::support::Sandbox;

const SMALL: [&str; 8] = ["render", "scene.obj", "--device", "cpu", "--width", "24", "--height", "16"];

fn scene() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write_scene();
    sandbox
}

/// A program that is ended whatever the test comes to.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Running {
    /// As `kill` ends programs by default; the exit code.
    #[cfg(unix)]
    fn terminate(&mut self) -> Option<i32> {
        let pid = self.0.id().to_string();
        assert!(std::process::Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
        self.0.wait().unwrap().code()
    }
}

/// The address that a line says.
fn address_of(line: &str) -> &str {
    line.trim().strip_prefix("view: http://").expect("an address").trim_end_matches('/')
}

/// The page of the server whose address a line says.
fn page(line: &str) -> String {
    let address = address_of(line);
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET / HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
    let mut page = String::new();
    stream.read_to_string(&mut page).unwrap();
    page
}

#[test]
fn tev_is_sent_the_picture() {
    let sandbox = scene();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let tev = thread::spawn(move || {
        let mut bytes = Vec::new();
        listener.accept().unwrap().0.read_to_end(&mut bytes).unwrap();
        bytes
    });
    sandbox.expect(0, &[&SMALL[..], &["--spp", "2", "--display", &address]].concat());
    let bytes = tev.join().unwrap();
    // Two messages at least, each its length, its kind and what follows; the last holds all pixels.
    let length = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let second = length(0);
    assert_eq!(bytes[4], 4, "create an image");
    assert!(length(second) > 24 * 16 * 3 * 4, "{}", length(second));
    let names = String::from_utf8_lossy(&bytes[..second]).into_owned();
    assert!(names.contains("scene.obj"), "{names}");
}

#[test]
fn a_display_that_is_not_there_is_told_before_rendering() {
    let sandbox = scene();
    let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let run = sandbox.expect(5, &[&SMALL[..], &["--display", &free]].concat());
    assert!(run.error().contains("--display"), "{}", run.stderr);
    assert!(!sandbox.exists("scene.exr"));
}

#[test]
fn a_running_render_has_a_page() {
    let sandbox = scene();
    let line = [&SMALL[..], &["--time", "1m", "--serve=0"]].concat();
    let mut render = Running(sandbox.command(&line).spawn().unwrap());
    let told = BufReader::new(render.0.stderr.take().unwrap());
    let address = told.lines().map(Result::unwrap).find(|line| line.starts_with("view: ")).unwrap();
    assert!(page(&address).contains("<title>Midway</title>"));
}

#[test]
fn the_viewer_says_where_it_is() {
    let sandbox = scene();
    let line = ["view", "scene.obj", "--device", "cpu", "--width", "24", "--no-open", "--port", "0"];
    let mut view = Running(sandbox.command(&line).spawn().unwrap());
    let mut told = String::new();
    BufReader::new(view.0.stdout.take().unwrap()).read_line(&mut told).unwrap();
    assert!(page(&told).contains("<title>Midway</title>"));
}

#[test]
fn the_viewer_refuses_what_it_cannot_show() {
    let sandbox = scene();
    sandbox.expect(3, &["view", "nothing.glb", "--no-open", "--port", "0"]);
    sandbox.expect(4, &["view", "scene.obj", "--device", "no such device", "--no-open", "--port", "0"]);
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let run = sandbox.expect(2, &["view", "scene.obj", "--device", "cpu", "--no-open", "--port", &port]);
    assert!(run.error().contains("cannot listen"), "{}", run.stderr);
}

/// What a browser that steers brings to uploads. The connection stays open: it steers as long.
#[cfg(unix)]
fn steer(address: &str) -> (TcpStream, String) {
    let mut socket = TcpStream::connect(address).unwrap();
    let upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
                   Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==";
    write!(socket, "GET /ws HTTP/1.1\r\nHost: {address}\r\n{upgrade}\r\n\r\n").unwrap();
    let mut told = String::new();
    while !told.contains("\"version\"") {
        let mut bytes = [0; 4096];
        let n = socket.read(&mut bytes).unwrap();
        assert!(n > 0, "{told}");
        told += &String::from_utf8_lossy(&bytes[..n]);
    }
    let key = told.split("\"key\":\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a key");
    (socket, key.to_owned())
}

#[cfg(unix)]
#[test]
fn what_was_uploaded_goes_with_the_viewer() {
    let sandbox = scene();
    let line = ["view", "scene.obj", "--device", "cpu", "--width", "24", "--no-open", "--port", "0"];
    std::fs::create_dir(sandbox.path("tmp")).unwrap();
    let uploads = || std::fs::read_dir(sandbox.path("tmp")).unwrap().count();
    let mut command = sandbox.command(&line);
    let mut view = Running(command.env("TMPDIR", sandbox.path("tmp")).spawn().unwrap());
    let mut told = String::new();
    BufReader::new(view.0.stdout.take().unwrap()).read_line(&mut told).unwrap();
    let address = address_of(&told);
    let (_socket, key) = steer(address);
    let mut stream = TcpStream::connect(address).unwrap();
    let head = format!(
        "PUT /upload/1/a.obj HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nX-Midway-Key: {key}"
    );
    write!(stream, "{head}\r\nContent-Length: 2\r\n\r\nv ").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 204"), "{answer}");
    assert_eq!(uploads(), 1);
    assert_eq!(view.terminate(), Some(0));
    assert_eq!(uploads(), 0);
}

#[cfg(unix)]
#[test]
fn a_render_that_is_terminated_writes_what_there_is() {
    let sandbox = scene();
    let line = [&SMALL[..], &["--time", "1m", "--serve=0"]].concat();
    let mut render = Running(sandbox.command(&line).spawn().unwrap());
    let told = BufReader::new(render.0.stderr.take().unwrap());
    assert!(told.lines().map(Result::unwrap).any(|line| line.starts_with("view: ")));
    thread::sleep(std::time::Duration::from_secs(1)); // a pass takes milliseconds
    assert_eq!(render.terminate(), Some(10));
    assert!(sandbox.exists("scene.exr"));
}
