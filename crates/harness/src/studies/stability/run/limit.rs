//! Search for the longest stable step by bisection.

use super::DAMPINGS;
use super::sheet::{SEEDS, Setting, run as run_sheet, schedule};
use super::theory::{largest_eigenvalue, longest};
use crate::HarnessError;
use crate::methods::runs::Variant;
use crate::methods::{Choice, is_added};
use crate::run::{Runner, Simulation};
use crate::studies::sheet::MASS;
use crate::studies::stability::facts::Limit;
use crate::studies::variant::is_explicit;
use crate::theory::{self as known, Limit as ClosedForm};
use drape_model::{SpringEffect, Vec3};
use drape_oracle::scenes::{particles, spring};
use drape_report::Verdict;
use std::sync::Arc;

/// Stiffness over mass of the tension springs, 1/s².
const STIFFNESS: f64 = 1e4;
/// Shortest and longest step, s.
const PAIR_RANGE: [f64; 2] = [1.0 / 4096.0, 8.0];
const SHEET_RANGE: [f64; 2] = [1.0 / 16384.0, 1.0];
/// Width of the last interval in powers of two: 5 %.
const WIDTH: f64 = 0.07;
/// Growth of the energy from the first to the last quarter above which a run has failed.
const VISIBLE: f64 = 1.02;
/// Number of the sheet's eigenvalues that theory tries, and the least over the largest.
const MODES: i32 = 64;
const LEAST_MODE: f64 = 1e-4;
/// Effort after which a run on the sheet is over budget, in visits of a spring.
const BUDGET: f64 = 1e9;

/// A method without a closed form on the pair: a limit of elongation means nothing at rest length
/// 0.
const NOT_ON_PAIR: &str = "provot";
/// Shares of the Laplacian that a sheet's stiffness may have in a mode, while its full damping has
/// all of it.
const SHARES: [f64; 5] = [1.0, 0.75, 0.5, 0.25, 0.0];

/// A method on a scene.
pub(super) struct Case {
    variant: Variant,
    scene: Scene,
    damping: f64,
}

#[derive(Clone)]
enum Scene {
    Pair,
    Sheet(Arc<Setting>),
}

/// All cases.
pub(super) fn cases(variants: &[Variant], is_quick: bool) -> Result<Vec<Case>, HarnessError> {
    let mut cases = Vec::new();
    for damping in DAMPINGS {
        // The page compares the pair's limits with theory, and an added method has none.
        let on_pair = variants
            .iter()
            .filter(|variant| variant.label != NOT_ON_PAIR && !is_added(variant.label));
        cases.extend(on_pair.map(|&variant| Case { variant, scene: Scene::Pair, damping }));
        if is_quick {
            continue;
        }
        let setting = Arc::new(Setting::new(STIFFNESS, damping)?);
        for &variant in variants {
            let choice = Choice::parse(variant.method, &[])?;
            if is_explicit(choice.method()) {
                cases.push(Case { variant, scene: Scene::Sheet(Arc::clone(&setting)), damping });
            }
        }
    }
    Ok(cases)
}

/// Two particles at rest, 1 m apart, on a spring of rest length 0.
fn pair(damping: f64) -> Result<Simulation, HarnessError> {
    let x = [Vec3::new(-0.5, 0.0, 0.0), Vec3::new(0.5, 0.0, 0.0)];
    let mut spec = particles(&[MASS; 2], &x, &[Vec3::zeros(); 2]);
    let (k, c) = (STIFFNESS * MASS, damping * MASS);
    spec.springs = vec![spring(SpringEffect::Tension, (0, 1), 0.0, k, c)];
    let (system, state) = spec.build()?;
    Ok(Simulation { system, state })
}

/// Whether the energy of the last quarter exceeds that of the first by at most [`VISIBLE`].
fn keeps_pair(start: &Simulation, choice: &Choice, h: f64) -> Result<bool, HarnessError> {
    let schedule = schedule(h);
    let steps = schedule.steps();
    let (mut first, mut last) = (0.0_f64, 0.0_f64);
    let runner = Runner::by(choice, &schedule).observe(|moment| {
        let energy = moment.system.total_energy(moment.state);
        let energy = if energy.is_nan() { f64::INFINITY } else { energy };
        if 4 * moment.step <= steps {
            first = first.max(energy);
        } else if 4 * moment.step >= 3 * steps {
            last = last.max(energy);
        }
    });
    let outcome = runner.go(&mut start.clone())?;
    Ok(outcome.divergence.is_none() && last <= VISIBLE * first)
}

fn keeps_sheet(setting: &Setting, choice: &Choice, h: f64) -> Result<bool, HarnessError> {
    let (counts, _) = run_sheet(&setting.start(SEEDS[0]), choice, &schedule(h), Some(BUDGET))?;
    Ok(counts.verdict(setting.released) == Verdict::Stable && !counts.outcome.is_over_budget)
}

/// Result of a search.
struct Found {
    longest: Option<f64>,
    is_unlimited: bool,
    runs: u32,
}

/// Doubles the step from the shortest until a run fails, then bisects the interval on a logarithmic
/// scale.
fn search(
    range: [f64; 2],
    mut keeps: impl FnMut(f64) -> Result<bool, HarnessError>,
) -> Result<Found, HarnessError> {
    let mut runs = 0;
    let mut try_step = |h: f64| {
        runs += 1;
        keeps(h)
    };
    let (mut good, mut bad) = (None, range[0]);
    while try_step(bad)? {
        good = Some(bad);
        if bad >= range[1] {
            return Ok(Found { longest: good, is_unlimited: true, runs });
        }
        bad *= 2.0;
    }
    if let Some(good) = &mut good {
        while (bad / *good).log2() > WIDTH {
            let middle = (*good * bad).sqrt();
            if try_step(middle)? { *good = middle } else { bad = middle }
        }
    }
    Ok(Found { longest: good, is_unlimited: false, runs })
}

pub(super) fn run(case: &Case) -> Result<Limit, HarnessError> {
    let Case { variant, scene, damping } = case;
    let choice = Choice::parse(variant.method, &[])?;
    let theory = known::form_of(variant.label).and_then(|form| form.limit);
    let (name, range, eigenvalue, found) = match scene {
        Scene::Pair => {
            let start = pair(*damping)?;
            let found = search(PAIR_RANGE, |h| keeps_pair(&start, &choice, h))?;
            ("pair", PAIR_RANGE, 2.0 * STIFFNESS, found)
        }
        Scene::Sheet(setting) => {
            let Simulation { system, state } = &setting.simulation;
            let found = search(SHEET_RANGE, |h| keeps_sheet(setting, &choice, h))?;
            ("sheet", SHEET_RANGE, largest_eigenvalue(system, &state.x), found)
        }
    };
    let is_pair = name == "pair";
    let brake = damping / STIFFNESS;
    let closed_form = |theory: ClosedForm| {
        // Shear and tension springs have damping in proportion to stiffness. Undamped, the shares
        // of the largest eigenvalue cover modes of any stiffness.
        let modes = if is_pair { 1 } else { MODES };
        let shares = if is_pair || brake == 0.0 { &SHARES[..1] } else { &SHARES[..] };
        longest(range, |h| {
            (0..modes).all(|n| {
                let share = libm::pow(LEAST_MODE, f64::from(n) / f64::from(MODES - 1));
                let (stiffness, damping) = (share * eigenvalue, share * eigenvalue * brake);
                shares.iter().all(|part| theory.is_stable(h, part * stiffness, damping))
            })
        })
    };
    let visible = |theory: ClosedForm| {
        let steps = |h: f64| 0.75 * schedule(h).steps() as f64;
        longest(range, |h| theory.growth(h, eigenvalue, eigenvalue * brake, steps(h)) <= VISIBLE)
    };
    Ok(Limit {
        scene: name.to_owned(),
        label: variant.label.to_owned(),
        method: choice.full_id(),
        stiffness_over_mass_per_s2: STIFFNESS,
        damping_over_mass_per_s: *damping,
        largest_eigenvalue_per_s2: eigenvalue,
        rule: theory.map_or("none", |theory| theory.rule).to_owned(),
        theory_s: theory.and_then(closed_form),
        visible_s: theory.filter(|_| is_pair).and_then(visible),
        measured_s: found.longest,
        is_unlimited: found.is_unlimited,
        range_s: range,
        runs: found.runs,
        portable: choice.is_portable(),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    fn limit(label: &'static str, damping: f64) -> Limit {
        run(&Case { variant: Variant::new(label, label), scene: Scene::Pair, damping }).unwrap()
    }

    /// The measured limits agree with `θ < 4`, `θ + 2η < 4` and `θ ≤ η` within the width of the
    /// search.
    #[test]
    fn limits_of_the_pair_are_those_of_theory() {
        for (label, damping) in
            [("leapfrog", 0.0), ("symplectic-euler", 40.0), ("explicit-euler", 40.0)]
        {
            let limit = limit(label, damping);
            let (measured, theory) = (limit.measured_s.unwrap(), limit.theory_s.unwrap());
            assert!((0.94..=1.01).contains(&(measured / theory)), "{label}: {measured} {theory}");
        }
    }

    #[test]
    fn an_unconditional_method_is_stable_over_the_range_and_an_unstable_one_nowhere() {
        let limit_of = limit("imex-euler", 0.0);
        assert!(limit_of.is_unlimited && limit_of.theory_s.is_none());
        let limit_of = limit("explicit-euler", 0.0);
        assert_eq!((limit_of.theory_s, limit_of.measured_s), (Some(0.0), None));
    }
}
