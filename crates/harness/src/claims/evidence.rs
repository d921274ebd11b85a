//! What a claim reads: recorded numbers by their names.

use super::{Judgement, Ruling};
use crate::studies::claims::facts::Number;
use std::ops::Not;

/// The recorded numbers of one claim.
#[derive(Clone, Copy, Debug)]
pub struct Evidence<'a> {
    numbers: &'a [Number],
}

/// A number that the record lacks.
#[derive(Clone, Debug)]
pub(super) struct Missing(String);

impl From<Missing> for Judgement {
    fn from(missing: Missing) -> Self {
        Self {
            verdict: Ruling::Undecided,
            reason: format!("The record lacks a number: “{}”.", missing.0),
            repair: None,
        }
    }
}

impl<'a> Evidence<'a> {
    /// What a row of the record holds.
    pub fn new(numbers: &'a [Number]) -> Self {
        Self { numbers }
    }

    /// The number of a name.
    pub(super) fn number(self, what: &str) -> Result<&'a Number, Missing> {
        let found = self.numbers.iter().find(|number| number.what == what);
        found.ok_or_else(|| Missing(what.to_owned()))
    }

    /// The value of a name.
    pub(super) fn value(self, what: &str) -> Result<f64, Missing> {
        self.number(what).map(|number| number.value)
    }

    /// The numbers whose names begin so, each with the rest of its name; at least one.
    pub(super) fn rows(self, prefix: &str) -> Result<Vec<(&'a str, &'a Number)>, Missing> {
        self.cut(prefix, |what| what.strip_prefix(prefix))
    }

    /// As [`rows`](Self::rows), by the end of the names.
    pub(super) fn ending(self, suffix: &str) -> Result<Vec<(&'a str, &'a Number)>, Missing> {
        self.cut(suffix, |what| what.strip_suffix(suffix))
    }

    fn cut(
        self,
        part: &str,
        rest: impl Fn(&'a str) -> Option<&'a str>,
    ) -> Result<Vec<(&'a str, &'a Number)>, Missing> {
        let named = |number: &'a Number| Some((rest(&number.what)?, number));
        let rows: Vec<_> = self.numbers.iter().filter_map(named).collect();
        rows.is_empty().not().then_some(rows).ok_or_else(|| Missing(part.to_owned()))
    }

    /// The values of [`rows`](Self::rows).
    pub(super) fn values(self, prefix: &str) -> Result<Vec<f64>, Missing> {
        Ok(self.rows(prefix)?.iter().map(|(_, number)| number.value).collect())
    }

    /// The values of [`rows`](Self::rows) in series: names that differ only behind `by` belong
    /// together.
    pub(super) fn series(
        self,
        prefix: &str,
        by: &str,
    ) -> Result<Vec<(&'a str, Vec<f64>)>, Missing> {
        let mut series: Vec<(&str, Vec<f64>)> = Vec::new();
        for (rest, number) in self.rows(prefix)? {
            let name = rest.rsplit_once(by).map_or(rest, |(name, _)| name);
            match series.iter_mut().find(|(other, _)| *other == name) {
                Some((_, values)) => values.push(number.value),
                None => series.push((name, vec![number.value])),
            }
        }
        Ok(series)
    }

    /// Each number of [`rows`](Self::rows) over the one of the same rest that begins with `below`.
    pub(super) fn quotients(self, above: &str, below: &str) -> Result<Vec<f64>, Missing> {
        let quotient = |(rest, number): &(&str, &Number)| {
            Ok(number.value / self.value(&format!("{below}{rest}"))?)
        };
        self.rows(above)?.iter().map(quotient).collect()
    }
}

/// The least and the greatest of some values.
pub(super) fn span(values: &[f64]) -> (f64, f64) {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    (least, values.iter().copied().fold(f64::NEG_INFINITY, f64::max))
}

/// A value in prose; the largest number stands for all that are not finite.
pub(super) fn told(value: f64) -> String {
    match value {
        0.0 => "0".to_owned(),
        value if value.abs() >= f64::MAX => "∞".to_owned(),
        value if value.fract() == 0.0 && value.abs() < 1e5 => format!("{value}"),
        value => crate::studies::short(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_is_named_by_all_before_the_last_mark() {
        let number = |what: &str, value| Number::new(what, value, "");
        let numbers = [
            number("error, a, h = 1, h = 2", 3.0),
            number("error, b, h = 2", 4.0),
            number("error, a, h = 1, h = 4", 5.0),
        ];
        let series = Evidence::new(&numbers).series("error, ", ", h = ").unwrap_or_default();
        assert_eq!(series, [("a, h = 1", vec![3.0, 5.0]), ("b", vec![4.0])]);
    }
}
