//! Figures and tables of the experiment `stability`.

use super::facts::{Cell, Facts, Limit, Shear, has_gained, over_theory};
use crate::families::labels;
use drape_report::Verdict;
use drape_report::number::{power, setting, significant, trimmed};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{
    At, Atlas, Axis, Look, Map, Panel, Point, Rule, Series, Shade, Sheet, State, Tile, values,
};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts>;

pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "stability-atlas.svg",
        title: "Steps and stiffnesses that each method survives, d/m = 40 s⁻¹",
        caption: "Explicit methods lose stability at a line of constant h²k/m. Beyond it, many \
            cells that implicit-explicit methods survive are locked (L). A map for each method: \
            step h to the right, k/m upwards, in decades. Hanging sheet of 8 × 8 particles. S \
            stable, L stable but less than half as far from the start as the true motion, M \
            marginal, U unstable, D diverged, B over budget.",
        draw: Draw::Atlas(|input| by_stiffness(input, 40.0)),
    },
    Plate {
        file: "stability-atlas-undamped.svg",
        title: "Steps and stiffnesses that each method survives, undamped",
        caption: "Without damping the picture is much the same. Explicit Euler and two-step \
            Adams-Bashforth have no stable step in theory: where they show S, growth is too slow \
            to be seen. A map for each method: step h to the right, k/m upwards. S stable, L \
            locked, M marginal, U unstable, D diverged, B over budget.",
        draw: Draw::Atlas(|input| by_stiffness(input, 0.0)),
    },
    Plate {
        file: "stability-atlas-damping.svg",
        title: "Steps and dampings that each method survives at k/m = 10⁶ s⁻²",
        caption: "Damping at the old velocity shortens the stable steps of explicit methods; in \
            implicit-explicit methods, it turns locked sheets (L) stable. A map for each method: \
            step h to the right, damping d/m upwards. S stable, L locked, M marginal, U unstable, \
            D diverged, B over budget.",
        draw: Draw::Atlas(by_damping),
    },
    Plate {
        file: "stability-limits.svg",
        title: "Longest stable step: measured over theory",
        caption: "On two particles all finite limits agree with theory (1, dashed) within the 5 % \
            of the search. On the sheet theory is a lower bound; only undamped symplectic Euler \
            and undamped `multirate` stay below it. k/m = 10⁴ s⁻². Methods without a finite limit \
            stand in the table; a cross on the left edge means that no step was stable.",
        draw: Draw::Sheet(ratios),
    },
    Plate {
        file: "stability-shear.svg",
        title: "Energy gained with explicit shear beside implicit tension",
        caption: "With IMEX Euler shear may be half as stiff as tension at any step; with updated \
            CG long steps fail at tiny ratios. Undamped sheet of 8 × 8 particles, k/m = 10⁶ s⁻²; \
            greatest gain of energy over E_ref against k_s/k, a curve for each step. Gains below \
            10⁻⁶ and above 10⁶ are drawn at these values (≤, ≥). Upright: the least bound of \
            theory. Runs over budget are left out.",
        draw: Draw::Sheet(shear),
    },
];

const KNOWN: [(Verdict, &str, Shade); 6] = [
    (Verdict::Stable, "S", Shade::Good),
    (Verdict::Locked, "L", Shade::Still),
    (Verdict::Marginal, "M", Shade::Fair),
    (Verdict::Unstable, "U", Shade::Bad),
    (Verdict::Diverged, "D", Shade::Worst),
    (Verdict::OverBudget, "B", Shade::Open),
];

fn tile(verdict: Verdict) -> Tile {
    let known = KNOWN.iter().find(|(name, ..)| *name == verdict);
    Tile {
        shade: known.map_or(Shade::Idle, |(.., shade)| *shade),
        text: known.map_or("?", |(_, letter, _)| letter).to_owned(),
        is_marked: false,
    }
}

fn identity(cell: &Cell) -> (&str, &str) {
    (&cell.method, &cell.label)
}

fn by_stiffness(input: &Input, damping: f64) -> Option<Atlas> {
    let cells: Vec<_> =
        input.facts.cells.iter().filter(|cell| cell.damping_over_mass_per_s == damping).collect();
    let note = "To the right: time step h (s). Upwards: stiffness over mass k/m (s⁻²).";
    atlas(&cells, |cell| cell.stiffness_over_mass_per_s2, note)
}

fn by_damping(input: &Input) -> Option<Atlas> {
    let stiffness = |cell: &&Cell| cell.stiffness_over_mass_per_s2 == 1e6;
    let cells: Vec<_> = input.facts.cells.iter().filter(stiffness).collect();
    let note = "To the right: time step h (s). Upwards: damping over mass d/m (s⁻¹).";
    atlas(&cells, |cell| cell.damping_over_mass_per_s, note)
}

/// A map for each label, with steps to the right and another quantity upwards.
fn atlas(cells: &[&Cell], of: impl Fn(&Cell) -> f64, note: &str) -> Option<Atlas> {
    let steps = values(cells.iter().map(|cell| cell.step_s));
    let mut rows = values(cells.iter().map(|cell| of(cell)));
    rows.reverse();
    let labels = labels(cells.iter().map(|cell| identity(cell)));
    let map = |label: String| {
        let at = |row: f64, step: f64| {
            let found =
                |cell: &&&Cell| cell.label == label && of(cell) == row && cell.step_s == step;
            cells.iter().find(found).map(|cell| tile(cell.verdict))
        };
        let tiles = rows.iter().map(|&row| steps.iter().map(|&step| at(row, step)).collect());
        Map { tiles: tiles.collect(), title: label }
    };
    let maps: Vec<_> = labels.into_iter().map(map).collect();
    // Only decades have labels: there is no room for more.
    let tick = |step: &f64| {
        let text = power(*step);
        if text.contains('.') { String::new() } else { text }
    };
    let legend = KNOWN.iter().filter(|(name, ..)| cells.iter().any(|cell| cell.verdict == *name));
    let legend: Vec<_> =
        legend.map(|(verdict, ..)| (tile(*verdict), verdict.to_string())).collect();
    (!maps.is_empty() && rows.len() > 1).then(|| Atlas {
        x_ticks: steps.iter().map(tick).collect(),
        y_ticks: rows
            .iter()
            .map(|row| if *row == 0.0 { "0".to_owned() } else { power(*row) })
            .collect(),
        maps,
        legend,
        notes: vec![note.to_owned()],
    })
}

fn name(limit: &Limit) -> String {
    let damping = limit.damping_over_mass_per_s;
    format!("{}, d/m = {} s⁻¹", limit.scene, trimmed(damping, 3))
}

fn ratios(input: &Input) -> Option<Sheet> {
    let limits: Vec<_> =
        input.facts.limits.iter().filter(|limit| over_theory(limit).is_some()).collect();
    let labels = labels(limits.iter().map(|limit| (limit.method.as_str(), limit.label.as_str())));
    let found: Vec<f64> =
        limits.iter().filter_map(|limit| over_theory(limit)).chain([0.0, 1.4]).collect();
    let axis = Axis::linear("longest stable step, measured over theory (ratio)", &found);
    let mut panel = Panel::new(Vec::new(), axis, Axis::names("", &labels));
    let mut names: Vec<String> = Vec::new();
    for limit in &limits {
        if !names.contains(&name(limit)) {
            names.push(name(limit));
        }
    }
    for (n, scene) in names.iter().enumerate() {
        let points = limits.iter().filter(|limit| name(limit) == *scene).filter_map(|limit| {
            let y = -(labels.iter().position(|label| *label == limit.label)? as f64);
            let x = over_theory(limit)?;
            let state = if x > 0.0 { State::Stable } else { State::Failed };
            Some(Point { x, y, state })
        });
        let series = Series::new(scene.clone(), Look::number(n), points.collect());
        panel.series.extend(series.map(Series::apart));
    }
    panel.rules.push(Rule { label: "measured as in theory".to_owned(), at: At::X(1.0) });
    (!labels.is_empty()).then(|| Sheet { panels: vec![panel], notes: Vec::new() })
}

/// Smaller gains count as none.
const LEAST_GAIN: f64 = 1e-6;
/// Larger gains are drawn on the upper edge.
const MOST_GAIN: f64 = 1e6;

fn shear(input: &Input) -> Option<Sheet> {
    let scans = &input.facts.shear;
    let ratios: Vec<f64> = scans.iter().flat_map(|s| &s.ratios).map(|r| r.ratio).collect();
    let mut panels: Vec<Panel> = Vec::new();
    let mut names: Vec<&str> = scans.iter().map(|scan| scan.label.as_str()).collect();
    names.dedup();
    names.sort_unstable();
    names.dedup();
    let steps = values(scans.iter().map(|scan| scan.step_s));
    for label in names {
        let mut panel = Panel::new(
            vec![label.to_owned()],
            Axis::log("stiffness ratio k_s/k (dimensionless)", &ratios),
            Axis::log("gain of energy over E_ref", &[LEAST_GAIN, MOST_GAIN]).clipped(),
        );
        let of: Vec<_> = scans.iter().filter(|scan| scan.label == label).collect();
        for scan in &of {
            let ended = scan.ratios.iter().filter(|ratio| ratio.verdict != Verdict::OverBudget);
            let points = ended.map(|ratio| Point {
                x: ratio.ratio,
                y: ratio.gain.clamp(LEAST_GAIN, MOST_GAIN),
                state: State::of_verdict(ratio.verdict),
            });
            let n = steps.iter().position(|step| *step == scan.step_s).unwrap_or(0);
            let name = format!("h = {} s", setting(scan.step_s));
            panel.series.extend(Series::new(name, Look::number(n), points.collect()));
        }
        let bound = of.iter().map(|scan| scan.bound).reduce(f64::min);
        panel.rules.extend(
            bound.map(|bound| Rule { label: "least bound of theory".to_owned(), at: At::X(bound) }),
        );
        panels.push(panel);
    }
    (!panels.is_empty()).then_some(Sheet { panels, notes: Vec::new() })
}

/// All tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    vec![limits(input), scans(input), counts(input)]
}

fn limits(input: &Input) -> Table {
    let line = |limit: &Limit| {
        let step = |h: Option<f64>| h.map_or_else(absent, |h| significant(h, 3));
        let theory = match limit.theory_s {
            Some(0.0) => "none".to_owned(),
            Some(h) => significant(h, 3),
            None if limit.rule == "none" => "–".to_owned(),
            None => "no limit".to_owned(),
        };
        let measured = if limit.is_unlimited {
            format!("≥ {}", setting(limit.range_s[1]))
        } else {
            step(limit.measured_s)
        };
        vec![
            limit.label.clone(),
            name(limit),
            limit.rule.clone(),
            significant(limit.largest_eigenvalue_per_s2, 4),
            theory,
            step(limit.visible_s),
            measured,
            over_theory(limit)
                .filter(|_| !limit.is_unlimited)
                .map_or_else(absent, |r| significant(r, 3)),
        ]
    };
    Table {
        title: "**Longest stable steps.** λ: largest eigenvalue of M⁻¹L_k, θ = h²λ, η = hλd/k. \
                Theory: no mode grows (none: every step lets one grow). Visible: longest step at \
                which growth does not show. ≥: no step failed."
            .to_owned(),
        header: texts(&[
            "method",
            "scene",
            "stable for",
            "λ (s⁻²)",
            "theory (s)",
            "visible (s)",
            "measured (s)",
            "measured over theory",
        ]),
        names: 3,
        rows: input.facts.limits.iter().map(line).collect(),
    }
}

fn scans(input: &Input) -> Table {
    let line = |scan: &Shear| {
        let failing = scan.first_failure.and_then(|first| {
            let found = scan.ratios.iter().find(|ratio| ratio.ratio == first)?;
            Some(format!(
                "{} ({}, {})",
                trimmed(first, 3),
                found.verdict,
                significant(found.gain, 2)
            ))
        });
        let held = scan.ratios.iter().take_while(|ratio| Some(ratio.ratio) != scan.first_failure);
        let held = held.filter(|ratio| ratio.verdict == Verdict::Stable).last();
        vec![
            scan.label.clone(),
            setting(scan.step_s),
            significant(scan.bound, 3),
            scan.start_bound.map_or_else(absent, |bound| significant(bound, 3)),
            held.map_or_else(absent, |ratio| trimmed(ratio.ratio, 3)),
            failing.unwrap_or_else(absent),
        ]
    };
    Table {
        title:
            "**Explicit shear beside implicit tension**, undamped, k/m = 10⁶ s⁻²: ratios k_s/k. \
                Beyond the bound some mode has θ_E > 4 + θ_I, anywhere or at the start; for \
                updated CG θ_I counts only along the springs."
                .to_owned(),
        header: texts(&[
            "method",
            "h (s)",
            "bound, anywhere",
            "bound, start",
            "greatest stable ratio",
            "first that is not (verdict, gain over E_ref)",
        ]),
        names: 1,
        rows: input.facts.shear.iter().map(line).collect(),
    }
}

/// Counts of cells by verdict. The variant with the greatest share of cells without gain is first.
fn counts(input: &Input) -> Table {
    let mut header = texts(&["method", "without gain (%)"]);
    header.extend(KNOWN.iter().map(|(verdict, ..)| verdict.to_string()));
    header.push("greatest gain over E_ref of stable and locked cells".to_owned());
    let line = |label: String| {
        let cells = || input.facts.cells.iter().filter(|cell| cell.label == label);
        let of = |verdict: Verdict| cells().filter(|cell| cell.verdict == verdict).count();
        let decided = cells().count() - of(Verdict::OverBudget);
        let good = cells().filter(|cell| !has_gained(cell) && cell.verdict != Verdict::OverBudget);
        let share = good.clone().count() as f64 / decided.max(1) as f64;
        let gain = good.map(|cell| cell.gain).reduce(f64::max);
        let mut line = vec![label.clone(), significant(100.0 * share, 3)];
        line.extend(KNOWN.iter().map(|(verdict, ..)| of(*verdict).to_string()));
        line.push(gain.map_or_else(absent, |gain| significant(gain, 2)));
        (share, line)
    };
    let mut rows: Vec<_> =
        labels(input.facts.cells.iter().map(identity)).into_iter().map(line).collect();
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    Table {
        title: "**Cells of the atlas by verdict**, the most without gain first; cells over budget \
                do not count."
            .to_owned(),
        header,
        names: 1,
        rows: rows.into_iter().map(|(_, row)| row).collect(),
    }
}
