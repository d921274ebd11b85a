//! Contests: which method reaches an error in the least modelled time on a sheet of the study
//! `work-precision`.
//!
//! The budget of a run, in modelled time, grows until three methods reach every error within it. So
//! the first three are exact,
//! and what is far behind is given up early. A form whose run is exact enough is not run finer.

use crate::HarnessError;
use crate::claims::places::Ground;
use crate::cost::prices;
use crate::methods::Choice;
use crate::run::{Runner, Simulation};
use crate::studies::claims::facts::Number;
use crate::studies::work_precision::facts::{Row, cheapest};
use crate::studies::work_precision::run::scenes::{Case, SPAN, Setting, Shape};
use crate::studies::work_precision::run::variants::{DOP853, VARIANTS, Variant};
use drape_integrator::PrepareError;
use drape_model::{ObstacleSpec, State, System, SystemSpec, TimeSpan};
use rayon::prelude::*;

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
/// The ball: its highest point is 0.05 m below the middle of the sheet.
const BALL: ([f64; 3], f64) = ([0.0, 0.0, -0.25], 0.2);

/// A sheet with its exact solution, on which methods compete.
pub(super) struct Contest {
    pub(super) setting: Setting,
    ground: Ground,
}

/// The least modelled time of a method for an error.
#[derive(Clone, Debug)]
struct Effort {
    method: String,
    seconds: f64,
    is_portable: bool,
}

impl Contest {
    pub(super) fn new(ground: Ground) -> Result<Self, HarnessError> {
        let (case, spec) = (case(&ground), spec(&ground)?);
        let setting = if ground.is_heavy {
            Setting::new(&case)?
        } else {
            // Contact leaves no method its order: above the ball the cheaper steps serve.
            let (method, shares) =
                if ground.has_ball { (VERLET, [0.125, 0.25]) } else { (NYSTROM, [0.5, 0.95]) };
            Setting::of(&case, &spec, 0.0, |system, state| {
                let end = |share| fine(system, state, method, share);
                Ok([end(shares[0])?, end(shares[1])?])
            })?
        };
        Ok(Self { setting, ground })
    }

    /// The sheet at its start.
    pub(super) fn start(ground: &Ground) -> Result<Simulation, HarnessError> {
        let (system, state) = spec(ground)?.build()?;
        Ok(Simulation { system, state })
    }

    /// The runs of the forms that are meant, up to a modelled time. A form's runs end at the visits
    /// that take at least this time at its prices.
    fn rows(
        &self,
        budget: f64,
        is_meant: impl Fn(&Variant) -> bool,
    ) -> Result<Vec<Row>, HarnessError> {
        let of_methods = |form: &&Variant| form.method != DOP853 && is_meant(form);
        let forms: Vec<&Variant> = VARIANTS.iter().filter(of_methods).collect();
        let run = |form: &&Variant| {
            let mut setting = self.setting.clone();
            let ns_a_visit = prices().of(form.method).least_ns_a_visit;
            setting.case.budget = SLACK * 1e9 * budget / ns_a_visit;
            match setting.row(form, None) {
                Err(HarnessError::Prepare(PrepareError::Unsupported { .. })) => Ok(None),
                row => row.map(Some),
            }
        };
        let rows: Result<Vec<_>, HarnessError> =
            forms.par_iter().with_max_len(1).map(run).collect();
        Ok(rows?.into_iter().flatten().collect())
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
        let own = self.rows(most, |form| is_named(form) && is_meant(form))?;
        let mut budget = (FIRST_BUDGET * self.setting.scene.particles as f64 / USUAL).min(most);
        loop {
            let mut rows = self.rows(budget, |form| !is_named(form) && is_meant(form))?;
            rows.extend(own.iter().cloned());
            let all: Vec<Vec<Effort>> = levels.iter().map(|&level| efforts(&rows, level)).collect();
            let known = |efforts: &Vec<Effort>| {
                efforts.iter().filter(|effort| effort.seconds <= budget).count() >= RECORDED
            };
            if budget >= most || all.iter().all(known) {
                let of_level = levels.iter().zip(&all);
                let numbers = of_level.map(|(&level, all)| self.numbers(named, level, all));
                let doubt = format!("doubt of the reference at {}", self.ground.name());
                let doubt = Number::new(doubt, self.setting.scene.reference_error, "");
                return Ok(numbers.flatten().chain([doubt.of_machine()]).collect());
            }
            budget = (GROWTH * budget).min(most);
        }
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
        budget: 0.0,
    }
}

fn spec(ground: &Ground) -> Result<SystemSpec, HarnessError> {
    let mut spec = case(ground).spec()?;
    let (center, radius) = BALL;
    spec.obstacles.extend(ground.has_ball.then(|| ObstacleSpec::sphere(center, radius, 0.0)));
    Ok(spec)
}

fn id(method: &str) -> &str {
    method.split(':').next().unwrap_or(method)
}

/// The least time of each method whose runs reach an error, the least first. Of equal times the
/// methods stand in the order of the registry.
fn efforts(rows: &[Row], level: f64) -> Vec<Effort> {
    let mut efforts: Vec<Effort> = Vec::new();
    for method in crate::methods::all() {
        let own = rows.iter().filter(|row| id(&row.method) == method.id);
        efforts.extend(cheapest(own, level).map(|(_, run)| Effort {
            method: method.id.to_owned(),
            seconds: run.modelled_s,
            is_portable: run.portable,
        }));
    }
    efforts.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    efforts
}
