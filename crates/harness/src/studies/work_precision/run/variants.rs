//! The methods, and the knob that is turned from one run to the next.

use crate::HarnessError;
use crate::methods::runs::work::{self, Scope};
pub(in crate::studies) use crate::methods::runs::work::{Knob, Variant};
use crate::methods::{self, Choice};
use crate::studies::variant::{is_explicit, or_defaults};
use std::sync::LazyLock;

pub(in crate::studies) const DOP853: &str = "dop853";
const TOLERANCES: &[f64] = &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];

/// DOP853, then all forms of the registry's methods; those under step size control
/// come last.
pub(in crate::studies) static VARIANTS: LazyLock<Vec<Variant>> = LazyLock::new(|| {
    let dop853 = work::headline(DOP853, DOP853).knob(Knob::Tolerance(TOLERANCES));
    let forms = methods::runs().flat_map(|(method, runs)| {
        or_defaults(method, runs.work_precision, |form| work::main(form.label, form.method))
    });
    let (adaptive, steady): (Vec<_>, Vec<_>) = forms.partition(Variant::is_adaptive);
    [vec![dop853], steady, adaptive].concat()
});

impl Variant {
    /// Whether it controls the size of its steps.
    fn is_adaptive(&self) -> bool {
        matches!(self.knob, Knob::Setting("tolerance", _))
    }

    /// Whether it stands in the headline figure.
    pub(in crate::studies::work_precision) fn is_headline(&self) -> bool {
        self.scope == Scope::Headline
    }

    /// Whether it is run outside the series over the stiffness with light damping too.
    pub(in crate::studies) fn is_run_everywhere(&self) -> bool {
        self.scope != Scope::Extra
    }

    /// The method at a value of the knob; `None` for DOP853.
    pub(in crate::studies::work_precision) fn choice(
        &self,
        value: f64,
    ) -> Result<Option<Choice>, HarnessError> {
        let more = match self.knob {
            Knob::Steps => Vec::new(),
            Knob::Setting(key, _) => vec![format!("{key}={value}")],
            Knob::Tolerance(_) => return Ok(None),
        };
        Ok(Some(Choice::parse(self.method, &more)?))
    }

    /// Name of what is turned.
    pub(in crate::studies::work_precision) fn knob_name(&self) -> &'static str {
        match self.knob {
            Knob::Steps => "steps",
            Knob::Setting(key, _) => key,
            Knob::Tolerance(_) => "tolerance",
        }
    }
}

/// Whether the stiffness limits the step of what stands behind a label.
pub(super) fn is_limited_by_stiffness(method: &str) -> bool {
    method == DOP853 || Choice::parse(method, &[]).is_ok_and(|choice| is_explicit(choice.method()))
}
