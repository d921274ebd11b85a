//! Shards: parts of the cells of a study that are computed apart, on one machine or on many.
//!
//! The key of a cell is `STUDY/PART/NUMBER`, as its journal names it. The first eight bytes of the
//! key's SHA-256, read as a number and taken modulo `n`, say which of `n` shards the cell belongs
//! to. So a cell belongs to the same shard on every machine. Neighbours often take about as long,
//! and the hash spreads them over all shards. Timed cells form a shard of their own, because
//! nothing else may run beside them.

use sha2::{Digest as _, Sha256};
use std::fmt;
use std::str::FromStr;

/// Which cells a process computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shard {
    /// The cells whose key falls to `number`. None of them is timed.
    Of {
        /// Its number, from 1 to `count`.
        number: u32,
        /// Number of shards.
        count: u32,
    },
    /// All cells that are timed.
    Timed,
}

const TIMED: &str = "timed";
/// Most shards. A greater number is taken for a typing error.
const MOST: u32 = 1_000_000;

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == TIMED {
            return Ok(Self::Timed);
        }
        let numbers = text.split_once('/').and_then(|(number, count)| {
            Some((number.parse::<u32>().ok()?, count.parse::<u32>().ok()?))
        });
        match numbers {
            Some((number, count)) if (1..=MOST).contains(&count) => match number {
                1.. if number <= count => Ok(Self::Of { number, count }),
                _ => Err(format!("shard {number}; expected a number from 1 to {count}")),
            },
            _ => Err(format!(
                "expected I/N with I from 1 to N, such as 3/7, N at most {MOST}, or `{TIMED}`"
            )),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Of { number, count } => write!(f, "{number}/{count}"),
            Self::Timed => f.write_str(TIMED),
        }
    }
}

impl Shard {
    /// Whether a cell belongs to this shard.
    pub(crate) fn has(self, study: &str, part: &str, number: usize, is_timed: bool) -> bool {
        match self {
            Self::Timed => is_timed,
            Self::Of { number: own, count } => {
                !is_timed && place(study, part, number, count) == own
            }
        }
    }
}

/// The shard that a cell falls to, from 1 to `count`.
fn place(study: &str, part: &str, number: usize, count: u32) -> u32 {
    let hash = Sha256::digest(format!("{study}/{part}/{number}").as_bytes());
    let first = hash.iter().take(8).fold(0_u64, |sum, byte| sum << 8 | u64::from(*byte));
    (first % u64::from(count)) as u32 + 1
}

/// Cells of a part that a process may not compute and that no journal holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// The part of the study.
    pub part: String,
    /// How many cells the part has.
    pub of: usize,
    /// The numbers of those that are missing, from 0 and rising.
    pub numbers: Vec<usize>,
    /// Whether they are timed.
    pub is_timed: bool,
}

/// Most ranges of numbers that are written out.
const MOST_RANGES: usize = 12;

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { part, of, numbers, .. } = self;
        let ranges: Vec<_> = numbers
            .chunk_by(|a, b| a + 1 == *b)
            .map(|range| match range {
                [one] => one.to_string(),
                [first, .., last] => format!("{first}–{last}"),
                [] => String::new(),
            })
            .collect();
        let shown = ranges.len().min(MOST_RANGES);
        let rest = if ranges.len() > shown { ", …" } else { "" };
        let ranges = ranges[..shown].join(", ");
        write!(f, "{part}: {} of {of} cells are missing: {ranges}{rest}", numbers.len())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn shards_are_read_or_refused() {
        for text in ["1/1", "3/7", "7/7", "timed"] {
            assert_eq!(text.parse::<Shard>().unwrap().to_string(), text);
        }
        for wrong in ["", "3", "0/7", "8/7", "1/0", "-1/7", "1/7/2", "a/b", "1/2000000", "Timed"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }

    /// Every counted cell belongs to exactly one shard, no shard has many more than another, and
    /// timed cells belong to a shard of their own.
    #[test]
    fn shards_divide_the_cells() {
        let shards = (1..=7).map(|number| Shard::Of { number, count: 7 });
        let has = |shard: Shard, is_timed| {
            (0..7000).filter(|&cell| shard.has("order", "methods", cell, is_timed)).count()
        };
        let sizes: Vec<_> = shards.clone().map(|shard| has(shard, false)).collect();
        assert_eq!(sizes.iter().sum::<usize>(), 7000);
        assert!(sizes.iter().all(|size| (850..1150).contains(size)), "{sizes:?}");
        for cell in 0..100 {
            let owners = shards.clone().filter(|shard| shard.has("order", "methods", cell, false));
            assert_eq!(owners.count(), 1, "{cell}");
        }
        assert!(shards.clone().all(|shard| has(shard, true) == 0));
        assert_eq!((has(Shard::Timed, true), has(Shard::Timed, false)), (7000, 0));
    }

    /// The place follows from the key alone. The numbers below keep it the same in every version.
    #[test]
    fn a_cell_keeps_its_place() {
        let places = |part| (0..6).map(|cell| place("order", part, cell, 7)).collect::<Vec<_>>();
        assert_eq!(places("methods"), PLACES);
        assert_ne!(places("limits"), PLACES);
    }

    /// The first eight bytes of `printf 'order/methods/0' | sha256sum` and so on, modulo 7, plus 1.
    const PLACES: [u32; 6] = [2, 3, 4, 7, 5, 2];

    #[test]
    fn missing_cells_are_told_as_ranges() {
        let missing = |numbers: Vec<usize>| {
            Missing { part: "atlas".to_owned(), of: 90, numbers, is_timed: false }.to_string()
        };
        assert_eq!(missing(vec![3]), "atlas: 1 of 90 cells are missing: 3");
        let text = missing(vec![0, 1, 2, 7, 9, 10]);
        assert_eq!(text, "atlas: 6 of 90 cells are missing: 0–2, 7, 9–10");
        let many = missing((0..45).map(|n| 2 * n).collect());
        assert!(many.ends_with("20, 22, …"), "{many}");
    }
}
