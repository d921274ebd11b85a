//! Description and settings of the method.

use drape_integrator::{
    Declares, Method, Order, Quantity, SettingError, StabilityClass, StageSettings, Supports, Word,
    settings,
};

/// The generalized-α family.
pub static GENERALIZED_ALPHA: Method = Method {
    id: "generalized-alpha",
    name: "generalized-alpha with full Newton",
    source: "Newmark 1959; Hilber, Hughes & Taylor 1977; Chung & Hulbert 1993",
    order: Order::Two,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "A-stable on linear problems, where it multiplies infinitely stiff motion by rho_inf a \
             step; no energy theorem, and unstable at large h²k/m for rho_inf near 1",
    supports: Supports::Blocks,
    refuses: &[],
    settings: GeneralizedAlphaSettings::SETTINGS,
};

/// Members of the family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Chung and Hulbert (1993).
    ChungHulbert,
    /// Hilber, Hughes and Taylor (1977).
    Hht,
    /// Newmark (1959).
    Newmark,
}

impl Word for Family {
    const WORDS: &'static [(&'static str, Self)] =
        &[("chung-hulbert", Self::ChungHulbert), ("hht", Self::Hht), ("newmark", Self::Newmark)];
}

settings! {
    /// Settings of the generalized-α family.
    pub struct GeneralizedAlphaSettings for GENERALIZED_ALPHA, checked by within_reach_of_hht {
        /// factor by which a step multiplies infinitely stiff motion: 1 damps nothing, 0 all of it
        rho_inf: f64 in 0.0..=1.0 = 0.5,
        /// chung-hulbert damps slow motion least; hht needs rho_inf from 0.5 on; newmark has order
        /// 1 unless rho_inf=1, which is the trapezoidal rule
        family: Family [ChungHulbert, Hht, Newmark] = ChungHulbert,
        /// how Newton's method solves and when it stops
        stage: StageSettings,
    }
}

/// HHT has order 2 and is stable for `α` up to ⅓ only.
fn within_reach_of_hht(settings: &GeneralizedAlphaSettings) -> Result<(), SettingError> {
    if settings.family == Family::Hht && settings.rho_inf < 0.5 {
        return Err(SettingError::Conflict {
            method: GENERALIZED_ALPHA.id,
            key: "rho_inf",
            other: "family=hht",
            advice: "take rho_inf from 0.5 to 1, or family=chung-hulbert",
        });
    }
    Ok(())
}

/// `α_m`, `α_f`, `β`, `γ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coefficients {
    pub(crate) alpha_m: f64,
    pub(crate) alpha_f: f64,
    pub(crate) beta: f64,
    pub(crate) gamma: f64,
}

impl GeneralizedAlphaSettings {
    /// The coefficients of the step.
    pub(crate) fn coefficients(&self) -> Coefficients {
        let rho = self.rho_inf;
        let (alpha_m, alpha_f, gamma) = match self.family {
            Family::ChungHulbert => {
                let (m, f) = ((2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0));
                (m, f, 0.5 - m + f)
            }
            Family::Hht => {
                let f = (1.0 - rho) / (1.0 + rho);
                (0.0, f, 0.5 + f)
            }
            Family::Newmark => (0.0, 0.0, (3.0 - rho) / (2.0 + 2.0 * rho)),
        };
        let beta = 0.25 * (gamma + 0.5) * (gamma + 0.5);
        Coefficients { alpha_m, alpha_f, beta, gamma }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_oracle::recurrence::GeneralizedAlpha;

    #[test]
    fn the_coefficients_are_those_of_the_oracle() {
        for rho in [0.5, 0.8, 1.0] {
            for (family, expected) in [
                (Family::ChungHulbert, GeneralizedAlpha::chung_hulbert(rho)),
                (Family::Hht, GeneralizedAlpha::hht((1.0 - rho) / (1.0 + rho))),
                (Family::Newmark, GeneralizedAlpha::newmark(rho)),
            ] {
                let settings =
                    GeneralizedAlphaSettings { rho_inf: rho, family, ..Default::default() };
                let Coefficients { alpha_m, alpha_f, beta, gamma } = settings.coefficients();
                let apart = (alpha_m - expected.alpha_m).abs()
                    + (alpha_f - expected.alpha_f).abs()
                    + (beta - expected.beta).abs()
                    + (gamma - expected.gamma).abs();
                assert!(apart < 1e-15, "{family:?}, {rho}: {apart:e}");
            }
        }
        let refused = GeneralizedAlphaSettings::from_pairs([("family", "hht"), ("rho_inf", "0.3")]);
        assert!(refused.expect_err("no such member").to_string().contains("family=hht"));
    }
}
