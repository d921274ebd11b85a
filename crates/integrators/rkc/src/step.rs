//! The step.

use crate::coefficients::Coefficients;
use crate::division::Divider;
use crate::settings::{RKC, RkcSettings};
use drape_integrator::{
    ContactSet, Method, Phase, PhaseClock, PrepareError, Registration, Scheme, StepError,
    StepReport, Stepper, lead_pins,
};
use drape_model::{Level, State, System, Vec3};
use drape_solvers::Constraints;

/// Runge–Kutta–Chebyshev.
#[doc(alias = "RKC2")]
#[doc(alias = "Sommeijer-Shampine-Verwer 1998")]
pub type Rkc = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&RKC);

/// Memory of a step. `z_j = y_j − y_n` is kept in place of the stage `y_j = (x_j, v_j)`, so that a
/// motion that all particles share leaves no round-off.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) divider: Divider,
    pub(crate) coefficients: Coefficients,
    /// `z_{j−2}`, `z_{j−1}`.
    before: Displacement,
    last: Displacement,
    /// `y_{j−1}`.
    x: Vec<Vec3>,
    v: Vec<Vec3>,
    /// `M⁻¹ f` at `y_n` and at `y_{j−1}`.
    start: Vec<Vec3>,
    acceleration: Vec<Vec3>,
    ending: Ending,
}

#[derive(Debug)]
struct Displacement {
    x: Vec<Vec3>,
    v: Vec<Vec3>,
}

/// Memory of pins and contacts at the end of a substep.
#[derive(Debug)]
struct Ending {
    contacts: ContactSet,
    constraints: Constraints,
    impulse: Vec<Vec3>,
    velocity: Vec<Vec3>,
}

impl Scheme for Workspace {
    type Settings = RkcSettings;

    fn method(_settings: &RkcSettings) -> &'static Method {
        &RKC
    }

    fn new(system: &System, settings: &RkcSettings, _h: f64) -> Result<Self, PrepareError> {
        let mut divider = Divider::new(system);
        let is_stiff = system.effects().any(|effect| effect.has_jacobian() && !effect.is_drag());
        if is_stiff && !divider.is_damped(system) {
            let what = "springs without damping".to_owned();
            let key = "effects".to_owned();
            return Err(PrepareError::Unsupported { method: RKC.id, what, key });
        }
        let zeros = || vec![Vec3::zeros(); system.len()];
        let displacement = || Displacement { x: zeros(), v: zeros() };
        Ok(Self {
            divider,
            coefficients: Coefficients::new(settings.stages),
            before: displacement(),
            last: displacement(),
            x: zeros(),
            v: zeros(),
            start: zeros(),
            acceleration: zeros(),
            ending: Ending {
                contacts: ContactSet::new(system),
                constraints: Constraints::free(system.len()),
                impulse: zeros(),
                velocity: zeros(),
            },
        })
    }

    fn step(
        &mut self,
        settings: &RkcSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport::default();
        clock.switch(Phase::MatrixSetup);
        let Self { divider, coefficients, .. } = self;
        report.substeps =
            divider.divide(settings, system, &state.x, h, coefficients, &mut report)?;
        let (begin, end) = (state.t, state.t + h);
        let h = h / f64::from(report.substeps);
        for substep in 0..report.substeps {
            clock.switch(Phase::Forces);
            state.t = begin + f64::from(substep) * h;
            lead_pins(system, state.t, h, &state.x, &mut state.v);
            self.stages(system, state, h);
            report.force_evaluations += self.coefficients.count();
            clock.switch(Phase::Contact);
            self.end(system, state, h);
            clock.switch(Phase::Update);
        }
        state.t = end;
        Ok(report)
    }

    fn restart(&mut self) {
        self.divider.restart();
        self.ending.contacts.restart();
    }

    fn is_portable(_settings: &RkcSettings) -> bool {
        true
    }
}

impl Workspace {
    /// All stages from `state`: `z_s` ends in `last`.
    fn stages(&mut self, system: &System, state: &State, h: f64) {
        let Self { coefficients, before, last, x, v, start, acceleration, .. } = self;
        accelerations(system, state.level(), start); // F_0 = (v_n, M⁻¹ f(y_n))
        for i in 0..state.len() {
            (before.x[i], before.v[i]) = (Vec3::zeros(), Vec3::zeros()); // z_0 = 0
            // z_1 = μ̃₁ h F_0, (R3)
            last.x[i] = state.v[i] * (coefficients.first * h);
            last.v[i] = start[i] * (coefficients.first * h);
        }
        for stage in &coefficients.stages {
            for i in 0..state.len() {
                (x[i], v[i]) = (state.x[i] + last.x[i], state.v[i] + last.v[i]);
            }
            let t = state.t + stage.time * h;
            accelerations(system, Level { t, x, v }, acceleration); // F_{j−1}
            let (mu, nu) = (stage.mu, stage.nu);
            let (ahead, back) = (stage.mu_tilde * h, stage.gamma_tilde * h);
            for i in 0..state.len() {
                // z_j = μ z_{j−1} + ν z_{j−2} + μ̃ h F_{j−1} + γ̃ h F_0, (R4)
                before.x[i] = last.x[i] * mu + before.x[i] * nu + v[i] * ahead + state.v[i] * back;
                before.v[i] =
                    last.v[i] * mu + before.v[i] * nu + acceleration[i] * ahead + start[i] * back;
            }
            std::mem::swap(before, last);
        }
    }

    /// Ends a substep at `y_n + z_s`, under pins and contacts. An impact is a jump of `v_n`; the
    /// rest of the motion is its lead over `h v_n`, of which a particle that stays in contact has
    /// none along the normals.
    fn end(&mut self, system: &System, state: &mut State, h: f64) {
        let Self { last, x: lead, v: free, ending, .. } = self;
        let Ending { contacts, constraints, impulse, velocity } = ending;
        let State { t, x, v } = state;
        *t += h;
        for i in 0..x.len() {
            free[i] = v[i] + last.v[i];
            lead[i] = last.x[i] / h - v[i];
        }
        contacts.detect(system, x, v, (h, *t), constraints);
        contacts.project(system, constraints, free, velocity, impulse);
        contacts.strike(system, constraints, v, velocity);
        contacts.support(h, lead);
        for i in 0..x.len() {
            x[i] += (velocity[i] + lead[i]) * h; // x_n + z_s where nothing touches
        }
        for pin in system.moving_pins() {
            x[pin.particle] = pin.position(*t);
        }
        contacts.settle(velocity, |_| ());
        for i in 0..x.len() {
            v[i] = velocity[i] + last.v[i]; // v_n + z_s where nothing touches
        }
        contacts.stop(v);
    }
}

/// `M⁻¹ f`, 0 where pinned, m/s².
fn accelerations(system: &System, at: Level<'_>, out: &mut [Vec3]) {
    system.forces(at, out);
    for (a, m) in out.iter_mut().zip(system.mass()) {
        *a /= *m;
    }
    system.clear_pinned(out);
}

#[cfg(test)]
mod tests;
