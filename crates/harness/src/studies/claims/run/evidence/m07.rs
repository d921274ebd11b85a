//! What is run for claim M07.

use super::contest::Contest;
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::m07::{GROUNDS, LEVELS, METHOD};

pub(super) const TRIAL: Trial = Trial {
    id: "M07",
    scenes: || {
        "the hanging sheet of `work-precision` with d/m = 40/s, 400 particles, 0.25 s, k/m = 1e6 \
         and 1e8; all forms of all methods; reference: `srkn4` at half its limit"
            .to_owned()
    },
    portable: false,
    is_quick: false,
    run: evidence,
    seconds: None,
};

/// Most modelled time of a run, s.
const MOST: f64 = 0.5;

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut numbers = Vec::new();
    for ground in GROUNDS {
        numbers.extend(Contest::new(ground)?.efforts(&[METHOD], &LEVELS, MOST, |_| true)?);
    }
    Ok(numbers)
}
