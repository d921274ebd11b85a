//! A method that is a program of the user, in any language.
//!
//! builds-on: nothing: it is the door through which other methods come in
//!
//! # What it is
//!
//! drape starts the program and sends it the frozen system. Then it asks for one step at a time
//! over two pipes (protocol `drape-method/1`). The guide of the crate `drape` describes the
//! protocol exactly (`drape::guide::protocol`).
//!
//! # The mathematics
//!
//! The program defines it. drape requests the state at `t + h` from the state at `t`. It checks the
//! sizes of all answers, that pins are on their paths, and how long each answer takes.
//!
//! # Safety
//!
//! A program may hang, die, print garbage or lie about sizes. Each of these becomes an error of one
//! sentence ([`drape_integrator::StepError::Outside`]). drape then kills the program and all
//! processes that it started, and waits for them. It never reads more bytes than an answer may
//! hold.
//!
//! # Where it failed here, and what it cost
//!
//! *Starting costs more than stepping.* Each run starts a process. Python alone takes some 20 ms,
//! with SciPy half a second, while a step of a small sheet takes a millisecond.

mod description;
mod failures;
mod message;
#[cfg(unix)]
mod process;
#[cfg(not(unix))]
#[path = "no_process.rs"]
mod process;
mod program;
mod step;

pub use failures::failures;
pub use message::try_line;
pub use process::kill_all;
pub use program::{AnswerLimit, PREFIX, answer_within, load};
