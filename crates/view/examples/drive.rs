//! Drives a running `midway view` without a browser, and measures it.
//!
//! `drive ADDRESS SECONDS` orbits with 60 inputs a second and prints frames a second, and the time from
//! an input's message to the decoded frame that shows it. `drive ADDRESS SECONDS CLIENTS PID` soaks:
//! clients send random requests and nonsense, and PID's memory is watched (Linux). Prints JSON.

use std::{
    collections::{HashMap, VecDeque},
    error::Error,
    time::{Duration, Instant},
};

use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use tokio::{task::JoinSet, time::timeout};
use tokio_tungstenite::{connect_async, tungstenite::Message};

type Outcome<T = ()> = Result<T, Box<dyn Error + Send + Sync>>;

/// Inputs a second of a hand that drags.
const INPUTS: f64 = 60.0;
/// Requests a second of a client that soaks.
const SOAK_REQUESTS: f64 = 8.0;
/// What a client that soaks looks at.
const LAYERS: [&str; 5] = ["beauty", "normal", "depth", "noise", "albedo"];
/// Measured after this long: the controller has settled.
const WARM_UP: Duration = Duration::from_secs(2);

#[tokio::main(flavor = "current_thread")]
async fn main() -> Outcome {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [address, seconds, rest @ ..] = arguments.as_slice() else {
        return Err("drive ADDRESS SECONDS [CLIENTS PID]".into());
    };
    let time = Duration::from_secs_f64(seconds.parse()?);
    let result = match rest {
        [] => measure(address, time).await?,
        [clients, pid] => soak(address, time, clients.parse()?, pid).await?,
        _ => return Err("CLIENTS and PID go together".into()),
    };
    println!("{result}");
    Ok(())
}

/// A scene's own view, turned about its target.
fn turned(view: &Value, angle: f64, input: u32) -> Value {
    let point = |name: &str| [0, 1, 2].map(|i| view[name][i].as_f64().unwrap_or(0.0));
    let (eye, target) = (point("eye"), point("target"));
    let (x, z) = (eye[0] - target[0], eye[2] - target[2]);
    let (sin, cos) = angle.sin_cos();
    let eye = [target[0] + x * cos + z * sin, eye[1], target[2] - x * sin + z * cos];
    json!({ "type": "look", "eye": eye, "target": target, "up": [0, 1, 0], "input": input })
}

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

async fn measure(address: &str, time: Duration) -> Outcome<Value> {
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

/// Numbers that look random (xorshift32).
struct Dice(u32);

impl Dice {
    fn roll(&mut self, n: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 % n
    }
}

fn any_request(dice: &mut Dice, view: &Value) -> String {
    let method = |dice: &mut Dice| {
        let integrator = ["path-naive", "path", "light", "bdpt"][dice.roll(4) as usize];
        let join = ["full", "k-step", "single-step"][dice.roll(3) as usize];
        json!({ "integrator": integrator, "join": join, "k": 1 + dice.roll(9), "pool": dice.roll(2) == 0 })
    };
    match dice.roll(25) {
        0 => json!({ "type": "render", "method": method(dice) }),
        1 => json!({ "type": "split", "right": if dice.roll(2) == 0 { Value::Null } else { method(dice) } }),
        2 => json!({ "type": "render", "size": [64 + dice.roll(128), 64 + dice.roll(128)] }),
        3 => json!({ "type": "region", "window": if dice.roll(2) == 0 { Value::Null } else { json!([9, 9, 20, 20]) } }),
        4 => json!({ "type": "show", "exposure": f64::from(dice.roll(8)) - 4.0, "tone_map": "aces",
            "layer": LAYERS[dice.roll(5) as usize] }),
        5 => json!({ "type": "restart" }),
        6 => json!({ "type": "take" }),
        7 => json!({ "type": "pick", "x": 0.4, "y": 0.6 }),
        8 => json!({ "type": "render", "max_path_length": dice.roll(9) }),
        9 => json!({ "type": "environment", "strength": f64::from(dice.roll(3)), "rotation": 30 }),
        11 => json!({ "type": "mix", "factors": if dice.roll(2) == 0 { Value::Null } else { json!([[1, 0.5, dice.roll(3)]]) } }),
        10 => return (0..dice.roll(300)).map(|_| char::from(b' ' + dice.roll(95) as u8)).collect(),
        angle => turned(view, f64::from(angle) / 10.0, angle),
    }
    .to_string()
}

/// A wait for a frame that is told of is at least this long, in seconds.
const STALL: f64 = 1.0;
/// Requests before it that are told.
const LAST: usize = 6;

/// What a client that soaks has seen.
struct Seen {
    frames: u64,
    /// Seconds.
    longest_wait: f64,
    /// Waits of [`STALL`] or more: with what the server's process had of the processors meanwhile, and
    /// the last requests.
    stalls: Vec<Value>,
}

/// One client that soaks.
async fn torment(address: String, time: Duration, seed: u32, pid: String) -> Outcome<Seen> {
    let (socket, _) = connect_async(format!("ws://{address}/ws")).await?;
    let (mut sink, mut stream) = socket.split();
    let (mut dice, mut view) = (Dice(seed), Value::Null);
    let mut seen = Seen { frames: 0, longest_wait: 0.0, stalls: Vec::new() };
    let (start, mut last, mut spent) = (Instant::now(), Instant::now(), processor_seconds(&pid)?);
    let mut asked: VecDeque<String> = VecDeque::new();
    let mut clock = tokio::time::interval(Duration::from_secs_f64(1.0 / SOAK_REQUESTS));
    while start.elapsed() < time {
        tokio::select! {
            _ = clock.tick() => if !view.is_null() {
                let request = any_request(&mut dice, &view);
                asked.push_back(format!("{:.2} {request}", start.elapsed().as_secs_f64()));
                if asked.len() > LAST {
                    asked.pop_front();
                }
                timeout(Duration::from_secs(30), sink.send(Message::text(request))).await??;
            },
            message = stream.next() => match message.ok_or("the server has gone")?? {
                Message::Binary(_) => {
                    let (wait, now) = (last.elapsed().as_secs_f64(), processor_seconds(&pid)?);
                    if wait >= STALL {
                        let at = start.elapsed().as_secs_f64();
                        seen.stalls.push(json!({ "at": at, "wait_s": wait, "processor_s": now - spent, "last": asked }));
                    }
                    seen.frames += 1;
                    seen.longest_wait = seen.longest_wait.max(wait);
                    (last, spent) = (Instant::now(), now);
                    sink.send(Message::text(r#"{"type":"decoded"}"#)).await?;
                }
                Message::Text(text) => {
                    let told: Value = serde_json::from_str(&text)?;
                    if told["type"] == "scene" && told["view"].is_object() {
                        view = told["view"].clone();
                    }
                }
                _ => {}
            },
        }
    }
    Ok(seen)
}

/// What a process has had of the processors, in seconds of 100 ticks (Linux).
fn processor_seconds(pid: &str) -> Outcome<f64> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat"))?;
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |field: usize| fields.get(field).and_then(|f| f.parse::<f64>().ok()).ok_or("no times");
    Ok((ticks(11)? + ticks(12)?) / 100.0)
}

fn resident_mib(pid: &str) -> Outcome<f64> {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status"))?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).ok_or("no VmRSS")?;
    Ok(line.trim().trim_end_matches(" kB").parse::<f64>()? / 1024.0)
}

async fn soak(address: &str, time: Duration, clients: u32, pid: &str) -> Outcome<Value> {
    let mut tasks = JoinSet::new();
    for client in 0..clients {
        tasks.spawn(torment(address.to_owned(), time, 0x9e37_79b9 ^ (client + 1), pid.to_owned()));
    }
    let (mut memory, start) = (Vec::new(), Instant::now());
    while start.elapsed() < time && !tasks.is_empty() {
        tokio::time::sleep(time / 60).await;
        memory.push(resident_mib(pid)?);
    }
    let (mut frames, mut longest, mut stalls) = (0, 0f64, Vec::new());
    while let Some(client) = tasks.join_next().await {
        let seen = client??;
        frames += seen.frames;
        longest = longest.max(seen.longest_wait);
        stalls.extend(seen.stalls);
    }
    // Highest of a sixth early on, and of the last sixth: requests come and go in between.
    let peak = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
    let sixth = memory.len() / 6;
    let (early, late) = (peak(&memory[sixth..2 * sixth]), peak(&memory[memory.len() - sixth..]));
    Ok(json!({
        "seconds": time.as_secs_f64(), "clients": clients, "frames": frames, "longest_wait_s": longest, "stalls": stalls,
        "memory_mib_peaks": memory.chunks(5).map(peak).collect::<Vec<_>>(), "memory_mib_early": early, "memory_mib_late": late, "growth": late / early - 1.0,
    }))
}
