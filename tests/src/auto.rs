//! What follows from the record of `work-precision` for `--method auto`.

use drape_harness::auto::{Case, LEVELS, Table, judge};
use drape_report::number::{percent, significant};
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

/// The files, below the root of the workspace.
pub const FILES: [&str; 2] = ["crates/harness/src/auto/table.json", "results/auto.md"];

/// Their texts.
///
/// # Errors
/// What is wrong with the record.
pub fn written(root: &Path) -> Result<[String; 2], Box<dyn Error>> {
    let record = std::fs::read_to_string(root.join("results/work-precision.json"))?;
    let table =
        serde_json::to_string(&Table::of_record(&record)?)?.replace("},{\"id\"", "},\n{\"id\"");
    Ok([table + "\n", page(&judge(&record, false)?, &judge(&record, true)?)])
}

/// Numbers of a list of cases.
pub struct Summary {
    /// Number of cases.
    pub cases: usize,
    /// Median of the regret.
    pub median: f64,
    /// Regret in nine of ten cases at most.
    pub nine_of_ten: f64,
    /// Greatest regret; infinite where a form does not get to the error.
    pub worst: f64,
    /// Share of the cases in which the error is met with the foreseen step.
    pub met: f64,
    /// Median of the modelled time with that step over that of the best form, where it is met.
    pub with_step: f64,
}

/// Sums cases up.
#[must_use]
pub fn summary(cases: &[Case]) -> Summary {
    let sorted = |values: Vec<f64>| {
        let mut values = values;
        values.sort_by(f64::total_cmp);
        values
    };
    let regrets = sorted(cases.iter().map(|case| case.regret.unwrap_or(f64::INFINITY)).collect());
    let steps = sorted(cases.iter().filter_map(|case| case.with_step).collect());
    let at = |values: &[f64], share: f64| {
        values.get((share * values.len() as f64) as usize).copied().unwrap_or(f64::NAN)
    };
    let met = cases.iter().filter(|case| case.is_met).count();
    Summary {
        cases: cases.len(),
        median: at(&regrets, 0.5),
        nine_of_ten: at(&regrets, 0.9),
        worst: regrets.last().copied().unwrap_or(f64::NAN),
        met: met as f64 / cases.len().max(1) as f64,
        with_step: at(&steps, 0.5),
    }
}

fn page(known: &[Case], held_out: &[Case]) -> String {
    let mut text = String::from(
        "# How good `--method auto` is\n\n\
         `drape run SCENE --method auto` chooses a form and a step from the study `work-precision`, \
         without a run of its own. This page holds the rule against the study. *Regret* is the least \
         modelled time of the chosen form for an error, over that of the best form. *Met* is the \
         share of cases in which the form keeps the error with the step that is foreseen. In *held \
         out* each scene is foreseen from the other scenes alone: a measure for scenes that the \
         study does not have. The aim is a regret of at most 1.2 in the median and 3 at worst. \
         `cargo run -p drape-tests --bin auto` makes this page from the record.\n\n\
         | | cases | regret: median | nine of ten at most | worst | met | time with the foreseen step over the best, median |\n\
         |---|---|---|---|---|---|---|\n",
    );
    for (name, cases) in [("all scenes known", known), ("held out", held_out)] {
        let s = summary(cases);
        line(
            &mut text,
            &format!(
                "| {name} | {} | {} | {} | {} | {} | {} |",
                s.cases,
                number(s.median),
                number(s.nine_of_ten),
                number(s.worst),
                percent(s.met, 2),
                number(s.with_step)
            ),
        );
    }
    line(&mut text, "\n## Each scene, held out\n");
    line(&mut text, "A cross marks a step with which the error is not met.\n");
    let heads: Vec<_> = LEVELS.iter().map(|level| percent(*level, 2)).collect();
    line(&mut text, &format!("| scene | {} |", heads.join(" | ")));
    line(&mut text, "|---|---|---|---|---|");
    let mut scenes: Vec<&str> = held_out.iter().map(|case| case.scene.as_str()).collect();
    scenes.dedup();
    for scene in scenes {
        let cells = LEVELS.map(|level| {
            let case = held_out.iter().find(|case| case.scene == scene && case.level == level);
            case.map_or_else(
                || "no form gets there".to_owned(),
                |case| {
                    let cross = if case.is_met { "" } else { " ✗" };
                    let regret = case.regret.map_or_else(|| "never".to_owned(), number);
                    format!("{regret} `{}`{cross}", case.method)
                },
            )
        });
        line(&mut text, &format!("| {scene} | {} |", cells.join(" | ")));
    }
    text
}

fn line(text: &mut String, line: &str) {
    // A String takes every text.
    let _ = writeln!(text, "{line}");
}

fn number(value: f64) -> String {
    if value.is_finite() { significant(value, 3) } else { "never".to_owned() }
}
