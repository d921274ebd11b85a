//! C08: the matrix is diagonally dominant only through the identity.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, sole, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C08",
    origin: Origin::Paper { section: "3" },
    says: "the matrix is diagonally dominant only through the identity",
    criterion: "margin of every row = m_i exactly; margin over diagonal → 0 as h²k/m grows",
    reads: &[
        "rows whose margin is not m_i to the last bit",
        "rows",
        "greatest margin over diagonal, h²k/m = ",
    ],
    overturned_by: "A row whose margin is not its mass, or a relative margin that stays, refutes \
                    it.",
    see: "cg-vs-theta.svg",
    age: Age::FIRST,
    judge,
    readings: sole,
};

/// A relative margin below this has vanished.
const GONE: f64 = 1e-6;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let differing = evidence.value("rows whose margin is not m_i to the last bit")?;
    let rows = evidence.value("rows")?;
    let margins = evidence.values("greatest margin over diagonal, h²k/m = ")?;
    let falls = margins.windows(2).all(|pair| pair[1] < pair[0]);
    let last = margins.last().copied().unwrap_or(f64::INFINITY);
    let reason = format!(
        "In {} of {rows} rows the diagonal exceeds the other entries by the mass, to the last bit. \
         Over the diagonal this margin falls to {}: the springs add nothing to it.",
        rows - differing,
        told(last)
    );
    Ok(Judgement::new(differing == 0.0 && falls && last < GONE, reason))
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn one_row_that_differs_or_a_margin_that_stays_refutes() {
        let verdict = |differing, first, last| {
            let numbers = [
                ("rows whose margin is not m_i to the last bit", differing),
                ("rows", 9.0),
                ("greatest margin over diagonal, h²k/m = 1", first),
                ("greatest margin over diagonal, h²k/m = 100000000", last),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(0.0, 0.5, 1e-8), Ruling::Holds);
        assert_eq!(verdict(1.0, 0.5, 1e-8), Ruling::Fails);
        assert_eq!(verdict(0.0, 0.5, 0.4), Ruling::Fails);
        assert_eq!(verdict(0.0, 1e-9, 1e-8), Ruling::Fails);
    }
}
