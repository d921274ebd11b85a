//! C19: repositioning causes a severe increase of CG iterations.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C19",
    origin: Origin::Paper { section: "6" },
    says: "repositioning causes a severe increase of CG iterations",
    criterion: "Repositioning takes at least twice the iterations of the velocity constraint, in \
                the same scene.",
    reads: &[
        "least ratio, IMEX Euler, ",
        "greatest ratio, IMEX Euler, ",
        "least ratio, Baraff-Witkin, ",
        "greatest ratio, Baraff-Witkin, ",
        "scenes of `collision`",
        "scenes of `collision` with a ratio of at least 2",
        "greatest ratio in a scene of `collision`",
    ],
    overturned_by: "Ratios of at least 2 in every run of the paper's own system confirm it.",
    see: "collision-iterations.svg",
    age: Age::FIRST,
    judge,
    readings,
};

/// Least ratio of the iterations.
pub(crate) const LIMIT: f64 = 2.0;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let of = |method: &str| {
        let (low, _) = span(&evidence.values(&format!("least ratio, {method}, "))?);
        let (_, high) = span(&evidence.values(&format!("greatest ratio, {method}, "))?);
        Ok((low, high))
    };
    let (own, theirs) = (of("IMEX Euler")?, of("Baraff-Witkin")?);
    let is_met = own.0 >= LIMIT;
    let why = " Either way the matrix sees the same springs, stretched by the same depth.";
    let reason = format!(
        "Repositioning takes {} to {} times the iterations of the velocity constraint in IMEX \
         Euler, and {} to {} times in Baraff and Witkin's step.{}",
        told(own.0),
        told(own.1),
        told(theirs.0),
        told(theirs.1),
        if is_met { "" } else { why }
    );
    Ok(Judgement::new(is_met, reason))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let many = evidence.value("scenes of `collision` with a ratio of at least 2")?;
    let all = evidence.value("scenes of `collision`")?;
    let greatest = evidence.value("greatest ratio in a scene of `collision`")?;
    let (theirs, most) = (
        span(&evidence.values("least ratio, Baraff-Witkin, ")?).0,
        span(&evidence.values("greatest ratio, Baraff-Witkin, ")?).1,
    );
    Ok(vec![
        Reading::new(
            "In some scene of the study `collision` the paper's system takes twice as many.",
            many > 0.0,
            format!("in {many} of {all} pairs of runs, {} times at most", told(greatest)),
        ),
        Reading::new(
            "In Baraff and Witkin's own step it takes twice as many.",
            theirs >= LIMIT,
            format!("{} to {} times", told(theirs), told(most)),
        ),
    ])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn every_run_of_the_papers_system_must_show_the_increase() {
        let verdict = |least| {
            let numbers = [
                ("least ratio, IMEX Euler, plain, 2 m/s", least),
                ("greatest ratio, IMEX Euler, plain, 2 m/s", 5.0),
                ("least ratio, Baraff-Witkin, 2 m/s", 1.0),
                ("greatest ratio, Baraff-Witkin, 2 m/s", 1.0),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(2.0), Ruling::Holds);
        assert_eq!(verdict(1.9), Ruling::Fails);
    }
}
