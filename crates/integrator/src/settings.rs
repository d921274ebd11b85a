//! Settings of methods. [`settings!`](crate::settings) declares each of them once. [`Settings`]
//! reads them from `key=value`. An error lists the known keys or values.

use std::fmt;

/// The values that a setting accepts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A number in a closed range.
    Number {
        /// Least value.
        min: f64,
        /// Greatest value.
        max: f64,
    },
    /// A number in a closed range, or 0 for off.
    OptionalNumber {
        /// Least value except 0.
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
    /// One of these words.
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
    /// Key of the setting.
    pub key: &'static str,
    /// The values that the setting accepts.
    pub kind: Kind,
    /// Default, as text.
    pub default: &'static str,
    /// Description for the user.
    pub help: &'static str,
}

/// Why a setting was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SettingError {
    /// There is no such key.
    #[error("{method} has no setting `{key}`; expected one of: {known}")]
    Unknown {
        /// Method id.
        method: &'static str,
        /// The key that was given.
        key: String,
        /// The known keys, as a list in text.
        known: String,
    },
    /// The value is not allowed.
    #[error("{method}: setting `{key}` is `{value}`; expected {expected}")]
    Value {
        /// Method id.
        method: &'static str,
        /// The key.
        key: &'static str,
        /// The value that was given.
        value: String,
        /// The allowed values.
        expected: String,
    },
    /// The value excludes the value of another setting.
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

/// The values of all settings of a method, with defaults filled in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    values: Vec<(&'static str, String)>,
}

impl Settings {
    /// Checks `pairs` of key and value against a method's declarations, and fills in the defaults.
    ///
    /// # Errors
    /// A [`SettingError`] if a key is unknown or given twice, or if a value is not allowed.
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

    /// The value of a key, as text; `None` if the method does not have the key.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.iter().find(|(known, _)| *known == key).map(|(_, value)| value)
    }

    /// The value of a declared key, as text. A missing key is a bug: debug builds assert, release
    /// builds return an empty string.
    pub fn word(&self, key: &str) -> &str {
        let value = self.get(key);
        debug_assert!(value.is_some(), "setting `{key}` is not declared");
        value.unwrap_or_default()
    }

    /// The value of a declared number.
    pub fn number(&self, key: &str) -> f64 {
        self.word(key).parse().unwrap_or(f64::NAN)
    }
}

/// A type that a setting can have.
pub trait Value: Copy {
    /// Reads a text that fits the [`Kind`] of the setting. Returns `None` for any other text.
    fn read(text: &str) -> Option<Self>;
}

/// A type with few values, one word each.
pub trait Word: Copy + 'static {
    /// All words, in the order in which messages list them.
    const WORDS: &'static [(&'static str, Self)];
}

impl<T: Word> Value for T {
    fn read(text: &str) -> Option<Self> {
        Self::WORDS.iter().find(|(word, _)| *word == text).map(|(_, value)| *value)
    }
}

impl Word for bool {
    const WORDS: &'static [(&'static str, Self)] = &[("false", false), ("true", true)];
}

impl Value for f64 {
    fn read(text: &str) -> Option<Self> {
        text.parse().ok()
    }
}

impl Value for u32 {
    fn read(text: &str) -> Option<Self> {
        text.parse().ok()
    }
}

impl Value for usize {
    fn read(text: &str) -> Option<Self> {
        text.parse().ok()
    }
}

/// A setting with its typed default.
#[derive(Clone, Copy, Debug)]
pub struct Declared<T> {
    /// The setting as text.
    pub setting: Setting,
    /// Its default.
    pub default: T,
}

impl<T: Value> Declared<T> {
    /// Reads the value from `settings`. Returns the default if the method does not have this
    /// setting.
    pub fn read(&self, settings: &Settings) -> T {
        settings.get(self.setting.key).and_then(T::read).unwrap_or(self.default)
    }
}

/// A group of settings that [`settings!`](crate::settings) declares.
pub trait Declares: Sized {
    /// The declarations of the settings.
    const SETTINGS: &'static [Setting];

    /// Reads checked settings.
    fn read(settings: &Settings) -> Self;
}

/// The settings of one method, some of which may exclude each other.
pub trait MethodSettings: Sized {
    /// Reads checked settings.
    ///
    /// # Errors
    /// [`SettingError::Conflict`] if values do not go together.
    fn of(settings: &Settings) -> Result<Self, SettingError>;
}

/// A method without settings.
impl MethodSettings for () {
    fn of(_settings: &Settings) -> Result<Self, SettingError> {
        Ok(())
    }
}

/// Joins lists of declarations into one array of `N` entries.
///
/// # Panics
/// If there are more than `N` entries.
#[doc(hidden)]
pub const fn join<const N: usize>(lists: &[&[Setting]]) -> [Setting; N] {
    const NOTHING: Setting = Setting { key: "", kind: Kind::Choice(&[]), default: "", help: "" };
    let (mut all, mut count, mut list) = ([NOTHING; N], 0, 0);
    while list < lists.len() {
        let mut place = 0;
        while place < lists[list].len() {
            all[count] = lists[list][place];
            (count, place) = (count + 1, place + 1);
        }
        list += 1;
    }
    all
}

/// Total number of declarations in several lists.
#[doc(hidden)]
pub const fn count(lists: &[&[Setting]]) -> usize {
    let (mut count, mut list) = (0, 0);
    while list < lists.len() {
        count += lists[list].len();
        list += 1;
    }
    count
}

/// One [`Declared`] setting: `declare!(key: Type … = default, "help")`, with the forms of
/// [`settings!`](crate::settings).
#[macro_export]
macro_rules! declare {
    ($key:ident: bool = $default:tt, $($help:literal)+) => {
        $crate::declare!(
            @ $key, $crate::Kind::Choice(&["false", "true"]), stringify!($default), $default,
            $($help)+
        )
    };
    ($key:ident: f64 in $min:literal ..= $max:literal = $default:literal, $($help:literal)+) => {
        $crate::declare!(
            @ $key, $crate::Kind::Number { min: $min, max: $max }, stringify!($default),
            $default as f64, $($help)+
        )
    };
    (
        $key:ident: f64 off or in $min:literal ..= $max:literal = $default:literal,
        $($help:literal)+
    ) => {
        $crate::declare!(
            @ $key, $crate::Kind::OptionalNumber { min: $min, max: $max }, stringify!($default),
            $default as f64, $($help)+
        )
    };
    ($key:ident: u32 in $min:literal ..= $max:literal = $default:literal, $($help:literal)+) => {
        $crate::declare!(
            @ $key, $crate::Kind::Integer { min: $min, max: $max }, stringify!($default), $default,
            $($help)+
        )
    };
    ($key:ident: usize in $min:literal ..= $max:literal = $default:literal, $($help:literal)+) => {
        $crate::declare!(
            @ $key, $crate::Kind::Integer { min: $min, max: $max }, stringify!($default), $default,
            $($help)+
        )
    };
    ($key:ident: $type:ident [$($word:ident),+] = $default:ident, $($help:literal)+) => {
        $crate::declare!(
            @ $key, $crate::Kind::Choice(&[$($crate::declare!(word $type $word)),+]),
            $crate::declare!(word $type $default), $type::$default, $($help)+
        )
    };
    (word $type:ident $variant:ident) => {
        const {
            let words = <$type as $crate::Word>::WORDS;
            let mut place = 0;
            while !matches!(words[place].1, $type::$variant) {
                place += 1;
            }
            words[place].0
        }
    };
    (@ $key:ident, $kind:expr, $text:expr, $default:expr, $($help:literal)+) => {
        $crate::Declared {
            setting: $crate::Setting {
                key: stringify!($key),
                kind: $kind,
                default: $text,
                help: concat!($($help),+).trim_ascii_start(),
            },
            default: $default,
        }
    };
}

/// Declares the settings of a method, or a group of settings that several methods share.
///
/// One line a setting gives the field, range, default and help (the doc comment), and the code that
/// reads and lists it. The forms are
///
/// ```text
/// sweeps: u32 in 1..=64 = 1,              a whole number
/// limit: f64 in 1e-4..=10.0 = 0.1,        a number
/// clamp: bool = false,                    a switch
/// torque: Torque [None, Literal] = None,  some words of an enum that has the trait `Word`
/// norm: Norm as NORM,                     a `Declared` constant, which several methods share
/// stage: StageSettings,                   a group with a declaration of its own
/// ```
///
/// `for METHOD` adds `from_pairs`. `checked by function` adds a function that refuses values which
/// exclude each other.
///
/// ```
/// use drape_integrator::{Declares, Word, settings};
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// pub enum Way { Forward, Backward }
/// impl Word for Way {
///     const WORDS: &'static [(&'static str, Self)] =
///         &[("forward", Self::Forward), ("backward", Self::Backward)];
/// }
/// settings! {
///     /// How springs are shortened.
///     pub struct Shortening {
///         /// most sweeps over the springs
///         sweeps: u32 in 1..=1000 = 3,
///         /// order in which a sweep visits them
///         order: Way [Forward, Backward] = Backward,
///     }
/// }
/// assert_eq!(Shortening::default().order, Way::Backward);
/// assert_eq!(Shortening::SETTINGS[1].default, "backward");
/// ```
#[macro_export]
macro_rules! settings {
    (
        $(#[$meta:meta])*
        $visibility:vis struct $Name:ident $(for $METHOD:ident $(, checked by $check:ident)?)? {
            $(
                $(#[doc = $help:literal])*
                $field:ident: $type:ident $([$($word:ident),+ $(,)?])?
                    $(in $min:literal ..= $max:literal)? $(= $default:tt)? $(as $shared:path)?
            ),* $(,)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        $visibility struct $Name {
            $(
                $(#[doc = $help])*
                pub $field: $type,
            )*
        }

        impl $crate::Declares for $Name {
            const SETTINGS: &'static [$crate::Setting] = {
                const LISTS: &[&[$crate::Setting]] = &[$(
                    $crate::settings!(@list $field $type [$($help)*]
                        { $([$($word),+])? $(in $min ..= $max)? $(= $default)? $(as $shared)? })
                ),*];
                &$crate::join::<{ $crate::count(LISTS) }>(LISTS)
            };

            fn read(settings: &$crate::Settings) -> Self {
                let _ = settings;
                Self { $(
                    $field: $crate::settings!(@read settings $field $type [$($help)*]
                        { $([$($word),+])? $(in $min ..= $max)? $(= $default)? $(as $shared)? })
                ),* }
            }
        }

        impl Default for $Name {
            fn default() -> Self {
                Self { $(
                    $field: $crate::settings!(@default $field $type [$($help)*]
                        { $([$($word),+])? $(in $min ..= $max)? $(= $default)? $(as $shared)? })
                ),* }
            }
        }

        $($crate::settings!(@method $Name $METHOD $($check)?);)?
    };
    (@method $Name:ident $METHOD:ident $($check:ident)?) => {
        impl $crate::MethodSettings for $Name {
            fn of(settings: &$crate::Settings) -> Result<Self, $crate::SettingError> {
                let read = <Self as $crate::Declares>::read(settings);
                $($check(&read)?;)?
                Ok(read)
            }
        }

        impl $Name {
            /// Reads `key=value` pairs.
            ///
            /// # Errors
            /// [`SettingError`]($crate::SettingError) for an unknown key or a value that does not
            /// fit.
            pub fn from_pairs<'a>(
                pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
            ) -> Result<Self, $crate::SettingError> {
                let settings = $crate::Settings::new($METHOD.id, $METHOD.settings, pairs)?;
                $crate::MethodSettings::of(&settings)
            }
        }
    };
    (@list $field:ident $type:ident [$($help:literal)*] {}) => {
        <$type as $crate::Declares>::SETTINGS
    };
    (@list $field:ident $type:ident [$($help:literal)*] { as $shared:path }) => {
        &[$shared.setting]
    };
    (@list $field:ident $type:ident [$($help:literal)*] { $($form:tt)+ }) => {
        &[$crate::declare!($field: $type $($form)+, $($help)*).setting]
    };
    (@read $settings:ident $field:ident $type:ident [$($help:literal)*] {}) => {
        <$type as $crate::Declares>::read($settings)
    };
    (@read $settings:ident $field:ident $type:ident [$($help:literal)*] { as $shared:path }) => {
        $shared.read($settings)
    };
    (@read $settings:ident $field:ident $type:ident [$($help:literal)*] { $($form:tt)+ }) => {
        const { $crate::declare!($field: $type $($form)+, $($help)*) }.read($settings)
    };
    (@default $field:ident $type:ident [$($help:literal)*] {}) => { <$type>::default() };
    (@default $field:ident $type:ident [$($help:literal)*] { as $shared:path }) => {
        $shared.default
    };
    (@default $field:ident $type:ident [$($help:literal)*] { $($form:tt)+ }) => {
        const { $crate::declare!($field: $type $($form)+, $($help)*) }.default
    };
}
