//! The paper's claims: each is a test with a criterion that was fixed before anything was measured.
//!
//! A claim is general, so no verdict rests on one run of one scene: each test says what it ran. Claims about time are
//! decided from counted work, which is the same on every machine; measured seconds stand beside the facts
//! ([`Claim::seconds`]) and must bear the verdict out.

mod atlas;
mod c01;
mod c02;
mod c03;
mod c04;
mod c05;
mod c06;
mod c07;
mod c08;
mod c09;
mod c10;
mod c11;
mod c12;
mod c13;
mod c14;
mod c15;
mod c16;
mod c17;
mod c18;
mod c19;
mod c20;
mod c21;
mod c22;
mod c23;
mod c24;
mod c25;
mod c26;
mod c27;
mod c28;
mod c29;
mod general;
mod meshes;
mod runs;
mod scenes;

use crate::HarnessError;
pub use crate::studies::claims::facts::{Number, Verdict};
use crate::studies::claims::facts::{Row, TimingRow};

/// A claim of the paper and its test.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// `C01` to `C29`.
    pub id: &'static str,
    /// Section of the paper.
    pub section: &'static str,
    /// What the paper claims, in our words.
    pub says: &'static str,
    /// What decides.
    pub criterion: &'static str,
    /// Whether the test costs so little (less than 0.3 s) that quick runs do it too.
    pub is_quick: bool,
    test: fn() -> Result<Finding, HarnessError>,
    seconds: Option<fn() -> Result<TimingRow, HarnessError>>,
}

/// What the test of a claim found.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Whether the criterion is met.
    pub verdict: Verdict,
    /// The numbers behind it.
    pub numbers: Vec<Number>,
    /// What was seen, and why: two sentences.
    pub reason: String,
    /// What helps, where the claim is refuted and a remedy was measured.
    pub repair: Option<String>,
    /// What was run.
    pub scenes: String,
    /// File name, below `figures/`, of the figure that shows it.
    pub see: &'static str,
    /// Same bits on every machine.
    pub portable: bool,
}

static CLAIMS: [Claim; 29] = [
    c01::CLAIM,
    c02::CLAIM,
    c03::CLAIM,
    c04::CLAIM,
    c05::CLAIM,
    c06::CLAIM,
    c07::CLAIM,
    c08::CLAIM,
    c09::CLAIM,
    c10::CLAIM,
    c11::CLAIM,
    c12::CLAIM,
    c13::CLAIM,
    c14::CLAIM,
    c15::CLAIM,
    c16::CLAIM,
    c17::CLAIM,
    c18::CLAIM,
    c19::CLAIM,
    c20::CLAIM,
    c21::CLAIM,
    c22::CLAIM,
    c23::CLAIM,
    c24::CLAIM,
    c25::CLAIM,
    c26::CLAIM,
    c27::CLAIM,
    c28::CLAIM,
    c29::CLAIM,
];

/// All claims, by id.
pub fn all() -> &'static [Claim] {
    &CLAIMS
}

/// Finds a claim by its id, in capitals or not.
///
/// # Errors
/// [`HarnessError::UnknownClaim`] naming the known ones.
pub fn find(id: &str) -> Result<&'static Claim, HarnessError> {
    all().iter().find(|claim| claim.id.eq_ignore_ascii_case(id)).ok_or_else(|| {
        let known: Vec<_> = all().iter().map(|claim| claim.id).collect();
        HarnessError::UnknownClaim { id: id.to_owned(), known: known.join(", ") }
    })
}

impl Claim {
    /// Runs the test.
    ///
    /// # Errors
    /// [`HarnessError`] when a run is refused.
    pub fn test(&self) -> Result<Row, HarnessError> {
        let found = (self.test)()?;
        Ok(Row {
            id: self.id.to_owned(),
            section: self.section.to_owned(),
            says: self.says.to_owned(),
            criterion: self.criterion.to_owned(),
            verdict: found.verdict,
            numbers: found.numbers,
            reason: found.reason,
            repair: found.repair,
            scenes: found.scenes,
            see: found.see.to_owned(),
            portable: found.portable,
        })
    }

    /// Whether measured seconds stand beside its verdict.
    pub fn has_seconds(&self) -> bool {
        self.seconds.is_some()
    }

    /// Measures the seconds of a claim about time; `None` for any other.
    ///
    /// # Errors
    /// [`HarnessError`] when a run is refused.
    pub fn seconds(&self) -> Result<Option<TimingRow>, HarnessError> {
        self.seconds.map(|measure| measure()).transpose()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn every_claim_stands_once_in_order_and_is_found_by_its_id() {
        for (n, claim) in all().iter().enumerate() {
            assert_eq!(claim.id, format!("C{:02}", n + 1));
            assert_eq!(find(&claim.id.to_lowercase()).unwrap().id, claim.id);
            assert!(claim.says.chars().count() <= 84, "{} is too long for its figure", claim.id);
        }
        let message = find("C30").unwrap_err().to_string();
        assert!(message.contains("C30") && message.contains("C01, C02"), "{message}");
    }

    #[test]
    fn quick_claims_come_to_a_verdict_with_numbers_and_scenes() {
        for claim in all().iter().filter(|claim| claim.is_quick) {
            let row = claim.test().unwrap();
            let mut names: Vec<_> = row.numbers.iter().map(|number| &number.what).collect();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), row.numbers.len(), "{}: two numbers of one name", claim.id);
            assert!(!row.reason.is_empty() && !row.scenes.is_empty(), "{}", claim.id);
            assert!(row.see.ends_with(".svg"), "{}: {}", claim.id, row.see);
        }
    }
}
