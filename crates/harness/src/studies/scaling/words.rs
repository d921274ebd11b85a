//! The words of the study `scaling`: its question, and the findings from its numbers.

use super::facts::{Cell, FIXED_MATERIAL, FIXED_QUOTIENT, Facts, Growth, growths};
use crate::studies::names::verb;
use drape_report::number::{power, setting, significant};
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str =
    "How do the iterations and the time of a step grow from a hundred particles to a million?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["work-precision"];

/// Power of n below which iterations count as constant.
const LEVEL: f64 = 0.05;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let begins = [(FIXED_QUOTIENT, "With k/m fixed"), (FIXED_MATERIAL, "With the material fixed")];
    let conclusion: Vec<_> =
        begins.iter().filter_map(|(series, begin)| growth(facts, series, begin)).collect();
    let conclusion = match &conclusion[..] {
        [] => "One size tells nothing about growth.".to_owned(),
        sentences => sentences.join(" "),
    };
    let observations = [most(facts), failed(facts)].into_iter().flatten().collect();
    Words { conclusion, observations, caveats: caveats(facts) }
}

/// The growth of the iterations in a series, over all methods.
fn growth(facts: &Facts, series: &str, begin: &str) -> Option<String> {
    let own: Vec<_> = growths(facts).into_iter().filter(|g| g.first.series == *series).collect();
    let least = own.iter().map(Growth::power).reduce(f64::min)?;
    let greatest = own.iter().map(Growth::power).reduce(f64::max)?;
    let what = "the CG iterations of a step";
    Some(if greatest < LEVEL {
        format!("{begin}, {what} do not grow with the number of particles.")
    } else if least < LEVEL {
        let grow = own.iter().filter(|growth| growth.power() >= LEVEL).count();
        format!(
            "{begin}, {what} grow in {grow} of {} forms, at most as n to the power \
             {greatest:.2}.",
            own.len()
        )
    } else {
        let powers = if least == greatest {
            format!("{least:.2}")
        } else {
            format!("{least:.2} to {greatest:.2}, by method")
        };
        format!("{begin}, {what} grow as n to the power {powers}.")
    })
}

/// The method and mesh with the most iterations a step.
fn most(facts: &Facts) -> Option<String> {
    let most = facts.cells.iter().max_by(|a, b| a.cg_per_step.total_cmp(&b.cg_per_step))?;
    (most.cg_per_step > 0.0).then(|| {
        format!(
            "`{}` takes the most CG iterations a step: {} at n = {} ({}).",
            most.label,
            significant(most.cg_per_step, 3),
            power(most.particles as f64),
            most.series
        )
    })
}

fn failed(facts: &Facts) -> Option<String> {
    let fails = |cell: &&Cell| cell.verdict != Verdict::Completed || cell.unconverged_steps > 0;
    let count = facts.cells.iter().filter(fails).count();
    let all = facts.cells.len();
    let worst = facts.cells.iter().filter(fails).max_by_key(|cell| cell.unconverged_steps);
    (all > 0).then(|| match worst {
        None => format!("All {all} runs complete and every solve meets its tolerance."),
        Some(worst) => format!(
            "{count} of {all} runs {} or {} solves that miss their tolerance, at worst {} at n = \
             {} ({}, {}).",
            verb(count, "fails", "fail"),
            verb(count, "has", "have"),
            worst.label,
            worst.particles,
            worst.verdict,
            match worst.unconverged_steps {
                1 => "1 step".to_owned(),
                steps => format!("{steps} steps"),
            }
        ),
    })
}

fn caveats(facts: &Facts) -> Vec<String> {
    let steps = facts.cells.iter().max_by_key(|cell| (cell.particles, cell.steps));
    let steps = steps.map(|cell| {
        format!(
            "Runs cover only the first steps, {} on the largest mesh, so transients count.",
            cell.steps
        )
    });
    let largest = |label: &str| {
        facts.cells.iter().filter(|cell| cell.label == *label).map(|cell| cell.particles).max()
    };
    let mut labels: Vec<_> = facts.cells.iter().map(|cell| cell.label.as_str()).collect();
    labels.sort_unstable();
    labels.dedup();
    let top = facts.cells.iter().map(|cell| cell.particles).max();
    let short = labels.iter().filter(|label| largest(label) < top).count();
    let short = (short > 0)
        .then(|| format!("The largest mesh was not run with {short} of {} forms.", labels.len()));
    let explicit = growths(facts).len() < facts.labels_with_iterations();
    let explicit = explicit.then(|| {
        let step = facts.cells.iter().map(|cell| cell.step_s).fold(0.0, f64::max);
        format!(
            "Growth counts only forms with h = {} s; others take shorter steps on finer meshes.",
            setting(step)
        )
    });
    [steps, short, explicit].into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(series: &str, label: &str, particles: usize, cg_per_step: f64) -> Cell {
        Cell {
            series: series.to_owned(),
            side: 10,
            particles,
            springs: 2 * particles,
            stiffness_over_mass_per_s2: 1e4,
            damping_over_mass_per_s: 10.0,
            step_s: 0.01,
            steps: 3,
            label: label.to_owned(),
            method: label.to_owned(),
            cg_per_step,
            matvecs: 0,
            force_evaluations: 0,
            newton_iterations: 0,
            unconverged_steps: 0,
            verdict: Verdict::Completed,
            portable: true,
        }
    }

    #[test]
    fn the_conclusion_tells_growth_from_none() {
        let mut cells = vec![
            cell(FIXED_QUOTIENT, "a", 100, 2.0),
            cell(FIXED_QUOTIENT, "a", 10_000, 2.0),
            cell(FIXED_MATERIAL, "a", 100, 2.0),
            cell(FIXED_MATERIAL, "a", 10_000, 20.0),
        ];
        let said = words(&Facts { cells: cells.clone() });
        assert_eq!(
            said.conclusion,
            "With k/m fixed, the CG iterations of a step do not grow with the number of \
             particles. With the material fixed, the CG iterations of a step grow as n to the \
             power 0.50."
        );
        assert!(
            said.observations[0].contains("a step: 20.0 at n = 10⁴ (material fixed)"),
            "{said:?}"
        );
        assert_eq!(
            said.observations[1],
            "All 4 runs complete and every solve meets its tolerance."
        );
        assert!(said.caveats[0].contains("3 on the largest mesh"), "{said:?}");
        cells.extend([cell(FIXED_MATERIAL, "b", 100, 2.0), cell(FIXED_MATERIAL, "b", 10_000, 2.0)]);
        // An explicit method takes shorter steps, so its solves are shorter too.
        let explicit = |n| Cell { step_s: 0.001, ..cell(FIXED_MATERIAL, "c", n, n as f64) };
        cells.extend([100, 10_000].map(explicit));
        cells[1].unconverged_steps = 1;
        let said = words(&Facts { cells: cells.clone() });
        let grow = "grow in 1 of 2 forms, at most as n to the power 0.50.";
        assert!(said.conclusion.ends_with(grow), "{said:?}");
        let failed = "1 of 8 runs fails or has solves that miss their tolerance, at worst a at n = \
                      10000 (completed, 1 step).";
        assert_eq!(said.observations[1], failed);
        assert!(said.caveats.iter().any(|caveat| caveat.contains("h = 0.01 s")), "{said:?}");
        cells.truncate(1);
        assert_eq!(words(&Facts { cells }).conclusion, "One size tells nothing about growth.");
    }
}
