//! From the id and settings on the command line to an integrator: the only place that knows every
//! method's crate.

use crate::presets::presets;
use crate::theory::{self, Theory};
use drape_integrator::{Integrator, Method, Registration, SettingError, Settings, Split};

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
    /// A setting is not of the form `key=value`, and no preset either.
    #[error("{id}: setting `{text}`; expected key=value{presets}")]
    NotAPair {
        /// Method id.
        id: &'static str,
        /// What was given.
        text: String,
        /// The presets of the method, if it has any.
        presets: String,
    },
    /// A setting was refused.
    #[error(transparent)]
    Setting(#[from] SettingError),
}

impl MethodError {
    fn not_a_pair(method: &Method, text: &str) -> Self {
        let names: Vec<_> = presets(method).map(|preset| preset.name).collect();
        let presets = match names.join(", ") {
            none if none.is_empty() => none,
            names => format!(", or first the preset {names}"),
        };
        Self::NotAPair { id: method.id, text: text.to_owned(), presets }
    }
}

/// A method and what is known of it.
#[derive(Debug)]
struct Entry {
    registration: &'static Registration,
    theory: &'static Theory,
}

const fn entry(registration: &'static Registration, theory: &'static Theory) -> Entry {
    Entry { registration, theory }
}

/// All methods, in the order in which they build on each other: one line a method.
static REGISTRY: [Entry; 17] = [
    entry(&drape_explicit_euler::EXPLICIT, &theory::EXPLICIT_EULER),
    entry(&drape_explicit_euler::SYMPLECTIC, &theory::SYMPLECTIC_EULER),
    entry(&drape_explicit_euler::VERLET, &theory::LEAPFROG),
    entry(&drape_provot::REGISTRATION, &theory::PROVOT),
    entry(&drape_multistep::EXPLICIT_ADAMS, &theory::ADAMS_BASHFORTH),
    entry(&drape_backward_euler::REGISTRATION, &theory::BACKWARD_EULER),
    entry(&drape_multistep::BACKWARD_DIFFERENTIATION, &theory::BDF),
    entry(&drape_terzopoulos_fleischer::REGISTRATION, &theory::TERZOPOULOS_FLEISCHER),
    entry(&drape_baraff_witkin::REGISTRATION, &theory::BARAFF_WITKIN),
    entry(&drape_desbrun::REGISTRATION, &theory::DESBRUN),
    entry(&drape_kang::REGISTRATION, &theory::KANG),
    entry(&drape_imex::EULER, &theory::IMEX_EULER),
    entry(&drape_imex::UPDATED, &theory::IMEX_UPDATED),
    entry(&drape_imex::SBDF2, &theory::SBDF2),
    entry(&drape_imex::CNAB2, &theory::CNAB2),
    entry(&drape_imex::MCNAB2, &theory::MCNAB2),
    entry(&drape_imex::CNLF, &theory::CNLF),
];

/// All methods, in the order in which they build on each other.
pub fn all() -> impl Iterator<Item = &'static Method> {
    REGISTRY.iter().map(|entry| entry.registration.method)
}

/// What is known of the method of that id.
pub(crate) fn theory_of(id: &str) -> Option<&'static Theory> {
    find(id).map(|entry| entry.theory)
}

fn find(id: &str) -> Option<&'static Entry> {
    REGISTRY.iter().find(|entry| entry.registration.method.id == id)
}

/// What is known of each method, in the same order.
pub(crate) fn theories() -> impl Iterator<Item = &'static Theory> {
    REGISTRY.iter().map(|entry| entry.theory)
}

/// A method with checked settings.
#[derive(Clone, Debug)]
pub struct Choice {
    entry: &'static Entry,
    settings: Settings,
}

impl Choice {
    /// Reads `id` or `id:key=value,key=value`, with further `key=value` settings from elsewhere.
    /// The name of a [preset](crate::Preset) may stand first after the colon; what is given beside
    /// it goes before it.
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
        let entry = find(id).ok_or_else(|| {
            let known: Vec<_> = all().map(|method| method.id).collect();
            MethodError::Unknown { id: id.to_owned(), known: known.join(", ") }
        })?;
        let method = entry.registration.method;
        let mut texts = settings.split(',').filter(|text| !text.trim().is_empty()).peekable();
        let preset =
            texts.peek().and_then(|name| presets(method).find(|preset| preset.name == name.trim()));
        if preset.is_some() {
            texts.next();
        }
        let mut pairs = Vec::new();
        for text in texts.chain(more.iter().map(String::as_str)) {
            let (key, value) =
                text.split_once('=').ok_or_else(|| MethodError::not_a_pair(method, text))?;
            pairs.push((key.trim(), value.trim()));
        }
        for &(key, value) in preset.iter().flat_map(|preset| preset.settings) {
            if !pairs.iter().any(|(given, _)| *given == key) {
                pairs.push((key, value));
            }
        }
        let settings = Settings::new(method.id, method.settings, pairs)?;
        Ok(Self { entry, settings })
    }

    /// The method.
    pub fn method(&self) -> &'static Method {
        self.entry.registration.method
    }

    /// What is known of the method.
    pub(crate) fn theory(&self) -> &'static Theory {
        self.entry.theory
    }

    /// Whether the numbers of its explicit effects ([`drape_integrator::ExplicitNumbers`]) limit
    /// its step exactly; other methods have a lower limit of their own.
    pub fn has_exact_limit(&self) -> bool {
        self.theory().is_limited
    }

    /// All settings with their values.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Id with all settings, as [`parse`](Self::parse) reads it. The default split is left out:
    /// only springs of several slopes notice.
    pub fn full_id(&self) -> String {
        let is_told = |(key, value): &(&'static str, &str)| {
            *key != Split::SETTING.setting.key || *value != Split::SETTING.setting.default
        };
        let settings = self.settings.iter().filter(is_told);
        let settings: Vec<_> = settings.map(|(key, value)| format!("{key}={value}")).collect();
        if settings.is_empty() {
            self.method().id.to_owned()
        } else {
            format!("{}:{}", self.method().id, settings.join(","))
        }
    }

    /// Whether results of this choice have the same bits on every machine: no library
    /// factorisation takes part.
    pub fn is_portable(&self) -> bool {
        (self.entry.registration.is_portable)(&self.settings)
    }

    /// Whether the result depends on the order of the springs by more than round-off.
    pub fn follows_springs(&self) -> bool {
        (self.entry.registration.follows_springs)(&self.settings)
    }

    /// A new integrator.
    ///
    /// # Errors
    /// [`SettingError`], if the method's own reader refuses what its declaration allowed.
    pub fn build(&self) -> Result<Box<dyn Integrator>, SettingError> {
        (self.entry.registration.build)(&self.settings)
    }
}
