//! A run between two steps.

use super::{Divergence, Moment, Outcome, Runner, Simulation};
use crate::HarnessError;
use crate::bounds::Bounds;
use crate::cost::Counted;
use crate::processor;
use crate::record::{Phases, Sample, Totals};
use crate::schedule::Schedule;
use drape_integrator::{
    Implicit, Integrator, Phase, PhaseClock, SolveStatus, StepError, StepReport, TimeStep,
};
use drape_model::{Numbering, State, System};
use std::collections::BTreeMap;
use std::time::Instant;

/// Most samples in a run's series.
const MAX_SAMPLES: u64 = 1000;

/// The message for a refused matrix. The row that it names may belong to a particle or to a
/// coordinate.
fn refusal(error: &StepError, numbering: &Numbering) -> String {
    if numbering.is_identity() {
        error.to_string()
    } else {
        format!("{error} (rows are counted in the order of the run, which is not that of the file)")
    }
}

impl Outcome {
    /// Adds the report of a step of a system with so many particles and springs.
    fn count(&mut self, step: u64, report: &StepReport, (particles, springs): (usize, usize)) {
        add(&mut self.totals, report);
        self.steps = step;
        self.counted = Counted::of(&self.totals, step, particles, springs);
        self.effort = self.counted.visits();
        self.substeps += u64::from(report.substeps);
        self.rejected += u64::from(report.rejected);
        self.idle += u64::from(report.cg_iterations == 0);
        self.unconverged += u64::from(report.solve != SolveStatus::Converged);
    }
}

fn add(totals: &mut Totals, report: &StepReport) {
    totals.cg_iterations += u64::from(report.cg_iterations);
    totals.outer_passes += u64::from(report.outer_passes);
    totals.newton_iterations += u64::from(report.newton_iterations);
    totals.factorisations += u64::from(report.factorisations);
    totals.setups += u64::from(report.setups.total());
    totals.matvecs += u64::from(report.matvecs);
    totals.force_evaluations += u64::from(report.force_evaluations);
}

/// A sample, and the total energy with the bits of [`System::total_energy`], J. The sample sums the
/// energies by name.
fn sample(system: &System, state: &State) -> (Sample, f64) {
    let energies = || system.energies(&state.x).collect::<Vec<_>>();
    let others = || {
        let momenta = [system.momentum(state), system.angular_momentum(state)];
        (system.kinetic_energy(&state.v), momenta)
    };
    let (energies, (kinetic, [momentum, angular_momentum])) =
        if system.has_helpers() { rayon::join(energies, others) } else { (energies(), others()) };
    let total_j = kinetic + energies.iter().map(|(_, energy)| energy).sum::<f64>();
    let named = energies.into_iter().map(|(name, energy)| (name.to_owned(), energy));
    let mut energy_j: BTreeMap<String, f64> = named.collect();
    let total = kinetic + energy_j.values().sum::<f64>();
    energy_j.insert("kinetic".to_owned(), kinetic);
    energy_j.insert("total".to_owned(), total);
    let sample = Sample {
        time_s: state.t,
        energy_j,
        momentum: momentum.into(),
        angular_momentum: angular_momentum.into(),
    };
    (sample, total_j)
}

fn is_finite(sample: &Sample) -> bool {
    let momenta = sample.momentum.iter().chain(&sample.angular_momentum);
    sample.energy_j.values().chain(momenta).all(|value| value.is_finite())
}

/// Number of springs.
fn springs(system: &System) -> usize {
    let mut springs = 0;
    Implicit::Springs.visit_weights(system, &mut |_, _, _, _| springs += 1);
    springs
}

/// The plan of a run, checked.
#[derive(Debug)]
pub(super) struct Plan {
    schedule: Schedule,
    series: bool,
    phases: bool,
    has_processor: bool,
    ledger: bool,
    budget: Option<f64>,
}

impl Plan {
    pub(super) fn of(runner: &Runner<'_>) -> Result<Self, HarnessError> {
        let Runner { schedule, series, phases, has_processor, ledger, budget, .. } = runner;
        schedule.time.check("time.step_s", "time.duration_s")?;
        let (series, phases, ledger, budget) = (*series, *phases, *ledger, *budget);
        let (schedule, has_processor) = (schedule.clone(), *has_processor);
        Ok(Self { schedule, series, phases, has_processor, ledger, budget })
    }
}

/// A run that was begun. Its simulation and its integrator are always those that it began with.
#[derive(Debug)]
pub(crate) struct Progress {
    schedule: Schedule,
    budget: Option<f64>,
    /// Steps of the whole run.
    steps: u64,
    /// Time at its start, s.
    start: f64,
    /// Number of changes of the schedule that were made.
    changed: usize,
    outside_work: f64,
    clock: PhaseClock,
    has_phases: bool,
    has_processor: bool,
    bounds: Bounds,
    /// Steps between two samples of the series.
    every: u64,
    /// Particles and springs.
    size: (usize, usize),
    /// The state before the step, for the ledger.
    before: Option<State>,
    /// The last finite state. It is kept where a series is recorded, since JSON has no infinity.
    last_finite: Option<State>,
    outcome: Outcome,
    is_over: bool,
}

impl Progress {
    pub(super) fn new(
        plan: Plan,
        integrator: &mut dyn Integrator,
        simulation: &mut Simulation,
    ) -> Result<Self, HarnessError> {
        super::starts::starts_from(simulation);
        let Plan { schedule, series, phases, has_processor, ledger, budget } = plan;
        let Simulation { system, state } = simulation;
        let steps = schedule.steps();
        let begin = Instant::now();
        integrator.prepare(system, TimeStep::new(schedule.time.step_s)?)?;
        let mut outcome = Outcome::default();
        outcome.totals.prepare_seconds = begin.elapsed().as_secs_f64();
        if series {
            outcome.series.push(sample(system, state).0);
        }
        Ok(Self {
            schedule,
            budget,
            steps,
            start: state.t,
            changed: 0,
            outside_work: 0.0,
            clock: if phases { PhaseClock::on() } else { PhaseClock::off() },
            has_phases: phases,
            has_processor,
            bounds: Bounds::of(system, state),
            every: steps.div_ceil(MAX_SAMPLES).max(1),
            size: (system.len(), springs(system)),
            before: ledger.then(|| state.clone()),
            last_finite: series.then(|| state.clone()),
            outcome,
            is_over: steps == 0,
        })
    }

    /// Takes a step and shows its end to `look`, which decides whether the run ends there. Returns
    /// whether another step follows.
    ///
    /// # Errors
    /// As [`Runner::go`]. No step follows then.
    pub(crate) fn step(
        &mut self,
        integrator: &mut dyn Integrator,
        simulation: &mut Simulation,
        numbering: &Numbering,
        look: &mut dyn FnMut(&Moment<'_>) -> bool,
    ) -> Result<bool, HarnessError> {
        if std::mem::replace(&mut self.is_over, true) {
            return Ok(false);
        }
        let Simulation { system, state } = simulation;
        let step = self.outcome.steps + 1;
        self.change(system, state);
        let h = TimeStep::new(self.schedule.step(step))?;
        if let Some(before) = &mut self.before {
            before.copy_from(state);
        }
        let spent = self.has_processor.then(processor::spent).flatten();
        let begin = Instant::now();
        let report = match integrator.step(system, state, h, &mut self.clock) {
            Ok(report) => report,
            Err(error) => return self.fail(step, state.t, error, numbering).map(|()| false),
        };
        self.outcome.wall += begin.elapsed();
        if let Some((before, now)) = spent.zip(processor::spent()) {
            *self.outcome.processor.get_or_insert_default() += now.saturating_sub(before);
        }
        let elapsed = self.schedule.elapsed(step);
        state.t = self.start + elapsed;
        self.outcome.count(step, &report, self.size);
        let violation = self.bounds.violation(state, numbering);
        let is_sampled = step.is_multiple_of(self.every) || step == self.steps;
        let sample = (self.last_finite.is_some() && is_sampled).then(|| sample(system, state));
        let sample = sample.filter(|(sample, _)| is_finite(sample));
        let total_j = sample.as_ref().map(|(_, total_j)| *total_j);
        self.outcome.series.extend(sample.map(|(sample, _)| sample));
        let before = self.before.as_ref();
        let ledger = before.and_then(|before| integrator.ledger(system, before, state, h));
        let is_stopped = look(&Moment {
            step,
            h: h.seconds(),
            elapsed,
            outside_work: self.outside_work,
            system,
            state,
            total_j,
            ledger,
            report: &report,
            numbering,
            wall: self.outcome.wall,
            counted: self.outcome.counted,
        });
        let time = state.t;
        if let Some(last) = &mut self.last_finite {
            // A state within the bounds is finite.
            let is_sound = violation.is_none() || state.is_finite();
            if is_sound { last.copy_from(state) } else { state.copy_from(last) }
        }
        if let Some(criterion) = violation {
            let is_outside = false;
            self.outcome.divergence = Some(Divergence { step, time, criterion, is_outside });
            return Ok(false);
        }
        let is_spent = is_stopped || self.budget.is_some_and(|limit| self.outcome.effort > limit);
        let is_last = step >= self.steps;
        self.outcome.is_over_budget = is_spent && !is_last;
        self.is_over = is_spent || is_last;
        Ok(!self.is_over)
    }

    /// Makes the changes of the schedule that are due.
    fn change(&mut self, system: &mut System, state: &State) {
        let due = self.schedule.due(state.t - self.start);
        for change in &self.schedule.changes[self.changed..due] {
            self.outside_work += change.apply(system, &state.x);
        }
        self.changed = due;
    }

    /// Handles a step that could not be taken, which is a result or an error.
    fn fail(
        &mut self,
        step: u64,
        time: f64,
        error: StepError,
        numbering: &Numbering,
    ) -> Result<(), HarnessError> {
        let (criterion, is_outside) = match error {
            // A blow-up is a result: the matrix of such numbers cannot be set up.
            StepError::Solver(_) => (refusal(&error, numbering), false),
            // The run ends and keeps its records.
            StepError::Outside(criterion) => (criterion, true),
            // A step of more substeps than the method takes would exceed any budget.
            StepError::TooManySubsteps { .. } if self.budget.is_some() => {
                self.outcome.is_over_budget = true;
                return Ok(());
            }
            _ => return Err(error.into()),
        };
        self.outcome.divergence = Some(Divergence { step, time, criterion, is_outside });
        Ok(())
    }

    /// The outcome of the steps.
    pub(crate) fn end(self) -> Outcome {
        let Self { mut outcome, clock, has_phases, .. } = self;
        outcome.totals.seconds = outcome.wall.as_secs_f64();
        outcome.phases = has_phases.then(|| Phases {
            forces: clock.seconds(Phase::Forces),
            matrix_setup: clock.seconds(Phase::MatrixSetup),
            solve: clock.seconds(Phase::Solve),
            contact: clock.seconds(Phase::Contact),
            update: clock.seconds(Phase::Update),
        });
        outcome
    }
}
