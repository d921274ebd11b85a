//! The methods, and what is turned from one run to the next.

use crate::HarnessError;
use crate::methods::Choice;
use crate::studies::variant::is_explicit;

/// What differs between the runs of a variant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Knob {
    /// The number of steps, doubled from run to run.
    Steps,
    /// A setting of the method, which divides the steps that it is given: its name and values,
    /// coarsest first.
    Setting(&'static str, &'static [f64]),
    /// The tolerance of the adaptive method of a library.
    Library(&'static [f64]),
}

/// A method in certain settings, with a knob.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Variant {
    /// Short name for tables and legends.
    pub(super) label: &'static str,
    /// Method id with settings, as [`Choice::parse`] reads it; [`DOP853`] for the library.
    pub(super) method: &'static str,
    pub(super) knob: Knob,
    /// Where it is run.
    scope: Scope,
}

/// Where a variant is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scope {
    /// Everywhere, all its runs timed; it stands in the headline figure.
    Headline,
    /// Everywhere.
    Main,
    /// In the series over the stiffness with light damping only.
    Extra,
}

pub(super) const DOP853: &str = "dop853";
const TOLERANCES: &[f64] = &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];
/// Substep of the leapfrog method over its stability limit.
const SAFETIES: &[f64] = &[0.95, 0.5, 0.25, 0.125, 0.0625];

/// Local error of positions that a method under step size control may make, in mesh widths.
const LOCAL_ERRORS: &[f64] = &[1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 0.001];

const fn headline(label: &'static str, method: &'static str, knob: Knob) -> Variant {
    Variant { label, method, knob, scope: Scope::Headline }
}

const fn main(label: &'static str, method: &'static str) -> Variant {
    Variant { label, method, knob: Knob::Steps, scope: Scope::Main }
}

const fn extra(label: &'static str, method: &'static str) -> Variant {
    Variant { label, method, knob: Knob::Steps, scope: Scope::Extra }
}

/// A method under step size control.
const fn adaptive(label: &'static str, method: &'static str) -> Variant {
    Variant { knob: Knob::Setting("tolerance", LOCAL_ERRORS), ..extra(label, method) }
}

/// One line a variant; every method of the registry is among them.
pub(super) const VARIANTS: &[Variant] = &[
    headline(DOP853, DOP853, Knob::Library(TOLERANCES)),
    main("explicit-euler", "explicit-euler"),
    headline("symplectic-euler", "symplectic-euler", Knob::Steps),
    headline("leapfrog", "leapfrog:step=bound", Knob::Setting("safety", SAFETIES)),
    Variant {
        knob: Knob::Setting("safety", SAFETIES),
        ..extra("leapfrog, CG", "leapfrog:step=bound,solver=cg")
    },
    extra("leapfrog, fixed steps", "leapfrog"),
    main("provot", "provot"),
    main("adams-bashforth2", "adams-bashforth2"),
    extra("adams-bashforth, 3 steps", "adams-bashforth2:steps=3"),
    main("backward-euler", "backward-euler:residual=1e-3"),
    extra("backward-euler, tight", "backward-euler"),
    headline("bdf2", "bdf2:residual=1e-3", Knob::Steps),
    extra("bdf2, tight", "bdf2"),
    main("terzopoulos-fleischer", "terzopoulos-fleischer"),
    headline("baraff-witkin", "baraff-witkin", Knob::Steps),
    extra("baraff-witkin, Cholesky", "baraff-witkin:solver=cholesky"),
    main("desbrun", "desbrun"),
    main("kang", "kang"),
    extra("kang, 8 sweeps", "kang:sweeps=8"),
    headline("imex-euler", "imex-euler", Knob::Steps),
    extra("imex-euler, all springs, Cholesky", "imex-euler:implicit=springs,solver=cholesky"),
    headline("imex-updated", "imex-updated", Knob::Steps),
    extra("imex-updated, ε = 1e-6", "imex-updated:forcing_term=1e-6"),
    extra("imex-updated, as printed", "imex-updated:safeguard=paper,norm=euclid"),
    main("imex-sbdf2", "imex-sbdf2"),
    extra("imex-sbdf2, Cholesky", "imex-sbdf2:solver=cholesky"),
    main("imex-cnab2", "imex-cnab2"),
    main("imex-mcnab2", "imex-mcnab2"),
    main("imex-cnlf", "imex-cnlf"),
    adaptive("backward-euler, adaptive", "backward-euler:residual=1e-3"),
    adaptive("bdf2, adaptive", "bdf2:residual=1e-3"),
    adaptive("imex-euler, adaptive", "imex-euler"),
    adaptive("imex-updated, adaptive", "imex-updated"),
    adaptive("imex-sbdf2, adaptive", "imex-sbdf2"),
];

impl Variant {
    /// Whether it stands in the headline figure.
    pub(super) fn is_headline(&self) -> bool {
        self.scope == Scope::Headline
    }

    /// Whether it is run outside the series over the stiffness with light damping too.
    pub(super) fn is_run_everywhere(&self) -> bool {
        self.scope != Scope::Extra
    }

    /// The method at a value of the knob; `None` for the library.
    pub(super) fn choice(&self, value: f64) -> Result<Option<Choice>, HarnessError> {
        let more = match self.knob {
            Knob::Steps => Vec::new(),
            Knob::Setting(key, _) => vec![format!("{key}={value}")],
            Knob::Library(_) => return Ok(None),
        };
        Ok(Some(Choice::parse(self.method, &more)?))
    }

    /// Name of what is turned.
    pub(super) fn knob_name(&self) -> &'static str {
        match self.knob {
            Knob::Steps => "steps",
            Knob::Setting(key, _) => key,
            Knob::Library(_) => "tolerance",
        }
    }
}

/// Whether the stiffness limits the step of what stands behind a label.
pub(super) fn is_limited_by_stiffness(method: &str) -> bool {
    method == DOP853 || Choice::parse(method, &[]).is_ok_and(|choice| is_explicit(choice.method()))
}
