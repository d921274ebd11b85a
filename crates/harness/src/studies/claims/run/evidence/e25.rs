//! What is run for claim C25.

use super::runs::{Exact, error, free_edge, track};
use super::scenes::{build, hanging};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c25::LIMIT;
use crate::run::Simulation;
use crate::scenes::bundled;
use drape_model::State;

pub(super) const TRIAL: Trial = Trial {
    id: "C25",
    scenes: || {
        "hanging sheets of 100 particles (k/m = 1e4 and 1e6, h = 0.01 and 0.002 s) and the paper's \
         table of 400: way of a particle in 1 s, error after 0.3 s against the true motion; change \
         relative to ε = 1e-6"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

/// The tightest stands for the others to be compared with.
const TERMS: [&str; 6] = ["1e-6", "1e-5", "1e-4", "1e-3", "1e-2", "1e-1"];
/// Simulated time after which the error is taken, s; the way is taken over a second.
const SPAN: f64 = 0.3;

/// The forms of the method; the paper's first.
const FORMS: [(&str, &str); 3] = [
    ("plain", "imex-euler:norm=euclid,implicit=springs,forcing_term="),
    ("updated as printed", "imex-updated:norm=euclid,safeguard=paper,max_outer=3000,forcing_term="),
    ("updated, safeguarded", "imex-updated:newton_above=1e300,max_outer=100000,forcing_term="),
];

struct Stage {
    name: &'static str,
    start: Simulation,
    step: f64,
    tracked: usize,
    /// Where the true motion is after the span; contacts have none.
    exact: Option<State>,
}

fn stages() -> Result<Vec<Stage>, HarnessError> {
    let mut stages = Vec::new();
    let sheets = [
        ("hanging, k/m = 1e4, h = 0.01 s", 1e4, 0.01),
        ("hanging, k/m = 1e6, h = 0.01 s", 1e6, 0.01),
        ("hanging, k/m = 1e6, h = 0.002 s", 1e6, 0.002),
    ];
    for (name, stiffness, step) in sheets {
        let spec = hanging(10, stiffness, 40.0).spec()?;
        let (start, tracked) = (build(&spec)?, free_edge(&spec));
        let exact = Some(Exact::new(&start, SPAN)?.state);
        stages.push(Stage { name, start, step, tracked, exact });
    }
    let start = crate::scenes::build(&bundled("square-table-1e4")?)?.1;
    let name = "table, k/m = 1e4, h = 0.01 s";
    stages.push(Stage { name, start, step: 0.01, tracked: 0, exact: None });
    Ok(stages)
}

/// Greatest changes of a form in a scene over the range of ε, relative to the tightest.
struct Row {
    form: &'static str,
    scene: &'static str,
    motion: f64,
    error: f64,
    /// From which ε down both stay within the limit, by the number of values that do.
    within: usize,
}

fn change(value: f64, tightest: f64) -> f64 {
    let change = (value / tightest - 1.0).abs();
    if change.is_nan() { f64::INFINITY } else { change }
}

fn row(form: (&'static str, &str), stage: &Stage) -> Result<Row, HarnessError> {
    let Stage { name, start, step, tracked, exact } = stage;
    let mut row = Row { form: form.0, scene: name, motion: 0.0, error: 0.0, within: 0 };
    let mut tightest = (0.0, 0.0);
    for (number, term) in TERMS.into_iter().enumerate() {
        let method = format!("{}{term}", form.1);
        let motion = track(start, &method, *step, 1.0, *tracked)?.path;
        let off = match exact {
            Some(exact) => {
                error(start, &track(start, &method, *step, SPAN, *tracked)?.state, exact)
            }
            None => 1.0,
        };
        if number == 0 {
            tightest = (motion, off);
        }
        row.motion = row.motion.max(change(motion, tightest.0));
        row.error = row.error.max(change(off, tightest.1));
        if row.motion < LIMIT && row.error < LIMIT {
            row.within = number + 1;
        }
    }
    Ok(row)
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut rows = Vec::new();
    for stage in stages()? {
        for form in FORMS {
            rows.push(row(form, &stage)?);
        }
    }
    Ok(numbers(&rows))
}

fn numbers(rows: &[Row]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for Row { form, scene, motion, error, within } in rows {
        let of = |what: &str| format!("{what}, {form}, {scene}");
        numbers.push(Number::new(of("change of the motion"), *motion, "").against(LIMIT));
        numbers.push(Number::new(of("change of the error"), *error, "").against(LIMIT));
        numbers.push(Number::new(of("values of ε within 5 %"), *within as f64, ""));
    }
    numbers
}
