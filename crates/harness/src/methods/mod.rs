//! The registry of methods: it makes an integrator from the id and settings on the command line.
//! Only this module depends on the crate of every method.
//!
//! Each method or family has one module, which holds its theory and the forms in which studies run
//! it. Studies that compare all methods ask this registry.

mod adams_bashforth;
mod added;
mod backward_euler;
mod baraff_witkin;
mod bdf;
mod desbrun;
mod dirk;
mod energy_momentum;
mod explicit_euler;
mod exponential;
mod generalized_alpha;
mod imex_euler;
mod imex_rk;
mod imex_two_step;
mod imex_updated;
mod kang;
mod leapfrog;
mod midpoint;
mod multirate;
mod projective;
mod provot;
mod rkc;
mod rosenbrock;
pub(crate) mod runs;
mod srkn4;
mod symplectic_euler;
mod terzopoulos_fleischer;
mod vbd;
mod xpbd;
mod xpbd_lines;

use crate::lessons::Lesson;
use crate::presets::presets;
use crate::theory::Theory;
use drape_integrator::{
    Integrator, Method, Registration, Safeguard, SettingError, Settings, Split,
};
use drape_model::nearest;
use runs::Runs;

pub(crate) use added::programs_answer_within;
pub use added::{add, are_ours_alone, choose, kill_programs, program_failures, registration};
pub(crate) use added::{identity, is_added, is_chosen, options};

/// What a user may have meant by an unknown id: the form with this label, as tables and figures name
/// it, or the nearest id.
fn meant(id: &str, known: &str) -> String {
    let labelled = added::entries().find_map(|entry| {
        let runs = &entry.runs;
        let ranked = runs.work_precision.iter().map(|form| (form.label, form.method));
        let filmed = runs.animation.iter().map(|film| (film.form.label, film.form.method));
        ranked.chain(filmed).find(|(label, method)| *label == id && label != method)
    });
    match labelled {
        Some((_, method)) => format!(" (a label; its form is `{method}`)"),
        None => nearest(id, known.split(", ")),
    }
}

/// Why a choice of method was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MethodError {
    /// No method has this id.
    #[error("no method `{id}`{}; expected one of: {known}", meant(id, known))]
    Unknown {
        /// The id that was given.
        id: String,
        /// The known ids.
        known: String,
    },
    /// A setting is neither of the form `key=value` nor the name of a preset.
    #[error("{id}: setting `{text}`; expected key=value{presets}")]
    NotAPair {
        /// Method id.
        id: &'static str,
        /// The text that was given.
        text: String,
        /// The presets of the method, if it has any.
        presets: String,
    },
    /// A method of that id exists already.
    #[error("a method has the id `{id}` already; expected another id for the method that is added")]
    Taken {
        /// The id.
        id: String,
    },
    /// No command line could name a method of that id.
    #[error("method id `{id}`; expected letters, digits, `-`, `_` and `.`, at least one")]
    BadId {
        /// The id.
        id: String,
    },
    /// A program does not describe its method.
    #[error("{0}")]
    Program(String),
    /// A setting was refused.
    #[error(transparent)]
    Setting(#[from] SettingError),
}

impl MethodError {
    fn unknown(id: &str) -> Self {
        let known: Vec<_> = added::entries().map(|entry| entry.registration.method.id).collect();
        Self::Unknown { id: id.to_owned(), known: known.join(", ") }
    }

    fn not_a_pair(method: &Method, text: &str) -> Self {
        let names: Vec<_> = presets(method).map(|preset| preset.name).collect();
        let presets = match names.join(", ") {
            none if none.is_empty() => none,
            names => format!(", or first the preset {names}"),
        };
        Self::NotAPair { id: method.id, text: text.to_owned(), presets }
    }
}

/// The entry of a method in the registry: its registration, lesson, theory and forms.
#[derive(Debug)]
struct Entry {
    registration: &'static Registration,
    lesson: Option<&'static Lesson>,
    theory: Theory,
    runs: Runs,
}

/// All methods, one a line, in the order in which they build on each other.
static REGISTRY: &[&Entry] = &[
    &explicit_euler::ENTRY,
    &symplectic_euler::ENTRY,
    &leapfrog::ENTRY,
    &provot::ENTRY,
    &adams_bashforth::ENTRY,
    &rkc::ENTRY,
    &srkn4::ENTRY,
    &multirate::ENTRY,
    &backward_euler::ENTRY,
    &bdf::ENTRY,
    &midpoint::ENTRY,
    &generalized_alpha::ENTRY,
    &dirk::ENTRY,
    &energy_momentum::ENTRY,
    &terzopoulos_fleischer::ENTRY,
    &baraff_witkin::ENTRY,
    &rosenbrock::ENTRY,
    &exponential::ENTRY,
    &projective::ENTRY,
    &vbd::ENTRY,
    &xpbd::ENTRY,
    &xpbd_lines::ENTRY,
    &desbrun::ENTRY,
    &kang::ENTRY,
    &imex_euler::ENTRY,
    &imex_updated::ENTRY,
    &imex_two_step::SBDF2,
    &imex_two_step::CNAB2,
    &imex_two_step::MCNAB2,
    &imex_two_step::CNLF,
    &imex_rk::ENTRY,
];

/// All methods that studies compare, in the order in which they build on each other. Methods that a
/// user added come last.
pub fn all() -> impl Iterator<Item = &'static Method> {
    runs().map(|(method, _)| method)
}

/// The theory of the method of that id.
pub(crate) fn theory_of(id: &str) -> Option<&'static Theory> {
    find(id).map(|entry| &entry.theory)
}

/// All methods that studies compare, each with its forms, in the same order.
pub(crate) fn runs() -> impl Iterator<Item = (&'static Method, &'static Runs)> {
    let all = added::entries().map(|entry| (entry.registration.method, &entry.runs));
    all.filter(|(method, _)| is_chosen(method.id))
}

/// The methods that have a lesson, each with its lesson, in the same order.
pub(crate) fn taught() -> impl Iterator<Item = (&'static Method, &'static Lesson)> {
    added::entries().filter_map(|entry| Some((entry.registration.method, entry.lesson?)))
}

/// The forms of the method of that id.
pub(crate) fn runs_of(id: &str) -> Option<&'static Runs> {
    find(id).map(|entry| &entry.runs)
}

fn find(id: &str) -> Option<&'static Entry> {
    let known = added::entries().find(|entry| entry.registration.method.id == id);
    known.or_else(|| added::called(id))
}

/// The theory of each method, in the same order.
pub(crate) fn theories() -> impl Iterator<Item = &'static Theory> {
    added::entries().map(|entry| &entry.theory)
}

/// The id of a method and its settings from a text such as `id:key=value,…`. A text that begins
/// with `program:` names a command, and all of it is the id.
pub(crate) fn parts(text: &str) -> (&str, &str) {
    if text.starts_with(drape_program::PREFIX) {
        return (text, "");
    }
    text.split_once(':').unwrap_or((text, ""))
}

/// A method with checked settings.
#[derive(Clone, Debug)]
pub struct Choice {
    entry: &'static Entry,
    settings: Settings,
}

impl Choice {
    /// Reads `id` or `id:key=value,key=value`, with further `key=value` settings in `more`. The
    /// name of a [preset](crate::Preset) may stand first after the colon; settings beside it
    /// override those of the preset. `program:COMMAND` starts a program of the user, which
    /// describes its method.
    ///
    /// # Errors
    /// [`MethodError`] where the id or a setting is refused; it names the known ones.
    ///
    /// ```
    /// use drape_harness::methods::Choice;
    /// let choice = Choice::parse("imex-euler:forcing_term=0.05", &[])?;
    /// assert_eq!(choice.method().id, "imex-euler");
    /// assert!(Choice::parse("imex-euler:forcing_term=2", &[]).is_err());
    /// # Ok::<(), drape_harness::methods::MethodError>(())
    /// ```
    pub fn parse(text: &str, more: &[String]) -> Result<Self, MethodError> {
        let (id, settings) = parts(text);
        let entry = match id.strip_prefix(drape_program::PREFIX) {
            Some(command) => added::program(command)?,
            None => find(id).ok_or_else(|| MethodError::unknown(id))?,
        };
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

    /// The theory of the method.
    pub(crate) fn theory(&self) -> &'static Theory {
        &self.entry.theory
    }

    /// Whether the numbers of its explicit effects ([`drape_integrator::ExplicitNumbers`]) limit
    /// its step exactly. Other methods have a lower limit of their own.
    pub fn has_exact_limit(&self) -> bool {
        self.theory().is_limited
    }

    /// All settings with their values.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The id with all settings, as [`parse`](Self::parse) reads it. It leaves out the default
    /// split, which only matters to springs of several slopes, and the time limits of a program.
    pub fn full_id(&self) -> String {
        if self.method().id.starts_with(drape_program::PREFIX) {
            return self.method().id.to_owned();
        }
        let is_told = |(key, value): &(&'static str, &str)| {
            let untold = [Split::SETTING.setting, Safeguard::SETTING.setting];
            !untold.iter().any(|setting| *key == setting.key && *value == setting.default)
        };
        let settings = self.settings.iter().filter(is_told);
        let settings: Vec<_> = settings.map(|(key, value)| format!("{key}={value}")).collect();
        if settings.is_empty() {
            self.method().id.to_owned()
        } else {
            format!("{}:{}", self.method().id, settings.join(","))
        }
    }

    /// The id with the settings that differ from their defaults, as [`parse`](Self::parse) reads it.
    /// Where the defaults alone do not tell the rest, all settings.
    #[must_use]
    pub fn short_id(&self) -> String {
        let is_default = |key: &str, value: &str| {
            self.method().settings.iter().any(|set| set.key == key && set.default == value)
        };
        let settings = self.settings.iter().filter(|(key, value)| !is_default(key, value));
        let settings: Vec<_> = settings.map(|(key, value)| format!("{key}={value}")).collect();
        let id = self.method().id;
        let short = if settings.is_empty() {
            id.to_owned()
        } else {
            format!("{id}:{}", settings.join(","))
        };
        let is_same = Self::parse(&short, &[]).is_ok_and(|same| same.settings == self.settings);
        if is_same { short } else { self.full_id() }
    }

    /// Whether results of this choice have the same bits on every machine, because no factorisation
    /// of a library takes part.
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
    /// [`SettingError`], if the method itself refuses a setting that its declaration allows.
    pub fn build(&self) -> Result<Box<dyn Integrator>, SettingError> {
        (self.entry.registration.build)(&self.settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_id_gets_the_nearest_one_and_a_strange_one_gets_none() {
        let said = |id: &str| MethodError::unknown(id).to_string();
        for (id, nearest) in [("symplectic-eulr", "symplectic-euler"), ("bdf", "bdf2")] {
            assert!(said(id).contains(&format!("(nearest: `{nearest}`)")), "{}", said(id));
        }
        let label = said("midpoint, safeguarded");
        let form = "(a label; its form is `midpoint:max_iterations=1,safeguard=work`)";
        assert!(label.contains(form), "{label}");
        assert!(
            said("newmark").starts_with("no method `newmark`; expected"),
            "{}",
            said("newmark")
        );
    }

    #[test]
    fn a_short_id_names_what_differs_from_the_defaults() {
        let short = |text: &str| Choice::parse(text, &[]).map(|choice| choice.short_id());
        for method in all() {
            let choice = Choice::parse(method.id, &[]).expect("an id of the registry");
            assert_eq!(choice.short_id(), method.id);
            assert_eq!(short(&choice.full_id()).ok().as_deref(), Some(method.id));
        }
        let form = "dirk:residual=1e-3,jacobian=saved,solver=cholesky";
        let choice = Choice::parse(form, &[]).expect("a form");
        let told = short(&choice.full_id()).expect("a form");
        assert!(told.len() <= form.len(), "{told}");
        assert_eq!(Choice::parse(&told, &[]).map(|c| c.full_id()).ok(), Some(choice.full_id()));
    }
}
