//! The step against its recurrences and laws, alone and in contact.

use crate::{GeneralizedAlpha, GeneralizedAlphaSettings};
use drape_integrator::{Integrator, SolveStatus};
use drape_model::{DampingLaw, Vec3};
use drape_oracle::checks::{self, Known, contact};
use drape_oracle::laws::{Drift, spin};
use drape_oracle::recurrence;
use drape_oracle::scenes::{Sheet, build, particles, stir, tension};
use drape_oracle::{Run, apart};
use nalgebra::Vector3;

/// Family and `rho_inf`.
const ALL: [(&str, &str); 6] = [
    ("chung-hulbert", "0.5"),
    ("chung-hulbert", "0"),
    ("chung-hulbert", "0.8"),
    ("chung-hulbert", "1"),
    ("hht", "0.8"),
    ("newmark", "1"),
];

fn exact_of((family, rho): (&str, &str)) -> recurrence::GeneralizedAlpha {
    let rho: f64 = rho.parse().expect("a number");
    match family {
        "hht" => recurrence::GeneralizedAlpha::hht((1.0 - rho) / (1.0 + rho)),
        "newmark" => recurrence::GeneralizedAlpha::newmark(rho),
        _ => recurrence::GeneralizedAlpha::chung_hulbert(rho),
    }
}

fn with((family, rho): (&str, &str), more: &[(&str, &str)]) -> Box<dyn Integrator> {
    let pairs = more.iter().copied().chain([("family", family), ("rho_inf", rho)]);
    let settings = GeneralizedAlphaSettings::from_pairs(pairs).expect("in range");
    Box::new(GeneralizedAlpha::new(settings))
}

fn tight(member: (&str, &str)) -> Box<dyn Integrator> {
    with(member, &[("residual", "1e-16"), ("solver", "cholesky")])
}

#[test]
fn a_spring_without_length_moves_by_the_recurrence_at_any_step_sizes() {
    let h = checks::H;
    for (member, (theta, eta)) in ALL.into_iter().flat_map(|m| checks::PARAMETERS.map(|p| (m, p))) {
        let mut run = Run::new(tight(member), checks::oscillator(theta, eta), h);
        // (x, hv, h²a) with h of the first step, each rescaled for its own.
        let mut exact = [0, 1, 2].map(|k| {
            let (x, w) = (run.state.x[1][k], run.state.v[1][k] * h);
            recurrence::GeneralizedAlpha::start(x, w, theta, eta)
        });
        for step in 0..100 {
            let r = checks::SIZES[step % checks::SIZES.len()];
            run.step_by(r * h);
            for (axis, y) in exact.iter_mut().enumerate() {
                let matrix = exact_of(member).matrix(theta * r * r, eta * r);
                let scaled = Vector3::new(y.x, y.y * r, y.z * r * r);
                let next = matrix * scaled;
                let found = [run.state.x[1][axis], run.state.v[1][axis] * r * h];
                let error = (found[0] - next.x).hypot(found[1] - next.y);
                let error = error / next.norm().max(scaled.norm());
                let case = format!("{member:?}, θ={theta} η={eta}, step {step}");
                assert!(error < 1e-9, "{case}: {error:e}");
                *y = Vector3::new(next.x, next.y / r, next.z / (r * r));
            }
        }
    }
}

/// Numbers of an independent implementation: spin and angle after 1 s at h = 0.01 for θ = 1 and
/// θ = 100, and energy for θ = 100.
#[test]
fn a_stiff_pair_turns_as_an_independent_implementation_says() {
    #[rustfmt::skip]
    let table = [
        ("1", [1.000_000_000_2, 1.999_933_34], [1.000_000_000_0, 1.999_933_34], 1.000_000_00),
        ("0.8", [0.999_997_509_7, 1.999_925_93], [0.999_997_509_4, 1.999_925_92], 0.999_995_02),
        ("0.5", [0.999_977_200_6, 1.999_866_47], [0.999_977_199_6, 1.999_866_41], 0.999_954_40),
        ("0", [0.999_784_954_2, 1.999_327_94], [0.999_784_954_4, 1.999_327_44], 0.999_569_96),
    ];
    for (rho, soft, stiff, energy) in table {
        for (theta, [spin, angle]) in [(1.0, soft), (100.0, stiff)] {
            let found = checks::turn(tight(("chung-hulbert", rho)), theta);
            assert!((found.spin - spin).abs() < 2e-9, "{rho}, θ={theta}: {found:?}");
            assert!((found.angle - angle).abs() < 1e-8, "{rho}, θ={theta}: {found:?}");
            assert!(theta < 2.0 || (found.energy - energy).abs() < 1e-8, "{rho}: {found:?}");
        }
    }
}

/// `(1 + ¼θ (1 − ℓ/L)) d × v` never drifts, whatever the spring does; damping takes its share.
#[test]
fn newmarks_trapezoid_obeys_its_law_of_spin() {
    let h = checks::H;
    for (theta, eta) in [(10.0, 0.0), (10.0, 0.125), (1e4, 0.0)] {
        let (k, c) = checks::coefficients(0.5 * theta, 0.5 * eta, h);
        let (x, v) = ([Vec3::zeros(), Vec3::new(0.6, 0.0, 0.0)], [Vec3::y(), -Vec3::y()]);
        let mut spec = particles(&[0.25; 2], &x, &v);
        spec.springs = vec![tension((0, 1), 0.5, k, c)];
        let mut run = Run::new(tight(("newmark", "1")), build(&spec), h);
        let ratio = |run: &Run| 0.5 / checks::pair(&run.state).0.norm();
        let turn = |run: &Run| {
            let (d, v) = checks::pair(&run.state);
            d.cross(&v).z
        };
        for step in 0..100 {
            let (before, old) = (turn(&run), ratio(&run));
            run.step();
            let factor = spin::trapezoid(theta, eta, old, ratio(&run));
            let wrong = (turn(&run) - factor * before).abs() / before.abs();
            assert!(wrong < 1e-8, "θ={theta} η={eta}, step {step}: {wrong:e}");
        }
    }
}

#[test]
fn a_free_sheet_falls_on_the_exact_parabola() {
    for member in ALL {
        checks::falls_freely(member, with(member, &[]), Drift::MeanVelocity, 1e-11);
    }
}

#[test]
fn every_member_has_its_order_with_both_laws_of_damping() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let known = Known::new(stir(Sheet::smooth(law).build(), 0.02, 0.3), 0.25);
        for member in ALL.into_iter().chain([("newmark", "0.5")]) {
            let order = if member == ("newmark", "0.5") { 1.0 } else { 2.0 };
            let found = known.order(|| with(member, &[]), &[40, 80, 160]);
            assert!((found.order - order).abs() < 0.15, "{member:?}, {law:?}: {found:?}");
        }
    }
}

/// One linear solve a step keeps order 2: Newton starts within `O(h²)` and squares that.
#[test]
fn one_newton_iteration_keeps_order_two() {
    let known = Known::new(stir(Sheet::smooth(DampingLaw::Full).build(), 0.02, 0.3), 0.25);
    let one = [("max_iterations", "1"), ("solver", "cg"), ("cg_tolerance", "0.01")];
    for cheap in [&one[..1], &one] {
        let found = known.order(|| with(ALL[0], cheap), &[20, 40, 80, 160]);
        assert!((found.order - 2.0).abs() < 0.2, "{cheap:?}: {found:?}");
    }
}

/// A factor keeps it to round-off. Conjugate gradients, the default, leave a residual, whose sum is
/// momentum: they keep it to their tolerance.
#[test]
fn momentum_of_a_free_sheet_is_kept() {
    for member in ALL {
        let free = Sheet { tension: 1e6, shear: 1e5, ..Sheet::free() };
        let start = stir(free.build(), 0.0, 0.3);
        for (settings, most) in [(&[("solver", "cholesky")][..], 1e-13), (&[], 1e-9)] {
            let drift = checks::momentum_drift(with(member, settings), start.clone(), 1e-3);
            assert!(drift < most, "{member:?}, {settings:?}: {drift:e}");
        }
    }
}

#[test]
fn a_dropped_particle_comes_to_rest_and_an_elastic_one_returns_to_its_height() {
    for member in ALL {
        contact::bounces_or_rests(member, || with(member, &[]), &[0.0, 0.5, 1.0]);
    }
}

/// A rubbing particle moves with `(h − τ_x) v_n + τ_x v_{n+1}`, which has order 1.
#[test]
fn friction_is_coulombs() {
    for member in ALL {
        contact::friction_is_coulombs(member, || with(member, &[]), 0.51, 3e-3);
    }
}

#[test]
fn an_impact_with_friction_takes_its_share_once() {
    for member in ALL {
        contact::impact_takes_its_share_once(member, with(member, &[]));
    }
}

#[test]
fn led_pins_are_on_their_paths_and_a_rising_floor_lifts() {
    for member in ALL {
        contact::paths_lead(member, || with(member, &[]));
    }
}

/// What the last step knows of its forces does not outlive a change of the system.
#[test]
fn a_change_of_the_system_is_seen_at_once() {
    for member in ALL {
        let [kept, fresh] = checks::after_a_change(|| tight(member), 0.004);
        let off = apart(&kept.state.x, &fresh.state.x);
        assert!(off < 1e-12, "{member:?}: {off:e}");
    }
}

#[test]
fn an_unfinished_solve_is_reported() {
    let start = stir(Sheet { tension: 1e6, ..Sheet::default() }.build(), 0.1, 3.0);
    let mut run = Run::new(with(ALL[0], &[("max_iterations", "1")]), start, 0.05);
    assert_eq!(run.step().solve, SolveStatus::IterationLimit);
}
