//! The server: the page, what it is made of, uploads, saved pictures, and the WebSocket.

use std::{
    collections::HashMap,
    net::{IpAddr, Ipv4Addr, SocketAddr},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use axum::{
    Router,
    body::{Body, Bytes},
    extract::{DefaultBodyLimit, FromRequest, Path, Request, State, WebSocketUpgrade},
    http::{HeaderMap, HeaderValue, StatusCode, header},
    middleware::{self, Next},
    response::{IntoResponse, Response},
    routing::{get, put},
};
use tokio::{net::TcpListener, sync::oneshot, task::JoinSet};

use crate::{
    ViewError, client,
    guard::Guard,
    protocol::MAX_MESSAGE,
    save::Format,
    session::{Command, Session},
    uploads::{MAX_FILE, Uploads},
};

/// Browsers at once.
const MAX_CLIENTS: usize = 32;

/// What the page is made of, in the program.
const PAGE: &[(&str, &str, &str)] = &[
    ("", "text/html; charset=utf-8", include_str!("../page/index.html")),
    ("style.css", "text/css; charset=utf-8", include_str!("../page/style.css")),
    ("main.js", "text/javascript; charset=utf-8", include_str!("../page/main.js")),
    ("lights.js", "text/javascript; charset=utf-8", include_str!("../page/lights.js")),
    ("link.js", "text/javascript; charset=utf-8", include_str!("../page/link.js")),
    ("aim.js", "text/javascript; charset=utf-8", include_str!("../page/aim.js")),
    ("kept.js", "text/javascript; charset=utf-8", include_str!("../page/kept.js")),
    ("keys.js", "text/javascript; charset=utf-8", include_str!("../page/keys.js")),
    ("camera.js", "text/javascript; charset=utf-8", include_str!("../page/camera.js")),
    ("stage.js", "text/javascript; charset=utf-8", include_str!("../page/stage.js")),
    ("panel.js", "text/javascript; charset=utf-8", include_str!("../page/panel.js")),
    ("plot.js", "text/javascript; charset=utf-8", include_str!("../page/plot.js")),
    ("saved.js", "text/javascript; charset=utf-8", include_str!("../page/saved.js")),
    ("drop.js", "text/javascript; charset=utf-8", include_str!("../page/drop.js")),
    ("icon.svg", "image/svg+xml", include_str!("../page/icon.svg")),
];

/// Nothing but the page's own files, from nowhere else, in nobody's frame.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; \
                      connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Where to listen.
#[derive(Clone, Copy, Debug)]
pub struct Address {
    /// None: loopback.
    pub ip: Option<IpAddr>,
    /// 0: any that is free.
    pub port: u16,
}

/// Browsers that are connected.
#[derive(Default)]
pub struct Clients {
    /// Each with the key that its uploads carry.
    pub keys: HashMap<u64, String>,
    /// The one that steers.
    pub steering: Option<u64>,
    last: u64,
}

impl Clients {
    /// Adds one; the first steers. None where there are too many.
    pub fn add(&mut self, key: String) -> Option<u64> {
        if self.keys.len() >= MAX_CLIENTS {
            return None;
        }
        self.last += 1;
        self.keys.insert(self.last, key);
        self.steering.get_or_insert(self.last);
        Some(self.last)
    }

    /// Removes one; the oldest steers if it did.
    pub fn remove(&mut self, client: u64) {
        self.keys.remove(&client);
        if self.steering == Some(client) {
            self.steering = self.keys.keys().min().copied();
        }
    }
}

/// What all requests share.
pub struct Shared {
    /// The render thread.
    pub session: Session,
    /// Uploaded files.
    pub uploads: Uploads,
    /// Whether nobody may steer.
    pub read_only: bool,
    clients: Mutex<Clients>,
    /// Counts the changes of `clients`, so that all are told.
    pub roles: tokio::sync::watch::Sender<u64>,
    guard: Guard,
    say: fn(&str),
}

impl Shared {
    /// The browsers, for a moment.
    pub fn clients(&self) -> MutexGuard<'_, Clients> {
        self.clients.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a request carries the key of the browser that steers.
    fn may_change(&self, headers: &HeaderMap) -> bool {
        let given = headers.get("x-midway-key").and_then(|value| value.to_str().ok());
        let clients = self.clients();
        let key = clients.steering.and_then(|client| clients.keys.get(&client));
        !self.read_only && given.is_some() && given == key.map(String::as_str)
    }
}

/// A server that listens, and does not serve yet.
pub struct Server {
    listener: std::net::TcpListener,
    shared: Arc<Shared>,
}

impl Server {
    /// Listens. `say` prints a line for people.
    ///
    /// # Errors
    /// [`ViewError::Listen`].
    pub fn listen(
        address: Address,
        session: Session,
        read_only: bool,
        say: fn(&str),
    ) -> Result<Self, ViewError> {
        let wanted = SocketAddr::new(address.ip.unwrap_or(IpAddr::V4(Ipv4Addr::LOCALHOST)), address.port);
        let refused = |source| ViewError::Listen { address: wanted, source };
        let listener = std::net::TcpListener::bind(wanted).map_err(refused)?;
        listener.set_nonblocking(true)?;
        let guard = Guard::new(listener.local_addr()?)?;
        let shared = Shared {
            session,
            uploads: Uploads::new(),
            read_only,
            clients: Mutex::default(),
            roles: tokio::sync::watch::Sender::new(0),
            guard,
            say,
        };
        Ok(Self { listener, shared: Arc::new(shared) })
    }

    /// Where browsers find the page, with the token where there is one: one place or several, the likeliest
    /// first.
    pub fn urls(&self) -> Vec<String> {
        self.shared.guard.urls()
    }

    /// Opens the page in this machine's browser, if it has one.
    pub fn open_browser(&self) {
        if let Some(Err(error)) = self.urls().first().map(open::that_detached) {
            (self.shared.say)(&format!("no browser could be opened: {error}"));
        }
    }

    /// Serves until `stop` says so, on this thread.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn serve(self, stop: impl Fn() -> bool + Send + 'static) -> Result<(), ViewError> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        runtime.block_on(async move {
            let listener = TcpListener::from_std(self.listener)?;
            let mut tasks = JoinSet::new();
            let service = axum::serve(listener, router(self.shared));
            tasks.spawn(async move { service.await.map_err(ViewError::from) });
            tasks.spawn(async move {
                while !stop() {
                    tokio::time::sleep(std::time::Duration::from_millis(50)).await;
                }
                Ok(())
            });
            // The first that ends, ends all: open sockets do not hold the program up.
            tasks.join_next().await.map_or(Ok(()), |ended| ended.unwrap_or(Ok(())))
        })
    }
}

fn router(shared: Arc<Shared>) -> Router {
    Router::new()
        .route("/", get(page))
        .route("/{file}", get(page))
        .route("/ws", get(socket))
        .route("/save/{format}", get(save))
        .route("/upload/{batch}/{*path}", put(upload).layer(DefaultBodyLimit::max(MAX_FILE)))
        .layer(middleware::from_fn_with_state(Arc::clone(&shared), check))
        .with_state(shared)
}

/// In front of everything: who asks, by what name; and what answers may be used for.
async fn check(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let headers = request.headers();
    if !shared.guard.names_this_server(headers) {
        return refuse(StatusCode::FORBIDDEN, "this is not the name or the page of this server");
    }
    if !shared.guard.is_admitted(headers) {
        return admit(&shared, request.uri().query().unwrap_or_default());
    }
    let mut response = next.run(request).await;
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response.headers_mut().insert("cross-origin-resource-policy", HeaderValue::from_static("same-origin"));
    response
}

/// Gives a cookie for the token, and the page's address without it.
fn admit(shared: &Shared, query: &str) -> Response {
    let Ok(Some(cookie)) = shared.guard.redeem(query) else {
        return refuse(StatusCode::UNAUTHORIZED, "open the address that was printed when the server started");
    };
    (shared.say)(&format!("for another browser: {}", shared.guard.urls().join(" or ")));
    let headers = [(header::SET_COOKIE, cookie), (header::LOCATION, "/".to_owned())];
    (StatusCode::SEE_OTHER, headers).into_response()
}

fn refuse(status: StatusCode, why: &str) -> Response {
    (status, [(header::CONTENT_TYPE, "text/plain; charset=utf-8")], format!("{why}\n")).into_response()
}

async fn page(path: Option<Path<String>>) -> Response {
    let wanted = path.map_or(String::new(), |Path(file)| file);
    match PAGE.iter().find(|(name, ..)| *name == wanted) {
        Some((_, kind, text)) => ([(header::CONTENT_TYPE, *kind)], *text).into_response(),
        None => refuse(StatusCode::NOT_FOUND, "there is no such file"),
    }
}

async fn socket(State(shared): State<Arc<Shared>>, upgrade: WebSocketUpgrade) -> Response {
    let bounded = upgrade.max_message_size(MAX_MESSAGE).max_frame_size(MAX_MESSAGE);
    bounded.on_upgrade(move |socket| client::run(socket, shared))
}

async fn save(State(shared): State<Arc<Shared>>, Path(format): Path<String>) -> Response {
    let (format, kind) = match format.as_str() {
        "exr" => (Format::Exr, "image/x-exr"),
        "png" => (Format::Png, "image/png"),
        _ => return refuse(StatusCode::NOT_FOUND, "pictures are saved as exr or png"),
    };
    let (answer, saved) = oneshot::channel();
    if !shared.session.send(Command::Save(format, answer)) {
        return refuse(StatusCode::SERVICE_UNAVAILABLE, "too much waits");
    }
    match saved.await {
        Ok(Ok(bytes)) => ([(header::CONTENT_TYPE, kind)], Body::from(bytes)).into_response(),
        Ok(Err(why)) => refuse(StatusCode::CONFLICT, &why),
        Err(_) => refuse(StatusCode::INTERNAL_SERVER_ERROR, "the renderer has ended"),
    }
}

async fn upload(
    State(shared): State<Arc<Shared>>,
    Path((batch, path)): Path<(u64, String)>,
    request: Request,
) -> Response {
    // Before the body is read: what a stranger sends is not kept.
    if !shared.may_change(request.headers()) {
        return refuse(StatusCode::FORBIDDEN, "only the browser that steers may upload");
    }
    let bytes = match Bytes::from_request(request, &()).await {
        Ok(bytes) => bytes,
        Err(rejection) => return rejection.into_response(),
    };
    let written = tokio::task::spawn_blocking(move || shared.uploads.write(batch, &path, &bytes)).await;
    match written {
        Ok(Ok(())) => StatusCode::NO_CONTENT.into_response(),
        Ok(Err(error @ ViewError::Refused(_))) => refuse(StatusCode::BAD_REQUEST, &error.to_string()),
        _ => refuse(StatusCode::INTERNAL_SERVER_ERROR, "the file could not be kept"),
    }
}
