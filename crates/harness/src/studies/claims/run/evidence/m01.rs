//! What is run for claim M01.

use super::contest::Contest;
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::m01::{GROUNDS, LEVELS, METHOD};

pub(super) const TRIAL: Trial = Trial {
    id: "M01",
    scenes: || {
        "the hanging sheet of `work-precision` with d/m = 40/s, 0.25 s: 400 particles at k/m = \
         1e4, 1e6 and 1e8, 100 at 1e10; all forms of all methods; reference: `srkn4` at half its \
         limit"
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
