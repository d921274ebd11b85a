//! The engine of the lab for a page that needs no server.
//!
//! The engine is built for `wasm32-wasip1` and runs in a worker of the page; `page/src/worker.ts`
//! is the other side. All runs take turns on the thread of the worker. The engine uses the
//! [`Session`] of the server, so the messages are the same.
//!
//! A page writes a message into the [`room`] and says of which kind it is ([`hear_text`],
//! [`hear_file`]). At each [`tick`] it takes all messages of the engine ([`next`], [`start`],
//! [`length`]).

// On other targets nothing calls the engine.
#![cfg(target_family = "wasm")]
// An unmangled name could clash with a name of another library. No other names are unmangled here.
#![allow(unsafe_code, reason = "exports")]

use drape_lab::{Out, Runs, Session, work};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

struct Engine {
    session: Session,
    heard: Vec<u8>,
    told: VecDeque<Out>,
    /// The message that the page reads now.
    present: Vec<u8>,
}

thread_local! {
    static ENGINE: RefCell<Engine> = RefCell::new(Engine::new());
}

impl Engine {
    fn new() -> Self {
        let session = Session::new(Runs::default());
        let told = VecDeque::from([session.greet()]);
        Self { session, heard: Vec::new(), told, present: Vec::new() }
    }
}

fn with<T>(act: impl FnOnce(&mut Engine) -> T) -> T {
    ENGINE.with_borrow_mut(act)
}

/// Makes room for a message of so many bytes to the engine, and returns its address.
#[unsafe(no_mangle)]
pub extern "C" fn room(bytes: usize) -> *mut u8 {
    with(|engine| {
        engine.heard.clear();
        engine.heard.resize(bytes, 0);
        engine.heard.as_mut_ptr()
    })
}

/// Takes the message in the room as a request.
#[unsafe(no_mangle)]
pub extern "C" fn hear_text() {
    with(|engine| {
        let heard = std::mem::take(&mut engine.heard);
        engine.told.extend(engine.session.receive(&String::from_utf8_lossy(&heard)));
    });
}

/// Takes the message in the room as a file.
#[unsafe(no_mangle)]
pub extern "C" fn hear_file() {
    with(|engine| {
        let heard = std::mem::take(&mut engine.heard);
        engine.told.push_back(engine.session.receive_file(&heard));
    });
}

/// Lets `elapsed` milliseconds pass, and lets the runs work for at most `share` milliseconds.
#[unsafe(no_mangle)]
pub extern "C" fn tick(elapsed: f64, share: f64) {
    let millis = |time: f64| Duration::try_from_secs_f64(time / 1000.0).unwrap_or_default();
    with(|engine| engine.told.extend(engine.session.tick(millis(elapsed))));
    work(Instant::now() + millis(share));
}

/// Takes the next message of the engine. Returns 1 for text, 2 for positions, 0 if no message
/// waits.
#[unsafe(no_mangle)]
pub extern "C" fn next() -> u32 {
    with(|engine| {
        let (kind, bytes) = match engine.told.pop_front() {
            None => (0, Vec::new()),
            Some(Out::Text(text)) => (1, text.into_bytes()),
            Some(Out::Binary(bytes)) => (2, bytes),
        };
        engine.present = bytes;
        kind
    })
}

/// The address of the message that was taken last.
#[unsafe(no_mangle)]
pub extern "C" fn start() -> *const u8 {
    with(|engine| engine.present.as_ptr())
}

/// The length of the message that was taken last, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn length() -> usize {
    with(|engine| engine.present.len())
}

/// Takes, as a message, the page with the source that decides the verdicts.
#[unsafe(no_mangle)]
pub extern "C" fn source() {
    with(|engine| engine.present = drape_lab::source().as_bytes().to_vec());
}
