//! The words of the study `stability`: its question, and what its numbers say.

use super::facts::{Cell, EXACT, Facts, Limit, Shear};
use crate::studies::short;
use drape_report::Verdict;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "Which step size, stiffness and damping does a method survive, where is its longest stable step, and is it \
     where theory puts it?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["order"];

const FAILING: [Verdict; 3] = [Verdict::Marginal, Verdict::Unstable, Verdict::Diverged];

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    findings.extend(atlas(facts));
    findings.extend(theorem(facts));
    findings.extend(standstill(facts));
    findings.extend(pair(facts));
    findings.extend(sheet(facts));
    for label in ["imex-euler", "imex-updated"] {
        findings.extend(shear(facts, label));
    }
    findings.extend(over_budget(facts));
    findings
}

fn labels(facts: &Facts) -> Vec<&str> {
    let mut labels: Vec<&str> = Vec::new();
    for cell in &facts.cells {
        if !labels.contains(&cell.label.as_str()) {
            labels.push(&cell.label);
        }
    }
    labels
}

fn is_failing(cell: &Cell) -> bool {
    FAILING.contains(&cell.verdict)
}

/// Who never gains energy, and how often the others do.
fn atlas(facts: &Facts) -> Option<String> {
    let (mut clean, mut others) = (Vec::new(), Vec::new());
    for label in labels(facts) {
        let cells = facts.cells.iter().filter(|cell| cell.label == label);
        let decided: Vec<_> = cells.filter(|cell| cell.verdict != Verdict::OverBudget).collect();
        let failing = decided.iter().filter(|cell| is_failing(cell)).count();
        let locked = decided.iter().filter(|cell| cell.verdict == Verdict::Locked).count();
        let all = decided.len();
        let still = if locked > 0 { format!(", {locked} of them locked") } else { String::new() };
        if failing == 0 {
            clean.push(format!("{label} ({all}{still})"));
        } else {
            others.push(format!("{label} {} of {all}{still}", all - failing));
        }
    }
    let mut lines = Vec::new();
    if !clean.is_empty() {
        lines.push(format!(
            "No cell of the atlas that came to a verdict gains energy with {}.",
            clean.join(", ")
        ));
    }
    if !others.is_empty() {
        lines.push(format!("Cells without gain: {}.", others.join("; ")));
    }
    (!lines.is_empty()).then(|| lines.join(" "))
}

/// The energy theorem of IMEX Euler.
fn theorem(facts: &Facts) -> Option<String> {
    let cells = || facts.cells.iter().filter(|cell| cell.label == EXACT);
    let greatest = cells().map(|cell| cell.gain).reduce(f64::max)?;
    Some(format!(
        "IMEX Euler with all springs in the matrix, solved to 1e-10: its energy rises by at most {} E_ref above its start \
         anywhere in the atlas.",
        short(greatest)
    ))
}

/// Stable because it does not move.
fn standstill(facts: &Facts) -> Option<String> {
    let mut lines = Vec::new();
    for label in labels(facts) {
        let of = |verdict: Verdict| {
            let cells = facts.cells.iter();
            cells.filter(|cell| cell.label == label && cell.verdict == verdict).count()
        };
        let (locked, stable) = (of(Verdict::Locked), of(Verdict::Stable));
        if locked > stable {
            lines.push(format!("{label} ({locked} locked, {stable} moving)"));
        }
    }
    (!lines.is_empty()).then(|| {
        format!("Standstill is no success: more than half of the cells that gain no energy are locked with {}.", lines.join(", "))
    })
}

/// Whether the form solves as loosely as the paper.
fn is_loose(limit: &Limit) -> bool {
    limit.method.contains("forcing_term=0.05")
}

fn damping(limit: &Limit) -> String {
    format!("d/m = {}", limit.damping_over_mass_per_s)
}

/// Two particles, where theory is exact.
fn pair(facts: &Facts) -> Option<String> {
    let limits: Vec<_> = facts.limits.iter().filter(|limit| limit.scene == "pair").collect();
    let (mut finite, mut never, mut free) = (Vec::new(), Vec::new(), 0);
    let (mut off, mut loose) = (Vec::new(), Vec::new());
    for limit in &limits {
        let name = format!("{} ({})", limit.label, damping(limit));
        match (limit.theory_s, limit.measured_s) {
            (Some(theory), Some(measured)) if theory > 0.0 && !limit.is_unlimited => {
                let ratio = measured / theory;
                finite.push(format!("{name} {}", short(ratio)));
                if !(0.95..=1.05).contains(&ratio) {
                    off.push(name);
                }
            }
            (Some(0.0), _) => {
                let measured = limit.measured_s.map_or("at no tested step".to_owned(), |h| {
                    let visible = limit.visible_s.unwrap_or_default();
                    format!(
                        "up to {} s, where growth first shows within the run: {} s",
                        short(h),
                        short(visible)
                    )
                });
                never.push(format!("{name}: seen stable {measured}"));
            }
            (None, _) if limit.is_unlimited => free += 1,
            (None, None) if is_loose(limit) => loose.push(name),
            _ => off.push(name),
        }
    }
    (!limits.is_empty()).then(|| {
        let range = limits[0].range_s;
        let off = if off.is_empty() {
            "no other is off by more than 5 %".to_owned()
        } else {
            format!("off: {}", off.join(", "))
        };
        let loose = if loose.is_empty() {
            String::new()
        } else {
            format!(
                " Unstable at the shortest step already, though theory has no limit: {}; theory is that of an exact solve, and \
                 with ε = 0.05 and the extrapolated start this is not one.",
                loose.join(", ")
            )
        };
        format!(
            "Two particles on a linear spring, measured over theoretical limit: {}. Without a stable step in theory: {}. \
             In {free} cases theory has no limit and none is found from {} s to {} s. Of all {} cases {off}.{loose}",
            finite.join(", "),
            never.join("; "),
            short(range[0]),
            range[1],
            limits.len()
        )
    })
}

/// The sheet, where theory is a bound.
fn sheet(facts: &Facts) -> Option<String> {
    let limits: Vec<_> = facts.limits.iter().filter(|limit| limit.scene == "sheet").collect();
    let (mut within, mut below) = (Vec::new(), Vec::new());
    for limit in &limits {
        let Some(theory) = limit.theory_s.filter(|theory| *theory > 0.0) else { continue };
        let name = format!("{} ({})", limit.label, damping(limit));
        let ratio = limit.measured_s.unwrap_or(0.0) / theory;
        let list = if ratio >= 0.95 { &mut within } else { &mut below };
        list.push(format!("{name} {}", short(ratio)));
    }
    let first = limits.first()?;
    let or_none =
        |list: Vec<String>| if list.is_empty() { "none".to_owned() } else { list.join(", ") };
    Some(format!(
        "On the sheet (λ_max of M⁻¹L_k = {} k/m) measured over theoretical limit: at least as long as theory \
         guarantees, within 5 %: {}; shorter, where the energy already swings or drifts by more than its rule admits: {}.",
        short(first.largest_eigenvalue_per_s2 / first.stiffness_over_mass_per_s2),
        or_none(within),
        or_none(below)
    ))
}

/// Explicit shear beside implicit tension.
fn shear(facts: &Facts, label: &str) -> Option<String> {
    let line = |scan: &Shear| {
        let last = scan.ratios.last().map_or(0.0, |ratio| ratio.ratio);
        let first =
            scan.first_failure.map_or(format!("none up to {last}"), |ratio| ratio.to_string());
        let start = scan.start_bound.map_or(format!("above {last}"), short);
        format!("h = {} s: {first} (bounds {} and {start})", scan.step_s, short(scan.bound))
    };
    let lines: Vec<_> = facts.shear.iter().filter(|scan| scan.label == label).map(line).collect();
    (!lines.is_empty()).then(|| {
        format!(
            "Explicit shear beside implicit tension, {label}: least ratio k_s/k that is not stable at k/m = {:e} (in \
             brackets the bounds of theory at any positions, and at the start): {}.",
            facts.shear[0].stiffness_over_mass_per_s2,
            lines.join("; ")
        )
    })
}

/// What was not found out.
fn over_budget(facts: &Facts) -> Option<String> {
    let count = |label: &&str| {
        let is_over = |cell: &&Cell| cell.label == **label && cell.verdict == Verdict::OverBudget;
        let count = facts.cells.iter().filter(is_over).count();
        (count > 0).then(|| format!("{label} {count}"))
    };
    let labels = labels(facts);
    let counts: Vec<_> = labels.iter().filter_map(count).collect();
    (!counts.is_empty()).then(|| format!("Cells that ended over budget: {}.", counts.join(", ")))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    fn cell(label: &str, verdict: Verdict) -> Cell {
        Cell {
            label: label.to_owned(),
            method: label.to_owned(),
            stiffness_over_mass_per_s2: 1e4,
            damping_over_mass_per_s: 0.0,
            step_s: 0.01,
            verdict,
            starts: 1,
            gain: 0.0,
            drift: 0.0,
            reach: None,
            reached_s: 2.0,
            portable: true,
        }
    }

    #[test]
    fn a_locked_cell_is_neither_a_gain_nor_a_success() {
        let cells = vec![
            cell("a", Verdict::Locked),
            cell("a", Verdict::Locked),
            cell("a", Verdict::Stable),
            cell("b", Verdict::Marginal),
        ];
        let facts = Facts { cells, limits: Vec::new(), shear: Vec::new() };
        let text = atlas(&facts).unwrap();
        assert!(text.contains("a (3, 2 of them locked)") && text.contains("b 0 of 1"), "{text}");
        assert!(standstill(&facts).unwrap().contains("a (2 locked, 1 moving)"));
    }
}
