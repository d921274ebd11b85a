//! C18: in general the matrix must be set up each step.

use super::runs::track;
use super::scenes::{build, hanging};
use super::{Claim, Finding, Number, Verdict};
use crate::HarnessError;

pub(super) const CLAIM: Claim = Claim {
    id: "C18",
    section: "5",
    says: "in general the matrix must be set up each step",
    criterion: "error of keeping it, with piecewise-linear springs",
    is_quick: true,
    test,
    seconds: None,
};

/// What can be said without springs whose modulus changes: keeping the matrix of linear springs changes nothing.
fn test() -> Result<Finding, HarnessError> {
    let mut farthest = 0.0_f64;
    for stiffness in [1e4, 1e6] {
        let start = build(&hanging(10, stiffness, 40.0).spec()?)?;
        let run = |matrix| track(&start, &format!("imex-euler:matrix={matrix}"), 0.01, 0.5, 0);
        let (kept, rebuilt) = (run("kept")?.state, run("rebuilt")?.state);
        let pairs = kept.x.iter().zip(&rebuilt.x);
        farthest = pairs.fold(farthest, |far, (a, b)| far.max((a - b).norm()));
    }
    Ok(Finding {
        verdict: Verdict::Undecided,
        numbers: vec![Number::new(
            "change of positions by keeping it, linear springs",
            farthest,
            "m",
        )],
        reason: format!(
            "Effect absent: the claim speaks of springs whose modulus changes with their length, and this program has linear springs \
             only. With them the matrix is constant, and keeping it moves no particle by more than {farthest} m."
        ),
        repair: None,
        scenes: "hanging sheets of 100 particles, k/m = 1e4 and 1e6, h = 0.01 s, 0.5 s".to_owned(),
        see: "claims.svg",
        portable: true,
    })
}
