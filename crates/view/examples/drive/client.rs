//! One client that soaks.

use std::{
    collections::VecDeque,
    time::{Duration, Instant},
};

use futures_util::{
    SinkExt, StreamExt,
    stream::{SplitSink, SplitStream},
};
use serde_json::{Value, json};
use tokio::{net::TcpStream, task::JoinSet, time::timeout};
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async, tungstenite::Message};

use crate::{
    Outcome,
    files::files,
    gone, http,
    requests::{Act, Dice, any},
    soak::processor_seconds,
    verdict::{STALL, Seen},
};

/// Requests a second.
const REQUESTS: f64 = 8.0;
/// Requests before a stall that are told.
const LAST: usize = 6;
/// How long nothing is taken in a nap.
const NAP: Duration = Duration::from_secs(3);
/// The first number of uploads that are rested on.
const REST_BATCH: u32 = 1_000_000;
/// Frames until what was asked for last is shown.
const RESTING_FRAMES: u64 = 8;
/// How long an answer may take.
const PATIENCE: Duration = Duration::from_secs(30);

type Socket = WebSocketStream<MaybeTlsStream<TcpStream>>;

struct Client {
    address: String,
    pid: String,
    number: u32,
    dice: Dice,
    sink: SplitSink<Socket, Message>,
    stream: SplitStream<Socket>,
    /// What uploads carry.
    key: String,
    /// The scene's name, and the view that it was told with; null where it is not told yet.
    named: String,
    view: Value,
    variants: u32,
    /// What takes long beside: the message that follows from it.
    beside: JoinSet<Outcome<Option<String>>>,
    start: Instant,
    /// When the last frame came, or none was due.
    last: Instant,
    /// Of the server's processors then.
    spent: f64,
    asked: VecDeque<String>,
    /// Nonsense under way.
    pending: u64,
    seen: Seen,
}

/// Torments a server for some time, and tells what it has seen.
pub async fn torment(address: String, time: Duration, number: u32, pid: String) -> Seen {
    let failed = |seen: Seen, error| Seen { failures: vec![format!("client {number}: {error}")], ..seen };
    match Client::start(address, number, pid).await {
        Err(error) => failed(Seen::default(), error),
        Ok(mut client) => match client.run(time).await {
            Err(error) => failed(client.seen, error),
            Ok(()) => client.seen,
        },
    }
}

/// Has a server show a small scene, plainly, and rest so long.
pub async fn rest(address: &str, time: Duration) -> Outcome {
    let mut client = Client::start(address.to_owned(), 0, std::process::id().to_string()).await?;
    timeout(PATIENCE, client.settle()).await.map_err(|_| "it took too long")??;
    tokio::time::sleep(time).await;
    Ok(())
}

async fn connect(address: &str) -> Outcome<(SplitSink<Socket, Message>, SplitStream<Socket>)> {
    let connected = timeout(PATIENCE, connect_async(format!("ws://{address}/ws"))).await.map_err(gone)?;
    Ok(connected.map_err(gone)?.0.split())
}

impl Client {
    async fn start(address: String, number: u32, pid: String) -> Outcome<Self> {
        let (sink, stream) = connect(&address).await?;
        let spent = processor_seconds(&pid)?;
        Ok(Self {
            address,
            pid,
            number,
            dice: Dice(0x9e37_79b9 ^ number),
            sink,
            stream,
            key: String::new(),
            named: String::new(),
            view: Value::Null,
            variants: 0,
            beside: JoinSet::new(),
            start: Instant::now(),
            last: Instant::now(),
            spent,
            asked: VecDeque::new(),
            pending: 0,
            seen: Seen::default(),
        })
    }

    async fn run(&mut self, time: Duration) -> Outcome {
        let mut clock = tokio::time::interval(Duration::from_secs_f64(1.0 / REQUESTS));
        // At the end all that is to be refused may still be.
        while self.start.elapsed() < time || (self.pending > 0 && self.start.elapsed() < time + PATIENCE) {
            tokio::select! {
                _ = clock.tick() => if !self.view.is_null() && self.start.elapsed() < time {
                    self.act().await?;
                },
                message = self.stream.next() => {
                    let message = message.ok_or_else(|| gone("it closed the connection"))?.map_err(gone)?;
                    self.hear(message).await?;
                }
                Some(done) = self.beside.join_next() => if let Some(request) = done?? {
                    self.send(Message::text(request)).await?;
                },
            }
        }
        self.seen.unanswered += self.pending;
        self.frame_is_due()
    }

    /// Until the scene of an upload is shown by `path` alone.
    async fn settle(&mut self) -> Outcome {
        while self.key.is_empty() {
            self.hear_next().await?;
        }
        self.ask(&json!({ "type": "take" })).await?;
        // A scene is opened as the one before is rendered.
        self.ask_plainly().await?;
        let batch = REST_BATCH + std::process::id() % 1000;
        let open = http::upload(&self.address, &self.key, batch, 0).await?;
        self.send(Message::text(open.ok_or("another client steers")?)).await?;
        while self.named != files(0)[0].0 {
            self.hear_next().await?;
        }
        self.ask_plainly().await?;
        let shown = self.seen.frames + RESTING_FRAMES;
        while self.seen.frames < shown {
            self.hear_next().await?;
        }
        Ok(())
    }

    async fn ask_plainly(&mut self) -> Outcome {
        for request in [
            json!({ "type": "pause", "paused": false }),
            json!({ "type": "split", "right": null }),
            json!({ "type": "mix", "factors": null }),
            json!({ "type": "region", "window": null }),
            json!({ "type": "show", "exposure": 0, "tone_map": "agx" }),
            json!({ "type": "environment", "strength": 0, "rotation": 0 }),
            json!({ "type": "render", "size": [128, 128], "method": { "integrator": "path" }, "max_path_length": 0 }),
        ] {
            self.ask(&request).await?;
        }
        Ok(())
    }

    async fn ask(&mut self, request: &Value) -> Outcome {
        self.send(Message::text(request.to_string())).await
    }

    async fn hear_next(&mut self) -> Outcome {
        let message = self.stream.next().await;
        let message = message.ok_or_else(|| gone("it closed the connection"))?.map_err(gone)?;
        self.hear(message).await
    }

    async fn send(&mut self, message: Message) -> Outcome {
        timeout(PATIENCE, self.sink.send(message)).await.map_err(gone)?.map_err(gone)
    }

    async fn act(&mut self) -> Outcome {
        let act = any(&mut self.dice, &self.view, self.variants);
        self.seen.requests += 1;
        let (told, message) = match act {
            Act::Ask(request) => (request.to_string(), Some(Message::text(request.to_string()))),
            Act::Nonsense(text) => (text.clone(), Some(self.nonsense(Message::text(text)))),
            Act::Bytes(bytes) => ("bytes".to_owned(), Some(self.nonsense(Message::binary(bytes)))),
            Act::Upload(which) => (format!("upload {which}"), self.upload(which)),
            Act::Save(format) => (format!("save {format}"), self.save(format)),
            Act::Nap => {
                tokio::time::sleep(NAP).await;
                self.seen.naps += 1;
                self.last = Instant::now();
                ("nap".to_owned(), None)
            }
            Act::Vanish => {
                (self.sink, self.stream) = connect(&self.address).await?;
                self.seen.vanished += 1;
                (self.view, self.pending, self.last) = (Value::Null, 0, Instant::now());
                ("vanish".to_owned(), None)
            }
        };
        self.asked.push_back(format!("{:.2} {told}", self.start.elapsed().as_secs_f64()));
        if self.asked.len() > LAST {
            self.asked.pop_front();
        }
        match message {
            Some(message) => self.send(message).await,
            None => Ok(()),
        }
    }

    fn nonsense(&mut self, message: Message) -> Message {
        self.seen.nonsense += 1;
        self.pending += 1;
        message
    }

    fn upload(&mut self, which: u32) -> Option<Message> {
        self.seen.uploads += 1;
        // Clients choose other numbers.
        let batch = 1000 * self.number + self.seen.uploads as u32;
        let (address, key) = (self.address.clone(), self.key.clone());
        self.beside.spawn(async move { http::upload(&address, &key, batch, which).await });
        None
    }

    fn save(&mut self, format: &'static str) -> Option<Message> {
        self.seen.saves += 1;
        let address = self.address.clone();
        self.beside.spawn(async move { http::save(&address, format).await.map(|_| None) });
        None
    }

    async fn hear(&mut self, message: Message) -> Outcome {
        match message {
            Message::Binary(_) => {
                self.frame_is_due()?;
                self.seen.frames += 1;
                (self.last, self.spent) = (Instant::now(), processor_seconds(&self.pid)?);
                self.send(Message::text(r#"{"type":"decoded"}"#)).await
            }
            Message::Text(text) => self.told(&serde_json::from_str(&text)?),
            _ => Ok(()),
        }
    }

    /// Notes how long it has been waited for.
    fn frame_is_due(&mut self) -> Outcome {
        let wait = self.last.elapsed().as_secs_f64();
        self.seen.longest_wait = self.seen.longest_wait.max(wait);
        if wait >= STALL {
            let (at, spent) =
                (self.start.elapsed().as_secs_f64(), processor_seconds(&self.pid)? - self.spent);
            self.seen
                .stalls
                .push(json!({ "at": at, "wait_s": wait, "processor_s": spent, "last": self.asked }));
        }
        Ok(())
    }

    fn told(&mut self, told: &Value) -> Outcome {
        match told["type"].as_str() {
            Some("hello") => self.key = told["key"].as_str().unwrap_or_default().to_owned(),
            Some("scene") if told["view"].is_object() => {
                told["name"].as_str().unwrap_or_default().clone_into(&mut self.named);
                self.view = told["view"].clone();
                self.variants = told["variants"].as_array().map_or(0, Vec::len) as u32;
            }
            Some("refused") => {
                let reason = told["reason"].as_str().unwrap_or_default();
                let is_for_nonsense = reason.starts_with("bad message") || reason == "messages are text";
                self.pending = self.pending.saturating_sub(u64::from(is_for_nonsense));
            }
            Some("status") => {
                // Nothing new is shown while it is paused.
                if (told["paused"] == true && told["moving"] == false) || told["done"] == true {
                    self.last = Instant::now();
                }
                if let Some(why) = told["failure"].as_str() {
                    return Err(format!("the renderer stopped: {why}").into());
                }
            }
            _ => {}
        }
        Ok(())
    }
}
