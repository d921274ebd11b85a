//! Tests of the public interface.

mod page;
mod socket;
mod verdicts;

#[path = "../../harness/tests/devtools/mod.rs"]
mod devtools;
