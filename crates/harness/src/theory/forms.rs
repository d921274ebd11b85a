//! How a form is written down.
//!
//! Limits are those of springs of rest length 0, whose forces are linear; they come from the
//! recurrences of the oracle, as do the laws of spin.

use super::{Form, Limit, Radius, SpinLaw};

/// The rule of a method that is stable at every step.
pub(crate) const ALWAYS: &str = "every θ and η";

/// A form of which only the label is known.
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
