//! C16: IC makes the iteration converge in very few steps.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C16",
    origin: Origin::Paper { section: "5" },
    says: "IC makes the iteration converge in very few steps",
    criterion: "No solve to 1e-3 takes more than 10 iterations over the paper's range of \
                parameters.",
    reads: &[
        ": most of a solve, IC(0)",
        ": most of a solve, IC(0), ε = 0.05",
        ": mean of a step, ic0",
        ": most of a step, none",
        "share of steps with more than 10 iterations",
    ],
    overturned_by: "Solves that all take at most 10 iterations confirm it.",
    see: "cg-vs-stiffness.svg",
    age: Age::FIRST,
    judge,
    readings,
};

/// Most iterations of a solve.
pub(crate) const LIMIT: f64 = 10.0;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let most = |what: &str| {
        let counts = evidence.ending(what)?;
        Ok(counts.iter().fold(0.0_f64, |most, (_, number)| most.max(number.value)))
    };
    let solve = most(": most of a solve, IC(0)")?;
    let bare = most(": most of a step, none")?;
    let share = evidence.value("share of steps with more than 10 iterations")?;
    let reason = format!(
        "With IC(0) the dearest solve takes {solve} iterations, and {} % of the steps take more \
         than {LIMIT}. Without a preconditioner the dearest step takes {bare}.",
        told(100.0 * share)
    );
    Ok(Judgement::new(solve <= LIMIT, reason))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let most = |what: &str| {
        let counts = evidence.ending(what)?;
        Ok(counts.iter().fold(0.0_f64, |most, (_, number)| most.max(number.value)))
    };
    let loose = most(": most of a solve, IC(0), ε = 0.05")?;
    let mean = most(": mean of a step, ic0")?;
    Ok(vec![
        Reading::new(
            "At ε = 0.05 no solve takes more than 10 iterations.",
            loose <= LIMIT,
            format!("{} at most", told(loose)),
        ),
        Reading::new(
            "On average a step to 1e-3 takes at most 10 iterations.",
            mean <= LIMIT,
            format!("{} in the dearest row", told(mean)),
        ),
    ])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn the_dearest_solve_decides() {
        let verdict = |solve| {
            let numbers = [
                ("table 2 row 1: most of a solve, IC(0)", 4.0),
                ("table 2 row 2: most of a solve, IC(0)", solve),
                ("table 2 row 1: most of a step, none", 50.0),
                ("share of steps with more than 10 iterations", 0.0),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(10.0), Ruling::Holds);
        assert_eq!(verdict(11.0), Ruling::Fails);
    }
}
