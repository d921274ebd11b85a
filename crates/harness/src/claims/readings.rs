//! Ways to read a claim, and where it stands under all of them.
//!
//! The paper's words admit more than one reading, and it does not print every parameter. A claim
//! *holds* or *fails* if it does so under each reading that we could think of, and *depends* if the
//! reading decides.

use super::{Evidence, Missing, Ruling};

/// A way to read a claim, and what the numbers make of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reading {
    /// What is asked under this reading.
    pub asks: &'static str,
    /// The verdict.
    pub verdict: Ruling,
    /// The numbers behind it.
    pub seen: String,
}

impl Reading {
    pub(super) fn new(asks: &'static str, is_met: bool, seen: String) -> Self {
        Self { asks, verdict: Ruling::of(is_met), seen }
    }
}

/// What a claim is judged by, besides its criterion.
pub(super) type Others = fn(Evidence<'_>) -> Result<Vec<Reading>, Missing>;

/// There is one way to read it.
pub(super) fn sole(_: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    Ok(Vec::new())
}

/// Where a claim stands under all its readings. A reading that is undecided neither holds nor fails,
/// so beside it the claim does not do so under every reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    /// Each reading holds.
    Holds,
    /// The readings disagree.
    Depends,
    /// Each reading fails.
    Fails,
    /// Each reading is undecided: the numbers cannot tell.
    Undecided,
}

impl Standing {
    /// All of them, in the order of tables.
    pub const ALL: [Self; 4] = [Self::Holds, Self::Depends, Self::Fails, Self::Undecided];

    /// One word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Depends => "depends",
            Self::Fails => "fails",
            Self::Undecided => "undecided",
        }
    }

    /// What some verdicts come to.
    pub(super) fn of(verdicts: impl IntoIterator<Item = Ruling>) -> Self {
        let (mut holds, mut fails, mut open) = (false, false, false);
        for verdict in verdicts {
            holds |= verdict == Ruling::Holds;
            fails |= verdict == Ruling::Fails;
            open |= verdict == Ruling::Undecided;
        }
        match (holds, fails, open) {
            (true, false, false) => Self::Holds,
            (false, true, false) => Self::Fails,
            (false, false, _) => Self::Undecided,
            _ => Self::Depends,
        }
    }
}

/// Since when a criterion stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Age {
    /// The commit that brought it, but for its wording.
    pub since: &'static str,
    /// How it changed after its results were first seen.
    pub changed: Option<&'static str>,
}

impl std::fmt::Display for Age {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.since)?;
        self.changed.map_or(Ok(()), |how| write!(f, ": {how}"))
    }
}

impl Age {
    /// It came with the code that first measured it.
    pub(super) const FIRST: Self = Self { since: "0e663d9", changed: None };
    /// It came with the methods of later years.
    pub(super) const LATER: Self = Self { since: "43c38bc", changed: None };
    /// It was about counted work until that was found to be no unit.
    pub(super) const MODELLED: Self = Self::changed(
        "38ad7b3",
        "asked for the least counted work before, and a miss within a factor of 2 refuted it; only \
         the verdict of M04 changed",
    );
    /// It was settled while it was first measured.
    pub(super) const SETTLED: Self =
        Self::changed("0e663d9", "settled while it was first measured, not before");

    pub(super) const fn changed(since: &'static str, how: &'static str) -> Self {
        Self { since, changed: Some(how) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claim_holds_or_fails_only_if_every_reading_does() {
        let (holds, fails, open) = (Ruling::Holds, Ruling::Fails, Ruling::Undecided);
        assert_eq!(Standing::of([holds, holds]), Standing::Holds);
        assert_eq!(Standing::of([fails, fails]), Standing::Fails);
        assert_eq!(Standing::of([fails, holds]), Standing::Depends);
        assert_eq!(Standing::of([open, holds]), Standing::Depends);
        assert_eq!(Standing::of([fails, open]), Standing::Depends);
        assert_eq!(Standing::of([open, fails, holds]), Standing::Depends);
        assert_eq!(Standing::of([open]), Standing::Undecided);
        assert_eq!(Standing::of([open, open]), Standing::Undecided);
    }
}
