//! The command with methods that a user adds.

use crate::cli;
use drape_harness::{methods, studies::Allocated};
use drape_integrator::Registration;
use std::process::ExitCode;

/// The `drape` command with your own methods: a binary of a few lines that has every subcommand and
/// every study, and includes your methods.
///
/// ```no_run
/// use drape::integrator::*;
/// use drape::model::{State, System, Vec3};
///
/// static METHOD: Method = Method {
///     id: "my-euler",
///     name: "symplectic Euler of my own",
///     source: "Euler-Cromer",
///     order: Order::One,
///     class: StabilityClass::Symplectic,
///     conserves: &[Quantity::Momentum],
///     theory: "stable up to h² k/m = 4 without damping",
///     supports: Supports::Explicit,
///     refuses: &["contact", "friction", "moving pins", "moving obstacles"],
///     settings: &[],
/// };
///
/// /// The force on each particle, N.
/// #[derive(Debug)]
/// struct MyEuler(Vec<Vec3>);
///
/// impl Scheme for MyEuler {
///     type Settings = ();
///     fn method(_: &()) -> &'static Method {
///         &METHOD
///     }
///     fn new(system: &System, _: &(), _h: f64) -> Result<Self, PrepareError> {
///         Ok(Self(vec![Vec3::zeros(); system.len()]))
///     }
///     fn step(
///         &mut self,
///         _: &(),
///         system: &System,
///         state: &mut State,
///         h: f64,
///         _: &mut PhaseClock,
///     ) -> Result<StepReport, StepError> {
///         system.forces(state.level(), &mut self.0);
///         for i in (0..system.len()).filter(|i| !system.pinned()[*i]) {
///             state.v[i] += self.0[i] * (h / system.mass()[i]); // v ← v + h f/m
///             state.x[i] += state.v[i] * h; // x ← x + h v
///         }
///         state.t += h;
///         Ok(StepReport { force_evaluations: 1, ..StepReport::default() })
///     }
///     fn restart(&mut self) {}
///     fn is_portable(_: &()) -> bool {
///         true
///     }
/// }
///
/// fn main() -> std::process::ExitCode {
///     drape::Drape::new().with(Registration::new::<MyEuler>(&METHOD)).main()
/// }
/// ```
///
/// [`examples::write_a_method`](crate::examples::write_a_method) is a complete example. A study
/// runs an added method at its defaults, after all others. `--methods MY-METHOD` runs only that
/// method. Its results go into `results-own` by default. Figures show it among the "Other methods".
#[derive(Debug, Default)]
#[must_use]
pub struct Drape {
    methods: Vec<Registration>,
    allocated: Option<Allocated>,
}

impl Drape {
    /// The command without additional methods.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a method. Its id must be new; [`main`](Self::main) refuses an id that exists.
    pub fn with(mut self, method: Registration) -> Self {
        self.methods.push(method);
        self
    }

    /// Lets studies of memory ask how many bytes the process holds. This requires a program that
    /// counts them in its allocator.
    pub fn counting(mut self, allocated: Allocated) -> Self {
        self.allocated = Some(allocated);
        self
    }

    /// Reads the command line, runs the command and returns the exit code.
    pub fn main(self) -> ExitCode {
        if let Some(allocated) = self.allocated {
            cli::count_with(allocated);
        }
        for method in self.methods {
            if let Err(error) = methods::add(method) {
                return cli::refuse(error);
            }
        }
        cli::main()
    }
}
