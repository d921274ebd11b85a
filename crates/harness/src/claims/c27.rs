//! C27: the differential equation is solved completely.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C27",
    origin: Origin::Paper { section: "9" },
    says: "the differential equation is solved completely",
    criterion: "Some form of the method has the observed order 1 against the reference, at \
                feasible h, in every scene.",
    reads: &[
        "order, ",
        "error at h = 0.00125 s, plain, ε = 1e-10, ",
        "CG iterations a step at most, updated, ε = 1e-8, ",
    ],
    overturned_by: "It is refuted if no form has order 1 in every scene.",
    see: "order-stiff.svg",
    age: Age::changed("35329f5", "says that one form is enough; the verdict is the same"),
    judge,
    readings,
};

/// Greatest accepted distance of the order from 1.
const ACCEPTED: f64 = 0.15;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let forms = evidence.series("order, ", ", k/m = ")?;
    let converges = |order: &f64| (order - 1.0).abs() <= ACCEPTED;
    let good = |orders: &[f64]| orders.iter().filter(|order| converges(order)).count();
    let is_met = forms.iter().any(|(_, orders)| good(orders) == orders.len());
    let list =
        |(form, orders): &(&str, Vec<f64>)| format!("{form}: {} of {}", good(orders), orders.len());
    let list: Vec<_> = forms.iter().map(list).collect();
    let (_, dearest) = span(&evidence.values("CG iterations a step at most, updated, ε = 1e-8, ")?);
    let (_, plain) = span(&evidence.values("error at h = 0.00125 s, plain, ε = 1e-10, ")?);
    let reason = format!(
        "Scenes with order 1 ± {ACCEPTED}: {}. Algorithm 1 takes up to {} CG iterations a step for \
         that; without updates the error is still {} of the motion at the finest step.",
        list.join("; "),
        told(dearest.round()),
        told(plain)
    );
    Ok(Judgement::new(is_met, reason))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let forms = evidence.series("order, ", ", k/m = ")?;
    let reading = |asks: &'static str, form: &str| {
        let orders = forms.iter().filter(|(of, _)| *of == form).flat_map(|(_, orders)| orders);
        let orders: Vec<_> = orders.copied().collect();
        let is_met = orders.iter().all(|order| (order - 1.0).abs() <= ACCEPTED);
        let (low, high) = span(&orders);
        Reading::new(asks, is_met, format!("orders from {} to {}", told(low), told(high)))
    };
    Ok(vec![
        reading("Algorithm 1 at ε = 0.05.", "updated, ε = 0.05"),
        reading("Algorithm 1 at ε = 1e-8.", "updated, ε = 1e-8"),
        reading("The plain iteration, solved to 1e-10.", "plain, ε = 1e-10"),
    ])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn one_form_must_converge_in_every_scene() {
        let verdict = |plain: f64, updated: f64| {
            let numbers = [
                ("order, plain, ε = 1e-10, k/m = 1e4", 1.0),
                ("order, plain, ε = 1e-10, k/m = 1e6", plain),
                ("order, updated, ε = 1e-8, k/m = 1e4", 1.0),
                ("order, updated, ε = 1e-8, k/m = 1e6", updated),
                ("error at h = 0.00125 s, plain, ε = 1e-10, k/m = 1e4", 0.1),
                ("CG iterations a step at most, updated, ε = 1e-8, k/m = 1e4", 9.0),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(0.1, 0.9), Ruling::Holds);
        assert_eq!(verdict(1.2, 0.8), Ruling::Fails);
    }
}
