//! The runs on each scene.

use super::Case;
use crate::studies::solver_control::facts::{PLAIN, Run};

/// The scene of the quick subset.
pub(super) const QUICK_SCENE: &str = "hanging-1e4";
/// The scene whose runs are timed.
const TIMED_SCENE: &str = "hanging-1e6";
/// Step in the series that do not vary it, and time between two frames of adaptive runs, s.
const STEP: f64 = 0.01;
/// Inner tolerances.
const FORCING_TERMS: [f64; 6] = [0.5, 0.1, 1e-2, 1e-3, 1e-4, 1e-6];
/// Tolerances of the step size control, in mesh widths.
const TOLERANCES: [f64; 4] = [1e-1, 1e-2, 1e-3, 1e-4];
/// The tolerance whose step sizes are recorded.
const HISTORY_TOLERANCE: f64 = 1e-3;

/// A run, before it is made.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cell {
    pub(super) series: &'static str,
    pub(super) label: &'static str,
    pub(super) method: String,
    pub(super) is_adaptive: bool,
    pub(super) value: Option<f64>,
    pub(super) step_s: f64,
    pub(super) is_quick: bool,
    pub(super) is_timed: bool,
}

/// Methods whose inner tolerance is varied: label, method, and the setting of a constant term.
const INNER: [(&str, &str, &str); 2] = [
    ("backward-euler", "backward-euler:solver=cg", "cg_tolerance"),
    ("imex-euler", "imex-euler:implicit=springs", "forcing_term"),
];
/// Updated CG has no constant inner tolerance other than that of the step. Newton is switched off
/// here, so `h²k/m` above 100 takes very many updates.
const UPDATED: [(&str, &str); 2] = [
    ("imex-updated, to the end", "imex-updated:newton_above=1e300,max_outer=5000"),
    (
        "imex-updated, Eisenstat-Walker",
        "imex-updated:newton_above=1e300,max_outer=5000,forcing=eisenstat-walker",
    ),
];

const JACOBIANS: [(&str, &str); 4] = [
    ("fresh, Cholesky", "jacobian=fresh,solver=cholesky"),
    ("saved, Cholesky", "jacobian=saved,solver=cholesky"),
    ("fresh, CG", "jacobian=fresh,solver=cg,forcing=eisenstat-walker"),
    ("saved, CG", "jacobian=saved,solver=cg,forcing=eisenstat-walker"),
];

const PRECONDITIONERS: [(&str, &str); 4] = [
    ("none", "preconditioner=none"),
    ("jacobi", "preconditioner=jacobi"),
    ("ic0", "preconditioner=ic0"),
    ("cholesky", "solver=cholesky"),
];

/// Methods whose steps are varied: label, method, its settings, the number of halvings of 0.01 s to
/// the smallest constant step, and the settings of the adaptive run.
const STEPPED: [(&str, &str, &str, u32, &str); 5] = [
    ("backward-euler", "backward-euler", "jacobian=saved,solver=cholesky", 3, ""),
    ("bdf2", "bdf2", "jacobian=saved,solver=cholesky", 3, ""),
    ("imex-euler", "imex-euler", "forcing_term=1e-8,implicit=springs", 6, ",estimator=splitting"),
    (PLAIN, "imex-euler", "forcing_term=1e-8,implicit=springs", 0, ",estimator=plain"),
    ("imex-sbdf2", "imex-sbdf2", "forcing_term=1e-4", 5, ""),
];

/// Whether the step sizes of a run are recorded.
pub(super) fn has_history(run: &Run) -> bool {
    run.is_adaptive && run.value == Some(HISTORY_TOLERANCE)
}

/// All runs on a scene.
pub(super) fn all(case: &Case) -> Vec<Cell> {
    let mut list = steps(case);
    if !case.is_stretched {
        list.extend(forcing(case));
        list.extend(jacobians(case));
        list.extend(preconditioners(case));
    }
    list
}

fn cell(series: &'static str, label: &'static str, method: String, case: &Case) -> Cell {
    Cell {
        series,
        label,
        method,
        is_adaptive: false,
        value: None,
        step_s: STEP,
        is_quick: case.id == QUICK_SCENE,
        is_timed: case.id == TIMED_SCENE,
    }
}

fn forcing(case: &Case) -> Vec<Cell> {
    let mut list = Vec::new();
    for (label, method, key) in INNER {
        for term in FORCING_TERMS {
            let method = format!("{method}{}{key}={term:e}", separator(method));
            let is_timed = false;
            list.push(Cell { value: Some(term), is_timed, ..cell("forcing", label, method, case) });
        }
    }
    let walker = "backward-euler:solver=cg,forcing=eisenstat-walker".to_owned();
    list.push(cell("forcing", "backward-euler", walker, case));
    if STEP * STEP * case.stiffness <= 100.0 * (1.0 + 1e-12) {
        list.extend(UPDATED.map(|(label, method)| cell("forcing", label, method.to_owned(), case)));
    }
    list
}

fn separator(method: &str) -> &'static str {
    if method.contains(':') { "," } else { ":" }
}

fn jacobians(case: &Case) -> Vec<Cell> {
    let of = |id: &'static str, labels: [&'static str; 4]| {
        JACOBIANS.into_iter().zip(labels).map(move |((_, settings), label)| {
            cell("jacobian", label, format!("{id}:{settings}"), case)
        })
    };
    let backward_euler = [
        "backward-euler: fresh, Cholesky",
        "backward-euler: saved, Cholesky",
        "backward-euler: fresh, CG",
        "backward-euler: saved, CG",
    ];
    let bdf2 =
        ["bdf2: fresh, Cholesky", "bdf2: saved, Cholesky", "bdf2: fresh, CG", "bdf2: saved, CG"];
    of("backward-euler", backward_euler).chain(of("bdf2", bdf2)).collect()
}

fn preconditioners(case: &Case) -> Vec<Cell> {
    PRECONDITIONERS
        .into_iter()
        .map(|(label, settings)| {
            let method = format!("imex-euler:implicit=springs,{settings}");
            cell("preconditioner", label, method, case)
        })
        .collect()
}

fn steps(case: &Case) -> Vec<Cell> {
    let mut list = Vec::new();
    for (label, id, settings, halvings, adaptive) in STEPPED {
        let is_cheap = id.starts_with("imex");
        // The plain estimator is compared with the same constant steps.
        for n in (0..=halvings).filter(|_| label != PLAIN) {
            let step_s = STEP / f64::from(1 << n);
            let method = format!("{id}:{settings}");
            let bare = cell("steps", label, method, case);
            let is_quick = bare.is_quick && (is_cheap || n == 0);
            list.push(Cell { value: Some(step_s), step_s, is_quick, ..bare });
        }
        for tolerance in TOLERANCES {
            let method = format!("{id}:{settings},tolerance={tolerance:e}{adaptive}");
            let bare = cell("steps", label, method, case);
            let is_quick = bare.is_quick && tolerance >= if is_cheap { 1e-3 } else { 1e-1 };
            list.push(Cell { value: Some(tolerance), is_adaptive: true, is_quick, ..bare });
        }
    }
    list
}
