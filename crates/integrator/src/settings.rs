//! Settings of methods: declared once, read from `key=value`, refused with the known ones named.

use crate::{LinearSettings, PreconditionerKind, SolverKind};
use drape_solvers::Norm;
use std::fmt;

/// What values a setting takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A number in a closed range.
    Number {
        /// Least value.
        min: f64,
        /// Greatest value.
        max: f64,
    },
    /// A number in a closed range, or 0, which turns off what it sets.
    OptionalNumber {
        /// Least value but 0.
        min: f64,
        /// Greatest value.
        max: f64,
    },
    /// A whole number in a closed range.
    Integer {
        /// Least value.
        min: u64,
        /// Greatest value.
        max: u64,
    },
    /// One of some words.
    Choice(&'static [&'static str]),
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number { min, max } => write!(f, "a number from {min:e} to {max:e}"),
            Self::OptionalNumber { min, max } => write!(f, "0 or a number from {min:e} to {max:e}"),
            Self::Integer { min, max } => write!(f, "a whole number from {min} to {max}"),
            Self::Choice(words) => write!(f, "{}", words.join("|")),
        }
    }
}

/// Declaration of one setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Its key.
    pub key: &'static str,
    /// What values it takes.
    pub kind: Kind,
    /// Its default, as text.
    pub default: &'static str,
    /// What it does.
    pub help: &'static str,
}

/// Why a setting was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SettingError {
    /// No such key.
    #[error("{method} has no setting `{key}`; expected one of: {known}")]
    Unknown {
        /// Method id.
        method: &'static str,
        /// What was given.
        key: String,
        /// The known keys.
        known: String,
    },
    /// The value does not fit.
    #[error("{method}: setting `{key}` is `{value}`; expected {expected}")]
    Value {
        /// Method id.
        method: &'static str,
        /// The key.
        key: &'static str,
        /// What was given.
        value: String,
        /// What is allowed.
        expected: String,
    },
    /// The value does not go with that of another setting.
    #[error("{method}: setting `{key}` does not go with `{other}`; {advice}")]
    Conflict {
        /// Method id.
        method: &'static str,
        /// The key.
        key: &'static str,
        /// The other setting with its value.
        other: &'static str,
        /// What to do instead.
        advice: &'static str,
    },
    /// The key was given twice.
    #[error("{method}: setting `{key}` is given twice; expected it once")]
    Twice {
        /// Method id.
        method: &'static str,
        /// The key.
        key: &'static str,
    },
}

/// The values of all settings of a method, defaults filled in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    values: Vec<(&'static str, String)>,
}

impl Settings {
    /// Checks `pairs` against a method's declarations and fills in the defaults.
    ///
    /// # Errors
    /// An unknown key, a key given twice, or a value that does not fit.
    pub fn new<'a>(
        method: &'static str,
        declared: &'static [Setting],
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let mut values: Vec<(&'static str, Option<String>)> =
            declared.iter().map(|setting| (setting.key, None)).collect();
        for (key, value) in pairs {
            let Some(position) = declared.iter().position(|setting| setting.key == key) else {
                let known: Vec<_> = declared.iter().map(|setting| setting.key).collect();
                let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
                return Err(SettingError::Unknown { method, key: key.to_owned(), known });
            };
            let Setting { key, kind, .. } = declared[position];
            let fits = match kind {
                Kind::Number { min, max } => value.parse().is_ok_and(|v: f64| v >= min && v <= max),
                Kind::OptionalNumber { min, max } => {
                    value.parse().is_ok_and(|v: f64| v == 0.0 || (v >= min && v <= max))
                }
                Kind::Integer { min, max } => {
                    value.parse().is_ok_and(|v: u64| v >= min && v <= max)
                }
                Kind::Choice(words) => words.contains(&value),
            };
            if !fits {
                let (value, expected) = (value.to_owned(), kind.to_string());
                return Err(SettingError::Value { method, key, value, expected });
            }
            if values[position].1.replace(value.to_owned()).is_some() {
                return Err(SettingError::Twice { method, key });
            }
        }
        let fill = |((key, value), setting): ((&'static str, Option<String>), &Setting)| {
            (key, value.unwrap_or_else(|| setting.default.to_owned()))
        };
        Ok(Self { values: values.into_iter().zip(declared).map(fill).collect() })
    }

    /// Keys and values in the order of declaration.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &str)> {
        self.values.iter().map(|(key, value)| (*key, value.as_str()))
    }

    /// The value of a declared key. Keys are literals of the method's own crate, so that a missing
    /// one is a slip of its author, which every test of the method meets: it reads as empty text.
    pub fn word(&self, key: &str) -> &str {
        let value = self.iter().find(|(known, _)| *known == key).map(|(_, value)| value);
        debug_assert!(value.is_some(), "setting `{key}` is not declared");
        value.unwrap_or_default()
    }

    /// A declared number.
    pub fn number(&self, key: &str) -> f64 {
        self.word(key).parse().unwrap_or(f64::NAN)
    }

    /// A declared whole number.
    pub fn integer(&self, key: &str) -> usize {
        self.word(key).parse().unwrap_or_default()
    }
}

/// Declarations of the settings that every method with a linear solve shares.
pub mod linear_settings {
    use super::{Kind, Setting};

    /// Preconditioner of CG.
    pub const PRECONDITIONER: Setting = Setting {
        key: "preconditioner",
        kind: Kind::Choice(&["none", "jacobi", "ic0", "auto"]),
        default: "ic0",
        help: "preconditioner of the conjugate gradients; auto: the faster of jacobi and ic0, by estimates from the matrix",
    };
    /// Norm of the stop test.
    pub const NORM: Setting = Setting {
        key: "norm",
        kind: Kind::Choice(&["euclid", "preconditioned"]),
        default: "euclid",
        help: "norm in which the residual is tested (updated CG, robust: always that of the inverse mass)",
    };
    /// Solver.
    pub const SOLVER: Setting = Setting {
        key: "solver",
        kind: Kind::Choice(&["cg", "cholesky", "auto"]),
        default: "cg",
        help: "conjugate gradients, or a direct solve by sparse Cholesky (with contacts: CG to 1e-13, \
               preconditioned by it); preconditioner, norm and the linear tolerance then do not count; auto: the \
               faster of the two, by estimates from the matrix",
    };
    /// Whether the matrix is kept.
    pub const MATRIX: Setting = Setting {
        key: "matrix",
        kind: Kind::Choice(&["kept", "rebuilt"]),
        default: "kept",
        help: "set the matrix up only when it changes, or in each step as varying moduli would need",
    };
}

impl LinearSettings {
    /// Reads the four shared settings, all of which the method must declare.
    pub fn read(settings: &Settings, forcing_term: f64) -> Self {
        Self {
            forcing_term,
            preconditioner: match settings.word("preconditioner") {
                "none" => PreconditionerKind::None,
                "jacobi" => PreconditionerKind::Jacobi,
                "auto" => PreconditionerKind::Auto,
                _ => PreconditionerKind::Ic0,
            },
            norm: match settings.word("norm") {
                "preconditioned" => Norm::Preconditioned,
                _ => Norm::Euclid,
            },
            solver: match settings.word("solver") {
                "cholesky" => SolverKind::Cholesky,
                "auto" => SolverKind::Auto,
                _ => SolverKind::Cg,
            },
            rebuild_every_step: settings.word("matrix") == "rebuilt",
        }
    }
}
