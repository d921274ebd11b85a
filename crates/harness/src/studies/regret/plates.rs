//! Figures and tables of the experiment `regret`.

use super::facts::{Case, Facts, MEDIAN, MET, Origin, Pick, TimingRow, WORST};
use drape_report::number::{median, percent, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{At, Axis, Look, Panel, Point, Rule, Series, Sheet, State};

/// What the figures are drawn from.
pub(super) type Input = crate::studies::Input<Facts, TimingRow>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[Plate {
    file: "regret.svg",
    title: "Time of the advised form over that of the best one",
    caption: "A point a scene and target. Across: modelled time of the whole comparison over that \
        of an exhaustive search, so that points on the left were cheap to find. Upwards: the regret, \
        modelled time of the advised run over that of the best run of all forms; 1 is the best run \
        itself, the dashed line the greatest that the advice should have. Scenes on which nothing \
        was tuned.",
    draw: Draw::Sheet(figure),
}];

fn figure(input: &Input) -> Option<Sheet> {
    let cases = &input.facts.cases;
    let judged: Vec<(&Case, f64)> =
        cases.iter().filter_map(|case| Some((case, case.regret?))).collect();
    let xs: Vec<f64> = judged.iter().map(|(case, _)| 100.0 * case.effort).collect();
    let ys: Vec<f64> = judged.iter().map(|(_, regret)| *regret).chain([1.0, WORST]).collect();
    let mut panel = Panel::new(
        Vec::new(),
        Axis::log("effort of the comparison (% of the search)", &xs),
        Axis::linear("regret (ratio of times)", &ys),
    );
    let mut series = |n: usize, label: &str, is_its: fn(&Case) -> bool| {
        let own = judged.iter().filter(|(case, _)| is_its(case));
        let points = own.map(|(case, regret)| Point {
            x: 100.0 * case.effort,
            y: *regret,
            state: State::Stable,
        });
        let series = Series::new(label.to_owned(), Look::number(n), points.collect());
        panel.series.extend(series.map(Series::apart));
    };
    series(0, "target met on a pushed cloth", |case| case.is_met() == Some(true));
    series(1, "target missed on a pushed cloth", |case| case.is_met() == Some(false));
    panel.rules.push(Rule { label: "greatest that it should have".to_owned(), at: At::Y(WORST) });
    (judged.len() > 1).then_some(Sheet { panels: vec![panel], notes: Vec::new() })
}

fn millimetres(metres: f64) -> String {
    significant(1e3 * metres, 2)
}

fn pick(pick: Option<&Pick>) -> String {
    pick.map_or_else(absent, |pick| {
        format!("{} ×{}, {} ms", pick.label, pick.substeps, significant(1e3 * pick.frame_s, 2))
    })
}

/// All tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let mut tables = vec![cases(&input.facts)];
    let timings = input.timings.as_ref();
    tables.extend(timings.into_iter().flat_map(|t| [sums(&t.rows), by_clock(&t.rows)]));
    tables
}

fn cases(facts: &Facts) -> Table {
    let row = |case: &Case| {
        let again = case.again_m.map_or_else(absent, millimetres);
        vec![
            case.scene.clone(),
            case.description.clone(),
            format!("{}; {}", millimetres(case.target_m), millimetres(case.good_m)),
            pick(case.best.as_ref()),
            pick(case.advice.as_ref()),
            case.regret.map_or_else(absent, |regret| significant(regret, 3)),
            format!("{again}; {}", millimetres(case.again_good_m)),
            percent(case.effort, 2),
        ]
    };
    Table {
        title: "**Advice and best form by modelled time a frame**; ×n: n steps a frame.".to_owned(),
        header: texts(&[
            "scene",
            "what it is",
            "target; counts as met (mm)",
            "best of all",
            "advised",
            "regret",
            "error when pushed; counts as met (mm)",
            "effort",
        ]),
        names: 2,
        rows: facts.cases.iter().map(row).collect(),
    }
}

/// What holds by the clock, for each origin and for all scenes.
fn sums(rows: &[TimingRow]) -> Table {
    let all = [None].into_iter().chain(Origin::ALL.map(Some));
    let line = |origin: Option<Origin>| {
        let own =
            || rows.iter().filter(move |row| origin.is_none_or(|origin| row.origin == origin));
        let met: Vec<bool> = own().filter_map(TimingRow::is_met).collect();
        let kept = met.iter().filter(|met| **met).count();
        let regrets: Vec<f64> = own().filter_map(|row| row.regret).collect();
        let worst = regrets.iter().copied().reduce(f64::max);
        let ratio = |value: Option<f64>| value.map_or_else(absent, |value| significant(value, 3));
        vec![
            origin.map_or("all", Origin::name).to_owned(),
            own().count().to_string(),
            own().filter(|row| row.is_judged).count().to_string(),
            own().filter(|row| row.label.is_some()).count().to_string(),
            format!("{kept} of {}", met.len()),
            ratio(median(regrets.iter().copied())),
            ratio(worst),
            regrets.len().to_string(),
        ]
    };
    Table {
        title: format!(
            "**The aim by the clock of one machine**: the target met in at least {}, a regret of at \
             most {MEDIAN} in the median and {WORST} at worst.",
            percent(MET, 2)
        ),
        header: texts(&[
            "scenes",
            "cases",
            "with a true motion",
            "with an advice",
            "target met again",
            "regret: median",
            "worst",
            "of so many",
        ]),
        names: 1,
        rows: all.map(line).collect(),
    }
}

fn by_clock(rows: &[TimingRow]) -> Table {
    let form = |label: Option<&String>, substeps: u32| {
        label.map_or_else(absent, |label| format!("{label} ×{substeps}"))
    };
    let ratio = |value: Option<f64>| value.map_or_else(absent, |value| significant(value, 3));
    let row = |row: &TimingRow| {
        let again = row.again_m.map_or_else(absent, millimetres);
        vec![
            row.scene.clone(),
            row.origin.name().to_owned(),
            row.particles.to_string(),
            millimetres(row.target_m),
            if row.is_trusted { "yes" } else { "no" }.to_owned(),
            form(row.label.as_ref(), row.substeps),
            form(row.best.as_ref(), row.best_substeps),
            ratio(row.regret),
            row.again_good_m.map_or_else(absent, |good| format!("{again}; {}", millimetres(good))),
            significant(row.seconds, 2),
            ratio(row.over_model),
        ]
    };
    let budget = rows.first().map_or(0.0, |row| row.budget_s);
    Table {
        title: format!(
            "**Advice and best form by the clock of one machine**, budget {budget} s; ×n: n steps a \
             frame."
        ),
        header: texts(&[
            "scene",
            "kind",
            "particles",
            "target (mm)",
            "true motion",
            "advised",
            "best of the search",
            "regret",
            "error when pushed; counts as met (mm)",
            "seconds",
            "clock over model",
        ]),
        names: 2,
        rows: rows.iter().map(row).collect(),
    }
}
