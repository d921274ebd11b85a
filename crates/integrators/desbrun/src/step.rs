//! The step.

use crate::settings::{DESBRUN, DesbrunSettings, Inverse, Torque};
use crate::torque::{correct, damping_force};
use drape_integrator::{
    ElongationLimit, EnergyLedger, Implicit, ImpulsiveContacts, LaplacianSolver, LinearSettings,
    Method, Phase, PhaseClock, PreconditionerKind, PrepareError, Registration, Scheme, StepError,
    StepReport, Stepper, Taken, ViscousImpulse, Weights, drift, kick,
};
use drape_model::{State, System, Vec3};

/// Desbrun, Schröder and Barr's precomputed inverse.
pub type Desbrun = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&DESBRUN);

/// Memory of a step, and the precomputed inverse.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) linear: LaplacianSolver,
    pub(crate) viscous: ViscousImpulse,
    /// `Δv = A⁻¹ h F̃ = h M⁻¹ F_filtered`, m/s.
    pub(crate) change: Vec<Vec3>,
    /// Damping force at level `n`, N: 0 throughout where nothing is damped.
    pub(crate) damping: Vec<Vec3>,
    elongation: Option<ElongationLimit>,
    pub(crate) contacts: ImpulsiveContacts,
}

impl Scheme for Workspace {
    type Settings = DesbrunSettings;

    fn method(_settings: &DesbrunSettings) -> &'static Method {
        &DESBRUN
    }

    fn new(system: &System, settings: &DesbrunSettings, h: f64) -> Result<Self, PrepareError> {
        let linear = LinearSettings::kept(1e-14, PreconditionerKind::None, settings.solver());
        let weights = Weights::StiffnessAndDamping;
        let zeros = || vec![Vec3::zeros(); system.len()];
        let elongation = || ElongationLimit::new(system, settings.elongation);
        Ok(Self {
            linear: LaplacianSolver::new(system, Implicit::Springs, weights, linear, h)?,
            viscous: ViscousImpulse::new(system.len()),
            change: zeros(),
            damping: zeros(),
            elongation: settings.inverse_dynamics.then(elongation),
            contacts: ImpulsiveContacts::new(system),
        })
    }

    fn step(
        &mut self,
        settings: &DesbrunSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let Self { linear, viscous, change, damping, elongation, contacts } = self;
        clock.switch(Phase::MatrixSetup);
        let mut report = StepReport::after_setup(linear.refresh(system, h)?); // A⁻¹, if out of date
        clock.switch(Phase::Forces);
        viscous.assemble(linear, system, state, h); // h F̃ = h (F(x_n) − h L_k v_n − L_c v_n), (D1)
        report.force_evaluations = 1;
        clock.switch(Phase::Solve);
        // Δv = A⁻¹ h F̃ = h M⁻¹ F_filtered, (D2)
        linear.apply_preconditioner(viscous.impulse(), change);
        report.matvecs = match settings.inverse {
            Inverse::Cholesky => 1,
            Inverse::Dense => 2,
        };
        let v = &mut contacts.free_velocity;
        v.copy_from_slice(&state.v);
        v.iter_mut().zip(&*change).for_each(|(v, change)| *v += change);
        if settings.torque == Torque::Consistent {
            damping_force(system, state.level(), damping);
        }
        correct(settings.torque, system, h, &state.x, change, damping, v); // + h M⁻¹ F_corr, (D3)
        // v_{n+1} = v_n + Δv + h M⁻¹ (F_corr + f_external), (D4)
        kick(system, h, viscous.external(), v);
        contacts.constrain(system, h, state, clock);
        drift(system, h, &state.v, &mut state.x); // x_{n+1} = x_n + h v_{n+1}, (D5)
        contacts.settle(h, state);
        if let Some(elongation) = elongation {
            let State { x, v, .. } = state;
            report.correction = elongation.correct(system, h, x, Some(v)); // v = (x_{n+1} − x_n)/h
            contacts.stop(v);
        }
        Ok(report)
    }

    fn restart(&mut self) {
        self.contacts.restart();
    }

    fn ledger(&mut self, settings: &DesbrunSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        Some(self.energy_ledger(settings, taken))
    }

    fn is_portable(_settings: &DesbrunSettings) -> bool {
        false
    }

    /// Each spring is shortened from where the one before left its ends.
    fn follows_springs(settings: &DesbrunSettings) -> bool {
        settings.inverse_dynamics
    }
}
