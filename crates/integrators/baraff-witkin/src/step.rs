//! The step.

use crate::linear_system::LinearSystem;
use crate::settings::{BARAFF_WITKIN, BaraffWitkinSettings, BlockSolver, Recovery};
use drape_integrator::{
    ContactSet, EnergyLedger, Method, Phase, PhaseClock, PrepareError, Registration, Scheme,
    SetupCause, StepError, StepReport, Stepper, Taken, Wanted,
};
use drape_model::{State, System, Vec3};
use drape_solvers::Constraints;
use drape_solvers::bands::{bands, in_bands};

/// Baraff and Witkin's implicit step.
pub type BaraffWitkin = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&BARAFF_WITKIN);

/// Memory of a step.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) linear: LinearSystem,
    /// `Δv`, m/s.
    pub(crate) change: Vec<Vec3>,
    /// `y`, m; all 0 where velocities lead particles out of obstacles.
    pub(crate) y: Vec<Vec3>,
    pub(crate) impulse: Vec<Vec3>,
    contacts: ContactSet,
    /// Constraints on `v`.
    pub(crate) constraints: Constraints,
    /// Constraints on `Δv`.
    changes: Constraints,
    /// Why the next step sets the matrix up.
    cause: SetupCause,
}

impl Scheme for Workspace {
    type Settings = BaraffWitkinSettings;

    fn method(_settings: &BaraffWitkinSettings) -> &'static Method {
        &BARAFF_WITKIN
    }

    fn new(
        system: &System,
        settings: &BaraffWitkinSettings,
        _h: f64,
    ) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            linear: LinearSystem::new(system, settings)?,
            change: zeros(),
            y: zeros(),
            impulse: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
            changes: Constraints::free(system.len()),
            cause: SetupCause::First,
        })
    }

    #[doc(alias = "Baraff-Witkin 6")]
    fn step(
        &mut self,
        settings: &BaraffWitkinSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let Self { linear, change, y, impulse, contacts, constraints, changes, cause } = self;
        // The matrix holds for one step only.
        let cause = std::mem::replace(cause, SetupCause::EveryStep);
        let mut report = StepReport::after_setup(Some(cause));
        clock.switch(Phase::Contact);
        let (x, v, span) = (&state.x, &state.v, (h, state.t + h));
        match settings.contact {
            // S and z
            Recovery::Velocity => contacts.detect(system, x, v, span, constraints),
            // S, z and y
            Recovery::Position => contacts.detect_altering(system, x, v, span, constraints, y),
        }
        report.correction = y.iter().fold(0.0, |largest, y| largest.max(y.norm()));
        clock.switch(Phase::MatrixSetup);
        linear.linearise(system, state, y, h); // A = M − h ∂f/∂v − h² ∂f/∂x, Baraff-Witkin (16)
        clock.switch(Phase::Forces);
        // b = h (f_n + h ∂f/∂x v_n + ∂f/∂x y), Baraff-Witkin (18)
        linear.set_right_hand_side(system, state, h, &mut report);
        clock.switch(Phase::Solve);
        contacts.solve(system, constraints, impulse, |constraints, wanted| {
            prescribe_changes(constraints, &state.v, changes);
            linear.solve(changes, change, &mut report)?; // S (b − A Δv) = 0, Baraff-Witkin (16)
            match wanted {
                Wanted::Nothing => {}
                // p = A Δv − b, Baraff-Witkin (17)
                Wanted::Impulse(out) => linear.constraint_impulse(change, out, &mut report),
                Wanted::Velocity(out) => {
                    for i in 0..out.len() {
                        out[i] = state.v[i] + change[i];
                    }
                }
            }
            Ok::<(), StepError>(())
        })?;
        clock.switch(Phase::Update);
        let bands = bands(system.threads(), state.len());
        let part = (&mut state.x[..], &mut state.v[..]);
        in_bands(bands, y.len(), part, &|band, (x, v): (&mut [Vec3], &mut [Vec3])| {
            let moves = change[band.clone()].iter().zip(&y[band]);
            for ((x, v), (change, y)) in x.iter_mut().zip(v).zip(moves) {
                *v += change; // v_{n+1} = v_n + Δv, Baraff-Witkin (6)
                *x += y;
                *x += *v * h; // x_{n+1} = x_n + h (v_n + Δv) + y, Baraff-Witkin (6)
            }
        });
        contacts.settle(&mut state.v, |_| ());
        state.t += h;
        Ok(report)
    }

    fn restart(&mut self) {
        self.contacts.restart();
        self.change.fill(Vec3::zeros());
    }

    fn ledger(
        &mut self,
        settings: &BaraffWitkinSettings,
        taken: &Taken<'_>,
    ) -> Option<EnergyLedger> {
        Some(self.energy_ledger(settings, taken))
    }

    fn is_portable(settings: &BaraffWitkinSettings) -> bool {
        match settings.solver {
            BlockSolver::Cg => true,
            BlockSolver::Direct => false,
        }
    }
}

/// Turns constraints on the new velocity into constraints on its change, Baraff and Witkin's `z`.
fn prescribe_changes(constraints: &Constraints, v: &[Vec3], changes: &mut Constraints) {
    changes.clear();
    for i in constraints.constrained().iter().map(|&i| i as usize) {
        changes.set(i, constraints.filter(i), constraints.prescribed(i) - v[i]);
    }
}

#[cfg(test)]
mod tests;
