//! Tests of the public interface.

mod browser;
mod common;
mod devtools;
mod draw;
mod pictures;
mod report;
