//! C12: stable under all circumstances and with all feasible parameters.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading};

pub(super) const CLAIM: Claim = Claim {
    id: "C12",
    origin: Origin::Paper { section: "4" },
    says: "stable under all circumstances and with all feasible parameters",
    criterion: "No energy growth with the paper's own predictor and updates, over the stability \
                atlas and the hard cases. The paper prints no ε for it; we take 0.05 and 0.1.",
    reads: &[
        "runs that are not stable, updated CG as printed, ",
        "runs, updated CG as printed, ",
        "runs that gain more than half of the energy set free, updated CG as printed, ",
        "runs that are not stable, no updates, ",
        "runs that are not stable, updated CG, safeguarded",
        "runs, updated CG, safeguarded",
        "runs, no updates, ",
        "runs over budget, no updates, ",
    ],
    overturned_by: "It is confirmed if every run of the method as printed is stable.",
    see: "hard-cases.svg",
    age: Age::SETTLED,
    judge,
    readings,
};

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let sum = |prefix: &str| Ok(evidence.values(prefix)?.iter().sum::<f64>());
    let failing = sum("runs that are not stable, updated CG as printed, ")?;
    let runs = sum("runs, updated CG as printed, ")?;
    let what = "runs that gain more than half of the energy set free, updated CG as printed, ";
    let gross = sum(what)?;
    let plain = evidence.value("runs that are not stable, no updates, ε = 0.05")?;
    let what = "runs that are not stable, no updates, solved to 1e-10 from v_n, hard cases";
    let exact = evidence.value(what)?;
    let safe = evidence.value("runs that are not stable, updated CG, safeguarded")?;
    let safe_runs = evidence.value("runs, updated CG, safeguarded")?;
    let reason = format!(
        "As printed, {failing} of {runs} runs are not stable, and {gross} gain more than half of \
         the energy set free. A loose ε accepts the predictor unchanged, which then feeds on \
         itself; without updates {plain} runs fail."
    );
    let repair = format!(
        "Without updates, solved to 1e-10 from v_n, {exact} hard cases fail; of the safeguarded \
         updates {safe} of {safe_runs} runs fail."
    );
    let is_met = failing == 0.0;
    Ok(Judgement::new(is_met, reason).repaired((!is_met).then_some(repair)))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let reading = |asks: &'static str, form: &str| -> Result<Reading, Missing> {
        let of = |what: &str| evidence.value(&format!("{what}, {form}"));
        let (failing, runs) = (of("runs that are not stable")?, of("runs")?);
        let over = of("runs over budget")?;
        let seen = format!("{failing} of {runs} runs gain energy, {over} end over budget");
        Ok(Reading::new(asks, failing == 0.0, seen))
    };
    Ok(vec![
        reading("Without updates, at ε = 0.05.", "no updates, ε = 0.05")?,
        reading(
            "Without updates, solved to 1e-10 from v_n, on the hard cases.",
            "no updates, solved to 1e-10 from v_n, hard cases",
        )?,
    ])
}

#[cfg(test)]
mod tests {
    use super::super::{Number, Ruling};
    use super::*;

    #[test]
    fn one_unstable_run_of_the_printed_form_refutes_whatever_the_others_do() {
        let unstable = "runs that are not stable";
        let gross = "runs that gain more than half of the energy set free";
        let [loose, tight] =
            ["0.1", "0.05"].map(|term| format!("updated CG as printed, ε = {term}"));
        let verdict = |printed: [f64; 2], others: f64| {
            let mut numbers = Vec::new();
            for (form, failing) in [
                (loose.as_str(), printed[0]),
                (&tight, printed[1]),
                ("no updates, ε = 0.05", others),
                ("no updates, solved to 1e-10 from v_n, hard cases", others),
                ("updated CG, safeguarded", others),
            ] {
                numbers.push(Number::new(format!("{unstable}, {form}"), failing, ""));
                numbers.push(Number::new(format!("{gross}, {form}"), 0.0, ""));
                numbers.push(Number::new(format!("runs, {form}"), 9.0, ""));
            }
            CLAIM.judge(&Evidence::new(&numbers)).verdict
        };
        assert_eq!(verdict([0.0, 0.0], 3.0), Ruling::Holds);
        assert_eq!(verdict([0.0, 1.0], 0.0), Ruling::Fails);
    }
}
