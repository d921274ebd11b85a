//! Claims: each is a predicate over recorded numbers.
//!
//! `C01` to `C29` are claims of the paper. `M01` to `M08` are expectations about methods of the
//! years after it, which no paper makes ([`Origin`]).
//!
//! A claim has a criterion, which reads numbers of the record of the study `claims`
//! ([`Claim::reads`]) and runs nothing. What is measured for it stands in the study;
//! [`crate::studies::claims::test`] runs that. Where the words of the paper can be read otherwise, or
//! it does not print a parameter that decides, other [readings](Reading) stand beside the criterion.
//! [`Age`] says since when a criterion stands and whether it changed when results were known.

pub(crate) mod c01;
pub(crate) mod c02;
pub(crate) mod c03;
pub(crate) mod c04;
pub(crate) mod c05;
pub(crate) mod c06;
pub(crate) mod c07;
pub(crate) mod c08;
pub(crate) mod c09;
pub(crate) mod c10;
pub(crate) mod c11;
pub(crate) mod c12;
pub(crate) mod c13;
pub(crate) mod c14;
pub(crate) mod c15;
pub(crate) mod c16;
pub(crate) mod c17;
pub(crate) mod c18;
pub(crate) mod c19;
pub(crate) mod c20;
pub(crate) mod c21;
pub(crate) mod c22;
pub(crate) mod c23;
pub(crate) mod c24;
pub(crate) mod c25;
pub(crate) mod c26;
pub(crate) mod c27;
pub(crate) mod c28;
pub(crate) mod c29;
mod evidence;
pub(crate) mod m01;
pub(crate) mod m02;
pub(crate) mod m03;
pub(crate) mod m04;
pub(crate) mod m05;
pub(crate) mod m06;
pub(crate) mod m07;
pub(crate) mod m08;
pub(crate) mod places;
mod readings;

use crate::HarnessError;
pub use crate::studies::claims::facts::{Number, Ruling};
pub use evidence::Evidence;
use evidence::{Missing, span, told};
pub use readings::{Age, Reading, Standing};
use readings::{Others, sole};

/// Whose claim it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The paper makes it.
    Paper {
        /// Section of the paper.
        section: &'static str,
    },
    /// Nobody made it in print: an expectation about methods published since the paper, which
    /// calculations on a similar sheet suggested before this program measured it.
    Expectation {
        /// Publications of the methods.
        about: &'static str,
    },
}

impl Origin {
    /// Whether the paper makes the claim.
    pub fn is_paper(self) -> bool {
        matches!(self, Self::Paper { .. })
    }
}

impl std::fmt::Display for Origin {
    /// The section, or that it is an expectation and the publications of the methods.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Paper { section } => write!(f, "§{section}"),
            Self::Expectation { about } => write!(f, "expectation about methods of {about}"),
        }
    }
}

/// A claim of the paper, or an expectation about later methods.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// `C01` to `C29` for the paper, `M01` to `M08` for later methods.
    pub id: &'static str,
    /// Whose it is.
    pub origin: Origin,
    /// What is claimed, in our words.
    pub says: &'static str,
    /// What decides under the first reading.
    pub criterion: &'static str,
    /// The numbers that decide, in its row of the study `claims`: how their names begin or end.
    pub reads: &'static [&'static str],
    /// What would overturn the verdict of the criterion.
    pub overturned_by: &'static str,
    /// File name, below `figures/`, of the figure that shows it.
    pub see: &'static str,
    /// Since when the criterion stands.
    pub age: Age,
    judge: fn(Evidence<'_>) -> Result<Judgement, Missing>,
    /// Readings besides the criterion.
    readings: Others,
}

/// What the numbers say of a claim.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// Whether the criterion is met.
    pub verdict: Ruling,
    /// What was seen, and why.
    pub reason: String,
    /// What helps, where the claim is refuted and a remedy was measured.
    pub repair: Option<String>,
}

impl Judgement {
    fn new(is_met: bool, reason: String) -> Self {
        Self { verdict: Ruling::of(is_met), reason, repair: None }
    }

    /// The same with what helps.
    fn repaired(self, repair: Option<String>) -> Self {
        Self { repair, ..self }
    }
}

static CLAIMS: [Claim; 37] = [
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
    m01::CLAIM,
    m02::CLAIM,
    m03::CLAIM,
    m04::CLAIM,
    m05::CLAIM,
    m06::CLAIM,
    m07::CLAIM,
    m08::CLAIM,
];

/// All claims by id, those of the paper first.
pub fn all() -> &'static [Claim] {
    &CLAIMS
}

/// Finds a claim by its id, in capitals or not.
///
/// # Errors
/// [`HarnessError::UnknownClaim`] naming the known ones.
pub fn find(id: &str) -> Result<&'static Claim, HarnessError> {
    let found = all().iter().find(|claim| claim.id.eq_ignore_ascii_case(id));
    found.ok_or_else(|| unknown(id))
}

/// Whether a claim of that id is known not to be the paper's.
pub fn is_expectation(id: &str) -> bool {
    find(id).is_ok_and(|claim| !claim.origin.is_paper())
}

/// Where a claim stands under all its readings: the verdict of the criterion, and those of the other
/// readings on the same numbers.
pub fn standing(id: &str, verdict: Ruling, numbers: &[Number]) -> Standing {
    let readings = find(id).map(|claim| claim.readings(&Evidence::new(numbers)));
    let others = readings.unwrap_or_default().into_iter().map(|reading| reading.verdict);
    Standing::of(std::iter::once(verdict).chain(others))
}

/// The error that no claim has this id.
pub(crate) fn unknown(id: &str) -> HarnessError {
    let known: Vec<_> = all().iter().map(|claim| claim.id).collect();
    HarnessError::UnknownClaim { id: id.to_owned(), known: known.join(", ") }
}

impl Claim {
    /// The verdict of the criterion on recorded numbers; undecided if one that it needs is missing.
    pub fn judge(&self, evidence: &Evidence<'_>) -> Judgement {
        (self.judge)(*evidence).unwrap_or_else(Judgement::from)
    }

    /// The readings besides the criterion; none if a number that they need is missing.
    pub fn readings(&self, evidence: &Evidence<'_>) -> Vec<Reading> {
        (self.readings)(*evidence).unwrap_or_default()
    }
}

/// What a claim makes of numbers that are given by hand.
#[cfg(test)]
fn judged(claim: &Claim, numbers: &[(&str, f64)]) -> Judgement {
    let number = |&(what, value): &(&str, f64)| Number::new(what, value, "");
    claim.judge(&Evidence::new(&numbers.iter().map(number).collect::<Vec<_>>()))
}

/// As [`judged`], with the limit of each number; the verdict alone.
#[cfg(test)]
fn ruled(claim: &Claim, numbers: &[(&str, f64, f64)]) -> Ruling {
    let number =
        |&(what, value, limit): &(&str, f64, f64)| Number::new(what, value, "").against(limit);
    claim.judge(&Evidence::new(&numbers.iter().map(number).collect::<Vec<_>>())).verdict
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::studies::claims::facts::{Facts, Row};

    /// The committed record.
    fn rows() -> Vec<Row> {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../results/claims.json");
        let record: drape_report::Record<Facts> =
            drape_report::file::read_json(path.as_ref()).unwrap();
        record.facts.claims
    }

    #[test]
    fn every_claim_stands_once_in_order_and_is_found_by_its_id() {
        let (paper, others): (Vec<&Claim>, _) = all().iter().partition(|c| c.origin.is_paper());
        let in_order = |claims: &[&Claim], letter| {
            let ids =
                claims.iter().enumerate().map(|(n, c)| (c.id, format!("{letter}{:02}", n + 1)));
            ids.for_each(|(id, expected)| assert_eq!(id, expected));
        };
        in_order(&paper, 'C');
        in_order(&others, 'M');
        assert_eq!((paper.len(), others.len()), (29, 8));
        assert!(all().iter().map(|claim| claim.id).eq(paper.iter().chain(&others).map(|c| c.id)));
        for claim in all() {
            assert_eq!(find(&claim.id.to_lowercase()).unwrap().id, claim.id);
            assert!(claim.says.chars().count() <= 84, "{} is too long for its figure", claim.id);
            assert!(claim.see.ends_with(".svg"), "{}: {}", claim.id, claim.see);
            assert!(claim.overturned_by.ends_with('.') && !claim.reads.is_empty(), "{}", claim.id);
        }
        let message = find("C30").unwrap_err().to_string();
        assert!(message.contains("C30") && message.contains("C01, C02"), "{message}");
    }

    #[test]
    fn the_recorded_verdicts_follow_from_the_recorded_numbers() {
        let rows = rows();
        assert_eq!(rows.len(), all().len());
        for (claim, row) in all().iter().zip(&rows) {
            let judgement = claim.judge(&Evidence::new(&row.numbers));
            assert_eq!((claim.id, judgement.verdict), (row.id.as_str(), row.verdict));
            let sentences = |text: &str| text.split(". ").count();
            assert!(sentences(&judgement.reason) <= 2, "{}: {}", claim.id, judgement.reason);
            let repair = judgement.repair.unwrap_or_default();
            assert!(sentences(&repair) <= 2, "{}: {repair}", claim.id);
        }
    }

    /// Whether noise hides every error whose times begin like this.
    fn is_hidden(numbers: &[Number], read: &str) -> bool {
        let Some(ground) = read.strip_prefix("time at ").and_then(|r| r.strip_suffix(" for "))
        else {
            return false;
        };
        let doubt = format!("doubt of the reference at {ground}");
        let doubt = numbers.iter().find(|number| number.what == doubt).map(|number| number.value);
        let levels = numbers.iter().filter_map(|number| {
            number.what.strip_prefix(read)?.split(',').next()?.parse::<f64>().ok()
        });
        let greatest = levels.fold(0.0, f64::max);
        doubt.is_some_and(|doubt| doubt > places::TRUSTED * greatest)
    }

    /// What a claim says that it reads is what decides: without it there is no verdict, or other
    /// readings.
    #[test]
    fn a_claim_without_a_number_that_it_reads_is_undecided_and_names_it() {
        for (claim, row) in all().iter().zip(rows()) {
            for read in claim.reads {
                let is_other = |number: &&Number| {
                    !number.what.starts_with(read) && !number.what.ends_with(read)
                };
                let rest: Vec<_> = row.numbers.iter().filter(is_other).cloned().collect();
                assert!(rest.len() < row.numbers.len(), "{}: nothing is “{read}”", claim.id);
                let judgement = claim.judge(&Evidence::new(&rest));
                // A contest that noise hides is run, but says nothing.
                if is_hidden(&row.numbers, read) {
                    continue;
                }
                if judgement.verdict != Ruling::Undecided {
                    let [less, all] =
                        [&rest, &row.numbers].map(|n| claim.readings(&Evidence::new(n)));
                    assert_ne!(less, all, "{}: {read}", claim.id);
                    continue;
                }
                let words: Vec<_> = read.split(", ").collect();
                assert!(judgement.reason.contains(words[0]), "{}: {judgement:?}", claim.id);
            }
            let nothing = claim.judge(&Evidence::new(&[]));
            assert_eq!(nothing.verdict, Ruling::Undecided, "{}", claim.id);
            assert!(nothing.reason.contains("lacks"), "{}: {}", claim.id, nothing.reason);
        }
    }
}
