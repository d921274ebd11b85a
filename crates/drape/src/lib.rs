//! Time integrators for mass-spring cloth, compared on one and the same cloth.
//!
//! A *cloth* is a [`model::System`] (masses, springs and other forces, pins, obstacles) and a
//! [`model::State`] (time, positions, velocities). A *method* advances the state by one step
//! ([`integrator::Integrator`]). A *run* takes many steps and counts what they cost ([`Runner`]). A
//! *verdict* says whether the run gained energy ([`Verdict`]).
//!
//! ```
//! use drape::{Runner, Simulation, methods::Choice, model::TimeSpan, reference_energy};
//!
//! let sheet = Simulation::load("hanging-textile-1e4")?;
//! let method = Choice::parse("imex-euler:forcing_term=0.05", &[])?;
//! let time = TimeSpan { step_s: 0.01, duration_s: 0.2 };
//! let run = Runner::new(&method, time).count(&sheet)?;
//! println!("{} CG iterations", run.outcome.totals.cg_iterations);
//! assert_eq!(run.verdict(reference_energy(&sheet, 0.2)?).name(), "stable");
//! # Ok::<(), drape::Error>(())
//! ```
//!
//! # Where to go from here
//!
//! | I want to | go to |
//! |---|---|
//! | see a whole program | [`examples::hang_a_sheet`] |
//! | write a method of my own | [`examples::write_a_method`], [`Drape`] |
//! | write a method in another language | [`guide::protocol`] |
//! | write a force of my own | [`examples::write_an_effect`] |
//! | compare two methods | [`examples::compare_two`] |
//! | find the method for a scene | [`compare`] |
//! | find an equation, a force or a verdict in the code | [`guide::places`] |
//! | choose a method | [`guide::methods`] |
//! | see methods side by side, live | [`guide::lab`] |
//! | write a scene | [`guide::scenes`] |
//! | use the command | [`guide::command`] |
//! | compute studies on many machines | [`guide::sweeps`] |
//! | know why the numbers can be trusted | [`guide::trust`] |
//! | doubt the comparison | [`guide::methodology`] |
//! | know how fast it is | [`guide::speed`] |
//!
//! # The crates
//!
//! | crate | what it holds |
//! |---|---|
//! | [`model`] | particles, effects, obstacles, energies, scenes; no time step |
//! | [`integrator`] | the trait [`integrator::Integrator`] and what methods share |
//! | `drape_imex`, `drape_backward_euler`, … | one crate for each family of methods |
//! | [`methods`] | the registry: from an id such as `imex-euler` to an integrator |
//! | `drape_kernels`, `drape_solvers` | vector loops and layouts; matrices and conjugate gradients |
//! | `drape_oracle` | exact recurrences and reference trajectories, which tests compare with |
//! | `drape_harness` | runs, verdicts, studies and claims |
//! | `drape_report`, `drape_render` | figures and pages; pictures of a cloth |
//! | `drape_lab` | methods side by side, live in the browser |
//!
//! The program `drape` is built from the same crates; [`guide::command`] describes it.

mod builder;
mod cli;

pub use builder::Drape;
pub use drape_harness::{
    Counts, Divergence, Energy, HarnessError as Error, Moment, Outcome, Rule, Runner, Simulation,
    Verdict, judge, reference_energy,
};
pub use drape_harness::{compare, methods};
pub use drape_integrator as integrator;
pub use drape_model as model;

/// Pages for readers: where things are, how to choose a method, how to write a scene, and more.
pub mod guide {
    #[doc = include_str!("../docs/places.md")]
    pub mod places {}

    #[doc = include_str!("../docs/methods.md")]
    pub mod methods {}

    #[doc = include_str!("../docs/scenes.md")]
    pub mod scenes {}

    #[doc = include_str!("../docs/command.md")]
    pub mod command {}

    #[doc = include_str!("../docs/lab.md")]
    pub mod lab {}

    #[doc = include_str!("../docs/protocol.md")]
    pub mod protocol {}

    #[doc = include_str!("../docs/engine.md")]
    pub mod engine {}

    #[doc = include_str!("../docs/sweeps.md")]
    pub mod sweeps {}

    #[doc = include_str!("../docs/trust.md")]
    pub mod trust {}

    #[doc = include_str!("../docs/methodology.md")]
    pub mod methodology {}

    #[doc = include_str!("../docs/speed.md")]
    pub mod speed {}
}

/// Four programs that use this library. `cargo run --example NAME` runs one of them.
pub mod examples {
    /// A sheet hangs by two corners.
    ///
    /// ```rust,ignore
    #[doc = include_str!("../examples/hang_a_sheet.rs")]
    /// ```
    pub mod hang_a_sheet {}

    /// Your own time integrator.
    ///
    /// ```rust,ignore
    #[doc = include_str!("../examples/write_a_method.rs")]
    /// ```
    pub mod write_a_method {}

    /// Your own force.
    ///
    /// ```rust,ignore
    #[doc = include_str!("../examples/write_an_effect.rs")]
    /// ```
    pub mod write_an_effect {}

    /// Two methods on one scene.
    ///
    /// ```rust,ignore
    #[doc = include_str!("../examples/compare_two.rs")]
    /// ```
    pub mod compare_two {}
}
