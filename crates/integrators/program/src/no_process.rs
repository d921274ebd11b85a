//! Replacement for systems other than Unix. Programs need pipes with time limits, which are written
//! for Unix only.

use crate::message::Answer;
use std::time::Duration;

/// Does nothing, because no program can run.
pub fn kill_all() {}

/// No program runs here.
#[derive(Debug)]
pub(crate) enum Process {}

impl Process {
    pub(crate) fn start(command: &str, _words: &[String]) -> Result<Self, String> {
        Err(format!("program `{command}`: programs as methods need a Unix system"))
    }

    pub(crate) fn reserve(&mut self, _bytes: usize) {}

    pub(crate) fn has_hung(&self) -> bool {
        match *self {}
    }

    pub(crate) fn failed(&mut self, _did: &str) -> String {
        match *self {}
    }

    pub(crate) fn ask(&mut self, _: &str, _: &[u8], _: Duration) -> Result<&[u8], String> {
        match *self {}
    }

    pub(crate) fn request(
        &mut self,
        _when: &str,
        _request: &[u8],
        _bytes: usize,
        _limit: Duration,
    ) -> Result<(Answer, &[u8]), String> {
        match *self {}
    }
}
