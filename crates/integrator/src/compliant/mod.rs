//! Shared parts of the methods that move positions, constraint by constraint, in substeps.
//!
//! A substep predicts the displacements `q` of all particles from a base `x*`. The method then
//! changes `q`, constraint by constraint; contacts act after each sweep. At the end of the substep
//! `v = q/τ` and `x = x* + q`. The numbers of equations are those of `drape-xpbd`.

mod angles;
mod colouring;

pub use angles::CompliantAngles;
pub use colouring::Colouring;

use crate::{Change, ContactSet, History, MultistepMotion, each_particle, kick};
use drape_model::{Effect, Part, State, System, Vec3};
use drape_solvers::Constraints;

/// Fields of the history.
const POSITION: usize = 0;
const VELOCITY: usize = 1;

/// Whether a sweep projects the effect; all others stay at the old level.
fn is_projected(effect: &dyn Effect) -> bool {
    effect.split().is_some() || effect.stencils().is_some()
}

/// Everything that a sweep does not project.
fn explicit(system: &System) -> impl Iterator<Item = (&dyn Effect, Part)> {
    let effects = system.effects().filter(|effect| !is_projected(*effect));
    effects.map(|effect| (effect, Part::All))
}

/// A substep and its formula.
#[derive(Clone, Copy, Debug)]
pub struct Substep {
    /// Length of the substep, s.
    pub h: f64,
    /// Time at the end of the substep, s.
    pub end: f64,
    /// Time constant `τ` of the formula, s.
    pub tau: f64,
    /// Weight of level `n − 1` in `x*` and `v*`; 0 for backward Euler.
    pub past: f64,
}

/// Scratch of a substep, and the history.
#[derive(Debug)]
pub struct PositionBased {
    /// The last substep, for the formula of order 2; without room for order 1.
    history: History<2>,
    /// Force of the effects that no sweep projects, N.
    force: Vec<Vec3>,
    /// `x*`, m.
    base: Vec<Vec3>,
    /// `v*`, and later the velocities that the sweeps leave, m/s.
    free: Vec<Vec3>,
    /// `q`, m.
    way: Vec<Vec3>,
    /// The acceleration that lasts after an impact, m/s²; empty for order 1 or without obstacles.
    acceleration: Vec<Vec3>,
    /// The part of `q` that contacts have made, m. Like the next two empty without obstacles.
    pushed: Vec<Vec3>,
    /// Velocities under contacts, m/s.
    held: Vec<Vec3>,
    impulse: Vec<Vec3>,
    contacts: ContactSet,
    constraints: Constraints,
}

impl PositionBased {
    /// Memory for a system. With `is_second`, the method has order 2, by two-step backward
    /// differentiation.
    pub fn new(system: &System, is_second: bool) -> Self {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Self {
            history: History::new(system.len(), usize::from(is_second)),
            force: zeros(),
            base: zeros(),
            free: zeros(),
            way: zeros(),
            acceleration: if is_second { ContactSet::impulse(system) } else { Vec::new() },
            pushed: ContactSet::impulse(system),
            held: ContactSet::impulse(system),
            impulse: ContactSet::impulse(system),
            contacts: ContactSet::new(system),
            constraints: ContactSet::constraints(system),
        }
    }

    /// Forgets the past and the contacts.
    pub fn restart(&mut self) {
        self.history.restart();
        self.contacts.restart();
    }

    /// The base `x*` (m) and the displacements `q` (m), which sweeps change. Displacements are
    /// small beside positions, so the velocity `q/τ` keeps its digits even in a very short substep.
    pub fn places(&mut self) -> (&[Vec3], &mut [Vec3]) {
        (&self.base, &mut self.way)
    }

    /// Starts a substep of `h` seconds that ends at `end`: (X1) or (X2), then (X3).
    pub fn predict(&mut self, system: &System, state: &State, h: f64, end: f64) -> Substep {
        let substep = self.formula(system, h, end);
        let Self { history, force, base, free, way, pushed, .. } = self;
        let Substep { tau, past, .. } = substep;
        history.mean(POSITION, &state.x, &[past, 1.0 - past], base);
        history.mean(VELOCITY, &state.v, &[past, 1.0 - past], free);
        system.write_forces(explicit(system), state.level(), force);
        kick(system, tau, force, free); // v̂ = v* + τ M⁻¹ f_explicit(x_n, v_n), (X3)
        each_particle(system, way, |i| free[i] * tau); // q = τ v̂, λ = 0, (X3)
        system.clear_pinned(way);
        for pin in system.moving_pins() {
            way[pin.particle] = pin.position(end) - base[pin.particle];
        }
        pushed.fill(Vec3::zeros());
        substep
    }

    /// `τ` and the weights of `x*` and `v*`.
    fn formula(&mut self, system: &System, h: f64, end: f64) -> Substep {
        self.history.refresh(system, h, 0.5..=2.0);
        if self.history.is_empty() {
            return Substep { h, end, tau: h, past: 0.0 }; // x* = x_n, v* = v_n, τ = h, (X1)
        }
        // ω = h/h_{n−1}, x* = ((1+ω)² x_n − ω² x_{n−1})/(1+2ω), v* likewise, (X2)
        let ratio = h / self.history.step(0);
        let sum = 1.0 + 2.0 * ratio;
        let past = -ratio * ratio / sum;
        Substep { h, end, tau: h * (1.0 + ratio) / sum, past } // τ = h (1+ω)/(1+2ω), (X2)
    }

    /// Applies the obstacles to the displacements after a sweep, (X7). It replaces the effect that
    /// they had after the previous sweep.
    pub fn meet(&mut self, system: &System, state: &State, substep: Substep) {
        let Self { contacts, constraints, impulse, held, pushed, free, way, base, .. } = self;
        let Substep { h, end, tau, .. } = substep;
        for ((free, way), pushed) in free.iter_mut().zip(&mut *way).zip(&mut *pushed) {
            *way -= std::mem::take(pushed);
            *free = *way / tau;
        }
        let motion = MultistepMotion { from: (&state.x, &state.v), h, end, x_star: base, tau };
        contacts.detect_predicted(system, motion, free, constraints);
        if contacts.is_empty() {
            return;
        }
        contacts.project(system, constraints, free, held, impulse);
        for i in constraints.constrained().iter().map(|&i| i as usize) {
            if !system.pinned()[i] {
                pushed[i] = held[i] * tau - way[i];
                way[i] += pushed[i];
            }
        }
    }

    /// Ends a substep: velocities and positions by (X8), pins on their paths, contacts.
    pub fn finish(&mut self, system: &System, state: &mut State, substep: Substep) {
        self.remember(system, state, substep);
        let Substep { end, tau, .. } = substep;
        let Self { base, way, .. } = self;
        each_particle(system, &mut state.v, |i| way[i] / tau); // v_+ = q/τ, (X8)
        each_particle(system, &mut state.x, |i| base[i] + way[i]); // x_+ = x* + q, (X8)
        for pin in system.moving_pins() {
            state.x[pin.particle] = pin.position(end);
        }
        self.settle(state);
        state.t = end;
    }

    /// Pushes the level that the substep leaves to the history, and writes the accelerations that
    /// the past of particles gets whose contact changes.
    fn remember(&mut self, system: &System, state: &State, substep: Substep) {
        let Self { history, force, way, acceleration: a, contacts, constraints, .. } = self;
        let Substep { h, tau, past, .. } = substep;
        if !a.is_empty() {
            history.mean(VELOCITY, &state.v, &[past, 1.0 - past], a);
            for (i, m) in system.mass().iter().enumerate() {
                let inverse_mass = if system.pinned()[i] { 0.0 } else { 1.0 / m };
                let explicit = force[i] * inverse_mass;
                let change = (way[i] / tau - a[i]) / tau;
                // Along the normals the impulse hides the springs; the explicit forces go on.
                a[i] = explicit + constraints.filter(i).apply(change - explicit);
            }
            contacts.support(h, a);
        }
        history.push(h, [&state.x, &state.v]);
    }

    /// Ends the contacts. A particle whose contact changed gets a past of constant acceleration.
    fn settle(&mut self, State { x, v, .. }: &mut State) {
        let Self { acceleration: a, contacts, history, .. } = self;
        contacts.settle(v, |Change { particle: i, velocity: v, .. }| {
            history.rewrite(i, |age| [x[i] - (v - a[i] * (0.5 * age)) * age, v - a[i] * age]);
        });
    }
}
