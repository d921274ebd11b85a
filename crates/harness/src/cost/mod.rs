//! What counted work costs: a common currency for methods whose kernels differ.
//!
//! A visit of a spring takes some 2 ns in a sweep of forces and three to eight times as long in a
//! sweep over constraints, so visits alone cannot rank methods of different kinds. The *modelled time* of a
//! run multiplies its visits of each kind by a price, and adds up the products:
//!
//! ```text
//! t = Σ_i p_i w_i,
//! ```
//!
//! with `w` the [visits](Counted::visits_by_kind) of each kind and `p ≥ 0` the prices, ns a visit,
//! of the method's form. The prices are fitted to measured times (see [`fit`]). They are part of
//! the source, with the machine and the commit at which they were measured. So the modelled time is
//! the same on every machine that takes the same steps, and no verdict depends on a clock.
//!
//! The timed runs to which the table is fitted stand beside it in the source, and a test fits it
//! again. The table says for each form how far its model is from the measured times. A lead that is
//! smaller than this error does not count.

pub mod fit;

use crate::record::Totals;
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

/// Number of kinds of counted work.
pub const KINDS: usize = 8;

/// Visits that stand for what a sweep or a product costs besides its length: lanes that stay empty,
/// and waiting for memory.
const EACH: f64 = 100.0;

/// Work is unlike the timed runs if its modelled time a visit is less than this share of the least
/// modelled time a visit among them.
const UNLIKE: f64 = 0.25;

/// The counted work of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counted {
    /// Steps.
    pub steps: u64,
    /// Sweeps over all springs that evaluated forces or energies, or corrected positions.
    pub force_evaluations: u64,
    /// Products of a matrix with a block vector, triangular solves included.
    pub matvecs: u64,
    /// Factorisations of Newton's matrix.
    pub factorisations: u64,
    /// Set-ups of cached operators.
    pub setups: u64,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
}

impl Counted {
    /// The work of a run of `steps` steps.
    #[must_use]
    pub fn of(totals: &Totals, steps: u64, particles: usize, springs: usize) -> Self {
        let Totals { force_evaluations, matvecs, factorisations, setups, .. } = *totals;
        Self { steps, force_evaluations, matvecs, factorisations, setups, particles, springs }
    }

    /// Visits of a spring of each kind: in sweeps of forces and in products, by their length; in
    /// factorisations and set-ups, by the fill-in of a planar mesh, `n^1.5` (Newton's matrix has 3×3
    /// blocks); in steps; in the set-up of the run; and for each sweep and each product, whatever
    /// its length.
    #[must_use]
    pub fn visits_by_kind(&self) -> [f64; KINDS] {
        let [n, springs] = [self.particles, self.springs].map(|count| count as f64);
        let planar = n * n.sqrt();
        [
            self.force_evaluations as f64 * (springs + n),
            self.matvecs as f64 * 2.0 * (springs + n),
            self.factorisations as f64 * 80.0 * planar,
            self.setups as f64 * 8.0 * planar,
            self.steps as f64 * 4.0 * n,
            8.0 * planar,
            self.force_evaluations as f64 * EACH,
            self.matvecs as f64 * EACH,
        ]
    }

    /// All visits of the steps, which are the unit of budgets. The unit is the same for every
    /// method and does not depend on how long a visit takes.
    #[must_use]
    pub fn visits(&self) -> f64 {
        let [forces, products, factorisations, setups, steps, ..] = self.visits_by_kind();
        forces + products + factorisations + setups + steps
    }

    /// Modelled time by prices, s. Where two kinds of work grew together in all timed runs, the fit
    /// may give all of their time to one of them, and no price to the other. Then work of the other
    /// kind alone would cost too little, for example an undamped run of a method that was timed
    /// with damping. Such work is unlike all timed runs, and the prices of a plain sweep count.
    #[must_use]
    pub fn seconds(&self, price: &Price) -> f64 {
        let visits = self.visits_by_kind();
        let by = |prices: &[f64; KINDS]| -> f64 {
            1e-9 * visits.iter().zip(prices).map(|(count, ns)| count * ns).sum::<f64>()
        };
        let seconds = by(&price.ns_a_visit);
        let is_timed = seconds >= UNLIKE * 1e-9 * price.least_ns_a_visit * self.visits();
        if is_timed { seconds } else { by(&PLAIN.ns_a_visit) }
    }
}

/// The prices of one form of a method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Price {
    /// Method id with settings, as in a run.
    pub method: String,
    /// Nanoseconds a visit of each kind of work.
    pub ns_a_visit: [f64; KINDS],
    /// Least modelled time a visit, ns, among the runs to which the prices were fitted.
    pub least_ns_a_visit: f64,
    /// Timed runs to which the prices were fitted.
    pub runs: usize,
    /// The greatest factor between modelled and measured time in nine of ten of these runs.
    pub within: f64,
    /// The same factor where the model of each run was fitted to the other runs; `None` where there
    /// are too few runs.
    pub left_out: Option<f64>,
}

impl Price {
    /// Visits that take at least this time, s, whatever kind of work they are: the budget in visits
    /// of a run that may take this time.
    #[must_use]
    pub fn visits_within(&self, seconds: f64) -> f64 {
        1e9 * seconds / self.least_ns_a_visit
    }
}

/// All prices, with their origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prices {
    /// Processor on which the times were measured.
    pub cpu: String,
    /// Commit of the program that measured.
    pub commit: String,
    /// One a form.
    pub forms: Vec<Price>,
}

/// The table that is part of the source.
#[allow(clippy::expect_used, reason = "a test reads the same text")]
static PRICES: LazyLock<Prices> =
    LazyLock::new(|| serde_json::from_str(include_str!("prices.json")).expect("a valid table"));

/// Prices of the same forms on a processor of another maker.
#[allow(clippy::expect_used, reason = "a test reads the same text")]
static OTHER_PRICES: LazyLock<Prices> = LazyLock::new(|| {
    serde_json::from_str(include_str!("prices-epyc.json")).expect("a valid table")
});

/// Prices that were measured on a processor of another maker. They show which answers depend on the
/// machine of the [prices](prices()).
#[must_use]
pub fn other_prices() -> &'static Prices {
    &OTHER_PRICES
}

/// The prices by which runs are ranked.
#[must_use]
pub fn prices() -> &'static Prices {
    &PRICES
}

impl Prices {
    /// The prices that were fitted to this form, however its settings are written; `None` where it
    /// was never timed.
    #[must_use]
    pub fn own(&self, method: &str) -> Option<&Price> {
        let whole = |text: &str| Some(crate::methods::Choice::parse(text, &[]).ok()?.full_id());
        let same = |price: &&Price| price.method == method;
        self.forms.iter().find(same).or_else(|| {
            let wanted = whole(method)?;
            self.forms.iter().find(|price| whole(&price.method).is_some_and(|id| id == wanted))
        })
    }

    /// The prices of a form: its own, else those of the method's first form in the table, else
    /// those of a plain sweep of forces. A user's method has the prices of a plain sweep.
    #[must_use]
    pub fn of(&self, method: &str) -> &Price {
        let id = |method: &str| method.split(':').next().map(str::to_owned);
        let alike = || self.forms.iter().find(|price| id(&price.method) == id(method));
        self.own(method).or_else(alike).unwrap_or(&PLAIN)
    }
}

/// Prices of a method that was never timed.
static PLAIN: Price = Price {
    method: String::new(),
    ns_a_visit: [2.0; KINDS],
    least_ns_a_visit: 2.0,
    runs: 0,
    within: f64::INFINITY,
    left_out: None,
};

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    /// Both tables have the same forms, so a ranking by the other prices is one of the same forms.
    #[test]
    fn the_other_prices_are_of_another_processor_and_of_the_same_forms() {
        let forms = |prices: &Prices| -> Vec<String> {
            let whole = |price: &Price| {
                crate::methods::Choice::parse(&price.method, &[])
                    .map_or_else(|_| price.method.clone(), |choice| choice.full_id())
            };
            let mut forms: Vec<String> = prices.forms.iter().map(whole).collect();
            forms.sort();
            forms
        };
        assert_eq!(forms(prices()), forms(other_prices()));
        assert_ne!(prices().cpu, other_prices().cpu);
    }

    /// A form stays the same with all its settings written out. A form that was never timed has no
    /// price.
    #[test]
    fn a_form_is_known_by_its_settings_however_they_are_written() {
        for price in &prices().forms {
            let Ok(choice) = crate::methods::Choice::parse(&price.method, &[]) else { continue };
            assert_eq!(prices().of(&choice.full_id()), price, "{}", price.method);
        }
        assert!(prices().own("symplectic-euler:damping=implicit").is_none());
        assert!(prices().own("no-such").is_none());
    }

    const WORK: Counted = Counted {
        steps: 10,
        force_evaluations: 20,
        matvecs: 30,
        factorisations: 2,
        setups: 1,
        particles: 100,
        springs: 342,
    };

    #[test]
    fn visits_count_sweeps_by_their_length_and_factors_by_their_fill_in() {
        let kinds = [20.0 * 442.0, 30.0 * 884.0, 2.0 * 80e3, 8e3, 10.0 * 400.0, 8e3, 2e3, 3e3];
        assert_eq!(WORK.visits_by_kind(), kinds);
        assert_eq!(WORK.visits(), kinds[..5].iter().sum::<f64>());
    }

    #[test]
    fn modelled_time_is_the_sum_of_prices_times_visits() {
        let price = Price {
            method: "a".to_owned(),
            ns_a_visit: [1.0, 0.0, 0.5, 0.0, 2.0, 0.0, 1.0, 0.0],
            least_ns_a_visit: 0.5,
            runs: 9,
            within: 1.1,
            left_out: None,
        };
        assert_eq!(WORK.seconds(&price), 1e-9 * (8840.0 + 80e3 + 8e3 + 2e3));
    }

    /// The price of a method whose timed runs were damped rests on products. An undamped run has no
    /// products.
    #[test]
    fn work_unlike_all_timed_runs_costs_what_a_plain_sweep_does() {
        // Prices of `srkn4` as they were fitted once: all its timed runs were damped.
        let mut ns_a_visit = [0.0; KINDS];
        ns_a_visit[1] = 0.7884;
        let price = &Price {
            method: "srkn4".to_owned(),
            ns_a_visit,
            least_ns_a_visit: 0.717,
            runs: 3,
            within: 1.0,
            left_out: None,
        };
        let undamped = Counted { matvecs: 0, factorisations: 0, setups: 0, ..WORK };
        let visits: f64 = undamped.visits_by_kind().iter().sum();
        let is_near = |seconds: f64, ns: f64| (1e9 * seconds / ns - 1.0).abs() < 1e-12;
        assert!(is_near(undamped.seconds(price), 2.0 * visits));
        let damped = Counted { matvecs: 600, ..undamped };
        assert!(is_near(damped.seconds(price), price.ns_a_visit[1] * 600.0 * 884.0));
    }

    #[test]
    fn a_form_has_its_own_price_or_that_of_its_method() {
        let form = |method: &str, ns: f64| Price {
            method: method.to_owned(),
            ns_a_visit: [ns; KINDS],
            least_ns_a_visit: ns,
            runs: 1,
            within: 1.0,
            left_out: None,
        };
        let forms = vec![form("a:x=1", 1.0), form("a", 2.0), form("b", 3.0)];
        let prices = Prices { cpu: String::new(), commit: String::new(), forms };
        for (method, ns) in [("a", 2.0), ("a:x=1", 1.0), ("a:x=2", 1.0), ("b:y=1", 3.0), ("c", 2.0)]
        {
            assert_eq!(prices.of(method).ns_a_visit, [ns; KINDS], "{method}");
        }
        assert!(prices.of("c").within.is_infinite());
    }

    /// The fit of the committed timed runs gives the committed table.
    #[test]
    fn the_table_follows_from_its_samples() {
        let samples: fit::Samples = serde_json::from_str(include_str!("samples.json")).unwrap();
        let fitted = samples.prices();
        assert_eq!((&fitted.cpu, &fitted.commit), (&prices().cpu, &prices().commit));
        for (ours, theirs) in fitted.forms.iter().zip(&prices().forms) {
            assert_eq!(ours, theirs, "run `cargo run --release -p drape-tests --bin prices`");
        }
        assert_eq!(fitted.forms.len(), prices().forms.len());
    }

    /// A form without a price, or a model far from the measured times, would make a ranking by
    /// modelled time wrong.
    #[test]
    fn every_method_of_the_registry_has_a_price_that_tells_its_time() {
        for method in crate::methods::all() {
            let price = prices().of(method.id);
            assert!(price.runs > 0, "{} has no price", method.id);
        }
        for price in &prices().forms {
            assert!(price.ns_a_visit.iter().any(|ns| *ns > 0.0), "{}", price.method);
            assert!(price.least_ns_a_visit > 0.1, "{}", price.method);
            assert!(price.within <= 1.25, "{}: within {}", price.method, price.within);
        }
        let forms = prices().forms.iter();
        let tried: Vec<_> = forms.filter_map(|p| Some((p.method.as_str(), p.left_out?))).collect();
        assert!(tried.len() > 50);
        for (method, factor) in tried {
            assert!(factor <= 1.25, "{method}: within {factor}, left out");
        }
    }
}
