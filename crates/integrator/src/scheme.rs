//! The trait that a method's crate implements, and the integrator around it.
//!
//! A method is a [`Scheme`]: the memory of a step, its allocation, and the step. [`Stepper`] adds
//! the parts that all methods share: it refuses unsupported effects, keeps the memory, checks it
//! against the system, and stops the clock. A method that can take a step back is also [`Rewind`],
//! and [`Adaptive`] can control its step size.

use crate::{
    Adaptive, ContactSet, EnergyLedger, History, Integrator, Method, MethodSettings, Order,
    PhaseClock, Predictor, PrepareError, Scratch, SettingError, Settings, StepError, StepReport,
    TimeStep,
};
use drape_model::{State, System, Vec3};
use std::fmt::Debug;

/// A method. The implementing type is the memory of its steps.
pub trait Scheme: Debug + Send + Sized + 'static {
    /// Settings of the method.
    type Settings: Debug + Clone + Send + 'static;

    /// Description of the method.
    fn method(settings: &Self::Settings) -> &'static Method;

    /// Allocates and fills everything that a step of `h` seconds needs.
    ///
    /// # Errors
    /// [`PrepareError`] if an operator cannot be built.
    fn new(system: &System, settings: &Self::Settings, h: f64) -> Result<Self, PrepareError>;

    /// Advances `state` by `h` seconds, without allocating.
    ///
    /// # Errors
    /// [`StepError`] for a broken contract. The state is unchanged.
    fn step(
        &mut self,
        settings: &Self::Settings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError>;

    /// Forgets the history and the contacts.
    fn restart(&mut self);

    /// The energy ledger of the last step; see [`Integrator::ledger`].
    fn ledger(&mut self, _settings: &Self::Settings, _taken: &Taken<'_>) -> Option<EnergyLedger> {
        None
    }

    /// Whether results have the same bits on every machine. They have if no library factorises.
    fn is_portable(settings: &Self::Settings) -> bool;

    /// Whether the order of the springs affects the result by more than round-off.
    fn follows_springs(_settings: &Self::Settings) -> bool {
        false
    }
}

/// A step that was taken, for the ledger.
#[derive(Clone, Copy, Debug)]
pub struct Taken<'a> {
    /// System of the step.
    pub system: &'a System,
    /// State before the step.
    pub before: &'a State,
    /// State after the step.
    pub after: &'a State,
    /// Length of the step.
    pub h: TimeStep,
}

/// A scheme as an [`Integrator`].
#[derive(Debug)]
pub struct Stepper<S: Scheme> {
    pub(crate) settings: S::Settings,
    scratch: Scratch<S>,
}

impl<S: Scheme> Default for Stepper<S>
where
    S::Settings: Default,
{
    fn default() -> Self {
        Self::new(S::Settings::default())
    }
}

impl<S: Scheme> Stepper<S> {
    /// The method with its settings.
    pub fn new(settings: S::Settings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }

    /// The settings of the method.
    pub fn settings(&self) -> &S::Settings {
        &self.settings
    }

    /// The memory of the method's steps; `None` before `prepare`.
    pub fn prepared(&mut self) -> Option<&mut S> {
        self.scratch.get_mut()
    }
}

impl<S: Rewind> Stepper<S> {
    /// The method, under step size control if the settings ask for it.
    pub fn controlled(settings: S::Settings) -> Box<dyn Integrator> {
        let tolerance = S::tolerance(&settings);
        let method = Self::new(settings);
        if tolerance > 0.0 { Box::new(Adaptive::new(method, tolerance)) } else { Box::new(method) }
    }
}

impl<S: Scheme> Integrator for Stepper<S> {
    fn method(&self) -> &'static Method {
        S::method(&self.settings)
    }

    fn prepare(&mut self, system: &System, h: TimeStep) -> Result<(), PrepareError> {
        self.method().check(system)?;
        self.scratch.set(system, S::new(system, &self.settings, h.seconds())?);
        Ok(())
    }

    fn step(
        &mut self,
        system: &System,
        state: &mut State,
        h: TimeStep,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let scheme = self.scratch.ready(system, state, h)?;
        let report = scheme.step(&self.settings, system, state, h.seconds(), clock)?;
        clock.stop();
        Ok(report)
    }

    fn ledger(
        &mut self,
        system: &System,
        before: &State,
        after: &State,
        h: TimeStep,
    ) -> Option<EnergyLedger> {
        let taken = Taken { system, before, after, h };
        self.scratch.get_mut()?.ledger(&self.settings, &taken)
    }

    fn restart(&mut self, _state: &State) {
        if let Some(scheme) = self.scratch.get_mut() {
            scheme.restart();
        }
    }
}

/// The memory that a step changes and that the next step reads, except contacts and cached
/// operators.
pub trait Past: Clone + Debug + Send {
    /// Copies another past of the same size without allocating.
    fn copy_from(&mut self, other: &Self);
}

impl Past for Predictor {
    fn copy_from(&mut self, other: &Self) {
        self.copy_from(other);
    }
}

impl<const FIELDS: usize> Past for History<FIELDS> {
    fn copy_from(&mut self, other: &Self) {
        self.copy_from(other);
    }
}

/// A scheme whose steps can be undone. Step size control needs no more.
pub trait Rewind: Scheme {
    /// Memory of the past, except contacts.
    type Past: Past;

    /// The memory of the past and the contacts.
    fn past(&mut self) -> (&mut Self::Past, &mut ContactSet);

    /// Local error that a step may make, in mesh widths; 0 if the method takes steps as given.
    fn tolerance(settings: &Self::Settings) -> f64;

    /// Order of accuracy with these settings.
    fn order(settings: &Self::Settings) -> Order {
        Self::method(settings).order
    }

    /// The error constant `C(ω)` of the local error `C h³ x'''` of a method of order 2. `ω` is the
    /// ratio of the last step to the step before it. The default is the constant of two-step BDF.
    fn error_constant(_settings: &Self::Settings, omega: f64) -> f64 {
        let sum = 1.0 + omega;
        sum * sum / (6.0 * omega * (1.0 + 2.0 * omega))
    }

    /// Adds to `error`, m, the part of the error that positions cannot show, after a step of `h`
    /// seconds to the state `to`. A method that splits the force adds the error of the part that it
    /// takes at the old level. The report counts the costs.
    fn add_splitting_error(
        &mut self,
        _settings: &Self::Settings,
        _system: &System,
        _to: &State,
        _h: f64,
        _error: &mut [Vec3],
        _report: &mut StepReport,
    ) {
    }
}

/// A method as the registry stores it, in one line.
#[derive(Clone, Copy, Debug)]
pub struct Registration {
    /// Description of the method.
    pub method: &'static Method,
    /// Makes an integrator from checked settings.
    pub build: fn(&Settings) -> Result<Box<dyn Integrator>, SettingError>,
    /// Whether results have the same bits on every machine.
    pub is_portable: fn(&Settings) -> bool,
    /// Whether the order of the springs affects the result by more than round-off.
    pub follows_springs: fn(&Settings) -> bool,
}

impl Registration {
    /// A method that takes steps as given.
    pub const fn new<S: Scheme>(method: &'static Method) -> Self
    where
        S::Settings: MethodSettings,
    {
        Self {
            method,
            build: |settings| Ok(Box::new(Stepper::<S>::new(S::Settings::of(settings)?))),
            is_portable: |settings| S::Settings::of(settings).is_ok_and(|s| S::is_portable(&s)),
            follows_springs: |settings| {
                S::Settings::of(settings).is_ok_and(|s| S::follows_springs(&s))
            },
        }
    }

    /// A method whose settings may put it under step size control.
    pub const fn controlled<S: Rewind>(method: &'static Method) -> Self
    where
        S::Settings: MethodSettings,
    {
        Self {
            build: |settings| Ok(Stepper::<S>::controlled(S::Settings::of(settings)?)),
            ..Self::new::<S>(method)
        }
    }
}
