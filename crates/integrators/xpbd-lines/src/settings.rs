//! Description and settings of the method.

use drape_integrator::{
    Declares, Method, Order, Quantity, StabilityClass, Supports, Word, settings,
};

/// XPBD by lines.
pub static XPBD_LINES: Method = Method {
    id: "xpbd-lines",
    name: "XPBD with line relaxation",
    source: "XPBD: Macklin et al. 2016, 2019; strips of constraints: Bender, Bayer 2008",
    order: Order::Two,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "one spring in one sweep is two-step backward differentiation; a line of springs is \
             solved by one Newton step, so that a sweep carries stretch across the whole sheet; \
             between families of lines it stops before the solution, which may set the energy of \
             stiff springs free where lines kink",
    supports: Supports::Compliant,
    refuses: &[],
    settings: XpbdLinesSettings::SETTINGS,
};

/// Formula that leads from substep to substep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formula {
    /// Backward Euler.
    One,
    /// Two-step backward differentiation.
    Two,
}

impl Word for Formula {
    const WORDS: &'static [(&'static str, Self)] = &[("1", Self::One), ("2", Self::Two)];
}

settings! {
    /// Settings of XPBD by lines.
    pub struct XpbdLinesSettings for XPBD_LINES {
        /// parts into which a step is divided
        substeps: u32 in 1..=1000 = 20,
        /// sweeps over all lines in a substep
        iterations: u32 in 1..=10000 = 1,
        /// order of the formula between substeps: 1 is backward Euler, 2 is two-step backward
        /// differentiation
        order: Formula [One, Two] = Two,
    }
}
