//! The energy of a run while pins, obstacles or wind do work.

use super::facts::Run;
use crate::judgement::allowed_rise;
use crate::run::Moment;
use crate::stability::Rule;
use crate::{Verdict, WorkBalance};

/// Watches a run, and compares the rise of its energy with that work, as `drape run` does.
pub(super) struct Watch {
    pub(super) balance: WorkBalance,
    pub(super) rule: Rule,
    /// Greatest rise that may be round-off, J.
    pub(super) round_off: f64,
    /// Greatest kinetic energy so far, J.
    pub(super) kinetic: f64,
}

impl Watch {
    /// Looks at the end of a step.
    pub(super) fn look(&mut self, moment: &Moment<'_>) {
        self.balance.look(moment);
        self.kinetic = self.kinetic.max(moment.system.kinetic_energy(&moment.state.v));
    }

    /// Changes the verdict of a run that is sound so far: it is unstable if it surely gained
    /// energy beside that work, and open if that is not known.
    pub(super) fn judge(&self, run: &mut Run) {
        if !run.is_sound() {
            return;
        }
        let allowed = allowed_rise(self.rule, self.kinetic) + self.round_off;
        run.verdict = match (self.balance.excess(), self.balance.sure_excess()) {
            (_, Some(sure)) if sure > allowed => Verdict::Unstable,
            (Some(excess), _) if excess <= allowed => Verdict::Stable,
            _ => Verdict::Open,
        };
    }
}
