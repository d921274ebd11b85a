//! A pane: one run that is shown. It does not depend on a transport. A session tells it how far it
//! may go, and reads its state and numbers.

use crate::files::Files;
use crate::page::decides;
use crate::setup::{Setup, SetupError, Stage};
use crate::work::{Gate, Run, Runs, StepEnd, lock, start};
use drape_harness::judgement::{self, Expected, Extremes, Start, energy_gain};
use drape_harness::record::{Judged, Judgement};
use drape_harness::{
    LOCKED, Moment, MotionCheck, Moving, OrderedSimulation, Outcome, Rule, Steps, WorkBalance,
};
use drape_integrator::EnergyLedger;
use drape_model::{SpringEffect, State, SystemSpec, TimeSpan, Vec3};
use drape_render::Subject;
use drape_report::number::trimmed;
use serde::Serialize;
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

/// The page is shown a run at most this often.
const SHOWN_EVERY: Duration = Duration::from_millis(30);
/// Steps are timed over at least this long, because the clock of a browser ticks every 0.1 ms.
const MEASURED: Duration = Duration::from_millis(5);
/// Greatest coordinate that is shown, m. Coordinates beyond are moved to it.
const FAR: f64 = 1e6;

/// The progress of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind", content = "sentence")]
pub enum Phase {
    /// The scene is being built.
    #[default]
    Preparing,
    /// It can take a step.
    Ready,
    /// All steps were taken.
    Ended,
    /// It diverged.
    Diverged,
    /// The set-up or the run was refused, for this reason.
    Refused(String),
}

impl Phase {
    /// Whether no step will follow.
    pub fn is_over(&self) -> bool {
        matches!(self, Self::Ended | Self::Diverged | Self::Refused(_))
    }
}

/// A verdict on a run, which may not have ended.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Opinion {
    /// The verdict.
    pub kind: Judged,
    /// Whether the run is over. Until then, theory decides whether the cloth locks.
    pub is_final: bool,
    /// The measurement behind the verdict, in a sentence.
    pub reason: String,
    /// The explanation of the verdict, in a sentence.
    pub why: String,
    /// Address, below that of the page, of the line of the source that decides the verdict.
    pub decides: String,
}

/// Changes of the energy by cause, summed over all steps, J.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Causes {
    damping: f64,
    inertia: f64,
    impact: f64,
    gaps: f64,
    residual: f64,
    constraint: f64,
    correction: f64,
}

impl Causes {
    fn add(&mut self, ledger: &EnergyLedger) {
        self.damping += ledger.damping;
        self.inertia += ledger.inertia;
        self.impact += ledger.impact;
        self.gaps += ledger.gap();
        self.residual += ledger.residual;
        self.constraint += ledger.constraint;
        self.correction += ledger.correction;
    }
}

/// The numbers of a run at the end of a step. Where a person moved the cloth by hand, steps and
/// time count from the first start. All other sums count from the last touch.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Numbers {
    /// Completed steps.
    pub step: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Energy by kind, J; the last is the total.
    pub energy: Vec<(String, f64)>,
    /// The causes of the change of the total energy since the start; `None` where the method does
    /// not report them.
    pub causes: Option<Causes>,
    /// Greatest length of a tension spring over its rest length, less 1.
    pub stretch: f64,
    /// Linear momentum `Σ m v`, kg m/s.
    pub momentum: [f64; 3],
    /// Angular momentum `Σ m x × v` about the origin, kg m²/s.
    pub angular_momentum: [f64; 3],
    /// CG iterations of the last step.
    pub cg_iterations: u32,
    /// CG iterations of all steps.
    pub all_cg_iterations: u64,
    /// Mean wall time of the last steps, µs a step.
    pub micros: f64,
    /// Simulated seconds per second of computing, since the start.
    pub times_real_time: f64,
    /// `h²k/m` of the stiffest spring.
    pub theta: f64,
    /// Positions of the moving obstacles, relative to their start, m.
    pub offsets: Vec<[f64; 3]>,
}

/// The state of a run at the end of a step, as the page shows it.
#[derive(Clone, Debug, Default)]
pub struct Snapshot {
    /// Positions to draw, m.
    pub shown: Vec<[f32; 3]>,
    /// Its numbers.
    pub numbers: Numbers,
    /// Steps since the present start.
    pub step: u64,
    /// The state, in the order of the scene. Its time counts from the present start.
    pub state: Option<State>,
    /// The verdict so far.
    pub opinion: Option<Opinion>,
}

/// The constant parts of a run: the scene, and the subject to draw.
#[derive(Debug)]
pub struct Scenery {
    /// The checked set-up.
    pub stage: Stage,
    /// Triangles, lines and obstacles.
    pub subject: Subject,
}

#[derive(Debug, Default)]
struct Shared {
    gate: Arc<Gate>,
    scenery: OnceLock<Arc<Scenery>>,
    shown: Mutex<(u64, Phase, Arc<Snapshot>)>,
}

impl Shared {
    fn show(&self, phase: Phase, snapshot: Option<Snapshot>) {
        let mut shown = lock(&self.shown);
        shown.0 += 1;
        shown.1 = phase;
        if let Some(snapshot) = snapshot {
            shown.2 = Arc::new(snapshot);
        }
    }
}

/// A run that is shown. Once the pane is dropped, the run ends after its present step.
#[derive(Debug)]
pub struct Pane {
    shared: Arc<Shared>,
    /// Simulated time before its start, s.
    past: f64,
}

impl Drop for Pane {
    fn drop(&mut self) {
        self.shared.gate.close();
    }
}

impl Pane {
    /// Starts the run of a set-up of a bundled scene. The run takes no step before
    /// [`go_until`](Self::go_until). Returns `None` if too many runs exist.
    pub fn start(setup: Setup, runs: &Runs) -> Option<Self> {
        Self::start_with(setup, Arc::default(), runs)
    }

    /// As [`start`](Self::start), for a page that was given `files`.
    pub fn start_with(setup: Setup, files: Arc<Files>, runs: &Runs) -> Option<Self> {
        Self::begin(move || setup.stage_with(&files), 0.0, runs)
    }

    /// Starts the run of a checked stage, which may have a [past](Stage::past).
    pub fn resume(stage: Stage, runs: &Runs) -> Option<Self> {
        let past = stage.past.time;
        Self::begin(move || Ok(stage), past, runs)
    }

    fn begin(
        stage: impl FnOnce() -> Result<Stage, SetupError> + Send + 'static,
        past: f64,
        runs: &Runs,
    ) -> Option<Self> {
        let ticket = runs.enter()?;
        let shared = Arc::new(Shared::default());
        let (worker, told) = (shared.clone(), shared.clone());
        let begin = move || Worker::begin(stage()?, worker);
        let end = move |sentence: Option<String>| {
            if let Some(sentence) = sentence {
                told.show(Phase::Refused(sentence), None);
            }
            drop(ticket);
        };
        start(shared.gate.clone(), begin, end)?;
        Some(Self { shared, past })
    }

    /// Lets the run take all steps that end by this simulated time, s.
    pub fn go_until(&self, time: f64) {
        self.shared.gate.go_until(time - self.past);
    }

    /// The scene; `None` until it is built.
    pub fn scenery(&self) -> Option<&Scenery> {
        self.shared.scenery.get().map(Arc::as_ref)
    }

    /// The present state of the run: a number that grows with each change, the progress, and the
    /// state at the end of a step.
    pub fn look(&self) -> (u64, Phase, Arc<Snapshot>) {
        lock(&self.shared.shown).clone()
    }

    /// The time at the end of the next step, s; `None` if no step follows or the time is not known
    /// yet.
    pub fn next(&self) -> Option<f64> {
        let (_, phase, snapshot) = self.look();
        let time = self.scenery()?.stage.time;
        let since = snapshot.state.as_ref()?.t;
        (phase == Phase::Ready).then(|| self.past + next(since, time))
    }
}

/// The time at the end of the step that begins at `time`, s.
pub(crate) fn next(time: f64, span: TimeSpan) -> f64 {
    (time + span.step_s).min(span.duration_s)
}

/// Positions in the format that the page gets, m.
pub(crate) fn shown(positions: &[Vec3]) -> Vec<[f32; 3]> {
    let near = |c: f64| if c.is_finite() { c.clamp(-FAR, FAR) as f32 } else { 0.0 };
    positions.iter().map(|x| [near(x.x), near(x.y), near(x.z)]).collect()
}

/// The run of `drape run`, step by step.
struct Worker {
    simulation: OrderedSimulation,
    steps: Option<Steps>,
    check: MotionCheck,
    balance: Option<WorkBalance>,
    sight: Sight,
}

impl Worker {
    fn begin(stage: Stage, shared: Arc<Shared>) -> Result<Self, SetupError> {
        let mut simulation = OrderedSimulation::new(&stage.spec, &stage.choice)?;
        let subject = Subject::new(&stage.spec, simulation.obstacles());
        let scenery = Arc::new(Scenery { stage, subject });
        let scenery = shared.scenery.get_or_init(|| scenery).clone();
        let (time, choice) = (scenery.stage.time, &scenery.stage.choice);
        let expected = Expected::of(&simulation, choice, time);
        let (whole, rest) = time.steps();
        let steps = whole + u64::from(rest.is_some());
        let balance = simulation.work_balance();
        let mut sight = Sight {
            start: Start::of(&simulation),
            rule: simulation.rule(),
            is_driven: balance.is_some(),
            theta: simulation.theta(time.step_s),
            limit: simulation.explicit_numbers().limit(),
            advice: expected.warning(&simulation, choice, time.step_s),
            expected,
            extremes: None,
            causes: None,
            all_cg_iterations: 0,
            last: Instant::now(),
            measured: (0, Duration::ZERO),
            micros: 0.0,
            now: 0.0,
            steps,
            scenery: scenery.clone(),
            shared,
        };
        let check = simulation.motion_check(steps);
        let snapshot = sight.snapshot(simulation.moving(), 0, 0, Duration::ZERO);
        let steps = simulation.begin(time, |runner| runner.series().ledger())?;
        sight.shared.show(Phase::Ready, Some(snapshot));
        Ok(Self { simulation, steps: Some(steps), check, balance, sight })
    }

    /// Judges the run as `drape run` does.
    fn end(&mut self, outcome: &Outcome) {
        let Self { simulation, check, balance, sight, .. } = self;
        let stage = &sight.scenery.stage;
        let has_diverged = outcome.divergence.is_some();
        let gain = Extremes::of(&outcome.series)
            .filter(|_| !has_diverged)
            .and_then(|e| energy_gain(e, &stage.choice, sight.rule, sight.start, balance.as_ref()));
        let is_judged = balance.as_ref().is_none_or(|balance| balance.excess().is_some());
        let kept = (!has_diverged).then(|| simulation.kept(check, outcome.effort));
        let kept = (kept, check.spin_share());
        let judgement = judgement::judge(outcome, gain.as_ref(), is_judged, kept, &sight.expected);
        let mut last = sight.snapshot(simulation.moving(), outcome.steps, 0, outcome.wall);
        last.opinion = Some(sight.final_opinion(judgement));
        let phase = if has_diverged { Phase::Diverged } else { Phase::Ended };
        sight.shared.show(phase, Some(last));
    }
}

impl Run for Worker {
    fn next(&self) -> Option<StepEnd> {
        self.steps.as_ref().map(|_| self.sight.next())
    }

    fn step(&mut self) -> Result<(), SetupError> {
        let Self { simulation, steps, check, balance, sight } = self;
        let Some(mut run) = steps.take() else { return Ok(()) };
        let goes_on = simulation.step(&mut run, |moment| {
            check.look(moment);
            if let Some(balance) = balance {
                balance.look(moment);
            }
            sight.look(moment);
        })?;
        if goes_on {
            self.steps = Some(run);
        } else {
            self.end(&run.end());
        }
        Ok(())
    }
}

/// Observes a run, and makes its numbers and verdicts.
struct Sight {
    shared: Arc<Shared>,
    scenery: Arc<Scenery>,
    expected: Expected,
    start: Start,
    rule: Rule,
    /// Whether pins, obstacles or wind do work.
    is_driven: bool,
    theta: f64,
    /// Greatest step that the effects at the old time level allow, s.
    limit: f64,
    advice: Option<String>,
    extremes: Option<Extremes>,
    causes: Option<Causes>,
    all_cg_iterations: u64,
    /// The moment at which the run was last shown.
    last: Instant,
    /// Number of steps, and wall time of their calls, at the last measurement of the time of a
    /// step.
    measured: (u64, Duration),
    micros: f64,
    /// Time at the end of the last step, s.
    now: f64,
    /// Steps of the whole run.
    steps: u64,
}

impl Sight {
    fn next(&self) -> StepEnd {
        let time = self.scenery.stage.time;
        StepEnd(next(self.now, time), time.step_s)
    }

    /// Handles the end of a step. Shows it if the last one shown is old enough, or if the run must
    /// wait there.
    fn look(&mut self, moment: &Moment<'_>) {
        if let Some(ledger) = &moment.ledger {
            self.causes.get_or_insert_default().add(ledger);
        }
        self.all_cg_iterations += u64::from(moment.report.cg_iterations);
        self.now = moment.state.t;
        let must_wait = moment.step != self.steps && !self.shared.gate.lets(self.next());
        if must_wait || self.last.elapsed() >= SHOWN_EVERY {
            let iterations = moment.report.cg_iterations;
            let snapshot = self.snapshot(moment.moving(), moment.step, iterations, moment.wall);
            // States that are not finite are not shown; the end of the run says that it diverged.
            if moment.moving().is_finite() {
                self.shared.show(Phase::Ready, Some(snapshot));
            }
        }
    }

    fn snapshot(
        &mut self,
        moving: Moving<'_>,
        step: u64,
        cg_iterations: u32,
        wall: Duration,
    ) -> Snapshot {
        let state = moving.state().into_owned();
        let energy = moving.energies();
        let of = |name: &str| energy.iter().find(|(key, _)| key == name).map_or(0.0, |(_, e)| *e);
        let (total, kinetic) = (of("total"), of("kinetic"));
        let extremes = self.extremes.get_or_insert(Extremes { start: total, top: total, kinetic });
        extremes.top = extremes.top.max(total);
        extremes.kinetic = extremes.kinetic.max(kinetic);
        let (steps, before) = self.measured;
        let since = wall.saturating_sub(before);
        if step > steps && (since >= MEASURED || self.micros == 0.0) {
            self.micros = since.as_secs_f64() * 1e6 / (step - steps) as f64;
            self.measured = (step, wall);
        }
        self.last = Instant::now();
        let shown = shown(&moving.display_positions());
        let past = &self.scenery.stage.past;
        let (momentum, angular_momentum) = momenta(&self.scenery.stage.spec, &state);
        let paths = self.scenery.subject.solids.iter().filter_map(|solid| solid.path.as_ref());
        let numbers = Numbers {
            step: past.steps + step,
            time: past.time + moving.time(),
            energy,
            causes: self.causes.clone(),
            stretch: stretch(&self.scenery.stage.spec, &state),
            momentum,
            angular_momentum,
            cg_iterations,
            all_cg_iterations: self.all_cg_iterations,
            micros: self.micros,
            times_real_time: if wall.is_zero() { 0.0 } else { state.t / wall.as_secs_f64() },
            theta: self.theta,
            offsets: paths.map(|path| path.offset(state.t).into()).collect(),
        };
        let opinion = Some(self.opinion());
        Snapshot { shown, numbers, step, state: Some(state), opinion }
    }

    /// The verdict before the end. It rests on the measured energy and on the motion that theory
    /// predicts.
    fn opinion(&self) -> Opinion {
        let choice = &self.scenery.stage.choice;
        // Where pins, obstacles or wind do work, only the balance at the end shows a gain.
        let extremes = self.extremes.filter(|_| !self.is_driven);
        let gain = extremes
            .and_then(|extremes| energy_gain(extremes, choice, self.rule, self.start, None));
        let share = self.expected.share();
        let (kind, reason) = match (gain, share) {
            (Some(gain), _) => (Judged::GainedEnergy, gain.told),
            (None, Some(share)) if share < LOCKED => {
                let share = judgement::percent(share);
                (Judged::Locked, format!("theory expects it to keep {share} of the motion"))
            }
            (None, Some(share)) => {
                let share = judgement::percent(share);
                let told =
                    format!("no gain of energy; theory expects it to keep {share} of the motion");
                (Judged::Stable, told)
            }
            (None, None) => (Judged::Stable, "no gain of energy so far".to_owned()),
        };
        let (why, decides) = (self.why(kind), decides(kind));
        Opinion { kind, is_final: false, reason, why, decides }
    }

    fn final_opinion(&self, judgement: Judgement) -> Opinion {
        let Judgement { kind, reason, .. } = judgement;
        Opinion { kind, is_final: true, reason, why: self.why(kind), decides: decides(kind) }
    }

    /// The explanation of a verdict, in a sentence.
    fn why(&self, kind: Judged) -> String {
        let (step, id) = (self.scenery.stage.time.step_s, self.scenery.stage.choice.method().id);
        let ratio = step / self.limit;
        match kind {
            Judged::Diverged | Judged::GainedEnergy if ratio > 1.0 => format!(
                "{id} takes forces at the old time level, which allows steps of at most about {} s; \
                 this step of {step} s is {} times as long.",
                trimmed(self.limit, 2),
                trimmed(ratio, 2)
            ),
            Judged::Diverged | Judged::GainedEnergy => {
                "The step is too long for this method, or its settings allow too large errors."
                    .to_owned()
            }
            Judged::Locked => match &self.advice {
                Some(advice) => sentence(advice),
                None => "The solve damps the motion more than the springs do.".to_owned(),
            },
            Judged::Stable => match self.expected.share() {
                Some(_) => format!(
                    "With h²k/m = {} it holds the stiff springs back and lets the cloth move.",
                    trimmed(self.theta, 2)
                ),
                None if self.limit.is_finite() && ratio <= 1.0 => format!(
                    "The step of {step} s is below its limit of about {} s.",
                    trimmed(self.limit, 2)
                ),
                None => "Nothing in it limits the step on this scene.".to_owned(),
            },
            Judged::Unknown => "No reference and no theory covers this run.".to_owned(),
        }
    }
}

/// A text as a sentence.
fn sentence(text: &str) -> String {
    let mut characters = text.chars();
    let first = characters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", characters.as_str())
}

/// Greatest length of a tension spring over its rest length, less 1.
fn stretch(spec: &SystemSpec, state: &State) -> f64 {
    let tension = spec.springs.iter().filter(|s| s.effect == SpringEffect::Tension);
    let of = |i: u32, j: u32| (state.x[i as usize] - state.x[j as usize]).norm();
    tension
        .filter(|s| s.rest_length_m > 0.0)
        .map(|s| of(s.i, s.j) / s.rest_length_m - 1.0)
        .fold(f64::NEG_INFINITY, f64::max)
}

/// Linear momentum, kg m/s, and angular momentum about the origin, kg m²/s.
fn momenta(spec: &SystemSpec, state: &State) -> ([f64; 3], [f64; 3]) {
    let (mut linear, mut angular) = (Vec3::zeros(), Vec3::zeros());
    for ((&m, x), v) in spec.particles.mass_kg.iter().zip(&state.x).zip(&state.v) {
        linear += v * m;
        angular += x.cross(&(v * m));
    }
    (linear.into(), angular.into())
}
