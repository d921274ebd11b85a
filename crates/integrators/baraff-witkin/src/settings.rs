//! What the method is, and its settings.

use drape_integrator::{
    Implicit, Kind, Method, Order, Quantity, Setting, SettingError, Settings, StabilityClass,
    Support, Treatment,
};
use drape_model::Tangent;
use drape_solvers::Norm;

/// Baraff and Witkin's implicit step.
pub static BARAFF_WITKIN: Method = Method {
    id: "baraff-witkin",
    name: "linearised implicit Euler",
    source: "Baraff & Witkin 1998 (6), (15)-(18)",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "backward Euler where forces are linear; elsewhere one linear solve a step, of which no \
             energy theorem holds: it may gain energy at large h²k/m",
    supports: &[
        Support::new("tension", Treatment::Implicit),
        Support::new("shear", Treatment::BySetting),
        Support::new("bending", Treatment::BySetting),
        Support::new("shear_angle", Treatment::BySetting),
        Support::new("bending_angle", Treatment::BySetting),
        Support::new("bending_hinge", Treatment::BySetting),
        Support::new("gravity", Treatment::Explicit),
        Support::new("air", Treatment::BySetting),
        Support::new("pins", Treatment::Constraint),
        Support::new("contact", Treatment::Constraint),
        Support::new("friction", Treatment::Constraint),
    ],
    settings: &[
        Setting {
            key: "forcing_term",
            kind: Kind::Number { min: 1e-16, max: 0.5 },
            default: "1e-3",
            help: "relative tolerance of the conjugate gradients",
        },
        Setting {
            key: "preconditioner",
            kind: Kind::Choice(&["none", "block-jacobi"]),
            default: "block-jacobi",
            help: "preconditioner of the conjugate gradients",
        },
        Setting {
            key: "norm",
            kind: Kind::Choice(&["euclid", "preconditioned"]),
            default: "preconditioned",
            help: "norm in which the residual is tested",
        },
        Setting {
            key: "solver",
            kind: Kind::Choice(&["cg", "cholesky"]),
            default: "cg",
            help: "conjugate gradients, or a sparse factorisation in each step (LDLᵀ with hessian=raw)",
        },
        Setting {
            key: "start",
            kind: Kind::Choice(&["zero", "last"]),
            default: "zero",
            help: "where the conjugate gradients start: at no change of velocity, or at that of the last step",
        },
        Setting {
            key: "hessian",
            kind: Kind::Choice(&["clamped", "raw"]),
            default: "clamped",
            help: "∂f/∂x with the negative stiffness across compressed springs left out, or as it is: then \
                   the matrix may be indefinite, and conjugate gradients stop early",
        },
        Setting {
            key: "implicit",
            kind: Kind::Choice(&["everything", "tension"]),
            default: "everything",
            help: "which forces are linearised; the others stay at the old level",
        },
        Setting {
            key: "contact",
            kind: Kind::Choice(&["velocity", "position"]),
            default: "velocity",
            help: "particles inside an obstacle are led out by their velocity, or put on its surface at \
                   once by the position alteration y",
        },
    ],
};

/// Which preconditioner CG uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preconditioning {
    /// None.
    None,
    /// The inverses of the 3×3 diagonal blocks.
    BlockJacobi,
}

/// Which solver is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockSolver {
    /// Filtered conjugate gradients.
    Cg,
    /// A sparse factorisation: Cholesky, or `L D Lᵀ` of the raw matrix.
    Direct,
}

/// How a particle inside an obstacle gets out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recovery {
    /// By its velocity, at limited speed (EEH section 6).
    Velocity,
    /// By the position alteration `y`, at once (Baraff & Witkin section 6).
    Position,
}

/// Settings of Baraff and Witkin's step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaraffWitkinSettings {
    /// Relative tolerance of the conjugate gradients.
    pub forcing_term: f64,
    /// Preconditioner of the conjugate gradients.
    pub preconditioning: Preconditioning,
    /// Norm of their stop test.
    pub norm: Norm,
    /// Solver.
    pub solver: BlockSolver,
    /// Whether the conjugate gradients start at the last step's `Δv` instead of at 0.
    pub starts_at_last: bool,
    /// Which `∂f/∂x`.
    pub tangent: Tangent,
    /// Which forces are linearised.
    pub implicit: Implicit,
    /// How particles get out of obstacles.
    pub contact: Recovery,
}

impl BaraffWitkinSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let settings = Settings::new(BARAFF_WITKIN.id, BARAFF_WITKIN.settings, pairs)?;
        Ok(Self {
            forcing_term: settings.number("forcing_term"),
            preconditioning: match settings.word("preconditioner") {
                "none" => Preconditioning::None,
                _ => Preconditioning::BlockJacobi,
            },
            norm: match settings.word("norm") {
                "euclid" => Norm::Euclid,
                _ => Norm::Preconditioned,
            },
            solver: match settings.word("solver") {
                "cholesky" => BlockSolver::Direct,
                _ => BlockSolver::Cg,
            },
            starts_at_last: settings.word("start") == "last",
            tangent: match settings.word("hessian") {
                "raw" => Tangent::Exact,
                _ => Tangent::Projected,
            },
            implicit: match settings.word("implicit") {
                "tension" => Implicit::Tension,
                _ => Implicit::Everything,
            },
            contact: match settings.word("contact") {
                "position" => Recovery::Position,
                _ => Recovery::Velocity,
            },
        })
    }
}
