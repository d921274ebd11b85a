//! Scratch memory, history and contacts of Adams–Bashforth.

use super::step_sizes;
use crate::coefficients::LinearMultistep;
use crate::settings::Steps;
use drape_integrator::{Change, ContactSet, History, drift};
use drape_model::{Level, State, System, Vec3};
use drape_solvers::Constraints;

const VELOCITY: usize = 0;
const ACCELERATION: usize = 1;

#[derive(Debug)]
pub(crate) struct AdamsWorkspace {
    /// Velocities and accelerations.
    pub(crate) history: History<2>,
    /// `a_n = M⁻¹ f(x_n, v_n)`, 0 where pinned.
    acceleration: Vec<Vec3>,
    /// `Σ_j β_j a_{n−j}`.
    pub(crate) mean_acceleration: Vec<Vec3>,
    /// `Σ_j β_j v_{n−j} − v_n`, what the positions move by beside `v_n`.
    pub(crate) lead: Vec<Vec3>,
    /// `v_n` as pins and contacts leave it.
    pub(crate) velocity: Vec<Vec3>,
    predicted: (Vec<Vec3>, Vec<Vec3>),
    /// What `v_{n+1}` would be without pins and contacts.
    free_velocity: Vec<Vec3>,
    impulse: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    constraints: Constraints,
}

/// `a = M⁻¹ f(t, x, v)`, 0 where pinned.
fn accelerations(system: &System, at: Level<'_>, a: &mut [Vec3]) {
    system.forces(at, a);
    for (i, a) in a.iter_mut().enumerate() {
        *a = if system.pinned()[i] { Vec3::zeros() } else { *a / system.mass()[i] };
    }
}

impl AdamsWorkspace {
    pub(crate) fn new(system: &System, steps: Steps) -> Self {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Self {
            history: History::new(system.len(), steps.count() - 1),
            acceleration: zeros(),
            mean_acceleration: zeros(),
            lead: zeros(),
            velocity: zeros(),
            predicted: (zeros(), zeros()),
            free_velocity: zeros(),
            impulse: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
        }
    }

    /// `a_n`.
    pub(crate) fn accelerate(&mut self, system: &System, state: &State) {
        accelerations(system, state.level(), &mut self.acceleration);
    }

    /// EEH (2): the means of velocities and accelerations over as many levels as are known.
    pub(crate) fn extrapolate(&mut self, state: &State, h: f64) {
        let (steps, k) = step_sizes(&self.history, h);
        let formula = LinearMultistep::adams_bashforth(&steps[..k]);
        let beta = &formula.beta()[..k];
        self.history.mean(VELOCITY, &state.v, beta, &mut self.lead);
        self.lead.iter_mut().zip(&state.v).for_each(|(lead, v)| *lead -= v);
        self.history.mean(ACCELERATION, &self.acceleration, beta, &mut self.mean_acceleration);
    }

    /// The same by Heun's method (the explicit trapezoidal rule), which needs no past.
    pub(crate) fn start(&mut self, system: &System, state: &State, h: f64) {
        let Self { acceleration: a, mean_acceleration: mean, predicted: (x, v), .. } = self;
        x.copy_from_slice(&state.x);
        drift(h, &state.v, x); // x̃ = x_n + h v_n
        v.copy_from_slice(&state.v);
        drift(h, a, v); // ṽ = v_n + h a_n
        accelerations(system, Level { t: state.t + h, x, v }, mean);
        for i in 0..state.len() {
            mean[i] = (mean[i] + a[i]) * 0.5;
            self.lead[i] = a[i] * (0.5 * h); // ½ (v_n + ṽ) − v_n
        }
    }

    /// `velocity` from `v_n`, pins and contacts: an impact is a jump of `v_n`. Contacts that would pull at the
    /// end of the step are released; what stays in contact has no lead along the normals.
    pub(crate) fn meet_obstacles(&mut self, system: &System, state: &State, h: f64) {
        let Self { contacts, constraints, free_velocity, velocity, impulse, .. } = self;
        contacts.detect(system, &state.x, &state.v, (h, state.t + h), constraints);
        free_velocity.copy_from_slice(&state.v);
        drift(h, &self.mean_acceleration, free_velocity);
        contacts.project(system, constraints, free_velocity, velocity, impulse);
        contacts.strike(system, constraints, &state.v, velocity);
        contacts.support(h, &mut self.lead);
        for pin in system.moving_pins() {
            self.lead[pin.particle] = Vec3::zeros();
        }
    }

    /// Ends the contacts and remembers `v_n`, `a_n`. A particle whose contact changed starts anew, with a past
    /// of constant acceleration.
    pub(crate) fn settle(&mut self, state: &mut State, h: f64) {
        let Self { contacts, velocity, acceleration: a, history, .. } = self;
        history.push(h, [velocity, a]);
        contacts.settle(velocity, |Change { particle: i, velocity: v, .. }| {
            history.rewrite(i, |age| [v - a[i] * (age - h), a[i]]);
        });
        state.v.copy_from_slice(velocity);
    }

    /// Forgets the past.
    pub(crate) fn restart(&mut self) {
        self.history.restart();
        self.contacts.restart();
    }
}
