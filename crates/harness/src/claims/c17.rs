//! C17: the extrapolated start helps.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C17",
    origin: Origin::Paper { section: "5" },
    says: "the extrapolated start helps",
    criterion: "Every run takes fewer iterations from the extrapolated start, and none gains \
                energy from it alone.",
    reads: &[
        "iterations over those from v_n, ",
        "runs with fewer, ",
        "runs that it alone makes unstable, ",
        "the same from v_n, plain, ε = 0.05",
    ],
    overturned_by: "It is confirmed if every form of the paper takes fewer iterations and stays \
                    stable.",
    see: "cg-vs-forcing-term.svg",
    age: Age::changed("35329f5", "says what equal energy means; the verdict is the same"),
    judge,
    readings,
};

/// The forms of the paper, which decide: two tolerances, plain and updated.
const PAPER: [&str; 4] = [
    "plain, ε = 0.05",
    "plain, ε = 1e-3",
    "updated as printed, ε = 0.05",
    "updated as printed, ε = 1e-3",
];
/// The repair.
const SAFE: &str = "updated from the better start, ε = 0.01";

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let ratio = |form: &str| evidence.value(&format!("iterations over those from v_n, {form}"));
    let broken = |form: &str| evidence.value(&format!("runs that it alone makes unstable, {form}"));
    let (mut runs, mut unstable, mut is_met) = (0.0, 0.0, true);
    for form in PAPER {
        // The limit is the number of runs.
        let fewer = evidence.number(&format!("runs with fewer, {form}"))?;
        let all = fewer.limit.unwrap_or(f64::INFINITY);
        runs += all;
        unstable += broken(form)?;
        is_met &= fewer.value >= all && broken(form)? == 0.0;
    }
    let off = evidence.value("the same from v_n, plain, ε = 0.05")?;
    let [loose, tight, loose_updated, tight_updated] = PAPER.map(ratio);
    let reason = format!(
        "The extrapolated start takes {} times the iterations at ε = 1e-3 (updated: {}) and {} \
         times at 0.05 (updated: {}); it alone makes {unstable} of {runs} runs unstable. At the \
         loose tolerance v_n often passes the test itself, and up to {} of the way is lost.",
        told(tight?),
        told(tight_updated?),
        told(loose?),
        told(loose_updated?),
        told(off)
    );
    let safe = ratio(SAFE)?;
    let repair = format!(
        "Extrapolate only where the potential is lower than at v_n, and measure the residual by \
         the forces: {} times the iterations, no run unstable.",
        told(safe)
    );
    let helps = !is_met && broken(SAFE)? == 0.0 && safe < 1.0;
    Ok(Judgement::new(is_met, reason).repaired(helps.then_some(repair)))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let reading = |asks: &'static str, forms: [&str; 2]| -> Result<Reading, Missing> {
        let (mut is_met, mut seen) = (true, Vec::new());
        for form in forms {
            let fewer = evidence.number(&format!("runs with fewer, {form}"))?;
            let broken = evidence.value(&format!("runs that it alone makes unstable, {form}"))?;
            is_met &= fewer.limit.is_some_and(|all| fewer.value >= all) && broken == 0.0;
            let ratio = evidence.value(&format!("iterations over those from v_n, {form}"))?;
            seen.push(told(ratio));
        }
        let seen = format!("{} times the iterations, updated {}", seen[0], seen[1]);
        Ok(Reading::new(asks, is_met, seen))
    };
    Ok(vec![
        reading("At ε = 1e-3.", [PAPER[1], PAPER[3]])?,
        reading("At ε = 0.05.", [PAPER[0], PAPER[2]])?,
    ])
}

#[cfg(test)]
mod tests {
    use super::super::{Number, Ruling};
    use super::*;

    #[test]
    fn every_form_of_the_paper_must_gain_and_lose_nothing() {
        let verdict = |changed: &str, fewer: f64, broken: f64| {
            let mut numbers = vec![Number::new("the same from v_n, plain, ε = 0.05", 0.1, "")];
            for form in PAPER.into_iter().chain([SAFE]) {
                let (fewer, broken) = if form == changed { (fewer, broken) } else { (6.0, 0.0) };
                let of = |what: &str, value| Number::new(format!("{what}, {form}"), value, "");
                numbers.push(of("iterations over those from v_n", 0.5));
                numbers.push(of("runs with fewer", fewer).against(6.0));
                numbers.push(of("runs that it alone makes unstable", broken));
            }
            CLAIM.judge(&Evidence::new(&numbers)).verdict
        };
        assert_eq!(verdict("", 0.0, 0.0), Ruling::Holds);
        assert_eq!(verdict(PAPER[1], 5.0, 0.0), Ruling::Fails);
        assert_eq!(verdict(PAPER[2], 6.0, 1.0), Ruling::Fails);
        assert_eq!(verdict(SAFE, 6.0, 1.0), Ruling::Holds);
    }
}
