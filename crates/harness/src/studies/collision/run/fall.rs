//! A rippled sheet that falls on an obstacle: its scenes, and a run of a method with one way out.

use super::Form;
use crate::methods::Choice;
use crate::run::Simulation;
use crate::stability::{Energy, Rule, judge};
use crate::studies::collision::facts::{Row, Scene, TELEPORT};
use crate::studies::finite;
use crate::studies::sheet::{GRAVITY, MASS, Sheet};
use crate::studies::stepper::Stepper;
use crate::{HarnessError, system_hash};
use drape_model::{DampingLaw, Obstacle, ObstacleSpec, State, System, SystemSpec, Vec3};
use drape_report::Verdict;

/// Particles along each edge.
pub(super) const SIDE: u32 = 20;
/// Step size if a scene names no other, s.
pub(super) const STEP: f64 = 0.01;
pub(super) const DURATION: f64 = 0.6;
/// Longest time of the fall to the obstacle, s.
const FLIGHT: f64 = 0.095;
/// Vertical speed of the ripples, m/s. A flat sheet would meet a plane like a single particle.
const RIPPLE: f64 = 0.3;
/// Depth of a draped sheet's centre of mass below the top, m: half of what hangs over the table's
/// edges.
const SAG: f64 = 0.25;
/// Largest distance outside the surface at which a contact is detected, m.
const TOUCHING: f64 = 1e-9;

/// The obstacle. Its top is at z = 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// Half as wide as the sheet.
    Table,
    /// Of 0.3 m radius.
    Sphere,
    Plane,
}

impl Target {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Table => "table",
            Self::Sphere => "sphere",
            Self::Plane => "plane",
        }
    }

    pub(super) fn obstacle(self, restitution: f64) -> ObstacleSpec {
        match self {
            Self::Table => ObstacleSpec::cuboid([0.0, 0.0, -0.25], [0.5; 3], restitution),
            Self::Sphere => ObstacleSpec::sphere([0.0, 0.0, -0.3], 0.3, restitution),
            Self::Plane => ObstacleSpec::plane([0.0; 3], [0.0, 0.0, 1.0], restitution),
        }
    }
}

/// A scene, before its system is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Case {
    pub(super) target: Target,
    pub(super) speed: f64,
    pub(super) stiffness: f64,
    pub(super) step: f64,
    /// Whether there are shear springs. The paper's tablecloth has none.
    pub(super) has_shear: bool,
}

impl Case {
    pub(super) fn id(&self) -> String {
        let Self { target, speed, stiffness, step, has_shear } = *self;
        let finer = if step == STEP { String::new() } else { format!("-h={step}") };
        let bare = if has_shear { "" } else { "-no-shear" };
        format!("{}-{speed}-{stiffness:e}{finer}{bare}", target.name())
    }

    /// Height of the fall, m.
    fn height(&self) -> f64 {
        FLIGHT * self.speed
    }

    /// The system of the sheet above its obstacle, at its start.
    pub(super) fn spec(&self) -> Result<SystemSpec, HarnessError> {
        let Self { target, speed, stiffness, has_shear, .. } = *self;
        let sheet = Sheet {
            side: SIDE,
            tension: stiffness,
            shear: if has_shear { 0.1 * stiffness } else { 0.0 },
            damping: 40.0,
            law: DampingLaw::Full,
            gravity: GRAVITY,
            is_pinned: false,
        };
        let mut spec = sheet.spec()?;
        let particles = &mut spec.particles;
        for position in &mut particles.position_m {
            position[2] += self.height();
        }
        let wave = |x: f64| libm::sin(2.0 * std::f64::consts::PI * x);
        // A sheet that lies on its obstacle from the start is flat, as in the paper.
        let ripple = if speed > 0.0 { RIPPLE } else { 0.0 };
        let velocity = |x: &[f64; 3]| [0.0, 0.0, ripple * wave(x[0]) * wave(x[1]) - speed];
        particles.velocity_m_s = particles.position_m.iter().map(velocity).collect();
        spec.obstacles = vec![target.obstacle(0.0)];
        Ok(spec)
    }

    /// Simulated time, s. It is long enough for the middle of the sheet to come to rest.
    fn duration(&self) -> f64 {
        if self.speed > 0.0 { DURATION } else { 1.0 }
    }

    /// Whether this is the middle of the sweep. Costly methods run only there, and iterations are
    /// plotted.
    pub(super) fn is_middle(&self) -> bool {
        self.speed == 3.0 && self.step == STEP
    }
}

/// A scene at its start.
pub(super) struct Stage {
    pub(super) case: Case,
    pub(super) scene: Scene,
    pub(super) hash: String,
    pub(super) body: Body,
}

/// A falling system, with and without the obstacle.
pub(super) struct Body {
    pub(super) simulation: Simulation,
    /// The system for methods that do not know of the obstacle.
    bare: System,
}

impl Body {
    /// Puts an obstacle below a system.
    pub(super) fn new(spec: &mut SystemSpec, obstacle: ObstacleSpec) -> Result<Self, HarnessError> {
        spec.obstacles = Vec::new();
        let (bare, _) = spec.build()?;
        spec.obstacles = vec![obstacle];
        let (system, state) = spec.build()?;
        Ok(Self { simulation: Simulation { system, state }, bare })
    }

    /// The system that a method sees.
    pub(super) fn seen(&self, form: &Form) -> &System {
        if form.way_out == TELEPORT { &self.bare } else { &self.simulation.system }
    }

    pub(super) fn obstacle(&self) -> &Obstacle {
        &self.simulation.system.obstacles()[0]
    }
}

impl Stage {
    pub(super) fn new(case: &Case) -> Result<Self, HarnessError> {
        let Case { target, speed, stiffness, step, .. } = *case;
        let drop = case.height();
        let mut spec = case.spec()?;
        let body = Body::new(&mut spec, target.obstacle(0.0))?;
        let mass = MASS * f64::from(SIDE * SIDE);
        let scene = Scene {
            id: case.id(),
            obstacle: target.name().to_owned(),
            speed_m_s: speed,
            stiffness_over_mass_per_s2: stiffness,
            step_s: step,
            steps: (case.duration() / step).round() as u64,
            particles: body.simulation.state.len(),
            drop_m: drop,
            available_j: mass * (0.5 * speed * speed - GRAVITY[2] * (drop + SAG)),
            portable: true,
        };
        Ok(Self { case: *case, scene, hash: system_hash(&spec), body })
    }
}

/// Moves the particles inside an obstacle to its surface, as Provot and Desbrun treat collisions.
/// A normal velocity into the obstacle is reversed with the restitution `e`. Returns the number of
/// particles that were moved.
pub(super) fn teleport(obstacle: &Obstacle, state: &mut State) -> u64 {
    let mut moved = 0;
    for (x, v) in state.x.iter_mut().zip(&mut state.v) {
        let (distance, normal) = obstacle.distance(x);
        if distance < 0.0 {
            *x -= normal * distance;
            let along = normal.dot(v);
            *v -= normal * ((1.0 + obstacle.restitution) * along.min(0.0));
            moved += 1;
        }
    }
    moved
}

/// Which of the particles touch the obstacle.
pub(super) fn touching(obstacle: &Obstacle, x: &[Vec3]) -> Vec<bool> {
    x.iter().map(|x| obstacle.distance(x).0 < TOUCHING).collect()
}

/// Greatest depth of a particle inside the obstacle, m.
fn depth(obstacle: &Obstacle, x: &[Vec3]) -> f64 {
    x.iter().fold(0.0, |deepest, x| f64::max(deepest, -obstacle.distance(x).0))
}

/// Runs a method with its way out on a scene.
pub(super) fn row(form: &Form, stage: &Stage) -> Result<Row, HarnessError> {
    let choice = Choice::parse(form.method, &[])?;
    let Stage { case, scene, body, .. } = stage;
    let (system, obstacle) = (body.seen(form), body.obstacle());
    let mut state = body.simulation.state.clone();
    let mut stepper = Stepper::new(&choice, system, case.step)?;
    let start = system.total_energy(&state);
    let (mut energy, mut least, mut gain) = (start, start, 0.0_f64);
    let mut contacts = touching(obstacle, &state.x);
    let mut before = state.x.clone();
    let (mut has_met, mut diverged, mut fastest) = (false, false, 0.0_f64);
    let mut row = Row {
        scene: scene.id.clone(),
        label: form.label.to_owned(),
        way_out: form.way_out.to_owned(),
        method: choice.full_id(),
        steps_before: 0,
        steps_after: 0,
        iterations_before: 0,
        iterations_after: 0,
        iterations_by_step: Vec::new(),
        teleports: 0,
        depth_m: 0.0,
        depth_over_reach: 0.0,
        displayed_depth_m: 0.0,
        release_j: 0.0,
        climb_j: 0.0,
        gain: 0.0,
        unconverged_steps: 0,
        verdict: Verdict::Open,
        portable: choice.is_portable(),
    };
    for _ in 0..scene.steps {
        let Some(report) = stepper.step(system, &mut state)? else {
            diverged = true;
            break;
        };
        has_met |= contacts.contains(&true);
        let iterations = report.cg_iterations + report.newton_iterations;
        if has_met {
            row.steps_after += 1;
            row.iterations_after += u64::from(iterations);
        } else {
            row.steps_before += 1;
            row.iterations_before += u64::from(iterations);
        }
        if case.is_middle() && case.target == Target::Table {
            row.iterations_by_step.push(iterations);
        }
        row.unconverged_steps +=
            u64::from(report.solve != drape_integrator::SolveStatus::Converged);
        let ways = state.x.iter().zip(&before).map(|(x, before)| (x - before).norm());
        fastest = ways.fold(fastest, f64::max);
        row.depth_m = row.depth_m.max(depth(obstacle, &state.x));
        let shown = body.simulation.system.display_positions(&state.x, state.t);
        row.displayed_depth_m = row.displayed_depth_m.max(depth(obstacle, &shown));
        if form.way_out == TELEPORT {
            let moved = teleport(obstacle, &mut state);
            row.teleports += moved;
            if moved > 0 {
                stepper.restart(&state);
            }
        }
        before.copy_from_slice(&state.x);
        let now = touching(obstacle, &state.x);
        let after = system.total_energy(&state);
        if contacts.iter().zip(&now).any(|(was, is)| *was && !is) {
            row.release_j += (after - energy).max(0.0);
        }
        (contacts, energy) = (now, after);
        least = least.min(energy);
        row.climb_j = row.climb_j.max(energy - least);
        gain = gain.max(energy - start);
    }
    row.depth_over_reach = if fastest > 0.0 { row.depth_m / fastest } else { 0.0 };
    row.gain = finite(gain / scene.available_j);
    (row.release_j, row.climb_j) = (finite(row.release_j), finite(row.climb_j));
    let verdict = if diverged {
        Verdict::Diverged
    } else {
        judge(&Energy { gain, ..Energy::default() }, Rule::Dissipative, scene.available_j)
    };
    row.verdict = verdict;
    Ok(row)
}
