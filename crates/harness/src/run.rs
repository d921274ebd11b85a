//! One method on one scene.

use crate::HarnessError;
use crate::methods::Choice;
use crate::record::{Phases, Sample, Totals};
use crate::schedule::Schedule;
use crate::stability::{Energy, Rule, Verdict, Watch, judge};
use drape_integrator::{
    EnergyLedger, Implicit, Integrator, Phase, PhaseClock, SolveStatus, StepError, StepReport,
    TimeStep,
};
use drape_model::{Numbering, SceneFile, State, System, TimeSpan, Vec3};
use std::time::{Duration, Instant};

/// A position farther from the centre of the start than this many scene sizes counts as diverged.
const FAR: f64 = 1e3;
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
}

/// What a run should record.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Energies and momenta over time.
    pub series: bool,
    /// Seconds by phase.
    pub phases: bool,
    /// What each step did to the energy, cause by cause.
    pub ledger: bool,
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
    /// What the steps cost, in visits of a spring (some 5 ns each): counted, not timed, so that it is the same on
    /// every machine that takes the same steps.
    pub effort: f64,
    /// Whether the run ended because its effort reached the limit.
    pub is_over_budget: bool,
}

/// One moment of a run: the end of a step.
pub(crate) struct Moment<'a> {
    /// Number of completed steps.
    pub(crate) step: u64,
    /// Length of the step that ended, s.
    pub(crate) h: f64,
    /// Work that changes of the system from outside have done since the start, J.
    pub(crate) outside_work: f64,
    /// The system.
    pub(crate) system: &'a System,
    /// Its state.
    pub(crate) state: &'a State,
    /// What the step did to the energy, if asked for and known.
    pub(crate) ledger: Option<EnergyLedger>,
    /// What the step reported.
    pub(crate) report: &'a StepReport,
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

/// Extent of a scene, for the test of divergence.
struct Bounds {
    center: Vec3,
    reach: f64,
}

impl Bounds {
    fn of(x: &[Vec3]) -> Self {
        let mut low = x[0];
        let mut high = x[0];
        for x in x {
            low = low.inf(x);
            high = high.sup(x);
        }
        let size = (high - low).norm();
        // A single particle, or all in one place: there is no size, so a metre is taken.
        let size = if size > 0.0 { size } else { 1.0 };
        Self { center: (low + high) * 0.5, reach: FAR * size }
    }

    fn violation(&self, state: &State, numbering: &Numbering) -> Option<String> {
        if !state.is_finite() {
            return Some("a position or velocity is not finite".to_owned());
        }
        let outside = |x: &Vec3| (x - self.center).norm() > self.reach;
        let particles = state.x.iter().enumerate().filter(|(_, x)| outside(x));
        particles.map(|(particle, _)| numbering.given(particle)).min().map(|particle| {
            format!(
                "particle {particle} is farther than {:.3e} m (1000 scene sizes) from the centre of the start",
                self.reach
            )
        })
    }
}

/// What a refused matrix is called. It names a row, which may be that of a particle or of a coordinate.
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

/// What the steps of a run cost, in visits of a spring: sweeps over the springs and products with the matrix by their
/// length, factorisations by the fill-in of a planar mesh (`n^1.5`; Newton's matrix has 3×3 blocks).
fn effort(totals: &Totals, steps: u64, particles: f64, springs: f64) -> f64 {
    let planar = particles * particles.sqrt();
    totals.force_evaluations as f64 * (springs + particles)
        + totals.matvecs as f64 * 2.0 * (springs + particles)
        + totals.factorisations as f64 * 80.0 * planar
        + totals.setups as f64 * 8.0 * planar
        + steps as f64 * 4.0 * particles
}

/// Number of springs.
fn springs(system: &System) -> usize {
    let mut springs = 0;
    Implicit::Springs.visit_weights(system, &mut |_, _, _, _| springs += 1);
    springs
}

/// Runs a method over a time span; `observe` is called after each step with the number of completed
/// steps.
///
/// Divergence is a result, not an error: the run stops there and says so. If a series is recorded, the
/// simulation is left in its last finite state then.
///
/// # Errors
/// [`HarnessError`] when the time span, the method or the system is refused.
pub fn simulate(
    simulation: &mut Simulation,
    choice: &Choice,
    time: TimeSpan,
    options: Options,
    mut observe: impl FnMut(u64, &System, &State),
) -> Result<Outcome, HarnessError> {
    drive(simulation, choice, &Schedule::steady(time), options, None, |moment| {
        observe(moment.step, moment.system, moment.state);
    })
}

/// As [`simulate`] with any integrator, for example one that no registry knows.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_with(
    simulation: &mut Simulation,
    integrator: &mut dyn Integrator,
    time: TimeSpan,
    options: Options,
    mut observe: impl FnMut(u64, &System, &State),
) -> Result<Outcome, HarnessError> {
    let (numbering, schedule) = (Numbering::identity(), Schedule::steady(time));
    drive_integrator(simulation, &numbering, integrator, &schedule, options, None, |moment| {
        observe(moment.step, moment.system, moment.state);
    })
}

/// As [`simulate`], by a schedule that may change step size and stiffness on the way, and at most until the
/// [effort](Outcome::effort) reaches a limit.
///
/// # Errors
/// As [`simulate`].
pub(crate) fn drive(
    simulation: &mut Simulation,
    choice: &Choice,
    schedule: &Schedule,
    options: Options,
    effort_limit: Option<f64>,
    observe: impl FnMut(&Moment<'_>),
) -> Result<Outcome, HarnessError> {
    let numbering = Numbering::identity();
    drive_numbered(simulation, &numbering, choice, schedule, options, effort_limit, observe)
}

/// As [`drive`], on a system in an order of its own: what is said of a particle calls it by its given index. The
/// moments are in the order of the system.
pub(crate) fn drive_numbered(
    simulation: &mut Simulation,
    numbering: &Numbering,
    choice: &Choice,
    schedule: &Schedule,
    options: Options,
    effort_limit: Option<f64>,
    observe: impl FnMut(&Moment<'_>),
) -> Result<Outcome, HarnessError> {
    schedule.time.check("time.step_s", "time.duration_s")?;
    let mut integrator = choice.build().map_err(crate::methods::MethodError::from)?;
    let integrator = integrator.as_mut();
    drive_integrator(simulation, numbering, integrator, schedule, options, effort_limit, observe)
}

/// As [`drive_numbered`] with any integrator.
fn drive_integrator(
    simulation: &mut Simulation,
    numbering: &Numbering,
    integrator: &mut dyn Integrator,
    schedule: &Schedule,
    options: Options,
    effort_limit: Option<f64>,
    mut observe: impl FnMut(&Moment<'_>),
) -> Result<Outcome, HarnessError> {
    let time = schedule.time;
    time.check("time.step_s", "time.duration_s")?;
    let Simulation { system, state } = simulation;
    let steps = schedule.steps();
    let begin = Instant::now();
    integrator.prepare(system, TimeStep::new(time.step_s)?)?;
    let prepare_seconds = begin.elapsed().as_secs_f64();
    let mut clock = if options.phases { PhaseClock::on() } else { PhaseClock::off() };
    let bounds = Bounds::of(&state.x);
    let every = steps.div_ceil(MAX_SAMPLES).max(1);
    let (particles, springs) = (system.len() as f64, springs(system) as f64);
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
        is_over_budget: false,
    };
    if options.series {
        outcome.series.push(sample(system, state));
    }
    let start = state.t;
    let mut changed = 0;
    let mut outside_work = 0.0;
    let mut last_finite = options.series.then(|| state.clone());
    let mut before = options.ledger.then(|| state.clone());
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
            // Blow-up is a result: the numbers have left the range in which a matrix can be set up.
            Err(error @ StepError::Solver(_)) => {
                let criterion = refusal(&error, numbering);
                outcome.divergence = Some(Divergence { step, time: state.t, criterion });
                break;
            }
            Err(error) => return Err(error.into()),
        };
        outcome.wall += begin.elapsed();
        state.t = start + schedule.elapsed(step);
        outcome.steps = step;
        add(&mut outcome.totals, &report);
        outcome.effort = effort(&outcome.totals, step, particles, springs);
        outcome.substeps += u64::from(report.substeps);
        outcome.rejected += u64::from(report.rejected);
        outcome.idle += u64::from(report.cg_iterations == 0);
        outcome.unconverged += u64::from(report.solve != SolveStatus::Converged);
        let divergence = bounds.violation(state, numbering);
        if options.series && (step % every == 0 || step == steps) {
            outcome.series.extend(Some(sample(system, state)).filter(is_finite));
        }
        let ledger = before.as_ref().and_then(|before| integrator.ledger(system, before, state, h));
        let (h, report) = (h.seconds(), &report);
        observe(&Moment { step, h, outside_work, system, state, report, ledger });
        let time = state.t;
        if let Some(last) = &mut last_finite {
            // What is recorded must be readable again: JSON knows no infinity.
            if state.is_finite() { last.copy_from(state) } else { state.copy_from(last) }
        }
        if let Some(criterion) = divergence {
            outcome.divergence = Some(Divergence { step, time, criterion });
            break;
        }
        if step < steps && effort_limit.is_some_and(|limit| outcome.effort > limit) {
            outcome.is_over_budget = true;
            break;
        }
    }
    outcome.totals.seconds = outcome.wall.as_secs_f64();
    outcome.totals.prepare_seconds = prepare_seconds;
    outcome.phases = options.phases.then(|| Phases {
        forces: clock.seconds(Phase::Forces),
        matrix_setup: clock.seconds(Phase::MatrixSetup),
        solve: clock.seconds(Phase::Solve),
        contact: clock.seconds(Phase::Contact),
        update: clock.seconds(Phase::Update),
    });
    Ok(outcome)
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

/// Runs a method from the start of a simulation, watching the energy at every step.
///
/// # Errors
/// As [`simulate`].
pub fn count(
    simulation: &Simulation,
    choice: &Choice,
    time: TimeSpan,
) -> Result<Counts, HarnessError> {
    count_by(simulation, choice, &Schedule::steady(time), None, None)
}

/// As [`count`] with any integrator, for example one that no registry knows.
///
/// # Errors
/// As [`simulate`].
pub fn count_with(
    simulation: &Simulation,
    integrator: &mut dyn Integrator,
    time: TimeSpan,
) -> Result<Counts, HarnessError> {
    watch_integrator(simulation, integrator, &Schedule::steady(time), None, None, |_| {})
}

/// As [`count`], by a schedule. `reference` is the scene's `E_ref`, J, where rises of the energy are to be counted;
/// `effort_limit` as in [`drive`].
///
/// # Errors
/// As [`simulate`].
pub(crate) fn count_by(
    simulation: &Simulation,
    choice: &Choice,
    schedule: &Schedule,
    reference: Option<f64>,
    effort_limit: Option<f64>,
) -> Result<Counts, HarnessError> {
    watch_by(simulation, choice, schedule, reference, effort_limit, |_| {})
}

/// As [`count_by`]; `observe` is called after each step.
///
/// # Errors
/// As [`simulate`].
pub(crate) fn watch_by(
    simulation: &Simulation,
    choice: &Choice,
    schedule: &Schedule,
    reference: Option<f64>,
    effort_limit: Option<f64>,
    observe: impl FnMut(&Moment<'_>),
) -> Result<Counts, HarnessError> {
    let mut integrator = choice.build().map_err(crate::methods::MethodError::from)?;
    let integrator = integrator.as_mut();
    watch_integrator(simulation, integrator, schedule, reference, effort_limit, observe)
}

/// As [`watch_by`] with any integrator.
fn watch_integrator(
    simulation: &Simulation,
    integrator: &mut dyn Integrator,
    schedule: &Schedule,
    reference: Option<f64>,
    effort_limit: Option<f64>,
    mut observe: impl FnMut(&Moment<'_>),
) -> Result<Counts, HarnessError> {
    let rule = Rule::of(integrator.method().class, &simulation.system);
    let mut watch = Watch::new(simulation, schedule.time.duration_s, reference);
    let mut simulation = simulation.clone();
    let (options, numbering) = (Options::default(), Numbering::identity());
    let look = |moment: &Moment<'_>| {
        watch.look(schedule.elapsed(moment.step), moment);
        observe(moment);
    };
    let outcome = drive_integrator(
        &mut simulation,
        &numbering,
        integrator,
        schedule,
        options,
        effort_limit,
        look,
    )?;
    let energy = watch.energy(outcome.divergence.is_some());
    Ok(Counts { outcome, energy, rule, state: simulation.state })
}
