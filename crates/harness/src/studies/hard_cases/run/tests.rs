//! Theory against known limits, and a part of the experiment itself.

#![allow(clippy::unwrap_used, reason = "tests")]

use super::super::facts::Expected;
use super::explanations::explained;
use super::scenes;
use super::*;
use crate::methods::{self, Choice};
use crate::run::Simulation;
use crate::schedule::Schedule;
use crate::studies::Progress;
use crate::studies::sheet::pair;
use crate::theory::{Problem, expectation};
use drape_integrator::Treatment;
use drape_model::{EffectClass, EffectKind, SpringEffect, TimeSpan};
use drape_report::Verdict;
use std::collections::BTreeSet;
use std::path::Path;

/// What theory says about two free particles of equal mass on a spring, with `θ = 2h²k/m` and
/// `η = 2hc/m`. A shear spring of `θ_E` lies beside it.
fn of_pair(method: &str, theta: f64, eta: f64, theta_explicit: f64) -> Expected {
    let h = 0.01;
    let mut spec = pair(theta / (2.0 * h * h));
    spec.springs[0].damping_n_s_per_m = eta * spec.particles.mass_kg[0] / (2.0 * h);
    if theta_explicit > 0.0 {
        let mut shear = spec.springs[0].clone();
        shear.effect = SpringEffect::Shear;
        shear.stiffness_n_per_m *= theta_explicit / theta;
        spec.springs.push(shear);
    }
    let (system, state) = spec.build().unwrap();
    let simulation = Simulation { system, state };
    let schedule = Schedule::steady(TimeSpan { step_s: h, duration_s: 200.0 * h });
    let choice = Choice::parse(method, &[]).unwrap();
    let (schedule, choice, simulation) = (&schedule, &choice, &simulation);
    expectation(&Problem { schedule, is_at_rest: false, choice, simulation }).kind
}

/// The limit is `θ + 2η < 4`.
#[test]
fn theory_knows_the_limit_of_symplectic_euler() {
    for eta in [0.0, 0.5, 1.5] {
        let limit = 4.0 - 2.0 * eta;
        assert_eq!(
            of_pair("symplectic-euler", 0.98 * limit, eta, 0.0),
            Expected::Stable,
            "η = {eta}"
        );
        let beyond = limit + 0.05;
        assert_eq!(of_pair("symplectic-euler", beyond, eta, 0.0), Expected::Unstable, "η = {eta}");
    }
}

/// The limit is `θ ≤ η` and `η ≤ 2`. An undamped spring is never stable.
#[test]
fn theory_knows_the_limit_of_explicit_euler() {
    assert_eq!(of_pair("explicit-euler", 0.2, 0.0, 0.0), Expected::Unstable);
    assert_eq!(of_pair("explicit-euler", 0.9, 1.0, 0.0), Expected::Stable);
    assert_eq!(of_pair("explicit-euler", 1.5, 1.0, 0.0), Expected::Unstable);
    // The amplitude grows by 1 + θ/2 a step: too slowly to show within 200 steps.
    assert_eq!(of_pair("explicit-euler", 1e-3, 0.0, 0.0), Expected::NoTheorem);
}

/// The limit is `θ_E < 4 + θ_I` with the tension springs in the matrix. With all springs in it, the
/// energy theorem holds.
#[test]
fn theory_knows_the_limit_of_explicit_springs_beside_implicit_ones() {
    const EXACT: &str = "imex-euler:solver=cholesky,implicit=";
    for implicit in [1.0, 100.0] {
        let of = |setting: &str, explicit: f64| {
            of_pair(&format!("{EXACT}{setting}"), implicit, 0.0, explicit)
        };
        assert_eq!(of("tension", 0.98 * (4.0 + implicit)), Expected::Stable);
        assert_eq!(of("tension", 1.05 * (4.0 + implicit)), Expected::Unstable);
        assert_eq!(of("springs", 1.05 * (4.0 + implicit)), Expected::Monotone);
    }
    assert_eq!(of_pair("imex-euler", 1.0, 0.0, 0.0), Expected::NoTheorem, "an inexact solve");
}

/// The limit is `θ < 4` with any damping. The secant method at rest length is leapfrog.
#[test]
fn theory_knows_the_limit_of_leapfrog_and_of_the_secant_method() {
    for eta in [0.0, 1.5] {
        assert_eq!(of_pair("leapfrog", 3.9, eta, 0.0), Expected::Stable, "η = {eta}");
        assert_eq!(
            of_pair("terzopoulos-fleischer", 3.9, eta, 0.0),
            Expected::NoTheorem,
            "η = {eta}"
        );
        for method in ["leapfrog", "terzopoulos-fleischer"] {
            assert_eq!(of_pair(method, 4.1, eta, 0.0), Expected::Unstable, "{method}, η = {eta}");
        }
    }
}

/// Limits of explicit springs beside implicit ones: `θ_E = 4 + θ_I` with their tangents or backward
/// Euler; `(16 + θ_I)/3`, `8 + θ_I/8` and `θ_I` in the two-step methods.
#[test]
fn theory_knows_how_much_explicit_stiffness_a_method_bears() {
    for theta in [10.0, 1e3] {
        for (method, limit) in [
            ("imex-updated", 4.0 + theta),
            ("baraff-witkin", 4.0 + theta),
            ("imex-sbdf2", (16.0 + theta) / 3.0),
            ("imex-mcnab2", 8.0 + theta / 8.0),
            ("imex-cnlf", theta),
        ] {
            let of = |share: f64| {
                of_pair(&format!("{method}:implicit=tension"), theta, 0.0, share * limit)
            };
            assert_eq!(of(0.98), Expected::NoTheorem, "{method} below θ_E = {limit}");
            // The margin is a share of the whole stiffness.
            assert_eq!(of(1.2), Expected::Unstable, "{method} beyond θ_E = {limit}");
        }
    }
}

#[test]
fn an_expectation_admits_what_it_should() {
    for verdict in [Verdict::OverBudget, Verdict::Refused, Verdict::NotApplicable] {
        for kind in [Expected::Monotone, Expected::Stable, Expected::Unstable, Expected::NoTheorem]
        {
            assert!(kind.admits(verdict, 0), "{kind:?} {verdict}");
        }
    }
    for (verdict, admitted) in [
        (Verdict::Stable, [true, true, false, true]),
        (Verdict::Marginal, [false, false, false, true]),
        (Verdict::Unstable, [false, false, true, true]),
        (Verdict::Diverged, [false, false, true, true]),
    ] {
        let kinds = [Expected::Monotone, Expected::Stable, Expected::Unstable, Expected::NoTheorem];
        assert_eq!(kinds.map(|kind| kind.admits(verdict, 0)), admitted, "{verdict}");
    }
    assert!(
        !Expected::Monotone.admits(Verdict::Stable, 1)
            && Expected::Stable.admits(Verdict::Stable, 1)
    );
}

#[test]
fn explanations_name_cases_and_forms_that_exist() {
    let (cases, forms) = (scenes::all(), tweak::forms());
    for (case, method) in explained() {
        assert!(cases.iter().any(|c| c.id == case || c.name() == case), "{case}");
        assert!(forms.iter().any(|form| form.label == method), "{method}");
    }
}

struct Silent;

impl Progress for Silent {
    fn begin(&self, _: &str, _: usize) {}
    fn done(&self) {}
    fn end(&self) {}
}

const UNKNOWN: crate::Source = crate::Source { commit: None, dirty: None };

/// A context that writes no files and draws no figures.
fn quickly(journal: &crate::Journal) -> Context<'_> {
    let (out, source) = (Path::new(""), &UNKNOWN);
    Context { out, quick: true, long: false, progress: &Silent, journal, allocated: None, source }
}

/// Runs every method in every form on a squeezed sheet, explicit shear, a loose tolerance, one
/// heavy particle, a single particle, and pinned particles alone.
#[test]
fn on_small_cases_every_verdict_is_what_theory_says_or_explained() {
    let mut cases = scenes::all();
    let small = ["H16 explicit shear", "H20 ε = 0.1", "H21 one mass × 1e6"];
    cases.retain(|case| case.is_quick || small.contains(&case.name().as_str()));
    assert_eq!(cases.len(), 6);
    let (facts, _) = facts(&quickly(&crate::Journal::none()), &cases).unwrap();
    assert!(facts.unexplained.is_empty(), "{}", facts.unexplained.join("\n"));
    for method in methods::all() {
        assert!(facts.cells.iter().any(|cell| cell.method == method.id), "{} ran", method.id);
    }
    let mut held = 0;
    for cell in &facts.cells {
        let must_hold = ["imex-euler (exact)", "imex-updated", "backward-euler"]
            .contains(&cell.method.as_str())
            && matches!(cell.expected, Expected::Stable | Expected::Monotone);
        if must_hold {
            let name = format!("{}, {}", cell.case, cell.method);
            assert_eq!(cell.verdict, Verdict::Stable, "{name}: gains {} E_ref", cell.gain);
            held += 1;
        }
    }
    assert!(held >= 20, "only {held} cells were held to their theory");
}

/// Runs every method in every form on slivers, and in drag beyond the limit of explicit methods.
#[test]
fn in_wind_and_on_slivers_every_verdict_is_what_theory_says_or_explained() {
    let mut cases = scenes::all();
    cases.retain(|case| {
        ["H14 gust of wind", "H15 sliver triangles"].contains(&case.name().as_str())
    });
    let (facts, _) = facts(&quickly(&crate::Journal::none()), &cases).unwrap();
    assert!(facts.unexplained.is_empty(), "{}", facts.unexplained.join("\n"));
    let (mut unstable, mut divided) = (BTreeSet::new(), BTreeSet::new());
    for cell in facts.cells.iter().filter(|cell| cell.case.starts_with("H14")) {
        let method =
            methods::all().find(|method| cell.method.split(' ').next() == Some(method.id)).unwrap();
        let treatment = method.treatment(EffectKind::Air, EffectClass::Drag);
        let is_explicit = treatment == Treatment::Explicit;
        match cell.verdict {
            Verdict::Refused => {}
            Verdict::Stable if !is_explicit => {}
            _ if !is_explicit => _ = unstable.insert(cell.method.as_str()),
            _ if cell.expected != Expected::Unstable => _ = divided.insert(cell.method.as_str()),
            _ => {}
        }
    }
    // One averages the drag of the old and the new velocity; the other linearises at the old one.
    assert_eq!(unstable.into_iter().collect::<Vec<_>>(), ["generalized-alpha", "rosenbrock"]);
    // Its substeps stay within the limit of the drag.
    assert_eq!(divided.into_iter().collect::<Vec<_>>(), ["xpbd", "xpbd-lines"]);
}
