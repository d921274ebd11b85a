//! Helpers for the theory of a form.
//!
//! Limits hold for springs of rest length 0, whose forces are linear. The limits and the laws of
//! spin come from the recurrences of the oracle.

use super::{Form, Limit, Radius, SpinLaw};

/// The rule of a method that is stable at every step.
pub(crate) const ALWAYS: &str = "every θ and η";

/// A form with a label alone, without any theory.
pub(crate) const fn form(label: &'static str) -> Form {
    Form { label, limit: None, spin: None, order: None }
}

impl Form {
    pub(crate) const fn limit(self, rule: &'static str, radius: Radius) -> Self {
        Self { limit: Some(Limit { rule, radius }), ..self }
    }

    pub(crate) const fn spin(self, law: SpinLaw) -> Self {
        Self { spin: Some(law), ..self }
    }

    pub(crate) const fn order(self, order: Option<u32>) -> Self {
        Self { order: Some(order), ..self }
    }
}
