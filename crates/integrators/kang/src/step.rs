//! The step.

use crate::settings::{KANG, KangSettings};
use crate::sweep::sweep;
use drape_integrator::{
    EnergyLedger, Implicit, ImpulsiveContacts, LaplacianSolver, LinearSettings, Method, Phase,
    PhaseClock, PreconditionerKind, PrepareError, Registration, Scheme, SolverKind, StepError,
    StepReport, Stepper, Taken, ViscousImpulse, Weights, drift, kick,
};
use drape_model::{State, System, Vec3};

/// Kang's neighbour-corrected sweep.
pub type Kang = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&KANG);

/// Memory of a step, and the cached matrix.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) linear: LaplacianSolver,
    /// Right-hand side `h F̃`, and the external force.
    pub(crate) viscous: ViscousImpulse,
    /// `Δv`, m/s.
    pub(crate) change: Vec<Vec3>,
    pub(crate) product: Vec<Vec3>,
    pub(crate) contacts: ImpulsiveContacts,
}

impl Scheme for Workspace {
    type Settings = KangSettings;

    fn method(_settings: &KangSettings) -> &'static Method {
        &KANG
    }

    fn new(system: &System, _settings: &KangSettings, h: f64) -> Result<Self, PrepareError> {
        // The method uses the matrix and its diagonal only; it solves nothing.
        let unused = LinearSettings::kept(0.5, PreconditionerKind::None, SolverKind::Cg);
        let weights = Weights::StiffnessAndDamping;
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            linear: LaplacianSolver::new(system, Implicit::Springs, weights, unused, h)?,
            viscous: ViscousImpulse::new(system.len()),
            change: zeros(),
            product: zeros(),
            contacts: ImpulsiveContacts::new(system),
        })
    }

    fn step(
        &mut self,
        settings: &KangSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let Self { linear, viscous, change, product, contacts } = self;
        let sweeps = settings.sweeps;
        clock.switch(Phase::MatrixSetup);
        // A = M + h² L_k + h L_c and its diagonal D
        let mut report = StepReport::after_setup(linear.refresh(system, h)?);
        clock.switch(Phase::Forces);
        viscous.assemble(linear, system, state, h); // h F̃ = h (F(x_n) − h L_k v_n − L_c v_n), (K1)
        clock.switch(Phase::Solve);
        let (a, b) = (linear.product(), viscous.impulse());
        // Δv*_i = h F̃_i / D_i, (K2); Δv_i = (h F̃_i + Σ_j (h² k_ij + h c_ij) Δv*_j) / D_i, (K3)
        report.relative_residual = sweep(a, b, system.pinned(), sweeps, product, change);
        report.force_evaluations = 1;
        report.matvecs = 1 + sweeps;
        for (i, free) in contacts.free_velocity.iter_mut().enumerate() {
            *free = state.v[i] + change[i];
        }
        // v_{n+1} = v_n + Δv + h M⁻¹ f_external, (K4)
        kick(system, h, viscous.external(), &mut contacts.free_velocity);
        contacts.constrain(system, h, state, clock);
        drift(system, h, &state.v, &mut state.x); // x_{n+1} = x_n + h v_{n+1}, (K5)
        contacts.settle(h, state);
        Ok(report)
    }

    fn restart(&mut self) {
        self.contacts.restart();
    }

    fn ledger(&mut self, _settings: &KangSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        Some(self.energy_ledger(taken))
    }

    fn is_portable(_settings: &KangSettings) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_oracle::Run;
    use drape_oracle::scenes::Sheet;

    #[test]
    fn costs_are_counted() {
        for sweeps in [1, 4] {
            let settings = KangSettings { sweeps };
            let mut run = Run::new(Box::new(Kang::new(settings)), Sheet::default().build(), 0.01);
            let report = run.step();
            assert_eq!((report.force_evaluations, report.matvecs), (1, 1 + sweeps));
        }
    }
}
