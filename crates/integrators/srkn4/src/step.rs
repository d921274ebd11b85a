//! The step.

use crate::settings::{SRKN4, Srkn4Settings};
use drape_integrator::{
    DampingBound, KeptForce, Method, Phase, PhaseClock, PrepareError, Registration, Scheme,
    StabilityLimit, StepError, StepReport, Stepper, drift, is_damped, kick, write_damping_force,
};
use drape_model::{Level, State, System, Vec3};

/// The symplectic Runge–Kutta–Nyström method of order 4.
#[doc(alias = "Blanes-Moan")]
pub type Srkn4 = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&SRKN4);

const B1: f64 = 0.082_984_406_417_405_2;
const B2: f64 = 0.396_309_801_498_368;
const B3: f64 = -0.039_056_304_922_348_6;
const A1: f64 = 0.245_298_957_184_271;
const A2: f64 = 0.604_872_665_711_080;

/// `b_i`, (N3).
#[rustfmt::skip]
pub(crate) const KICKS: [f64; 7] = [B1, B2, B3, 1.0 - 2.0 * (B1 + B2 + B3), B3, B2, B1];
/// `a_i`, (N3).
pub(crate) const DRIFTS: [f64; 6] = [A1, A2, 0.5 - A1 - A2, 0.5 - A1 - A2, A2, A1];
/// Terms of the series of a damped kick.
pub(crate) const TERMS: u32 = 5;

/// `h√λ` at which the undamped method becomes unstable.
const REACH: f64 = 5.0269;
/// Greatest `hδ` of a substep of `step=auto` and `bound`.
const MOST_DAMPING: f64 = 8.0;

/// Memory of a step.
#[derive(Debug)]
pub struct Workspace {
    kept: KeptForce,
    /// `None` without damping.
    damping: Option<Damping>,
    /// `None` unless steps are divided.
    limit: Option<StabilityLimit>,
}

#[derive(Debug)]
struct Damping {
    /// `−D w`, N.
    force: Vec<Vec3>,
    /// Term `w` of the series, m/s.
    term: Vec<Vec3>,
    bound: DampingBound,
}

impl Scheme for Workspace {
    type Settings = Srkn4Settings;

    fn method(_settings: &Srkn4Settings) -> &'static Method {
        &SRKN4
    }

    fn new(system: &System, settings: &Srkn4Settings, _h: f64) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let damping =
            || Damping { force: zeros(), term: zeros(), bound: DampingBound::new(system) };
        Ok(Self {
            kept: KeptForce::new(system),
            damping: is_damped(system).then(damping),
            limit: settings.step.limit(system, &SRKN4)?,
        })
    }

    fn step(
        &mut self,
        settings: &Srkn4Settings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport::default();
        clock.switch(Phase::MatrixSetup);
        report.substeps = self.substeps(settings, system, &state.x, h, &mut report)?;
        let (end, h) = (state.t + h, h / f64::from(report.substeps));
        clock.switch(Phase::Forces);
        self.kept.begin(system, &state.x, &mut report); // F(x_n)
        for _ in 0..report.substeps {
            self.kick(system, KICKS[0] * h, state, &mut report); // b₁, (N1)
            for (a, b) in DRIFTS.into_iter().zip(KICKS.into_iter().skip(1)) {
                drift(system, a * h, &state.v, &mut state.x); // x ← x + a_i h v, (N2)
                self.kept.evaluate(system, &state.x, &mut report);
                self.kick(system, b * h, state, &mut report); // b_{i+1}, (N1)
            }
        }
        self.kept.keep(system, &state.x);
        state.t = end;
        Ok(report)
    }

    fn restart(&mut self) {
        self.kept.forget();
        if let Some(limit) = &mut self.limit {
            limit.restart();
        }
    }

    fn is_portable(_settings: &Srkn4Settings) -> bool {
        true
    }
}

impl Workspace {
    /// Solves `M v' = F(x) − D v` over `tau` seconds, which may be negative.
    fn kick(&mut self, system: &System, tau: f64, state: &mut State, report: &mut StepReport) {
        let force = self.kept.force();
        match &mut self.damping {
            None => kick(system, tau, force, &mut state.v), // v ← v + τ M⁻¹ F(x), (N1)
            Some(Damping { force: damping, term: w, .. }) => {
                write_damping_force(system, state.level(), damping, report); // −D v
                damping.iter_mut().zip(force).for_each(|(damping, force)| *damping += force);
                for q in 1..=TERMS {
                    w.fill(Vec3::zeros());
                    // w₁ = τ M⁻¹ (F(x) − D v), w_q = −τ/q M⁻¹ D w_{q−1}, (N4)
                    kick(system, tau / f64::from(q), damping, w);
                    system.clear_pinned(w);
                    drift(system, 1.0, w, &mut state.v); // v ← v + w_q, (N4)
                    if q < TERMS {
                        write_damping_force(
                            system,
                            Level { v: w, ..state.level() },
                            damping,
                            report,
                        );
                    }
                }
            }
        }
        system.clear_pinned(&mut state.v);
    }

    /// Number of equal substeps in `h` seconds.
    fn substeps(
        &mut self,
        settings: &Srkn4Settings,
        system: &System,
        x: &[Vec3],
        h: f64,
        report: &mut StepReport,
    ) -> Result<u32, StepError> {
        let Some(limit) = &mut self.limit else { return Ok(1) };
        let damping = self.damping.as_mut().map(|damping| damping.bound.evaluate(system));
        limit.substeps(system, x, h, report, |lambda| {
            let longest = settings.safety * REACH / lambda.sqrt();
            damping.map_or(longest, |damping| longest.min(MOST_DAMPING / damping))
        })
    }
}

#[cfg(test)]
mod tests;
