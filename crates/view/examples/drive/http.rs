//! Requests that are no WebSocket messages.

use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::TcpStream,
};

use crate::{Outcome, files::files, gone};

/// Uploads files and has the first opened by the message that this gives; none where another steers.
pub async fn upload(address: &str, key: &str, batch: u32, which: u32) -> Outcome<Option<String>> {
    let files = files(which);
    for (name, bytes) in &files {
        let head = format!("PUT /upload/{batch}/{name} HTTP/1.1\r\nX-Midway-Key: {key}\r\n");
        match ask(address, &head, bytes).await?.0 {
            204 => {}
            403 => return Ok(None),
            status => return Err(format!("an upload was answered by {status}").into()),
        }
    }
    Ok(Some(format!(r#"{{"type":"open","batch":{batch},"path":"{}"}}"#, files[0].0)))
}

/// Saves the picture and looks at how it begins; whether there was one, as there is none while the view moves.
pub async fn save(address: &str, format: &str) -> Outcome<bool> {
    let (status, body) = ask(address, &format!("GET /save/{format} HTTP/1.1\r\n"), b"").await?;
    let magic: &[u8] = if format == "exr" { &[0x76, 0x2f, 0x31, 0x01] } else { b"\x89PNG" };
    match status {
        200 if body.starts_with(magic) => Ok(true),
        409 | 503 => Ok(false),
        _ => Err(format!("a picture as {format} was answered by {status}").into()),
    }
}

/// The answer's status and body.
async fn ask(address: &str, head: &str, body: &[u8]) -> Outcome<(u16, Vec<u8>)> {
    let mut stream = TcpStream::connect(address).await.map_err(gone)?;
    let rest = format!("Host: {address}\r\nConnection: close\r\nContent-Length: {}\r\n\r\n", body.len());
    stream.write_all(&[head.as_bytes(), rest.as_bytes(), body].concat()).await?;
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).await?;
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n").ok_or("an answer has no end")?;
    let status =
        std::str::from_utf8(&answer[..end])?.split(' ').nth(1).ok_or("an answer has no status")?.parse()?;
    Ok((status, answer.split_off(end + 4)))
}
