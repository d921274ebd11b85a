//! Experiment `locking`: how much of the motion a stiff cloth keeps at a step that does not resolve
//! its springs.

mod law;
mod motion;
mod spring;
#[cfg(test)]
mod tests;

use super::facts::{BACKWARD_EULER, BASE_STEP, BASE_STIFFNESS};
use crate::HarnessError;
use crate::facts::{Fact, fact};
use crate::methods;
use crate::methods::runs::{Steps, Variant};
use crate::studies::locking::facts::{Facts, Run};
use crate::studies::variant::or_defaults;
use crate::studies::{Context, Measured, Start, prepared, taken};
use motion::{BUDGET, Setting};

/// Values of stiffness over mass, 1/s².
const STIFFNESSES: [f64; 7] = [1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8];
/// Steps, s. Each divides 0.01 s, the distance between positions on a path.
const STEPS: [f64; 7] = [0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001];
/// Steps for methods that factorise several times in a step, s.
const LONG_STEPS: [f64; 4] = [0.01, 0.005, 0.002, 0.001];
/// Stiffness over mass in the quick subset, 1/s².
const QUICK: [f64; 1] = [1e6];

/// Every method in its forms or at its defaults, with its choice of steps at the base stiffness.
fn forms() -> Vec<(Variant, Steps)> {
    let one = |form| (form, Steps::One);
    methods::runs().flat_map(|(method, runs)| or_defaults(method, runs.locking, one)).collect()
}

/// The steps at the base stiffness, s.
fn steps(steps: Steps) -> &'static [f64] {
    match steps {
        Steps::All => &STEPS,
        Steps::Long => &LONG_STEPS,
        Steps::One => &STEPS[..1],
    }
}

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "A sheet of 20 × 20 particles (1 m × 1 m, 1 g each, structural springs, shear springs of \
         a tenth of the stiffness, d/m = 40 s⁻¹, two corners pinned) is let go from the \
         horizontal, for one second. Retained motion R is the path of the free edge's midpoint \
         over the true one, through its positions every 0.01 s. R_fall is its fall over the true \
         fall, at the time when half of the true fall is over. Symplectic Euler at a quarter of \
         its limit, with steps of at most 1e-4 s, computes the true motion; twice that step \
         measures its error. A run is locked if its energy is stable and R < 0.5. A run ends over \
         budget after {BUDGET:e} visits of a spring. Every method runs. Explicit ones run beyond \
         their limits too; motion that they gain there does not count as kept. Solves are tight: \
         ε = 1e-8. Updated CG solves to 1e-4, or takes a number of passes from the last velocity, \
         each solved to 1e-8. The law: IMEX Euler with all springs in the matrix is symplectic \
         Euler with an artificial damping d = hk of every spring, which balances gravity at h L_k \
         v = M g. A single spring, at rest and anchored at one end, is loaded across itself by \
         1e-3 m/s², along x and obliquely. There the angular momentum of IMEX Euler obeys J' = (J \
         + h d × a)/(1 + θ)."
    )
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    STIFFNESSES.map(|k| Start::new(format!("sheet-{k:e}"), move || motion::spec(k))).into()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts>, HarnessError> {
    let stiffnesses: &[f64] = if context.quick { &QUICK } else { &STIFFNESSES };
    let settings = prepared(context, "true motion", stiffnesses, |&k| Setting::new(k))?;
    let forms = forms();
    let mut pairs = Vec::new();
    for setting in &settings {
        for (variant, chosen) in &forms {
            let is_base = setting.stiffness() == BASE_STIFFNESS && !context.quick;
            let steps: &[f64] = if is_base { steps(*chosen) } else { &[BASE_STEP] };
            pairs.extend(steps.iter().map(|&step| (setting, variant, step)));
        }
    }
    let runs =
        taken(context, "methods", &pairs, |&(setting, variant, step)| setting.run(variant, step))?;
    let springs = taken(context, "springs", &spring::cases(), spring::run)?;
    let (mut runs, springs) = (runs.all()?, springs.all()?);
    beside_backward_euler(&mut runs);
    let sheets = settings.iter().map(|setting| setting.sheet.clone()).collect();
    let facts = Facts { sheets, runs, springs };
    let hashes = settings.iter().map(|s| (format!("sheet-{:e}", s.stiffness()), s.hash.clone()));
    let (facts, scenes, seed) = (facts, hashes.collect(), None);
    Ok(Measured { facts, timings: None, scenes, seed })
}

/// Adds the retained motion against backward Euler at the same step.
fn beside_backward_euler(runs: &mut [Run]) {
    let key = |run: &Run| (run.stiffness_over_mass_per_s2, run.step_s);
    let standards: Vec<_> = runs
        .iter()
        .filter(|run| run.label == BACKWARD_EULER)
        .filter_map(|run| Some((key(run), run.path_m?)))
        .collect();
    for run in runs {
        let standard = standards.iter().find(|(other, _)| *other == key(run));
        run.retained_beside_backward_euler =
            run.path_m.zip(standard).map(|(path, (_, standard))| path / standard);
    }
}

/// Retained motion near which a library's round-off may decide whether a run counts as locked.
const EDGE: std::ops::Range<f64> = 0.45..0.55;

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let sheets = facts.sheets.iter();
    let sheets = sheets.map(|sheet| {
        fact(format!("sheet {:e}", sheet.stiffness_over_mass_per_s2), sheet.portable, sheet)
    });
    let runs = facts.runs.iter().map(|run| {
        let key =
            format!("{}, k/m={:e}, h={}", run.label, run.stiffness_over_mass_per_s2, run.step_s);
        let mut fact = fact(key, run.portable, run);
        if let serde_json::Value::Object(values) = &mut fact.values {
            values.remove("retained_beside_backward_euler");
            if !run.portable {
                // The sheet folds. If a library's functions rounded, only the verdict can be
                // repeated.
                values.retain(|_, value| value.is_string());
                if run.retained.is_some_and(|retained| EDGE.contains(&retained)) {
                    values.remove("verdict");
                }
            }
        }
        fact
    });
    let springs = facts.springs.iter().map(|spring| {
        let key = format!("spring {}, {}, θ={}", spring.label, spring.direction, spring.theta);
        fact(key, spring.portable, spring)
    });
    sheets.chain(runs).chain(springs).collect()
}
