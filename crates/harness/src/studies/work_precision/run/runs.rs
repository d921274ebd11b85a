//! Runs of one method on one scene, from coarse to fine, within a budget of counted effort.

use super::scenes::{SPAN, Setting};
use super::variants::{DOP853, Knob, Variant, is_limited_by_stiffness};
use crate::HarnessError;
use crate::cost::{Counted, prices};
use crate::film::Seen;
use crate::methods::{self, Choice};
use crate::run::{Outcome, Runner, Simulation};
use crate::studies::work_precision::facts::{Beside, FEWEST, Flaw, PICTURE_S, Row, Run};
use drape_model::{State, TimeSpan};
use drape_oracle::adaptive::{AdaptiveError, AdaptiveSettings, Pair, adaptive};
use drape_report::Verdict;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Largest number of steps of any run.
const MOST: u32 = 1 << 20;
/// Number of steps asked of a method with another knob: each step is about a frame of a film.
const FRAMES: u32 = 16;
/// A run has diverged if its error exceeds twice the true motion. A sheet that stands still has an
/// error of 1: it is wrong, but has not diverged.
const LOST: f64 = 2.0;
/// Bounds on the growth of effort from one run to the next finer one. The effort grows at least by
/// this factor, and by at least [`SAME_GROWTH`] times its last growth.
const LEAST_GROWTH: f64 = 1.4;
const SAME_GROWTH: f64 = 0.9;
/// Evaluations of the forces in a step of DOP853.
const STAGES: f64 = 12.0;
/// Work of combining the stages of a DOP853 step and of estimating its error, in visits of a spring
/// per particle.
const COMBINING: f64 = 45.0;

/// Lower bound on the effort of the next, finer run.
fn expected(runs: &[Run]) -> f64 {
    let Some(last) = runs.last() else { return 0.0 };
    let before =
        runs.len().checked_sub(2).map(|n| &runs[n]).filter(|run| run.verdict == Verdict::Completed);
    let growth = before.map_or(1.0, |before| last.effort / before.effort);
    last.effort * LEAST_GROWTH.max(SAME_GROWTH * growth.min(2.0))
}

/// The runs whose work tells what finer runs will take: those with at least [`FEWEST`] steps.
fn usual<'a>(variant: &Variant, runs: &'a [Run]) -> &'a [Run] {
    let is_usual = |run: &Run| variant.knob != Knob::Steps || run.value >= f64::from(FEWEST);
    let first = runs.iter().position(is_usual).unwrap_or(runs.len());
    &runs[first..]
}

/// Whether an explicit method is stable at any step.
fn is_stabilised(id: &str) -> bool {
    methods::theory_of(id).is_some_and(|theory| !theory.is_limited)
}

/// A run with the time it took.
pub(super) struct Timed {
    pub(super) run: Run,
    pub(super) nanoseconds: u64,
}

/// Runs on one scene, each with its budget in visits of a spring, by their form and the value of its
/// knob.
#[derive(Debug, Default)]
pub(in crate::studies) struct KeptRuns(Mutex<HashMap<Which, Vec<(f64, Run)>>>);

/// The label of a form, and the bits of the value of its knob.
type Which = (&'static str, u64);

impl KeptRuns {
    /// The run that this budget would give: one that fits it, or one that had the same budget.
    fn get(&self, variant: &Variant, value: f64, budget: f64) -> Option<Run> {
        let fits = |run: &Run| run.verdict != Verdict::OverBudget && run.effort <= budget;
        let runs = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let of_value = runs.get(&(variant.label, value.to_bits()))?;
        let same = |(limit, run): &&(f64, Run)| fits(run) || limit.to_bits() == budget.to_bits();
        of_value.iter().find(same).map(|(_, run)| run.clone())
    }

    fn put(&self, variant: &Variant, value: f64, budget: f64, run: &Run) {
        let mut runs = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        runs.entry((variant.label, value.to_bits())).or_default().push((budget, run.clone()));
    }
}

impl Setting {
    /// All runs of a variant, coarsest first. They end when the error of a run without a flaw is
    /// small enough or the budget is spent, and before a run that is expected to take more than
    /// `limit` visits of a spring. A run of fewer than [`FEWEST`] steps ends no row.
    pub(in crate::studies) fn row(
        &self,
        variant: &Variant,
        limit: Option<f64>,
    ) -> Result<Row, HarnessError> {
        self.row_after(Vec::new(), variant, limit)
    }

    /// As [`row`](Self::row), from the run on that ended a row over a smaller budget.
    pub(in crate::studies) fn row_after(
        &self,
        mut runs: Vec<Run>,
        variant: &Variant,
        limit: Option<f64>,
    ) -> Result<Row, HarnessError> {
        let over = runs.iter().position(|run| run.verdict == Verdict::OverBudget);
        runs.truncate(over.unwrap_or(runs.len()));
        for value in self.values(variant).into_iter().skip(runs.len()) {
            // In a very long step a solver may take more work than in several shorter ones.
            let is_long = variant.knob == Knob::Steps && value < f64::from(FEWEST);
            // A run that is not expected to fit its budget is recorded, but not begun.
            let expected = if is_long { 0.0 } else { expected(usual(variant, &runs)) };
            if limit.is_some_and(|limit| expected > limit) {
                break;
            }
            let run = if expected > self.budget(variant) {
                self.not_begun(variant, value)?
            } else {
                self.run_once(variant, value)?
            };
            let is_enough =
                run.flaw.is_none() && run.error.is_some_and(|error| error < self.enough);
            let is_last = (run.verdict == Verdict::OverBudget && !is_long) || is_enough;
            runs.push(run);
            if is_last {
                break;
            }
        }
        Ok(Row {
            scene: self.scene.id.clone(),
            label: variant.label.to_owned(),
            method: variant.method.to_owned(),
            knob: variant.knob_name().to_owned(),
            is_headline: variant.is_headline(),
            runs,
        })
    }

    /// Values of the knob, coarsest first.
    fn values(&self, variant: &Variant) -> Vec<f64> {
        match variant.knob {
            Knob::Setting(_, values) | Knob::Tolerance(values) => values.to_vec(),
            Knob::Steps => {
                let id = variant.method.split(':').next().unwrap_or(variant.method);
                let is_limited = is_limited_by_stiffness(variant.method)
                    && !(self.stabilised_begin_coarse && is_stabilised(id));
                let first = if is_limited {
                    // The largest power of two with unstable steps, judged by the fastest undamped
                    // oscillation.
                    let limit = 0.5 * SPAN * self.scene.greatest_frequency_per_s;
                    ((limit as u32 + 1).next_power_of_two() / 2).max(self.fewest)
                } else {
                    self.fewest
                };
                let doubled = std::iter::successors(Some(first), |steps| Some(2 * steps));
                doubled.take_while(|steps| *steps <= MOST).map(f64::from).collect()
            }
        }
    }

    /// Makes one run, or takes over what another row has kept.
    fn run_once(&self, variant: &Variant, value: f64) -> Result<Run, HarnessError> {
        // DOP853 ends by its steps, not by the visits of a budget.
        let kept = self.kept.as_ref().filter(|_| !matches!(variant.knob, Knob::Tolerance(_)));
        let budget = self.budget(variant);
        if let Some(run) = kept.and_then(|kept| kept.get(variant, value, budget)) {
            return Ok(run);
        }
        let run = self.run(variant, value)?.run;
        if let Some(kept) = kept {
            kept.put(variant, value, budget, &run);
        }
        Ok(run)
    }

    /// Makes one run and takes its time.
    pub(super) fn run(&self, variant: &Variant, value: f64) -> Result<Timed, HarnessError> {
        match variant.choice(value)? {
            Some(choice) => self.integrate(variant, &choice, value),
            None => self.adapt(value, self.budget(variant)),
        }
    }

    /// The visits after which a run is over its budget.
    fn budget(&self, variant: &Variant) -> f64 {
        self.case.budget.min(prices().of(variant.method).visits_within(self.most_s))
    }

    fn steps(variant: &Variant, value: f64) -> f64 {
        if variant.knob == Knob::Steps { value } else { f64::from(FRAMES) }
    }

    fn not_begun(&self, variant: &Variant, value: f64) -> Result<Run, HarnessError> {
        let choice = variant.choice(value)?;
        let step_s = choice.as_ref().map(|_| SPAN / Self::steps(variant, value));
        let portable = choice.is_some_and(|choice| choice.is_portable());
        Ok(Run { portable, ..Run::uncounted(value, step_s, Verdict::OverBudget) })
    }

    fn integrate(
        &self,
        variant: &Variant,
        choice: &Choice,
        value: f64,
    ) -> Result<Timed, HarnessError> {
        let time = TimeSpan { step_s: SPAN / Self::steps(variant, value), duration_s: SPAN };
        let mut simulation = self.simulation.clone();
        let runner = Runner::new(choice, time).budget(self.budget(variant));
        let (outcome, seen) = match &self.truth {
            Some(truth) => truth.watch(runner, &mut simulation, Self::steps(variant, value))?,
            None => (runner.go(&mut simulation)?, Seen::default()),
        };
        let Outcome { totals, unconverged, effort, counted, divergence, is_over_budget, .. } =
            outcome;
        let (verdict, error) = if is_over_budget {
            (Verdict::OverBudget, None)
        } else if divergence.is_some() {
            (Verdict::Diverged, None)
        } else {
            judge(self.error(&simulation.state.x))
        };
        let watched = self.truth.as_ref().filter(|_| error.is_some());
        let beside = watched.map(|truth| truth.beside(&simulation, &seen));
        let seconds = totals.seconds + totals.prepare_seconds;
        let run = Run {
            value,
            step_s: Some(time.step_s),
            verdict,
            error,
            beside,
            flaw: self.flaw(beside).or((time.step_s > PICTURE_S).then_some(Flaw::SkipsPictures)),
            modelled_s: counted.seconds(prices().of(variant.method)),
            effort,
            steps: counted.steps,
            force_evaluations: totals.force_evaluations,
            matvecs: totals.matvecs,
            factorisations: totals.factorisations,
            setups: totals.setups,
            cg_iterations: totals.cg_iterations,
            unconverged_steps: unconverged,
            is_on_front: false,
            portable: choice.is_portable(),
        };
        Ok(Timed { run, nanoseconds: (1e9 * seconds) as u64 })
    }

    fn flaw(&self, beside: Option<Beside>) -> Option<Flaw> {
        self.truth.as_ref()?.flaw(&beside?)
    }

    /// The other errors of DOP853, where it ends in this state.
    fn beside(&self, end: State, tolerance: f64) -> Option<Beside> {
        let truth = self.truth.as_ref()?;
        let seen = truth.film(&self.simulation, tolerance)?;
        let end = Simulation { system: self.simulation.system.clone(), state: end };
        Some(truth.beside(&end, &seen))
    }

    /// A run of DOP853.
    fn adapt(&self, tolerance: f64, budget: f64) -> Result<Timed, HarnessError> {
        let particles = self.scene.particles as f64;
        let sweep = self.scene.springs as f64 + particles;
        let max_steps = (budget / (STAGES * sweep + COMBINING * particles)) as u32;
        let settings = AdaptiveSettings { tolerance, max_steps };
        let begin = Instant::now();
        let Simulation { system, state } = &self.simulation;
        let result = adaptive(Pair::Dop853, system, state, SPAN, settings);
        let nanoseconds = begin.elapsed().as_nanos() as u64;
        let mut beside = None;
        let (verdict, error, steps, evaluations) = match result {
            Ok(run) => {
                let (verdict, error) = judge(self.error(&run.state.x));
                beside = error.and_then(|_| self.beside(run.state, tolerance));
                (verdict, error, run.steps, run.evaluations)
            }
            Err(AdaptiveError::StepLimit { steps, .. }) => {
                (Verdict::OverBudget, None, steps, STAGES as u64 * u64::from(steps))
            }
            Err(AdaptiveError::NotFinite { .. }) => (Verdict::Diverged, None, 0, 0),
            Err(error) => return Err(error.into()),
        };
        let counted = Counted {
            steps: u64::from(steps),
            force_evaluations: evaluations,
            particles: self.scene.particles,
            springs: self.scene.springs,
            ..Counted::default()
        };
        let run = Run {
            error,
            beside,
            flaw: self.flaw(beside),
            modelled_s: counted.seconds(prices().of(DOP853)),
            steps: u64::from(steps),
            effort: evaluations as f64 * sweep + f64::from(steps) * COMBINING * particles,
            force_evaluations: evaluations,
            portable: false,
            ..Run::uncounted(tolerance, None, verdict)
        };
        Ok(Timed { run, nanoseconds })
    }
}

fn judge(error: f64) -> (Verdict, Option<f64>) {
    let error = Some(error).filter(|error| *error < LOST);
    (if error.is_some() { Verdict::Completed } else { Verdict::Diverged }, error)
}
