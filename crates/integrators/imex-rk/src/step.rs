//! The step.

use crate::settings::{IMEX_RK, ImexRkSettings};
use crate::stages::Stages;
use drape_integrator::{
    ContactSet, Implicit, LaplacianSolver, Method, Phase, PhaseClock, PrepareError, Registration,
    Scheme, SolverKind, StepError, StepReference, StepReport, StepStart, Stepper, Weights, drift,
    hold_pins,
};
use drape_model::{Level, State, System, Vec3};
use drape_solvers::{Constraints, StartValue};

/// An additive Runge–Kutta method on the split of the springs' force.
pub type ImexRk = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&IMEX_RK);

/// Memory of a step.
#[derive(Debug)]
pub struct Workspace {
    linear: LaplacianSolver,
    reference: StepReference,
    stages: Stages,
    /// `X*` of a stage, then its positions `x_i`, m.
    position: Vec<Vec3>,
    /// Velocities `v_i` of a stage, m/s; the start value of the next one.
    velocity: Vec<Vec3>,
    /// `V*` of a stage, m/s.
    start: Vec<Vec3>,
    /// Right-hand side, kg m/s.
    b: Vec<Vec3>,
    /// No contacts; the stop test of the linear solve asks for them.
    contacts: ContactSet,
    constraints: Constraints,
}

impl Scheme for Workspace {
    type Settings = ImexRkSettings;

    fn method(_settings: &ImexRkSettings) -> &'static Method {
        &IMEX_RK
    }

    fn new(system: &System, settings: &ImexRkSettings, h: f64) -> Result<Self, PrepareError> {
        let tableau = settings.tableau.tableau();
        let (implicit, weights) = (settings.implicit, Weights::StiffnessAndDamping);
        let tau = h * tableau.gamma();
        let linear = LaplacianSolver::new(system, implicit, weights, settings.linear(), tau)?;
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            reference: StepReference::new(system, &linear),
            linear,
            stages: Stages::new(system.len(), tableau.stages),
            position: zeros(),
            velocity: zeros(),
            start: zeros(),
            b: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
        })
    }

    #[doc(alias = "additive Runge-Kutta")]
    #[doc(alias = "Ascher-Ruuth-Spiteri 1997")]
    #[doc(alias = "Kennedy-Carpenter 2003")]
    fn step(
        &mut self,
        settings: &ImexRkSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let (tableau, implicit) = (settings.tableau.tableau(), settings.implicit);
        let tau = h * tableau.gamma(); // τ = γh, one matrix for all stages
        clock.switch(Phase::MatrixSetup);
        // M + τ² L_k + τ L_d, (3)
        let mut report = StepReport::after_setup(self.linear.refresh(system, tau)?);
        self.constraints.clear();
        hold_pins(system, &mut self.constraints);
        self.velocity.copy_from_slice(&state.v);
        for i in 0..tableau.stages {
            clock.switch(Phase::Forces);
            let Self { stages, position, velocity, start, .. } = self;
            // X* = x_n + h Σ_{j<i} a^I_ij v_j,  V* = v_n + h Σ_{j<i} (a^I_ij g_j + a^E_ij e_j)
            // (2)
            let row = (&tableau.implicit[i], &tableau.explicit[i]);
            stages.combine(state, h, row, i, position, start);
            if i == 0 {
                velocity.copy_from_slice(start);
                if tableau.takes_first_slope() || !self.linear.is_direct() {
                    stages.set_first_slope(system, implicit, state.level());
                    report.force_evaluations += 1;
                }
            } else {
                self.write_right_hand_side(system, implicit, tau); // b = M V* − τ L_k X*          (3)
                report.force_evaluations += 1;
                clock.switch(Phase::Solve);
                self.solve(system, state, tau, &mut report); // (M + τ² L_k + τ L_d) v_i = b       (3)
                drift(system, tau, &self.velocity, &mut self.position); // x_i = X* + τ v_i               (3)
            }
            clock.switch(Phase::Forces);
            let Self { stages, position: x, velocity: v, start, .. } = self;
            if i > 0 {
                stages.set_slope(i, tau, v, start); // g_i = (v_i − V*)/τ                          (4)
            }
            stages.set_velocity(i, v);
            if tableau.takes_force(i) {
                let at = Level { t: state.t + h * tableau.nodes[i], x, v };
                stages.set_force(i, system, implicit, at); // e_i = M⁻¹ (F2 + F_explicit)(x_i, v_i) (4)
                report.force_evaluations += 1;
            }
        }
        clock.switch(Phase::Update);
        // x_{n+1} = x_s,  v_{n+1} = v_s + h Σ (b^E_i − a^E_si) e_i
        // (5)
        self.stages.finish(h, &tableau.corrections(), &mut self.velocity);
        state.x.copy_from_slice(&self.position);
        state.v.copy_from_slice(&self.velocity);
        state.t += h;
        Ok(report)
    }

    fn restart(&mut self) {}

    fn is_portable(settings: &ImexRkSettings) -> bool {
        settings.solver == SolverKind::Cg
    }
}

impl Workspace {
    /// `b = M V* − τ L_k X*`.
    fn write_right_hand_side(&mut self, system: &System, implicit: Implicit, tau: f64) {
        let Self { position, start, b, .. } = self;
        b.fill(Vec3::zeros());
        implicit.add_linear_spring_forces(system, position, b); // −L_k X*
        for ((b, v), &m) in b.iter_mut().zip(&*start).zip(system.mass()) {
            *b = v * m + *b * tau;
        }
    }

    /// Solves for the velocities of a stage, from those of the stage before. The stop test refers
    /// to the change of velocity that the forces at the start of the step make in `τ`.
    fn solve(&mut self, system: &System, state: &State, tau: f64, report: &mut StepReport) {
        let Self { linear, reference, stages, contacts, constraints, .. } = self;
        let impulse = |i: usize| stages.first_acceleration(i) * (system.mass()[i] * tau);
        let begin = StepStart { system, state, tau, rounds_positions: true };
        let reference = reference.of(begin, linear, contacts, constraints, impulse);
        let (b, velocity) = (&self.b, &mut self.velocity);
        *report += linear.solve_from(StartValue::Given, constraints, b, velocity, reference);
    }
}
