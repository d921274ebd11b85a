//! C07: one Jacobi sweep is too little for stiff systems.

use super::{Age, Claim, Evidence, Judgement, Missing, Number, Origin, Reading, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C07",
    origin: Origin::Paper { section: "3" },
    says: "one Jacobi sweep is too little for stiff systems",
    criterion: "At h²k/m ≥ 1 the sweep leaves a residual above 10 %, and its error exceeds that of \
                IMEX Euler.",
    reads: &[
        "residual left, ",
        "error over motion, Kang, ",
        "energy gained over energy set free, Kang, ",
        "mean elongation of the springs, Kang, ",
        "mean elongation of the springs, truth, ",
    ],
    overturned_by: "Sweeps that are less accurate than IMEX Euler in every case confirm it.",
    see: "work-precision.svg",
    age: Age::FIRST,
    judge,
    readings,
};

/// Least share of the right-hand side that the sweep leaves.
pub(crate) const LEFT: f64 = 0.1;
/// Greatest gain of energy of a stable run, over what the scene sets free.
pub(crate) const GAIN: f64 = 0.02;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let (left, _) = span(&evidence.values("residual left, ")?);
    let errors = evidence.rows("error over motion, Kang, ")?;
    // The limit is the error of IMEX Euler.
    let is_worse = |error: &Number| error.limit.is_some_and(|imex| error.value > imex);
    let worse = errors.iter().filter(|(_, error)| is_worse(error)).count();
    let (_, stretched) = span(&evidence.values("mean elongation of the springs, Kang, ")?);
    let (_, truly) = span(&evidence.values("mean elongation of the springs, truth, ")?);
    let reason = format!(
        "The sweep leaves at least {} of the right-hand side, but is less accurate than IMEX \
         Euler, which locks, in only {worse} of {} cases. The sheet sags instead: its springs are \
         up to {} too long on average (truly {}).",
        told(left),
        errors.len(),
        told(stretched),
        told(truly)
    );
    Ok(Judgement::new(left > LEFT && worse == errors.len(), reason))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let (least, most) = span(&evidence.values("residual left, ")?);
    let gains = evidence.values("energy gained over energy set free, Kang, ")?;
    let gaining = gains.iter().filter(|gain| **gain > GAIN).count();
    Ok(vec![
        Reading::new(
            "The residual alone decides: more than 10 % of it is left.",
            least > LEFT,
            format!("{} to {} is left", told(least), told(most)),
        ),
        Reading::new(
            "Stability decides: some run with h²k/m ≥ 1 gains energy.",
            gaining > 0,
            format!("{gaining} of {} runs gain energy", gains.len()),
        ),
    ])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, ruled};
    use super::*;

    #[test]
    fn both_halves_of_the_criterion_must_hold_everywhere() {
        let verdict = |left, kang| {
            let numbers = [
                ("residual left, a", 0.9, LEFT),
                ("residual left, b", left, LEFT),
                ("error over motion, Kang, a", 0.5, 0.1),
                ("error over motion, Kang, b", kang, 0.1),
                ("mean elongation of the springs, Kang, a", 0.1, 0.0),
                ("mean elongation of the springs, truth, a", 0.1, 0.0),
            ];
            ruled(&CLAIM, &numbers)
        };
        assert_eq!(verdict(0.2, 0.2), Ruling::Holds);
        assert_eq!(verdict(0.05, 0.2), Ruling::Fails);
        assert_eq!(verdict(0.2, 0.05), Ruling::Fails);
    }
}
