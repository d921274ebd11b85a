//! Who reaches an error for the least modelled time: the sheets of the contests and the places in
//! them.

use super::evidence::{Evidence, Missing};
use super::{Judgement, Ruling, told};
use std::ops::Not;

/// A method is among the first if at most one other is ahead of it.
pub(crate) const FIRST: usize = 2;
/// A reference ranks methods by an error if its own doubt is at most this share of the error: as in
/// the studies, an error ranks if it is at least twice the noise.
pub(crate) const TRUSTED: f64 = 0.5;

/// Modelled times within this factor are a tie, as in the study `work-precision`: steps are powers of
/// two, and prices have errors of 25 %. What only a tie refutes is undecided.
pub(crate) const TIE: f64 = 2.0;

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

    /// What the doubt of its reference is called: the distance between two references, of which the
    /// looser starts from a cloth that noise has moved.
    pub(crate) fn doubt(&self) -> String {
        format!("doubt of the reference at {}", self.name())
    }

    /// What the time is called up to which every method was tried for an error.
    pub(crate) fn tried(&self, level: f64) -> String {
        format!("all tried at {} for {level:e} up to", self.name())
    }

    /// What the effort of a method for an error is called.
    pub(crate) fn effort(&self, level: f64, method: &str) -> String {
        format!("time at {} for {level:e}, {method}", self.name())
    }
}

/// The place of a method on a sheet, for one error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place<'a> {
    /// The method of least effort.
    pub(super) winner: &'a str,
    /// Effort over the least of the other methods; infinite if it does not reach the error.
    pub(super) ratio: f64,
    /// Its effort; the largest number if it does not reach the error.
    own: f64,
    /// The efforts of the other methods, least first.
    others: [f64; FIRST],
    /// How many other methods need less.
    ahead: usize,
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
        let ahead = others().filter(|(_, number)| number.value < own).count();
        let mut least = others().map(|(_, number)| number.value);
        let others = [(); FIRST].map(|()| least.next().unwrap_or(f64::MAX));
        let [best, ..] = others;
        Ok(Self {
            winner: all[0].0,
            ratio: if is_reached { own / best } else { f64::INFINITY },
            own,
            others,
            ahead,
        })
    }

    /// 1 for the least effort; `None` if the method does not reach the error.
    fn rank(&self) -> Option<usize> {
        (self.own < f64::MAX).then_some(1 + self.ahead)
    }

    /// Whether it is known if the method is among the first, where every method was tried up to
    /// this time: enough others are ahead, or nobody else can be.
    fn is_decided(&self, tried: f64) -> bool {
        self.ahead >= FIRST || self.own <= tried
    }

    pub(super) fn is_among_first(&self) -> bool {
        self.rank().is_some_and(|rank| rank <= FIRST)
    }

    pub(super) fn is_first(&self) -> bool {
        self.rank() == Some(1)
    }

    /// Whether it is so far from being among the first so many that a tie cannot explain it.
    fn is_clearly_behind(&self, count: usize) -> bool {
        self.rank().is_none() || self.own > TIE * self.others[count - 1]
    }

    /// Whether it is so clearly among the first so many that a tie cannot explain it.
    fn is_clearly_among(&self, count: usize) -> bool {
        TIE * self.own < self.others[count - 1]
    }

    /// The verdict on a claim that the method is among the first.
    fn leads(&self) -> Ruling {
        missed(!self.is_among_first(), self.is_clearly_behind(FIRST))
    }

    /// The verdict on a claim that the method is not among the first.
    fn lags(&self) -> Ruling {
        missed(self.is_among_first(), self.is_clearly_among(FIRST))
    }

    /// The verdict on a claim that the method is not the first.
    fn follows(&self) -> Ruling {
        missed(self.is_first(), self.is_clearly_among(1))
    }
}

/// The verdict on a criterion that is missed or not, clearly or within a tie.
pub(super) fn missed(is_missed: bool, is_clear: bool) -> Ruling {
    match (is_missed, is_clear) {
        (false, _) => Ruling::Holds,
        (true, false) => Ruling::Undecided,
        (true, true) => Ruling::Fails,
    }
}

/// The verdict on a claim that all of these must meet: one that fails refutes it, and it does not
/// hold while one is undecided.
pub(super) fn all_of(rulings: impl IntoIterator<Item = Ruling>) -> Ruling {
    let mut worst = Ruling::Holds;
    for ruling in rulings {
        worst = match (worst, ruling) {
            (Ruling::Fails, _) | (_, Ruling::Fails) => Ruling::Fails,
            (Ruling::Undecided, _) | (_, Ruling::Undecided) => Ruling::Undecided,
            _ => Ruling::Holds,
        };
    }
    worst
}

/// Contests that rank nobody, by the reason.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Open {
    /// The error is less than twice the doubt of the reference, in which noise has its part. There
    /// is nothing to rank.
    doubt: usize,
    /// There is no reference.
    none: usize,
    /// The work for the contest came to an end before its place was known.
    work: usize,
}

impl Open {
    /// Those that more work could decide.
    fn undecided(self) -> usize {
        self.none + self.work
    }

    /// As a part of a sentence; empty where there are none.
    fn told(self) -> String {
        let parts = [
            (self.doubt, "hidden by noise"),
            (self.none, "undecided without a reference"),
            (self.work, "undecided because work ended before all methods were tried"),
        ];
        let parts = parts.iter().filter(|(count, _)| *count > 0);
        parts.map(|(count, why)| format!("; {count} more: {why}")).collect()
    }
}

/// The places of one method in several contests.
pub(super) struct Places<'a> {
    method: &'a str,
    /// Of the contests that are decided.
    all: Vec<(String, Place<'a>)>,
    open: Open,
}

impl<'a> Places<'a> {
    /// Of contests in which every method was tried.
    pub(super) fn of(
        evidence: Evidence<'a>,
        method: &'a str,
        grounds: &[Ground],
        levels: &[f64],
    ) -> Result<Self, Missing> {
        Self::read(evidence, method, grounds, levels, |_| Ok(f64::INFINITY))
    }

    /// Of contests that record up to which time every method was tried.
    pub(super) fn of_tried(
        evidence: Evidence<'a>,
        method: &'a str,
        grounds: &[Ground],
        levels: &[f64],
    ) -> Result<Self, Missing> {
        Self::read(evidence, method, grounds, levels, |what| evidence.value(what))
    }

    fn read(
        evidence: Evidence<'a>,
        method: &'a str,
        grounds: &[Ground],
        levels: &[f64],
        tried: impl Fn(&str) -> Result<f64, Missing>,
    ) -> Result<Self, Missing> {
        let (mut all, mut open) = (Vec::new(), Open::default());
        for ground in grounds {
            let doubt = evidence.value(&ground.doubt())?;
            for &level in levels {
                if doubt >= f64::MAX {
                    open.none += 1;
                    continue;
                }
                if doubt > TRUSTED * level {
                    open.doubt += 1;
                    continue;
                }
                let place = Place::of(evidence, ground, level, method)?;
                if place.is_decided(tried(&ground.tried(level))?) {
                    all.push((format!("{level:e} at k/m = {}", ground.name()), place));
                } else {
                    open.work += 1;
                }
            }
        }
        Ok(Self { method, all, open })
    }

    fn count(&self, is_meant: impl Fn(&Place<'a>) -> bool) -> usize {
        self.all.iter().filter(|(_, place)| is_meant(place)).count()
    }

    fn each(&self, ruling: impl Fn(&Place<'a>) -> Ruling) -> Ruling {
        all_of(self.all.iter().map(|(_, place)| ruling(place)))
    }

    /// The verdict on a claim that it is among the first everywhere.
    pub(super) fn lead(&self) -> Ruling {
        self.each(Place::leads)
    }

    /// The verdict on a claim that it is among the first nowhere.
    pub(super) fn lag(&self) -> Ruling {
        self.each(Place::lags)
    }

    /// The verdict on a claim that it is the first nowhere.
    pub(super) fn follow(&self) -> Ruling {
        self.each(Place::follows)
    }

    /// How often it is among the first, as a part of a sentence.
    pub(super) fn told(&self) -> String {
        let Self { method, all, open } = self;
        let (among, first) = (self.count(Place::is_among_first), self.count(Place::is_first));
        format!(
            "`{method}` is among the first two in {among} of {} cases, first in {first}{}",
            all.len(),
            open.told()
        )
    }

    /// Where it is farthest behind the first; `None` where nobody is ahead of it.
    pub(super) fn worst(&self) -> Option<String> {
        let (at, place) = self.all.iter().max_by(|(_, a), (_, b)| a.ratio.total_cmp(&b.ratio))?;
        let method = self.method;
        (place.ratio > 1.0).then(|| match place.rank() {
            None => format!("`{method}` does not reach {at} within its budget"),
            Some(_) => {
                let (ratio, winner) = (told(place.ratio), place.winner);
                format!("`{method}` needs {ratio} times the time of `{winner}` for {at}")
            }
        })
    }
}

/// Reason of a claim about places: how often each method is among the first, and the worst case.
/// The claim is one about all contests that noise lets rank: one of them refutes it, and it does not
/// hold while one is undecided, or without any.
pub(super) fn judgement(verdict: Ruling, places: &[Places<'_>]) -> Judgement {
    let told: Vec<_> = places.iter().map(Places::told).collect();
    let worst: Vec<_> = places.iter().filter_map(Places::worst).collect();
    let tie = match verdict {
        Ruling::Undecided => format!("; each miss is a tie (within a factor of {TIE})"),
        _ => String::new(),
    };
    let mut reason = format!("{}{tie}.", told.join("; "));
    if worst.is_empty().not() {
        let worst = worst.join("; ");
        reason = format!("{reason} Farthest behind: {worst}.");
    }
    let is_open = places.iter().any(|own| own.open.undecided() > 0 || own.all.is_empty());
    let verdict = if is_open { all_of([verdict, Ruling::Undecided]) } else { verdict };
    Judgement { verdict, reason, repair: None }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::{Claim, Number};
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
            numbers.push(Number::new(ground.doubt(), 1e-9, ""));
            for (l, &level) in levels.iter().enumerate() {
                numbers.push(Number::new(ground.tried(level), f64::INFINITY, "s"));
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
        let place = place.map(|place| (place.rank(), place.winner.to_owned(), place.ratio));
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

    /// A contest in noise counts for nothing; one that was left, or has no reference, leaves the claim
    /// undecided. Others still refute.
    #[test]
    fn a_contest_in_doubt_ranks_nobody() {
        let other = Ground::light(1e6);
        let ruled = |doubt: f64, rival: f64, tried: f64, own: f64| {
            let mut all =
                numbers(&[GROUND], &[0.1], &[("a", 1.0), ("b", rival), ("c", rival)], None);
            all.extend(numbers(&[other], &[0.1], &[("b", 1.0), ("c", 2.0), ("a", own)], None));
            for number in &mut all {
                if number.what == other.doubt() {
                    number.value = doubt;
                } else if number.what == other.tried(0.1) {
                    number.value = tried;
                }
            }
            let places = Places::of_tried(Evidence::new(&all), "a", &[GROUND, other], &[0.1]);
            let places = places.unwrap_or_else(|_| panic!("a number is missing"));
            let open = places.open;
            (judgement(places.lead(), &[places]).verdict, open)
        };
        let none = Open::default();
        let (doubt, missing) = (Open { doubt: 1, ..none }, Open { none: 1, ..none });
        let work = Open { work: 1, ..none };
        assert_eq!(ruled(0.05, 2.0, 9.0, 4.1), (Ruling::Fails, none), "two are ahead");
        assert_eq!(ruled(0.05, 2.0, 9.0, 4.0), (Ruling::Undecided, none), "a tie");
        assert_eq!(ruled(0.051, 2.0, 9.0, 4.1), (Ruling::Holds, doubt), "noise ranks nobody");
        assert_eq!(ruled(f64::MAX, 2.0, 9.0, 3.0), (Ruling::Undecided, missing));
        assert_eq!(ruled(0.051, 0.4, 9.0, 3.0), (Ruling::Fails, doubt));
        assert_eq!(ruled(0.0, 2.0, 1.5, 1.5), (Ruling::Holds, none), "nobody else is ahead");
        assert_eq!(ruled(0.0, 2.0, 1.4, 1.5), (Ruling::Undecided, work), "one more may be");
        assert_eq!(ruled(0.0, 2.0, 0.0, 4.1), (Ruling::Fails, none), "two are ahead");
        // A method that does not reach the error in its budget is no worse than that budget.
        assert_eq!(ruled(0.0, 2.0, 9.0, f64::MAX), (Ruling::Fails, none));
        let all = Open { doubt: 2, ..work };
        let ended = "1 more: undecided because work ended before all methods were tried";
        assert_eq!(all.told(), format!("; 2 more: hidden by noise; {ended}"));
    }

    #[test]
    fn what_only_a_tie_refutes_is_undecided() {
        use Ruling::{Fails, Holds, Undecided};
        let place = |own: f64| {
            let efforts = [("a", own), ("b", 2.0), ("c", 4.0)];
            let numbers = numbers(&[GROUND], &[0.1], &efforts, None);
            Place::of(Evidence::new(&numbers), &GROUND, 0.1, "a")
                .map(|place| [place.leads(), place.lags(), place.follows()])
                .unwrap_or_else(|_| panic!("a number is missing"))
        };
        assert_eq!(place(8.1), [Fails, Holds, Holds]);
        assert_eq!(place(8.0), [Undecided, Holds, Holds]);
        assert_eq!(place(2.0), [Holds, Undecided, Undecided]);
        assert_eq!(place(1.9), [Holds, Fails, Undecided]);
        assert_eq!(place(0.9), [Holds, Fails, Fails]);
        assert_eq!(place(f64::INFINITY), [Fails, Holds, Holds]);
        assert_eq!(all_of([Holds, Undecided]), Undecided);
        assert_eq!(all_of([Undecided, Fails, Holds]), Fails);
        assert_eq!(all_of([]), Holds);
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
