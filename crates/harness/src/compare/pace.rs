//! The clock by which runs are ranked.

use super::Clock;
use crate::cost::{Price, prices};
use crate::methods::Choice;
use crate::run::Moment;

/// How long the steps of one form take.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// Where counted work is the clock.
    price: Option<&'static Price>,
}

impl Pace {
    pub(super) fn of(clock: Clock, choice: &Choice) -> Self {
        let price = || prices().of(&choice.full_id());
        Self { price: (clock == Clock::Modelled).then(price) }
    }

    /// Seconds of all steps so far.
    pub(super) fn seconds(&self, moment: &Moment<'_>) -> f64 {
        match self.price {
            Some(price) => moment.counted.seconds(price),
            None => moment.wall.as_secs_f64(),
        }
    }
}
