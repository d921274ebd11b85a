//! The atlas: one method at one stiffness and damping, with steps from long to short.

use super::sheet::{SEEDS, Setting, run, schedule};
use crate::HarnessError;
use crate::methods::runs::Variant;
use crate::methods::{Choice, is_added};
use crate::studies::finite;
use crate::studies::stability::facts::Cell;
use drape_report::Verdict;

/// Effort after which a run is over budget, in visits of a spring: about a tenth of a second.
pub(super) const BUDGET: f64 = 3e7;
/// A run with a step of at most so many seconds that spends its budget by [`EARLY`] of its time ends
/// its column: shorter steps count as over budget without a run.
pub(super) const SHORT: f64 = 0.04;
pub(super) const EARLY: f64 = 0.3;
/// A run with a step of at most so many seconds ends its column if it spends its budget at all.
pub(super) const VERY_SHORT: f64 = 0.001;
/// A stable run is locked if its reach is below this share of the true one.
const HALF: f64 = 0.5;
/// The final verdict on a run: `judged` by its energy, corrected by its reach and its budget.
pub(super) fn full_verdict(judged: Verdict, reach: Option<f64>, is_over: bool) -> Verdict {
    match judged {
        Verdict::Stable | Verdict::Marginal if is_over => Verdict::OverBudget,
        Verdict::Stable if reach.is_some_and(|reach| reach < HALF) => Verdict::Locked,
        other => other,
    }
}

/// Whether shorter steps than that of a cell count as over budget without a run. With short steps the
/// work for a second grows with their number. With long ones it may fall, since a solve then needs
/// fewer iterations. In the map of d1849b38, in which every cell ran, none of the 766 cells that this
/// rule leaves out had another verdict. The nearest that would have had one follows a run that spent
/// its budget by 0.41 of its time (`imex-updated`, k/m = 1e5, h = 0.0316).
pub(super) fn ends_column(cell: &Cell) -> bool {
    let is_early = cell.reached_s <= EARLY * schedule(cell.step_s).time.duration_s;
    let is_meant = cell.step_s <= VERY_SHORT || (cell.step_s <= SHORT && is_early);
    cell.verdict == Verdict::OverBudget && is_meant
}

/// Runs a method at each of the steps, longest first. More starts are run where the verdict
/// changes. Steps after a cell that [ends the column](ends_column) are not run, unless the method is
/// an added one, for which nobody has tried that rule.
pub(super) fn column(
    variant: &Variant,
    setting: &Setting,
    steps: &[f64],
) -> Result<Vec<Cell>, HarnessError> {
    let choice = Choice::parse(variant.method, &[])?;
    let mut cells: Vec<Cell> = Vec::new();
    for &step_s in steps {
        let ended = |longer: &Cell| longer.starts == 0 || ends_column(longer);
        let is_over = !is_added(variant.label) && cells.last().is_some_and(ended);
        let mut cell = Cell {
            label: variant.label.to_owned(),
            method: choice.full_id(),
            stiffness_over_mass_per_s2: setting.stiffness,
            damping_over_mass_per_s: setting.damping,
            step_s,
            verdict: Verdict::Stable,
            starts: 0,
            gain: 0.0,
            drift: 0.0,
            reach: None,
            reached_s: f64::INFINITY,
            portable: choice.is_portable(),
        };
        if is_over {
            cells.push(Cell { verdict: Verdict::OverBudget, reached_s: 0.0, ..cell });
            continue;
        }
        add(&mut cell, setting, &choice, SEEDS[0])?;
        let is_last_good = cells.last().is_some_and(|longer| longer.verdict != cell.verdict);
        if is_last_good && cell.verdict < Verdict::OverBudget {
            for seed in &SEEDS[1..] {
                add(&mut cell, setting, &choice, *seed)?;
            }
        }
        cells.push(cell);
    }
    Ok(cells)
}

/// Adds a run from a perturbed start. The worst verdict counts.
fn add(cell: &mut Cell, setting: &Setting, choice: &Choice, seed: u64) -> Result<(), HarnessError> {
    let schedule = schedule(cell.step_s);
    let (counts, reach) = run(&setting.start(seed), choice, &schedule, Some(BUDGET))?;
    let reach = reach.map(|reach| reach / setting.reach);
    let judged = counts.verdict(setting.released);
    let verdict = full_verdict(judged, reach, counts.outcome.is_over_budget);
    cell.verdict = cell.verdict.max(verdict);
    let share = |energy: f64| finite(energy / setting.released);
    let drift = share(counts.energy.drift);
    if drift.abs() >= cell.drift.abs() {
        cell.drift = drift;
    }
    cell.gain = cell.gain.max(share(counts.energy.gain));
    cell.reach = if cell.starts == 0 {
        reach
    } else {
        cell.reach.zip(reach).map(|(one, other)| one.min(other))
    };
    cell.reached_s = cell.reached_s.min(counts.state.t);
    cell.starts += 1;
    Ok(())
}
