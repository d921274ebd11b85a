//! What the method is, and its settings.

use drape_integrator::{
    ElongationSettings, Kind, Method, Order, Quantity, Setting, SettingError, Settings, SolverKind,
    StabilityClass, Support, Treatment,
};

/// Desbrun, Schröder and Barr's precomputed inverse.
pub static DESBRUN: Method = Method {
    id: "desbrun",
    name: "Desbrun's precomputed inverse",
    source: "Desbrun, Schröder, Barr 1999; EEH section 3",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum, Quantity::AngularMomentum],
    theory: "IMEX Euler with unfiltered external forces: with torque=none, full damping, no contacts and not both pins \
             and gravity it never gains energy; locks for h²k/m above 1; the consistent correction keeps the angular \
             momentum of the whole, at the price of energy, and nothing else of the motion",
    supports: &[
        Support::new("tension", Treatment::Implicit),
        Support::new("shear", Treatment::Implicit),
        Support::new("bending", Treatment::Implicit),
        Support::new("shear_angle", Treatment::Explicit),
        Support::new("bending_angle", Treatment::Explicit),
        Support::new("bending_hinge", Treatment::Explicit),
        Support::new("gravity", Treatment::Explicit),
        Support::new("air", Treatment::Explicit),
        Support::new("pins", Treatment::Constraint),
        Support::new("contact", Treatment::Constraint),
        Support::new("friction", Treatment::Constraint),
    ],
    settings: &[
        Setting {
            key: "inverse",
            kind: Kind::Choice(&["cholesky", "dense"]),
            default: "cholesky",
            help: "what is precomputed: a sparse Cholesky factor, or the full inverse as published; the motion is the \
                   same",
        },
        Setting {
            key: "memory_limit_mib",
            kind: Kind::Integer { min: 1, max: 1_048_576 },
            default: "2048",
            help: "inverse=dense is refused where the inverse and its work space would take more than this many MiB",
        },
        Setting {
            key: "torque",
            kind: Kind::Choice(&["none", "literal", "consistent"]),
            default: "consistent",
            help: "correction of the torque that the filter adds: none, as published, or in consistent units (which \
                   does nothing where a particle is pinned)",
        },
        Setting {
            key: "inverse_dynamics",
            kind: Kind::Choice(&["false", "true"]),
            default: "false",
            help: "shorten over-stretched springs after the step, like Provot, by limit, sweeps and order",
        },
        ElongationSettings::LIMIT,
        ElongationSettings::SWEEPS,
        ElongationSettings::ORDER,
    ],
};

/// What is precomputed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inverse {
    /// A sparse Cholesky factor of `A`.
    Cholesky,
    /// `A⁻¹`, `n` × `n`.
    Dense {
        /// Most memory that it may take with its scratch, bytes.
        limit_bytes: usize,
    },
}

impl Inverse {
    pub(crate) fn solver(self) -> SolverKind {
        match self {
            Self::Cholesky => SolverKind::Cholesky,
            Self::Dense { limit_bytes } => SolverKind::DenseInverse { limit_bytes },
        }
    }
}

/// How the torque of the filter is corrected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Torque {
    /// Not at all.
    None,
    /// `F_i = h (x_G − x_i) × δT`, as published.
    Literal,
    /// `F_i = m_i β × r_i` with `β = −I_G⁻¹ Σ r_i × F_i`.
    Consistent,
}

/// Settings of Desbrun's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DesbrunSettings {
    /// What is precomputed.
    pub inverse: Inverse,
    /// Correction of the torque.
    pub torque: Torque,
    /// Correction of over-stretched springs.
    pub inverse_dynamics: Option<ElongationSettings>,
}

impl DesbrunSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let settings = Settings::new(DESBRUN.id, DESBRUN.settings, pairs)?;
        let limit_bytes = settings.integer("memory_limit_mib").saturating_mul(1 << 20);
        Ok(Self {
            inverse: match settings.word("inverse") {
                "dense" => Inverse::Dense { limit_bytes },
                _ => Inverse::Cholesky,
            },
            torque: match settings.word("torque") {
                "none" => Torque::None,
                "literal" => Torque::Literal,
                _ => Torque::Consistent,
            },
            inverse_dynamics: (settings.word("inverse_dynamics") == "true")
                .then(|| ElongationSettings::read(&settings)),
        })
    }
}
