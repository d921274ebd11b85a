//! The steps of the two methods of order 1.

use crate::algorithm1::{Problem, as_printed};
use crate::right_hand_side::add_nonlinear_forces;
use crate::settings::{IMEX_EULER, IMEX_UPDATED, ImexEulerSettings, ImexUpdatedSettings};
use crate::workspace::Workspace;
use drape_integrator::{
    Adaptive, ContactSet, EnergyLedger, Integrator, LaplacianSolver, Method, Phase, PhaseClock,
    Predictor, PrepareError, Rewind, Scratch, Start, StepError, StepReport, TimeStep,
};
use drape_model::{State, System, Vec3};
use drape_solvers::StartValue;
use drape_solvers::bands::{bands, in_bands};
use drape_solvers::vector::axpy;

/// IMEX Euler, EEH (21).
#[derive(Debug)]
pub struct ImexEuler {
    settings: ImexEulerSettings,
    scratch: Scratch<Workspace>,
}

impl ImexEuler {
    /// The method with its settings.
    pub fn new(settings: ImexEulerSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }

    /// The method, under step size control where the settings ask for it.
    pub fn controlled(settings: ImexEulerSettings) -> Box<dyn Integrator> {
        Adaptive::boxed(Self::new(settings), settings.tolerance)
    }
}

/// IMEX Euler with updated CG, EEH Algorithm 1.
#[derive(Debug)]
pub struct ImexUpdated {
    settings: ImexUpdatedSettings,
    scratch: Scratch<Workspace>,
}

impl ImexUpdated {
    /// The method with its settings.
    pub fn new(settings: ImexUpdatedSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }

    /// The method, under step size control where the settings ask for it.
    pub fn controlled(settings: ImexUpdatedSettings) -> Box<dyn Integrator> {
        Adaptive::boxed(Self::new(settings), settings.tolerance)
    }
}

impl Workspace {
    /// The new velocity takes the place of the last one, which the predictor remembers, without a copy: only what contacts may
    /// still change is kept for the [ledger](Self::plain_ledger) as the step solved for it.
    fn change_places(&mut self, v: &mut Vec<Vec3>, h: f64) {
        self.predictor.take(v, h);
        std::mem::swap(v, &mut self.velocity);
        if !self.contacts.is_empty() {
            self.velocity.copy_from_slice(v);
        }
    }
}

/// `x_{n+1} = x_n + h v_{n+1}`, EEH (20), and the end of the contacts.
#[doc(alias = "EEH 20")]
fn advance(w: &mut Workspace, state: &mut State, h: f64, bands: usize) {
    let State { x, v, .. } = state;
    in_bands(bands, v.len(), &mut x[..], &|band, x: &mut [Vec3]| axpy(h, &v[band], x)); // EEH (20)
    w.contacts.settle(&mut state.v, |c| w.predictor.forget(c.particle, c.velocity));
    state.t += h;
}

impl Integrator for ImexEuler {
    fn method(&self) -> &'static Method {
        &IMEX_EULER
    }

    fn prepare(&mut self, system: &System, h: TimeStep) -> Result<(), PrepareError> {
        IMEX_EULER.check(system)?;
        self.scratch.set(system, Workspace::plain(system, &self.settings, h.seconds())?);
        Ok(())
    }

    #[doc(alias = "EEH 19")]
    fn step(
        &mut self,
        system: &System,
        state: &mut State,
        h: TimeStep,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let w = self.scratch.ready(system, state, h)?;
        let (h, bands) = (h.seconds(), bands(system.threads(), system.len()));
        clock.switch(Phase::MatrixSetup);
        let mut report = StepReport::after_setup(w.linear.refresh_at(system, h, &state.x)?); // A = M + h² L_k + h L_c
        clock.switch(Phase::Forces);
        w.rhs.assemble(system, state, h); // right-hand side of EEH (21)
        report.force_evaluations = 1 + u32::from(w.linear.slopes().is_some());
        if let Some(splitting) = &mut w.splitting {
            splitting.expect(system, self.settings.implicit, w.linear.slopes(), &state.x);
            report.force_evaluations += 1;
        }
        clock.switch(Phase::Contact);
        let end = state.t + h;
        w.contacts.detect(system, &state.x, &state.v, (h, end), &mut w.constraints);
        clock.switch(Phase::Solve);
        let Workspace { rhs, velocity: v, impulse, linear, contacts, constraints, .. } = w;
        let mut start = w.predictor.start(self.settings.start, &state.v, h); // EEH (22)
        contacts.solve(system, constraints, impulse, |constraints, wanted| {
            report += linear.solve_from(start, constraints, &rhs.b, v); // EEH (21)
            start = StartValue::Given; // other contacts: from the last solution
            wanted.fill(v, |impulse| {
                linear.constraint_impulse(&rhs.b, v, impulse);
                report.matvecs += 1;
            });
            Ok::<(), StepError>(())
        })?;
        clock.switch(Phase::Update);
        w.change_places(&mut state.v, h);
        advance(w, state, h, bands);
        clock.stop();
        Ok(report)
    }

    fn restart(&mut self, _state: &State) {
        if let Some(w) = self.scratch.get_mut() {
            w.restart();
        }
    }

    fn ledger(
        &mut self,
        system: &System,
        before: &State,
        after: &State,
        h: TimeStep,
    ) -> Option<EnergyLedger> {
        Some(self.scratch.get_mut()?.plain_ledger(system, before, after, h))
    }
}

impl Workspace {
    /// Puts the start value of updated CG into the velocity and begins the descent, if there is one.
    fn start(&mut self, system: &System, state: &State, h: f64, bands: usize, start: Start) {
        match start {
            Start::Last => self.velocity.copy_from_slice(&state.v),
            _ => self.predictor.extrapolate(&state.v, h, bands, &mut self.velocity), // EEH (22)
        }
        if let Some(descent) = &mut self.descent {
            descent.begin(system, state, h, &self.rhs.explicit_force);
        }
    }
}

impl Integrator for ImexUpdated {
    fn method(&self) -> &'static Method {
        &IMEX_UPDATED
    }

    fn prepare(&mut self, system: &System, h: TimeStep) -> Result<(), PrepareError> {
        IMEX_UPDATED.check(system)?;
        self.scratch.set(system, Workspace::updated(system, &self.settings, h.seconds())?);
        Ok(())
    }

    fn step(
        &mut self,
        system: &System,
        state: &mut State,
        h: TimeStep,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let w = self.scratch.ready(system, state, h)?;
        let (h, settings) = (h.seconds(), &self.settings);
        let bands = bands(system.threads(), system.len());
        clock.switch(Phase::MatrixSetup);
        let mut report = StepReport::after_setup(w.linear.refresh_at(system, h, &state.x)?); // A = M + h² L_k + h L_c
        clock.switch(Phase::Forces);
        w.rhs.freeze(system, state, h, w.linear.slopes()); // M v_n + h [F_frozen − L_k x_n]
        clock.switch(Phase::Contact);
        let end = state.t + h;
        w.contacts.detect(system, &state.x, &state.v, (h, end), &mut w.constraints);
        clock.switch(Phase::Solve);
        w.start(system, state, h, bands, settings.start);
        let Workspace { rhs, velocity: v, impulse, linear, contacts, constraints, descent, .. } = w;
        contacts.solve(system, constraints, impulse, |constraints, wanted| {
            let problem = Problem { system, state, h, constraints, settings };
            if let Some(descent) = descent.as_mut() {
                if settings.start == Start::Best {
                    descent.choose(problem, v, &state.v);
                }
                descent.minimise(problem, rhs, linear, v, &mut report)?;
                wanted.fill(v, |impulse| impulse.copy_from_slice(descent.gradient(system, v)));
            } else {
                as_printed(problem, rhs, linear, v, &mut report);
                wanted.fill(v, |impulse| {
                    linear.constraint_impulse(&rhs.b, v, impulse);
                    report.matvecs += 1;
                });
            }
            Ok::<(), StepError>(())
        })?;
        clock.switch(Phase::Update);
        let descent = w.descent.as_ref().map_or(0, |descent| descent.evaluations());
        let slopes = u32::from(w.linear.slopes().is_some());
        report.force_evaluations += 2 + report.outer_passes + descent + slopes;
        w.predictor.take(&mut state.v, h);
        state.v.copy_from_slice(&w.velocity); // the ledger asks for it
        advance(w, state, h, bands);
        clock.stop();
        Ok(report)
    }

    fn restart(&mut self, _state: &State) {
        if let Some(w) = self.scratch.get_mut() {
            w.restart();
        }
    }

    fn ledger(
        &mut self,
        system: &System,
        before: &State,
        after: &State,
        h: TimeStep,
    ) -> Option<EnergyLedger> {
        Some(self.scratch.get_mut()?.updated_ledger(system, before, after, h))
    }
}

/// History of both methods.
type Past = (Predictor, ContactSet);

impl Workspace {
    fn past(&self) -> Past {
        (self.predictor.clone(), self.contacts.clone())
    }

    fn keep(&self, (predictor, contacts): &mut Past) {
        predictor.copy_from(&self.predictor);
        contacts.copy_from(&self.contacts);
    }

    fn recall(&mut self, (predictor, contacts): &Past) {
        self.predictor.copy_from(predictor);
        self.contacts.copy_from(contacts);
    }
}

impl Rewind for ImexEuler {
    type Past = Past;

    fn new_past(&self) -> Option<Past> {
        self.scratch.get().map(Workspace::past)
    }

    fn keep(&self, past: &mut Past) {
        self.scratch.get().into_iter().for_each(|w| w.keep(past));
    }

    fn recall(&mut self, past: &Past) {
        self.scratch.get_mut().into_iter().for_each(|w| w.recall(past));
    }

    fn contacts(&self) -> Option<&ContactSet> {
        self.scratch.get().map(|w| &w.contacts)
    }

    fn add_splitting_error(
        &mut self,
        system: &System,
        to: &State,
        h: f64,
        error: &mut [Vec3],
        report: &mut StepReport,
    ) {
        let Some(w) = self.scratch.get_mut() else { return };
        let Workspace { splitting: Some(splitting), linear, constraints, .. } = w else { return };
        let implicit = self.settings.implicit;
        let force = |linear: &LaplacianSolver, out: &mut [Vec3]| {
            add_nonlinear_forces(implicit, linear.slopes(), system, &to.x, out);
        };
        splitting.add(system, force, h, linear, constraints, error, report);
    }
}

impl Rewind for ImexUpdated {
    type Past = Past;

    fn new_past(&self) -> Option<Past> {
        self.scratch.get().map(Workspace::past)
    }

    fn keep(&self, past: &mut Past) {
        self.scratch.get().into_iter().for_each(|w| w.keep(past));
    }

    fn recall(&mut self, past: &Past) {
        self.scratch.get_mut().into_iter().for_each(|w| w.recall(past));
    }

    fn contacts(&self) -> Option<&ContactSet> {
        self.scratch.get().map(|w| &w.contacts)
    }
}
