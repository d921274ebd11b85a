//! The cloth, its scenes, their true motions, and the runs of a method.

use super::{DEAR, EXPLICIT, FILM, FRAMES_PER_S, LADDER, LARGE_LADDER, first_forms, forms, rungs};
use crate::film::{Camera, HALF, Look, Seen, look_apart, mean, noise, threads};
use crate::methods::Choice;
use crate::methods::runs::{Film, Inside, Substeps};
use crate::run::{Counts, Outcome, Runner, Simulation};
use crate::schedule::Schedule;
use crate::stability::{Energy, Rule, gershgorin, judge, reference_run};
use crate::studies::animation::facts::{self, FINE, HEAVY, Measure, NEARLY, Run, TimingRow};
use crate::studies::clocked::{Taken, samples};
use crate::studies::filmed::{Counters, LONG_S, Stage};
use crate::studies::finite;
use crate::studies::sheet::cut;
use crate::work::{WorkBalance, is_driven};
use crate::{HarnessError, Journal, system_hash};
use drape_integrator::PrepareError;
use drape_model::fabric::Material;
use drape_model::{SystemSpec, TimeSpan, Vec3};
use drape_oracle::Random;
use drape_report::Verdict;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

/// Damping of a spring over its stiffness, s.
pub(super) const LIGHT: f64 = 1e-5;
/// Seed of the random numbers that perturb the starts.
pub(super) const SEED: u64 = 20;
/// Greatest displacement of a particle out of the plane in a perturbed start, m.
const NOISE: f64 = 1e-6;
/// Time between looks at the surface, s, rounded up to whole frames.
const LOOK_S: f64 = 0.1;
/// Time at which trajectories are compared, s; if no look falls on it, at the last look before.
const EARLY_S: f64 = 0.3;
/// Step of the true motion, as a share of the stability limit: usual, and where it is coarse.
const SAFETY: f64 = 0.25;
const COARSE_SAFETY: f64 = 0.5;
/// The method of the true motion.
const REFERENCE: &str = "leapfrog:damping=explicit";
/// Largest work of a run, in sweeps of forces per frame at the usual rate on the usual mesh.
pub(super) const SWEEPS_A_FRAME: f64 = 500.0;
/// A run may always take this much work, in visits of a spring: some seconds.
pub(super) const BUDGET: f64 = 1e8;
/// Up to so many particles along an edge the budget of a frame grows. On finer meshes explicit
/// methods still reach their limit within it.
pub(super) const FINEST: u32 = 100;
/// A particle this near to the ball lies on it, m.
pub(super) const NEAR_M: f64 = 5e-3;
/// Radius of the ball and place of its centre, m.
const BALL_M: f64 = 0.3;
const CENTRE_M: [f64; 3] = [0.08, 0.0, 0.0];
/// If wind or rings supply energy, a run has also gained energy if its mean kinetic energy exceeds
/// this share of the true one.
pub(super) const RESTLESS: f64 = 1.5;
/// Period of the rings of a curtain, s, and the distance that they move, m.
const SWAY_S: f64 = 0.8;
const SWAY_M: f64 = 0.3;
/// Keys of the path of a ring in a frame. Between keys a ring moves evenly, so with one key a frame
/// it would start anew in each frame.
const KEYS: u32 = 10;

/// How the cloth is placed and held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Held by two corners, it swings down.
    Hanging,
    /// Its upper edge moves to and fro across the cloth.
    Led,
    /// It falls on a ball, off its centre.
    Ball,
    /// Its middle is held above a ball, as a waist holds a skirt. The rest falls over the ball, off
    /// its centre, and stays there.
    Held,
    /// Held by the corners of an upright edge, in the wind.
    Flag,
}

/// The error from which on more calls of a form are not tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Enough {
    /// A figure asks for no smaller error, or noise hides it.
    Fine,
    /// The run is good.
    Good,
}

/// A scene before it is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Case {
    place: Place,
    /// A bundled material.
    fabric: &'static str,
    side: u32,
    is_heavy: bool,
    /// Frames a second.
    rate: u32,
    /// Simulated frames.
    frames: u32,
    /// Number of starts beside the one without noise.
    perturbed: usize,
    /// Whether every form of a method is run.
    has_all_forms: bool,
    /// Numbers of substeps of a frame for methods that stiffness does not limit.
    pub(super) ladder: &'static [u32],
    /// Whether an explicit method runs on until one of its runs is good.
    until_good: bool,
    /// Whether a sound run of an explicit method is its last if it is exact enough.
    pub(super) ends_when_enough: bool,
    /// How exact is enough.
    pub(super) enough: Enough,
    /// Whether the true motion has steps twice as long, and shows the energy that the scene sets
    /// free at its looks alone. It takes a fourth of the time.
    pub(super) is_truth_coarse: bool,
    /// Whether forms are left out that exceed the budget on the same cloth over a shorter span.
    leaves_out_dear: bool,
}

/// Particles along each edge of the quick scene and of the others.
const QUICK: u32 = 10;
const USUAL: u32 = 20;

const BASE: Case = Case {
    place: Place::Hanging,
    fabric: "cotton-blend",
    side: USUAL,
    is_heavy: false,
    rate: FRAMES_PER_S,
    frames: 36,
    perturbed: 3,
    has_all_forms: true,
    ladder: &LADDER,
    until_good: true,
    ends_when_enough: false,
    enough: Enough::Fine,
    is_truth_coarse: false,
    leaves_out_dear: false,
};

/// The scenes of up to 400 particles: firm to soft fabrics with light and heavy damping and one cloth in
/// every place, for up to a second; and a curtain at the frames of a film for four, since runs of it
/// may gain energy after the first. Every form of every method runs them.
pub(super) fn cases() -> Vec<Case> {
    vec![
        Case { side: QUICK, frames: 20, ..BASE },
        BASE,
        Case { is_heavy: true, ..BASE },
        Case { fabric: "denim", ..BASE },
        Case { fabric: "denim", is_heavy: true, ..BASE },
        Case { fabric: "ponte", ..BASE },
        Case { fabric: "ponte", is_heavy: true, ..BASE },
        Case { place: Place::Led, rate: FILM, frames: 4 * FILM, ..BASE },
        Case { place: Place::Ball, frames: 24, ..BASE },
        Case { place: Place::Flag, frames: 24, ..BASE },
    ]
}

/// Number of frames in 5 s.
const LONG: u32 = 300;

/// The scenes of the long study: larger cloth, and longer motions. Only the first form of each method
/// runs them, and on larger cloth with fewer numbers of substeps, since more would take hours.
pub(super) fn long() -> Vec<Case> {
    let some = Case { frames: LONG, perturbed: 2, has_all_forms: false, ..BASE };
    let dear = Case { until_good: false, ..some };
    let large = Case { side: 50, perturbed: 1, ladder: &LARGE_LADDER, ..dear };
    vec![
        some,
        Case { frames: 24, until_good: true, ..large },
        Case { place: Place::Held, ..dear },
        Case { place: Place::Flag, ..dear },
        large,
        Case { side: 100, frames: 60, ..large },
        Case { side: 200, frames: 24, ends_when_enough: true, ..large },
        Case { side: 200, ..large }.dearest(),
    ]
}

impl Case {
    /// With less precision, for a scene whose true motion and runs take hours otherwise.
    fn dearest(self) -> Self {
        Self {
            ends_when_enough: true,
            enough: Enough::Good,
            is_truth_coarse: true,
            leaves_out_dear: true,
            ..self
        }
    }

    /// Whether forms are left out that exceed the budget in the other case, which shows the same
    /// cloth over a shorter span.
    pub(super) fn leaves_out(&self, other: &Self) -> bool {
        let cloth = |case: &Self| (case.place, case.fabric, case.side, case.is_heavy, case.rate);
        self.leaves_out_dear && cloth(self) == cloth(other) && other.frames < self.frames
    }

    /// A small curtain.
    #[cfg(test)]
    pub(super) fn led_quick() -> Self {
        Self { place: Place::Led, side: QUICK, rate: FILM, frames: FILM, ..BASE }
    }

    /// A small sheet whose true motion is cheap.
    #[cfg(test)]
    pub(super) fn dearest_quick() -> Self {
        Self { side: QUICK, frames: 30, perturbed: 1, ..BASE }.dearest()
    }

    /// Whether the quick subset has this case.
    pub(super) fn is_quick(&self) -> bool {
        self.side == QUICK
    }

    pub(super) fn spec(&self) -> Result<SystemSpec, HarnessError> {
        Ok(drape_model::parse(&self.id(), &self.text())?.spec().clone())
    }

    pub(super) fn id(&self) -> String {
        let place = match self.place {
            Place::Hanging => "hanging",
            Place::Led => "led",
            Place::Ball => "on a ball",
            Place::Held => "held on a ball",
            Place::Flag => "flag",
        };
        let damping = if self.is_heavy { "heavy" } else { "light" };
        let rate =
            if self.rate == FRAMES_PER_S { String::new() } else { format!(", {} Hz", self.rate) };
        let span = if self.is_long() { format!(", {} s", self.span_s()) } else { String::new() };
        format!("{place}, {}, {damping}, n={}{rate}{span}", self.fabric, self.side * self.side)
    }

    /// Simulated time, s.
    fn span_s(&self) -> f64 {
        f64::from(self.frames) / f64::from(self.rate)
    }

    /// Whether the case lasts for more than a second.
    fn is_long(&self) -> bool {
        self.span_s() > 1.0
    }

    fn damping(&self) -> f64 {
        if self.is_heavy { HEAVY } else { LIGHT }
    }

    /// Sweeps of forces after which a frame is over budget. On a finer mesh, a wave takes more steps
    /// to cross the cloth, and information more iterations.
    pub(super) fn sweeps_a_frame(&self) -> f64 {
        SWEEPS_A_FRAME * self.frame_length() * self.fineness()
    }

    /// How many times as much work a frame may take as on the usual mesh.
    fn fineness(&self) -> f64 {
        f64::from(self.side.min(FINEST)) / f64::from(USUAL)
    }

    /// Length of a frame, over that at the usual rate.
    fn frame_length(&self) -> f64 {
        f64::from(FRAMES_PER_S) / f64::from(self.rate)
    }

    /// The measure that ranks its runs.
    fn measure(&self) -> Measure {
        match self.place {
            Place::Hanging | Place::Led | Place::Held => Measure::Shape,
            Place::Flag if self.is_long() => Measure::Kept,
            Place::Ball | Place::Flag => Measure::Trajectory,
        }
    }

    /// Row and column of the particle whose path shows whether the cloth moves: the middle of the
    /// free edge.
    fn midpoint(&self) -> [u32; 2] {
        match self.place {
            Place::Flag => [self.side / 2, self.side - 1],
            _ => [self.side - 1, self.side / 2],
        }
    }

    fn held(&self, row: u32, column: u32) -> Value {
        json!({ "row": row, "column": column })
    }

    /// Paths of the pins along the upper edge.
    fn led(&self) -> Vec<Value> {
        let key = |number: u32| {
            let time = f64::from(number) / f64::from(KEYS * self.rate);
            let way = 0.5 * SWAY_M * (1.0 - libm::cos(std::f64::consts::TAU * time / SWAY_S));
            json!({ "time_s": time, "offset_m": [0, way, 0] })
        };
        let path: Vec<_> = (1..=KEYS * self.frames).map(key).collect();
        let pin = |column| json!({ "row": 0, "column": column, "path": path });
        (0..self.side).map(pin).collect()
    }

    /// The scene in the text of a scene file.
    fn text(&self) -> String {
        let last = self.side - 1;
        let mut grid = json!({
            "rows": self.side, "columns": self.side, "size_m": [1, 1], "center_m": [0, 0, 0],
        });
        let mut scene = json!({
            "format": "drape-scene/1",
            "name": self.id(),
            "material": { "of": self.fabric, "retardation_s": self.damping() },
            "effects": { "gravity": { "m_s2": [0, 0, -9.81] } },
            "damping": "projected",
            "time": { "step_s": 0.01, "duration_s": self.span_s() },
        });
        // The first row is above, the first column to the left.
        let upright = json!({ "axis": [1, 0, 0], "angle_deg": -90 });
        match self.place {
            Place::Hanging => scene["pins"] = json!([self.held(0, 0), self.held(0, last)]),
            Place::Led => {
                grid["rotation"] = upright;
                scene["pins"] = self.led().into();
            }
            Place::Ball | Place::Held => {
                grid["center_m"] = json!([0, 0, 0.31]);
                let ball = json!({ "center_m": CENTRE_M, "radius_m": BALL_M, "friction": 0.3 });
                scene["obstacles"] = json!([{ "sphere": ball }]);
                if self.place == Place::Held {
                    let middle = [last / 2, self.side / 2];
                    let held = |row| middle.map(|column| self.held(row, column));
                    scene["pins"] = middle.map(held).concat().into();
                }
            }
            Place::Flag => {
                grid["rotation"] = upright;
                scene["pins"] = json!([self.held(0, 0), self.held(last, 0)]);
                scene["effects"]["air"] = json!({
                    "drag": { "quadratic": { "coefficient": 1.2 } },
                    "wind": { "velocity_m_s": [6, 2, 0] },
                });
            }
        }
        scene["cloth"] = json!({ "grid": grid });
        scene.to_string()
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
    /// Time at which every run ends, whether it is complete or not.
    pub(super) deadline: Option<Instant>,
}

impl Setting {
    /// The scene with its true motions.
    pub(super) fn new(case: &Case) -> Result<Self, HarnessError> {
        let mut setting = Self::staged(case)?;
        setting.find_true_motion(&Journal::none())?;
        Ok(setting)
    }

    /// The scene without its true motions and energies, which take minutes for large cloth. Its
    /// runs can be timed, but not judged.
    pub(super) fn staged(case: &Case) -> Result<Self, HarnessError> {
        let case = *case;
        let spec = case.spec()?;
        let (system, state) = spec.build()?;
        let simulation = Simulation { system, state };
        let side = case.side;
        let [row, column] = case.midpoint();
        let camera = Camera {
            triangles: cut(side),
            threads: threads(&spec),
            tracked: vec![(side * row + column) as usize],
            rate: f64::from(case.rate),
            frames: case.frames,
            stride: (LOOK_S * f64::from(case.rate)).ceil() as u32,
        };
        let (bound, damping) = gershgorin(&simulation.system);
        let frame = 1.0 / f64::from(case.rate);
        let explicit = 4.0 / (damping + (damping * damping + 4.0 * bound).sqrt());
        let safety = if case.is_truth_coarse { COARSE_SAFETY } else { SAFETY };
        let reference = 2.0 * (frame / (2.0 * safety * explicit)).ceil();
        let mass: f64 = simulation.system.mass().iter().sum();
        let fabric = Material::load(case.fabric)?;
        let stiffness = fabric.tension_n_per_m.warp.max(fabric.tension_n_per_m.weft);
        let stiffness_over_mass = stiffness / (mass / f64::from(side * side));
        let scene = facts::Scene {
            id: case.id(),
            fabric: case.fabric.to_owned(),
            measure: case.measure(),
            has_all_forms: case.has_all_forms,
            particles: simulation.system.len(),
            springs: spec.springs.len(),
            stiffness_n_per_m: stiffness,
            stiffness_over_mass_per_s2: stiffness_over_mass,
            theta: frame * frame * stiffness_over_mass,
            damping_over_stiffness_s: case.damping(),
            frames_per_s: case.rate,
            span_s: case.span_s(),
            limit_substeps: (frame / explicit).ceil() as u32,
            reference_substeps: reference as u32,
            members: case.perturbed + 1,
            shape_floor_m: 0.0,
            trajectory_floor_m: 0.0,
            reference_error_m: 0.0,
            strain: 0.0,
            released_j: 0.0,
            prestress: 0.0,
            portable: true,
            computed: None,
        };
        let hash = system_hash(&spec);
        let members = Vec::new();
        Ok(Self { scene, hash, case, simulation, camera, members, deadline: None })
    }

    /// Computes the energies of the scene, the true motions, the noise between them, and the error
    /// of their step. The journal keeps each film and the energy.
    pub(super) fn find_true_motion(&mut self, journal: &Journal) -> Result<(), HarnessError> {
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
        let at_looks = is_driven(&self.simulation.system) || self.case.is_truth_coarse;
        let part = format!("{}, films", self.scene.id);
        let shot = |number: usize, start: &Simulation, substeps| {
            journal.cell(&part, number, false, || self.film_of_truth(start, &choice, substeps))
        };
        let all = || {
            let numbered = starts.par_iter().enumerate();
            numbered.map(|(k, start)| shot(k, start, substeps)).collect::<Result<Vec<_>, _>>()
        };
        let energy = || journal.cell(&part, starts.len() + 1, false, || self.released());
        // Large cloth takes minutes a film, so all are shot at the same time, beside the energy.
        let (members, (coarse, released)) = rayon::join(all, || {
            rayon::join(
                || shot(starts.len(), &self.simulation, substeps / 2),
                || (!at_looks).then(energy).transpose(),
            )
        });
        self.members = members?;
        let (coarse, released) = (coarse?, released?);
        let released = released.unwrap_or_else(|| self.released_at_looks());
        self.scene.released_j = released;
        self.scene.prestress = elastic_energy(&self.simulation) / released;
        let first = &self.members[0];
        let shapes = noise(&self.members, |a, b| self.camera.shape_apart(a, b));
        let ways = noise(&self.members, |a, b| self.trajectory_apart(a, b));
        self.scene.shape_floor_m = finite(shapes.unwrap_or(f64::INFINITY));
        self.scene.trajectory_floor_m = finite(ways.unwrap_or(f64::INFINITY));
        self.scene.reference_error_m = self.camera.shape_apart(first, &coarse);
        self.scene.strain = mean(first.looks.iter().map(|look| look.strain));
        Ok(())
    }

    /// The energy that the scene sets free, as far as the looks of the true motion show it, J: the
    /// greatest kinetic energy, and without rings and wind also the greatest loss of other energy.
    fn released_at_looks(&self) -> f64 {
        let Simulation { system, state } = &self.simulation;
        let potential = |x: &[Vec3]| system.energies(x).map(|(_, energy)| energy).sum::<f64>();
        let start = (!is_driven(system)).then(|| potential(&state.x));
        let freed = |look: &Look| {
            start.map_or(look.kinetic, |start| look.kinetic.max(start - potential(&look.x)))
        };
        self.members[0].looks.iter().map(freed).fold(0.0, f64::max)
    }

    /// Largest work of a run, in visits of a spring.
    fn budget(&self) -> f64 {
        let sweep = (self.scene.springs + self.scene.particles) as f64;
        BUDGET.max(self.case.sweeps_a_frame() * f64::from(self.case.frames) * sweep)
    }

    /// What the camera sees of a true motion. The run does not watch its energy, which would double
    /// the time.
    fn film_of_truth(
        &self,
        start: &Simulation,
        choice: &Choice,
        substeps: u32,
    ) -> Result<Seen, HarnessError> {
        let time = self.camera.span(substeps, self.case.frames);
        let runner = self.in_time(Runner::new(choice, time));
        let (outcome, seen) = self.camera.glance(runner, &mut start.clone(), substeps)?;
        self.check_time(&outcome)?;
        Ok(seen)
    }

    /// The energy that the scene sets free, J.
    pub(super) fn released(&self) -> Result<f64, HarnessError> {
        let span = self.case.span_s();
        let time = TimeSpan { step_s: span, duration_s: span };
        let counts = reference_run(&self.simulation, &Schedule::steady(time), |r| self.in_time(r))?;
        self.check_time(&counts.outcome)?;
        Ok(counts.energy.released)
    }

    /// Runs a method over the scene. Returns the counts, what the camera saw, and the energy that
    /// the run surely gained beside the work of rings and wind, J; `None` where they do no work or a
    /// method moves particles by other means than forces.
    fn film(
        &self,
        start: &Simulation,
        choice: &Choice,
        substeps: u32,
        budget: f64,
    ) -> Result<(Counts, Seen, Option<f64>), HarnessError> {
        let time = self.camera.span(substeps, self.case.frames);
        let runner = Runner::new(choice, time).reference(self.scene.released_j).budget(budget);
        let mut runner = self.in_time(runner);
        let balance = || Rc::new(RefCell::new(WorkBalance::new(&start.system, &start.state)));
        let balance = is_driven(&start.system).then(balance);
        if let Some(balance) = &balance {
            let balance = Rc::clone(balance);
            runner = runner.ledger().observe(move |moment| balance.borrow_mut().look(moment));
        }
        let (counts, seen) = self.camera.film(runner, start, &start.state.x, substeps)?;
        self.check_time(&counts.outcome)?;
        Ok((counts, seen, balance.and_then(|balance| balance.borrow().sure_excess())))
    }

    /// Makes a run stop at the deadline.
    fn in_time<'a>(&self, runner: Runner<'a>) -> Runner<'a> {
        match self.deadline {
            Some(deadline) => runner.stop(move |_| Instant::now() >= deadline),
            None => runner,
        }
    }

    /// Refuses a run that ended at the deadline, since it shows nothing about its method.
    fn check_time(&self, outcome: &Outcome) -> Result<(), HarnessError> {
        let is_late = self.deadline.is_some_and(|deadline| Instant::now() >= deadline);
        if outcome.is_over_budget && is_late { Err(HarnessError::Late) } else { Ok(()) }
    }

    /// Runs with each of its [`rungs`], until more would be too expensive or could not matter.
    fn ladder(&self, film: &Film) -> Result<Vec<Run>, HarnessError> {
        let dear = DEAR * self.case.fineness().max(1.0) * f64::from(self.case.frames);
        let mut runs: Vec<Run> = Vec::new();
        for (substeps, inside) in rungs(film, self.case.ladder) {
            // More calls take more factorisations, and more sweeps if each call is expensive.
            let is_over = |run: &Run| {
                let is_factored = run.counts.factorisations > 0;
                let is_spent = run.verdict == Verdict::OverBudget && is_factored;
                let is_lively = run.is_lively(1.0 / NEARLY);
                let is_enough = run.is_sound() && is_lively && self.is_exact_enough(run);
                is_enough || is_spent || run.counts.force_evaluations as f64 >= dear
            };
            if runs.last().is_some_and(is_over) {
                break;
            }
            runs.push(self.run(film, substeps, inside)?);
        }
        Ok(runs)
    }

    /// Whether a run is so exact that more calls are not tried.
    fn is_exact_enough(&self, run: &Run) -> bool {
        match self.case.enough {
            Enough::Good => run.is_near(&self.scene, 1.0),
            Enough::Fine => {
                let fine = FINE.max(self.scene.floor_m());
                self.scene.error(run).is_some_and(|error| error <= fine)
            }
        }
    }

    /// Runs with rising numbers of calls until two runs are sound and, if the scene asks for it, one
    /// of them is good; or until one is exact enough, if that is to end them.
    fn to_the_limit(&self, film: &Film) -> Result<Vec<Run>, HarnessError> {
        let mut runs = Vec::new();
        // Within Gershgorin's bound stiffness makes no run unstable.
        let most = 4 * self.scene.limit_substeps;
        for substeps in EXPLICIT.into_iter().filter(|&n| n <= most) {
            let run = self.run(film, substeps, None)?;
            // A refused run stays refused, and more calls only exceed the budget further.
            let is_over = matches!(run.verdict, Verdict::Refused | Verdict::OverBudget);
            let is_enough =
                self.case.ends_when_enough && run.is_sound() && self.is_exact_enough(&run);
            if !run.is_sound() && !is_over && !runs.iter().any(Run::is_sound) {
                runs.clear(); // of the failures before the first sound run the last counts
            }
            runs.push(run);
            let has_two = runs.iter().filter(|run| run.is_sound()).count() >= 2;
            let is_good = runs.iter().any(|run| run.is_good(&self.scene));
            if is_over || is_enough || has_two && (is_good || !self.case.until_good) {
                break;
            }
        }
        Ok(runs)
    }

    /// Runs a form with so many calls a frame, and with the value of a setting if one is given.
    fn run(
        &self,
        film: &Film,
        substeps: u32,
        inside: Option<(&Inside, u32)>,
    ) -> Result<Run, HarnessError> {
        let method = film.form.method;
        let method =
            inside.map_or_else(|| method.to_owned(), |(inside, value)| inside.with(method, value));
        let choice = Choice::parse(&method, &[])?;
        let mut run = Run {
            scene: self.scene.id.clone(),
            label: film.form.label.to_owned(),
            method: choice.full_id(),
            substeps,
            inside: inside.map(|(_, value)| value),
            is_limited: film.substeps == Substeps::Limit,
            verdict: Verdict::Refused,
            shape_error_m: None,
            trajectory_error_m: None,
            excess_strain: None,
            retained: None,
            kinetic: None,
            contact: None,
            gain: 0.0,
            counts: Counters::default(),
            portable: choice.is_portable(),
        };
        let (counts, seen, excess) =
            match self.film(&self.simulation, &choice, substeps, self.budget()) {
                Ok(seen) => seen,
                Err(HarnessError::Prepare(PrepareError::Unsupported { .. })) => return Ok(run),
                Err(error) => return Err(error),
            };
        run.counts = Counters::of(&counts.outcome);
        run.gain = finite(counts.energy.gain / self.scene.released_j);
        run.verdict = counts.verdict(self.scene.released_j);
        if let (Verdict::Open, Some(gain)) = (run.verdict, excess) {
            run.gain = finite(gain / self.scene.released_j);
            let energy = Energy { gain, ..Energy::default() };
            let verdict = judge(&energy, Rule::Dissipative, self.scene.released_j);
            if verdict != Verdict::Stable {
                run.verdict = verdict;
            }
        }
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
        run.trajectory_error_m = Some(nearest(&|member| self.trajectory_apart(&seen, member)));
        let strain = mean(seen.looks.iter().map(|look| look.strain));
        run.excess_strain = Some(strain - self.scene.strain);
        run.retained = Some(retained);
        let restlessness = kinetic(&seen) / kinetic(first);
        run.kinetic = Some(restlessness);
        if run.verdict == Verdict::Open {
            let is_restless = restlessness.is_nan() || restlessness > RESTLESS;
            run.verdict = if is_restless { Verdict::Unstable } else { Verdict::Stable };
        }
        run.contact = self.contact(&seen, first);
        if run.verdict == Verdict::Stable && retained < HALF {
            run.verdict = Verdict::Locked;
        } else if run.verdict == Verdict::Stable && run.contact.is_some_and(|share| share < HALF) {
            run.verdict = Verdict::LostContact;
        }
        Ok(run)
    }

    /// Number of particles on the ball at the last look, over that of another film. `None` if
    /// nothing lies on a ball.
    fn contact(&self, film: &Seen, other: &Seen) -> Option<f64> {
        let on_the_ball = |film: &Seen| {
            let lies = |x: &&Vec3| (*x - Vec3::from(CENTRE_M)).norm() <= BALL_M + NEAR_M;
            film.looks.last().map_or(0, |look| look.x.iter().filter(lies).count()) as f64
        };
        let has_ball = matches!(self.case.place, Place::Ball | Place::Held);
        let is_there = has_ball && on_the_ball(other) > 0.0;
        is_there.then(|| on_the_ball(film) / on_the_ball(other))
    }

    /// Root of the mean square distance of the particles at 0.3 s, or at the last look before, m.
    fn trajectory_apart(&self, a: &Seen, b: &Seen) -> f64 {
        let look_s = f64::from(self.camera.stride) / self.camera.rate;
        let early = (EARLY_S / look_s + 1e-9) as usize;
        match (a.looks.get(early - 1), b.looks.get(early - 1)) {
            (Some(a), Some(b)) => look_apart(a, b),
            _ => f64::INFINITY,
        }
    }
}

impl Stage for Setting {
    type Run = Run;
    type Row = TimingRow;

    fn hash(&self) -> &str {
        &self.hash
    }

    fn films(&self) -> Vec<Film> {
        if self.case.has_all_forms { forms() } else { first_forms() }
    }

    fn runs(&self, film: &Film) -> Result<Vec<Run>, HarnessError> {
        match film.substeps {
            Substeps::Ladder => self.ladder(film),
            Substeps::Limit => self.to_the_limit(film),
        }
    }

    fn scene(run: &Run) -> &str {
        &run.scene
    }

    fn is_timed(run: &Run) -> bool {
        run.is_sound()
    }

    fn seconds(row: &TimingRow) -> f64 {
        row.frame_s
    }

    fn time(&self, run: &Run) -> Result<TimingRow, HarnessError> {
        let choice = Choice::parse(&run.method, &[])?;
        let frames = self.case.frames;
        let Taken { samples_s, seconds, probe_s } = samples(LONG_S, || {
            let runner = Runner::new(&choice, self.camera.span(run.substeps, frames)).processor();
            let outcome = self.in_time(runner).go(&mut self.simulation.clone())?;
            self.check_time(&outcome)?;
            Ok(outcome.seconds())
        })?;
        Ok(TimingRow {
            scene: run.scene.clone(),
            label: run.label.clone(),
            substeps: run.substeps,
            inside: run.inside,
            frames: u64::from(frames),
            frame_s: seconds / f64::from(frames),
            samples_s,
            probe_s: Some(probe_s),
        })
    }
}

/// Energy of all effects except gravity, J.
fn elastic_energy(simulation: &Simulation) -> f64 {
    let Simulation { system, state } = simulation;
    let stores = |name: &str| name != "gravity";
    system.energies(&state.x).filter(|(name, _)| stores(name)).map(|(_, energy)| energy).sum()
}
