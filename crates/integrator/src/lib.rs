//! The [`Integrator`] trait, and what several time integrators share.
//!
//! This is the only room where physics meets linear algebra: effects emit weights and 3×3 blocks,
//! and [`LaplacianSolver`] and [`Newton`] assemble them into matrices and solve. A method's own crate
//! then reads like the paragraph of a paper: force, set up, solve, update.
//!
//! # The contract
//!
//! The caller owns the [`State`]; the integrator owns its scratch memory and its history; the
//! system does not change during a step.
//!
//! * [`Integrator::prepare`] is the only place that allocates. A step on one thread allocates
//!   nothing.
//! * Cached operators are keyed on the bits of the step size and on
//!   [`System::revisions`](drape_model::System::revisions). When one of them changes they are rebuilt in place, and
//!   the rebuild is charged to the step that caused it, by [cause](Setups). A changed sparsity
//!   pattern asks for `prepare` again.
//! * Blow-up is a result, not an error. `Err` is for broken contracts and leaves the state as it
//!   was (but for velocities of pinned particles, which a step sets to 0 before anything else). A solver that stops early says so in [`StepReport::solve`].
//!
//! # A method
//!
//! A method's crate implements [`Scheme`]: the memory of a step, how it is allocated, and the step with all its
//! equations. [`Stepper`] makes an [`Integrator`] of it, and [`Registration`] is the one line that the registry takes.
//! [`Method`] holds what a method is. It says by one of three standard answers ([`Supports`]) what the method does with
//! each effect, and names only what it refuses. [`settings!`] declares each setting once.
//!
//! # Step size control
//!
//! *Why.* The paper names it as further work: a step that suits the fall of a sheet is too long for the moment in which it
//! is caught. *How.* [`Adaptive`] wraps a method and divides each call into substeps. [`LocalError`] estimates their error
//! from the last positions, [`StepController`] (a PI controller) chooses the next size, and keeps it within a dead band,
//! because each new size costs a set-up. What is rejected is taken back to the last bit, history included, which is all
//! that a method has to offer ([`Rewind`]). A method that splits the force adds what positions cannot show
//! ([`Rewind::add_splitting_error`]). *What came out* stands in the record `solver-control`. The tolerance is one for the
//! local error of positions; the error at the end is that of all steps together, and falls like its square root (order 1)
//! or its power 2/3 (order 2). The algebraic error should be a tenth of it: the tolerances of the solvers stay what they
//! are set to.
//!
//! # What is shared
//!
//! | item | what it is | who uses it |
//! |---|---|---|
//! | [`LaplacianSolver`] | `A = M + τ²L_k + τL_c`, EEH (16)–(18) and (21), with preconditioner and filtered CG | methods with a linear implicit part |
//! | [`IncrementalPotential`] | `Φ(v)`, whose minimum is an implicit stage | updated CG, Newton |
//! | [`Newton`] | minimises `Φ`: the nonlinear system (4) by (5), reduced to `3n` unknowns as in section 2.3 | backward Euler, the safeguard of updated CG |
//! | [`Linearisation`] | the matrix `M + τ²K + τD` in 3×3 blocks | Newton, Baraff-Witkin |
//! | [`NewtonLinear`], [`Forcing`] | fresh or saved Jacobian, Cholesky, or CG, by multigrid if need be, as tight as the progress deserves | Newton, updated CG |
//! | [`Adaptive`] | step size control around a method that can take a step back ([`Rewind`]) | backward Euler, BDF, IMEX |
//! | [`ImplicitStage`] | one stage of an implicit method, under pins and contacts | backward Euler, BDF, the start-up of two-step methods |
//! | [`History`] | the last levels | multistep methods |
//! | [`ElongationLimit`] | Provot's correction of over-stretched springs | Provot, Desbrun |
//! | [`ViscousImpulse`] | right-hand side for the change of velocity | Desbrun, Kang |
//! | [`LargestEigenvalue`], [`StiffnessBound`] | what limits an explicit step | leapfrog |
//! | [`ExplicitNumbers`] | whether a step is short enough for what is explicit | whoever starts a run |
//! | [`ImpulsiveContacts`] | pins and contacts on a velocity that was computed without them | Provot, Terzopoulos-Fleischer, Desbrun, Kang |
//! | [`ContactSet`] | active set of the velocity constraints of section 6 | all |
//! | [`Predictor`] | start values, EEH (22) | CG methods |
//! | [`Bookkeeping`] | makes the [`EnergyLedger`] of a step | the methods of one step |

mod adaptive;
mod assembly;
pub mod choice;
mod clock;
mod contact;
mod elongation;
mod error;
mod explicit_limit;
mod forcing;
mod history;
mod implicit;
mod impulsive;
mod kinematics;
mod ledger;
mod linear;
pub mod linear_settings;
mod method;
mod newton;
mod newton_linear;
mod pins;
mod potential;
mod predictor;
mod random;
mod report;
mod scheme;
mod scratch;
mod settings;
mod spectrum;
mod split;
mod stage;
mod step_control;
mod step_size;
#[cfg(test)]
mod test_support;
mod viscous;

pub use adaptive::Adaptive;
pub use assembly::Linearisation;
pub use clock::{Phase, PhaseClock};
pub use contact::{Change, ContactSet, MultistepMotion, Wanted};
pub use elongation::{ElongationLimit, ElongationSettings, SweepOrder};
pub use error::{PrepareError, StepError};
pub use explicit_limit::ExplicitNumbers;
pub use forcing::{Forcing, ForcingKind, ForcingRule};
pub use history::History;
pub use implicit::Implicit;
pub use impulsive::ImpulsiveContacts;
pub use kinematics::{drift, kick};
pub use ledger::{Bookkeeping, EnergyLedger, as_stepped, momentum_between, subtract_laplacian};
pub use linear::{LaplacianSolver, LinearSettings, PreconditionerKind, SolverKind, Weights};
pub use method::{Method, Order, Quantity, StabilityClass, Support, Supports, Treatment};
pub use newton::{Newton, NewtonReport, NewtonSettings};
pub use newton_linear::{Jacobian, NewtonLinear, NewtonSolver};
pub use pins::{hold_pins, lead_pins};
pub use potential::IncrementalPotential;
pub use predictor::{Predictor, Start};
pub use report::{SetupCause, Setups, StepReport};
pub use scheme::{Past, Registration, Rewind, Scheme, Stepper, Taken};
pub use scratch::Scratch;
pub use settings::{
    Declared, Declares, Kind, MethodSettings, Setting, SettingError, Settings, Value, Word,
};
#[doc(hidden)]
pub use settings::{count, join};
pub use spectrum::{LargestEigenvalue, StiffnessBound};
pub use split::{Slopes, Split};
pub use stage::{ImplicitStage, Stage, StageSettings};
pub use step_control::{Decision, LocalError, StepController, TOLERANCE, mesh_width};
pub use step_size::{InvalidTimeStep, TimeStep};
pub use viscous::ViscousImpulse;

pub use drape_solvers::SolveStatus;

use drape_model::{State, System};

/// A time integrator: advances a state by one step.
pub trait Integrator: std::fmt::Debug + Send {
    /// What the method is and supports.
    fn method(&self) -> &'static Method;

    /// Allocates and fills everything that a step of length `h` needs.
    ///
    /// # Errors
    /// [`PrepareError`] when the method does not support an effect of the system, or an operator
    /// cannot be built.
    fn prepare(&mut self, system: &System, h: TimeStep) -> Result<(), PrepareError>;

    /// Advances `state` by exactly `h`, without allocating.
    ///
    /// # Errors
    /// [`StepError`] for a broken contract; the state is left as it was.
    fn step(
        &mut self,
        system: &System,
        state: &mut State,
        h: TimeStep,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError>;

    /// What the last step did to the total energy, cause by cause, given the states before and after it, its length and
    /// the system that it saw. `None` where the method has no such identity: the methods of several steps, and steps that
    /// a method divides.
    ///
    /// A diagnosis to be called right after [`step`](Self::step), if at all: it may allocate, and the step does nothing for
    /// it. What changes of the system from outside do to the energy, between steps, is not of the step.
    fn ledger(
        &mut self,
        _system: &System,
        _before: &State,
        _after: &State,
        _h: TimeStep,
    ) -> Option<EnergyLedger> {
        None
    }

    /// Forgets the history (predictor, contacts) after a jump of the state that the integrator did
    /// not make.
    fn restart(&mut self, state: &State);
}

#[doc = include_str!("../docs/equations.md")]
pub mod equations {}
