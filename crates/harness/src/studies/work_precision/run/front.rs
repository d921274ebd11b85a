//! Who is cheapest: fronts and winners.

use super::variants::{DOP853, is_limited_by_stiffness};
use crate::methods;
use crate::studies::work_precision::facts::{LEAD, Row, Run, Tied, Winner, cheapest, cheapest_of};

/// Levels of error at which winners are named.
pub(super) const LEVELS: [f64; 4] = [1e-1, 1e-2, 1e-3, 1e-4];

/// A lead is narrow if another method would tie at errors that are larger by this factor.
const NARROW: f64 = 1.1;

/// Marks the runs of a scene that no run beats in both error and modelled time. Errors below
/// `floor` are noise and count as equal to it. Runs with a flaw neither beat others nor stand on
/// the front.
pub(in crate::studies) fn mark<'a>(rows: impl Iterator<Item = &'a mut Row>, floor: f64) {
    let mut runs: Vec<&mut Run> = rows.flat_map(|row| &mut row.runs).collect();
    let point = |run: &Run| match run.flaw {
        None => Some((run.error?.max(floor), run.modelled_s)),
        Some(_) => None,
    };
    let points: Vec<_> = runs.iter().filter_map(|run| point(run)).collect();
    let is_beaten = |(error, effort): (f64, f64)| {
        let beats = |&(e, w): &(f64, f64)| e <= error && w <= effort && (e < error || w < effort);
        points.iter().any(beats)
    };
    for run in &mut runs {
        run.is_on_front = point(run).is_some_and(|point| !is_beaten(point));
    }
}

fn id(row: &Row) -> &str {
    row.method.split(':').next().unwrap_or(&row.method)
}

/// The cheapest row of each method other than that of `best`, with its modelled time over that of
/// `best`: the cheapest first. Methods that take the same steps give the same answer, e.g.
/// symplectic Euler and Provot below his limit. A tie between equal runs says nothing, so equal runs
/// are left out.
fn behind<'a>(
    rows: impl Iterator<Item = &'a Row> + Clone,
    (best, run): (&Row, &Run),
    level: f64,
) -> Vec<(&'a Row, f64)> {
    let ids = methods::all().map(|method| method.id).chain([DOP853]);
    let others = ids.filter(|other| *other != id(best)).filter_map(|other| {
        let own = rows.clone().filter(|row| id(row) == other);
        let own = own.flat_map(|row| row.runs.iter().map(move |run| (row, run)));
        cheapest_of(own.filter(|(_, other)| other.error != run.error), level)
    });
    let mut others: Vec<_> =
        others.map(|(row, other)| (row, other.modelled_s / run.modelled_s)).collect();
    others.sort_by(|(_, a), (_, b)| a.total_cmp(b));
    others
}

/// The winner of a scene at a level of error, and the methods next to it.
pub(in crate::studies) fn winner(scene: &str, rows: &[Row], level: f64) -> Winner {
    let rows = rows.iter().filter(|row| row.scene == scene);
    let best = cheapest(rows.clone(), level);
    let others = |level: f64| best.map_or_else(Vec::new, |best| behind(rows.clone(), best, level));
    let is_tie = |(_, ratio): &(&Row, f64)| *ratio < LEAD;
    let behind = others(level);
    let is_narrow =
        !behind.first().is_some_and(is_tie) && others(NARROW * level).first().is_some_and(is_tie);
    let tied = behind.iter().take_while(|other| is_tie(other)).map(|(row, ratio)| Tied {
        label: row.label.clone(),
        is_explicit: is_limited_by_stiffness(&row.method),
        ratio: *ratio,
    });
    let beside = best.and_then(|(_, run)| run.beside);
    Winner {
        scene: scene.to_owned(),
        level,
        label: best.map(|(row, _)| row.label.clone()),
        is_explicit: best.map(|(row, _)| is_limited_by_stiffness(&row.method)),
        value: best.map(|(_, run)| run.value),
        modelled_s: best.map(|(_, run)| run.modelled_s),
        energy: beside.map(|beside| beside.energy),
        retained: beside.map(|beside| beside.retained),
        runner_up: behind.first().map(|(row, _)| row.label.clone()),
        ratio: behind.first().map(|(_, ratio)| *ratio),
        tied: tied.collect(),
        is_narrow,
    }
}
