//! The lab: methods side by side on the same cloth, live in the browser.
//!
//! **What it shows.** Two to six *panes*. Each is a run of one method on one scene. All panes share
//! a clock, so that one can see which method explodes, stands still or follows the motion. Each has
//! its numbers and the verdict of `drape run` with a sentence that says why.
//!
//! **How the code does it.**
//!
//! ```text
//! page/lab.ts  ⇄  server  ⇄  session  ⇄  engine  →  drape_harness::OrderedSimulation
//!  browser        HTTP,       panes,      a pane,
//!                 WebSocket   clock       step by step
//! ```
//!
//! | file | what it holds |
//! |---|---|
//! | [`setup`] | a scene with the knobs turned, a method, and the command that repeats them |
//! | [`files`] | scenes and meshes that were dropped on the page |
//! | [`engine`] | a run that is shown; it knows no transport |
//! | `work` | runs beside those who look: a thread for each, or all in turns |
//! | [`ghost`] | a reference solution to lay over panes |
//! | [`session`] | the panes of a page and their clock; it knows no transport |
//! | [`lessons`] | what the page shows of a lesson, and how answers are marked |
//! | [`messages`] | what page and server say to each other |
//! | [`server`] | the transport, and who may use it |
//! | [`limits`] | how much a page may ask for |
//! | `page/` | the page in TypeScript, and `lab.js`, which is built from it |
//!
//! A pane makes the run of `drape run`, with an observer that waits between two steps. So a pane and
//! the command that repeats it end in the same state, bit for bit; `crates/drape/tests/lab.rs`
//! checks this.
//!
//! **A cloth that is moved by hand.** A pin cannot begin or end within a run. So each touch freezes
//! the pane and starts a new run from there: with a pin on a short path while a particle is led,
//! without it once the particle is let go. Each of these runs is what `drape run` makes of the
//! frozen system, bit for bit. A method of several steps begins anew with each of them. A knob that
//! is turned while the panes go on freezes them in the same way.
//!
//! **What it cannot do.** A step that has begun cannot be stopped: a run that was closed ends after
//! its present step.

pub mod engine;
pub mod files;
pub mod ghost;
pub mod lessons;
pub mod limits;
pub mod messages;
mod page;
#[cfg(feature = "server")]
pub mod server;
pub mod session;
pub mod setup;
mod work;

pub use engine::{Pane, Phase};
pub use files::Files;
pub use page::source;
#[cfg(feature = "server")]
pub use server::Server;
pub use session::{Out, Session};
pub use setup::{Repeat, Setup, Source, Stage, Touch};
pub use work::Runs;
#[cfg(target_family = "wasm")]
pub use work::turns::work;
