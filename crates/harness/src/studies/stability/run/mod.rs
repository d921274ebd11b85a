//! Experiment `stability`: which steps, stiffness and damping a method survives.

mod atlas;
mod limit;
mod shear;
mod sheet;
#[cfg(test)]
mod tests;
mod theory;

use crate::HarnessError;
use crate::facts::{Fact, fact};
use crate::studies::stability::facts::{Cell, Facts};
use crate::studies::variant::of_registry;
use crate::studies::{Context, Measured, Start, cells, prepared, taken};
use sheet::{SEEDS, Setting};

/// Steps of the atlas, longest first, s.
const STEPS: [f64; 9] = [1.0, 0.316, 0.1, 0.0316, 0.01, 0.003_16, 0.001, 0.000_316, 0.000_1];
/// Stiffness over mass, 1/s².
const STIFFNESSES: [f64; 7] = [1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8];
/// Damping over mass of the tension springs, 1/s: none, and as in the paper.
const DAMPINGS: [f64; 2] = [0.0, DAMPING];
const DAMPING: f64 = 40.0;
/// Further values of damping at [`BASE_STIFFNESS`], 1/s.
const MORE_DAMPINGS: [f64; 3] = [1.0, 1e3, 1e4];
/// Stiffness over mass at which the damping varies, 1/s².
const BASE_STIFFNESS: f64 = 1e6;

/// Stiffness and damping of the columns of the atlas, and the steps there.
fn columns(quick: bool) -> Vec<(f64, f64, &'static [f64])> {
    if quick {
        // The longest steps suffice: a cell depends only on those of longer steps.
        return vec![(1e4, DAMPING, &STEPS[..4])];
    }
    let pairs = STIFFNESSES.iter().flat_map(|&k| DAMPINGS.map(|d| (k, d)));
    let more = MORE_DAMPINGS.iter().map(|&d| (BASE_STIFFNESS, d));
    pairs.chain(more).map(|(k, d)| (k, d, &STEPS[..])).collect()
}

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "Atlas: a sheet of 8 × 8 particles (1 m × 1 m, 1 g each, structural springs, shear \
         springs of a tenth of the stiffness and damping, two corners pinned) is let go from the \
         horizontal, for at least 2 s and 200 steps. The verdict compares the total energy H with \
         E_ref, the energy that the true motion sets free within 2 s (symplectic Euler at a \
         quarter of its limit). A run is stable if H never rises above its start by more than \
         0.02 E_ref, marginal up to 0.5 E_ref, and unstable above. It has diverged if a position \
         is not finite, or farther away than a thousand scene sizes plus twice the distance that \
         a fall can cover. Without damping, the energy of symplectic methods may oscillate by 0.5 \
         E_ref, but drift by at most 0.05 E_ref. A run is locked if it is stable but its free \
         edge gets less than half as far from its start as in the true motion. Starts are \
         perturbed by up to 1e-4 mesh widths. Where the verdict changes from one step to the \
         next, {} starts run and the worst verdict counts. A run ends over budget after {:e} \
         visits of a spring. If a run with a step of at most {} s does so within the first {} of \
         its time, or a run with a step of at most {} s at all, shorter steps do not run and count \
         as over budget: a map in which every cell ran had no exception. Limits: the step is \
         doubled until a run fails; bisection then finds the limit to 5 %. Pair: two free particles on a spring of rest length 0 with k/m = 10⁴ \
         s⁻², which is a linear system. A step is stable if the energy in the last quarter of the \
         run is at most 1.02 times that in the first. Sheet: as in the atlas; theory takes the \
         largest eigenvalue λ of M⁻¹L_k, which bounds the Hessian at all positions. Explicit \
         shear: undamped, k/m = 10⁶ s⁻², with tension springs in the matrix and explicit shear \
         springs, solved to 1e-12.",
        SEEDS.len(),
        atlas::BUDGET,
        atlas::SHORT,
        atlas::EARLY,
        atlas::VERY_SHORT,
    )
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    let start = |(stiffness, damping, _)| {
        Start::new(sheet::name(stiffness, damping), move || {
            sheet::spec(stiffness, damping, sheet::SHEAR)
        })
    };
    columns(false).into_iter().map(start).collect()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts>, HarnessError> {
    let variants = of_registry(|runs| runs.stability);
    let columns = columns(context.quick);
    let settings = prepared(context, "true motion", &columns, |&(k, d, _)| Setting::new(k, d))?;
    let pairs: Vec<_> = variants
        .iter()
        .flat_map(|variant| {
            settings.iter().zip(&columns).map(move |(setting, column)| (variant, setting, column.2))
        })
        .collect();
    let atlas = taken(context, "atlas", &pairs, |&(variant, setting, steps)| {
        atlas::column(variant, setting, steps)
    })?;
    let limits = limit::cases(&variants, context.quick)?;
    let limits = taken(context, "limits", &limits, limit::run)?;
    let shear = cells(context, "explicit shear", &shear::cases(context.quick), shear::run)?;
    let (cells, limits, shear) = (atlas.all()?.concat(), limits.all()?, shear.all()?);
    let facts = Facts { cells, limits, shear };
    let hashes = settings.iter().map(|setting| (setting.name(), setting.hash.clone()));
    let (facts, scenes, seed) = (facts, hashes.collect(), Some(SEEDS[0]));
    Ok(Measured { facts, timings: None, scenes, seed })
}

/// Whether another machine's round-off might change the verdict of a cell.
fn is_on_edge(cell: &Cell) -> bool {
    let near = |value: f64, edge: f64| value > edge / 2.0 && value < edge * 2.0;
    near(cell.gain, 0.02)
        || near(cell.gain, 0.5)
        || near(cell.drift.abs(), 0.05)
        || cell.reach.is_some_and(|reach| (0.4..0.6).contains(&reach))
        // A late explosion may also happen after the end.
        || (cell.gain > 0.5 && cell.gain < 1e3)
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let cells = facts.cells.iter().map(|cell| {
        let Cell {
            label, stiffness_over_mass_per_s2: k, damping_over_mass_per_s: d, step_s, ..
        } = cell;
        let mut fact =
            fact(format!("{label}, k/m={k:e}, d/m={d}, h={step_s}"), cell.portable, cell);
        if let serde_json::Value::Object(values) = &mut fact.values
            && !cell.portable
        {
            // Long runs are chaotic. If a library's functions rounded, only the verdict can be
            // repeated, and not always.
            values
                .retain(|key, value| value.is_string() && !(key == "verdict" && is_on_edge(cell)));
        }
        fact
    });
    let limits = facts.limits.iter().map(|limit| {
        let key = format!(
            "limit {}, {}, d/m={}",
            limit.scene, limit.label, limit.damping_over_mass_per_s
        );
        fact(key, limit.portable, limit)
    });
    let shear = facts.shear.iter().map(|shear| {
        let mut fact =
            fact(format!("shear {}, h={}", shear.label, shear.step_s), shear.portable, shear);
        if let serde_json::Value::Object(values) = &mut fact.values
            && !shear.portable
        {
            for key in ["ratios", "first_failure"] {
                values.remove(key);
            }
        }
        fact
    });
    cells.chain(limits).chain(shear).collect()
}
