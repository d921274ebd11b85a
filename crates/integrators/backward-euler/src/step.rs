//! The step.

use crate::settings::{BACKWARD_EULER, BackwardEulerSettings};
use drape_integrator::{
    ContactSet, EnergyLedger, ImplicitStage, Method, Phase, PhaseClock, Predictor, PrepareError,
    Registration, Rewind, Scheme, Stage, StepError, StepReport, Stepper, Taken, each_particle,
};
use drape_model::{State, System, Vec3};
use drape_solvers::Constraints;
use drape_solvers::bands::bands;

/// Backward Euler with Newton's method.
pub type BackwardEuler = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::controlled::<Workspace>(&BACKWARD_EULER);

/// Memory of a step, and history.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) stage: ImplicitStage,
    extrapolated: Vec<Vec3>,
    predictor: Predictor,
    contacts: ContactSet,
    pub(crate) constraints: Constraints,
}

impl Scheme for Workspace {
    type Settings = BackwardEulerSettings;

    fn method(_settings: &BackwardEulerSettings) -> &'static Method {
        &BACKWARD_EULER
    }

    fn new(
        system: &System,
        settings: &BackwardEulerSettings,
        _h: f64,
    ) -> Result<Self, PrepareError> {
        Ok(Self {
            stage: ImplicitStage::with_linear(system, settings.stage.linear)?,
            extrapolated: vec![Vec3::zeros(); system.len()],
            predictor: Predictor::new(system.len()),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
        })
    }

    fn step(
        &mut self,
        settings: &BackwardEulerSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let Self { stage, extrapolated: start, predictor, contacts, constraints } = self;
        let mut report = StepReport::default();
        let bands = bands(system.threads(), system.len());
        predictor.extrapolate(&state.v, h, bands, start); // EEH (22)
        let from = (&state.x[..], &state.v[..]);
        let (end, lagged, how) = (state.t + h, state.level(), settings.stage);
        let input = Stage { tau: h.into(), end, from, lagged, velocity: &state.v };
        // M (v_{n+1} − v_n) = h f(x_n + h v_{n+1}, v_{n+1}), EEH (4), by the iteration (5)
        stage.solve(system, input, start, contacts, constraints, how, clock, &mut report)?;
        clock.switch(Phase::Update);
        predictor.remember(&state.v, h);
        let v = stage.velocity();
        each_particle(system, &mut state.v, |i| v[i]);
        let x = stage.positions();
        each_particle(system, &mut state.x, |i| x[i]); // x_{n+1} = x_n + h v_{n+1}, EEH (4)
        contacts.settle(&mut state.v, |c| predictor.forget(c.particle, c.velocity));
        state.t += h;
        Ok(report)
    }

    fn restart(&mut self) {
        self.predictor.restart();
        self.contacts.restart();
        self.stage.restart();
    }

    fn ledger(&mut self, _: &BackwardEulerSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        Some(self.energy_ledger(taken))
    }

    fn is_portable(settings: &BackwardEulerSettings) -> bool {
        settings.stage.linear.is_portable()
    }
}

impl Rewind for Workspace {
    type Past = Predictor;

    fn past(&mut self) -> (&mut Predictor, &mut ContactSet) {
        (&mut self.predictor, &mut self.contacts)
    }

    fn tolerance(settings: &BackwardEulerSettings) -> f64 {
        settings.tolerance
    }
}
