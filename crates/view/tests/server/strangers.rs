//! Other names, other pages, guessed tokens, paths that lead out, nonsense.

use std::net::Ipv4Addr;

use futures_util::{SinkExt, StreamExt};
use serde_json::json;
use tokio_tungstenite::tungstenite::Message;

use crate::running::{DEADLINE, Running, look};

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
fn a_stranger_is_refused_before_its_file_is_read() {
    let server = Running::start(None, false);
    let head = format!(
        "PUT /upload/1/a.glb HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nContent-Length: 1000000\r\n\r\n",
        server.address()
    );
    assert_eq!(server.ask(&head, b"").0, 403);
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
    assert!(!server.url.contains("0.0.0.0"), "no browser opens {}", server.url);
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
