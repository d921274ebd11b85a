//! Description and settings of the method.

use drape_integrator::{Declares, Method, Order, StabilityClass, Supports, Word, settings};

/// Vertex block descent.
pub static VBD: Method = Method {
    id: "vbd",
    name: "vertex block descent",
    source: "Chen, Liu, Yang, Yuksel 2024; Giles, Diaz, Yuksel 2025",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[],
    theory: "backward Euler by sweeps of 3×3 Newton steps, one a particle: where the sweeps \
             converge \
             it damps as backward Euler does, where they do not it slows the motion down; energy \
             may \
             rise on springs with a rest length, and momentum is kept by converged steps only",
    supports: Supports::Blocks,
    refuses: &[],
    settings: VbdSettings::SETTINGS,
};

/// Where the sweeps of a step start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Between `v_n` and the inertial target, as far as the last step followed the explicit forces.
    Adaptive,
    /// At the inertial target: free motion under the explicit forces.
    Inertial,
    /// At the positions of the last level: at rest.
    Previous,
}

impl Word for Start {
    const WORDS: &'static [(&'static str, Self)] =
        &[("adaptive", Self::Adaptive), ("inertial", Self::Inertial), ("previous", Self::Previous)];
}

settings! {
    /// Settings of vertex block descent.
    pub struct VbdSettings for VBD {
        /// sweeps over all particles in a step
        sweeps: u32 in 1..=1000 = 20,
        /// where the sweeps of a step start: `previous` with few sweeps loses the free fall
        start: Start [Adaptive, Inertial, Previous] = Adaptive,
        /// spectral radius for Chebyshev's acceleration of the sweeps; 0: none
        chebyshev: f64 in 0.0..=0.999 = 0,
        /// replace the stiffness of linear springs by one that rises from sweep to sweep (AVBD)
        augmented: bool = false,
        /// AVBD: share of the full stiffness by which one rises in a sweep, for a strain of 1
        beta: f64 in 0.0..=1e9 = 0.1,
        /// AVBD: share of a stiffness that the next step starts with
        gamma: f64 in 0.0..=1.0 = 0.99,
    }
}
