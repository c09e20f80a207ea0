//! How fast a hand that drags sees what it does.

use std::{
    collections::HashMap,
    time::{Duration, Instant},
};

use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use tokio_tungstenite::{connect_async, tungstenite::Message};

use crate::{Outcome, requests::turned};

/// Inputs a second of a hand that drags.
const INPUTS: f64 = 60.0;
/// Measured after this long: the controller has settled.
const WARM_UP: Duration = Duration::from_secs(2);

/// Decodes a frame's pictures; which input it shows, and the size.
fn decode(bytes: &[u8]) -> Outcome<(u32, [u32; 2])> {
    let number = |at: usize| -> Outcome<u32> {
        Ok(u32::from_le_bytes(bytes.get(at..at + 4).ok_or("a frame is short")?.try_into()?))
    };
    let mut at = 24;
    for _ in 0..number(20)? {
        let length = number(at)? as usize;
        image::load_from_memory(bytes.get(at + 4..at + 4 + length).ok_or("a frame is short")?)?;
        at += 4 + length;
    }
    Ok((number(8)?, [number(12)?, number(16)?]))
}

/// Frames a second and latencies of an orbit.
pub async fn measure(address: &str, time: Duration) -> Outcome<Value> {
    let (socket, _) = connect_async(format!("ws://{address}/ws")).await?;
    let (mut sink, mut stream) = socket.split();
    let (mut view, mut status) = (Value::Null, Value::Null);
    let mut sent: HashMap<u32, Instant> = HashMap::new();
    let (mut latencies, mut widths, mut intervals) = (Vec::new(), Vec::new(), Vec::new());
    let (start, mut last) = (Instant::now(), None::<Instant>);
    let mut clock = tokio::time::interval(Duration::from_secs_f64(1.0 / INPUTS));
    let mut input = 0;
    while start.elapsed() < WARM_UP + time {
        tokio::select! {
            _ = clock.tick() => if !view.is_null() {
                input += 1;
                sent.insert(input, Instant::now());
                let look = turned(&view, 0.4 * (f64::from(input) / 40.0).sin(), input);
                sink.send(Message::text(look.to_string())).await?;
            },
            message = stream.next() => match message.ok_or("the server has gone")?? {
                Message::Binary(bytes) => {
                    let (shows, [width, _]) = decode(&bytes)?;
                    sink.send(Message::text(r#"{"type":"decoded"}"#)).await?;
                    let now = Instant::now();
                    if start.elapsed() > WARM_UP && let Some(asked) = sent.get(&shows) {
                        latencies.push((now - *asked).as_secs_f64() * 1e3);
                        widths.push(f64::from(width));
                        intervals.extend(last.map(|last| (now - last).as_secs_f64() * 1e3));
                        last = Some(now);
                    }
                    sent.retain(|number, _| *number >= shows);
                }
                Message::Text(text) => {
                    let told: Value = serde_json::from_str(&text)?;
                    match told["type"].as_str() {
                        Some("scene") if told["view"].is_object() => view = told["view"].clone(),
                        Some("status") => status = told,
                        _ => {}
                    }
                }
                _ => {}
            },
        }
    }
    Ok(json!({
        "device": status["device"], "integrator": status["left"]["integrator"], "film": status["film"],
        "frames": latencies.len(), "frames_per_second": latencies.len() as f64 / time.as_secs_f64(),
        "latency_ms": spread(&mut latencies), "interval_ms": spread(&mut intervals), "width": spread(&mut widths),
    }))
}

fn spread(values: &mut [f64]) -> Value {
    values.sort_by(f64::total_cmp);
    let at =
        |share: f64| values.get(((values.len() as f64 * share) as usize).min(values.len().saturating_sub(1)));
    json!({ "median": at(0.5), "p99": at(0.99), "least": at(0.0), "most": at(1.0) })
}
