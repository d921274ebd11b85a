//! From the id and settings on the command line to an integrator: the only place that knows every
//! method's crate.

use drape_backward_euler::{BACKWARD_EULER, BackwardEuler, BackwardEulerSettings};
use drape_baraff_witkin::{BARAFF_WITKIN, BaraffWitkin, BaraffWitkinSettings};
use drape_desbrun::{DESBRUN, Desbrun, DesbrunSettings};
use drape_explicit_euler::{
    EXPLICIT_EULER, ExplicitEuler, LEAPFROG, Leapfrog, LeapfrogSettings, SYMPLECTIC_EULER,
    SymplecticEuler, SymplecticSettings,
};
use drape_imex::{
    IMEX_CNAB2, IMEX_CNLF, IMEX_EULER, IMEX_MCNAB2, IMEX_SBDF2, IMEX_UPDATED, ImexEuler,
    ImexEulerSettings, ImexTwoStep, ImexTwoStepSettings, ImexUpdated, ImexUpdatedSettings, Scheme,
};
use drape_integrator::{Integrator, Method, NewtonLinear, SettingError, Settings, Split};
use drape_kang::{KANG, Kang, KangSettings};
use drape_multistep::{
    ADAMS_BASHFORTH2, AdamsBashforth, AdamsBashforthSettings, BDF2, Bdf, BdfSettings,
};
use drape_provot::{PROVOT, Provot, ProvotSettings};
use drape_terzopoulos_fleischer::{
    TERZOPOULOS_FLEISCHER, TerzopoulosFleischer, TerzopoulosFleischerSettings,
};

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

/// A two-step IMEX method; its first step is one of backward Euler, which factorises.
const fn two_step(
    method: &'static Method,
    build: fn(Pairs<'_>) -> Result<Box<dyn Integrator>, SettingError>,
) -> Entry {
    Entry { method, build, uses_library: |_| true }
}

/// Whether a linear solve goes, or may go, through a factorisation.
fn factorises(settings: &Settings) -> bool {
    settings.word("solver") != "cg"
}

/// Builds a two-step IMEX method.
fn imex(scheme: Scheme, pairs: Pairs<'_>) -> Result<Box<dyn Integrator>, SettingError> {
    Ok(ImexTwoStep::controlled(ImexTwoStepSettings::from_pairs(scheme, pairs)?))
}

/// All methods, in the order in which they build on each other.
static ENTRIES: [Entry; 17] = [
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
        method: &LEAPFROG,
        build: |pairs| Ok(Box::new(Leapfrog::new(LeapfrogSettings::from_pairs(pairs)?))),
        uses_library: |settings| settings.word("solver") == "cholesky",
    },
    Entry {
        method: &PROVOT,
        build: |pairs| Ok(Box::new(Provot::new(ProvotSettings::from_pairs(pairs)?))),
        uses_library: |_| false,
    },
    Entry {
        method: &ADAMS_BASHFORTH2,
        build: |pairs| {
            Ok(Box::new(AdamsBashforth::new(AdamsBashforthSettings::from_pairs(pairs)?)))
        },
        uses_library: |_| false,
    },
    Entry {
        method: &BACKWARD_EULER,
        build: |pairs| Ok(BackwardEuler::controlled(BackwardEulerSettings::from_pairs(pairs)?)),
        uses_library: |settings| !NewtonLinear::is_portable(settings),
    },
    Entry {
        method: &BDF2,
        build: |pairs| Ok(Bdf::controlled(BdfSettings::from_pairs(pairs)?)),
        uses_library: |settings| !NewtonLinear::is_portable(settings),
    },
    Entry {
        method: &TERZOPOULOS_FLEISCHER,
        build: |pairs| {
            let settings = TerzopoulosFleischerSettings::from_pairs(pairs)?;
            Ok(Box::new(TerzopoulosFleischer::new(settings)))
        },
        uses_library: |_| true,
    },
    Entry {
        method: &BARAFF_WITKIN,
        build: |pairs| Ok(Box::new(BaraffWitkin::new(BaraffWitkinSettings::from_pairs(pairs)?))),
        uses_library: |settings| settings.word("solver") == "cholesky",
    },
    Entry {
        method: &DESBRUN,
        build: |pairs| Ok(Box::new(Desbrun::new(DesbrunSettings::from_pairs(pairs)?))),
        uses_library: |_| true,
    },
    Entry {
        method: &KANG,
        build: |pairs| Ok(Box::new(Kang::new(KangSettings::from_pairs(pairs)?))),
        uses_library: |_| false,
    },
    Entry {
        method: &IMEX_EULER,
        build: |pairs| Ok(ImexEuler::controlled(ImexEulerSettings::from_pairs(pairs)?)),
        uses_library: factorises,
    },
    Entry {
        method: &IMEX_UPDATED,
        build: |pairs| Ok(ImexUpdated::controlled(ImexUpdatedSettings::from_pairs(pairs)?)),
        // The robust form may turn to Newton, which factorises.
        uses_library: |settings| factorises(settings) || settings.word("safeguard") == "robust",
    },
    two_step(&IMEX_SBDF2, |pairs| imex(Scheme::Sbdf2, pairs)),
    two_step(&IMEX_CNAB2, |pairs| imex(Scheme::Cnab2, pairs)),
    two_step(&IMEX_MCNAB2, |pairs| imex(Scheme::Mcnab2, pairs)),
    two_step(&IMEX_CNLF, |pairs| imex(Scheme::Cnlf, pairs)),
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

    /// Id with all settings, as [`parse`](Self::parse) reads it; without the split where it is the default, which only
    /// springs of several slopes notice.
    pub fn full_id(&self) -> String {
        let is_told = |(key, value): &(&'static str, &str)| {
            *key != Split::SETTING.key || *value != Split::SETTING.default
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
        !(self.entry.uses_library)(&self.settings)
    }

    /// Whether the result depends on the order of the springs by more than round-off: they are shortened one after
    /// the other, each from where the last one left its ends.
    pub fn follows_springs(&self) -> bool {
        let id = self.method().id;
        id == PROVOT.id || (id == DESBRUN.id && self.settings.word("inverse_dynamics") == "true")
    }

    /// A new integrator.
    ///
    /// # Errors
    /// [`SettingError`], if the method's own reader refuses what its declaration allowed.
    pub fn build(&self) -> Result<Box<dyn Integrator>, SettingError> {
        (self.entry.build)(self.settings.iter().collect())
    }
}
