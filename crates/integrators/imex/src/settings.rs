//! What the two methods of order 1 are, and their settings.

use drape_integrator::{
    ForcingRule, Implicit, Kind, LinearSettings, Method, Order, Quantity, Setting, SettingError,
    Settings, Split, StabilityClass, Start, Support, TOLERANCE, Treatment,
    linear_settings as linear,
};

pub(crate) const SUPPORTS: &[Support] = &[
    Support::new("tension", Treatment::Implicit),
    Support::new("shear", Treatment::BySetting),
    Support::new("bending", Treatment::BySetting),
    Support::new("shear_angle", Treatment::Explicit),
    Support::new("bending_angle", Treatment::Explicit),
    Support::new("bending_hinge", Treatment::Explicit),
    Support::new("gravity", Treatment::Explicit),
    Support::new("air", Treatment::Explicit),
    Support::new("pins", Treatment::Constraint),
    Support::new("contact", Treatment::Constraint),
    Support::new("friction", Treatment::Constraint),
];

/// The same without friction, which CNLF does not take: what friction stops would go to and fro for ever. Its difference
/// formula joins every other level, `x_{n+1} = x_{n−1} + h (v_{n+1} + v_{n−1})`; once the velocities are 0, `x_{n+1} = x_{n−1}`,
/// and the two positions between which the particle came to rest take turns.
pub(crate) const SUPPORTS_WITHOUT_FRICTION: &[Support] = match SUPPORTS {
    [others @ .., _friction] => others,
    [] => &[],
};

const fn forcing_term(default: &'static str) -> Setting {
    Setting {
        key: "forcing_term",
        kind: Kind::Number { min: 1e-16, max: 0.5 },
        default,
        help: "relative tolerance ε of the solve",
    }
}

const fn implicit(default: &'static str) -> Setting {
    Setting {
        key: "implicit",
        kind: Kind::Choice(&["tension", "springs"]),
        default,
        help: "which springs stand in the matrix; the others stay at the old level",
    }
}

pub(crate) const IMPLICIT_SPRINGS: Setting = implicit("springs");

pub(crate) const START: Setting = Setting {
    key: "start",
    kind: Kind::Choice(&["last", "extrapolated"]),
    default: "extrapolated",
    help: "start value of the solve: v_n or 2 v_n - v_{n-1} (EEH 22)",
};

/// How step size control estimates the error of a method that splits the force.
pub(crate) const ESTIMATOR: Setting = Setting {
    key: "estimator",
    kind: Kind::Choice(&["plain", "splitting"]),
    default: "splitting",
    help: "error estimate of step size control: from positions alone, which cannot see locking, or with what the part \
           of the force at the old level is off by",
};

/// Whether the setting `estimator` asks for the splitting error.
pub(crate) fn sees_splitting(settings: &Settings) -> bool {
    settings.word(ESTIMATOR.key) == "splitting"
}

const FORCING: Setting = Setting {
    help: "how tightly CG is solved between two updates of the right-hand side: to the tolerance of the step, or by \
           the progress of the updates (Eisenstat and Walker, choice 2)",
    ..ForcingRule::FORCING
};

const IMPLICIT_BENEFIT: &str = "solved exactly with all springs implicit \
     and full damping it never gains energy; locks for h²k/m above 1";

/// IMEX Euler.
pub static IMEX_EULER: Method = Method {
    id: "imex-euler",
    name: "IMEX Euler",
    source: "EEH (19)-(21)",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: IMPLICIT_BENEFIT,
    supports: SUPPORTS,
    settings: &[
        forcing_term("1e-3"),
        linear::PRECONDITIONER,
        START,
        linear::NORM,
        linear::SOLVER,
        implicit("tension"),
        linear::MATRIX,
        Split::SETTING,
        TOLERANCE,
        ESTIMATOR,
    ],
};

/// IMEX Euler with updated right-hand side.
pub static IMEX_UPDATED: Method = Method {
    id: "imex-updated",
    name: "IMEX Euler with updated CG",
    source: "EEH Algorithm 1",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "its fixed point is backward Euler; the robust form lowers the incremental potential \
             at every iteration; the paper's form may gain energy with a loose ε and the \
             extrapolated start",
    supports: SUPPORTS,
    settings: &[
        forcing_term("1e-2"),
        linear::PRECONDITIONER,
        Setting {
            key: "start",
            kind: Kind::Choice(&["last", "extrapolated", "best"]),
            default: "best",
            help: "start value of the solve; best: whichever has the lower potential \
                   (the paper's form reads it as extrapolated)",
        },
        Setting {
            key: "safeguard",
            kind: Kind::Choice(&["paper", "robust"]),
            default: "robust",
            help: "Algorithm 1 as printed, or with energy safeguards",
        },
        linear::NORM,
        linear::SOLVER,
        IMPLICIT_SPRINGS,
        linear::MATRIX,
        Split::SETTING,
        Setting {
            key: "max_outer",
            kind: Kind::Integer { min: 1, max: 1_000_000 },
            default: "200",
            help: "most updates of the right-hand side in a step; the robust form goes on with Newton",
        },
        Setting {
            key: "newton_above",
            kind: Kind::Number { min: 0.0, max: 1e300 },
            default: "100",
            help: "the robust form uses Newton at once where h²k/m is larger than this",
        },
        FORCING,
        TOLERANCE,
    ],
};

/// Settings of IMEX Euler.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImexEulerSettings {
    /// The linear solve.
    pub linear: LinearSettings,
    /// Start value.
    pub start: Start,
    /// Which springs are implicit.
    pub implicit: Implicit,
    /// What stands in the matrix for springs of several slopes.
    pub split: Split,
    /// Local error that a step may make, in mesh widths; 0: steps are taken as they are given.
    pub tolerance: f64,
    /// Whether the estimate of that error counts the splitting of the force.
    pub sees_splitting: bool,
}

impl ImexEulerSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let settings = Settings::new(IMEX_EULER.id, IMEX_EULER.settings, pairs)?;
        Ok(Self {
            linear: LinearSettings::read(&settings, settings.number("forcing_term")),
            start: Start::read(settings.word("start")),
            implicit: Implicit::read(settings.word("implicit")),
            split: Split::read(settings.word(Split::SETTING.key)),
            tolerance: settings.number(TOLERANCE.key),
            sees_splitting: sees_splitting(&settings),
        })
    }
}

/// Which form of Algorithm 1 runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Safeguard {
    /// As printed.
    Paper,
    /// With energy safeguards.
    Robust,
}

/// Settings of updated CG.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImexUpdatedSettings {
    /// The linear solves.
    pub linear: LinearSettings,
    /// Start value.
    pub start: Start,
    /// Which springs are implicit.
    pub implicit: Implicit,
    /// What stands in the matrix for springs of several slopes.
    pub split: Split,
    /// Which form of the algorithm.
    pub safeguard: Safeguard,
    /// Most updates of the right-hand side in a step.
    pub max_outer: u32,
    /// θ above which the robust form uses Newton at once.
    pub newton_above: f64,
    /// Whether CG between two updates is solved by the progress of the updates, instead of to the end.
    pub follows_progress: bool,
    /// Local error that a step may make, in mesh widths; 0: steps are taken as they are given.
    pub tolerance: f64,
}

impl ImexUpdatedSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let settings = Settings::new(IMEX_UPDATED.id, IMEX_UPDATED.settings, pairs)?;
        Ok(Self {
            linear: LinearSettings::read(&settings, settings.number("forcing_term")),
            start: Start::read(settings.word("start")),
            implicit: Implicit::read(settings.word("implicit")),
            split: Split::read(settings.word(Split::SETTING.key)),
            safeguard: match settings.word("safeguard") {
                "paper" => Safeguard::Paper,
                _ => Safeguard::Robust,
            },
            max_outer: settings.integer("max_outer") as u32,
            newton_above: settings.number("newton_above"),
            follows_progress: settings.word(FORCING.key) == "eisenstat-walker",
            tolerance: settings.number(TOLERANCE.key),
        })
    }
}
