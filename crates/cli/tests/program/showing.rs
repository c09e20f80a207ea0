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

/// The page of the server whose address a line says.
fn page(line: &str) -> String {
    let address = line.trim().strip_prefix("view: http://").expect("an address").trim_end_matches('/');
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
