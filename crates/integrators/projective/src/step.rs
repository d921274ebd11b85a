//! The step.

use crate::iteration::Minimiser;
use crate::settings::{PROJECTIVE, ProjectiveSettings};
use drape_integrator::{
    ContactSet, EnergyLedger, Implicit, Method, Phase, PhaseClock, PrepareError, Registration,
    Scheme, SolverKind, StepError, StepReport, Stepper, Taken,
};
use drape_model::{State, System, Vec3};
use drape_solvers::Constraints;

/// Projective dynamics.
pub type Projective = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&PROJECTIVE);

/// Memory of a step, and the kept factor.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) minimiser: Minimiser,
    /// Force of the explicit effects, N.
    frozen: Vec<Vec3>,
    /// The iterate `v`, m/s.
    pub(crate) velocity: Vec<Vec3>,
    /// Empty without obstacles.
    impulse: Vec<Vec3>,
    contacts: ContactSet,
    pub(crate) constraints: Constraints,
}

impl Scheme for Workspace {
    type Settings = ProjectiveSettings;

    fn method(_settings: &ProjectiveSettings) -> &'static Method {
        &PROJECTIVE
    }

    fn new(system: &System, settings: &ProjectiveSettings, h: f64) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            minimiser: Minimiser::new(system, settings, h)?,
            frozen: zeros(),
            velocity: zeros(),
            impulse: ContactSet::impulse(system),
            contacts: ContactSet::new(system),
            constraints: ContactSet::constraints(system),
        })
    }

    fn step(
        &mut self,
        settings: &ProjectiveSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let Self { minimiser, frozen, velocity: v, impulse, contacts, constraints } = self;
        clock.switch(Phase::MatrixSetup);
        // A = M + h² L_k + h L_c, (P2)
        let mut report = StepReport::after_setup(minimiser.refresh(system, h)?);
        clock.switch(Phase::Forces);
        frozen.fill(Vec3::zeros());
        Implicit::Springs.add_explicit_forces(system, state.level(), frozen);
        // Φ(v) = ½‖v − v̂‖²_M + U(x_n + h v) + ½ h vᵀ D v, v̂ = v_n + h M⁻¹ f_frozen, (P1)
        let from = (&state.x[..], &state.v[..]);
        minimiser.potential.begin(system, h, from, state.level(), frozen);
        clock.switch(Phase::Contact);
        let end = state.t + h;
        contacts.detect(system, &state.x, &state.v, (h, end), constraints);
        clock.switch(Phase::Solve);
        v.copy_from_slice(minimiser.potential.target()); // v⁰ = v̂
        contacts.solve(system, constraints, impulse, |constraints, wanted| {
            // v^{k+1} = v^k − A⁻¹ S ∇Φ(v^k), (P3), or an acceleration of it
            minimiser.minimise(settings, system, constraints, v, &mut report);
            wanted.fill(v, |impulse| {
                impulse.copy_from_slice(minimiser.potential.gradient(system, v)); // unfiltered
            });
            Ok::<(), StepError>(())
        })?;
        clock.switch(Phase::Update);
        report.force_evaluations += 1 + minimiser.potential.evaluations();
        state.v.copy_from_slice(v);
        state.x.copy_from_slice(minimiser.potential.positions(v)); // x_{n+1} = x_n + h v_{n+1}
        contacts.settle(&mut state.v, |_| ());
        state.t += h;
        Ok(report)
    }

    /// A step remembers no iterate of the one before.
    fn restart(&mut self) {
        self.contacts.restart();
    }

    fn ledger(&mut self, _: &ProjectiveSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        Some(self.energy_ledger(taken))
    }

    fn is_portable(settings: &ProjectiveSettings) -> bool {
        settings.solver == SolverKind::Cg
    }
}
