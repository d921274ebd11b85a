//! The methods of the registry, in the settings that an experiment runs.

use crate::methods;
use crate::methods::runs::{Runs, Variant};
use drape_integrator::{Method, Treatment};
use drape_model::{EffectClass, EffectKind};

/// Every method of the registry, in its order. It is given in each form that the study names, or at
/// its defaults if the study names none.
pub(super) fn of_registry(named: impl Fn(&Runs) -> &'static [Variant]) -> Vec<Variant> {
    let forms = |(method, runs)| or_defaults(method, named(runs), |form| form);
    methods::runs().flat_map(forms).collect()
}

/// The named forms of a method, or else its defaults.
pub(crate) fn or_defaults<T: Copy>(
    method: &Method,
    named: &[T],
    of: impl Fn(Variant) -> T,
) -> Vec<T> {
    if named.is_empty() { vec![of(Variant::new(method.id, method.id))] } else { named.to_vec() }
}

/// Whether a method takes the tension springs at the old time level, so that stiffness limits its
/// step.
pub(crate) fn is_explicit(method: &Method) -> bool {
    method.treatment(EffectKind::Tension, EffectClass::Springs) == Treatment::Explicit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_of_the_registry_is_there_in_its_forms_or_at_its_defaults() {
        let variants = of_registry(|runs| runs.order);
        for (method, runs) in methods::runs() {
            let defaults = [Variant::new(method.id, method.id)];
            let expected = if runs.order.is_empty() { &defaults } else { runs.order };
            let is_its = |v: &&Variant| v.method.split(':').next() == Some(method.id);
            let found: Vec<_> = variants.iter().filter(is_its).copied().collect();
            assert_eq!(found, expected, "{}", method.id);
        }
    }

    /// Each label belongs to one form, and each form to the method that names it.
    #[test]
    fn no_study_has_two_forms_of_one_label() {
        for (method, runs) in methods::runs() {
            let momentum = runs.momentum.iter().map(|(form, _)| form);
            let locking = runs.locking.iter().map(|(form, _)| form);
            let spring = runs.locked_spring.iter().map(|(form, _)| form);
            let lists: [Vec<&Variant>; 7] = [
                runs.order.iter().collect(),
                runs.energy.iter().collect(),
                runs.stability.iter().collect(),
                runs.hard_cases.iter().collect(),
                momentum.collect(),
                locking.collect(),
                spring.collect(),
            ];
            for list in lists {
                for (n, form) in list.iter().enumerate() {
                    assert!(list[..n].iter().all(|other| other.label != form.label), "{form:?}");
                    let choice = methods::Choice::parse(form.method, &[]);
                    assert_eq!(choice.map(|choice| choice.method().id), Ok(method.id), "{form:?}");
                }
            }
        }
    }

    #[test]
    fn explicit_methods_are_told_by_what_they_do_with_tension() {
        let explicit: Vec<_> =
            methods::all().filter(|m| is_explicit(m)).map(|method| method.id).collect();
        assert!(explicit.contains(&"explicit-euler") && explicit.contains(&"symplectic-euler"));
        assert!(!explicit.contains(&"imex-euler") && !explicit.contains(&"backward-euler"));
    }
}
