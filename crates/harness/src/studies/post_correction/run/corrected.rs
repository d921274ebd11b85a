//! Corrected runs. Each step is taken twice from the same state, with its correction and without
//! it. The difference is the effect of the correction.

use super::sheets::{Course, Kind, SOFT, Setting, elongation, marks, permuted, spinning};
use crate::HarnessError;
use crate::methods::Choice;
use crate::run::Simulation;
use crate::studies::Start;
use crate::studies::post_correction::facts::{FORWARD, PERTURBED, Row, Spin, Sweeps};
use crate::studies::stepper::Stepper;
use drape_integrator::{ElongationLimit, ElongationSettings, SweepOrder, Value};
use drape_model::{State, System, SystemSpec, Vec3};
use drape_oracle::Random;
use drape_report::Verdict;

/// A method with a correction, and the same method without it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Method {
    pub(super) label: &'static str,
    with: &'static str,
    without: &'static str,
}

/// Provot's and Desbrun's methods. Without contact, neither remembers earlier steps.
pub(super) const PROVOT: Method =
    Method { label: "provot", with: "provot:", without: "symplectic-euler" };
pub(super) const DESBRUN: Method =
    Method { label: "desbrun", with: "desbrun:inverse_dynamics=true,", without: "desbrun" };

/// An order of the sweeps: its name, the word of the setting, and the seed of a permutation of the
/// list of springs.
type Order = (&'static str, &'static str, Option<u64>);

const ORDERS: [Order; 7] = [
    (FORWARD, "forward", None),
    ("backward", "backward", None),
    ("shuffled", "shuffled", None),
    ("list 1", "forward", Some(1)),
    ("list 2", "forward", Some(2)),
    // Shows how much of a difference comes from the sensitivity of the motion alone.
    (PERTURBED, "forward", None),
    // With one sweep a step, this order is the forward one.
    ("alternating", "alternating", None),
];

/// Corrected runs that are compared with each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    pub(super) method: Method,
    pub(super) limit: f64,
    pub(super) sweeps: u32,
    pub(super) step_s: f64,
    /// Whether all orders are run, or only the forward one.
    pub(super) all_orders: bool,
}

impl Group {
    fn orders(&self) -> impl Iterator<Item = Order> {
        let kept = |n: usize| n == 0 || (self.all_orders && (n < 6 || self.sweeps > 1));
        ORDERS.into_iter().enumerate().filter(move |(n, _)| kept(*n)).map(|(_, order)| order)
    }

    fn choice(&self, word: &str) -> Result<Choice, HarnessError> {
        let Self { method, limit, sweeps, .. } = self;
        let text = format!("{}limit={limit},sweeps={sweeps},order={word}", method.with);
        Ok(Choice::parse(&text, &[])?)
    }
}

/// Two copies of a run, with and without correction.
struct Twins {
    with: Stepper,
    without: Stepper,
    /// The state at the end of the step without correction.
    uncorrected: State,
}

impl Twins {
    fn new(
        method: Method,
        with: &Choice,
        simulation: &Simulation,
        step_s: f64,
    ) -> Result<Self, HarnessError> {
        let without = Choice::parse(method.without, &[])?;
        let Simulation { system, state } = simulation;
        Ok(Self {
            with: Stepper::new(with, system, step_s)?,
            without: Stepper::new(&without, system, step_s)?,
            uncorrected: state.clone(),
        })
    }

    /// Takes a step. Returns whether neither run has diverged.
    fn step(&mut self, system: &System, state: &mut State) -> Result<bool, HarnessError> {
        self.uncorrected.copy_from(state);
        let without = self.without.step(system, &mut self.uncorrected)?;
        Ok(self.with.step(system, state)?.is_some() && without.is_some())
    }
}

/// Squared `‖M (v_+ − v)/h − f‖` over free particles, N².
fn residual(system: &System, h: f64, before: &[Vec3], after: &[Vec3], force: &[Vec3]) -> f64 {
    let mut sum = 0.0;
    for i in (0..system.len()).filter(|&i| !system.pinned()[i]) {
        sum += ((after[i] - before[i]) * (system.mass()[i] / h) - force[i]).norm_squared();
    }
    sum
}

/// The rows of a group on a mesh, one for each order.
pub(super) fn rows(setting: &Setting, group: &Group) -> Result<Vec<Row>, HarnessError> {
    let mut rows = Vec::new();
    let mut forward: Option<Course> = None;
    for (name, word, seed) in group.orders() {
        let (mut row, course) = hang(setting, group, (name, word, seed))?;
        match &forward {
            Some(forward) => row.order_distance = setting.between(&course, forward),
            None => forward = Some(course),
        }
        rows.push(row);
    }
    Ok(rows)
}

/// Largest disturbance of the start, m: a ten-thousandth of a mesh width.
const DISTURBANCE: f64 = 1e-4 / (super::sheets::SIDE - 1) as f64;

/// Moves every free particle by a small disturbance.
fn perturb(system: &System, state: &mut State) {
    let mut random = Random::new(1);
    for (x, pinned) in state.x.iter_mut().zip(system.pinned()) {
        if !pinned {
            *x += random.vector() * DISTURBANCE;
        }
    }
}

/// The start of a run with an order.
fn begun(
    spec: SystemSpec,
    (name, _, seed): Order,
) -> Result<(SystemSpec, Simulation), HarnessError> {
    let spec = match seed {
        Some(seed) => permuted(spec, seed),
        None => spec,
    };
    let (system, mut state) = spec.build()?;
    if name == PERTURBED {
        perturb(&system, &mut state);
    }
    Ok((spec.with_state(&state), Simulation { system, state }))
}

/// The systems from which runs on a mesh start: those of the [`ORDERS`] that change the soft sheet,
/// and the spinning sheet.
pub(super) fn starts(kind: Kind) -> impl Iterator<Item = Start> {
    let named = move |what: &str| format!("{}, {what}", kind.name());
    let others = ORDERS.into_iter().filter(|(name, _, seed)| seed.is_some() || *name == PERTURBED);
    let free = Start::new(named("spinning"), move || {
        Ok(kind.spec(SOFT, false)?.with_state(&spinning(kind, SPIN)?.state))
    });
    let others = others.map(move |order| {
        Start::new(named(order.0), move || Ok(begun(kind.spec(SOFT, true)?, order)?.0))
    });
    others.chain([free])
}

fn hang(
    setting: &Setting,
    group: &Group,
    (name, word, seed): Order,
) -> Result<(Row, Course), HarnessError> {
    let Group { method, limit, sweeps, step_s, .. } = *group;
    let (_, simulation) = begun(setting.spec.clone(), (name, word, seed))?;
    let choice = group.choice(word)?;
    let mut twins = Twins::new(method, &choice, &simulation, step_s)?;
    let Simulation { system, mut state } = simulation;
    let mass: f64 = system.mass().iter().sum();
    let released = setting.mesh.released_j;
    let marks = marks(step_s);
    let steps = marks[marks.len() - 1];
    let mut force = vec![Vec3::zeros(); system.len()];
    let mut velocity = state.v.clone();
    let mut course = Course::new();
    let (mut squares, mut corrected, mut uncorrected) = (0.0, 0.0, 0.0);
    let mut lift = 0.0;
    let mut row = Row {
        mesh: setting.mesh.id.clone(),
        label: method.label.to_owned(),
        method: choice.full_id(),
        limit,
        sweeps,
        order: name.to_owned(),
        step_s,
        distance: Vec::new(),
        order_distance: Vec::new(),
        energy_taken: 0.0,
        energy_given: 0.0,
        weight_held: 0.0,
        residual: 0.0,
        uncorrected_residual: 0.0,
        elongation: 0.0,
        verdict: Verdict::Completed,
        portable: choice.is_portable(),
    };
    for step in 1..=steps {
        system.forces(state.level(), &mut force);
        velocity.copy_from_slice(&state.v);
        if !twins.step(&system, &mut state)? {
            row.verdict = Verdict::Diverged;
            break;
        }
        squares += residual(&system, step_s, &velocity, &velocity, &force);
        corrected += residual(&system, step_s, &velocity, &state.v, &force);
        uncorrected += residual(&system, step_s, &velocity, &twins.uncorrected.v, &force);
        let change = system.total_energy(&state) - system.total_energy(&twins.uncorrected);
        row.energy_taken += (-change).max(0.0) / released;
        row.energy_given += change.max(0.0) / released;
        lift += (system.momentum(&state) - system.momentum(&twins.uncorrected)).z;
        row.elongation = row.elongation.max(elongation(&system, &state.x));
        if marks.contains(&step) {
            course.push(state.x.clone());
        }
    }
    let weight = -crate::studies::sheet::GRAVITY[2] * mass;
    row.weight_held = lift / (weight * steps as f64 * step_s);
    row.residual = (corrected / squares).sqrt();
    row.uncorrected_residual = (uncorrected / squares).sqrt();
    row.distance = setting.distances(&course);
    Ok((row, course))
}

/// Angular velocity of the free sheets, 1/s. It is so large that their springs stretch beyond the
/// limits.
const SPIN: f64 = 10.0;
const SPIN_DURATION: f64 = 1.0;

/// Spins a free sheet, with one sweep of corrections a step or without correction.
pub(super) fn spin(
    kind: Kind,
    method: Method,
    limit: Option<f64>,
    step_s: f64,
) -> Result<Spin, HarnessError> {
    let simulation = spinning(kind, SPIN)?;
    let choice = match limit {
        Some(limit) => {
            Group { method, limit, sweeps: 1, step_s, all_orders: false }.choice("forward")?
        }
        None => Choice::parse(method.without, &[])?,
    };
    let mut twins = Twins::new(method, &choice, &simulation, step_s)?;
    let Simulation { system, mut state } = simulation;
    let mass: f64 = system.mass().iter().sum();
    let edge = state.v.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let angular_momentum = system.angular_momentum(&state).z;
    let energy = system.total_energy(&state);
    let (mut change, mut taken) = (0.0_f64, 0.0);
    for _ in 0..(SPIN_DURATION / step_s).round() as u64 {
        if !twins.step(&system, &mut state)? {
            break;
        }
        let before = &twins.uncorrected;
        change = change.max((system.momentum(&state) - system.momentum(before)).norm());
        taken += system.angular_momentum(before).z - system.angular_momentum(&state).z;
    }
    Ok(Spin {
        mesh: kind.name().to_owned(),
        label: method.label.to_owned(),
        method: choice.full_id(),
        limit,
        momentum_change: change / (mass * edge),
        angular_momentum_left: system.angular_momentum(&state).z / angular_momentum,
        angular_momentum_taken: taken / angular_momentum,
        energy_left: system.total_energy(&state) / energy,
        portable: choice.is_portable(),
    })
}

/// Numbers of sweeps, up to a thousand.
const SWEEPS: [u32; 11] = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024];
/// Time at which the uncorrected sheet is taken out of its run, s.
const TAKEN: f64 = 0.25;

/// Corrects a sheet that fell without correction, by each number of [`SWEEPS`].
pub(super) fn sweeps(
    setting: &Setting,
    limit: f64,
    word: &str,
    step_s: f64,
) -> Result<Sweeps, HarnessError> {
    let Simulation { system, state } = &setting.simulation;
    let mut state = state.clone();
    let mut stepper = Stepper::new(&Choice::parse(PROVOT.without, &[])?, system, step_s)?;
    for _ in 0..(TAKEN / step_s).round() as u64 {
        stepper.step(system, &mut state)?;
    }
    let after = |sweeps: &u32| {
        let order = SweepOrder::read(word).unwrap_or(ElongationSettings::default().order);
        let settings = ElongationSettings { limit, sweeps: *sweeps as usize, order };
        let mut x = state.x.clone();
        ElongationLimit::new(system, settings).correct(system, step_s, &mut x, None);
        elongation(system, &x)
    };
    Ok(Sweeps {
        mesh: setting.mesh.id.clone(),
        limit,
        order: word.to_owned(),
        before: elongation(system, &state.x),
        sweeps: SWEEPS.to_vec(),
        elongation: SWEEPS.iter().map(after).collect(),
        portable: true,
    })
}
