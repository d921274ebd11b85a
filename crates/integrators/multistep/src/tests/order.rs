//! The error falls with the `k`-th power of the step size.

use super::{STEPS, adams, bdf_to, build, tetrahedron};
use crate::Steps;
use drape_integrator::Integrator;
use drape_model::DampingLaw;
use drape_oracle::order::{ObservedOrder, of_method};
use drape_oracle::reference::{ReferenceSettings, reference};

const SPAN: f64 = 0.5;

fn observed(
    family: impl Fn(Steps) -> Box<dyn Integrator>,
    law: DampingLaw,
    steps: Steps,
    runs: &[u32],
) -> ObservedOrder {
    let (system, start) = build(&tetrahedron(law));
    let exact = reference(&system, &start, &[SPAN], ReferenceSettings::default()).expect("smooth");
    assert!(exact.position_error < 1e-10, "{:e}", exact.position_error);
    of_method(|| family(steps), &system, &start, &exact, runs).expect("an order")
}

#[test]
fn the_order_is_the_number_of_steps_with_both_laws_of_damping() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        for steps in STEPS {
            let k = steps.count();
            let found = [
                observed(adams, law, steps, &[80, 160, 320, 640]),
                observed(bdf_to(1e-10), law, steps, &[80, 160, 320, 640]),
            ];
            for (name, found) in ["Adams-Bashforth", "BDF"].iter().zip(found) {
                assert!(
                    (found.order - k as f64).abs() < 0.15,
                    "{name}, k = {k}, {law:?}: {found:?}"
                );
            }
        }
    }
}
