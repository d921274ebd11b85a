//! Description and settings of the method.

use drape_integrator::{Declares, Method, Order, StabilityClass, Supports, settings};

/// Kang's neighbour-corrected sweep.
pub static KANG: Method = Method {
    id: "kang",
    name: "Kang's neighbour-corrected sweep",
    source: "Kang, Choi, Cho 2000; EEH section 3",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[],
    theory: "two Jacobi sweeps in place of the solve of IMEX Euler: stable on springs of rest \
             length 0, energy may rise on others; it hardly resists smooth stretching, so a stiff \
             sheet sags like rubber; momentum is kept only where all particles have equal masses \
             and springs",
    supports: Supports::ScalarMatrix,
    refuses: &[],
    settings: KangSettings::SETTINGS,
};

settings! {
    /// Settings of Kang's method.
    pub struct KangSettings for KANG {
        /// corrections by the neighbours in a step: 1 is the published formula, more approach IMEX
        /// Euler; an even number overshoots the roughest shapes
        sweeps: u32 in 1..=64 = 1,
    }
}
