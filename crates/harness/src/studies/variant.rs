//! The methods of the registry in the settings in which an experiment runs them.

use crate::methods;
use drape_integrator::{Method, Treatment};
use drape_model::{EffectClass, EffectKind};

/// A method in certain settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Variant {
    /// Short name for tables and legends.
    pub(super) label: &'static str,
    /// Method id with settings, as [`methods::Choice::parse`] reads it.
    pub(super) method: &'static str,
}

impl Variant {
    pub(super) const fn new(label: &'static str, method: &'static str) -> Self {
        Self { label, method }
    }

    fn id(&self) -> &'static str {
        self.method.split(':').next().unwrap_or(self.method)
    }
}

/// Every method of the registry, in its order: in each of the variants that `named` has of it, or
/// at its defaults where there is none. What `named` has of other methods is left out.
pub(super) fn of_registry(named: &[Variant]) -> Vec<Variant> {
    of_methods(methods::all(), named)
}

fn of_methods(methods: impl Iterator<Item = &'static Method>, named: &[Variant]) -> Vec<Variant> {
    methods
        .flat_map(|method| {
            let mut variants: Vec<_> =
                named.iter().copied().filter(|variant| variant.id() == method.id).collect();
            if variants.is_empty() {
                variants.push(Variant::new(method.id, method.id));
            }
            variants
        })
        .collect()
}

/// Whether a method takes the tension springs at the old level, so that stiffness limits its step.
pub(super) fn is_explicit(method: &Method) -> bool {
    method.treatment(EffectKind::Tension, EffectClass::Springs) == Treatment::Explicit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_of_the_registry_is_there_in_its_variants_or_at_its_defaults() {
        let named = [
            Variant::new("tight", "imex-euler:forcing_term=1e-10"),
            Variant::new("absent", "no-such-method:setting=1"),
            Variant::new("loose", "imex-euler:forcing_term=0.1"),
        ];
        let variants = of_registry(&named);
        let ids: Vec<_> = variants.iter().map(Variant::id).collect();
        for method in methods::all() {
            let expected = if method.id == "imex-euler" { 2 } else { 1 };
            let found = ids.iter().filter(|id| **id == method.id).count();
            assert_eq!(found, expected, "{}", method.id);
        }
        assert!(variants.contains(&named[0]) && variants.contains(&named[2]));
        assert!(variants.contains(&Variant::new("explicit-euler", "explicit-euler")));
        assert!(!variants.contains(&named[1]));
    }

    #[test]
    fn explicit_methods_are_told_by_what_they_do_with_tension() {
        let explicit: Vec<_> =
            methods::all().filter(|m| is_explicit(m)).map(|method| method.id).collect();
        assert!(explicit.contains(&"explicit-euler") && explicit.contains(&"symplectic-euler"));
        assert!(!explicit.contains(&"imex-euler") && !explicit.contains(&"backward-euler"));
    }
}
