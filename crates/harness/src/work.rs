//! The work that pins, obstacles and wind do on a cloth. A gain of energy shows only against it.
//!
//! | cause | its work in a step of `h` |
//! |---|---|
//! | a led pin | `−f·Δx + ½ m Δ(v²)`, with the force `f` of the cloth on it |
//! | pins that move as one | `Δx·(Σ m Δv / h − Σf) + Σ ½ m Δ(v²)`, with the first sum over the particles that are not pinned, the second over all, the third over the pins |
//! | the wind `w` | `h w·Σf` over the drag `f`; relative to the air, drag only takes energy |
//! | an obstacle that moves at `u` | `u·C`, with the impulse `C` of all contacts |
//!
//! `C = Σ (m Δv − h f)` over the particles that are not pinned. Forces between them cancel, so the
//! sum needs no knowledge of the contacts. Where obstacles move differently, `|C|` times the
//! greatest speed is an upper limit. In the same way forces within the cloth cancel in the second
//! line, which counts where all pins move by the same `Δx` and there are no obstacles. Only forces
//! from outside are left, such as gravity. So the line holds in a long step, too, within which the
//! force on a pin changes much.
//!
//! One-step methods report the work of pins and contacts themselves, in the [ledger](EnergyLedger)
//! of a step. The ledger replaces all lines but that of the wind where a run asks for it
//! ([`Runner::ledger`](crate::Runner::ledger)). A stiff sheet that is locked needs the ledger: the
//! forces that its method used are far from the forces at its positions.
//!
//! Other methods take `f` somewhere between the start and the end of the step. So the balance keeps
//! two sums, with the forces at the start and at the end of the steps, and the greater sum counts.
//! Where forces change much within a step, neither sum is the work. A rise is sure only above a
//! third sum, which takes in every step the forces that do more work.

use crate::run::Moment;
#[cfg(doc)]
use drape_integrator::EnergyLedger;
use drape_model::{Level, State, System, Vec3};

/// Compares the total energy of a driven run with the energy at its start plus the work on it.
#[derive(Clone, Debug)]
pub struct WorkBalance {
    /// Total energy at the start, J.
    start: f64,
    /// The last state, with the forces and the work rates that belong to it.
    before: State,
    last: Forces,
    next: Forces,
    /// Work so far by the forces at the start and at the end of the steps, J.
    work: [f64; 2],
    /// Work so far, in every step by those forces which do more, J.
    most: f64,
    /// Greatest rise above the energy at the start plus the work so far, J.
    excess: f64,
    /// Greatest rise above the energy at the start plus `most`, J.
    sure: f64,
    /// Whether a step has moved particles by other means than forces.
    is_corrected: bool,
}

/// Forces at a level.
#[derive(Clone, Debug)]
struct Forces {
    /// Force on each particle, N.
    all: Vec<Vec3>,
    scratch: Vec<Vec3>,
    /// Work rate of the wind, W.
    wind: f64,
    /// Sum of the forces on the particles that are not pinned, N.
    free: Vec3,
    /// Sum of the forces on all particles, N: those within the cloth cancel.
    outside: Vec3,
}

impl Forces {
    fn new(n: usize) -> Self {
        let zeros = || vec![Vec3::zeros(); n];
        Self {
            all: zeros(),
            scratch: zeros(),
            wind: 0.0,
            free: Vec3::zeros(),
            outside: Vec3::zeros(),
        }
    }

    fn evaluate(&mut self, system: &System, at: Level<'_>) {
        system.forces(at, &mut self.all);
        self.wind = 0.0;
        for drag in system.effects().filter(|effect| effect.is_drag()) {
            self.scratch.fill(Vec3::zeros());
            drag.add_damping_force(at, &mut self.scratch);
            self.wind += self.scratch.iter().sum::<Vec3>().dot(&drag.medium_velocity(at.t));
        }
        let free = self.all.iter().zip(system.pinned()).filter(|(_, pinned)| !**pinned);
        self.free = free.map(|(f, _)| f).sum();
        self.outside = self.all.iter().sum();
    }
}

/// Whether pins, obstacles or wind can do work on a cloth.
pub fn is_driven(system: &System) -> bool {
    !system.moving_pins().is_empty()
        || system.obstacles().iter().any(|obstacle| obstacle.path.is_some())
        || system.effects().any(|effect| effect.greatest_medium_speed() > 0.0)
}

impl WorkBalance {
    /// Starts to watch a run, at its start.
    pub fn new(system: &System, state: &State) -> Self {
        let n = state.len();
        let mut last = Forces::new(n);
        last.evaluate(system, state.level());
        Self {
            start: total(system, state),
            before: state.clone(),
            last,
            next: Forces::new(n),
            work: [0.0; 2],
            most: 0.0,
            excess: 0.0,
            sure: 0.0,
            is_corrected: false,
        }
    }

    /// Looks at the end of a step.
    pub fn look(&mut self, moment: &Moment<'_>) {
        let Moment { system, state, report, ref ledger, .. } = *moment;
        self.is_corrected |= report.correction > 0.0;
        if !state.is_finite() || self.is_corrected {
            return;
        }
        let Self { before, last, next, .. } = self;
        next.evaluate(system, state.level());
        let h = state.t - before.t;
        let work = match ledger {
            Some(ledger) => {
                [&*last, &*next].map(|forces| h * forces.wind + ledger.constraint + ledger.impact)
            }
            None => {
                let change = Change::of(system, before, state);
                [&*last, &*next].map(|forces| work(system, (before, state), &change, forces))
            }
        };
        self.work[0] += work[0];
        self.work[1] += work[1];
        self.most += work[0].max(work[1]);
        std::mem::swap(last, next);
        before.copy_from(state);
        let came_in = self.work[0].max(self.work[1]);
        let rise = total(system, state) - self.start;
        self.excess = self.excess.max(rise - came_in);
        self.sure = self.sure.max(rise - self.most);
    }

    /// Greatest rise of the total energy above its start plus the work so far, J. `None` where a
    /// step moved particles by other means than forces, as Provot's correction does. Its pull on a
    /// pin is work that no force shows.
    pub fn excess(&self) -> Option<f64> {
        (!self.is_corrected).then_some(self.excess)
    }

    /// The part of the [`excess`](Self::excess) that no change of forces within steps explains, J.
    pub fn sure_excess(&self) -> Option<f64> {
        (!self.is_corrected).then_some(self.sure)
    }
}

fn total(system: &System, state: &State) -> f64 {
    system.kinetic_energy(&state.v) + system.potential_energy(&state.x)
}

/// What a step does to the cloth as a whole.
struct Change {
    /// The way of all pins, if they move as one and no obstacle takes momentum, m.
    way: Option<Vec3>,
    /// Momentum that the particles gain which are not pinned, N s.
    momentum: Vec3,
}

impl Change {
    fn of(system: &System, from: &State, to: &State) -> Self {
        let free = (0..to.len()).filter(|&i| !system.pinned()[i]);
        let momentum = free.map(|i| (to.v[i] - from.v[i]) * system.mass()[i]).sum();
        Self { way: as_one(system, from, to), momentum }
    }
}

/// The way of all pins in a step, if they move as one and no obstacle takes momentum; else `None`.
fn as_one(system: &System, from: &State, to: &State) -> Option<Vec3> {
    let mut ways = (0..to.len()).filter(|&i| system.pinned()[i]).map(|i| to.x[i] - from.x[i]);
    let first = ways.next().filter(|_| system.obstacles().is_empty())?;
    // Positions are rounded.
    ways.all(|way| (way - first).norm() <= 1e-12).then_some(first)
}

/// Work of a step, J, with the forces at one end of the step.
fn work(
    system: &System,
    (from, to): (&State, &State),
    &Change { way, momentum }: &Change,
    forces: &Forces,
) -> f64 {
    let h = to.t - from.t;
    let mut work = h * forces.wind;
    for i in system.moving_pins().iter().map(|pin| pin.particle) {
        let kinetic = to.v[i].norm_squared() - from.v[i].norm_squared();
        work += 0.5 * system.mass()[i] * kinetic;
        if way.is_none() {
            work -= forces.all[i].dot(&(to.x[i] - from.x[i]));
        }
    }
    if let Some(way) = way {
        work += way.dot(&(momentum / h - forces.outside));
    }
    let velocity = |t: f64, h: f64| {
        let obstacles = system.obstacles().iter();
        obstacles.map(move |obstacle| (obstacle.offset(t + h) - obstacle.offset(t)) / h)
    };
    let velocities = || velocity(from.t, h);
    let fastest = velocities().map(|u| u.norm()).fold(0.0, f64::max);
    if fastest > 0.0 {
        let contact = momentum - forces.free * h;
        let first = velocities().next().unwrap_or_default();
        let is_one = velocities().all(|u| u == first);
        work += if is_one { first.dot(&contact) } else { fastest * contact.norm() };
    }
    work
}
