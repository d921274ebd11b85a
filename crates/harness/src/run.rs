//! One method on one scene.

use crate::HarnessError;
use crate::methods::Choice;
use drape_integrator::{Phase, PhaseClock, SolveStatus, StepError, StepReport, TimeStep};
use drape_model::{State, System, TimeSpan, Vec3};
use drape_records::run::{Sample, Totals};
use drape_records::tables::Phases;
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
    /// Seconds by phase, if asked for.
    pub phases: Option<Phases>,
    /// Diagnostics over time, if asked for.
    pub series: Vec<Sample>,
    /// Set if the run diverged.
    pub divergence: Option<Divergence>,
}

/// A system with its start state, ready to be run.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// The system.
    pub system: System,
    /// Its present state.
    pub state: State,
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

    fn violation(&self, state: &State) -> Option<String> {
        if !state.is_finite() {
            return Some("a position or velocity is not finite".to_owned());
        }
        let outside = |x: &Vec3| (x - self.center).norm() > self.reach;
        state.x.iter().position(outside).map(|particle| {
            format!(
                "particle {particle} is farther than {:.3e} m (1000 scene sizes) from the centre of the start",
                self.reach
            )
        })
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
    time.check("time.step_s", "time.duration_s")?;
    let Simulation { system, state } = simulation;
    let (whole, rest) = time.steps();
    let steps = whole + u64::from(rest.is_some());
    let h = TimeStep::new(time.step_s)?;
    let mut integrator = choice.build().map_err(crate::methods::MethodError::from)?;
    let begin = Instant::now();
    integrator.prepare(system, h)?;
    let prepare_seconds = begin.elapsed().as_secs_f64();
    let mut clock = if options.phases { PhaseClock::on() } else { PhaseClock::off() };
    let bounds = Bounds::of(&state.x);
    let every = steps.div_ceil(MAX_SAMPLES).max(1);
    let mut outcome = Outcome {
        steps: 0,
        totals: Totals::default(),
        wall: Duration::ZERO,
        unconverged: 0,
        idle: 0,
        phases: None,
        series: Vec::new(),
        divergence: None,
    };
    if options.series {
        outcome.series.push(sample(system, state));
    }
    let start = state.t;
    let mut last_finite = options.series.then(|| state.clone());
    for step in 1..=steps {
        let h = match rest {
            Some(rest) if step == steps => TimeStep::new(rest)?,
            _ => h,
        };
        let begin = Instant::now();
        let report = match integrator.step(system, state, h, &mut clock) {
            Ok(report) => report,
            // Blow-up is a result: the numbers have left the range in which a matrix can be set up.
            Err(error @ StepError::Solver(_)) => {
                let criterion = error.to_string();
                outcome.divergence = Some(Divergence { step, time: state.t, criterion });
                break;
            }
            Err(error) => return Err(error.into()),
        };
        outcome.wall += begin.elapsed();
        // Sums of h drift; the time of a run is a multiple of its step.
        state.t = start + if step == steps { time.duration_s } else { step as f64 * time.step_s };
        outcome.steps = step;
        add(&mut outcome.totals, &report);
        outcome.idle += u64::from(report.cg_iterations == 0);
        outcome.unconverged += u64::from(report.solve != SolveStatus::Converged);
        let divergence = bounds.violation(state);
        if options.series && (step % every == 0 || step == steps) {
            outcome.series.extend(Some(sample(system, state)).filter(is_finite));
        }
        observe(step, system, state);
        let time = state.t;
        if let Some(last) = &mut last_finite {
            // What is recorded must be readable again: JSON knows no infinity.
            if state.is_finite() { last.copy_from(state) } else { state.copy_from(last) }
        }
        if let Some(criterion) = divergence {
            outcome.divergence = Some(Divergence { step, time, criterion });
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

/// Integer counts and the energy of a run: what experiments on cost need.
#[derive(Clone, Debug)]
pub struct Counts {
    /// Result of the run.
    pub outcome: Outcome,
    /// Greatest rise of the total energy above its start, J; infinite if the run diverged.
    pub energy_gain: f64,
    /// Greatest rise of the total energy above the least it had before, J.
    pub energy_climb: f64,
    /// Least potential energy met, J.
    pub least_potential: f64,
    /// Greatest kinetic energy met, J.
    pub greatest_kinetic: f64,
    /// Last state.
    pub state: State,
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
    let mut simulation = simulation.clone();
    let start = simulation.system.total_energy(&simulation.state);
    let mut least_potential = simulation.system.potential_energy(&simulation.state.x);
    let mut greatest_kinetic = simulation.system.kinetic_energy(&simulation.state.v);
    let (mut energy_gain, mut energy_climb, mut least): (f64, f64, f64) = (0.0, 0.0, start);
    let outcome =
        simulate(&mut simulation, choice, time, Options::default(), |_, system, state| {
            let kinetic = system.kinetic_energy(&state.v);
            let potential = system.potential_energy(&state.x);
            least_potential = least_potential.min(potential);
            greatest_kinetic = greatest_kinetic.max(kinetic);
            let total = kinetic + potential;
            energy_gain = energy_gain.max(total - start);
            least = least.min(total);
            energy_climb = energy_climb.max(total - least);
        })?;
    if outcome.divergence.is_some() {
        (energy_gain, energy_climb) = (f64::INFINITY, f64::INFINITY);
    }
    let state = simulation.state;
    Ok(Counts { outcome, energy_gain, energy_climb, least_potential, greatest_kinetic, state })
}
