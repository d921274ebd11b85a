//! What is run for claim C12.

use super::atlas::{SCENES, Survey, survey};
use super::scenes::greatest;
use super::{Number, Trial};
use crate::HarnessError;
use crate::studies::hard_cases::run::{self as hard_cases, HardCase};

pub(super) const TRIAL: Trial = Trial {
    id: "C12",
    scenes: || format!("{SCENES}; and the hard cases {} with and without damping", HARD.join(", ")),
    portable: false,
    is_quick: false,
    run: evidence,
    seconds: None,
};

/// As printed: predictor (22), ε = 0.1 as in the paper's tables, Algorithm 1, all springs in the
/// matrix.
const PAPER: &str =
    "imex-updated:norm=euclid,safeguard=paper,start=extrapolated,forcing_term=0.1,max_outer=20000";
const PAPER_TIGHTER: &str =
    "imex-updated:norm=euclid,safeguard=paper,start=extrapolated,forcing_term=0.05,max_outer=20000";
/// Without the updates.
const PLAIN: &str = "imex-euler:norm=euclid,forcing_term=0.05,start=extrapolated,implicit=springs";
/// Without updates and predictor, solved exactly.
const EXACT: &str = "imex-euler:norm=euclid,forcing_term=1e-10,start=last,implicit=springs";
const SAFEGUARDED: &str = "imex-updated";
/// All that can be run but those that are large (H03), vary ε (H19), or do not move (H17, H18), in
/// the method's settings.
const HARD: [&str; 11] =
    ["H01", "H02", "H04", "H05", "H06", "H07", "H09", "H10", "H12", "H13", "H20"];
/// Most visits of a spring in a run on a hard case: about 0.2 s.
const BUDGET: f64 = 4e7;

/// What is counted of a method.
struct Tally {
    runs: usize,
    failing: usize,
    /// Of the failing, those that gain more than half of what the scene sets free.
    gross: usize,
    unfinished: usize,
    worst: f64,
}

fn tally(atlas: &[Survey], hard: &[HardCase]) -> Tally {
    let is_bad = |run: &&Survey| run.verdict != drape_report::Verdict::Stable;
    let failing = atlas.iter().filter(is_bad).count();
    let gains = || atlas.iter().map(|run| run.gain).chain(hard.iter().map(|case| case.gain));
    Tally {
        runs: atlas.len() + hard.len(),
        failing: failing + hard.iter().filter(|case| !case.is_stable).count(),
        gross: gains().filter(|gain| *gain > 0.5).count(),
        unfinished: atlas.iter().filter(|run| run.is_over_budget).count()
            + hard.iter().filter(|case| case.is_over_budget).count(),
        worst: greatest(gains()),
    }
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let hard =
        hard_cases::survey(&[PAPER, PAPER_TIGHTER, PLAIN, EXACT, SAFEGUARDED], &HARD, BUDGET)?;
    let of = |method: &str, hard: &[HardCase]| Ok::<_, HarnessError>(tally(&survey(method)?, hard));
    let [loose, tight, plain, exact, safeguarded] = hard.as_slice() else {
        return Ok(numbers(&[], &tally(&[], &[]), &tally(&[], &[]), &tally(&[], &[])));
    };
    Ok(numbers(
        &[of(PAPER, loose)?, of(PAPER_TIGHTER, tight)?],
        &of(PLAIN, plain)?,
        &tally(&[], exact),
        &of(SAFEGUARDED, safeguarded)?,
    ))
}

fn numbers(paper: &[Tally], plain: &Tally, exact: &Tally, safeguarded: &Tally) -> Vec<Number> {
    let mut numbers = Vec::new();
    let names = ["updated CG as printed, ε = 0.1", "updated CG as printed, ε = 0.05"];
    let others = [
        ("no updates, ε = 0.05", plain),
        ("no updates, solved to 1e-10 from v_n, hard cases", exact),
        ("updated CG, safeguarded", safeguarded),
    ];
    for (name, tally) in names.into_iter().zip(paper).chain(others) {
        let what = format!("runs that are not stable, {name}");
        numbers.push(Number::new(what, tally.failing as f64, ""));
        let what = format!("runs that gain more than half of the energy set free, {name}");
        numbers.push(Number::new(what, tally.gross as f64, ""));
        numbers.push(Number::new(format!("runs, {name}"), tally.runs as f64, ""));
        let what = format!("runs over budget, {name}");
        numbers.push(Number::new(what, tally.unfinished as f64, "").of_machine());
        let what = format!("greatest energy gained over energy set free, {name}");
        numbers.push(Number::new(what, tally.worst, "").against(0.02));
    }
    numbers
}
