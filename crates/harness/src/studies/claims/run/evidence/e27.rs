//! What is run for claim C27.

use super::runs::{Exact, error, track};
use super::scenes::{build, hanging};
use super::{Number, Trial};
use crate::HarnessError;
use drape_oracle::order::{Sample, observed_order};

pub(super) const TRIAL: Trial = Trial {
    id: "C27",
    scenes: || {
        "a hanging sheet of 144 particles, k/m = 1e4, 1e5 and 1e6, tension springs only, d/m = 40 \
         1/s; error of the positions after 0.3 s against leapfrog at a tenth of its stability \
         limit"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

/// Simulated time, s: the sheet is on its way down.
const SPAN: f64 = 0.3;
/// Steps within the span: h = 0.01 to 0.00125 s, the range of the paper's tables.
const COUNTS: [u32; 4] = [30, 60, 120, 240];

/// Forms of the method: with the paper's order of tolerance, and solved until the tolerance does
/// not count.
const FORMS: [(&str, &str); 4] = [
    ("plain, ε = 0.05", "imex-euler:norm=euclid,forcing_term=0.05"),
    ("plain, ε = 1e-10", "imex-euler:norm=euclid,forcing_term=1e-10"),
    (
        "updated, ε = 0.05",
        "imex-updated:norm=euclid,safeguard=paper,implicit=tension,forcing_term=0.05",
    ),
    (
        "updated, ε = 1e-8",
        "imex-updated:norm=euclid,safeguard=paper,implicit=tension,forcing_term=1e-8,max_outer=20000",
    ),
];

/// What one form does in one scene.
struct Row {
    stiffness: f64,
    form: &'static str,
    order: f64,
    /// Errors over the motion at the coarsest and the finest step.
    errors: [f64; 2],
    /// CG iterations a step at the dearest step size.
    per_step: f64,
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let (mut rows, mut reference) = (Vec::new(), 0.0_f64);
    for stiffness in [1e4, 1e5, 1e6] {
        let start = build(&hanging(12, stiffness, 40.0).spec()?)?;
        let Exact { state: exact, doubt } = Exact::new(&start, SPAN)?;
        reference = reference.max(doubt);
        for (form, method) in FORMS {
            let (mut samples, mut per_step) = (Vec::new(), 0.0_f64);
            for count in COUNTS {
                let step = SPAN / f64::from(count);
                let run = track(&start, method, step, SPAN, 0)?;
                per_step = per_step.max(run.per_step());
                samples.push(Sample { step, error: error(&start, &run.state, &exact) });
            }
            // A run that blew up has no order.
            let order = observed_order(&samples).map_or(0.0, |observed| observed.order);
            let errors = [samples[0].error, samples[samples.len() - 1].error];
            rows.push(Row { stiffness, form, order, errors, per_step });
        }
    }
    Ok(numbers(&rows, reference))
}

fn numbers(rows: &[Row], reference: f64) -> Vec<Number> {
    let mut numbers = Vec::new();
    for Row { stiffness, form, order, errors, per_step } in rows {
        let of = |what: &str| format!("{what}, {form}, k/m = {stiffness:e}");
        numbers.push(Number::new(of("order"), *order, "").against(1.0));
        numbers.push(Number::new(of("error at h = 0.01 s"), errors[0], ""));
        numbers.push(Number::new(of("error at h = 0.00125 s"), errors[1], ""));
        numbers.push(Number::new(of("CG iterations a step at most"), *per_step, ""));
    }
    numbers.push(Number::new("reference against twice its step, over the motion", reference, ""));
    numbers
}
