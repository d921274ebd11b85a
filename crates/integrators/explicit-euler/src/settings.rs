//! What the three methods are, and their settings.

use drape_integrator::{
    Kind, Method, Order, Quantity, Setting, SettingError, Settings, SolverKind, StabilityClass,
    Support, Treatment, linear_settings,
};

const SUPPORTS: &[Support] = &[
    Support::new("tension", Treatment::Explicit),
    Support::new("shear", Treatment::Explicit),
    Support::new("bending", Treatment::Explicit),
    Support::new("shear_angle", Treatment::Explicit),
    Support::new("bending_angle", Treatment::Explicit),
    Support::new("bending_hinge", Treatment::Explicit),
    Support::new("gravity", Treatment::Explicit),
    Support::new("air", Treatment::Explicit),
    Support::new("pins", Treatment::Constraint),
    Support::new("contact", Treatment::Constraint),
    Support::new("friction", Treatment::Constraint),
];

/// Explicit Euler.
pub static EXPLICIT_EULER: Method = Method {
    id: "explicit-euler",
    name: "explicit Euler",
    source: "EEH (2) with k = 1",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "stable only if h²k/m ≤ hd/m, so never without damping",
    supports: SUPPORTS,
    settings: &[],
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
    supports: SUPPORTS,
    settings: &[Setting {
        key: "damping",
        kind: Kind::Choice(&["explicit", "implicit"]),
        default: "explicit",
        help: "whether the springs' damping is taken at the old or the new velocity",
    }],
};

/// Leapfrog.
pub static LEAPFROG: Method = Method {
    id: "leapfrog",
    name: "leapfrog (velocity Verlet)",
    source: "Newmark's method with β = 0, γ = 1/2",
    order: Order::Two,
    class: StabilityClass::Symplectic,
    conserves: &[Quantity::Momentum, Quantity::AngularMomentum],
    theory: "its energy stays close to the true one; stable if h²λ < 4, whatever the damping",
    supports: SUPPORTS,
    settings: &[
        Setting {
            kind: Kind::Choice(&["cg", "cholesky"]),
            default: "cholesky",
            help: "how the damping at the new velocity is solved for, where there is any: sparse Cholesky, or \
                   conjugate gradients with Jacobi preconditioning to 1e-14",
            ..linear_settings::SOLVER
        },
        Setting {
            key: "step",
            kind: Kind::Choice(&["fixed", "auto", "bound"]),
            default: "fixed",
            help: "take the step as it is, or divide it into equal substeps within safety · 2/√λ, with λ estimated \
                   as the cloth moves (auto) or bounded for all its positions (bound)",
        },
        Setting {
            key: "safety",
            kind: Kind::Number { min: 0.05, max: 1.0 },
            default: "0.7",
            help: "longest substep of step=auto or bound over the stability limit 2/√λ; for bound 0.95 will do",
        },
    ],
};

/// Where symplectic Euler takes the damping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DampingTreatment {
    /// At `v_n`.
    #[default]
    Explicit,
    /// At `v_{n+1}`: one sparse solve a step.
    Implicit,
}

/// Settings of symplectic Euler.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SymplecticSettings {
    /// Where the damping is taken.
    pub damping: DampingTreatment,
}

impl SymplecticSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let settings = Settings::new(SYMPLECTIC_EULER.id, SYMPLECTIC_EULER.settings, pairs)?;
        let damping = match settings.word("damping") {
            "implicit" => DampingTreatment::Implicit,
            _ => DampingTreatment::Explicit,
        };
        Ok(Self { damping })
    }
}

/// Whether leapfrog divides the steps that it is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StepControl {
    /// It does not.
    #[default]
    Fixed,
    /// Into equal substeps within the stability limit, which is estimated as the cloth moves.
    Auto,
    /// Into equal substeps within a stability limit that holds for all positions.
    Bound,
}

/// Settings of leapfrog.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeapfrogSettings {
    /// How `(M + h/2 L_c) v = b` is solved, where something is damped.
    pub solver: SolverKind,
    /// Whether steps are divided.
    pub step: StepControl,
    /// Longest substep over the stability limit, if they are.
    pub safety: f64,
}

impl Default for LeapfrogSettings {
    fn default() -> Self {
        Self { solver: SolverKind::Cholesky, step: StepControl::Fixed, safety: 0.7 }
    }
}

impl LeapfrogSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let settings = Settings::new(LEAPFROG.id, LEAPFROG.settings, pairs)?;
        let solver = match settings.word("solver") {
            "cg" => SolverKind::Cg,
            _ => SolverKind::Cholesky,
        };
        let step = match settings.word("step") {
            "auto" => StepControl::Auto,
            "bound" => StepControl::Bound,
            _ => StepControl::Fixed,
        };
        Ok(Self { solver, step, safety: settings.number("safety") })
    }
}
