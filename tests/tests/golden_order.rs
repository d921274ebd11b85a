//! The error of every method falls with the order that theory gives.

use drape_model::DampingLaw;
use drape_oracle::order::of_method;
use drape_oracle::reference::{ReferenceSettings, reference};
use drape_tests::{Sheet, method};

/// `8 (k + k_s)/m ≥ ω_max²`.
const OMEGA_MAX: f64 = 63.3;
const SPAN: f64 = 0.25;

#[test]
fn every_method_is_of_first_order_on_a_smooth_scene() {
    let methods = [
        "explicit-euler",
        "symplectic-euler",
        "symplectic-euler:damping=implicit",
        "backward-euler",
        "imex-euler:forcing_term=1e-10",
        "imex-euler:forcing_term=1e-10,implicit=springs",
        "imex-updated:forcing_term=1e-9",
        "imex-updated:forcing_term=1e-9,safeguard=paper",
    ];
    let sheet = Sheet {
        side: 6,
        tension: 400.0,
        shear: 100.0,
        damping: 2.0,
        law: DampingLaw::Full,
        pinned: true,
    };
    let steps = [40, 80, 160, 320];
    assert!(SPAN / f64::from(steps[0]) * OMEGA_MAX < 0.5);
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let (system, mut start) = Sheet { law, ..sheet }.build();
        // Out of the plane in which springs across are without force.
        for (i, x) in start.x.iter_mut().enumerate() {
            x.z += 0.02 * (i as f64).sin();
        }
        let exact = reference(&system, &start, &[SPAN], ReferenceSettings::default())
            .unwrap_or_else(|error| panic!("{error}"));
        assert!(exact.position_error < 1e-9, "{:e}", exact.position_error);
        for id in methods {
            let found = of_method(|| method(id), &system, &start, &exact, &steps)
                .unwrap_or_else(|error| panic!("{id}: {error}"));
            let constant = found.error_constant(1);
            let summary = format!("{id}, {law:?}: order {:.3}, e = {constant:.3}/s h", found.order);
            assert!((found.order - 1.0).abs() < 0.15, "{summary}: {found:?}");
            assert!((0.1..100.0).contains(&constant), "{summary}");
        }
    }
}
