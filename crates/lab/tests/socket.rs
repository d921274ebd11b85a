//! The protocol over a socket, and the requests that the server refuses.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_lab::{Runs, Server, limits};
use serde_json::{Value, json};
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::sync::{PoisonError, RwLock, RwLockReadGuard};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

/// Longest wait. A busy machine may need so long.
const PATIENCE: Duration = Duration::from_secs(120);

/// Held for writing by the test that measures the memory of the process.
static MEMORY: RwLock<()> = RwLock::new(());

/// A server that ends when it is dropped.
struct Running {
    address: String,
    runs: Runs,
    end: Option<tokio::sync::oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
    _others: Option<RwLockReadGuard<'static, ()>>,
}

impl Running {
    fn start() -> Self {
        let others = MEMORY.read().unwrap_or_else(PoisonError::into_inner);
        Self::begin(Some(others))
    }

    fn begin(others: Option<RwLockReadGuard<'static, ()>>) -> Self {
        let server = Server::bind(0).unwrap();
        let (address, runs) = (server.address(), server.runs());
        let (end, ended) = tokio::sync::oneshot::channel::<()>();
        let serve = move || {
            let ended = async move {
                let _ = ended.await;
            };
            server.serve(ended).unwrap();
        };
        let thread = Some(std::thread::spawn(serve));
        Self { address, runs, end: Some(end), thread, _others: others }
    }

    /// `127.0.0.1:PORT`.
    fn host(&self) -> &str {
        self.address.strip_prefix("http://").unwrap().split('/').next().unwrap()
    }

    /// `/TOKEN/`.
    fn path(&self) -> String {
        self.address.replace(&format!("http://{}", self.host()), "")
    }

    /// The whole answer to a GET request.
    fn get(&self, path: &str, host: &str, more: &str) -> String {
        let mut stream = TcpStream::connect(self.host()).unwrap();
        let request =
            format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}Connection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).unwrap();
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    }

    /// A socket that says that it belongs to a page of `origin`.
    fn connect(&self, path: &str, origin: Option<&str>) -> Result<Page, u16> {
        let url = format!("ws://{}{path}", self.host());
        let mut request = url.into_client_request().unwrap();
        if let Some(origin) = origin {
            request.headers_mut().insert("Origin", origin.parse().unwrap());
        }
        let stream = TcpStream::connect(self.host()).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        match tungstenite::client(request, stream) {
            Ok((socket, _)) => Ok(Page(socket)),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
                Err(answer.status().as_u16())
            }
            Err(error) => panic!("{error}"),
        }
    }

    fn open(&self) -> Page {
        let origin = format!("http://{}", self.host());
        let mut page = self.connect(&format!("{}socket", self.path()), Some(&origin)).unwrap();
        assert_eq!(page.hear()["tell"], "hello");
        page
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.end.take().unwrap().send(());
        self.thread.take().unwrap().join().unwrap();
    }
}

struct Page(WebSocket<TcpStream>);

impl Page {
    fn say(&mut self, text: &str) {
        self.0.send(Message::text(text)).unwrap();
    }

    /// The next JSON message.
    fn hear(&mut self) -> Value {
        loop {
            if let Message::Text(text) = self.0.read().unwrap() {
                return serde_json::from_str(&text).unwrap();
            }
        }
    }

    /// The next message of a kind.
    fn wait_for(&mut self, is_meant: impl Fn(&Value) -> bool) -> Value {
        let begin = Instant::now();
        loop {
            let message = self.hear();
            if is_meant(&message) {
                return message;
            }
            assert!(begin.elapsed() < PATIENCE, "last message: {message}");
        }
    }
}

impl Page {
    /// Waits for a message of a kind about each of the first `count` panes, in any order.
    fn wait_for_panes(&mut self, count: usize, is_meant: impl Fn(&Value) -> bool) {
        let mut seen = std::collections::BTreeSet::new();
        while seen.len() < count {
            seen.insert(self.wait_for(&is_meant)["pane"].as_u64().unwrap());
        }
    }
}

fn sheet(method: &str) -> Value {
    json!({ "scene": "hanging-textile-1e6", "method": method, "step": 0.01, "duration": 0.1 })
}

fn wait_until(what: &str, is_so: impl Fn() -> bool) {
    let begin = Instant::now();
    while !is_so() {
        assert!(begin.elapsed() < PATIENCE, "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn the_page_is_given_to_those_who_know_the_token_under_the_servers_own_name() {
    let server = Running::start();
    let (host, path) = (server.host().to_owned(), server.path());
    let page = server.get(&path, &host, "");
    assert!(page.starts_with("HTTP/1.1 200"), "{page}");
    let lower = page.to_lowercase();
    assert!(lower.contains("content-security-policy: default-src 'none'; script-src 'self'"));
    assert!(lower.contains("referrer-policy: no-referrer") && lower.contains("nosniff"));
    for (file, content) in [("lab.js", "three.js"), ("lab.css", ".pane")] {
        let answer = server.get(&format!("{path}{file}"), &host, "");
        assert!(answer.starts_with("HTTP/1.1 200") && answer.contains(content), "{file}");
    }
    let localhost = host.replace("127.0.0.1", "localhost");
    assert!(server.get(&path, &localhost, "").starts_with("HTTP/1.1 200"));
    let wrong = path.replace(|c: char| c.is_ascii_hexdigit(), "0");
    let (short, outside) = (&path[..path.len() - 2], format!("{path}../../../etc/passwd"));
    let longer = format!("{host}.example.org");
    for (path, host, code) in [
        ("/", host.as_str(), "404"),
        (wrong.as_str(), host.as_str(), "403"),
        (short, host.as_str(), "404"),
        (outside.as_str(), host.as_str(), "404"),
        (path.as_str(), "example.org", "403"),
        (path.as_str(), "127.0.0.1", "403"),
        (path.as_str(), longer.as_str(), "403"),
    ] {
        let answer = server.get(path, host, "");
        assert!(answer.starts_with(&format!("HTTP/1.1 {code}")), "{path} {host}: {answer}");
        assert!(!answer.contains("drape lab</title>"), "{path} {host}");
    }
    let two = server.get(&path, &host, "Host: example.org\r\n");
    assert!(two.starts_with("HTTP/1.1 40"), "{two}");
}

#[test]
fn a_page_of_another_origin_cannot_open_a_socket() {
    let server = Running::start();
    let path = format!("{}socket", server.path());
    let own = format!("http://{}", server.host());
    let other_port = own.replace("127.0.0.1:", "127.0.0.1:1");
    for origin in [
        None,
        Some("null"),
        Some("http://example.org"),
        Some("http://127.0.0.1"),
        Some(other_port.as_str()),
    ] {
        assert_eq!(server.connect(&path, origin).err(), Some(403), "{origin:?}");
    }
    assert_eq!(server.connect("/00/socket", Some(&own)).err(), Some(403));
    assert!(server.connect(&path, Some(&own)).is_ok());
}

#[test]
fn panes_run_in_step_and_say_how_to_repeat_them() {
    let server = Running::start();
    let mut page = server.open();
    let panes = json!([sheet("imex-euler"), sheet("imex-updated")]);
    page.say(&json!({ "do": "open", "panes": panes }).to_string());
    page.wait_for_panes(2, |m| m["tell"] == "scenery" && m["particles"] == 400);
    page.say(r#"{"do":"step"}"#);
    page.wait_for(|m| m["tell"] == "status" && m["numbers"]["step"] == 1);
    page.say(r#"{"do":"repeat","pane":1}"#);
    let repeat = page.wait_for(|m| m["tell"] == "repeat");
    let command = repeat["repeat"]["command"].as_str().unwrap();
    assert!(
        command.starts_with("drape run hanging-textile-1e6 --method imex-updated"),
        "{command}"
    );
    page.say(r#"{"do":"play"}"#);
    let is_ended = |m: &Value| m["tell"] == "status" && m["phase"]["kind"] == "ended";
    let status = page.wait_for(is_ended);
    assert_eq!(status["numbers"]["step"], 10);
    assert_eq!(status["verdict"]["is_final"], true);
    page.wait_for(is_ended);
    page.wait_for(|m| m["tell"] == "clock" && m["playing"] == false);
}

#[test]
fn what_cannot_be_done_is_said_and_the_session_goes_on() {
    let server = Running::start();
    let mut page = server.open();
    let seven = json!({ "do": "open", "panes": vec![sheet("imex-euler"); 7] }).to_string();
    for (request, named) in [
        (seven.as_str(), "7 panes; expected 1 to 6"),
        (r#"{"do":"open","panes":[]}"#, "0 panes"),
        (r#"{"do":"rate","rate":-1}"#, "rate -1"),
        (r#"{"do":"repeat","pane":0}"#, "pane 0"),
        (r#"{"do":"fly"}"#, "fly"),
    ] {
        page.say(request);
        let refused = page.wait_for(|m| m["tell"] == "refused");
        assert!(refused["sentence"].as_str().unwrap().contains(named), "{refused}");
    }
    // A set-up is refused in its pane; the others run.
    let mut wrong = sheet("imex-euler");
    wrong["scene"] = json!("../../etc/passwd");
    page.say(&json!({ "do": "open", "panes": [wrong, sheet("program:touch x")] }).to_string());
    page.wait_for_panes(2, |m| m["tell"] == "status" && m["phase"]["kind"] == "refused");
}

/// A message with a file.
fn file(name: &str, content: &str) -> Message {
    let mut bytes = u32::try_from(name.len()).unwrap().to_le_bytes().to_vec();
    bytes.extend([name, content].concat().as_bytes());
    Message::binary(bytes)
}

#[test]
fn files_references_and_hands_go_over_the_socket() {
    let server = Running::start();
    let mut page = server.open();
    let strip = "v 0 0 1\nv 1 0 1\nv 2 0 1\nv 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 5 4\nf 2 3 6 5\n";
    page.0.send(file("strip.obj", &strip.replace("6 5", "6 7"))).unwrap();
    let refused = page.wait_for(|m| m["tell"] == "refused");
    let sentence = refused["sentence"].as_str().unwrap();
    assert!(sentence.contains("strip.obj") && sentence.contains("line 8"), "{sentence}");
    page.0.send(file("strip.obj", strip)).unwrap();
    let dropped = page.wait_for(|m| m["tell"] == "dropped");
    assert_eq!(dropped["scene"]["name"], "file:strip.obj");
    assert_eq!(dropped["scene"]["stiffness"], 1e4);
    page.say(r#"{"do":"ghost","on":true}"#);
    let pane = json!({ "scene": "file:strip.obj", "method": "imex-updated", "duration": 60 });
    page.say(&json!({ "do": "open", "panes": [pane] }).to_string());
    page.say(r#"{"do":"play"}"#);
    let near = page.wait_for(|m| m["distance"].as_f64().is_some_and(|d| d > 0.0));
    assert!(near["distance"].as_f64().unwrap() < 0.5, "{near}");
    page.say(r#"{"do":"lead","particle":4,"by":[0.3,0,1e9]}"#);
    let refused = page.wait_for(|m| m["tell"] == "refused");
    assert!(refused["sentence"].as_str().unwrap().contains("way of the hand"), "{refused}");
    page.say(r#"{"do":"lead","particle":4,"by":[0.3,0,0]}"#);
    page.wait_for(|m| m["ghost"].as_str().is_some_and(|note| note.contains("the hand")));
    page.say(r#"{"do":"lead","particle":3,"by":[0,0,0]}"#);
    let refused = page.wait_for(|m| m["tell"] == "refused");
    assert!(refused["sentence"].as_str().unwrap().contains("expected 4"), "{refused}");
    page.say(r#"{"do":"let_go"}"#);
    let before = page.wait_for(|m| m["tell"] == "status")["numbers"]["step"].as_u64().unwrap();
    page.wait_for(|m| m["numbers"]["step"].as_u64().is_some_and(|step| step > before + 5));
    page.say(r#"{"do":"repeat","pane":0}"#);
    let repeat = page.wait_for(|m| m["tell"] == "repeat")["repeat"].clone();
    assert!(repeat["note"].as_str().unwrap().contains("moved by hand"), "{repeat}");
    assert_eq!(repeat["way"]["file"], "strip-by-hand.json");
}

/// Memory of this process that is in use, bytes.
fn memory() -> u64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    text.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or(0) * 4096
}

#[test]
fn malformed_messages_neither_crash_nor_leak() {
    let _alone = MEMORY.write().unwrap_or_else(PoisonError::into_inner);
    let server = Running::begin(None);
    let mut page = server.open();
    let mut send = |messages: usize| {
        for n in 0..messages {
            // Deep, cut off, of another type, unknown, with numbers out of range.
            let text = match n % 8 {
                0 => "[".repeat(1 + n % 500),
                1 => r#"{"do":"open","panes":[{"scene":"#.to_owned(),
                2 => format!(r#"{{"do":"open","panes":{n}}}"#),
                3 => format!(r#"{{"do":"{}"}}"#, "é\u{202e}".repeat(n % 50)),
                4 => r#"{"do":"rate","rate":1e999}"#.to_owned(),
                5 => format!(r#"{{"do":"repeat","pane":{}}}"#, u64::MAX),
                6 => String::new(),
                _ => "\"\\ud800\"".to_owned(),
            };
            let bytes = n % 16 == 15;
            let message = if bytes { Message::binary(text) } else { Message::text(text) };
            page.0.send(message).unwrap();
            assert_eq!(page.wait_for(|m| m["tell"] != "clock")["tell"], "refused");
        }
    };
    send(1000);
    let before = memory();
    send(9000);
    let grown = memory().saturating_sub(before);
    assert!(grown < 8 << 20, "memory grew by {grown} bytes");
    page.say(&json!({ "do": "open", "panes": [sheet("imex-euler")] }).to_string());
    page.wait_for(|m| m["tell"] == "scenery");
}

#[test]
fn a_message_that_is_too_long_ends_its_session_alone() {
    let server = Running::start();
    let (mut page, mut other) = (server.open(), server.open());
    let long = format!(r#"{{"do":"{}"}}"#, "x".repeat(limits::MESSAGE_BYTES));
    // The server may have ended the session before all of the message is sent.
    let _ = page.0.send(Message::text(long));
    let begin = Instant::now();
    while page.0.read().is_ok() {
        assert!(begin.elapsed() < PATIENCE);
    }
    other.say(r#"{"do":"fly"}"#);
    other.wait_for(|m| m["tell"] == "refused");
}

#[test]
fn there_are_so_many_sessions_and_a_closed_one_makes_room() {
    let server = Running::start();
    let mut pages: Vec<_> = (0..limits::SESSIONS).map(|_| server.open()).collect();
    let path = format!("{}socket", server.path());
    let own = format!("http://{}", server.host());
    assert_eq!(server.connect(&path, Some(&own)).err(), Some(503));
    drop(pages.pop());
    wait_until("a closed session makes room", || server.connect(&path, Some(&own)).is_ok());
}

#[test]
fn sessions_that_close_leave_no_run_behind() {
    let server = Running::start();
    for session in 0..200 {
        let mut page = loop {
            let path = format!("{}socket", server.path());
            let own = format!("http://{}", server.host());
            if let Ok(page) = server.connect(&path, Some(&own)) {
                break page;
            }
        };
        let panes = json!([sheet("explicit-euler"), sheet("imex-euler"), sheet("imex-updated")]);
        page.say(&json!({ "do": "open", "panes": panes }).to_string());
        page.say(r#"{"do":"play"}"#);
        // Some sessions end at once, some while their panes run.
        if session % 10 == 0 {
            page.wait_for(|m| m["tell"] == "status");
            assert!(server.runs.count() > 0);
        }
    }
    wait_until("all runs end", || server.runs.count() == 0);
}
