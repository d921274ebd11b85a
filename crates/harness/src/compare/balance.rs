//! The energy of a run while pins, obstacles or wind do work.

use super::facts::Run;
use crate::judgement::allowed_rise;
use crate::ordered::{energy_round_off, particles_inside_obstacles};
use crate::run::{Moment, Simulation};
use crate::stability::Rule;
use crate::studies::finite;
use crate::{Verdict, WorkBalance};

/// Share of the greatest kinetic energy from which on a gain makes a run unstable, not marginal.
const LARGE: f64 = 0.5;

/// Watches a run, and compares the rise of its energy with the work of pins, obstacles and wind, as
/// `drape run` does.
pub(super) struct Watch {
    balance: WorkBalance,
    rule: Rule,
    /// Greatest rise that may be round-off, J.
    round_off: f64,
    /// Greatest kinetic energy so far, J.
    kinetic: f64,
    /// Whether particles start inside obstacles. These push them out, and that work is not known.
    is_blind: bool,
}

impl Watch {
    /// Starts to watch a run, at its start.
    pub(super) fn new(Simulation { system, state }: &Simulation, rule: Rule) -> Self {
        Self {
            balance: WorkBalance::new(system, state),
            rule,
            round_off: energy_round_off(system, state),
            kinetic: system.kinetic_energy(&state.v),
            is_blind: particles_inside_obstacles(system, state) > 0,
        }
    }

    /// Looks at the end of a step.
    pub(super) fn look(&mut self, moment: &Moment<'_>) {
        self.balance.look(moment);
        self.kinetic = self.kinetic.max(moment.system.kinetic_energy(&moment.state.v));
    }

    /// The verdict on a run that is sound by all that is known besides.
    pub(super) fn verdict(&self) -> Verdict {
        let known = self.balance.excess().zip(self.balance.sure_excess());
        let allowed = allowed_rise(self.rule, self.kinetic) + self.round_off;
        verdict(known.filter(|_| !self.is_blind), allowed, LARGE * self.kinetic)
    }

    /// Judges a run that is sound by all that is known besides.
    pub(super) fn judge(&self, run: &mut Run) {
        run.verdict = self.verdict();
        let gain = self.balance.sure_excess().filter(|_| run.verdict != Verdict::Open);
        run.gain = gain.map(|gain| finite(gain.max(0.0) / self.kinetic.max(1e-300)));
    }
}

/// The verdict by the rise of the energy beyond the work, J, and by its part that is sure, J.
/// Neither is known where a step moves particles by other means than forces.
fn verdict(known: Option<(f64, f64)>, allowed: f64, large: f64) -> Verdict {
    match known {
        Some((_, sure)) if sure > allowed.max(large) => Verdict::Unstable,
        Some((_, sure)) if sure > allowed => Verdict::Marginal,
        Some((excess, _)) if excess <= allowed => Verdict::Stable,
        _ => Verdict::Open,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_sure_rise_beyond_the_work_is_a_gain() {
        for (excess, sure, expected) in [
            (0.01, 0.01, Verdict::Stable),
            (0.03, 0.01, Verdict::Open),
            (0.03, 0.03, Verdict::Marginal),
            (0.70, 0.40, Verdict::Marginal),
            (0.70, 0.60, Verdict::Unstable),
            (f64::INFINITY, f64::INFINITY, Verdict::Unstable),
        ] {
            assert_eq!(verdict(Some((excess, sure)), 0.02, 0.5), expected, "{excess}, {sure}");
        }
        assert_eq!(verdict(None, 0.02, 0.5), Verdict::Open);
    }
}
