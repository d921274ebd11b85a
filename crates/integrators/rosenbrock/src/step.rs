//! The step.

use crate::linear_system::LinearSystem;
use crate::settings::{ROSENBROCK, RosenbrockSettings};
use crate::tableau::STAGES;
use drape_integrator::{
    Method, Phase, PhaseClock, PrepareError, Registration, Scheme, SetupCause, StepError,
    StepReport, Stepper, hold_pins,
};
use drape_model::{Level, State, System, Vec3};
use drape_solvers::Constraints;

/// A Rosenbrock method.
pub type Rosenbrock = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&ROSENBROCK);

/// Memory of a step.
#[derive(Debug)]
pub struct Workspace {
    linear: LinearSystem,
    /// `u^x_j` of the stages, m, and `u^v_j`, m/s.
    increments: Vec<[Vec<Vec3>; 2]>,
    /// Positions of a stage, m.
    x: Vec<Vec3>,
    /// Velocities of a stage, m/s.
    v: Vec<Vec3>,
    /// `r_x`, m/s.
    drift: Vec<Vec3>,
    /// `(1/h) Σ c_ij u^v_j`, m/s².
    carried: Vec<Vec3>,
    /// N.
    force: Vec<Vec3>,
    /// Right-hand side, kg m/s.
    b: Vec<Vec3>,
    constraints: Constraints,
    /// Why the next step sets the matrix up.
    cause: SetupCause,
}

impl Scheme for Workspace {
    type Settings = RosenbrockSettings;

    fn method(_settings: &RosenbrockSettings) -> &'static Method {
        &ROSENBROCK
    }

    fn new(system: &System, settings: &RosenbrockSettings, _h: f64) -> Result<Self, PrepareError> {
        let tableau = settings.tableau.tableau();
        if !tableau.is_w_method() {
            refuse_turning_damping(system)?;
        }
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            linear: LinearSystem::new(system, settings.jacobian)?,
            increments: (0..tableau.stages).map(|_| [zeros(), zeros()]).collect(),
            x: zeros(),
            v: zeros(),
            drift: zeros(),
            carried: zeros(),
            force: zeros(),
            b: zeros(),
            constraints: Constraints::free(system.len()),
            cause: SetupCause::First,
        })
    }

    #[doc(alias = "Rosenbrock 1963")]
    #[doc(alias = "linearly implicit Runge-Kutta")]
    fn step(
        &mut self,
        settings: &RosenbrockSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let tableau = settings.tableau.tableau();
        let tau = h * tableau.gamma; // τ = γh
        // The matrix holds for one step only.
        let cause = std::mem::replace(&mut self.cause, SetupCause::EveryStep);
        let mut report = StepReport::after_setup(Some(cause));
        clock.switch(Phase::MatrixSetup);
        self.constraints.clear();
        hold_pins(system, &mut self.constraints);
        // A = M + τ² K_n + τ D_n                                                             (3)
        self.linear.linearise(system, state, tau, &self.constraints, &mut report)?;
        for i in 0..tableau.stages {
            clock.switch(Phase::Forces);
            let (a, c) = (&tableau.a[i], &tableau.c[i]);
            self.combine(state, a, i); // x = x_n + Σ a_ij u^x_j,  v = v_n + Σ a_ij u^v_j       (2)
            self.carry(h, c, i); // r_x = v + (1/h) Σ c_ij u^x_j,  (1/h) Σ c_ij u^v_j          (2)
            let Self { linear, increments, x, v, drift, carried, force, b, constraints, .. } = self;
            if !tableau.repeats_forces(i) {
                let t = state.t + h * tableau.nodes[i];
                system.forces(Level { t, x, v }, force); // f(x, v)
                report.force_evaluations += 1;
            }
            linear.multiply_stiffness(system, &state.x, drift, b); // K_n r_x
            report.matvecs += 1;
            for (p, &m) in system.mass().iter().enumerate() {
                // b = τ [f(x, v) + (1/h) M Σ c_ij u^v_j − τ K_n r_x]                          (3)
                b[p] = (force[p] + carried[p] * m - b[p] * tau) * tau;
            }
            clock.switch(Phase::Solve);
            let [positions, velocities] = &mut increments[i];
            linear.solve(constraints, b, velocities, &mut report); // A u^v_i = b                (3)
            for ((u, velocity), drift) in positions.iter_mut().zip(&*velocities).zip(&*drift) {
                *u = (velocity + drift) * tau; // u^x_i = τ (u^v_i + r_x)                       (3)
            }
        }
        clock.switch(Phase::Update);
        // x_{n+1} = x_n + Σ m_i u^x_i,  v_{n+1} = v_n + Σ m_i u^v_i                           (4)
        self.combine(state, &tableau.m, tableau.stages);
        state.x.copy_from_slice(&self.x);
        state.v.copy_from_slice(&self.v);
        state.t += h;
        Ok(report)
    }

    fn restart(&mut self) {}

    fn is_portable(_settings: &RosenbrockSettings) -> bool {
        false
    }
}

impl Workspace {
    /// The level plus the weighted increments of the first `count` stages, in `x` and `v`.
    fn combine(&mut self, from: &State, weights: &[f64; STAGES], count: usize) {
        self.x.copy_from_slice(&from.x);
        self.v.copy_from_slice(&from.v);
        for ([positions, velocities], &weight) in self.increments[..count].iter().zip(weights) {
            if weight != 0.0 {
                self.x.iter_mut().zip(positions).for_each(|(x, u)| *x += u * weight);
                self.v.iter_mut().zip(velocities).for_each(|(v, u)| *v += u * weight);
            }
        }
    }

    /// The parts of `r_x` and `r_v` that do not come from forces.
    fn carry(&mut self, h: f64, weights: &[f64; STAGES], count: usize) {
        self.drift.copy_from_slice(&self.v);
        self.carried.fill(Vec3::zeros());
        for ([positions, velocities], &weight) in self.increments[..count].iter().zip(weights) {
            let weight = weight / h;
            if weight != 0.0 {
                self.drift.iter_mut().zip(positions).for_each(|(r, u)| *r += u * weight);
                self.carried.iter_mut().zip(velocities).for_each(|(r, u)| *r += u * weight);
            }
        }
    }
}

/// Refuses damping whose direction turns with the cloth: its derivative by the positions, which the
/// matrix leaves out, counts for the order of all but W-methods.
fn refuse_turning_damping(system: &System) -> Result<(), PrepareError> {
    for effect in system.effects().filter(|effect| effect.has_damping() && !effect.is_drag()) {
        let (what, key) = match effect.split() {
            Some(split) if !split.has_damping_remainder() => continue,
            Some(_) => ("projected damping".to_owned(), "damping".to_owned()),
            None => (format!("damping of {}", effect.name()), format!("effects.{}", effect.name())),
        };
        return Err(PrepareError::Unsupported { method: ROSENBROCK.id, what, key });
    }
    Ok(())
}
