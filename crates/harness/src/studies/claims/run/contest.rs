//! Contests: which method reaches an error in the least modelled time on a sheet of the study
//! `work-precision`.
//!
//! The budget of a run, in modelled time, grows until three methods reach every error within it, or
//! until the place of a method is decided. So what is recorded is exact, and what is far behind is
//! given up early: of a method that a claim names, too, slow forms end soon after its fastest. A form
//! whose run is exact enough is not run finer.
//!
//! Many claims ask about the same sheets. What one contest has computed on a sheet, its reference and
//! its runs, the others take over once it is finished.

use crate::HarnessError;
use crate::claims::places::{FIRST, Ground, TRUSTED};
use crate::cost::prices;
use crate::methods::Choice;
use crate::run::starts::starts_from;
use crate::run::{Runner, Simulation};
use crate::studies::claims::facts::Number;
use crate::studies::work_precision::facts::{Row, Run, cheapest};
use crate::studies::work_precision::run::scenes::{Case, SPAN, Setting, Shape, TOLERANCE, at_end};
use crate::studies::work_precision::run::truth::perturbed;
use crate::studies::work_precision::run::variants::{DOP853, VARIANTS, Variant};
use drape_integrator::PrepareError;
use drape_model::{ObstacleSpec, State, System, SystemSpec, TimeSpan};
use drape_report::Verdict;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Light damping over mass, 1/s.
const LIGHT: f64 = 40.0;
/// Particles of the usual sheet.
const USUAL: f64 = 400.0;
/// Times of so many methods are recorded, besides those that a claim names.
pub(super) const RECORDED: usize = 3;
/// Budget of the first round for [`USUAL`] particles, s, and how it grows.
const FIRST_BUDGET: f64 = 2e-3;
const GROWTH: f64 = 4.0;
/// Runs may cost so many times what counts in a round: a run whose cost can only be guessed is not
/// begun where the guess is beyond the budget.
const SLACK: f64 = 1.6;
/// Most modelled time of a round in which others could come ahead in a contest that decides a
/// place, s.
const MOST_OF_OTHERS: f64 = 120.0;
/// The ball: its highest point is 0.05 m below the middle of the sheet.
const BALL: ([f64; 3], f64) = ([0.0, 0.0, -0.25], 0.2);

/// The sheets of all contests so far, by name.
static SHEETS: Mutex<BTreeMap<String, Arc<Setting>>> = Mutex::new(BTreeMap::new());

/// A sheet with its exact solution, on which methods compete.
pub(super) struct Contest {
    pub(super) setting: Setting,
    ground: Ground,
}

/// A form with its runs so far.
type Tried = (&'static Variant, Option<Row>);

/// The least modelled time of a method for an error.
#[derive(Clone, Debug, PartialEq)]
struct Effort {
    method: String,
    seconds: f64,
    is_portable: bool,
}

impl Contest {
    pub(super) fn new(ground: Ground) -> Result<Self, HarnessError> {
        let known = || SHEETS.lock().unwrap_or_else(PoisonError::into_inner);
        let name = ground.name();
        let kept = known().get(&name).cloned();
        let setting = match kept {
            Some(kept) => {
                // A claim starts runs from it, even if all its runs are known.
                starts_from(&kept.simulation);
                kept
            }
            None => {
                // Computed without the lock, so that no thread waits for another. At worst two
                // contests compute the same reference, with the same bits.
                let setting = Arc::new(Self::sheet(&ground)?);
                known().entry(name).or_insert(setting).clone()
            }
        };
        Ok(Self { setting: (*setting).clone(), ground })
    }

    /// A sheet with its reference, which keeps the runs on it.
    fn sheet(ground: &Ground) -> Result<Setting, HarnessError> {
        let (case, spec) = (case(ground), spec(ground)?);
        // Contact leaves no method its order: above the ball the cheaper steps serve.
        let (method, shares) =
            if ground.has_ball { (VERLET, [0.125, 0.25]) } else { (NYSTROM, [0.5, 0.95]) };
        let end = |system: &System, state: &State, at: usize| {
            if ground.is_heavy {
                at_end(system, state, [TOLERANCE, 10.0 * TOLERANCE][at])
            } else {
                fine(system, state, method, shares[at])
            }
        };
        // The looser reference starts from a cloth that noise has moved: its distance from the
        // other is the error and the noise.
        let mut setting = Setting::of(&case, &spec, 0.0, |system, state| {
            let moved = perturbed(system, state);
            let (tight, loose) = rayon::join(|| end(system, state, 0), || end(system, &moved, 1));
            Ok([tight?, loose?])
        })?;
        setting.kept = Some(Arc::default());
        Ok(setting)
    }

    /// The sheet at its start.
    pub(super) fn start(ground: &Ground) -> Result<Simulation, HarnessError> {
        let (system, state) = spec(ground)?.build()?;
        Ok(Simulation { system, state })
    }

    /// The forms that are meant, before they have run.
    fn forms(is_meant: impl Fn(&Variant) -> bool) -> Vec<Tried> {
        let of_methods = |form: &&Variant| form.method != DOP853 && is_meant(form);
        VARIANTS.iter().filter(of_methods).map(|form| (form, None)).collect()
    }

    /// Whether a budget lets a form run, or run finer: what spent more before would end again.
    fn is_due((form, row): &Tried, budget: f64) -> bool {
        let last = row.as_ref().map(|row| row.runs.last());
        let is_over = |run: &Run| run.verdict == Verdict::OverBudget;
        last.is_none_or(|run| run.is_some_and(|r| is_over(r) && r.effort <= visits(form, budget)))
    }

    /// Runs the forms up to a modelled time, or on to it. A form's runs end at the visits that take
    /// at least this time at its prices. Forms that refuse the sheet leave the list.
    fn run(&self, forms: &mut Vec<Tried>, budget: f64) -> Result<(), HarnessError> {
        let run = |tried: &Tried| {
            let (form, row) = tried;
            if !Self::is_due(tried, budget) {
                return Ok(Some(tried.clone()));
            }
            let mut setting = self.setting.clone();
            setting.most_s = SLACK * budget;
            let runs = row.as_ref().map_or_else(Vec::new, |row| row.runs.clone());
            match setting.row_after(runs, form, None) {
                Err(HarnessError::Prepare(PrepareError::Unsupported { .. })) => Ok(None),
                row => row.map(|row| Some((*form, Some(row)))),
            }
        };
        let all: Result<Vec<_>, HarnessError> = forms.par_iter().with_max_len(1).map(run).collect();
        *forms = all?.into_iter().flatten().collect();
        Ok(())
    }

    /// Runs the forms up to a modelled time that grows until `is_enough` says so, at most to `most`
    /// seconds.
    fn run_on(
        &self,
        mut forms: Vec<Tried>,
        most: f64,
        is_enough: impl Fn(&[Tried], f64) -> bool,
    ) -> Result<Vec<Tried>, HarnessError> {
        let mut budget = self.first_budget().min(most);
        loop {
            self.run(&mut forms, budget)?;
            if budget >= most || is_enough(&forms, budget) {
                return Ok(forms);
            }
            budget = (GROWTH * budget).min(most);
        }
    }

    /// The modelled times of the named methods and of the three fastest, for each error.
    /// A named method that needs more than `most` seconds does not reach the error. Forms of which
    /// `is_meant` says no do not compete.
    pub(super) fn efforts(
        &mut self,
        named: &[&str],
        levels: &[f64],
        most: f64,
        is_meant: impl Fn(&Variant) -> bool,
    ) -> Result<Vec<Number>, HarnessError> {
        let is_named = |form: &Variant| named.contains(&id(form.method));
        self.setting.enough = levels.iter().copied().fold(f64::INFINITY, f64::min);
        let own = Self::forms(|form| is_named(form) && is_meant(form));
        let own = self.run_on(own, most, |own, budget| {
            levels.iter().all(|&level| has_all(&efforts(&[own], level), named, budget))
        })?;
        let others = Self::forms(|form| !is_named(form) && is_meant(form));
        let others = self.run_on(others, most, |others, budget| {
            let all = |level: f64| efforts(&[&own, others], level);
            levels.iter().all(|&level| within(&all(level), budget).count() >= RECORDED)
        })?;
        let of_level = |&level| self.numbers(named, level, &efforts(&[&own, &others], level));
        let numbers = levels.iter().flat_map(of_level);
        Ok(numbers.chain([self.doubt()]).collect())
    }

    /// The modelled times that decide the place of a method, for each error that the reference can
    /// tell: its own, those of the fastest others, and the time up to which all others were tried.
    /// Those that led elsewhere are tried first: where two of them are ahead, the place is decided.
    /// A method that does not reach an error within `most` seconds has at least this time.
    pub(super) fn places(
        &mut self,
        named: &str,
        leaders: &[String],
        levels: &[f64],
        most: f64,
        is_meant: impl Fn(&Variant) -> bool,
    ) -> Result<Vec<Number>, HarnessError> {
        let doubt = self.setting.scene.reference_error;
        let levels: Vec<_> =
            levels.iter().copied().filter(|level| doubt <= TRUSTED * level).collect();
        let mut numbers = vec![self.doubt()];
        if levels.is_empty() {
            return Ok(numbers);
        }
        self.setting.enough = levels.iter().copied().fold(f64::INFINITY, f64::min);
        let leads = |form: &Variant| leaders.iter().any(|leader| leader == id(form.method));
        let own = Self::forms(|form| id(form.method) == named && is_meant(form));
        let own = self.run_on(own, most, |own, budget| {
            levels.iter().all(|&level| has_all(&efforts(&[own], level), &[named], budget))
        })?;
        let group = |is_first: bool| {
            Self::forms(|form| {
                id(form.method) != named && leads(form) == is_first && is_meant(form)
            })
        };
        let mut groups = [own, group(true), group(false)];
        let all = |groups: &[Vec<Tried>; 3]| -> Vec<Vec<Effort>> {
            let groups = groups.each_ref().map(Vec::as_slice);
            levels.iter().map(|&level| efforts(&groups, level)).collect()
        };
        let mut tried = 0.0;
        for (others, most_of_round) in [(1, f64::INFINITY), (2, MOST_OF_OTHERS)] {
            tried = 0.0;
            let mut budget = self.first_budget();
            // Up to this time others may come ahead; the error that is decided soonest comes first.
            while let Some(needed) = all(&groups)
                .iter()
                .filter_map(|all| undecided(named, all, tried, most))
                .reduce(f64::min)
            {
                budget = budget.min(needed);
                let due = groups[others].iter().filter(|form| Self::is_due(form, budget)).count();
                if SLACK * budget * due as f64 > most_of_round {
                    break;
                }
                self.run(&mut groups[others], budget)?;
                tried = budget;
                budget = GROWTH * tried;
            }
        }
        for (&level, all) in levels.iter().zip(all(&groups)) {
            numbers.push(Number::new(self.ground.tried(level), tried, "s").of_machine());
            numbers.extend(self.numbers(&[named], level, &all));
        }
        Ok(numbers)
    }

    /// Of the first round, s.
    fn first_budget(&self) -> f64 {
        FIRST_BUDGET * self.setting.scene.particles as f64 / USUAL
    }

    fn doubt(&self) -> Number {
        Number::new(self.ground.doubt(), self.setting.scene.reference_error, "").of_machine()
    }

    fn numbers(&self, named: &[&str], level: f64, efforts: &[Effort]) -> Vec<Number> {
        let number = |method: &str, effort: Option<&Effort>| {
            let seconds = effort.map_or(f64::INFINITY, |effort| effort.seconds);
            let number = Number::new(self.ground.effort(level, method), seconds, "s");
            let is_portable = effort.is_some_and(|effort| effort.is_portable);
            if is_portable { number } else { number.of_machine() }
        };
        let leaders = efforts.iter().take(RECORDED);
        let mut numbers: Vec<_> = leaders.map(|e| number(&e.method, Some(e))).collect();
        let of = |method: &&&str| efforts.iter().position(|effort| effort.method == **method);
        let others = named.iter().filter(|method| of(method).is_none_or(|at| at >= RECORDED));
        numbers.extend(others.map(|method| number(method, of(&method).map(|at| &efforts[at]))));
        numbers
    }
}

const VERLET: &str = "leapfrog:step=bound,damping=explicit";
const NYSTROM: &str = "srkn4:step=bound";

/// The end by small steps: a share of the stability limit.
fn fine(system: &System, state: &State, method: &str, share: f64) -> Result<State, HarnessError> {
    let choice = Choice::parse(method, &[format!("safety={share}")])?;
    let time = TimeSpan { step_s: SPAN / 16.0, duration_s: SPAN };
    let mut simulation = Simulation { system: system.clone(), state: state.clone() };
    Runner::new(&choice, time).go(&mut simulation)?;
    Ok(simulation.state)
}

fn case(ground: &Ground) -> Case {
    let Ground { stiffness, side, is_heavy, .. } = *ground;
    Case {
        shape: Shape::Hanging,
        is_heavy,
        stiffness,
        side,
        light: LIGHT,
        series: Vec::new(),
        budget: f64::INFINITY,
    }
}

fn spec(ground: &Ground) -> Result<SystemSpec, HarnessError> {
    let mut spec = case(ground).spec()?;
    let (center, radius) = BALL;
    spec.obstacles.extend(ground.has_ball.then(|| ObstacleSpec::sphere(center, radius, 0.0)));
    Ok(spec)
}

/// The id of a method with settings.
pub(super) fn id(method: &str) -> &str {
    method.split(':').next().unwrap_or(method)
}

/// Those of at most so many seconds.
fn within(efforts: &[Effort], seconds: f64) -> impl Iterator<Item = &Effort> {
    efforts.iter().filter(move |effort| effort.seconds <= seconds)
}

/// Whether each of these methods is among those of at most so many seconds.
fn has_all(efforts: &[Effort], methods: &[&str], seconds: f64) -> bool {
    methods.iter().all(|method| within(efforts, seconds).any(|effort| effort.method == *method))
}

/// The time up to which others must be tried to decide the place of a method, where all were tried
/// up to `tried` seconds; `None` where it is decided. A method that does not reach the error needs
/// more than `most` seconds.
fn undecided(named: &str, efforts: &[Effort], tried: f64, most: f64) -> Option<f64> {
    let own = efforts.iter().find(|effort| effort.method == named);
    let own = own.map_or(most, |effort| effort.seconds);
    let ahead = efforts.iter().filter(|effort| effort.method != named && effort.seconds < own);
    (own > tried && ahead.count() < FIRST).then_some(own)
}

/// The visits after which a run of a form is over a budget in s.
fn visits(form: &Variant, budget: f64) -> f64 {
    prices().of(form.method).visits_within(SLACK * budget)
}

/// The least time of each method whose runs reach an error, the least first. Of equal times the
/// methods stand in the order of the registry.
fn efforts(forms: &[&[Tried]], level: f64) -> Vec<Effort> {
    let rows = || forms.iter().copied().flatten().filter_map(|(_, row)| row.as_ref());
    let mut efforts: Vec<Effort> = Vec::new();
    for method in crate::methods::all() {
        let own = rows().filter(|row| id(&row.method) == method.id);
        efforts.extend(cheapest(own, level).map(|(_, run)| Effort {
            method: method.id.to_owned(),
            seconds: run.modelled_s,
            is_portable: run.portable,
        }));
    }
    efforts.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    efforts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn effort(method: &str, seconds: f64) -> Effort {
        Effort { method: method.to_owned(), seconds, is_portable: true }
    }

    #[test]
    fn a_place_is_decided_when_two_are_ahead_or_nobody_can_be() {
        let of = |efforts: &[(&str, f64)], tried| {
            let efforts = efforts.iter().map(|(method, seconds)| effort(method, *seconds));
            undecided("a", &efforts.collect::<Vec<_>>(), tried, 8.0)
        };
        assert_eq!(of(&[("b", 1.0), ("a", 4.0)], 2.0), Some(4.0), "a third may lie between");
        assert_eq!(of(&[("b", 1.0), ("a", 4.0)], 4.0), None, "it is second");
        assert_eq!(of(&[("b", 1.0), ("c", 3.0), ("a", 4.0)], 0.0), None, "two are ahead");
        assert_eq!(of(&[("b", 1.0), ("c", 5.0), ("a", 4.0)], 2.0), Some(4.0), "c is behind");
        assert_eq!(of(&[("b", 1.0)], 2.0), Some(8.0), "it does not reach the error");
        assert_eq!(of(&[("b", 1.0), ("c", 7.0)], 2.0), None, "two reach it in its budget");
        assert_eq!(of(&[("b", 1.0), ("c", 9.0)], 2.0), Some(8.0), "one reaches it in its budget");
    }

    /// A run of a form may cost more than the budget of its round. Another form may be cheaper then.
    #[test]
    fn a_time_is_known_when_it_lies_within_the_budget() {
        let all = [effort("a", 1.0), effort("b", 3.0)];
        assert!(has_all(&all, &["a", "b"], 3.0) && has_all(&all, &["a"], 1.0));
        assert!(!has_all(&all, &["a", "b"], 2.9) && !has_all(&all, &["c"], 9.0));
    }
}
