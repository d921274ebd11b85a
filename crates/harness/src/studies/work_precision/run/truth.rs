//! True motions of a scene whose starts differ by noise, and the errors of a run against them.

use super::scenes::{Case, SPAN, Setting, TOLERANCE, normal};
use crate::HarnessError;
use crate::film::{Camera, Seen, mean, threads};
use crate::run::{Outcome, Runner, Simulation};
use crate::studies::sheet::cut;
use crate::studies::work_precision::facts::{Beside, Flaw};
use drape_model::{State, System, SystemSpec, Vec3};
use drape_oracle::Random;
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::adaptive::{Pair, adaptive};
use drape_oracle::order::position_error;

/// Seed of the random numbers that perturb the starts.
pub(in crate::studies) const SEED: u64 = 20;
/// Number of perturbed starts, beside the one without noise.
pub(in crate::studies) const PERTURBED: usize = 8;
/// Largest displacement of a particle in a perturbed start, m. It is along the normal of the sheet:
/// in another direction it would stretch the springs.
const NOISE_M: f64 = 1e-6;
/// Number of frames in the span. It is a power of two, so that steps of T/2ʲ end on frames.
const FRAMES: u32 = 8;
/// Frames from one look at the surface to the next.
const STRIDE: u32 = 2;

/// The ensemble of true motions.
#[derive(Clone)]
pub(in crate::studies) struct Truth {
    camera: Camera,
    /// Positions at the start without noise, m.
    start: Vec<Vec3>,
    /// The motion without noise, then those with noise.
    members: Vec<Member>,
    /// Total energy at the start, less the least potential energy at the end of a frame, J.
    released_j: f64,
    /// Noise of the energy at the end, over [`Self::released_j`].
    energy_floor: f64,
}

/// One true motion.
#[derive(Clone)]
struct Member {
    /// Positions at the end, m.
    end: Vec<Vec3>,
    seen: Seen,
    /// Total energy at the end, J.
    energy_j: f64,
}

/// Spread of the true motions, with the size of what they show. Each spread is a mean over the
/// perturbed motions of the distance from the one without noise.
#[derive(Clone, Copy, Debug)]
pub(in crate::studies) struct Noise {
    /// Spread of the positions at the end, as an error.
    pub(in crate::studies) error: f64,
    /// Spread of the surfaces: their mean distance, m.
    pub(in crate::studies) shape_m: f64,
    /// Spread of the mean strain, taken without its sign.
    pub(in crate::studies) strain: f64,
    /// Spread of the energy at the end, over [`Self::released_j`].
    pub(in crate::studies) energy: f64,
    /// Energy that the scene sets free, J.
    pub(in crate::studies) released_j: f64,
    /// Energy that the true motion loses, over [`Self::released_j`].
    pub(in crate::studies) dissipated: f64,
    /// 99th percentile of the strain of the true motion: a mean over time.
    pub(in crate::studies) true_strain: f64,
}

/// The states at the ends of the frames.
fn motion(system: &System, start: &State, tolerance: f64) -> Result<Vec<State>, HarnessError> {
    let settings = AdaptiveSettings { tolerance, max_steps: 4_000_000 };
    let mut states: Vec<State> = Vec::new();
    for _ in 0..FRAMES {
        let from = states.last().unwrap_or(start);
        let next = adaptive(Pair::Dop853, system, from, SPAN / f64::from(FRAMES), settings)?.state;
        states.push(next);
    }
    Ok(states)
}

fn energy(system: &System, state: &State) -> f64 {
    system.kinetic_energy(&state.v) + system.potential_energy(&state.x)
}

impl Setting {
    /// A scene whose runs are compared with the nearest of an ensemble of true motions. Runs are
    /// also measured for the errors in [`Beside`].
    pub(in crate::studies) fn among_noise(case: &Case) -> Result<(Self, Noise), HarnessError> {
        let spec = case.spec()?;
        let (system, state) = spec.build()?;
        let tight = motion(&system, &state, TOLERANCE)?;
        let loose = motion(&system, &state, 10.0 * TOLERANCE)?;
        let (truth, noise) = Truth::new((case, &spec), &system, &state, &tight)?;
        let ends = [tight, loose].map(|states| states.last().unwrap_or(&state).clone());
        let setting = Self::of(case, &spec, TOLERANCE, |_, _| Ok(ends))?;
        Ok((Self { truth: Some(truth), ..setting }, noise))
    }

    /// A scene whose runs are compared with the motion without noise. Noise only says which errors
    /// are too small to rank.
    pub(super) fn beside_noise(case: &Case) -> Result<Self, HarnessError> {
        let setting = Self::new(case)?;
        let Simulation { system, state } = &setting.simulation;
        let tight = motion(system, state, TOLERANCE)?;
        let (mut truth, noise) = Truth::new((case, &case.spec()?), system, state, &tight)?;
        truth.members.truncate(1);
        // The motion of one piece is the more exact: it does not start anew at each frame.
        truth.members[0].end.clone_from(&setting.exact);
        let mut scene = setting.scene.clone();
        (scene.floor, scene.energy_floor) = (noise.error, noise.energy);
        Ok(Self { truth: Some(truth), scene, ..setting })
    }
}

impl Truth {
    fn new(
        (case, spec): (&Case, &SystemSpec),
        system: &System,
        state: &State,
        tight: &[State],
    ) -> Result<(Self, Noise), HarnessError> {
        let camera = Camera {
            triangles: cut(case.side),
            threads: threads(spec),
            tracked: vec![case.tracked()],
            rate: f64::from(FRAMES) / SPAN,
            frames: FRAMES,
            stride: STRIDE,
        };
        let member = |states: &[State]| {
            let seen = camera.look_at(system, &state.x, states);
            let end = states.last().unwrap_or(state);
            Member { end: end.x.clone(), seen, energy_j: energy(system, end) }
        };
        let mut members = vec![member(tight)];
        let mut random = Random::new(SEED);
        for _ in 0..PERTURBED {
            let start = moved(system, state, &mut random);
            members.push(member(&motion(system, &start, 10.0 * TOLERANCE)?));
        }
        let potential = |state: &State| system.potential_energy(&state.x);
        let least = tight.iter().map(potential).fold(f64::INFINITY, f64::min);
        let released_j = energy(system, state) - least;
        let start = state.x.clone();
        let truth = Self { camera, start, members, released_j, energy_floor: 0.0 };
        let noise = truth.noise(system, state);
        Ok((Self { energy_floor: noise.energy, ..truth }, noise))
    }

    fn noise(&self, system: &System, state: &State) -> Noise {
        let (first, others) = (&self.members[0], &self.members[1..]);
        let of = |apart: &dyn Fn(&Member) -> f64| mean(others.iter().map(apart));
        let strain = |member: &Member| mean_strain(&member.seen);
        let off = |energy_j: f64| (energy_j - first.energy_j) / self.released_j;
        Noise {
            error: of(&|other| position_error(system, &self.start, &first.end, &other.end)),
            shape_m: of(&|other| self.camera.shape_apart(&first.seen, &other.seen)),
            strain: of(&|other| (strain(other) - strain(first)).abs()),
            energy: of(&|other| off(other.energy_j).abs()),
            released_j: self.released_j,
            dissipated: off(energy(system, state)),
            true_strain: strain(first),
        }
    }

    /// Makes a run of `steps` steps and looks at its frames.
    pub(super) fn watch<'a>(
        &'a self,
        runner: Runner<'a>,
        simulation: &mut Simulation,
        steps: f64,
    ) -> Result<(Outcome, Seen), HarnessError> {
        let steps = steps as u32;
        if steps < FRAMES {
            self.camera.glance_within(runner, simulation, FRAMES / steps)
        } else {
            self.camera.glance(runner, simulation, steps / FRAMES)
        }
    }

    /// The film of DOP853 at a tolerance; `None` if it does not get to the
    /// end. The method starts anew at each frame.
    pub(super) fn film(&self, start: &Simulation, tolerance: f64) -> Option<Seen> {
        let Simulation { system, state } = start;
        let states = motion(system, state, tolerance).ok()?;
        Some(self.camera.look_at(system, &state.x, &states))
    }

    /// Why a run with these errors may not win.
    pub(super) fn flaw(&self, beside: &Beside) -> Option<Flaw> {
        beside.flaw(self.energy_floor)
    }

    /// The error of the positions at the end against the nearest motion, and that motion.
    fn nearest(&self, system: &System, x: &[Vec3]) -> (f64, &Member) {
        let error = |member: &Member| position_error(system, &self.start, &member.end, x);
        let first = &self.members[0];
        let others = self.members[1..].iter().map(|member| (error(member), member));
        others.fold((error(first), first), |best, next| if next.0 < best.0 { next } else { best })
    }

    /// The error of the positions at the end, against the nearest motion.
    pub(super) fn error(&self, system: &System, x: &[Vec3]) -> f64 {
        self.nearest(system, x).0
    }

    /// The other errors, against the motion whose positions are nearest at the end.
    pub(super) fn beside(&self, simulation: &Simulation, seen: &Seen) -> Beside {
        let Simulation { system, state } = simulation;
        let (_, member) = self.nearest(system, &state.x);
        Beside {
            shape_m: self.camera.shape_apart(seen, &member.seen),
            strain: mean_strain(seen) - mean_strain(&member.seen),
            energy: (energy(system, state) - member.energy_j) / self.released_j,
            retained: seen.path / member.seen.path,
        }
    }
}

/// The start with each free particle moved along the normal of the sheet by noise.
fn moved(system: &System, state: &State, random: &mut Random) -> State {
    let mut start = state.clone();
    for (x, is_pinned) in start.x.iter_mut().zip(system.pinned()) {
        if !*is_pinned {
            *x += normal(x) * random.between(-NOISE_M, NOISE_M);
        }
    }
    start
}

/// A start moved by noise.
pub(in crate::studies) fn perturbed(system: &System, state: &State) -> State {
    moved(system, state, &mut Random::new(SEED))
}

fn mean_strain(seen: &Seen) -> f64 {
    mean(seen.looks.iter().map(|look| look.strain))
}

#[cfg(test)]
impl Setting {
    /// The true positions at the end, m.
    pub(in crate::studies) fn true_ends(&self) -> Vec<&[Vec3]> {
        let members = self.truth.iter().flat_map(|truth| &truth.members);
        members.map(|member| member.end.as_slice()).collect()
    }
}
