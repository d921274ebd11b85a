//! One method on one scene.

mod progress;
pub(crate) mod starts;

use crate::HarnessError;
use crate::cost::Counted;
use crate::methods::Choice;
use crate::record::{Phases, Sample, Totals};
use crate::schedule::Schedule;
use crate::stability::{Energy, Rule, Watch, judge};
use drape_integrator::{EnergyLedger, Integrator, StepReport};
use drape_model::{Numbering, SceneFile, State, System, TimeSpan};
use drape_report::Verdict;
use progress::Plan;
pub(crate) use progress::Progress;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Why and when a run diverged.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// Step, from 1.
    pub step: u64,
    /// Simulated time after that step, s.
    pub time: f64,
    /// Which criterion was met.
    pub criterion: String,
    /// Whether a program of the user failed. Then the criterion says how.
    pub is_outside: bool,
}

/// Result of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Completed steps.
    pub steps: u64,
    /// Sums over all steps.
    pub totals: Totals,
    /// Wall time of all `step` calls together.
    pub wall: Duration,
    /// Time that the calling thread spent on a processor in all `step` calls; `None` unless it was
    /// asked for and the operating system reports it.
    pub(crate) processor: Option<Duration>,
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
    /// The counts behind the effort, which have a price for each method.
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
    /// Simulated time since the start of the run, s.
    pub(crate) elapsed: f64,
    /// Work that changes of the system from outside have done since the start, J.
    pub outside_work: f64,
    /// The system.
    pub system: &'a System,
    /// Its state.
    pub state: &'a State,
    /// Total energy, J, if the series has a sample of this step.
    pub(crate) total_j: Option<f64>,
    /// The change of the energy in the step by its causes, if asked for and known.
    pub ledger: Option<EnergyLedger>,
    /// The report of the step.
    pub report: &'a StepReport,
    /// The correspondence between the particles of the system and those of the specification.
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
    /// [`HarnessError::Scene`], which names the file, the key and the values that are allowed
    /// there.
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

/// Where the integrator comes from.
#[derive(Debug)]
enum Source<'a> {
    Registry(&'a Choice),
    Caller(&'a mut dyn Integrator),
}

/// Decides at the end of a step whether the run ends there.
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
    has_processor: bool,
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

    /// A run of any integrator, for example one outside the registry.
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
            has_processor: false,
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

    /// Measures the time on the processor, besides the wall time.
    pub(crate) fn processor(self) -> Self {
        Self { has_processor: true, ..self }
    }

    /// Shows observers the change of the energy in each step, cause by cause.
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

    /// The system may have another order than the specification. Messages then name a particle by
    /// its index in the specification.
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
    /// Divergence is a result, not an error: the run stops, and [`Outcome::divergence`] says so. If
    /// a series is recorded, the simulation is then left in its last finite state.
    ///
    /// # Errors
    /// [`HarnessError`] when the time span, the method or the system is refused.
    pub fn go(self, simulation: &mut Simulation) -> Result<Outcome, HarnessError> {
        self.drive(simulation, None)
    }

    /// Prepares the run, which is then taken step by step, without observers.
    pub(crate) fn begin(
        self,
        simulation: &mut Simulation,
        integrator: &mut dyn Integrator,
    ) -> Result<Progress, HarnessError> {
        Progress::new(Plan::of(&self)?, integrator, simulation)
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
        mut self,
        simulation: &mut Simulation,
        mut watch: Option<&mut Watch>,
    ) -> Result<Outcome, HarnessError> {
        let mut observers = std::mem::take(&mut self.observers);
        let mut stop = self.stop.take();
        let plain = Numbering::identity();
        let numbering = self.numbering.unwrap_or(&plain);
        let plan = Plan::of(&self)?;
        let mut built;
        let integrator = match self.source {
            Source::Caller(integrator) => integrator,
            Source::Registry(choice) => {
                built = choice.build().map_err(crate::methods::MethodError::from)?;
                built.as_mut()
            }
        };
        let mut look = |moment: &Moment<'_>| {
            if let Some(watch) = &mut watch {
                watch.look(moment);
            }
            observers.iter_mut().for_each(|observe| observe(moment));
            stop.as_mut().is_some_and(|stop| stop(moment))
        };
        let mut progress = Progress::new(plan, integrator, simulation)?;
        while progress.step(integrator, simulation, numbering, &mut look)? {}
        Ok(progress.end())
    }
}

/// A run without its history: counts and energy.
#[derive(Clone, Debug)]
pub struct Counts {
    /// Result of the run.
    pub outcome: Outcome,
    /// The changes of its energy.
    pub energy: Energy,
    /// The rule by which its energy is judged.
    pub rule: Rule,
    /// Last state.
    pub state: State,
}

impl Outcome {
    /// Time on the processor in all `step` calls, s, if it was measured, else their wall time, s.
    pub(crate) fn seconds(&self) -> f64 {
        self.processor.unwrap_or(self.wall).as_secs_f64()
    }
}

impl Counts {
    /// The verdict on the run, from its energy and the energy that the scene sets free, J
    /// ([`reference_energy`](crate::reference_energy)).
    pub fn verdict(&self, reference_energy: f64) -> Verdict {
        match &self.outcome.divergence {
            Some(_) => Verdict::Diverged,
            None => judge(&self.energy, self.rule, reference_energy),
        }
    }
}
