//! Which forms of the methods run, and which settings a case changes.

use crate::methods::runs::Variant;
use crate::methods::{self, Choice, MethodError};
use crate::studies::variant::of_registry;
use drape_integrator::{Kind, Setting};

/// The columns of the table: every method of the registry at its defaults, and its other forms.
pub(super) fn forms() -> Vec<Variant> {
    of_registry(|runs| runs.hard_cases)
}

/// A form with its own settings and those of the case. Returns `None` if the case varies a
/// tolerance and the method has none.
///
/// # Errors
/// [`MethodError`] if a setting is refused.
pub(super) fn choose(form: &Variant, tweak: Tweak) -> Result<Option<Choice>, MethodError> {
    let (id, own) = methods::parts(form.method);
    let settings = Choice::parse(id, &[])?.method().settings;
    let Some(tweaked) = tweak.settings(settings) else { return Ok(None) };
    let key = |pair: &str| pair.split('=').next().unwrap_or_default().to_owned();
    let is_kept =
        |pair: &&str| !pair.is_empty() && !tweaked.iter().any(|other| key(other) == key(pair));
    let mut pairs: Vec<String> = own.split(',').filter(is_kept).map(str::to_owned).collect();
    pairs.extend(tweaked);
    Choice::parse(id, &pairs).map(Some)
}

/// What a case changes in the methods' settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Tweak {
    /// Nothing.
    None,
    /// Only tension springs stand in the matrix, if the method can choose.
    ExplicitShear,
    /// The largest tolerance that the method allows.
    Loosest,
    /// The smallest tolerance that the method allows.
    Tightest,
    /// This forcing term, if the method has one.
    ForcingTerm(f64),
}

/// Settings that are tolerances.
const TOLERANCES: [&str; 2] = ["forcing_term", "residual"];

impl Tweak {
    /// The settings to change in a method that declares `declared`. Returns `None` if the method
    /// has nothing to vary.
    fn settings(self, declared: &[Setting]) -> Option<Vec<String>> {
        let declares = |key: &str| declared.iter().find(|setting| setting.key == key);
        let tolerance = |pick: fn(f64, f64) -> f64| {
            let setting = TOLERANCES.iter().find_map(|key| declares(key))?;
            match setting.kind {
                Kind::Number { min, max } => {
                    Some(vec![format!("{}={:e}", setting.key, pick(min, max))])
                }
                Kind::OptionalNumber { .. } | Kind::Integer { .. } | Kind::Choice(_) => None,
            }
        };
        match self {
            Self::None => Some(Vec::new()),
            Self::ExplicitShear => {
                let pair = declares("implicit").map(|_| "implicit=tension".to_owned());
                Some(pair.into_iter().collect())
            }
            Self::Loosest => tolerance(|_, max| max),
            Self::Tightest => tolerance(|min, _| min),
            Self::ForcingTerm(term) => {
                let pair = declares("forcing_term").map(|_| format!("forcing_term={term}"));
                Some(pair.into_iter().collect())
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    fn form(label: &str) -> Variant {
        forms().into_iter().find(|form| form.label == label).unwrap()
    }

    #[test]
    fn every_form_of_a_registered_method_is_accepted_in_every_case() {
        let tweaks = [
            Tweak::None,
            Tweak::ExplicitShear,
            Tweak::Loosest,
            Tweak::Tightest,
            Tweak::ForcingTerm(0.1),
        ];
        for form in forms() {
            for tweak in tweaks {
                let choice = choose(&form, tweak).unwrap_or_else(|error| panic!("{error}"));
                assert!(choice.is_some() || matches!(tweak, Tweak::Loosest | Tweak::Tightest));
            }
        }
    }

    #[test]
    fn a_case_overrides_the_form() {
        let choice = choose(&form("imex-euler (exact)"), Tweak::ExplicitShear).unwrap().unwrap();
        assert_eq!(choice.settings().word("implicit"), "tension");
        assert_eq!(choice.settings().word("solver"), "cholesky");
        let term = |tweak| {
            let choice = choose(&form("imex-updated"), tweak).unwrap().unwrap();
            choice.settings().number("forcing_term")
        };
        assert_eq!(term(Tweak::Loosest), 0.5);
        assert_eq!(term(Tweak::Tightest), 1e-16);
        assert!(choose(&form("explicit-euler"), Tweak::Tightest).unwrap().is_none());
    }
}
