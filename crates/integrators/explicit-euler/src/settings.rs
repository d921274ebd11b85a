//! Description and settings of the three methods.

use drape_integrator::{
    Declares, Method, Order, Quantity, SolverKind, StabilityClass, StepControl, Supports, Word,
    settings,
};

/// Explicit Euler.
pub static EXPLICIT_EULER: Method = Method {
    id: "explicit-euler",
    name: "explicit Euler",
    source: "EEH (2) with k = 1",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "stable only if h²k/m ≤ hd/m, so never without damping",
    supports: Supports::Explicit,
    refuses: &[],
    settings: ExplicitSettings::SETTINGS,
};

/// Symplectic Euler.
pub static SYMPLECTIC_EULER: Method = Method {
    id: "symplectic-euler",
    name: "symplectic Euler",
    source: "the explicit part of Provot 1995",
    order: Order::One,
    class: StabilityClass::Symplectic,
    conserves: &[Quantity::Momentum, Quantity::AngularMomentum],
    theory: "its energy stays close to the true one; stable if h²λ + 2hδ < 4",
    supports: Supports::Explicit,
    refuses: &[],
    settings: SymplecticSettings::SETTINGS,
};

/// Leapfrog.
pub static LEAPFROG: Method = Method {
    id: "leapfrog",
    name: "leapfrog (velocity Verlet)",
    source: "Newmark's method with β = 0, γ = 1/2",
    order: Order::Two,
    class: StabilityClass::Symplectic,
    conserves: &[Quantity::Momentum, Quantity::AngularMomentum],
    theory: "its energy stays close to the true one; stable if h²λ < 4, whatever the damping; with \
             damping=explicit also only if hδ < 4",
    supports: Supports::Explicit,
    refuses: &[],
    settings: LeapfrogSettings::SETTINGS,
};

settings! {
    /// Settings of explicit Euler, which has none.
    pub struct ExplicitSettings for EXPLICIT_EULER {}
}

/// Where symplectic Euler takes the damping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DampingTreatment {
    /// At `v_n`.
    Explicit,
    /// At `v_{n+1}`: one sparse solve per step.
    Implicit,
}

impl Word for DampingTreatment {
    const WORDS: &'static [(&'static str, Self)] =
        &[("explicit", Self::Explicit), ("implicit", Self::Implicit)];
}

settings! {
    /// Settings of symplectic Euler.
    pub struct SymplecticSettings for SYMPLECTIC_EULER {
        /// whether the springs' damping is taken at the old or the new velocity
        damping: DampingTreatment [Explicit, Implicit] = Explicit,
    }
}

/// How leapfrog takes the damping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeapfrogDamping {
    /// Half at the old and half at the new velocity: a sparse solve per step, at any damping.
    CrankNicolson,
    /// In the kicks, by Heun's method: four products a step, and a limit.
    Explicit,
}

impl Word for LeapfrogDamping {
    const WORDS: &'static [(&'static str, Self)] =
        &[("crank-nicolson", Self::CrankNicolson), ("explicit", Self::Explicit)];
}

settings! {
    /// Settings of leapfrog.
    pub struct LeapfrogSettings for LEAPFROG {
        /// solver for the damping at the new velocity, if any: sparse Cholesky, or conjugate
        /// gradients with Jacobi preconditioning to 1e-14
        solver: SolverKind [Cg, Cholesky] = Cholesky,
        /// take the step as given, or divide it into equal substeps within safety · 2/√λ, with λ
        /// estimated as the cloth moves (auto) or bounded for all positions (bound)
        step: StepControl [Fixed, Auto, Bound] = Fixed,
        /// longest substep of step=auto or bound over the stability limit 2/√λ; for bound, 0.95 is
        /// enough
        safety: f64 in 0.05..=1.0 = 0.7,
        /// half the damping at the new velocity, by a solve, or all of it in the kicks, which is
        /// cheaper and stable only for hδ < 4
        damping: LeapfrogDamping [CrankNicolson, Explicit] = CrankNicolson,
    }
}
