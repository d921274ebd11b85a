//! How a run ended, in one word.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a run ended. The harness judges; records, figures and pages show the word.
///
/// From [`Stable`](Self::Stable) to [`Diverged`](Self::Diverged) a greater verdict is a worse one.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// No verdict: energy could flow in from outside until the end, and how much is not known, or
    /// the cloth was still on its way to rest.
    Open,
    /// The run took all its steps; the study does not judge its energy.
    Completed,
    /// The run gained no energy.
    Stable,
    /// Stable by its energy, but the cloth keeps less than half of the true motion.
    Locked,
    /// Stable by its energy, but the cloth has left an obstacle on which it should lie.
    #[serde(rename = "lost contact")]
    LostContact,
    /// The run gained some energy.
    Marginal,
    /// The run ended because its counted effort reached the limit.
    #[serde(rename = "over budget")]
    OverBudget,
    /// The run gained much energy.
    Unstable,
    /// The state became non-finite or left the scene.
    Diverged,
    /// The method does not support the scene.
    Refused,
    /// The case has nothing to vary for this method.
    #[serde(rename = "not applicable")]
    NotApplicable,
}

impl Verdict {
    /// All verdicts.
    pub const ALL: [Self; 11] = [
        Self::Open,
        Self::Stable,
        Self::Marginal,
        Self::Unstable,
        Self::Diverged,
        Self::Locked,
        Self::LostContact,
        Self::OverBudget,
        Self::Completed,
        Self::Refused,
        Self::NotApplicable,
    ];

    /// Whether the run gained energy or left the scene.
    pub fn gains_energy(self) -> bool {
        matches!(self, Self::Marginal | Self::Unstable | Self::Diverged)
    }

    /// The word that records and pages use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Stable => "stable",
            Self::Marginal => "marginal",
            Self::Unstable => "unstable",
            Self::Diverged => "diverged",
            Self::Locked => "locked",
            Self::LostContact => "lost contact",
            Self::OverBudget => "over budget",
            Self::Completed => "completed",
            Self::Refused => "refused",
            Self::NotApplicable => "not applicable",
        }
    }

    /// A sign that follows the number of a run that was not stable; see [`SIGNS`].
    pub fn sign(self) -> &'static str {
        match self {
            Self::Stable => "",
            Self::Marginal => " °",
            _ => " ✗",
        }
    }

    /// Whether the energy of the run was judged.
    pub fn is_judged(self) -> bool {
        matches!(self, Self::Stable | Self::Marginal | Self::Unstable | Self::Diverged)
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// Meaning of the signs of [`Verdict::sign`].
pub const SIGNS: &str = "° marginal, ✗ unstable or diverged.";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_spells_a_verdict_as_its_name() {
        for verdict in Verdict::ALL {
            let text = serde_json::to_string(&verdict).expect("a word");
            assert_eq!(text, format!("\"{verdict}\""));
            assert_eq!(serde_json::from_str::<Verdict>(&text).expect("the same"), verdict);
        }
        assert!(Verdict::Stable < Verdict::Marginal && Verdict::Unstable < Verdict::Diverged);
    }
}
