//! What is run for each claim, and what it measures.

mod e01;
mod e02;
mod e03;
mod e04;
mod e05;
mod e06;
mod e07;
mod e08;
mod e09;
mod e10;
mod e11;
mod e12;
mod e13;
mod e14;
mod e15;
mod e16;
mod e17;
mod e18;
mod e19;
mod e20;
mod e21;
mod e22;
mod e23;
mod e24;
mod e25;
mod e26;
mod e27;
mod e28;
mod e29;
mod m01;
mod m02;
mod m03;
mod m04;
mod m05;
mod m06;
mod m07;
mod m08;

use super::{atlas, contest, general, meshes, runs, scenes};
use crate::HarnessError;
use crate::studies::claims::facts::{Number, TimedCase};

/// Timed pieces of work, and the number that they give.
pub(super) type Timed = (Vec<TimedCase>, Number);

/// What is run for one claim.
#[derive(Debug)]
pub(super) struct Trial {
    /// Of the claim.
    pub(super) id: &'static str,
    /// What is run, in prose.
    pub(super) scenes: fn() -> String,
    /// Whether its numbers have the same bits on every machine.
    pub(super) portable: bool,
    /// Whether it costs so little that quick runs do it too: less than 0.3 s, one of later methods
    /// less than 3 s.
    pub(super) is_quick: bool,
    pub(super) run: fn() -> Result<Vec<Number>, HarnessError>,
    /// Measures the seconds of a claim about time.
    pub(super) seconds: Option<fn() -> Result<Timed, HarnessError>>,
}

/// One a claim, in the order of their ids.
pub(super) static TRIALS: [Trial; 37] = [
    e01::TRIAL,
    e02::TRIAL,
    e03::TRIAL,
    e04::TRIAL,
    e05::TRIAL,
    e06::TRIAL,
    e07::TRIAL,
    e08::TRIAL,
    e09::TRIAL,
    e10::TRIAL,
    e11::TRIAL,
    e12::TRIAL,
    e13::TRIAL,
    e14::TRIAL,
    e15::TRIAL,
    e16::TRIAL,
    e17::TRIAL,
    e18::TRIAL,
    e19::TRIAL,
    e20::TRIAL,
    e21::TRIAL,
    e22::TRIAL,
    e23::TRIAL,
    e24::TRIAL,
    e25::TRIAL,
    e26::TRIAL,
    e27::TRIAL,
    e28::TRIAL,
    e29::TRIAL,
    m01::TRIAL,
    m02::TRIAL,
    m03::TRIAL,
    m04::TRIAL,
    m05::TRIAL,
    m06::TRIAL,
    m07::TRIAL,
    m08::TRIAL,
];
