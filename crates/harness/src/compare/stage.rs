//! The scene of a comparison: its system, its frames, and how a run on it is filmed.

use super::Options;
use super::deadline::Deadline;
use super::facts::{Metric, Scene};
use super::pace::Pace;
use crate::film::{Camera, Seen, look_apart, mean, threads};
use crate::methods::Choice;
use crate::run::{Counts, Moment, Runner, Simulation};
use crate::stability::gershgorin;
use crate::{HarnessError, system_hash};
use drape_integrator::ExplicitNumbers;
use drape_model::{Numbering, SystemSpec, Vec3, Violation};
use drape_oracle::Random;

/// Most frames.
const MOST_FRAMES: f64 = 100_000.0;
/// Most looks at the cloth, and most positions in all of them.
const LOOKS: (usize, usize) = (10, 20_000);
/// Fewest looks.
const FEW_LOOKS: usize = 5;
/// The target without another, over the size of the cloth.
const USUAL_TARGET: f64 = 0.01;
/// Greatest distance of a particle from its place in a perturbed start, over the size of the cloth.
const NOISE: f64 = 1e-6;
/// Steps of a probe. The first sets up.
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
    /// Steps a frame within Gershgorin's bound.
    pub(super) bound_substeps: u32,
    seed: u64,
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
        let (stiffness, damping) = gershgorin(&ordered.system);
        let limit = |stiffness: f64| {
            4.0 / (damping + (damping * damping + 4.0 * stiffness).sqrt()).max(1e-300)
        };
        let limit_substeps = steps(limit(numbers.explicit_stiffness).min(numbers.drag_limit()));
        let bound_substeps = steps(limit(stiffness)).max(limit_substeps);
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
            bound_substeps,
            seed: options.seed,
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

    /// Films a run. Member 0 starts where the scene does, another number from a perturbed start.
    /// `stop` ends the run.
    pub(super) fn film<'a>(
        &'a self,
        choice: &'a Choice,
        substeps: u32,
        member: usize,
        stop: impl FnMut(&Moment<'_>) -> bool + 'a,
    ) -> Result<(Counts, Seen), HarnessError> {
        let (start, numbering) = self.of(choice);
        let runner = Runner::new(choice, self.camera.span(substeps, self.camera.frames));
        let runner = runner.numbered(numbering).stop(stop);
        if member == 0 {
            return self.camera.film(runner, start, &self.first, substeps);
        }
        let mut start = start.clone();
        let mut random = Random::new(self.seed.wrapping_add(member as u64));
        let reach = NOISE * self.scene.size_m;
        for (x, pinned) in start.state.x.iter_mut().zip(start.system.pinned()) {
            let noise = random.vector() * reach;
            *x += if *pinned { Vec3::zeros() } else { noise };
        }
        let first = numbering.restore(&start.state).x.clone();
        self.camera.film(runner, &start, &first, substeps)
    }

    /// Seconds of the steps of a whole run, without diagnostics.
    pub(super) fn time(
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

    /// Rise of the energy that may be round-off, J.
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
