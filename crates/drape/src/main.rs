//! The `drape` command; `drape --help` describes it.

use cap::Cap;
use std::alloc::System;
use std::process::ExitCode;

/// Counts the bytes that the process holds, and sets no limit.
#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Bytes that the process has allocated and not freed.
fn allocated() -> usize {
    ALLOCATOR.allocated()
}

fn main() -> ExitCode {
    drape::Drape::new().counting(allocated).main()
}
