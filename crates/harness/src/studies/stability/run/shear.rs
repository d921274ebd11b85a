//! How stiff explicit shear springs may be beside implicit tension springs: `θ_E < 4 + θ_I`.

use super::atlas::full_verdict;
use super::sheet::{SEEDS, Setting, run as run_sheet, schedule};
use super::theory::{Beside, outweighs};
use crate::HarnessError;
use crate::methods::runs::Variant;
use crate::methods::{Choice, is_chosen};
use crate::studies::finite;
use crate::studies::stability::facts::{Ratio, Shear};

const STIFFNESS: f64 = 1e6;
const STEPS: [f64; 4] = [0.001, 0.01, 0.1, 1.0];
const QUICK_STEP: f64 = 0.1;
const RATIOS: [f64; 16] =
    [1e-4, 1e-3, 0.01, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.5, 2.0, 4.0];
const METHODS: [(Variant, Beside); 2] = [
    (
        Variant::new("imex-euler", "imex-euler:implicit=tension,forcing_term=1e-12"),
        Beside::Laplacian,
    ),
    (
        Variant::new("imex-updated", "imex-updated:implicit=tension,forcing_term=1e-6"),
        Beside::Tangent,
    ),
];
/// Effort after which a run is over budget, in visits of a spring.
const BUDGET: f64 = 1e8;
const BISECTIONS: u32 = 12;

/// A method at a step.
pub(super) struct Case {
    variant: Variant,
    beside: Beside,
    step: f64,
}

pub(super) fn cases(is_quick: bool) -> Vec<Case> {
    let steps = STEPS.into_iter().filter(|step| !is_quick || *step == QUICK_STEP);
    let of = |step| METHODS.map(|(variant, beside)| Case { variant, beside, step });
    let cases = steps.flat_map(of).filter(|case| is_chosen(case.variant.label));
    cases.filter(|case| !is_quick || case.beside == Beside::Laplacian).collect()
}

/// Least ratio at which explicit shear outweighs the implicit springs in some mode. `None` if no
/// ratio of the scan does.
fn bound(h: f64, beside: Beside, is_at_start: bool) -> Result<Option<f64>, HarnessError> {
    let fails = |ratio: f64| -> Result<bool, HarnessError> {
        let Setting { simulation, .. } = Setting::resting(STIFFNESS, 0.0, ratio)?;
        Ok(outweighs(&simulation.system, &simulation.state.x, h, beside, is_at_start))
    };
    let (mut good, mut bad) = (RATIOS[0], RATIOS[RATIOS.len() - 1]);
    if !fails(bad)? {
        return Ok(None);
    }
    while fails(good)? {
        (good, bad) = (0.1 * good, good);
    }
    for _ in 0..BISECTIONS {
        let middle = (good * bad).sqrt();
        if fails(middle)? { bad = middle } else { good = middle }
    }
    Ok(Some(good))
}

pub(super) fn run(case: &Case) -> Result<Shear, HarnessError> {
    let Case { variant, beside, step } = case;
    let choice = Choice::parse(variant.method, &[])?;
    let mut ratios = Vec::new();
    for ratio in RATIOS {
        let setting = Setting::with_shear(STIFFNESS, 0.0, ratio)?;
        let start = setting.start(SEEDS[0]);
        let (counts, _) = run_sheet(&start, &choice, &schedule(*step), Some(BUDGET))?;
        let judged = counts.verdict(setting.released);
        ratios.push(Ratio {
            ratio,
            verdict: full_verdict(judged, None, counts.outcome.is_over_budget),
            gain: finite(counts.energy.gain / setting.released),
        });
    }
    let first = ratios.iter().find(|ratio| ratio.verdict.gains_energy());
    Ok(Shear {
        label: variant.label.to_owned(),
        method: choice.full_id(),
        stiffness_over_mass_per_s2: STIFFNESS,
        step_s: *step,
        bound: bound(*step, *beside, false)?.unwrap_or(RATIOS[RATIOS.len() - 1]),
        start_bound: bound(*step, *beside, true)?,
        first_failure: first.map(|ratio| ratio.ratio),
        ratios,
        portable: choice.is_portable(),
    })
}
