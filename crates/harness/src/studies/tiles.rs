//! Tiles of the tables that name the cheapest form of each scene, which several studies share.

use drape_report::Verdict;
use drape_report::plot::{Shade, Tile};

/// A tile with a text.
pub(super) fn told(shade: Shade, text: &str) -> Tile {
    Tile { shade, text: text.to_owned(), is_marked: false }
}

/// Why a form has no good run: the mildest of its verdicts.
pub(super) fn fault(verdicts: &[Verdict]) -> Tile {
    let has = |verdict: Verdict| verdicts.contains(&verdict);
    let (shade, text) = if has(Verdict::Stable) {
        (Shade::Fair, "≠")
    } else if has(Verdict::Open) {
        (Shade::Fair, "~")
    } else if has(Verdict::Locked) {
        (Shade::Still, "L")
    } else if has(Verdict::LostContact) {
        (Shade::Still, "↓")
    } else if has(Verdict::OverBudget) {
        (Shade::Idle, ">")
    } else if verdicts.is_empty() || has(Verdict::Refused) {
        (Shade::Idle, "–")
    } else {
        (Shade::Bad, "✗")
    };
    told(shade, text)
}

/// The legend: `unit` of the numbers, `others` what a stable run without a number is.
pub(super) fn legend(unit: &str, others: &[(&str, &str)]) -> Vec<(Tile, String)> {
    let mut legend = vec![
        (
            Tile { shade: Shade::Good, text: unit.to_owned(), is_marked: true },
            "cheapest, or a tie".to_owned(),
        ),
        (told(Shade::Open, unit), "good, but dearer".to_owned()),
    ];
    let fair = others.iter().map(|(sign, text)| (told(Shade::Fair, sign), (*text).to_owned()));
    legend.extend(fair);
    let faults = [
        (told(Shade::Still, "L"), "locked"),
        (told(Shade::Still, "↓"), "slid off"),
        (told(Shade::Bad, "✗"), "gains energy"),
        (told(Shade::Idle, ">"), "over the budget of work"),
        (told(Shade::Idle, "–"), "refuses, or is not run"),
    ];
    legend.extend(faults.map(|(tile, text)| (tile, text.to_owned())));
    legend
}
