//! C28: nothing depends on a regular mesh.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, sole, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C28",
    origin: Origin::Paper { section: "5, 9" },
    says: "nothing depends on a regular mesh",
    criterion: "Triangle meshes and random meshes show the same trends as the grid.",
    reads: &[
        "retained motion, plain, ",
        "iterations a step, no preconditioner, ",
        "IC(0) over no preconditioner, ",
        "retained motion, updated (to k/m = 1e5), ",
        "gain of energy over what is set free, ",
    ],
    overturned_by: "A trend that goes the other way than on the grid, or a gain of energy, refutes \
                    it.",
    see: "claims.svg",
    age: Age::FIRST,
    judge,
    readings: sole,
};

/// Greatest accepted gain of energy over what the scene sets free.
pub(crate) const GAIN: f64 = 0.02;
/// The quantities whose trends are compared.
pub(crate) const QUANTITIES: [&str; 4] = [
    "retained motion, plain",
    "iterations a step, no preconditioner",
    "IC(0) over no preconditioner",
    "retained motion, updated (to k/m = 1e5)",
];
/// A change by less than this factor is no change.
const LEVEL: f64 = 1.15;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let (_, gain) = span(&evidence.values("gain of energy over what is set free, ")?);
    let mut differing = 0;
    let mut last = Vec::new();
    for quantity in QUANTITIES {
        let meshes = evidence.series(&format!("{quantity}, "), ", k/m = ")?;
        differing += meshes.iter().filter(|(_, series)| !agree(series, &meshes[0].1)).count();
        let ends = meshes.iter().filter_map(|(_, series)| series.last().copied());
        last.push(span(&ends.collect::<Vec<_>>()));
    }
    let reason = format!(
        "{differing} trends go the other way than on the grid, and no mesh gains more than {} of \
         the energy set free. At the stiffest the meshes keep {} to {} of the motion without \
         updates.",
        told(gain),
        told(last[0].0),
        told(last[0].1)
    );
    Ok(Judgement::new(differing == 0 && gain <= GAIN, reason))
}

/// −1, 0 or 1 for each pair of neighbours: whether the series falls, stays or rises.
fn trend(series: &[f64]) -> Vec<i8> {
    let sign = |pair: &[f64]| match pair[1] / pair[0] {
        ratio if ratio > LEVEL => 1,
        ratio if ratio < 1.0 / LEVEL => -1,
        _ => 0,
    };
    series.windows(2).map(sign).collect()
}

/// Whether two trends never go opposite ways.
fn agree(a: &[f64], b: &[f64]) -> bool {
    trend(a).iter().zip(trend(b)).all(|(a, b)| a * b >= 0)
}

#[cfg(test)]
mod tests {
    use super::super::{Number, Ruling};
    use super::*;

    #[test]
    fn opposite_trends_differ_and_a_level_stretch_does_not() {
        assert!(agree(&[1.0, 2.0, 3.0], &[1.0, 1.1, 4.0]));
        assert!(!agree(&[1.0, 2.0, 3.0], &[1.0, 2.0, 1.0]));
        let verdict = |last: f64, gain: f64| {
            let mut numbers = vec![
                Number::new("gain of energy over what is set free, grid", 0.0, ""),
                Number::new("gain of energy over what is set free, random", gain, ""),
            ];
            for quantity in QUANTITIES {
                for (mesh, values) in [("grid", [1.0, 2.0, 3.0]), ("random", [2.0, 3.0, last])] {
                    let name = |n| format!("{quantity}, {mesh}, k/m = {n}");
                    let named = values.iter().enumerate();
                    numbers.extend(named.map(|(n, value)| Number::new(name(n), *value, "")));
                }
            }
            CLAIM.judge(&Evidence::new(&numbers)).verdict
        };
        assert_eq!(verdict(4.0, 0.0), Ruling::Holds);
        assert_eq!(verdict(1.0, 0.0), Ruling::Fails);
        assert_eq!(verdict(4.0, 0.1), Ruling::Fails);
    }
}
