//! Who reaches an error for the least modelled time: the sheets of the contests and the places in
//! them.

use super::evidence::{Evidence, Missing};
use super::{Judgement, told};
use std::ops::Not;

/// A method is among the first if at most one other is ahead of it.
pub(super) const FIRST: usize = 2;

/// A sheet on which methods compete: the hanging sheet of the study `work-precision`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ground {
    /// `k/m` of its springs, 1/s².
    pub(crate) stiffness: f64,
    /// Particles along each edge.
    pub(crate) side: u32,
    /// `d/m = √(k/m)`, not 40/s.
    pub(crate) is_heavy: bool,
    /// Whether the sheet falls on a ball.
    pub(crate) has_ball: bool,
}

impl Ground {
    /// A sheet of 400 particles with light damping.
    pub(crate) const fn light(stiffness: f64) -> Self {
        Self { stiffness, side: 20, is_heavy: false, has_ball: false }
    }

    /// A sheet of 400 particles with heavy damping.
    pub(crate) const fn heavy(stiffness: f64) -> Self {
        Self { is_heavy: true, ..Self::light(stiffness) }
    }

    /// The same with other particles. A fabric that is cut into `n/400` times as many has `n/400`
    /// times as much `k/m`.
    pub(crate) const fn of_side(self, side: u32) -> Self {
        Self { side, ..self }
    }

    /// The same above a ball.
    pub(crate) const fn on_ball(self) -> Self {
        Self { has_ball: true, ..self }
    }

    /// Its name; recorded numbers begin with it.
    pub(crate) fn name(&self) -> String {
        let damping = if self.is_heavy { " heavy" } else { "" };
        let ball = if self.has_ball { " with a ball" } else { "" };
        let Self { stiffness, side, .. } = self;
        let size = if *side == 20 { String::new() } else { format!(" n = {}", side * side) };
        format!("{stiffness:e}{damping}{size}{ball}")
    }

    /// What the effort of a method for an error is called.
    pub(crate) fn effort(&self, level: f64, method: &str) -> String {
        format!("time at {} for {level:e}, {method}", self.name())
    }
}

/// The place of a method on a sheet, for one error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place<'a> {
    /// 1 for the least effort; `None` if the method does not reach the error.
    pub(super) rank: Option<usize>,
    /// The method of least effort.
    pub(super) winner: &'a str,
    /// Effort over the least of the other methods; infinite if it does not reach the error.
    pub(super) ratio: f64,
}

impl<'a> Place<'a> {
    /// Reads the efforts of all methods that are recorded for this sheet and error.
    pub(super) fn of(
        evidence: Evidence<'a>,
        ground: &Ground,
        level: f64,
        method: &str,
    ) -> Result<Self, Missing> {
        let own = evidence.value(&ground.effort(level, method))?;
        let mut all = evidence.rows(&ground.effort(level, ""))?;
        all.sort_by(|(_, a), (_, b)| a.value.total_cmp(&b.value));
        let others = || all.iter().filter(|(name, _)| *name != method);
        let is_reached = own < f64::MAX;
        let rank = 1 + others().filter(|(_, number)| number.value < own).count();
        let best = others().map(|(_, number)| number.value).next().unwrap_or(f64::MAX);
        Ok(Self {
            rank: is_reached.then_some(rank),
            winner: all[0].0,
            ratio: if is_reached { own / best } else { f64::INFINITY },
        })
    }

    pub(super) fn is_among_first(&self) -> bool {
        self.rank.is_some_and(|rank| rank <= FIRST)
    }

    pub(super) fn is_first(&self) -> bool {
        self.rank == Some(1)
    }
}

/// The places of one method in several contests.
pub(super) struct Places<'a> {
    method: &'a str,
    all: Vec<(String, Place<'a>)>,
}

impl<'a> Places<'a> {
    pub(super) fn of(
        evidence: Evidence<'a>,
        method: &'a str,
        grounds: &[Ground],
        levels: &[f64],
    ) -> Result<Self, Missing> {
        let mut all = Vec::new();
        for ground in grounds {
            for &level in levels {
                let at = format!("{level:e} at k/m = {}", ground.name());
                all.push((at, Place::of(evidence, ground, level, method)?));
            }
        }
        Ok(Self { method, all })
    }

    fn count(&self, is_meant: impl Fn(&Place<'a>) -> bool) -> usize {
        self.all.iter().filter(|(_, place)| is_meant(place)).count()
    }

    pub(super) fn are_all_among_first(&self) -> bool {
        self.count(Place::is_among_first) == self.all.len()
    }

    pub(super) fn is_any_among_first(&self) -> bool {
        self.count(Place::is_among_first) > 0
    }

    pub(super) fn is_any_first(&self) -> bool {
        self.count(Place::is_first) > 0
    }

    /// How often it is among the first, as a part of a sentence.
    pub(super) fn told(&self) -> String {
        let Self { method, all } = self;
        let (among, first) = (self.count(Place::is_among_first), self.count(Place::is_first));
        format!(
            "`{method}` is among the first two in {among} of {} cases, first in {first}",
            all.len()
        )
    }

    /// Where it is farthest behind the first; `None` where nobody is ahead of it.
    pub(super) fn worst(&self) -> Option<String> {
        let (at, place) = self.all.iter().max_by(|(_, a), (_, b)| a.ratio.total_cmp(&b.ratio))?;
        let method = self.method;
        (place.ratio > 1.0).then(|| match place.rank {
            None => format!("`{method}` does not reach {at} within its budget"),
            Some(_) => {
                let (ratio, winner) = (told(place.ratio), place.winner);
                format!("`{method}` needs {ratio} times the time of `{winner}` for {at}")
            }
        })
    }
}

/// Reason of a claim about places: how often each method is among the first, and the worst case.
pub(super) fn judgement(is_met: bool, places: &[Places<'_>]) -> Judgement {
    let told: Vec<_> = places.iter().map(Places::told).collect();
    let worst: Vec<_> = places.iter().filter_map(Places::worst).collect();
    let mut reason = format!("{}.", told.join("; "));
    if worst.is_empty().not() {
        let worst = worst.join("; ");
        reason = format!("{reason} Farthest behind: {worst}.");
    }
    Judgement::new(is_met, reason)
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::{Claim, Number, Ruling};
    use super::*;

    /// A sheet, an error, and the efforts there.
    type Changed<'a> = (usize, usize, &'a [(&'a str, f64)]);

    /// The verdict if on every sheet, for every error, the methods need these efforts; `changed`
    /// replaces those of one sheet and error.
    pub(in crate::claims) fn contest(
        claim: &Claim,
        grounds: &[Ground],
        levels: &[f64],
        efforts: &[(&str, f64)],
        changed: Option<Changed<'_>>,
    ) -> Ruling {
        claim.judge(&Evidence::new(&numbers(grounds, levels, efforts, changed))).verdict
    }

    /// The numbers of [`contest`].
    pub(in crate::claims) fn numbers(
        grounds: &[Ground],
        levels: &[f64],
        efforts: &[(&str, f64)],
        changed: Option<Changed<'_>>,
    ) -> Vec<Number> {
        let mut numbers = Vec::new();
        for (g, ground) in grounds.iter().enumerate() {
            for (l, &level) in levels.iter().enumerate() {
                let other = changed.filter(|(at, of, _)| (*at, *of) == (g, l));
                let efforts = other.map_or(efforts, |(.., efforts)| efforts);
                numbers.extend(efforts.iter().map(|&(method, effort)| {
                    Number::new(ground.effort(level, method), effort, "visits")
                }));
            }
        }
        numbers
    }

    const GROUND: Ground = Ground::light(1e4);

    fn place(efforts: &[(&str, f64)]) -> (Option<usize>, String, f64) {
        let numbers = numbers(&[GROUND], &[0.1], efforts, None);
        let place = Place::of(Evidence::new(&numbers), &GROUND, 0.1, "a").ok();
        let place = place.map(|place| (place.rank, place.winner.to_owned(), place.ratio));
        place.unwrap_or((None, "nothing is recorded".to_owned(), 0.0))
    }

    #[test]
    fn a_place_counts_those_ahead_and_an_error_that_is_not_reached_gives_none() {
        assert_eq!(place(&[("a", 2.0), ("b", 4.0)]), (Some(1), "a".to_owned(), 0.5));
        assert_eq!(place(&[("b", 1.0), ("a", 2.0), ("c", 2.0)]), (Some(2), "b".to_owned(), 2.0));
        let third = [("b", 1.0), ("c", 1.5), ("a", 2.0)];
        assert_eq!(place(&third), (Some(3), "b".to_owned(), 2.0));
        assert_eq!(place(&[("a", f64::INFINITY), ("b", 1.0)]).0, None);
        assert_eq!(place(&[("b", 1.0)]).1, "nothing is recorded");
        assert_eq!(place(&[("a", 1.0)]), (Some(1), "a".to_owned(), 1.0 / f64::MAX));
    }

    #[test]
    fn each_sheet_has_a_name_of_its_own() {
        let light = Ground::light(1e6);
        let all = [light, Ground::heavy(1e6), light.of_side(40), light.on_ball()];
        let names = all.map(|ground| ground.name());
        assert_eq!(names, ["1e6", "1e6 heavy", "1e6 n = 1600", "1e6 with a ball"]);
        assert_eq!(light.effort(1e-3, "a"), "time at 1e6 for 1e-3, a");
    }
}
