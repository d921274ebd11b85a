//! The cloth, its scenes, their true motion, and what a method makes of them.

use super::{EXPLICIT, FRAMES_PER_S, LADDER, REPETITIONS, TIMED};
use crate::film::{Camera, HALF, Seen, look_apart, mean, threads};
use crate::methods::Choice;
use crate::methods::runs::{Film, Substeps};
use crate::run::{Counts, Runner, Simulation};
use crate::stability::{gershgorin, reference_energy};
use crate::studies::animation::facts::{self, Run, TimingRow};
use crate::studies::finite;
use crate::{HarnessError, system_hash};
use drape_integrator::PrepareError;
use drape_model::SystemSpec;
use drape_oracle::Random;
use drape_report::Verdict;

/// Damping of a spring over its stiffness, s.
pub(super) const LIGHT: f64 = 1e-5;
pub(super) const HEAVY: f64 = 1e-3;
/// Of the perturbed starts.
pub(super) const SEED: u64 = 20;
/// Springs along the threads, N/m.
const STIFFNESS: f64 = 2000.0;
/// Greatest height of a particle out of the plane in a perturbed start, m.
const NOISE: f64 = 1e-6;
/// Frames from one look at the surface to the next.
const STRIDE: u32 = 6;
/// When the trajectories are compared, in looks: 0.3 s.
const EARLY: usize = 3;
/// Share of the stability limit at which the true motion is computed.
const SAFETY: f64 = 0.25;
/// The method of the true motion.
const REFERENCE: &str = "leapfrog:damping=explicit";
/// Effort after which a run is over budget, in visits of a spring: some seconds.
pub(super) const BUDGET: f64 = 2e8;

/// Where the cloth is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Held by two corners, it swings down.
    Hanging,
    /// It falls on a ball, off its centre.
    Ball,
}

/// A scene before it is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Case {
    place: Place,
    side: u32,
    is_heavy: bool,
    /// Simulated frames.
    frames: u32,
    /// Starts beside the one without noise.
    perturbed: usize,
}

/// Particles along each edge of the quick scene.
const QUICK: u32 = 10;

pub(super) fn cases() -> Vec<Case> {
    let base = Case { place: Place::Hanging, side: 20, is_heavy: false, frames: 60, perturbed: 3 };
    vec![
        Case { side: QUICK, frames: 30, ..base },
        base,
        Case { is_heavy: true, ..base },
        Case { place: Place::Ball, ..base },
    ]
}

impl Case {
    /// Whether the quick subset has it.
    pub(super) fn is_quick(&self) -> bool {
        self.side == QUICK
    }

    pub(super) fn spec(&self) -> Result<SystemSpec, HarnessError> {
        Ok(drape_model::parse(&self.id(), &self.text())?.spec().clone())
    }

    pub(super) fn id(&self) -> String {
        let place = match self.place {
            Place::Hanging => "hanging",
            Place::Ball => "on a ball",
        };
        let damping = if self.is_heavy { "heavy" } else { "light" };
        format!("{place}, {damping}, n={}", self.side * self.side)
    }

    /// Simulated time, s.
    fn span_s(&self) -> f64 {
        f64::from(self.frames) / f64::from(FRAMES_PER_S)
    }

    fn damping(&self) -> f64 {
        if self.is_heavy { HEAVY } else { LIGHT }
    }

    /// The scene in the words of a file.
    fn text(&self) -> String {
        let Self { place, side, .. } = *self;
        let duration_s = self.span_s();
        let springs = |k: f64| {
            let damping = self.damping() * k;
            format!(r#"{{ "stiffness_n_per_m": {k}, "damping_n_s_per_m": {damping} }}"#)
        };
        let last = side - 1;
        let (height, rest) = match place {
            Place::Hanging => (
                0.0,
                format!(
                    r#""pins": [{{ "row": 0, "column": 0 }}, {{ "row": 0, "column": {last} }}]"#
                ),
            ),
            Place::Ball => (
                0.31,
                r#""obstacles": [{ "sphere": { "center_m": [0.08, 0, 0], "radius_m": 0.3,
                    "friction": 0.3 } }]"#
                    .to_owned(),
            ),
        };
        format!(
            r#"{{ "format": "drape-scene/1", "name": "{}",
            "cloth": {{ "grid": {{ "rows": {side}, "columns": {side}, "size_m": [1, 1],
                "center_m": [0, 0, {height}], "mass_kg": 0.2 }} }},
            "effects": {{ "tension": {}, "shear": {},
                "bending_hinge": {{ "stiffness_n_m": 3.3e-6 }},
                "gravity": {{ "m_s2": [0, 0, -9.81] }} }},
            "damping": "projected", {rest},
            "time": {{ "step_s": 0.01, "duration_s": {duration_s} }} }}"#,
            self.id(),
            springs(STIFFNESS),
            springs(0.02 * STIFFNESS),
        )
    }
}

/// A scene with its true motions.
pub(super) struct Setting {
    pub(super) scene: facts::Scene,
    pub(super) hash: String,
    case: Case,
    simulation: Simulation,
    camera: Camera,
    members: Vec<Seen>,
}

impl Setting {
    pub(super) fn new(case: &Case) -> Result<Self, HarnessError> {
        let case = *case;
        let spec = case.spec()?;
        let (system, state) = spec.build()?;
        let simulation = Simulation { system, state };
        let side = case.side;
        let cells = (0..(side - 1) * (side - 1)).map(|k| k / (side - 1) * side + k % (side - 1));
        let triangles = cells
            .flat_map(|k| [[k, k + 1, k + side], [k + 1, k + side + 1, k + side]])
            .collect::<Vec<_>>();
        // The midpoint of the free edge.
        let midpoint = (side * (side - 1) + side / 2) as usize;
        let camera = Camera {
            triangles,
            threads: threads(&spec),
            tracked: vec![midpoint],
            rate: f64::from(FRAMES_PER_S),
            frames: case.frames,
            stride: STRIDE,
        };
        let (bound, damping) = gershgorin(&simulation.system);
        let frame = 1.0 / f64::from(FRAMES_PER_S);
        let explicit = 4.0 / (damping + (damping * damping + 4.0 * bound).sqrt());
        let reference = 2.0 * (frame / (2.0 * SAFETY * 2.0 / bound.sqrt())).ceil();
        let released = reference_energy(&simulation, case.span_s())?;
        let potential: f64 = elastic_energy(&simulation);
        let mass: f64 = simulation.system.mass().iter().sum();
        let stiffness_over_mass = STIFFNESS / (mass / f64::from(side * side));
        let scene = facts::Scene {
            id: case.id(),
            particles: simulation.system.len(),
            springs: spec.springs.len(),
            stiffness_n_per_m: STIFFNESS,
            stiffness_over_mass_per_s2: stiffness_over_mass,
            theta: frame * frame * stiffness_over_mass,
            damping_over_stiffness_s: case.damping(),
            span_s: case.span_s(),
            limit_substeps: (frame / explicit).ceil() as u32,
            reference_substeps: reference as u32,
            members: case.perturbed + 1,
            shape_floor_m: 0.0,
            trajectory_floor_m: 0.0,
            reference_error_m: 0.0,
            strain: 0.0,
            released_j: released,
            prestress: potential / released,
            portable: true,
        };
        let hash = system_hash(&spec);
        let members = Vec::new();
        let mut setting = Self { scene, hash, case, simulation, camera, members };
        setting.find_true_motion()?;
        Ok(setting)
    }

    /// Computes the true motions, their noise and their error.
    fn find_true_motion(&mut self) -> Result<(), HarnessError> {
        let choice = Choice::parse(REFERENCE, &[])?;
        let mut random = Random::new(SEED);
        let substeps = self.scene.reference_substeps;
        let mut starts = vec![self.simulation.clone()];
        for _ in 0..self.case.perturbed {
            let mut start = self.simulation.clone();
            for (x, pinned) in start.state.x.iter_mut().zip(start.system.pinned()) {
                x.z += if *pinned { 0.0 } else { random.between(-NOISE, NOISE) };
            }
            starts.push(start);
        }
        for start in &starts {
            let (_, film) = self.film(start, &choice, substeps)?;
            self.members.push(film);
        }
        let (_, coarse) = self.film(&self.simulation, &choice, substeps / 2)?;
        let (first, others) = (&self.members[0], &self.members[1..]);
        let count = others.len() as f64;
        let shapes = others.iter().map(|other| self.camera.shape_apart(first, other)).sum::<f64>();
        let ways = others.iter().map(|other| trajectory_apart(first, other)).sum::<f64>();
        self.scene.shape_floor_m = shapes / count;
        self.scene.trajectory_floor_m = ways / count;
        self.scene.reference_error_m = self.camera.shape_apart(first, &coarse);
        self.scene.strain = mean(first.looks.iter().map(|look| look.strain));
        Ok(())
    }

    /// Runs a method over the scene and keeps what is seen.
    fn film(
        &self,
        start: &Simulation,
        choice: &Choice,
        substeps: u32,
    ) -> Result<(Counts, Seen), HarnessError> {
        let time = self.camera.span(substeps, self.case.frames);
        let runner = Runner::new(choice, time).reference(self.scene.released_j).budget(BUDGET);
        self.camera.film(runner, start, &start.state.x, substeps)
    }

    /// All runs of a form.
    pub(super) fn runs(&self, film: &Film) -> Result<Vec<Run>, HarnessError> {
        match film.substeps {
            Substeps::Ladder => LADDER.iter().map(|&n| self.run(film, n)).collect(),
            Substeps::Limit => {
                let mut runs = Vec::new();
                // Within Gershgorin's bound nothing is unstable by stiffness.
                let most = 4 * self.scene.limit_substeps;
                for substeps in EXPLICIT.into_iter().filter(|&n| n <= most) {
                    let run = self.run(film, substeps)?;
                    let is_refused = run.verdict == Verdict::Refused;
                    if !run.is_sound() && !is_refused && !runs.iter().any(Run::is_sound) {
                        runs.clear(); // of the failures before the first sound run the last counts
                    }
                    runs.push(run);
                    if is_refused || runs.iter().filter(|run| run.is_sound()).count() == 2 {
                        break;
                    }
                }
                Ok(runs)
            }
        }
    }

    fn run(&self, film: &Film, substeps: u32) -> Result<Run, HarnessError> {
        let choice = Choice::parse(film.form.method, &[])?;
        let mut run = Run {
            scene: self.scene.id.clone(),
            label: film.form.label.to_owned(),
            method: choice.full_id(),
            substeps,
            is_limited: film.substeps == Substeps::Limit,
            verdict: Verdict::Refused,
            shape_error_m: None,
            trajectory_error_m: None,
            excess_strain: None,
            retained: None,
            kinetic: None,
            gain: 0.0,
            force_evaluations: 0,
            matvecs: 0,
            factorisations: 0,
            newton_iterations: 0,
            cg_iterations: 0,
            unconverged_steps: 0,
            portable: choice.is_portable(),
        };
        let (counts, seen) = match self.film(&self.simulation, &choice, substeps) {
            Ok(seen) => seen,
            Err(HarnessError::Prepare(PrepareError::Unsupported { .. })) => return Ok(run),
            Err(error) => return Err(error),
        };
        let totals = &counts.outcome.totals;
        run.force_evaluations = totals.force_evaluations;
        run.matvecs = totals.matvecs;
        run.factorisations = totals.factorisations;
        run.newton_iterations = totals.newton_iterations;
        run.cg_iterations = totals.cg_iterations;
        run.unconverged_steps = counts.outcome.unconverged;
        run.gain = finite(counts.energy.gain / self.scene.released_j);
        run.verdict = counts.verdict(self.scene.released_j);
        if counts.outcome.is_over_budget && run.verdict < Verdict::Unstable {
            run.verdict = Verdict::OverBudget;
        }
        if matches!(run.verdict, Verdict::Diverged | Verdict::Unstable | Verdict::OverBudget) {
            return Ok(run);
        }
        let first = &self.members[0];
        let nearest = |apart: &dyn Fn(&Seen) -> f64| {
            self.members.iter().map(apart).fold(f64::INFINITY, f64::min)
        };
        let retained = seen.path / first.path;
        let kinetic = |film: &Seen| mean(film.looks.iter().map(|look| look.kinetic));
        run.shape_error_m = Some(nearest(&|member| self.camera.shape_apart(&seen, member)));
        run.trajectory_error_m = Some(nearest(&|member| trajectory_apart(&seen, member)));
        let strain = mean(seen.looks.iter().map(|look| look.strain));
        run.excess_strain = Some(strain - self.scene.strain);
        run.retained = Some(retained);
        run.kinetic = Some(kinetic(&seen) / kinetic(first));
        if run.verdict == Verdict::Stable && retained < HALF {
            run.verdict = Verdict::Locked;
        }
        Ok(run)
    }

    pub(super) fn time(&self, run: &Run) -> Result<TimingRow, HarnessError> {
        let choice = Choice::parse(&run.method, &[])?;
        let mut samples_s = Vec::new();
        for _ in 0..REPETITIONS {
            let runner = Runner::new(&choice, self.camera.span(run.substeps, TIMED));
            samples_s.push(runner.go(&mut self.simulation.clone())?.wall.as_secs_f64());
        }
        let mut sorted = samples_s.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        Ok(TimingRow {
            scene: run.scene.clone(),
            label: run.label.clone(),
            substeps: run.substeps,
            frames: u64::from(TIMED),
            frame_s: sorted[sorted.len() / 2] / f64::from(TIMED),
            samples_s,
        })
    }
}

/// Energy of all effects that cloth stores, J.
fn elastic_energy(simulation: &Simulation) -> f64 {
    let Simulation { system, state } = simulation;
    let stores = |name: &str| name != "gravity";
    system.energies(&state.x).filter(|(name, _)| stores(name)).map(|(_, energy)| energy).sum()
}

/// Root of the mean square distance of the particles at 0.3 s, m.
fn trajectory_apart(a: &Seen, b: &Seen) -> f64 {
    let (Some(a), Some(b)) = (a.looks.get(EARLY - 1), b.looks.get(EARLY - 1)) else {
        return f64::INFINITY;
    };
    look_apart(a, b)
}
