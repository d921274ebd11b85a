//! Description and settings of the method.

use drape_integrator::{
    Declares, ElongationSettings, Method, Order, Quantity, SolverKind, StabilityClass, Supports,
    Word, settings,
};

/// Desbrun, Schröder and Barr's precomputed inverse.
pub static DESBRUN: Method = Method {
    id: "desbrun",
    name: "Desbrun's precomputed inverse",
    source: "Desbrun, Schröder, Barr 1999; EEH section 3",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum, Quantity::AngularMomentum],
    theory: "IMEX Euler with unfiltered external forces: with torque=none, full damping, no \
             contacts and not both pins and gravity it never gains energy; it locks as IMEX Euler \
             does; the consistent correction keeps the total angular momentum, at the price of \
             energy, and nothing else of the motion",
    supports: Supports::ScalarMatrix,
    refuses: &[],
    settings: DesbrunSettings::SETTINGS,
};

/// Which form of the inverse is precomputed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inverse {
    /// A sparse Cholesky factor of `A`.
    Cholesky,
    /// `A⁻¹`, `n` × `n`.
    Dense,
}

impl Word for Inverse {
    const WORDS: &'static [(&'static str, Self)] =
        &[("cholesky", Self::Cholesky), ("dense", Self::Dense)];
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

impl Word for Torque {
    const WORDS: &'static [(&'static str, Self)] =
        &[("none", Self::None), ("literal", Self::Literal), ("consistent", Self::Consistent)];
}

settings! {
    /// Settings of Desbrun's method.
    pub struct DesbrunSettings for DESBRUN {
        /// form of the precomputed inverse: a sparse Cholesky factor, or the full inverse as
        /// published; the motion is the same
        inverse: Inverse [Cholesky, Dense] = Cholesky,
        /// most MiB that inverse=dense may take for the inverse and its work space; more is refused
        memory_limit_mib: usize in 1..=1_048_576 = 2048,
        /// correction of the torque that the filter adds: none, as published, or in consistent
        /// units (which does nothing where a particle is pinned)
        torque: Torque [None, Literal, Consistent] = Consistent,
        /// shorten over-stretched springs after the step, like Provot, by limit, sweeps and order
        inverse_dynamics: bool = false,
        /// how inverse_dynamics shortens springs
        elongation: ElongationSettings,
    }
}

impl DesbrunSettings {
    /// The solver that applies `A⁻¹`.
    pub(crate) fn solver(&self) -> SolverKind {
        match self.inverse {
            Inverse::Cholesky => SolverKind::Cholesky,
            Inverse::Dense => {
                let limit_bytes = self.memory_limit_mib.saturating_mul(1 << 20);
                SolverKind::DenseInverse { limit_bytes }
            }
        }
    }
}
