//! The scene of a comparison: its system, its frames, and how a run on it is filmed.

use super::Options;
use super::balance::Watch;
use super::deadline::Deadline;
use super::facts::{Metric, Scene, Truth};
use super::pace::Pace;
use crate::film::{Camera, Seen, look_apart, mean, threads};
use crate::judgement::{self, Expected};
use crate::kept::{Kept, MotionCheck};
use crate::methods::Choice;
use crate::motion::{LOCKED, Lever, Unforeseen, implicit_springs};
use crate::run::{Counts, Moment, Runner, Simulation};
use crate::stability::{Rule, gershgorin};
use crate::work::is_driven;
use crate::{HarnessError, system_hash};
use drape_integrator::{ExplicitNumbers, Implicit};
use drape_model::{Numbering, SystemSpec, Vec3, Violation};
use drape_oracle::Random;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Most frames.
const MOST_FRAMES: f64 = 100_000.0;
/// Most looks at the cloth, and most positions in all of them.
const LOOKS: (usize, usize) = (10, 20_000);
/// Fewest looks.
const FEW_LOOKS: usize = 5;
/// The target where the user gives none, over the size of the cloth.
const USUAL_TARGET: f64 = 0.01;
/// Greatest distance of a particle from its place in a perturbed start, over the size of the cloth.
const NOISE: f64 = 1e-6;
/// Directions in which the cloth is pushed.
pub(super) const PUSHES: usize = 3;
/// Velocity of a push, in sizes of the cloth a second.
const PUSH: f64 = 0.1;
/// A timed run is repeated until its repetitions have taken this long.
const LEAST_TIMED: Duration = Duration::from_millis(20);
/// Steps of a probe. The first step sets up the method.
const PROBE: u32 = 3;

/// A scene, ready to be run and filmed.
#[derive(Debug)]
pub(super) struct Stage {
    pub(super) scene: Scene,
    pub(super) hash: String,
    /// In the order of the specification.
    plain: Simulation,
    /// In the order that suits the cache.
    ordered: Simulation,
    numbering: Numbering,
    identity: Numbering,
    camera: Camera,
    /// Positions at the start, in the order of the specification, m.
    first: Vec<Vec3>,
    seed: u64,
    /// The numbers from which theory foresees a motion: where only tension is implicit, and where
    /// all springs are.
    levers: [OnceLock<Result<Lever, Unforeseen>>; 2],
}

/// Where a run starts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Start {
    /// Number of the perturbation; 0 is the start of the scene itself.
    pub(super) member: usize,
    /// The direction in which all free particles are pushed, if they are.
    pub(super) push: Option<usize>,
}

/// The result of a cheap check of a run's motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stillness {
    /// The share of its motion that the run kept in a few windows, beside a reference.
    pub(super) share: Option<f64>,
    /// Whether the cloth stands still, or stopped spinning.
    pub(super) is_locked: bool,
}

impl Stage {
    pub(super) fn new(
        name: &str,
        spec: &SystemSpec,
        duration_s: f64,
        options: &Options,
    ) -> Result<Self, HarnessError> {
        let frames = (duration_s * options.rate).round().max(1.0);
        if frames > MOST_FRAMES {
            return Err(Violation {
                path: "--frame".to_owned(),
                value: format!("{} s", 1.0 / options.rate),
                expected: format!("at most {MOST_FRAMES} frames, so at least {} s", {
                    duration_s / MOST_FRAMES
                }),
            }
            .into());
        }
        let frames = frames as u32;
        let (system, state) = spec.build()?;
        let plain = Simulation { system, state };
        let (system, state, numbering) = spec.build_ordered()?;
        let ordered = Simulation { system, state };
        let first = plain.state.x.clone();
        let size_m = size(&first);
        let looks = (LOOKS.1 / first.len().max(1)).clamp(FEW_LOOKS, LOOKS.0) as u32;
        let free = plain.system.pinned().iter().enumerate().filter(|(_, pinned)| !**pinned);
        let camera = Camera {
            triangles: spec.triangles.clone(),
            threads: threads(spec),
            tracked: free.map(|(i, _)| i).collect(),
            rate: options.rate,
            frames,
            stride: (frames / looks).max(1),
        };
        let frame_s = 1.0 / options.rate;
        let steps = |limit: f64| (frame_s / limit).ceil().clamp(1.0, 1e6) as u32;
        let numbers = ExplicitNumbers::new(&ordered.system, &ordered.state, &|_| true);
        let (_, damping) = gershgorin(&ordered.system);
        let root = (damping * damping + 4.0 * numbers.explicit_stiffness).sqrt();
        let limit = 4.0 / (damping + root).max(1e-300);
        let limit_substeps = steps(limit.min(numbers.drag_limit()));
        let scene = Scene {
            name: name.to_owned(),
            particles: first.len(),
            springs: spec.springs.len(),
            frames,
            frame_s,
            size_m,
            metric: options.metric,
            target_m: options.target_m.unwrap_or(USUAL_TARGET * size_m),
            budget_s: options.budget.as_secs_f64(),
            limit_substeps,
            is_driven: is_driven(&plain.system),
        };
        Ok(Self {
            scene,
            hash: system_hash(spec),
            plain,
            ordered,
            numbering,
            identity: Numbering::identity(),
            camera,
            first,
            seed: options.seed,
            levers: Default::default(),
        })
    }

    /// Number of free particles.
    pub(super) fn free(&self) -> usize {
        self.camera.tracked.len()
    }

    fn of(&self, choice: &Choice) -> (&Simulation, &Numbering) {
        if choice.follows_springs() {
            (&self.plain, &self.identity)
        } else {
            (&self.ordered, &self.numbering)
        }
    }

    /// Seconds of a step near the start. A run that is slow from the start ends at `deadline`.
    pub(super) fn probe(
        &self,
        choice: &Choice,
        substeps: u32,
        pace: &Pace,
        deadline: Deadline,
    ) -> Result<f64, HarnessError> {
        let (start, numbering) = self.of(choice);
        let mut time = self.camera.span(substeps, 1);
        time.duration_s = time.step_s * f64::from(PROBE);
        let (mut first, mut last) = (0.0, 0.0);
        let runner = Runner::new(choice, time).numbered(numbering).observe(|moment| {
            last = pace.seconds(moment);
            if moment.step == 1 {
                first = last;
            }
        });
        let runner = runner.stop(|_| deadline.is_over());
        let outcome = runner.go(&mut start.clone())?;
        let rest = last - first;
        let steps = outcome.steps.saturating_sub(1);
        Ok(if steps > 0 { rest / steps as f64 } else { first })
    }

    /// Watches how much of its motion a run keeps.
    pub(super) fn motion_check(&self, choice: &Choice, substeps: u32) -> MotionCheck {
        let Simulation { system, state } = self.of(choice).0;
        let steps = u64::from(substeps) * u64::from(self.camera.frames);
        MotionCheck::new(system, state, steps)
    }

    /// Checks whether a run stands still. `effort` is its number of visits of a spring. Where there
    /// is a true motion, its path tells more than a few windows do, so only the spin is checked.
    pub(super) fn stands_still(
        &self,
        choice: &Choice,
        substeps: u32,
        (check, effort): (&MotionCheck, f64),
        truth: &Truth,
    ) -> Stillness {
        let is_spent = check.spin_share().is_some_and(|share| share < LOCKED);
        if is_spent || truth.path_m.is_some() {
            return Stillness { share: None, is_locked: is_spent };
        }
        let kept = check.finish(&self.of(choice).0.system, effort);
        let share = match kept {
            Kept::Share { share, .. } => Some(share),
            Kept::Still | Kept::Unknown(_) => None,
        };
        let expected = || self.expected(choice, substeps);
        Stillness { share, is_locked: judgement::is_locked(kept, expected) }
    }

    /// What theory predicts for a run.
    fn expected(&self, choice: &Choice, substeps: u32) -> Expected {
        let time = self.camera.span(substeps, self.camera.frames);
        Expected::by(|| self.lever(choice, time.duration_s), choice, time)
    }

    /// The share of the motion that a run keeps by theory, where that locks it. A program of the user
    /// is not asked: it may know no other scene.
    pub(super) fn foreseen(&self, choice: &Choice, substeps: u32) -> Option<f64> {
        let is_program = choice.method().id.starts_with(drape_program::PREFIX);
        let expected = (!is_program).then(|| self.expected(choice, substeps))?;
        expected.share().filter(|share| *share < LOCKED)
    }

    fn lever(&self, choice: &Choice, duration_s: f64) -> Result<Lever, Unforeseen> {
        let implicit = implicit_springs(choice);
        let kept = &self.levers[usize::from(implicit == Implicit::Springs)];
        let Simulation { system, state } = &self.ordered;
        *kept.get_or_init(|| Lever::of(system, state, implicit, duration_s))
    }

    /// Watches the energy of a run where pins, obstacles or wind do work.
    pub(super) fn watch(&self, choice: &Choice, from: Start) -> Option<Watch> {
        self.scene.is_driven.then(|| {
            let start = self.start(choice, from);
            Watch::new(&start, Rule::of(choice.method().class, &start.system))
        })
    }

    /// Takes the steps of the scene. Where something does work on the cloth, they show that work as
    /// far as the method knows it.
    fn runner<'a>(
        &'a self,
        choice: &'a Choice,
        substeps: u32,
        stop: impl FnMut(&Moment<'_>) -> bool + 'a,
    ) -> Runner<'a> {
        let runner = Runner::new(choice, self.camera.span(substeps, self.camera.frames));
        let runner = runner.numbered(self.of(choice).1).stop(stop);
        if self.scene.is_driven { runner.ledger() } else { runner }
    }

    /// Films a run. `stop` ends it.
    pub(super) fn film<'a>(
        &'a self,
        choice: &'a Choice,
        substeps: u32,
        from: Start,
        stop: impl FnMut(&Moment<'_>) -> bool + 'a,
    ) -> Result<(Counts, Seen), HarnessError> {
        let numbering = self.of(choice).1;
        let start = self.start(choice, from);
        let first = match from.member {
            0 => self.first.clone(),
            _ => numbering.restore(&start.state).x.clone(),
        };
        self.camera.film(self.runner(choice, substeps, stop), &start, &first, substeps)
    }

    /// A run in which all free particles are pushed at the start.
    pub(super) fn pushed(
        &self,
        choice: &Choice,
        substeps: u32,
        direction: usize,
        stop: impl FnMut(&Moment<'_>) -> bool,
    ) -> Result<Counts, HarnessError> {
        let start = self.start(choice, Start { member: 0, push: Some(direction) });
        self.runner(choice, substeps, stop).count(&start)
    }

    /// Energy of a push, J.
    pub(super) fn push_energy(&self) -> f64 {
        let system = &self.plain.system;
        let free = system.mass().iter().zip(system.pinned()).filter(|(_, pinned)| !**pinned);
        0.5 * free.map(|(mass, _)| mass).sum::<f64>() * (PUSH * self.scene.size_m).powi(2)
    }

    fn start(&self, choice: &Choice, Start { member, push }: Start) -> Simulation {
        let mut start = self.of(choice).0.clone();
        let Simulation { system, state } = &mut start;
        if member > 0 {
            let mut random = Random::new(self.seed.wrapping_add(member as u64));
            let reach = NOISE * self.scene.size_m;
            for (x, pinned) in state.x.iter_mut().zip(system.pinned()) {
                let noise = random.vector() * reach;
                *x += if *pinned { Vec3::zeros() } else { noise };
            }
        }
        if let Some(direction) = push {
            let push = self.direction(direction) * (PUSH * self.scene.size_m);
            for (v, pinned) in state.v.iter_mut().zip(system.pinned()) {
                *v += if *pinned { Vec3::zeros() } else { push };
            }
        }
        start
    }

    /// One of [`PUSHES`] directions that are at right angles to each other, by the seed.
    fn direction(&self, number: usize) -> Vec3 {
        let mut random = Random::new(self.seed);
        let unit = |a: Vec3| a / a.norm().max(1e-9);
        let first = unit(random.vector());
        let second = unit(first.cross(&random.vector()));
        [first, second, first.cross(&second)][number % PUSHES]
    }

    /// Time of the steps of a whole run, s, without diagnostics. A short run is repeated, so that
    /// the time does not rest on one moment, and the least time counts.
    pub(super) fn time(
        &self,
        choice: &Choice,
        substeps: u32,
        mut stop: impl FnMut(&Moment<'_>) -> bool,
    ) -> Result<Option<f64>, HarnessError> {
        let begin = Instant::now();
        let mut least = None;
        loop {
            let Some(time) = self.time_once(choice, substeps, &mut stop)? else { return Ok(least) };
            least = Some(least.map_or(time, |least: f64| least.min(time)));
            if begin.elapsed() >= LEAST_TIMED {
                return Ok(least);
            }
        }
    }

    fn time_once(
        &self,
        choice: &Choice,
        substeps: u32,
        stop: impl FnMut(&Moment<'_>) -> bool,
    ) -> Result<Option<f64>, HarnessError> {
        let (start, numbering) = self.of(choice);
        let runner = Runner::new(choice, self.camera.span(substeps, self.camera.frames));
        let mut clock = Vec::with_capacity(self.camera.frames as usize);
        let look = |moment: &Moment<'_>| {
            if moment.step.is_multiple_of(u64::from(substeps)) {
                clock.push(moment.wall.as_secs_f64());
            }
        };
        let runner = runner.numbered(numbering).stop(stop).observe(look);
        let outcome = runner.go(&mut start.clone())?;
        let is_whole = !outcome.is_over_budget && outcome.divergence.is_none();
        Ok(is_whole.then(|| super::steady(&clock)))
    }

    /// Distance of two films by the metric, m.
    pub(super) fn apart(&self, a: &Seen, b: &Seen) -> f64 {
        match self.scene.metric {
            Metric::Shape => self.camera.shape_apart(a, b),
            Metric::Trajectory => mean(a.looks.iter().zip(&b.looks).map(|(a, b)| look_apart(a, b))),
        }
    }

    /// Greatest rise of the energy that may be round-off, J.
    pub(super) fn round_off(&self) -> f64 {
        let Simulation { system, state } = &self.ordered;
        let energy = system.energies(&state.x).map(|(_, energy)| energy.abs()).sum::<f64>();
        crate::stability::round_off(system, energy)
    }
}

/// Longest side of the box around points, m.
fn size(x: &[Vec3]) -> f64 {
    let side = |axis: usize| {
        let of = || x.iter().map(|x| x[axis]);
        of().fold(f64::NEG_INFINITY, f64::max) - of().fold(f64::INFINITY, f64::min)
    };
    let size = (0..3).map(side).fold(0.0, f64::max);
    if size > 0.0 { size } else { 1.0 }
}
