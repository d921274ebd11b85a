//! One method on one scene.

use crate::HarnessError;
use crate::bounds::Bounds;
use crate::cost::Counted;
use crate::methods::Choice;
use crate::record::{Phases, Sample, Totals};
use crate::schedule::Schedule;
use crate::stability::{Energy, Rule, Watch, judge};
use drape_integrator::{
    EnergyLedger, Implicit, Integrator, Phase, PhaseClock, SolveStatus, StepError, StepReport,
    TimeStep,
};
use drape_model::{Numbering, SceneFile, State, System, TimeSpan};
use drape_report::Verdict;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Most samples in a run's series.
const MAX_SAMPLES: u64 = 1000;

/// Why and when a run diverged.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// Step, from 1.
    pub step: u64,
    /// Simulated time after that step, s.
    pub time: f64,
    /// Which criterion was met.
    pub criterion: String,
    /// Whether a program of the user failed. Then the criterion says what it did.
    pub is_outside: bool,
}

/// Result of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Completed steps.
    pub steps: u64,
    /// Sums over all steps.
    pub totals: Totals,
    /// Wall time of all `step` calls together.
    pub wall: Duration,
    /// Steps whose solver stopped before its tolerance.
    pub unconverged: u64,
    /// Steps that took no CG iteration.
    pub idle: u64,
    /// Substeps of all steps, as the methods count them.
    pub substeps: u64,
    /// Substeps that step size control took back.
    pub rejected: u64,
    /// Seconds by phase, if asked for.
    pub phases: Option<Phases>,
    /// Diagnostics over time, if asked for.
    pub series: Vec<Sample>,
    /// Set if the run diverged.
    pub divergence: Option<Divergence>,
    /// Counted cost of the steps, in visits of a spring. It is the same on every machine that takes
    /// the same steps.
    pub effort: f64,
    /// The counts behind it, which have a price for each method.
    pub counted: Counted,
    /// Whether the run ended because its effort or its time reached the limit.
    pub is_over_budget: bool,
}

/// The end of a step, as observers of a run see it.
#[derive(Debug)]
pub struct Moment<'a> {
    /// Number of completed steps.
    pub step: u64,
    /// Length of the step that ended, s.
    pub h: f64,
    /// Work that changes of the system from outside have done since the start, J.
    pub outside_work: f64,
    /// The system.
    pub system: &'a System,
    /// Its state.
    pub state: &'a State,
    /// What the step did to the energy, if asked for and known.
    pub ledger: Option<EnergyLedger>,
    /// What the step reported.
    pub report: &'a StepReport,
    /// Which particle of the system is which of the specification.
    pub numbering: &'a Numbering,
    /// Wall time of all `step` calls so far.
    pub wall: Duration,
    /// Counted work so far, which has a [price](crate::cost) for each method.
    pub counted: Counted,
}

/// A system with its start state, ready to be run.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// The system.
    pub system: System,
    /// Its present state.
    pub state: State,
}

impl Simulation {
    /// A bundled scene by its name, or a scene or frozen system from a file.
    ///
    /// # Errors
    /// [`HarnessError::Scene`] naming the file, the key and what is allowed there.
    pub fn load(scene: &str) -> Result<Self, HarnessError> {
        Self::of(&drape_model::load(scene)?)
    }

    /// A scene or frozen system from text; errors call it `file`.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn parse(file: &str, text: &str) -> Result<Self, HarnessError> {
        Self::of(&drape_model::parse(file, text)?)
    }

    fn of(input: &SceneFile) -> Result<Self, HarnessError> {
        let (system, state) = input.spec().build()?;
        Ok(Self { system, state })
    }
}

/// The message for a refused matrix. Its row may be that of a particle or of a coordinate.
fn refusal(error: &StepError, numbering: &Numbering) -> String {
    if numbering.is_identity() {
        error.to_string()
    } else {
        format!("{error} (rows are counted in the order of the run, which is not that of the file)")
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

fn sample(system: &System, state: &State) -> Sample {
    let kinetic = system.kinetic_energy(&state.v);
    let mut energy_j: std::collections::BTreeMap<String, f64> =
        system.energies(&state.x).map(|(name, energy)| (name.to_owned(), energy)).collect();
    let total = kinetic + energy_j.values().sum::<f64>();
    energy_j.insert("kinetic".to_owned(), kinetic);
    energy_j.insert("total".to_owned(), total);
    Sample {
        time_s: state.t,
        energy_j,
        momentum: system.momentum(state).into(),
        angular_momentum: system.angular_momentum(state).into(),
    }
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

/// Where the integrator comes from.
#[derive(Debug)]
enum Source<'a> {
    Registry(&'a Choice),
    Caller(&'a mut dyn Integrator),
}

/// Says at the end of a step whether the run ends there.
type Stop<'a> = Box<dyn FnMut(&Moment<'_>) -> bool + 'a>;

/// Sees the end of every step.
type Observer<'a> = Box<dyn FnMut(&Moment<'_>) + 'a>;

/// A run to be made: its method, its steps, its budget and its observers.
///
/// ```
/// use drape_harness::{Runner, Simulation, methods::Choice};
/// use drape_model::TimeSpan;
///
/// let mut sheet = Simulation::load("hanging-textile-1e4")?;
/// let method = Choice::parse("imex-euler", &[])?;
/// let time = TimeSpan { step_s: 0.01, duration_s: 0.1 };
/// let mut highest = f64::NEG_INFINITY;
/// let runner = Runner::new(&method, time);
/// let outcome = runner.observe(|moment| highest = highest.max(moment.state.t)).go(&mut sheet)?;
/// assert_eq!((outcome.steps, highest), (10, 0.1));
/// # Ok::<(), drape_harness::HarnessError>(())
/// ```
#[must_use]
pub struct Runner<'a> {
    source: Source<'a>,
    schedule: Schedule,
    series: bool,
    phases: bool,
    ledger: bool,
    budget: Option<f64>,
    reference: Option<f64>,
    numbering: Option<&'a Numbering>,
    stop: Option<Stop<'a>>,
    observers: Vec<Observer<'a>>,
}

impl std::fmt::Debug for Runner<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { source, schedule, .. } = self;
        f.debug_struct("Runner").field("source", source).field("schedule", schedule).finish()
    }
}

impl<'a> Runner<'a> {
    /// A run of a method of the registry with steps of one length.
    pub fn new(choice: &'a Choice, time: TimeSpan) -> Self {
        Self::of(Source::Registry(choice), Schedule::steady(time))
    }

    /// A run of any integrator, for example one that no registry knows.
    pub fn with(integrator: &'a mut dyn Integrator, time: TimeSpan) -> Self {
        Self::of(Source::Caller(integrator), Schedule::steady(time))
    }

    /// A run in which step size and stiffness may change.
    pub(crate) fn by(choice: &'a Choice, schedule: &Schedule) -> Self {
        Self::of(Source::Registry(choice), schedule.clone())
    }

    fn of(source: Source<'a>, schedule: Schedule) -> Self {
        Self {
            source,
            schedule,
            series: false,
            phases: false,
            ledger: false,
            budget: None,
            reference: None,
            numbering: None,
            stop: None,
            observers: Vec::new(),
        }
    }

    /// Records energies and momenta over time.
    pub fn series(self) -> Self {
        Self { series: true, ..self }
    }

    /// Records the seconds of each phase, if `phases`.
    pub fn phases(self, phases: bool) -> Self {
        Self { phases, ..self }
    }

    /// Shows observers what each step did to the energy, cause by cause.
    pub fn ledger(self) -> Self {
        Self { ledger: true, ..self }
    }

    /// Ends the run when its [effort](Outcome::effort) exceeds a limit.
    pub fn budget(self, effort: impl Into<Option<f64>>) -> Self {
        Self { budget: effort.into(), ..self }
    }

    /// Counts the steps that raise the energy by more than round-off, given `E_ref`, J.
    pub(crate) fn reference(self, energy: impl Into<Option<f64>>) -> Self {
        Self { reference: energy.into(), ..self }
    }

    /// The system has an order of its own: messages call a particle by its given index.
    pub(crate) fn numbered(self, numbering: &'a Numbering) -> Self {
        Self { numbering: Some(numbering), ..self }
    }

    /// Ends the run as [over budget](Outcome::is_over_budget) at the end of the first step after
    /// which `stop` says so.
    pub fn stop(self, stop: impl FnMut(&Moment<'_>) -> bool + 'a) -> Self {
        Self { stop: Some(Box::new(stop)), ..self }
    }

    /// Ends the run as [over budget](Outcome::is_over_budget) at the end of the first step after
    /// which the flag is set.
    pub fn stop_at(self, flag: &'a AtomicBool) -> Self {
        self.stop(move |_| flag.load(Ordering::Relaxed))
    }

    /// Adds an observer, which sees the end of every step.
    pub fn observe(mut self, observer: impl FnMut(&Moment<'_>) + 'a) -> Self {
        self.observers.push(Box::new(observer));
        self
    }

    /// Makes the run; the simulation is left in its last state.
    ///
    /// Divergence is a result, not an error: the run stops there and says so. If a series is
    /// recorded, the simulation is left in its last finite state then.
    ///
    /// # Errors
    /// [`HarnessError`] when the time span, the method or the system is refused.
    pub fn go(self, simulation: &mut Simulation) -> Result<Outcome, HarnessError> {
        self.drive(simulation, None)
    }

    /// Makes the run from the start of a simulation, and watches its energy at every step.
    ///
    /// # Errors
    /// As [`go`](Self::go).
    pub fn count(self, simulation: &Simulation) -> Result<Counts, HarnessError> {
        let class = match &self.source {
            Source::Registry(choice) => choice.method().class,
            Source::Caller(integrator) => integrator.method().class,
        };
        let rule = Rule::of(class, &simulation.system);
        let mut watch = Watch::new(simulation, self.schedule.time.duration_s, self.reference);
        let mut simulation = simulation.clone();
        let outcome = self.drive(&mut simulation, Some(&mut watch))?;
        let energy = watch.energy(outcome.divergence.is_some());
        Ok(Counts { outcome, energy, rule, state: simulation.state })
    }

    fn drive(
        self,
        simulation: &mut Simulation,
        mut watch: Option<&mut Watch>,
    ) -> Result<Outcome, HarnessError> {
        let Self { source, schedule, mut observers, mut stop, budget, .. } = self;
        let time = schedule.time;
        time.check("time.step_s", "time.duration_s")?;
        let mut built;
        let integrator = match source {
            Source::Caller(integrator) => integrator,
            Source::Registry(choice) => {
                built = choice.build().map_err(crate::methods::MethodError::from)?;
                built.as_mut()
            }
        };
        let plain = Numbering::identity();
        let numbering = self.numbering.unwrap_or(&plain);
        let Simulation { system, state } = simulation;
        let steps = schedule.steps();
        let begin = Instant::now();
        integrator.prepare(system, TimeStep::new(time.step_s)?)?;
        let prepare_seconds = begin.elapsed().as_secs_f64();
        let mut clock = if self.phases { PhaseClock::on() } else { PhaseClock::off() };
        let bounds = Bounds::of(system, state);
        let every = steps.div_ceil(MAX_SAMPLES).max(1);
        let (particles, springs) = (system.len(), springs(system));
        let mut outcome = Outcome {
            steps: 0,
            totals: Totals::default(),
            wall: Duration::ZERO,
            unconverged: 0,
            idle: 0,
            substeps: 0,
            rejected: 0,
            phases: None,
            series: Vec::new(),
            divergence: None,
            effort: 0.0,
            counted: Counted::default(),
            is_over_budget: false,
        };
        if self.series {
            outcome.series.push(sample(system, state));
        }
        let start = state.t;
        let mut changed = 0;
        let mut outside_work = 0.0;
        let mut last_finite = self.series.then(|| state.clone());
        let mut before = self.ledger.then(|| state.clone());
        for step in 1..=steps {
            let due = schedule.due(state.t - start);
            for change in &schedule.changes[changed..due] {
                outside_work += change.apply(system, &state.x);
            }
            changed = due;
            let h = TimeStep::new(schedule.step(step))?;
            if let Some(before) = &mut before {
                before.copy_from(state);
            }
            let begin = Instant::now();
            let report = match integrator.step(system, state, h, &mut clock) {
                Ok(report) => report,
                // Blow-up is a result: no matrix can be set up from such numbers.
                Err(error @ StepError::Solver(_)) => {
                    let criterion = refusal(&error, numbering);
                    let (time, is_outside) = (state.t, false);
                    outcome.divergence = Some(Divergence { step, time, criterion, is_outside });
                    break;
                }
                // The run ends, and what was recorded until then is kept.
                Err(StepError::Outside(criterion)) => {
                    let (time, is_outside) = (state.t, true);
                    outcome.divergence = Some(Divergence { step, time, criterion, is_outside });
                    break;
                }
                // A step of more substeps than the method takes would exceed any budget.
                Err(StepError::TooManySubsteps { .. }) if budget.is_some() => {
                    outcome.is_over_budget = true;
                    break;
                }
                Err(error) => return Err(error.into()),
            };
            outcome.wall += begin.elapsed();
            state.t = start + schedule.elapsed(step);
            outcome.steps = step;
            add(&mut outcome.totals, &report);
            outcome.counted = Counted::of(&outcome.totals, step, particles, springs);
            outcome.effort = outcome.counted.visits();
            outcome.substeps += u64::from(report.substeps);
            outcome.rejected += u64::from(report.rejected);
            outcome.idle += u64::from(report.cg_iterations == 0);
            outcome.unconverged += u64::from(report.solve != SolveStatus::Converged);
            let divergence = bounds.violation(state, numbering);
            if self.series && (step % every == 0 || step == steps) {
                outcome.series.extend(Some(sample(system, state)).filter(is_finite));
            }
            let ledger =
                before.as_ref().and_then(|before| integrator.ledger(system, before, state, h));
            let (h, report) = (h.seconds(), &report);
            let (wall, counted) = (outcome.wall, outcome.counted);
            let moment = Moment {
                step,
                h,
                outside_work,
                system,
                state,
                report,
                ledger,
                numbering,
                wall,
                counted,
            };
            if let Some(watch) = &mut watch {
                watch.look(schedule.elapsed(step), &moment);
            }
            observers.iter_mut().for_each(|observe| observe(&moment));
            let is_stopped = stop.as_mut().is_some_and(|stop| stop(&moment));
            let time = state.t;
            if let Some(last) = &mut last_finite {
                // JSON knows no infinity: keep the last state that can be read again.
                if state.is_finite() { last.copy_from(state) } else { state.copy_from(last) }
            }
            if let Some(criterion) = divergence {
                let is_outside = false;
                outcome.divergence = Some(Divergence { step, time, criterion, is_outside });
                break;
            }
            let is_spent = is_stopped || budget.is_some_and(|limit| outcome.effort > limit);
            if step < steps && is_spent {
                outcome.is_over_budget = true;
                break;
            }
        }
        outcome.totals.seconds = outcome.wall.as_secs_f64();
        outcome.totals.prepare_seconds = prepare_seconds;
        outcome.phases = self.phases.then(|| Phases {
            forces: clock.seconds(Phase::Forces),
            matrix_setup: clock.seconds(Phase::MatrixSetup),
            solve: clock.seconds(Phase::Solve),
            contact: clock.seconds(Phase::Contact),
            update: clock.seconds(Phase::Update),
        });
        Ok(outcome)
    }
}

/// A run without its history: counts and energy.
#[derive(Clone, Debug)]
pub struct Counts {
    /// Result of the run.
    pub outcome: Outcome,
    /// What its energy did.
    pub energy: Energy,
    /// The rule by which its energy is judged.
    pub rule: Rule,
    /// Last state.
    pub state: State,
}

impl Counts {
    /// How the run ended, by its energy beside the energy that the scene sets free, J
    /// ([`reference_energy`](crate::reference_energy)).
    pub fn verdict(&self, reference_energy: f64) -> Verdict {
        match &self.outcome.divergence {
            Some(_) => Verdict::Diverged,
            None => judge(&self.energy, self.rule, reference_energy),
        }
    }
}
