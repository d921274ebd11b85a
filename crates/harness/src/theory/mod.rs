//! The theory of each method: its properties that are known without a run. Hard cases, the
//! stability atlas, the order study, the momentum study and tests read this one table.
//!
//! A method's [`Theory`] stands in the module of its name ([`crate::methods`]).

mod case;
mod forms;
mod linear;
mod load;

pub(crate) use case::{
    Expectation, PUSHING, TURNING, at_rest_or, beside_explicit, expectation, explicit, implicit,
    limit, monotone, no_theorem, stable, unstable,
};
pub(crate) use forms::{ALWAYS, form};
pub(crate) use linear::{Factors, Linear, Problem, Weights};
pub(crate) use load::LoadLaw;

use crate::methods;
use crate::need::Matrix;
use drape_integrator::Settings;
use drape_report::family::Kin;

/// A spectral radius above 1 by no more than this is round-off.
const ROUND_OFF: f64 = 1e-9;

/// The factor by which a step multiplies the motion in the long run, from `θ = h²κ` and `η = hδ`.
pub(crate) type Radius = fn(theta: f64, eta: f64) -> f64;

/// Factor by which a step multiplies the angular momentum of two undamped particles. Its arguments
/// are `θ`, and the rest length over the length before and after the step.
pub(crate) type SpinLaw = fn(theta: f64, before: f64, after: f64) -> f64;

/// The theory of a method.
#[derive(Debug)]
pub(crate) struct Theory {
    /// Its expected behaviour on a hard case.
    pub(crate) case: fn(&Problem<'_>) -> Expectation,
    /// The panel of figures in which its curves stand.
    pub(crate) kin: Kin,
    /// The matrix that it holds with these settings, for estimates of memory.
    pub(crate) matrix: fn(&Settings) -> Matrix,
    /// Whether it divides a step by itself, unless its setting `step` is `fixed`.
    pub(crate) divides: bool,
    /// Whether the numbers of its explicit effects ([`drape_integrator::ExplicitNumbers`]) limit
    /// its step exactly. Other methods have a lower limit of their own.
    pub(crate) is_limited: bool,
    /// Its forms. The label of the form at default settings is the method's id.
    pub(crate) forms: &'static [Form],
}

/// A form of a method: certain settings, under one label in all studies.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Form {
    /// Short name for tables and legends.
    pub(crate) label: &'static str,
    /// The limit of the step on springs of rest length 0.
    pub(crate) limit: Option<Limit>,
    /// Its effect on the spin of two particles on a spring.
    pub(crate) spin: Option<SpinLaw>,
    /// Its order, where it differs from the order that the method states. `Some(None)` claims no
    /// order.
    pub(crate) order: Option<Option<u32>>,
}

/// The stability limit of a form on the oscillator, in closed form.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limit {
    /// The condition for a stable step, in words.
    pub(crate) rule: &'static str,
    /// The spectral radius.
    pub(crate) radius: Radius,
}

impl Limit {
    /// Whether no oscillation of stiffness `κ` (1/s²) and damping `δ` (1/s) grows.
    pub(crate) fn is_stable(&self, h: f64, stiffness: f64, damping: f64) -> bool {
        (self.radius)(h * h * stiffness, h * damping) <= 1.0 + ROUND_OFF
    }

    /// Factor by which an oscillation's energy grows over a number of steps.
    pub(crate) fn growth(&self, h: f64, stiffness: f64, damping: f64, steps: f64) -> f64 {
        libm::pow((self.radius)(h * h * stiffness, h * damping), 2.0 * steps)
    }
}

/// The form of that label.
pub(crate) fn form_of(label: &str) -> Option<&'static Form> {
    methods::theories().flat_map(|theory| theory.forms).find(|form| form.label == label)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_method_has_a_form_by_its_id_and_no_label_stands_twice() {
        let labels: Vec<_> =
            methods::theories().flat_map(|theory| theory.forms).map(|form| form.label).collect();
        assert_eq!(labels.iter().collect::<BTreeSet<_>>().len(), labels.len(), "{labels:?}");
        for method in methods::all() {
            let form = form_of(method.id);
            assert!(form.is_some_and(|form| form.limit.is_some()), "{}", method.id);
        }
    }
}
