//! From the id and settings on the command line to an integrator: the only place that knows every
//! method's crate.

use drape_backward_euler::{BACKWARD_EULER, BackwardEuler, BackwardEulerSettings};
use drape_explicit_euler::{
    EXPLICIT_EULER, ExplicitEuler, SYMPLECTIC_EULER, SymplecticEuler, SymplecticSettings,
};
use drape_imex::{
    IMEX_EULER, IMEX_UPDATED, ImexEuler, ImexEulerSettings, ImexUpdated, ImexUpdatedSettings,
};
use drape_integrator::{Integrator, Method, SettingError, Settings};

/// Why a choice of method was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MethodError {
    /// No such id.
    #[error("no method `{id}`; expected one of: {known}")]
    Unknown {
        /// What was given.
        id: String,
        /// The known ids.
        known: String,
    },
    /// A setting is not of the form `key=value`.
    #[error("{id}: setting `{text}`; expected key=value")]
    NotAPair {
        /// Method id.
        id: &'static str,
        /// What was given.
        text: String,
    },
    /// A setting was refused.
    #[error(transparent)]
    Setting(#[from] SettingError),
}

type Pairs<'a> = Vec<(&'a str, &'a str)>;

/// A method, how it is built, and where a library's factorisation takes part in its results.
struct Entry {
    method: &'static Method,
    build: fn(Pairs<'_>) -> Result<Box<dyn Integrator>, SettingError>,
    uses_library: fn(&Settings) -> bool,
}

/// All methods, in the order in which they build on each other.
static ENTRIES: [Entry; 5] = [
    Entry {
        method: &EXPLICIT_EULER,
        build: |_| Ok(Box::new(ExplicitEuler::default())),
        uses_library: |_| false,
    },
    Entry {
        method: &SYMPLECTIC_EULER,
        build: |pairs| Ok(Box::new(SymplecticEuler::new(SymplecticSettings::from_pairs(pairs)?))),
        uses_library: |settings| settings.word("damping") == "implicit",
    },
    Entry {
        method: &BACKWARD_EULER,
        build: |pairs| Ok(Box::new(BackwardEuler::new(BackwardEulerSettings::from_pairs(pairs)?))),
        uses_library: |_| true,
    },
    Entry {
        method: &IMEX_EULER,
        build: |pairs| Ok(Box::new(ImexEuler::new(ImexEulerSettings::from_pairs(pairs)?))),
        uses_library: |settings| settings.word("solver") == "cholesky",
    },
    Entry {
        method: &IMEX_UPDATED,
        build: |pairs| Ok(Box::new(ImexUpdated::new(ImexUpdatedSettings::from_pairs(pairs)?))),
        // The robust form may turn to Newton, which factorises.
        uses_library: |settings| {
            settings.word("solver") == "cholesky" || settings.word("safeguard") == "robust"
        },
    },
];

/// All methods, in the order in which they build on each other.
pub fn all() -> impl Iterator<Item = &'static Method> {
    ENTRIES.iter().map(|entry| entry.method)
}

impl std::fmt::Debug for Entry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.method.id)
    }
}

/// A method with checked settings.
#[derive(Clone, Debug)]
pub struct Choice {
    entry: &'static Entry,
    settings: Settings,
}

impl Choice {
    /// Reads `id` or `id:key=value,key=value`, with further `key=value` settings from elsewhere.
    ///
    /// # Errors
    /// [`MethodError`] naming what is known.
    ///
    /// ```
    /// use drape_harness::methods::Choice;
    /// let choice = Choice::parse("imex-euler:forcing_term=0.05", &[])?;
    /// assert_eq!(choice.method().id, "imex-euler");
    /// assert!(Choice::parse("imex-euler:forcing_term=2", &[]).is_err());
    /// # Ok::<(), drape_harness::methods::MethodError>(())
    /// ```
    pub fn parse(text: &str, more: &[String]) -> Result<Self, MethodError> {
        let (id, settings) = text.split_once(':').unwrap_or((text, ""));
        let entry = ENTRIES.iter().find(|entry| entry.method.id == id).ok_or_else(|| {
            let known: Vec<_> = all().map(|method| method.id).collect();
            MethodError::Unknown { id: id.to_owned(), known: known.join(", ") }
        })?;
        let method = entry.method;
        let texts = settings.split(',').filter(|text| !text.trim().is_empty());
        let mut pairs = Vec::new();
        for text in texts.chain(more.iter().map(String::as_str)) {
            let (key, value) = text
                .split_once('=')
                .ok_or_else(|| MethodError::NotAPair { id: method.id, text: text.to_owned() })?;
            pairs.push((key.trim(), value.trim()));
        }
        let settings = Settings::new(method.id, method.settings, pairs)?;
        Ok(Self { entry, settings })
    }

    /// The method.
    pub fn method(&self) -> &'static Method {
        self.entry.method
    }

    /// All settings with their values.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Id with all settings, as [`parse`](Self::parse) reads it.
    pub fn full_id(&self) -> String {
        let settings: Vec<_> =
            self.settings.iter().map(|(key, value)| format!("{key}={value}")).collect();
        if settings.is_empty() {
            self.method().id.to_owned()
        } else {
            format!("{}:{}", self.method().id, settings.join(","))
        }
    }

    /// Whether results of this choice have the same bits on every machine: no library
    /// factorisation takes part.
    pub fn is_portable(&self) -> bool {
        !(self.entry.uses_library)(&self.settings)
    }

    /// A new integrator.
    ///
    /// # Errors
    /// [`SettingError`], if the method's own reader refuses what its declaration allowed.
    pub fn build(&self) -> Result<Box<dyn Integrator>, SettingError> {
        (self.entry.build)(self.settings.iter().collect())
    }
}
