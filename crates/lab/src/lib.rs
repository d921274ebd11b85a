//! The lab: methods side by side on the same cloth, live in the browser.
//!
//! **What it shows.** One to six *panes*. Each pane is a run of one method on one scene. All panes
//! share a clock, so that a person sees which method explodes, stands still or follows the motion.
//! Each pane has its numbers, and the verdict of `drape run` with a sentence that explains it.
//!
//! **How the code does it.**
//!
//! ```text
//! page/lab.ts  ⇄  server  ⇄  session  ⇄  engine  →  drape_harness::OrderedSimulation
//!  browser        HTTP,       panes,      a pane,
//!                 WebSocket   clock       step by step
//! ```
//!
//! | file | content |
//! |---|---|
//! | [`setup`] | a scene with the knobs turned, a method, and the command that repeats them |
//! | [`files`] | scenes and meshes that were dropped on the page |
//! | [`engine`] | a run that is shown; it does not depend on the transport |
//! | `work` | runs in the background: a thread for each, or all in turns |
//! | [`ghost`] | a reference solution to lay over panes |
//! | [`session`] | the panes of a page and their clock; it does not depend on the transport |
//! | [`lessons`] | lessons as the page shows them, and the marks for answers |
//! | [`messages`] | the messages between page and server |
//! | [`server`] | the transport, and the checks of who may use it |
//! | [`limits`] | the limits on the requests of a page |
//! | `page/` | the page in TypeScript, and `lab.js`, which is built from it |
//!
//! A pane makes the run of `drape run`, with an observer that waits between two steps. So a pane and
//! the command that repeats it end in the same state, bit for bit; `crates/drape/tests/lab.rs`
//! checks this.
//!
//! **A cloth that is moved by hand.** A pin cannot begin or end within a run. So each touch freezes
//! the pane and starts a new run from there. While a particle is led, the run has a pin on a short
//! path; once the particle is let go, it has none. Each of these runs equals the run of `drape run`
//! on the frozen system, bit for bit. A method of several steps begins anew with each run. A knob
//! that is turned while the panes go on freezes them in the same way.
//!
//! **What it cannot do.** A step that has begun cannot be stopped. A run that was closed ends after
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
