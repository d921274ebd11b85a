//! The transport: HTTP for the page and a WebSocket for each session, on the loopback address
//! alone.
//!
//! | check | reason |
//! |---|---|
//! | the server listens on 127.0.0.1 | no other machine reaches it |
//! | the address holds a random token | no other user of this machine knows it |
//! | `Host` names this server | another site may point its own name to 127.0.0.1 |
//! | `Origin` of a socket is this server | a page of another site cannot open one |
//! | size of messages, number of sessions, panes, particles and steps | [`crate::limits`] |

use crate::limits;
use crate::page::{ASSETS, Asset, POLICY, SOURCE, source};
use crate::session::{Out, Session};
use crate::work::Runs;
use axum::Router;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse as _, Response};
use axum::routing::{any, get};
use std::future::Future;
use std::io::Error;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};

/// Time between two looks at the panes.
const TICK: Duration = Duration::from_millis(33);
/// A page that takes no message for this long counts as gone.
const PATIENCE: Duration = Duration::from_secs(20);
/// Bytes of the token.
const TOKEN_BYTES: usize = 16;

/// A server that listens and does not answer yet.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    token: String,
    runs: Runs,
}

/// What all requests share.
#[derive(Clone, Debug)]
struct Shared {
    token: Arc<str>,
    port: u16,
    runs: Runs,
    sessions: Arc<Semaphore>,
}

impl Server {
    /// Listens on a port of the loopback address; 0 takes any free one.
    ///
    /// # Errors
    /// An I/O error if the port is taken, or if the operating system gives no random numbers.
    pub fn bind(port: u16) -> Result<Self, Error> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = listener.local_addr()?;
        listener.set_nonblocking(true)?;
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes).map_err(Error::other)?;
        let token = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { listener, address, token, runs: Runs::default() })
    }

    /// The address of the page, with the token.
    pub fn address(&self) -> String {
        format!("http://{}/{}/", self.address, self.token)
    }

    /// The runs of all sessions.
    pub fn runs(&self) -> Runs {
        self.runs.clone()
    }

    /// Answers requests until `end` is ready.
    ///
    /// # Errors
    /// An I/O error if the operating system refuses threads or sockets.
    pub fn serve(self, end: impl Future<Output = ()> + Send + 'static) -> Result<(), Error> {
        let shared = Shared {
            token: self.token.into(),
            port: self.address.port(),
            runs: self.runs,
            sessions: Arc::new(Semaphore::new(limits::SESSIONS)),
        };
        let runtime =
            tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
        let served = runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(self.listener)?;
            let server = axum::serve(listener, router(shared)).into_future();
            tokio::select! {
                served = server => served,
                () = end => Ok(()),
            }
        });
        runtime.shutdown_background();
        served
    }
}

fn router(shared: Shared) -> Router {
    let give = |name| get(move |path: Path<String>, state: State<Shared>| asset(path, state, name));
    Router::new()
        .route("/{token}/", give(""))
        .route("/{token}/lab.css", give("lab.css"))
        .route("/{token}/lab.js", give("lab.js"))
        .route(&format!("/{{token}}/{SOURCE}"), get(judgement))
        .route("/{token}/socket", any(socket))
        .fallback(async || refuse(StatusCode::NOT_FOUND, OPEN))
        .layer(from_fn_with_state(shared.clone(), check_host))
        .with_state(shared)
}

/// The text for a person who came without the token.
const OPEN: &str = "Open the address that `drape lab` printed: it holds a token.";

fn refuse(code: StatusCode, sentence: &str) -> Response {
    let kind = (header::CONTENT_TYPE, "text/plain; charset=utf-8");
    (code, [kind], sentence.to_owned() + "\n").into_response()
}

impl Shared {
    /// Whether a text is the name of this server, as browsers write it.
    fn is_own(&self, name: &str) -> bool {
        ["127.0.0.1", "localhost"].iter().any(|host| name == format!("{host}:{}", self.port))
    }

    /// Compares a token with that of this server, in a time that does not depend on the place of
    /// the first difference.
    fn knows(&self, token: &str) -> bool {
        let pairs = token.bytes().zip(self.token.bytes());
        token.len() == self.token.len() && pairs.fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
    }
}

/// The only value of a header; `None` if the header is missing, doubled or no text.
fn only(headers: &HeaderMap, name: header::HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(value)
}

/// Refuses requests under another name than this server's. Adds to all answers the headers that
/// isolate the page from other sites.
async fn check_host(State(shared): State<Shared>, request: Request, next: Next) -> Response {
    let is_own = only(request.headers(), header::HOST).is_some_and(|host| shared.is_own(host));
    let mut response = if is_own {
        next.run(request).await
    } else {
        refuse(StatusCode::FORBIDDEN, "The Host header names another server.")
    };
    let headers = [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ];
    for (name, value) in headers {
        response.headers_mut().insert(name, header::HeaderValue::from_static(value));
    }
    response
}

async fn asset(
    Path(token): Path<String>,
    State(shared): State<Shared>,
    name: &'static str,
) -> Response {
    if !shared.knows(&token) {
        return refuse(StatusCode::FORBIDDEN, OPEN);
    }
    match ASSETS.iter().find(|asset| asset.name == name) {
        Some(Asset { kind, bytes, .. }) => {
            ([(header::CONTENT_TYPE, *kind)], *bytes).into_response()
        }
        None => refuse(StatusCode::NOT_FOUND, OPEN),
    }
}

/// The source that decides the verdicts.
async fn judgement(Path(token): Path<String>, State(shared): State<Shared>) -> Response {
    if !shared.knows(&token) {
        return refuse(StatusCode::FORBIDDEN, OPEN);
    }
    ([(header::CONTENT_TYPE, "text/html; charset=utf-8")], source()).into_response()
}

async fn socket(
    Path(token): Path<String>,
    State(shared): State<Shared>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    if !shared.knows(&token) {
        return refuse(StatusCode::FORBIDDEN, OPEN);
    }
    let origin = only(&headers, header::ORIGIN).and_then(|origin| origin.strip_prefix("http://"));
    if !origin.is_some_and(|origin| shared.is_own(origin)) {
        return refuse(StatusCode::FORBIDDEN, "The Origin header names another page.");
    }
    let Ok(permit) = shared.sessions.clone().try_acquire_owned() else {
        let sentence = "Too many pages of the lab are open; close one.";
        return refuse(StatusCode::SERVICE_UNAVAILABLE, sentence);
    };
    upgrade
        .max_message_size(limits::FILE_MESSAGE_BYTES)
        .max_frame_size(limits::FILE_MESSAGE_BYTES)
        .on_upgrade(async move |socket| {
            converse(socket, Session::new(shared.runs)).await;
            drop(permit);
        })
}

/// Talks with a page until either side ends.
async fn converse(mut socket: WebSocket, mut session: Session) {
    let mut ticker = interval(TICK);
    ticker.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut last = Instant::now();
    let greeting = session.greet();
    if !send(&mut socket, vec![greeting]).await {
        return;
    }
    loop {
        let told = tokio::select! {
            message = socket.recv() => match message {
                // Only messages with files may be long.
                Some(Ok(Message::Text(text))) if text.len() > limits::MESSAGE_BYTES => return,
                Some(Ok(Message::Text(text))) => session.receive(&text),
                Some(Ok(Message::Binary(bytes))) => {
                    // A large mesh takes a while to read; other sessions go on meanwhile.
                    vec![tokio::task::block_in_place(|| session.receive_file(&bytes))]
                }
                Some(Ok(Message::Ping(_) | Message::Pong(_))) => Vec::new(),
                Some(Ok(Message::Close(_)) | Err(_)) | None => return,
            },
            now = ticker.tick() => {
                let elapsed = now.saturating_duration_since(last);
                last = now;
                session.tick(elapsed)
            }
        };
        if !send(&mut socket, told).await {
            return;
        }
    }
}

/// Sends messages; `false` if the page is gone.
async fn send(socket: &mut WebSocket, messages: Vec<Out>) -> bool {
    for message in messages {
        let message = match message {
            Out::Text(text) => Message::Text(text.into()),
            Out::Binary(bytes) => Message::Binary(bytes.into()),
        };
        if !matches!(timeout(PATIENCE, socket.send(message)).await, Ok(Ok(()))) {
            return false;
        }
    }
    true
}
