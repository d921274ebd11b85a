//! Chromium, driven over the DevTools protocol: JSON messages with a zero byte after each, on two
//! pipes.

#![allow(clippy::unwrap_used)]

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// An answer may take this long on a busy machine.
const PATIENCE: Duration = Duration::from_secs(180);
/// Chromium reads commands from file descriptor 3 and writes answers and events to 4.
const PIPES: &str = r#"exec "$0" "$@" 3<&0 4>&1 </dev/null >/dev/null 2>&1"#;

/// Chromium, or `None` after saying that there is none.
pub(crate) fn chromium() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::env::split_paths(&folders).collect::<Vec<_>>();
    let found = names
        .iter()
        .flat_map(|name| paths.iter().map(move |path| path.join(name)))
        .find(|path| path.is_file());
    if found.is_none() {
        let is_required =
            std::env::var_os("DRAPE_BROWSER").is_some_and(|value| value == "required");
        assert!(!is_required, "DRAPE_BROWSER=required, but no chromium is on the path");
        // Past the capture of tests.
        writeln!(std::io::stderr().lock(), "SKIPPED: no chromium is on the path").unwrap();
    }
    found
}

/// A browser with one tab. It ends when it is dropped.
pub(crate) struct Browser {
    process: Child,
    commands: ChildStdin,
    messages: Receiver<Value>,
    session: Option<String>,
    last: u64,
    /// Events of the tab since the start, in order.
    pub(crate) events: Vec<Value>,
    _profile: TempDir,
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Neither fails unless the browser has ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Browser {
    /// Starts a headless browser with an empty tab and an empty profile.
    pub(crate) fn start(chromium: &Path) -> Self {
        let profile = tempfile::tempdir().unwrap();
        let mut process = Command::new("sh")
            .args(["-c", PIPES])
            .arg(chromium)
            .arg(format!("--user-data-dir={}", profile.path().display()))
            // The sandbox does not work for root, which containers often run as.
            .args(["--headless", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu"])
            // WebGL is drawn by the processor.
            .args(["--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
            .args(["--no-first-run", "--remote-debugging-pipe", "about:blank"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let commands = process.stdin.take().unwrap();
        let output = BufReader::new(process.stdout.take().unwrap());
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            for message in output.split(0).map_while(Result::ok) {
                let parsed = serde_json::from_slice(&message).unwrap();
                if sender.send(parsed).is_err() {
                    break;
                }
            }
        });
        let events = Vec::new();
        let mut browser =
            Self { process, commands, messages, session: None, last: 0, events, _profile: profile };
        let tab = browser.call("Target.createTarget", &json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": tab["targetId"], "flatten": true });
        let session = browser.call("Target.attachToTarget", &attach);
        browser.session = session["sessionId"].as_str().map(str::to_owned);
        browser
    }

    /// Sends a command and waits for its result.
    pub(crate) fn call(&mut self, method: &str, params: &Value) -> Value {
        self.last += 1;
        let mut command = json!({ "id": self.last, "method": method, "params": params });
        if let Some(session) = &self.session {
            command["sessionId"] = json!(session);
        }
        self.commands.write_all(format!("{command}\0").as_bytes()).unwrap();
        let begin = Instant::now();
        loop {
            let mut message = self.receive(method, begin);
            if message["id"] == self.last {
                assert!(message["error"].is_null(), "{method}: {}", message["error"]);
                return message["result"].take();
            }
        }
    }

    /// Waits until an event of this name has come.
    pub(crate) fn wait_for(&mut self, event: &str) {
        let begin = Instant::now();
        while !self.events.iter().any(|known| known["method"] == event) {
            self.receive(event, begin);
        }
    }

    /// The next message; events are kept.
    fn receive(&mut self, waiting_for: &str, begin: Instant) -> Value {
        let rest = PATIENCE.saturating_sub(begin.elapsed());
        let message = self.messages.recv_timeout(rest);
        let message = message.unwrap_or_else(|error| panic!("{waiting_for}: {error}"));
        if message["id"].is_null() {
            self.events.push(message.clone());
        }
        message
    }

    /// The value of a JavaScript expression.
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let evaluate = json!({ "expression": expression, "returnByValue": true });
        let mut answer = self.call("Runtime.evaluate", &evaluate);
        let exception = &answer["exceptionDetails"];
        assert!(exception.is_null(), "{expression}: {exception}");
        answer["result"]["value"].take()
    }

    /// Presses the Enter key.
    pub(crate) fn press_enter(&mut self) {
        for kind in ["keyDown", "keyUp"] {
            let key = json!({ "type": kind, "key": "Enter", "code": "Enter", "text": "\r",
                "windowsVirtualKeyCode": 13 });
            self.call("Input.dispatchKeyEvent", &key);
        }
    }
}
