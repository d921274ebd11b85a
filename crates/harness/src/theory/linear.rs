//! Linear stability of a method on a case.
//!
//! With frozen tangents, `M x'' = −K x − C x'`, a method with constant coefficients has solutions
//! `ζⁿ u` with `P(ζ) u = 0`, where `P` is a polynomial of matrices. For real `ζ → −∞`, `P(ζ)` is
//! positive definite. If `P(−1)` is not, some root lies beyond, `ζ < −1`, and the step is unstable.
//! The tangent of a spring never exceeds its stiffness, `K ≤ L_k`. So if `P(−1)` is positive
//! definite with `L_k` in place of `K`, it is positive definite at every state.
//!
//! A one-step method that takes `L_I` and `C_I` at the new level and the rest at the old one obeys
//! `(M + h² L_I + h C_I)(x_{n+1} − x_n) = (M − h C_E)(x_n − x_{n−1}) − h² K x_n`, hence
//! `P(−1) = 4M + 2h² L_I + 2h C_I − 2h C_E − h² K`, and roots leave the unit circle only there. For
//! a two-step method let `A`, `B`, `C` be the polynomials of its coefficients `a`, `b` (implicit)
//! and `c` (explicit) at −1. Then
//! `P(−1) = A² M + h² B² L_I + h² B C (K − L_I) + h A B C_I + h A C C_E`.

use crate::methods::Choice;
use crate::run::Simulation;
use crate::schedule::Schedule;
use drape_integrator::{Implicit, LargestEigenvalue, hold_pins};
use drape_model::{BlockSink, Effect, Level, Mat3, SpringEffect, System, Tangent, Vec3};
use drape_solvers::{BlockFactor, BlockMatrix, Constraints, FactorKind};

/// Instability is predicted beyond this factor of the limit. Closer to the limit, growth is slow.
const MARGIN: f64 = 1.01;
/// Growth of the fastest mode over the run that is certainly visible.
const VISIBLE: f64 = 1e6;
/// Least factor of the masses. Without the masses, `P(−1)` would only be semi-definite on motions
/// that stretch no spring.
const LEAST_MASS: f64 = 1e-6;
/// Matrix products for the largest eigenvalue.
const PRODUCTS: usize = 100;

/// A method on a case.
pub(crate) struct Problem<'a> {
    pub(crate) schedule: &'a Schedule,
    /// Whether the start is an equilibrium.
    pub(crate) is_at_rest: bool,
    pub(crate) choice: &'a Choice,
    /// The unperturbed start.
    pub(crate) simulation: &'a Simulation,
}

/// Factors of an effect's matrices in `P(−1)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Weights {
    /// Factor of `h²` times the tangent stiffness `K`.
    pub(crate) tangent: f64,
    /// Factor of `h²` times the Laplacian `L_k` of the stiffness.
    pub(crate) laplacian: f64,
    /// Factor of `h²` times the Laplacian of the secant stiffness `k (1 − ℓ/L)`.
    pub(crate) secant: f64,
    /// Factor of `h` times the damping.
    pub(crate) damping: f64,
}

impl Weights {
    pub(crate) const NONE: Self = Self { tangent: 0.0, laplacian: 0.0, secant: 0.0, damping: 0.0 };
}

/// The factors in `P(−1)` of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Factors {
    /// Factor of the masses.
    pub(crate) mass: f64,
    /// Factors of the implicit springs.
    pub(crate) implicit: Weights,
    /// Factors of the explicit springs.
    pub(crate) explicit: Weights,
}

impl Factors {
    /// The factors of the one-step method that takes implicit springs with their whole Laplacian at
    /// the new level.
    pub(crate) const ONE_STEP: Self = Self {
        mass: 4.0,
        implicit: Weights { tangent: -1.0, laplacian: 2.0, damping: 2.0, ..Weights::NONE },
        explicit: Weights { tangent: -1.0, damping: -2.0, ..Weights::NONE },
    };

    /// The factors of the two-step method whose polynomials have these values at −1.
    pub(crate) const fn two_step(a: f64, b: f64, c: f64) -> Self {
        let tangent = b * c;
        let implicit =
            Weights { tangent, laplacian: b * b - b * c, damping: a * b, ..Weights::NONE };
        let explicit = Weights { tangent, damping: a * c, ..Weights::NONE };
        Self { mass: a * a, implicit, explicit }
    }
}

/// The result of the linear analysis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Linear {
    /// No root leaves through −1, whatever the state.
    Everywhere,
    /// A root has left at the start.
    Nowhere,
    /// No root has left at the start, but a root may leave at another state.
    Somewhere,
}

impl Problem<'_> {
    pub(crate) fn system(&self) -> &System {
        &self.simulation.system
    }

    pub(crate) fn is_damped(&self) -> bool {
        self.system().effects().any(Effect::has_damping)
    }

    pub(crate) fn has_contacts(&self) -> bool {
        !self.system().obstacles().is_empty()
    }

    pub(crate) fn has_moving_springs(&self) -> bool {
        let pinned = self.system().pinned();
        let mut moving = false;
        Implicit::Springs.visit_weights(self.system(), &mut |i, j, _, _| {
            moving |= !(pinned[i] && pinned[j]);
        });
        moving
    }

    /// Whether all springs are among the implicit ones.
    pub(crate) fn are_all(&self, implicit: Implicit) -> bool {
        self.system().effects().all(|e| e.split().is_none() || implicit.selects(e))
    }

    /// Least and greatest step, s.
    pub(crate) fn steps(&self) -> (f64, f64) {
        let schedule = self.schedule;
        let of = |pick: fn(f64, f64) -> f64| schedule.pattern.iter().copied().reduce(pick);
        let h = schedule.time.step_s;
        (h * of(f64::min).unwrap_or(1.0), h * of(f64::max).unwrap_or(1.0))
    }

    /// The system at its greatest stiffness.
    fn stiffest(&self) -> System {
        let mut system = self.system().clone();
        let factor = self.schedule.greatest_stiffness();
        for effect in SpringEffect::ALL {
            // An effect that the scene does not name has nothing to change.
            let _named = system.scale_stiffness(effect, factor);
        }
        system
    }

    /// A lower bound of `hδ` of the drag at the start, by Rayleigh's quotient, if the method takes
    /// drag at the old velocity. A method that divides its steps divides them by the stiffness
    /// alone.
    pub(crate) fn explicit_drag(&self) -> Option<f64> {
        let (system, settings) = (self.system(), self.choice.settings());
        let method = self.choice.method();
        let is_explicit =
            |effect: &&dyn Effect| effect.is_drag() && method.is_explicit(*effect, settings);
        let state = &self.simulation.state;
        let mut force = vec![Vec3::zeros(); system.len()];
        for effect in system.effects().filter(is_explicit) {
            effect.add_damping_force(state.level(), &mut force);
        }
        let power: f64 = force.iter().zip(&state.v).map(|(f, v)| -f.dot(v)).sum();
        let doubled: f64 =
            system.mass().iter().zip(&state.v).map(|(m, v)| m * v.norm_squared()).sum();
        let (h, _) = self.steps();
        let divides = self.choice.theory().divides && settings.word("step") != "fixed";
        let most_parts = if divides {
            let limit = 2.0 * settings.number("safety") / self.bounds().0.sqrt();
            (h / limit).ceil().max(1.0)
        } else {
            // Some methods divide every step into a given number of parts.
            settings.get("substeps").map_or(1.0, |_| settings.number("substeps"))
        };
        (power > 0.0).then(|| h / most_parts * power / doubled)
    }

    /// Bounds of the eigenvalues of `M⁻¹L_k` (1/s²) and `M⁻¹L_c` (1/s) by Gershgorin.
    pub(crate) fn bounds(&self) -> (f64, f64) {
        crate::stability::gershgorin(&self.stiffest())
    }

    /// Analyses a method that takes the springs of `implicit` at the new level; `None`: no springs.
    pub(crate) fn analyse(&self, implicit: Option<Implicit>, factors: &Factors) -> Linear {
        let (least, greatest) = self.steps();
        let of = |effect: &dyn Effect| match implicit {
            Some(implicit) if implicit.selects(effect) => factors.implicit,
            _ => factors.explicit,
        };
        let system = self.stiffest();
        let is_definite = |h: f64, weights: &dyn Fn(&dyn Effect) -> Weights| {
            is_definite(&system, &self.simulation.state.x, h, factors.mass, weights)
        };
        // A secant stiffness has no lower bound, nor does a tangent with a positive factor.
        let is_bounded = |w: Weights| w.tangent <= 0.0 && w.secant == 0.0;
        let at_every_state = |effect: &dyn Effect| {
            let w = of(effect);
            Weights { tangent: 0.0, laplacian: w.laplacian + w.tangent, ..w }
        };
        let at_the_start = |effect: &dyn Effect| {
            let w = of(effect);
            let tangent = if w.tangent < 0.0 { w.tangent / MARGIN } else { w.tangent };
            Weights { tangent, ..w }
        };
        let all_bounded = is_bounded(factors.implicit) && is_bounded(factors.explicit);
        if all_bounded && is_definite(greatest, &at_every_state) {
            Linear::Everywhere
        } else if is_definite(least, &at_the_start) {
            Linear::Somewhere
        } else {
            Linear::Nowhere
        }
    }

    /// A lower bound of `θ = h²λ` of the stiffest mode at the start. `None` unless that mode grows
    /// visibly over the run with any share of the damping. `step(θ, η, state)` is the method's
    /// recurrence on the oscillator `x'' = −κx − δx'`; the state begins with `x` and `w = hv`.
    pub(crate) fn growing(&self, step: impl Fn(f64, f64, &mut [f64; 4])) -> Option<f64> {
        let system = self.stiffest();
        let (h, _) = self.steps();
        let x = &self.simulation.state.x;
        let theta = h * h * LargestEigenvalue::new(&system).estimate(&system, x, PRODUCTS);
        let eta = h * self.bounds().1;
        let growth = |eta: f64| {
            let mut state = [1.0, 0.5, 0.5, 0.0];
            for _ in 0..self.schedule.steps() {
                step(theta, eta, &mut state);
                if state.iter().any(|value| value.abs() > VISIBLE) {
                    return true;
                }
            }
            false
        };
        (0..=4).all(|part| growth(0.25 * f64::from(part) * eta)).then_some(theta)
    }
}

struct Sink<'a>(&'a mut BlockMatrix);

impl BlockSink for Sink<'_> {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.0.add_pair(i, j, block);
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.0.add_general_pair(i, j, block);
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.0.add_diagonal(i, block);
    }
}

/// Whether `mass M` plus the weighted matrices of all springs is positive definite on the free
/// particles.
fn is_definite(
    system: &System,
    x: &[Vec3],
    h: f64,
    mass: f64,
    weights: &dyn Fn(&dyn Effect) -> Weights,
) -> bool {
    let mut pairs = Vec::new();
    for effect in system.effects() {
        effect.visit_pairs(&mut |i, j| pairs.push((i, j)));
    }
    let mut matrix = BlockMatrix::with_pattern(system.len(), pairs);
    for (i, m) in system.mass().iter().enumerate() {
        matrix.add_diagonal(i, &Mat3::from_diagonal_element(mass.max(LEAST_MASS) * m));
    }
    let (h2, rest) = (h * h, vec![Vec3::zeros(); system.len()]);
    for effect in system.effects() {
        let Weights { tangent, laplacian, secant, damping } = weights(effect);
        let mut sink = Sink(&mut matrix);
        effect.add_stiffness(x, h2 * tangent, Tangent::Exact, &mut sink);
        let at_rest = Level { t: 0.0, x, v: &rest };
        effect.add_damping(at_rest, h * damping, &mut sink);
        if let Some(split) = effect.split() {
            split.visit_weights(&mut |i, j, k, _| {
                sink.add_pair(i, j, &Mat3::from_diagonal_element(h2 * laplacian * k));
            });
            split.visit_secants(x, &mut |i, j, k| {
                sink.add_pair(i, j, &Mat3::from_diagonal_element(h2 * secant * k));
            });
        }
    }
    let mut constraints = Constraints::free(system.len());
    hold_pins(system, &mut constraints);
    matrix.project(&constraints);
    BlockFactor::new(&matrix, FactorKind::Cholesky)
        .is_ok_and(|mut factor| factor.factorise(&matrix).is_ok())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use drape_model::{AirSpec, DragSpec, SystemSpec, TimeSpan};
    use drape_oracle::scenes::{anchored, build, particles, tension};

    /// What `ask` says of a method on a system in steps of `step_s` seconds.
    fn ask<T>(spec: &SystemSpec, method: &str, step_s: f64, ask: impl Fn(&Problem<'_>) -> T) -> T {
        let (system, state) = build(spec);
        ask(&Problem {
            schedule: &Schedule::steady(TimeSpan { step_s, duration_s: 100.0 * step_s }),
            is_at_rest: false,
            choice: &Choice::parse(method, &[]).unwrap(),
            simulation: &Simulation { system, state },
        })
    }

    /// An oscillator, on which an explicit step is stable for `h²k/m ≤ 4`.
    #[test]
    fn instability_is_foreseen_only_beyond_the_margin() {
        let springs = [(SpringEffect::Tension, 1.0, 1.0, 0.0)];
        let spec = anchored(1.0, &springs, Vec3::x(), Vec3::zeros());
        for (theta, expected) in [
            (3.99, Linear::Everywhere),
            (4.01, Linear::Somewhere),
            (4.03, Linear::Somewhere),
            (4.05, Linear::Nowhere),
        ] {
            let of = |problem: &Problem<'_>| problem.analyse(None, &Factors::ONE_STEP);
            let found = ask(&spec, "symplectic-euler", f64::sqrt(theta), of);
            assert_eq!(found, expected, "{theta}");
        }
    }

    /// A triangle moves against the air as a whole: `hδ = hca/(3m)`. By Gershgorin `λ ≤ 4k/m`, so
    /// that a part of a divided step is at most 0.95 s long.
    #[test]
    fn drag_acts_on_the_parts_of_a_divided_step() {
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::y()];
        let mut spec = particles(&[1.0; 3], &corners, &[Vec3::z(); 3]);
        spec.triangles = vec![[0, 1, 2]];
        spec.springs = [(0, 1), (1, 2), (2, 0)].map(|ends| tension(ends, 1.0, 1.0, 0.0)).to_vec();
        let drag = DragSpec::Linear { coefficient_n_s_per_m3: 6.0 };
        spec.effects.air = Some(AirSpec { drag, wind: None });
        for (method, parts) in [("leapfrog", 1.0), ("leapfrog:step=bound,safety=0.95", 10.0)] {
            let found = ask(&spec, method, 9.0, |problem| problem.explicit_drag().unwrap());
            assert!((found - 9.0 / parts).abs() < 1e-12, "{method}: {found}");
        }
    }
}
