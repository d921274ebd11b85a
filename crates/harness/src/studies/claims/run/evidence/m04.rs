//! What is run for claim M04.

use super::contest::Contest;
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::m04::REGIMES;

pub(super) const TRIAL: Trial = Trial {
    id: "M04",
    scenes: || {
        "the hanging sheet of `work-precision` with d/m = √(k/m), 400 particles, 0.25 s, k/m = 1e6 \
         and 1e8; all forms of all methods; reference: DOP853"
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
    let mut numbers: Vec<Number> = Vec::new();
    for (method, ground, levels) in REGIMES {
        // Two regimes share a sheet, and so the doubt of its reference.
        let more = Contest::new(ground)?.efforts(&[method], levels, MOST, |_| true)?;
        for number in more {
            if numbers.iter().all(|other| other.what != number.what) {
                numbers.push(number);
            }
        }
    }
    Ok(numbers)
}
