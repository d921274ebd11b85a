//! One implicit stage with pins and contacts, for backward Euler, BDF and the start of two-step
//! methods.

use crate::{
    ContactSet, Implicit, IncrementalPotential, Newton, NewtonLinear, NewtonSettings, Phase,
    PhaseClock, PrepareError, Safeguard, StepError, StepReport, Tau, settings,
};
use drape_model::{Level, System, Vec3};
use drape_solvers::Constraints;

settings! {
    /// When Newton's method stops, and how it solves its linear systems.
    pub struct StageSettings {
        /// residual at which Newton stops, relative to the change of velocity that the forces would
        /// make; never below round-off
        residual: f64 in 1e-16..=0.5 = 1e-9,
        /// most Newton iterations in a step
        max_iterations: u32 in 1..=10_000 = 100,
        /// whether Newton goes on after them where the step would gain energy
        safeguard: Safeguard as Safeguard::SETTING,
        /// how Newton solves its linear systems
        linear: NewtonLinear,
    }
}

/// The stage `M (v − v*) = τ_v f(x, v)`, `x = x* + τ_x v`. It is EEH (10), `x'' = M⁻¹ f(x, x')` as
/// a system of first order, for any implicit method. Newton's iteration has the `3n` unknowns of
/// section 2.3, since `x` follows from `v`.
///
/// With `τ = τ_x = τ_v`:
///
/// | method | `τ` | `x*` | `v*` |
/// |---|---|---|---|
/// | backward Euler | `h` | `x_n` | `v_n` |
/// | `k`-step BDF | `h β_k/α_k` | `−Σ_{j<k} α_j x_{n+j} / α_k` | likewise of `v` |
/// | Alexander's two stages, `γ = 1 − 1/√2`: first | `γ h` | `x_n` | `v_n` |
/// | then, with the solution `v₁` of the first | `γ h` | `x_n + (1 − γ) h v₁` | `v_n + (1 − γ)/γ (v₁ − v_n)` |
/// | implicit midpoint, whose `v` is `½ (v_n + v_{n+1})` | `½ h` | `x_n` | `v_n` |
#[doc(alias = "EEH 10")]
#[derive(Clone, Copy, Debug)]
pub struct Stage<'a> {
    /// `τ_x` and `τ_v`, s.
    pub tau: Tau,
    /// The time at the end of the stage, s.
    pub end: f64,
    /// The vectors `(x*, v*)`, m and m/s.
    pub from: (&'a [Vec3], &'a [Vec3]),
    /// Level of all parts that are not implicit: explicit forces, directions of projected damping,
    /// and coefficients of drag. A method of order `p` must choose it within `O(h^p)` of the new
    /// level.
    pub lagged: Level<'a>,
    /// Velocity at the start of the step, m/s. Contacts bounce with it, and Newton's method takes
    /// it as the first candidate for its start.
    pub velocity: &'a [Vec3],
}

/// Solves stages of one system by [`Newton`]; every effect with a Jacobian is implicit.
#[derive(Debug)]
pub struct ImplicitStage {
    potential: IncrementalPotential,
    newton: Newton,
    frozen: Vec<Vec3>,
    velocity: Vec<Vec3>,
    impulse: Vec<Vec3>,
}

impl ImplicitStage {
    /// Allocates memory and makes the symbolic factorisation, for solves by
    /// [factors](NewtonLinear::CHOLESKY).
    ///
    /// # Errors
    /// [`PrepareError::Solver`] if the symbolic factorisation fails.
    pub fn new(system: &System) -> Result<Self, PrepareError> {
        Self::with_linear(system, NewtonLinear::CHOLESKY)
    }

    /// As [`new`](Self::new), for these settings of the linear systems.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_linear(system: &System, linear: NewtonLinear) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let potential = IncrementalPotential::new(system, Implicit::Everything);
        let newton = Newton::new(system, &potential, linear)?;
        Ok(Self { potential, newton, frozen: zeros(), velocity: zeros(), impulse: zeros() })
    }

    /// Solves a stage. It detects contacts at `x*`. It starts from the candidate with the lowest
    /// potential: `stage.velocity`, `start` or the inertial target.
    ///
    /// # Errors
    /// As [`Newton::minimise`].
    #[expect(clippy::too_many_arguments, reason = "each is owned by the method that calls")]
    pub fn solve(
        &mut self,
        system: &System,
        stage: Stage<'_>,
        start: &[Vec3],
        contacts: &mut ContactSet,
        constraints: &mut Constraints,
        settings: StageSettings,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        clock.switch(Phase::Contact);
        let Stage { tau, end, from, velocity, .. } = stage;
        contacts.detect(system, from.0, velocity, (tau.x, end), constraints);
        let start = Some(start);
        self.solve_constrained(system, stage, start, contacts, constraints, settings, clock, report)
    }

    /// As [`solve`](Self::solve), but with contacts that are already detected. Without a `start` it
    /// starts from `stage.velocity`, whatever its potential.
    ///
    /// # Errors
    /// As [`Newton::minimise`].
    #[expect(clippy::too_many_arguments, reason = "each is owned by the method that calls")]
    pub fn solve_constrained(
        &mut self,
        system: &System,
        stage: Stage<'_>,
        start: Option<&[Vec3]>,
        contacts: &mut ContactSet,
        constraints: &mut Constraints,
        settings: StageSettings,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let Stage { tau, from, lagged, velocity: v_n, .. } = stage;
        let Self { potential, newton, frozen, velocity, impulse } = self;
        clock.switch(Phase::Forces);
        frozen.fill(Vec3::zeros());
        potential.implicit().add_explicit_forces(system, lagged, frozen);
        potential.begin(system, tau, from, lagged, frozen);
        clock.switch(Phase::Solve);
        let wanted = settings.residual * potential.scale();
        let settings = NewtonSettings {
            residual: wanted.max(potential.round_off()),
            max_iterations: settings.max_iterations,
            safeguard: settings.safeguard,
        };
        velocity.copy_from_slice(v_n);
        contacts.solve(system, constraints, impulse, |constraints, wanted| {
            match start {
                Some(start) if newton.is_auto() => {
                    potential.choose_start_by_residual(system, constraints, velocity, start);
                }
                Some(start) => {
                    potential.choose_start(system, constraints, velocity, &[start], true);
                }
                None => constraints.impose(velocity),
            }
            *report += newton.minimise(system, potential, constraints, velocity, &settings)?;
            wanted.fill(velocity, |impulse| {
                impulse.copy_from_slice(potential.gradient(system, velocity)); // ∇Φ, unfiltered
            });
            Ok::<(), StepError>(())
        })?;
        report.solve = potential.status(report.solve, report.relative_residual, wanted);
        report.relative_residual = potential.relative(report.relative_residual);
        report.force_evaluations += potential.evaluations();
        Ok(())
    }

    /// Forgets the saved factor, if there is one.
    pub fn restart(&mut self) {
        self.newton.restart();
    }

    /// Explicit force of the last stage, at `stage.lagged`, N.
    pub fn explicit_force(&self) -> &[Vec3] {
        &self.frozen
    }

    /// `v`, the solution of the last stage, m/s.
    pub fn velocity(&self) -> &[Vec3] {
        &self.velocity
    }

    /// `∇Φ` at the solution of the last stage, unfiltered, kg m/s: its residual and the impulse of
    /// its constraints.
    pub fn gradient(&mut self, system: &System) -> &[Vec3] {
        self.potential.gradient(system, &self.velocity)
    }

    /// Which effects are implicit.
    pub fn implicit(&self) -> Implicit {
        self.potential.implicit()
    }

    /// `x* + τ_x v` of the last stage, m.
    pub fn positions(&mut self) -> &[Vec3] {
        self.potential.positions(&self.velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SolveStatus;
    use crate::random::Lcg;
    use drape_model::parse;

    const TAU: f64 = 0.05;

    /// Three particles on three damped springs, the first one pinned, above a plane, under gravity.
    fn triangle(damping: &str) -> System {
        let spring = |i: u32, j: u32| {
            format!(
                r#"{{ "effect": "tension", "i": {i}, "j": {j}, "rest_length_m": 0.7,
                "stiffness_n_per_m": 40, "damping_n_s_per_m": 0.3 }}"#
            )
        };
        let text = format!(
            r#"{{ "format": "drape-system/1", "damping": "{damping}",
            "springs": [{}, {}, {}], "pins": [{{ "particle": 0 }}],
            "particles": {{ "mass_kg": [1, 0.25, 2],
                "position_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0]] }},
            "effects": {{ "gravity": {{ "m_s2": [0, 0, -9.81] }} }},
            "obstacles": [{{ "plane": {{ "point_m": [0, 0, -2], "normal": [0, 0, 1] }} }}] }}"#,
            spring(0, 1),
            spring(1, 2),
            spring(0, 2)
        );
        parse("triangle", &text).expect("valid").spec().build().expect("valid").0
    }

    fn vectors(random: &mut Lcg) -> [Vec3; 3] {
        [(); 3].map(|()| Vec3::from_fn(|_, _| random.signed()))
    }

    /// Four unrelated random levels: `x*`, `v*`, `x̂` and the velocity before.
    struct Levels([[Vec3; 3]; 4]);

    impl Levels {
        fn random(random: &mut Lcg) -> Self {
            Self([(); 4].map(|()| vectors(random)))
        }

        fn stage(&self) -> Stage<'_> {
            let [x, v, lagged, before] = &self.0;
            let lagged = Level { t: 0.0, x: lagged, v: before };
            Stage { tau: TAU.into(), end: TAU, from: (x, v), lagged, velocity: before }
        }
    }

    fn solved(
        system: &System,
        levels: &Levels,
        start: &[Vec3],
        settings: StageSettings,
    ) -> (ImplicitStage, StepReport) {
        let mut stage = ImplicitStage::new(system).expect("a pattern");
        let mut report = StepReport::default();
        let (mut contacts, mut constraints) = (ContactSet::new(system), Constraints::free(3));
        let mut clock = PhaseClock::off();
        let (contacts, constraints) = (&mut contacts, &mut constraints);
        let input = levels.stage();
        stage
            .solve(system, input, start, contacts, constraints, settings, &mut clock, &mut report)
            .expect("finite");
        (stage, report)
    }

    #[test]
    fn the_solution_satisfies_the_equation_of_the_stage() {
        let tight = StageSettings { residual: 1e-13, ..StageSettings::default() };
        let mut random = Lcg::new();
        for damping in ["full", "projected"] {
            let system = triangle(damping);
            for _ in 0..20 {
                let levels = Levels::random(&mut random);
                let [x_star, v_star, lagged, _] = &levels.0;
                let (mut stage, report) = solved(&system, &levels, &vectors(&mut random), tight);
                let (v, x) = (stage.velocity().to_vec(), stage.positions().to_vec());
                let mut force = [Vec3::zeros(); 3];
                for effect in system.effects() {
                    effect.add_force(system.mass(), &x, &mut force);
                    effect.add_damping_force(Level { t: 0.0, x: lagged, v: &v }, &mut force);
                }
                assert_eq!((x[0], v[0]), (x_star[0], Vec3::zeros()), "the pin");
                for i in 1..3 {
                    assert!((x[i] - (x_star[i] + v[i] * TAU)).norm() < 1e-15);
                    let wrong = (v[i] - v_star[i]) * system.mass()[i] - force[i] * TAU;
                    assert!(wrong.norm() < 1e-11, "{damping}, particle {i}: {wrong:?}");
                    let weight = Vec3::z() * (-9.81 * system.mass()[i]);
                    assert_eq!(stage.explicit_force()[i], weight);
                }
                assert_eq!(report.solve, SolveStatus::Converged);
                assert!(report.relative_residual > 0.0 && report.relative_residual < 1e-12);
            }
        }
    }

    #[test]
    fn the_best_of_the_candidates_starts_newton() {
        let (system, levels) = (triangle("full"), Levels::random(&mut Lcg::new()));
        let settings = StageSettings::default();
        let far = [Vec3::new(1e3, -1e3, 1e3); 3];
        let (far_off, slow) = solved(&system, &levels, &far, settings);
        let (at_the_end, fast) = solved(&system, &levels, far_off.velocity(), settings);
        assert!(slow.newton_iterations > 0 && fast.newton_iterations == 0, "{slow:?}, {fast:?}");
        assert_eq!(at_the_end.velocity()[1..], far_off.velocity()[1..]);
        // A bad candidate is as good as none.
        let (without, report) = solved(&system, &levels, levels.stage().velocity, settings);
        assert_eq!((without.velocity(), report), (far_off.velocity(), slow));
    }

    #[test]
    fn contacts_are_those_at_x_star_unless_they_were_detected_before() {
        let (system, settings) = (triangle("full"), StageSettings::default());
        let mut levels = Levels::random(&mut Lcg::new());
        (levels.0[0][1].z, levels.0[1][1].z) = (-2.01, -50.0); // inside, and on its way down
        let (mut stage, _) = solved(&system, &levels, &[Vec3::zeros(); 3], settings);
        assert!((stage.positions()[1].z + 2.0).abs() < 1e-12, "led to the surface");
        let velocity = stage.velocity()[1];
        let (mut none, mut constraints) = (ContactSet::default(), Constraints::free(3));
        let (mut clock, mut report) = (PhaseClock::off(), StepReport::default());
        let (start, clock) = (&[Vec3::zeros(); 3], &mut clock);
        let (none, constraints, report) = (&mut none, &mut constraints, &mut report);
        let input = levels.stage();
        stage
            .solve_constrained(
                &system,
                input,
                Some(start),
                none,
                constraints,
                settings,
                clock,
                report,
            )
            .expect("finite");
        assert!((stage.velocity()[1] - velocity).norm() > 0.1, "{:?}", stage.velocity()[1]);
        assert_ne!(stage.velocity()[0], Vec3::zeros(), "no constraint, no pin");
    }

    #[test]
    fn a_motion_that_drowns_in_round_off_is_not_called_converged() {
        for (stiffness, status) in [(1e9, SolveStatus::Converged), (1e16, SolveStatus::Stagnated)] {
            let text = format!(
                r#"{{ "format": "drape-system/1", "pins": [{{ "particle": 0 }}],
                "springs": [{{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1,
                    "stiffness_n_per_m": {stiffness} }}],
                "particles": {{ "mass_kg": [1, 1], "position_m": [[0, 0, 0], [0.6, 0, 0.8]] }},
                "effects": {{ "gravity": {{ "m_s2": [0, 0, -9.81] }} }} }}"#
            );
            let (system, state) =
                parse("rod", &text).expect("valid").spec().build().expect("valid");
            let (mut contacts, mut constraints) = (ContactSet::new(&system), Constraints::free(2));
            let (mut clock, mut report) = (PhaseClock::off(), StepReport::default());
            let input = Stage {
                tau: TAU.into(),
                end: TAU,
                from: (&state.x, &state.v),
                lagged: state.level(),
                velocity: &state.v,
            };
            let (contacts, constraints) = (&mut contacts, &mut constraints);
            let mut stage = ImplicitStage::new(&system).expect("a pattern");
            let settings = StageSettings::default();
            stage
                .solve(
                    &system,
                    input,
                    &state.v,
                    contacts,
                    constraints,
                    settings,
                    &mut clock,
                    &mut report,
                )
                .expect("finite");
            assert_eq!(report.solve, status, "{stiffness:e}: {report:?}");
        }
    }

    #[test]
    fn reports_add_up_over_stages() {
        let (system, levels) = (triangle("full"), Levels::random(&mut Lcg::new()));
        let settings = StageSettings::default();
        let start = [Vec3::zeros(); 3];
        let (mut stage, once) = solved(&system, &levels, &start, settings);
        let mut twice = once;
        let (mut contacts, mut constraints) = (ContactSet::new(&system), Constraints::free(3));
        let (contacts, constraints) = (&mut contacts, &mut constraints);
        let (mut clock, input) = (PhaseClock::off(), levels.stage());
        stage
            .solve(&system, input, &start, contacts, constraints, settings, &mut clock, &mut twice)
            .expect("finite");
        assert_eq!(twice.newton_iterations, 2 * once.newton_iterations);
        assert_eq!(twice.factorisations, 2 * once.factorisations);
        assert_eq!(twice.force_evaluations, 2 * once.force_evaluations);
        assert!(once.force_evaluations > once.newton_iterations && once.newton_iterations > 1);
    }

    #[test]
    fn the_iteration_limit_ends_newton_and_is_reported() {
        let (system, levels) = (triangle("full"), Levels::random(&mut Lcg::new()));
        let settings =
            StageSettings { residual: 1e-13, max_iterations: 1, ..StageSettings::default() };
        let (_, report) = solved(&system, &levels, &[Vec3::zeros(); 3], settings);
        assert_eq!((report.solve, report.newton_iterations), (SolveStatus::IterationLimit, 1));
        assert!(report.relative_residual > 1e-13);
    }
}
