//! C12: stable under all circumstances and with all feasible parameters.

use super::atlas::{SCENES, Survey, survey, told};
use super::scenes::greatest;
use super::{Claim, Finding, Number, Verdict};
use crate::HarnessError;
use crate::studies::hard_cases::run::{self as hard_cases, HardCase};
use crate::studies::short;

pub(super) const CLAIM: Claim = Claim {
    id: "C12",
    section: "4",
    says: "stable under all circumstances and with all feasible parameters",
    criterion: "no energy growth with the paper's own ε, predictor and updates, over the stability atlas and the hard cases",
    is_quick: false,
    test,
    seconds: None,
};

/// As printed: predictor (22), ε = 0.1 as in the paper's tables, Algorithm 1, all springs in the matrix.
const PAPER: &str =
    "imex-updated:safeguard=paper,start=extrapolated,forcing_term=0.1,max_outer=20000";
const PAPER_TIGHTER: &str =
    "imex-updated:safeguard=paper,start=extrapolated,forcing_term=0.05,max_outer=20000";
/// Without the updates.
const PLAIN: &str = "imex-euler:forcing_term=0.05,start=extrapolated,implicit=springs";
/// Without updates and predictor, solved exactly.
const EXACT: &str = "imex-euler:forcing_term=1e-10,start=last,implicit=springs";
const SAFEGUARDED: &str = "imex-updated";
/// All that can be run but those that are large (H03), vary ε (H19), or do not move (H17, H18), in the method's settings.
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
    names: Vec<String>,
}

fn tally(atlas: &[Survey], hard: &[HardCase]) -> Tally {
    let is_bad = |run: &&Survey| run.verdict != drape_report::Verdict::Stable;
    let names = atlas.iter().filter(is_bad).map(|run| told(&run.place));
    let cases = hard.iter().filter(|case| !case.is_stable).map(|case| case.name.clone());
    let names: Vec<_> = names.chain(cases).collect();
    let gains = || atlas.iter().map(|run| run.gain).chain(hard.iter().map(|case| case.gain));
    Tally {
        runs: atlas.len() + hard.len(),
        failing: names.len(),
        gross: gains().filter(|gain| *gain > 0.5).count(),
        unfinished: atlas.iter().filter(|run| run.is_over_budget).count()
            + hard.iter().filter(|case| case.is_over_budget).count(),
        worst: greatest(gains()),
        names,
    }
}

fn test() -> Result<Finding, HarnessError> {
    let hard =
        hard_cases::survey(&[PAPER, PAPER_TIGHTER, PLAIN, EXACT, SAFEGUARDED], &HARD, BUDGET)?;
    let of = |method: &str, hard: &[HardCase]| Ok::<_, HarnessError>(tally(&survey(method)?, hard));
    let [loose, tight, plain, exact, safeguarded] = hard.as_slice() else {
        return Ok(judge(&[], &tally(&[], &[]), &tally(&[], &[]), &tally(&[], &[])));
    };
    Ok(judge(
        &[of(PAPER, loose)?, of(PAPER_TIGHTER, tight)?],
        &of(PLAIN, plain)?,
        &tally(&[], exact),
        &of(SAFEGUARDED, safeguarded)?,
    ))
}

fn judge(paper: &[Tally], plain: &Tally, exact: &Tally, safeguarded: &Tally) -> Finding {
    let failing: usize = paper.iter().map(|tally| tally.failing).sum();
    let runs: usize = paper.iter().map(|tally| tally.runs).sum();
    let worst = greatest(paper.iter().map(|tally| tally.worst));
    let gross: usize = paper.iter().map(|tally| tally.gross).sum();
    let first = paper.iter().find_map(|tally| tally.names.first().cloned()).unwrap_or_default();
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
    let is_met = failing == 0;
    let seen = if is_met {
        format!("All {runs} runs as printed are stable.")
    } else {
        let size = if worst < f64::MAX {
            format!("{} times", short(worst))
        } else {
            "without bound against".to_owned()
        };
        format!(
            "As printed, {failing} of {runs} runs are not stable (first: {first}); {gross} of them gain more than half of the energy set free, \
             the worst {size} it."
        )
    };
    Finding {
        verdict: Verdict::of(is_met),
        numbers,
        reason: format!(
            "{seen} The stop test compares with ‖b‖, which holds the whole momentum and grows like h²k/m, so that a loose ε accepts the \
             predictor 2v_n − v_(n−1) unchanged for many steps: the extrapolation feeds on itself. Without updates {} of {} \
             runs at ε = 0.05 fail.",
            plain.failing, plain.runs
        ),
        repair: (!is_met).then(|| {
            format!(
                "Solved to 1e-10 from v_n, IMEX Euler without updates fails in {} of {} hard cases ({}; the atlas is claim C02); the safeguarded updates (start of \
                 the lower potential, residual measured against the change of momentum, Newton at high stiffness) fail in {} \
                 of {}.",
                exact.failing,
                exact.runs,
                exact.names.join(", "),
                safeguarded.failing,
                safeguarded.runs
            )
        }),
        scenes: format!("{SCENES}; and the hard cases {} with and without damping", HARD.join(", ")),
        see: "hard-cases.svg",
        portable: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tally(failing: usize) -> Tally {
        Tally {
            runs: 9,
            failing,
            gross: 0,
            unfinished: 0,
            worst: failing as f64,
            names: Vec::new(),
        }
    }

    #[test]
    fn one_unstable_run_of_the_printed_form_refutes_whatever_the_others_do() {
        let verdict = |paper: [usize; 2], others: usize| {
            let others = tally(others);
            judge(&paper.map(tally), &others, &others, &others).verdict
        };
        assert_eq!(verdict([0, 0], 3), Verdict::Confirmed);
        assert_eq!(verdict([0, 1], 0), Verdict::Refuted);
    }
}
