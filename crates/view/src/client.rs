//! One browser: its requests to the session, the session's frames and figures to it, at the rate it
//! takes them.

use std::{
    sync::{Arc, atomic::Ordering},
    time::Duration,
};

use axum::extract::ws::{Message, WebSocket};
use futures_util::{SinkExt, StreamExt, stream::SplitSink};
use tokio::{sync::broadcast::error::RecvError, time::timeout};

use crate::{
    ViewError, guard,
    protocol::{Reply, Request},
    server::Shared,
    session::Command,
};

/// Frames that a browser may have been sent and not decoded.
const IN_FLIGHT: u32 = 2;
/// A browser that takes nothing for so long is gone.
const PATIENCE: Duration = Duration::from_secs(20);

/// Serves a browser until it goes.
pub async fn run(socket: WebSocket, shared: Arc<Shared>) {
    let Ok(key) = guard::secret() else { return };
    let Some(client) = shared.clients().add(key.clone()) else { return };
    shared.session.watchers.fetch_add(1, Ordering::Relaxed);
    shared.roles.send_modify(|changes| *changes += 1);
    serve(socket, &shared, client, key).await;
    shared.clients().remove(client);
    shared.session.watchers.fetch_sub(1, Ordering::Relaxed);
    shared.roles.send_modify(|changes| *changes += 1);
}

type Sink = SplitSink<WebSocket, Message>;

/// Sends, unless the browser takes nothing.
async fn send(sink: &mut Sink, message: Message) -> Option<()> {
    timeout(PATIENCE, sink.send(message)).await.ok()?.ok()
}

async fn say(sink: &mut Sink, reply: &Reply) -> Option<()> {
    send(sink, Message::Text(serde_json::to_string(reply).ok()?.into())).await
}

async fn serve(socket: WebSocket, shared: &Shared, client: u64, key: String) -> Option<()> {
    let session = &shared.session;
    let (mut sink, mut stream) = socket.split();
    let mut events = session.events.subscribe();
    let (mut frames, mut status, mut scene) =
        (session.frames.clone(), session.status.clone(), session.scene.clone());
    let mut roles = shared.roles.subscribe();
    for watched in [&mut status, &mut scene] {
        watched.mark_changed();
    }
    frames.mark_changed();
    roles.mark_changed();
    say(&mut sink, &Reply::Hello { client, key, version: env!("CARGO_PKG_VERSION") }).await?;
    let mut in_flight = 0u32;
    loop {
        tokio::select! {
            message = stream.next() => match message?.ok()? {
                Message::Text(text) => match obey(&text, shared, client) {
                    Ok(Obeyed::Decoded) => in_flight = in_flight.saturating_sub(1),
                    Ok(Obeyed::Done) => {}
                    Err(error) => say(&mut sink, &Reply::Refused { reason: error.to_string() }).await?,
                },
                Message::Close(_) => return None,
                Message::Binary(_) => {
                    say(&mut sink, &Reply::Refused { reason: "messages are text".into() }).await?;
                }
                Message::Ping(_) | Message::Pong(_) => {}
            },
            changed = frames.changed(), if in_flight < IN_FLIGHT => {
                changed.ok()?;
                let frame = Arc::clone(&frames.borrow_and_update());
                if frame.sequence > 0 {
                    in_flight += 1;
                    send(&mut sink, Message::Binary(frame.bytes.clone().into())).await?;
                }
            }
            changed = status.changed() => {
                changed.ok()?;
                let text = Arc::clone(&status.borrow_and_update());
                send(&mut sink, Message::Text((&*text).into())).await?;
            }
            changed = scene.changed() => {
                changed.ok()?;
                let text = Arc::clone(&scene.borrow_and_update());
                send(&mut sink, Message::Text((&*text).into())).await?;
            }
            changed = roles.changed() => {
                changed.ok()?;
                roles.mark_unchanged();
                let (steers, clients) = {
                    let all = shared.clients();
                    (all.steering == Some(client), all.keys.len())
                };
                say(&mut sink, &Reply::Role { steers, clients, read_only: shared.read_only }).await?;
            }
            event = events.recv() => match event {
                Ok(text) => send(&mut sink, Message::Text((&*text).into())).await?,
                Err(RecvError::Lagged(_)) => {}
                Err(RecvError::Closed) => return None,
            },
        }
    }
}

/// What a request came to.
enum Obeyed {
    /// It said that a frame was decoded.
    Decoded,
    /// It is carried out, or on its way.
    Done,
}

/// Carries out a request.
fn obey(text: &str, shared: &Shared, client: u64) -> Result<Obeyed, ViewError> {
    let request: Request =
        serde_json::from_str(text).map_err(|error| ViewError::Refused(format!("bad message: {error}")))?;
    if request == Request::Decoded {
        return Ok(Obeyed::Decoded);
    }
    if shared.read_only {
        return Err(ViewError::Refused("this picture is only to be looked at".into()));
    }
    if request == Request::Take {
        shared.clients().steering = Some(client);
        shared.roles.send_modify(|changes| *changes += 1);
        return Ok(Obeyed::Done);
    }
    if shared.clients().steering != Some(client) {
        return Err(ViewError::Refused("another browser steers; press Take over".into()));
    }
    let command = match request {
        Request::Open { batch, path } => Command::Open(shared.uploads.find(batch, &path)?),
        request => Command::Request(request),
    };
    if shared.session.send(command) {
        Ok(Obeyed::Done)
    } else {
        Err(ViewError::Refused("the renderer is busy".into()))
    }
}
