//! The page of results.

use crate::memory::{SIZES, Speed};
use crate::{Comparison, Times};
use drape_benches::origin;
use drape_report::Provenance;
use drape_report::number::median;
use std::fmt::Write as _;
use std::num::NonZero;

pub(crate) fn text(
    provenance: &Provenance,
    speeds: &[(NonZero<usize>, [Speed; 3])],
    comparisons: &[Comparison],
    others: &[Comparison],
) -> String {
    let mut text = String::from(HEAD);
    for Comparison { side, threads, pairs, apart, .. } in comparisons {
        let middle = |which| middle(pairs, which);
        let phases = (0..3).map(|phase| format!("{:.2}", ratios(pairs, |t| t.phases[phase])[1]));
        let _ = writeln!(
            text,
            "| {side} × {side} | {threads} | {:.2} | {:.2} | {} | {} | {} |",
            middle(0),
            middle(1),
            range(ratios(pairs, |times| times.step)),
            phases.collect::<Vec<_>>().join(" | "),
            range(spread(apart.clone())),
        );
    }
    text += OTHERS;
    for Comparison { method, side, threads, pairs, .. } in others {
        let _ = writeln!(
            text,
            "| {method} | {side} × {side} | {threads} | {:.2} | {:.2} | {} |",
            middle(pairs, 0),
            middle(pairs, 1),
            range(ratios(pairs, |times| times.step)),
        );
    }
    text += MEMORY;
    for (threads, speeds) in speeds {
        for ((size, _), Speed { alone, together }) in SIZES.iter().zip(speeds) {
            let _ = writeln!(
                text,
                "| {size} | {threads} | {:.0} | {:.0} | {:.2} |",
                1e-9 * alone,
                1e-9 * together,
                together / alone
            );
        }
    }
    let _ = writeln!(
        text,
        "\n{}, {} rounds, {}.",
        provenance.cpu,
        comparisons.first().map_or(0, |c| c.pairs.len()),
        origin(provenance)
    );
    text
}

/// Least, median and greatest of how many times as fast all threads are.
fn ratios(pairs: &[[Times; 2]], of: impl Fn(&Times) -> f64) -> [f64; 3] {
    spread(pairs.iter().map(|[one, all]| of(one) / of(all)).collect())
}

fn spread(values: Vec<f64>) -> [f64; 3] {
    let all = || values.iter().copied();
    [all().reduce(f64::min), median(all()), all().reduce(f64::max)]
        .map(|value| value.unwrap_or(f64::NAN))
}

/// Median time of a step on one thread (0) or on all (1), ms.
fn middle(pairs: &[[Times; 2]], which: usize) -> f64 {
    median(pairs.iter().map(|pair| pair[which].step)).unwrap_or(f64::NAN)
}

fn range([least, median, greatest]: [f64; 3]) -> String {
    format!("**{median:.2}** ({least:.2}–{greatest:.2})")
}

const HEAD: &str = "\
# What more threads are worth

IMEX Euler with Jacobi's preconditioner on the hanging sheet, N × N particles row by row, tension implicit, k/m = 1e4/s², h = 0.01 s, as in \
`peers.md`. Turns on one thread and on several from the same state; after each turn both states are the same bits. Ratios are those of a round: \
median, least and greatest. *Apart*: as many sheets as threads, together of as many particles, each on a thread of its own at the same time; how \
many particles they step in the time in which one thread steps one of the large sheet. They never wait for each other and each is smaller than \
the large one, so that more of it stays in a cache: what is below the number of threads there, the cores take from each other. \
`cargo run --release -p drape-benches --bin threads` makes this page.

| particles | threads | one thread, ms a step | all threads, ms | times as fast | forces | solve | update | apart |
|---|---|---|---|---|---|---|---|---|
";

const OTHERS: &str = "
## Other methods

The same sheet and turns. Both states are the same bits after each turn.

| method | particles | threads | one thread, ms a step | all threads, ms | times as fast |
|---|---|---|---|---|---|
";

const MEMORY: &str = "
## What the machine has to give

`b ← b + s a`, the same loop on one thread alone and on all at the same time, each with arrays of its own of this size: bytes read and written \
in a second. What does not stay in a core's own cache cannot go faster on several threads than the last column.

| a thread's arrays | threads | one alone, GB/s | all together, GB/s | ratio |
|---|---|---|---|---|
";
