//! The [`Integrator`] trait, and the parts that several time integrators share.
//!
//! This is the only crate where physics meets linear algebra. Effects emit weights and 3×3 blocks;
//! [`LaplacianSolver`] and [`Newton`] assemble them into matrices and solve. A method's own crate
//! then reads like a paragraph of a paper: force, set up, solve, update.
//!
//! # The contract
//!
//! The caller owns the [`State`]. The integrator owns its scratch memory and its history. The
//! system does not change during a step.
//!
//! * [`Integrator::prepare`] allocates; [`Integrator::step`] on one thread does not.
//! * Cached operators are keyed on the bits of the step size and on
//!   [`System::revisions`](drape_model::System::revisions). When one of them changes, the operators
//!   are rebuilt in place, and the report of that step counts the rebuild by its [cause](Setups). A
//!   changed sparsity pattern requires a new `prepare`.
//! * Blow-up is a result, not an error. `Err` reports a broken contract and leaves the state
//!   unchanged, except that a step first sets the velocities of pinned particles to 0. A solver
//!   that stops early says so in [`StepReport::solve`].
//!
//! # A method
//!
//! A method's crate implements [`Scheme`]: the memory of a step, its allocation, and the step with
//! all its equations. [`Stepper`] makes an [`Integrator`] of it, and [`Registration`] is its line
//! in the registry. [`Method`] describes a method. One of four standard answers ([`Supports`]) says
//! how the method treats each effect; the method lists only the effects that it refuses.
//! [`settings!`] declares each setting once.
//!
//! # Step size control
//!
//! The paper names step size control as further work: a step that suits the fall of a sheet is too
//! long for the moment in which the sheet is caught. [`Adaptive`] wraps a method and divides each
//! call into substeps. [`LocalError`] estimates their error from the last positions.
//! [`StepController`] (a PI controller) chooses the next size. It changes the size only outside a
//! dead band, because each new size costs a set-up. A rejected substep is undone to the last bit,
//! history included. A method must only support this ([`Rewind`]). A method that splits the force
//! adds the error that positions cannot show ([`Rewind::add_splitting_error`]).
//!
//! The tolerance limits the local error of positions. The error at the end sums over all steps. It
//! falls like the square root of the tolerance (order 1) or its power 2/3 (order 2). The algebraic
//! error should be a tenth of the tolerance; step size control does not change the tolerances of
//! the solvers. The record `solver-control` holds the results.
//!
//! # What is shared
//!
//! | item | what it is | used by |
//! |---|---|---|
//! | [`LaplacianSolver`] | `A = M + τ²L_k + τL_c`, EEH (16)–(18) and (21), with preconditioner and filtered CG | methods with a linear implicit part |
//! | [`IncrementalPotential`] | `Φ(v)`, whose minimum is an implicit stage | updated CG, Newton |
//! | [`Newton`] | minimises `Φ`: the nonlinear system (4) by (5), reduced to `3n` unknowns as in section 2.3 | backward Euler, updated CG |
//! | [`Linearisation`] | the matrix `M + τ²K + τD` in 3×3 blocks | Newton, Baraff-Witkin |
//! | [`NewtonLinear`], [`Forcing`] | fresh or saved Jacobian; Cholesky, CG or multigrid; forcing terms | Newton, updated CG |
//! | [`Adaptive`] | step size control around a method that can take a step back ([`Rewind`]) | backward Euler, BDF, IMEX |
//! | [`ImplicitStage`] | one stage of an implicit method, under pins and contacts | backward Euler, BDF, start of two-step methods |
//! | [`History`] | the last levels | multistep methods |
//! | [`ElongationLimit`] | Provot's correction of over-stretched springs | Provot, Desbrun |
//! | [`ViscousImpulse`] | right-hand side for the change of velocity | Desbrun, Kang |
//! | [`StabilityLimit`] by [`LargestEigenvalue`] or [`StiffnessBound`], [`DampingBound`] | stability limit of an explicit step, and its substeps | leapfrog, SRKN4, RKC |
//! | [`ExplicitKick`] | a kick with damping, without a solve | leapfrog, multirate |
//! | [`KeptForce`] | the force at the end of a step, for the start of the next | leapfrog, SRKN4, multirate |
//! | [`ExplicitNumbers`] | whether a step is short enough for the explicit forces | the harness, before a run |
//! | [`ImpulsiveContacts`] | pins and contacts on a velocity computed without them | Provot, Terzopoulos-Fleischer, Desbrun, Kang |
//! | [`ContactSet`] | active set of the velocity constraints of section 6 | all |
//! | [`StepReference`] | what the residual of a step's solve is measured against, in any frame and with any masses | IMEX |
//! | [`Predictor`] | start values, EEH (22) | CG methods |
//! | [`PositionBased`], [`CompliantAngles`], [`Colouring`] | substeps that predict, move positions and meet contacts | XPBD by springs and by lines |
//! | [`Bookkeeping`] | makes the [`EnergyLedger`] of a step | one-step methods |

mod adaptive;
mod assembly;
pub mod choice;
mod clock;
mod compliant;
mod contact;
mod elongation;
mod error;
mod explicit_kick;
mod explicit_limit;
mod forcing;
mod history;
mod implicit;
mod impulsive;
mod kept_force;
mod kinematics;
mod ledger;
mod linear;
pub mod linear_settings;
mod method;
mod newton;
mod newton_linear;
mod newton_safeguard;
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
mod stability_limit;
mod stage;
mod stage_memory;
mod step_control;
mod step_size;
mod stop_test;
#[cfg(test)]
mod test_support;
mod viscous;

pub use adaptive::Adaptive;
pub use assembly::Linearisation;
pub use clock::{Phase, PhaseClock};
pub use compliant::{Colouring, CompliantAngles, PositionBased, Substep};
pub use contact::{Change, ContactSet, MultistepMotion, Wanted};
pub use elongation::{ElongationLimit, ElongationSettings, SweepOrder};
pub use error::{PrepareError, StepError};
pub use explicit_kick::{ExplicitKick, damping_has_directions, is_damped, write_damping_force};
pub use explicit_limit::ExplicitNumbers;
pub use forcing::{Forcing, ForcingKind, ForcingRule};
pub use history::History;
pub use implicit::Implicit;
pub use impulsive::ImpulsiveContacts;
pub use kept_force::KeptForce;
pub use kinematics::{change_each, drift, each_particle, kick};
pub use ledger::{Bookkeeping, EnergyLedger, as_stepped, momentum_between, subtract_laplacian};
pub use linear::{LaplacianSolver, LinearSettings, PreconditionerKind, SolverKind, Weights};
pub use method::{Method, Order, Quantity, StabilityClass, Support, Supports, Treatment};
pub use newton::{Newton, NewtonReport, NewtonSettings};
pub use newton_linear::{Jacobian, NewtonLinear, NewtonSolver};
pub use newton_safeguard::Safeguard;
pub use pins::{hold_pins, lead_pins};
pub use potential::{IncrementalPotential, Tau};
pub use predictor::{Predictor, Start};
pub use report::{SetupCause, Setups, StepReport};
pub use scheme::{Past, Registration, Rewind, Scheme, Stepper, Taken};
pub use scratch::Scratch;
pub use settings::{
    Declared, Declares, Kind, MethodSettings, Setting, SettingError, Settings, Value, Word,
};
#[doc(hidden)]
pub use settings::{count, join};
pub use spectrum::{DampingBound, LargestEigenvalue, StiffnessBound};
pub use split::{Slopes, Split};
pub use stability_limit::{StabilityLimit, StepControl};
pub use stage::{ImplicitStage, Stage, StageSettings};
pub use stage_memory::StageMemory;
pub use step_control::{Decision, LocalError, StepController, TOLERANCE, mesh_width};
pub use step_size::{InvalidTimeStep, TimeStep};
pub use stop_test::{StepReference, StepStart, StopNorm, lightest_free_mass};
pub use viscous::ViscousImpulse;

pub use drape_solvers::{Constraints, SolveStatus};

use drape_model::{State, System};

/// A time integrator: it advances a state by one step.
pub trait Integrator: std::fmt::Debug + Send {
    /// Description of the method: id, order, settings and supported effects.
    fn method(&self) -> &'static Method;

    /// Allocates and fills everything that a step of length `h` needs.
    ///
    /// # Errors
    /// [`PrepareError`] if the method does not support an effect of the system, or if an operator
    /// cannot be built.
    fn prepare(&mut self, system: &System, h: TimeStep) -> Result<(), PrepareError>;

    /// Advances `state` by exactly `h`, without allocating.
    ///
    /// # Errors
    /// [`StepError`] for a broken contract. The state is unchanged.
    fn step(
        &mut self,
        system: &System,
        state: &mut State,
        h: TimeStep,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError>;

    /// The change of the total energy in the last step, cause by cause. The arguments are the
    /// states before and after the step, its length and its system. The result is `None` if the
    /// method has no energy identity, as multistep methods and divided steps.
    ///
    /// This is a diagnosis to call right after [`step`](Self::step): it may allocate, and a step
    /// does no work for it. Changes of the system between steps do not count.
    fn ledger(
        &mut self,
        _system: &System,
        _before: &State,
        _after: &State,
        _h: TimeStep,
    ) -> Option<EnergyLedger> {
        None
    }

    /// Forgets the history (predictor, contacts). Call it after changing the state.
    fn restart(&mut self, state: &State);
}

#[doc = include_str!("../docs/equations.md")]
pub mod equations {}
