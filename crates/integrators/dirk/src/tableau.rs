//! Coefficients of the methods.

use drape_integrator::{Order, Word};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// A diagonally implicit Runge–Kutta method: all implicit stages have the same `a_ii = γ`, and the
/// last stage is the new level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tableau {
    /// Trapezoidal rule, then BDF2, over parts of the step: order 2, stage order 2.
    TrBdf2,
    /// Alexander's method of order 2, stage order 1.
    Sdirk2,
    /// Alexander's method of order 3, stage order 1.
    Sdirk3,
    /// Kværnø's method of order 3, stage order 2.
    Esdirk3,
    /// Hairer and Wanner's method of order 4, stage order 1.
    Sdirk4,
}

impl Word for Tableau {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("tr-bdf2", Self::TrBdf2),
        ("sdirk2", Self::Sdirk2),
        ("sdirk3", Self::Sdirk3),
        ("esdirk3", Self::Esdirk3),
        ("sdirk4", Self::Sdirk4),
    ];
}

/// `γ`, and the rows of `a_ij` left of the diagonal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coefficients {
    /// `a_ii` of the implicit stages.
    pub(crate) gamma: f64,
    /// `a_ij`, `j < i`. The first row is empty, the last one with `γ` is `b`.
    pub(crate) rows: &'static [&'static [f64]],
    /// Whether the first stage is explicit: it is the level `n` itself.
    pub(crate) is_first_explicit: bool,
}

impl Coefficients {
    /// `a_ii`.
    fn diagonal(&self, stage: usize) -> f64 {
        if stage == 0 && self.is_first_explicit { 0.0 } else { self.gamma }
    }

    /// `c_i = Σ_j a_ij`: the time of the stage, in steps.
    pub(crate) fn time(&self, stage: usize) -> f64 {
        self.rows.get(stage).map_or(0.0, |row| row.iter().sum()) + self.diagonal(stage)
    }
}

/// `1 − 1/√2`, which makes two stages L-stable.
const SECOND: f64 = 1.0 - FRAC_1_SQRT_2;
/// Root of `γ³ − 3γ² + 3γ/2 − 1/6`, which makes three stages L-stable.
const THIRD: f64 = 0.435_866_521_508_459;
const WEIGHT: f64 = 0.25 * SQRT_2;

const TR_BDF2: Coefficients = Coefficients {
    gamma: SECOND,
    rows: &[&[], &[SECOND], &[WEIGHT, WEIGHT]],
    is_first_explicit: true,
};

const SDIRK2: Coefficients =
    Coefficients { gamma: SECOND, rows: &[&[], &[1.0 - SECOND]], is_first_explicit: false };

const SDIRK3: Coefficients = Coefficients {
    gamma: THIRD,
    rows: &[
        &[],
        &[0.5 * (1.0 - THIRD)],
        &[
            (4.0 - 1.5 * THIRD) * THIRD - 0.25, // −3γ²/2 + 4γ − ¼
            (1.5 * THIRD - 5.0) * THIRD + 1.25, // 3γ²/2 − 5γ + 5/4
        ],
    ],
    is_first_explicit: false,
};

const ESDIRK3: Coefficients = Coefficients {
    gamma: THIRD,
    rows: &[
        &[],
        &[THIRD],
        &[0.490_563_388_421_780_57, 0.073_570_090_069_760_43],
        &[0.308_809_969_976_746_53, 1.490_563_388_421_780_6, -1.235_239_879_906_987],
    ],
    is_first_explicit: true,
};

const SDIRK4: Coefficients = Coefficients {
    gamma: 0.25,
    rows: &[
        &[],
        &[0.5],
        &[17.0 / 50.0, -1.0 / 25.0],
        &[371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0],
        &[25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0],
    ],
    is_first_explicit: false,
};

impl Tableau {
    /// Its coefficients.
    pub(crate) fn coefficients(self) -> &'static Coefficients {
        match self {
            Self::TrBdf2 => &TR_BDF2,
            Self::Sdirk2 => &SDIRK2,
            Self::Sdirk3 => &SDIRK3,
            Self::Esdirk3 => &ESDIRK3,
            Self::Sdirk4 => &SDIRK4,
        }
    }

    /// Its order.
    pub fn order(self) -> Order {
        match self {
            Self::TrBdf2 | Self::Sdirk2 => Order::Two,
            Self::Sdirk3 | Self::Esdirk3 => Order::Three,
            Self::Sdirk4 => Order::Four,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_oracle::recurrence::RungeKutta;

    #[test]
    fn the_coefficients_are_those_of_the_oracle() {
        for (tableau, expected) in [
            (Tableau::TrBdf2, RungeKutta::tr_bdf2()),
            (Tableau::Sdirk2, RungeKutta::sdirk2()),
            (Tableau::Sdirk3, RungeKutta::sdirk3()),
            (Tableau::Esdirk3, RungeKutta::esdirk3()),
            (Tableau::Sdirk4, RungeKutta::sdirk4()),
        ] {
            let found = tableau.coefficients();
            assert_eq!(found.rows.len(), expected.b.len(), "{tableau:?}");
            for (i, row) in expected.a.iter().enumerate() {
                let all = found.rows[i].iter().copied().chain([found.diagonal(i)]);
                let pairs = all.zip(row);
                assert!(pairs.clone().count() == i + 1, "{tableau:?}, row {i}");
                pairs.for_each(|(a, b)| assert!((a - b).abs() < 1e-15, "{tableau:?}: {a} {b}"));
                assert!((found.time(i) - row.iter().sum::<f64>()).abs() < 1e-15);
            }
            assert!((found.time(found.rows.len() - 1) - 1.0).abs() < 1e-14, "{tableau:?}");
        }
    }
}
