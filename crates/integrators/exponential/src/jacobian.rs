//! The Jacobian of the equations of motion, and its products.

use drape_integrator::Implicit;
use drape_model::{Effect, State, System, Tangent, Vec3};
use drape_solvers::{BlockMatrix, LinearOperator};

/// `J = (0, I; −M⁻¹K, −M⁻¹D)` at a state, for vectors `(x/s, v)`.
#[derive(Debug)]
pub(crate) struct Jacobian {
    stiffness: BlockMatrix,
    /// `None` without damping.
    damping: Option<BlockMatrix>,
    turns: bool,
    /// `s`, s: the length of time that makes positions comparable to velocities.
    pub(crate) scale: f64,
    state: State,
    stretched: Vec<Vec3>,
    damped: Vec<Vec3>,
}

/// The effects with a Jacobian.
const ALL: Implicit = Implicit::Everything;

impl Jacobian {
    pub(crate) fn new(system: &System) -> Self {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let is_damped = ALL.effects(system).any(Effect::has_damping);
        Self {
            stiffness: ALL.block_matrix(system),
            damping: is_damped.then(|| ALL.block_matrix(system)),
            turns: ALL.effects(system).any(Effect::has_damping_turn),
            scale: 1.0,
            state: State { t: 0.0, x: zeros(), v: zeros() },
            stretched: zeros(),
            damped: zeros(),
        }
    }

    /// Linearises about a state. `K` is exact, indefinite where springs are compressed: anything
    /// else costs an order. Coefficients of drag are taken as they are there.
    pub(crate) fn linearise(&mut self, system: &System, state: &State) {
        self.state.t = state.t;
        self.state.x.copy_from_slice(&state.x);
        self.state.v.copy_from_slice(&state.v);
        self.stiffness.clear();
        for effect in ALL.effects(system) {
            effect.add_stiffness(&state.x, 1.0, Tangent::Exact, &mut self.stiffness);
        }
        if let Some(damping) = &mut self.damping {
            damping.clear();
            for effect in ALL.effects(system).filter(|effect| effect.has_damping()) {
                effect.add_damping(state.level(), 1.0, damping);
            }
        }
        let stiffest = ALL.max_stiffness_over_mass(system).max(1.0);
        self.scale = 1.0 / stiffest.sqrt();
    }

    /// `J F` at the state itself: `(a/s, −M⁻¹(K v + D a))`, without the matrix. Differences of
    /// velocities are multiplied, so a cloth that moves as a whole feels nothing.
    pub(crate) fn apply_to_flow(&mut self, system: &System, a: &[Vec3], out: &mut [Vec3]) {
        let Self { state, damping, stretched, damped, .. } = self;
        ALL.multiply_stiffness(system, &state.x, Tangent::Exact, &state.v, stretched);
        damped.fill(Vec3::zeros());
        if let Some(damping) = damping {
            damping.multiply(a, damped);
        }
        if self.turns {
            subtract_turns(system, state, &state.v, damped);
        }
        let n = a.len();
        let (positions, velocities) = out.split_at_mut(n);
        for i in 0..n {
            positions[i] = a[i] / self.scale;
            velocities[i] = -(self.stretched[i] + self.damped[i]) / system.mass()[i];
        }
        clear_pins(system, out);
    }

    /// `J u` for `u = (x/s, v)`.
    pub(crate) fn multiply(&mut self, system: &System, u: &[Vec3], out: &mut [Vec3]) {
        let n = system.len();
        let (x, v) = u.split_at(n);
        self.stiffness.multiply(x, &mut self.stretched);
        self.damped.fill(Vec3::zeros());
        if let Some(damping) = &self.damping {
            damping.multiply(v, &mut self.damped);
        }
        if self.turns {
            subtract_turns(system, &self.state, x, &mut self.stretched);
        }
        let (positions, velocities) = out.split_at_mut(n);
        for (i, m) in system.mass().iter().enumerate() {
            positions[i] = v[i] / self.scale;
            velocities[i] = -(self.stretched[i] * self.scale + self.damped[i]) / *m;
        }
        clear_pins(system, out);
    }
}

/// Subtracts the change of the damping forces by displacements `w`, N.
fn subtract_turns(system: &System, state: &State, w: &[Vec3], out: &mut [Vec3]) {
    let negate = |out: &mut [Vec3]| out.iter_mut().for_each(|f| *f = -*f);
    negate(out);
    for effect in ALL.effects(system) {
        effect.add_damping_turn(state.level(), w, out);
    }
    negate(out);
}

/// Sets positions and velocities of pinned particles to 0.
fn clear_pins(system: &System, out: &mut [Vec3]) {
    let (positions, velocities) = out.split_at_mut(system.len());
    system.clear_pinned(positions);
    system.clear_pinned(velocities);
}
