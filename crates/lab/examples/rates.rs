//! Measures how fast the lab is, as a page would see it over its socket.
//!
//! ```text
//! cargo run --release --example rates -p drape-lab
//! ```
//!
//! It tells the frames a second of each pane, the delay behind the clock, the share of the
//! processor, and the memory after many sessions. The numbers depend on the machine, so nothing here
//! passes or fails.

use drape_lab::Server;
use drape_report::tell;
use serde_json::{Value, json};
use std::error::Error;
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

/// How long a rate is measured.
const SPAN: Duration = Duration::from_secs(10);
/// Sessions that are opened and closed.
const SESSIONS: u32 = 200;
/// Six methods of different kinds.
const SIX: [&str; 6] =
    ["imex-euler", "imex-updated", "baraff-witkin", "backward-euler", "xpbd", "bdf2"];

type Outcome<T> = Result<T, Box<dyn Error>>;

/// A page that listens.
struct Page(WebSocket<TcpStream>);

impl Page {
    fn open(address: &str) -> Outcome<Self> {
        let rest = address.strip_prefix("http://").unwrap_or(address);
        let host = rest.split('/').next().unwrap_or_default();
        let mut request = format!("ws://{rest}socket").into_client_request()?;
        request.headers_mut().insert("Origin", format!("http://{host}").parse()?);
        let stream = TcpStream::connect(host)?;
        stream.set_nodelay(true)?;
        Ok(Self(tungstenite::client(request, stream)?.0))
    }

    fn say(&mut self, request: &Value) -> Outcome<()> {
        Ok(self.0.send(Message::text(request.to_string()))?)
    }

    fn show(&mut self, panes: &[Value], rate: f64) -> Outcome<()> {
        self.say(&json!({ "do": "rate", "rate": rate }))?;
        self.say(&json!({ "do": "wait", "wait": false }))?;
        self.say(&json!({ "do": "open", "panes": panes }))?;
        self.say(&json!({ "do": "play" }))
    }
}

/// Seconds of processor time of this process; 0 where the system does not tell.
fn processor() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let rest = text.rsplit(')').next().unwrap_or_default();
    let ticks = |n: usize| rest.split_whitespace().nth(n).and_then(|t| t.parse::<f64>().ok());
    // Linux counts hundredths of a second for user and system time.
    (ticks(11).unwrap_or(0.0) + ticks(12).unwrap_or(0.0)) / 100.0
}

/// Memory of this process that is in use, MiB; 0 where the system does not tell.
fn memory() -> f64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = text.split(' ').nth(1).and_then(|pages| pages.parse::<f64>().ok());
    pages.unwrap_or(0.0) * 4096.0 / f64::from(1 << 20)
}

/// Plays panes and tells their rates.
fn measure(address: &str, what: &str, panes: &[Value]) -> Outcome<()> {
    let mut page = Page::open(address)?;
    page.show(panes, 1.0)?;
    let mut frames = vec![0_u32; panes.len()];
    let mut last = vec![(0.0, 0.0, 0.0, String::new()); panes.len()];
    let mut begin: Option<(Instant, f64)> = None;
    let mut bytes = 0;
    while begin.is_none_or(|(begin, _)| begin.elapsed() < SPAN) {
        match page.0.read()? {
            Message::Binary(frame) => {
                let start = *begin.get_or_insert_with(|| (Instant::now(), processor()));
                if start.0.elapsed() < SPAN {
                    bytes += frame.len();
                    frames[usize::from(frame[0])] += 1;
                }
            }
            Message::Text(text) => {
                let told: Value = serde_json::from_str(&text)?;
                if told["tell"] == "status" {
                    let number = |value: &Value| value.as_f64().unwrap_or(0.0);
                    let (pane, numbers) = (told["pane"].as_u64().unwrap_or(0), &told["numbers"]);
                    let kind = told["phase"]["kind"].as_str().unwrap_or_default().to_owned();
                    last[usize::try_from(pane)?] = (
                        number(&told["behind"]),
                        number(&numbers["micros"]),
                        number(&numbers["times_real_time"]),
                        kind,
                    );
                }
            }
            _ => {}
        }
    }
    let Some((begin, busy)) = begin else { return Ok(()) };
    let span = begin.elapsed().as_secs_f64();
    let (share, rate) = ((processor() - busy) / span, bytes as f64 / span / 1e6);
    tell!("{what}: {share:.2} cores, {rate:.2} MB/s of positions");
    for (n, pane) in panes.iter().enumerate() {
        let (behind, micros, speed, phase) = &last[n];
        tell!(
            "  {}: {:.1} frames a second, {micros:.0} µs a step, {speed:.1} times real time, \
             {behind:.2} s behind, {phase}",
            pane["method"].as_str().unwrap_or_default(),
            f64::from(frames[n]) / span
        );
    }
    Ok(())
}

fn main() -> Outcome<()> {
    let server = Server::bind(0)?;
    let (address, runs) = (server.address(), server.runs());
    std::thread::spawn(move || server.serve(std::future::pending()));
    let pane = |method: &str, particles: u32| {
        json!({ "scene": "hanging-textile-1e6", "method": method, "step": 0.01,
            "duration": 3600, "particles": particles })
    };
    let six = SIX.map(|method| pane(method, 20));
    measure(&address, "six panes of 20 × 20", &six)?;
    measure(&address, "one pane of 100 × 100", &[pane("imex-euler", 100)])?;
    let begin = Instant::now();
    while runs.count() > 0 {
        std::thread::sleep(Duration::from_millis(10));
    }
    tell!("all runs ended {:.2} s after their pages", begin.elapsed().as_secs_f64());
    let mut before = memory();
    for session in 1..=SESSIONS {
        // A page that was closed makes room once its socket is gone.
        let mut page = loop {
            match Page::open(&address) {
                Ok(page) => break page,
                Err(_) => std::thread::sleep(Duration::from_millis(5)),
            }
        };
        page.show(&six, 1.0)?;
        while !page.0.read()?.is_binary() {}
        drop(page);
        while runs.count() > 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        if session == SESSIONS / 10 {
            before = memory();
            tell!("{before:.1} MiB after {session} sessions of six panes");
        }
    }
    tell!("{:.1} MiB after {SESSIONS} sessions: {:+.1} MiB", memory(), memory() - before);
    Ok(())
}
