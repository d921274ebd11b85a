//! Measures the speed of the lab as a page sees it over its socket, and makes the page
//! `results/lab.md`.
//!
//! ```text
//! cargo run --release --example rates -p drape-lab > results/lab.md
//! ```
//!
//! It reports the pictures a second of each pane, the delay behind the clock, the share of the
//! processor, and the memory after many sessions. The numbers depend on the machine, so nothing
//! here passes or fails.

use drape_harness::{Source, methods, provenance};
use drape_lab::{Runs, Server};
use drape_report::number::significant;
use drape_report::tell;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::io::{ErrorKind, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

/// Time over which the rates of several panes, and of a large one, are measured.
const LONG: Duration = Duration::from_secs(10);
/// Time over which each method is measured.
const SHORT: Duration = Duration::from_secs(3);
/// Sessions that are opened and closed.
const SESSIONS: u32 = 200;
/// Six methods of different kinds.
const SIX: [&str; 6] =
    ["imex-euler", "imex-updated", "baraff-witkin", "backward-euler", "xpbd", "bdf2"];
/// Steps that are tried one after the other until a method does not diverge, s.
const STEPS_S: [f64; 4] = [0.01, 0.002, 5e-4, 1e-4];

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

    fn show(&mut self, panes: &[Value]) -> Outcome<()> {
        self.say(&json!({ "do": "rate", "rate": 1 }))?;
        self.say(&json!({ "do": "wait", "wait": false }))?;
        self.say(&json!({ "do": "open", "panes": panes }))?;
        self.say(&json!({ "do": "play" }))
    }

    /// The next message; `None` if none comes for a while.
    fn hear(&mut self) -> Outcome<Option<Message>> {
        self.0.get_ref().set_read_timeout(Some(Duration::from_secs(1)))?;
        match self.0.read() {
            Ok(message) => Ok(Some(message)),
            Err(tungstenite::Error::Io(error))
                if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) =>
            {
                Ok(None)
            }
            Err(error) => Err(error.into()),
        }
    }
}

/// Processor time of this process, s; 0 where the operating system does not report it.
fn processor() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let rest = text.rsplit(')').next().unwrap_or_default();
    let ticks = |n: usize| rest.split_whitespace().nth(n).and_then(|t| t.parse::<f64>().ok());
    // Linux counts hundredths of a second for user and system time.
    (ticks(11).unwrap_or(0.0) + ticks(12).unwrap_or(0.0)) / 100.0
}

/// Memory of this process that is in use, MiB; 0 where the operating system does not report it.
fn memory() -> f64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = text.split(' ').nth(1).and_then(|pages| pages.parse::<f64>().ok());
    pages.unwrap_or(0.0) * 4096.0 / f64::from(1 << 20)
}

/// The measurements of a pane.
#[derive(Clone, Debug, Default)]
struct Seen {
    /// Pictures a second.
    pictures: f64,
    /// Delay behind the clock, s.
    behind: f64,
    /// Time of a step, µs.
    micros: f64,
    /// Simulated seconds per second of computing.
    speed: f64,
    /// Whether it goes on.
    is_live: bool,
}

/// The measurements of a session.
struct Rates {
    /// Share of one core.
    cores: f64,
    panes: Vec<Seen>,
}

/// Plays panes for a while in real time. The clock begins with the first picture.
fn measure(server: &Lab, panes: &[Value], span: Duration) -> Outcome<Rates> {
    server.rest();
    let mut page = Page::open(&server.address)?;
    page.show(panes)?;
    let mut seen = vec![Seen { is_live: true, ..Seen::default() }; panes.len()];
    let mut begin: Option<(Instant, f64)> = None;
    while begin.is_none_or(|(begin, _)| begin.elapsed() < span) && seen.iter().all(|s| s.is_live) {
        match page.hear()? {
            Some(Message::Binary(frame)) => {
                begin.get_or_insert_with(|| (Instant::now(), processor()));
                seen[usize::from(frame[0])].pictures += 1.0;
            }
            Some(Message::Text(text)) => {
                let told: Value = serde_json::from_str(&text)?;
                if told["tell"] == "status" {
                    let number = |value: &Value| value.as_f64().unwrap_or(0.0);
                    let numbers = &told["numbers"];
                    let seen = &mut seen[told["pane"].as_u64().unwrap_or(0) as usize];
                    seen.behind = number(&told["behind"]);
                    seen.micros = number(&numbers["micros"]);
                    seen.speed = number(&numbers["times_real_time"]);
                    let phase = told["phase"]["kind"].as_str().unwrap_or_default();
                    seen.is_live = ["preparing", "ready"].contains(&phase);
                }
            }
            _ => {}
        }
    }
    let (begin, busy) = begin.ok_or("no picture came")?;
    let seconds = begin.elapsed().as_secs_f64();
    seen.iter_mut().for_each(|seen| seen.pictures /= seconds);
    Ok(Rates { cores: (processor() - busy) / seconds, panes: seen })
}

/// A server with its runs.
struct Lab {
    address: String,
    runs: Runs,
}

impl Lab {
    /// Waits until the runs of all pages that were closed have ended.
    fn rest(&self) {
        while self.runs.count() > 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Opens and closes sessions of six panes. Memory after a tenth of them, and after all, MiB.
    fn sessions(&self, panes: &[Value]) -> Outcome<[f64; 2]> {
        let mut early = 0.0;
        for session in 1..=SESSIONS {
            // A page that was closed makes room once its socket is gone.
            let mut page = loop {
                match Page::open(&self.address) {
                    Ok(page) => break page,
                    Err(_) => std::thread::sleep(Duration::from_millis(5)),
                }
            };
            page.show(panes)?;
            while !page.hear()?.is_some_and(|message| message.is_binary()) {}
            drop(page);
            self.rest();
            if session == SESSIONS / 10 {
                early = memory();
            }
        }
        Ok([early, memory()])
    }
}

/// A square sheet that hangs by two corners.
fn pane(method: &str, particles: u32, step: f64) -> Value {
    json!({ "scene": "hanging-textile-1e4", "method": method, "step": step, "duration": 3600,
        "particles": particles })
}

fn main() -> Outcome<()> {
    let server = Server::bind(0)?;
    let lab = Lab { address: server.address(), runs: server.runs() };
    std::thread::spawn(move || server.serve(std::future::pending()));
    let mut text = String::from(
        "# How fast the lab is\n\nA page that only listens opens panes of the lab on the sheet that \
         hangs by two corners, at k/m = 1e4/s², and plays them in real time. *Pictures* are those \
         that the page gets a second; the lab sends up to 30. *Cores* is the time of the processor \
         over the time of the clock, for the server and all panes. *Behind* is how late the pane is \
         at the end. `cargo run --release --example rates -p drape-lab > results/lab.md` makes this \
         page.\n\n## Several panes, and a large one\n\n| panes | method | pictures a second | cores \
         | µs a step | times real time | behind (s) |\n|---|---|---|---|---|---|---|\n",
    );
    let six = SIX.map(|method| pane(method, 20, 0.01));
    for (name, panes) in
        [("six of 20 × 20", six.as_slice()), ("one of 100 × 100", &[pane("imex-euler", 100, 0.01)])]
    {
        tell!("{name}");
        let rates = measure(&lab, panes, LONG)?;
        for (n, (pane, seen)) in panes.iter().zip(&rates.panes).enumerate() {
            let cores = if n == 0 { format!("{:.2}", rates.cores) } else { String::new() };
            writeln!(
                text,
                "| {} | {} | {:.1} | {cores} | {:.0} | {} | {:.2} |",
                if n == 0 { name } else { "" },
                pane["method"].as_str().unwrap_or_default(),
                seen.pictures,
                seen.micros,
                significant(seen.speed, 3),
                seen.behind
            )?;
        }
    }
    text += "\n## One pane of 20 × 20 with each method\n\nThe step is the longest of 0.01, 0.002, \
             0.0005 and 0.0001 s with which the method does not diverge.\n\n| method | step (s) | \
             pictures a second | cores | µs a step | times real time | behind (s) \
             |\n|---|---|---|---|---|---|---|\n";
    for method in methods::all() {
        tell!("{}", method.id);
        for step in STEPS_S {
            let rates = measure(&lab, &[pane(method.id, 20, step)], SHORT)?;
            let seen = &rates.panes[0];
            if seen.is_live {
                writeln!(
                    text,
                    "| {} | {step} | {:.1} | {:.2} | {:.0} | {} | {:.2} |",
                    method.id,
                    seen.pictures,
                    rates.cores,
                    seen.micros,
                    significant(seen.speed, 3),
                    seen.behind
                )?;
                break;
            }
        }
    }
    tell!("{SESSIONS} sessions");
    let [early, late] = lab.sessions(&six)?;
    writeln!(
        text,
        "\n## Sessions\n\n{SESSIONS} sessions of the six panes were opened and closed: {early:.1} \
         MiB after {}, {late:.1} MiB after all, and no run was left.",
        SESSIONS / 10
    )?;
    let source = Source::of_folder(Path::new(env!("CARGO_MANIFEST_DIR")));
    let about = provenance(&source, BTreeMap::new());
    let commit = about.commit.as_deref().unwrap_or("commit unknown");
    writeln!(text, "\n{}, {} threads, {commit}, {}.", about.cpu, about.threads, about.date)?;
    Ok(std::io::stdout().write_all(text.as_bytes())?)
}
