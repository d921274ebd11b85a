//! C25: a constant forcing term suffices.

use super::runs::{Exact, error, free_edge, track};
use super::scenes::{build, hanging};
use super::{Claim, Finding, Number, Verdict};
use crate::HarnessError;
use crate::run::Simulation;
use crate::scenes::bundled;
use crate::studies::short;
use drape_model::State;

pub(super) const CLAIM: Claim = Claim {
    id: "C25",
    section: "7",
    says: "a constant forcing term suffices",
    criterion: "error and motion change < 5 % over ε = 1e-1 … 1e-6",
    is_quick: false,
    test,
    seconds: None,
};

const LIMIT: f64 = 0.05;
/// The tightest stands for the others to be compared with.
const TERMS: [&str; 6] = ["1e-6", "1e-5", "1e-4", "1e-3", "1e-2", "1e-1"];
/// Simulated time after which the error is taken, s; the way is taken over a second.
const SPAN: f64 = 0.3;

/// The forms of the method; the paper's first.
const FORMS: [(&str, &str); 3] = [
    ("plain", "imex-euler:implicit=springs,forcing_term="),
    ("updated as printed", "imex-updated:safeguard=paper,max_outer=3000,forcing_term="),
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

fn test() -> Result<Finding, HarnessError> {
    let mut rows = Vec::new();
    for stage in stages()? {
        for form in FORMS {
            rows.push(row(form, &stage)?);
        }
    }
    Ok(judge(&rows))
}

fn judge(rows: &[Row]) -> Finding {
    let mut numbers = Vec::new();
    for Row { form, scene, motion, error, within } in rows {
        let of = |what: &str| format!("{what}, {form}, {scene}");
        numbers.push(Number::new(of("change of the motion"), *motion, "").against(LIMIT));
        numbers.push(Number::new(of("change of the error"), *error, "").against(LIMIT));
        numbers.push(Number::new(of("values of ε within 5 %"), *within as f64, ""));
    }
    let paper = || rows.iter().filter(|row| row.form != FORMS[2].0);
    let suffices = |row: &&Row| row.motion < LIMIT && row.error < LIMIT;
    let (good, all) = (paper().filter(suffices).count(), paper().count());
    let worst = paper().map(|row| row.motion.max(row.error)).fold(0.0, f64::max);
    let safe: Vec<_> = rows.iter().filter(|row| row.form == FORMS[2].0).collect();
    let kept = safe.iter().map(|row| row.motion.max(row.error)).fold(0.0, f64::max);
    let is_met = good == all;
    Finding {
        verdict: Verdict::of(is_met),
        numbers,
        reason: format!(
            "Over ε = 1e-6 to 0.1 error and motion stay within 5 % in {good} of {all} pairs of scene and form of the method (plain, and \
             updated as printed); the greatest change is {} times the value at 1e-6. |b| grows like θ, so that a constant ε \
             relative to it lets the sum of the forces itself go unsolved in stiff scenes.",
            short(worst)
        ),
        repair: (!is_met && kept < worst).then(|| {
            format!(
                "measure the residual by what the forces change within the step instead of by |b|, and start where the potential \
                 is lower: the greatest change is {} then, and ε = 1e-2 and smaller stay within 5 % in {} of {} scenes.",
                short(kept),
                safe.iter().filter(|row| row.within >= TERMS.len() - 1).count(),
                safe.len()
            )
        }),
        scenes: "hanging sheets of 100 particles (k/m = 1e4 and 1e6, h = 0.01 and 0.002 s) and the paper's table of 400: way of a \
                 particle in 1 s, error after 0.3 s against the true motion; change relative to ε = 1e-6"
            .to_owned(),
        see: "cg-vs-forcing-term.svg",
        portable: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_of_the_paper_decide_and_the_safeguarded_does_not() {
        let row = |form, motion| Row { form, scene: "", motion, error: 0.01, within: 0 };
        let of = |plain, printed, safe| {
            let rows = [row(FORMS[0].0, plain), row(FORMS[1].0, printed), row(FORMS[2].0, safe)];
            judge(&rows).verdict
        };
        assert_eq!(of(0.04, 0.04, 1.0), Verdict::Confirmed);
        assert_eq!(of(0.04, 0.06, 0.0), Verdict::Refuted);
        assert_eq!(of(0.06, 0.04, 0.0), Verdict::Refuted);
    }
}
