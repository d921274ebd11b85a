//! Description and settings of the method.

use drape_integrator::{
    Declares, Method, Order, Quantity, StabilityClass, Supports, Word, settings,
};

/// XPBD.
pub static XPBD: Method = Method {
    id: "xpbd",
    name: "extended position-based dynamics with small steps",
    source: "Macklin, Müller, Chentanez 2016; Macklin et al. 2019",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "one spring in one sweep is backward Euler; on a net the sweep stops before the \
             solution, which makes stiff springs softer and may set their energy free: more \
             substeps, not more sweeps, make it stable",
    supports: Supports::Compliant,
    refuses: &[],
    settings: XpbdSettings::SETTINGS,
};

/// Formula that leads from substep to substep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formula {
    /// Backward Euler: the published one.
    One,
    /// Two-step backward differentiation.
    Two,
}

impl Word for Formula {
    const WORDS: &'static [(&'static str, Self)] = &[("1", Self::One), ("2", Self::Two)];
}

/// In which order a sweep visits the constraints of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sweep {
    /// As the scene lists them.
    List,
    /// Colour by colour: constraints of one colour share no particle.
    Coloured,
}

impl Word for Sweep {
    const WORDS: &'static [(&'static str, Self)] =
        &[("list", Self::List), ("coloured", Self::Coloured)];
}

settings! {
    /// Settings of XPBD.
    pub struct XpbdSettings for XPBD {
        /// parts into which a step is divided
        substeps: u32 in 1..=1000 = 20,
        /// sweeps over the constraints in a substep
        iterations: u32 in 1..=10000 = 1,
        /// order of the formula between substeps: 1 is backward Euler, as published; 2 takes
        /// velocities and predictions from two-step backward differentiation
        order: Formula [One, Two] = One,
        /// order in which a sweep visits the constraints of an effect: as listed, or by colours,
        /// whose members several threads can project at once
        sweep: Sweep [List, Coloured] = List,
    }
}
