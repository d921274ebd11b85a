//! References for the tests of integrators: exact recurrences, exact laws, finite differences,
//! observed orders, reference trajectories.
//!
//! # What it is for
//!
//! A simulated cloth that looks right proves little. Each module states, independently of any
//! implementation, the results of a correct integrator or a correct force:
//!
//! | module | statement | holds to |
//! |---|---|---|
//! | [`recurrence`] | on the damped oscillator a step is a known 2 × 2 matrix per level | round-off |
//! | [`laws`] | spin of two particles, free fall, lengths of a hanging chain | round-off |
//! | [`finite_difference`] | force = −∇energy, stiffness = −∂f/∂x, damping = −∂f/∂v | about 1e-9 |
//! | [`mod@adaptive`] | explicit Runge–Kutta methods that choose their steps | a tolerance a step |
//! | [`mod@reference`] | the solution of the differential equation itself | a stated error |
//! | [`published`] | where public programs move a sheet, and their steps written out | single precision |
//! | [`elastica`] | shape of a clamped strip under its weight | about 1e-6 |
//! | [`order`] | how fast the error falls with the step size | about 0.1 in the exponent |
//!
//! This crate uses the model and the integrator trait, but no method, so no check shares code with
//! the method that it checks.
//!
//! [`statics`] finds rest positions. [`scenes`] builds the small systems of the tests, [`Run`]
//! steps an integrator on one of them, and [`Random`] gives the same numbers on every machine.
//! [`checks`] are tests that many methods share.
//!
//! # Symbols
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `h` | step size | s |
//! | `κ`, `δ` | stiffness and damping over mass, of `x'' = −κx − δx'` | 1/s², 1/s |
//! | `θ = h²κ`, `η = hδ` | the same without dimension | – |
//! | `w = hv` | velocity as displacement per step | m |
//! | `ℓ`, `L` | rest length, length of a spring | m |
//!
//! For one particle of mass `m` on an anchored spring `κ = k/m`, `δ = c/m`; for the relative motion
//! of two free particles of mass `m` each, `κ = 2k/m`, `δ = 2c/m`.

pub mod adaptive;
pub mod checks;
pub mod elastica;
pub mod finite_difference;
pub mod laws;
pub mod order;
pub mod published;
mod random;
pub mod recurrence;
pub mod reference;
mod run;
pub mod scenes;
pub mod statics;

pub use random::Random;
pub use run::{Run, apart, bits, largest, order_of, seconds};
