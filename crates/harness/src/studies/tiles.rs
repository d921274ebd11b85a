//! Tiles of the maps that several studies share. They name the cheapest form or method of each
//! scene.

use crate::families::is_local;
use drape_report::Verdict;
use drape_report::number::significant;
use drape_report::plot::{Shade, Tile};

/// A tile with this text.
pub(super) fn told(shade: Shade, text: &str) -> Tile {
    Tile { shade, text: text.to_owned(), is_marked: false }
}

/// The tile of a form without a good run. It shows the mildest of the verdicts.
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

/// The legend of a map: `unit` of the numbers, and `others` for stable runs without a number.
pub(super) fn legend(unit: &str, others: &[(&str, &str)]) -> Vec<(Tile, String)> {
    let mut legend = vec![
        (
            Tile { shade: Shade::Good, text: unit.to_owned(), is_marked: true },
            "cheapest, or a tie".to_owned(),
        ),
        (told(Shade::Open, unit), "good, but costs more".to_owned()),
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

/// A tile of a map of winners. `name` is the cheapest method and `is_explicit` says whether
/// stiffness limits its step. `ties` are the other methods that tie with it. `next` is
/// the time of the next method over that of the winner. A tie names two methods and has no colour.
pub(super) fn winner(name: &str, is_explicit: bool, ties: &[&str], next: Option<f64>) -> Tile {
    if let [second, others @ ..] = ties {
        let more = if others.is_empty() { String::new() } else { format!(" +{}", others.len()) };
        return told(Shade::Tie, &format!("{name} =\n{second}{more}"));
    }
    let shade = match is_explicit {
        true => Shade::Open,
        false if is_local(name) => Shade::Still,
        false => Shade::Fair,
    };
    let margin = next.map_or_else(String::new, |next| {
        // Two digits could show a lead that looks like a tie.
        let digits = if next < 2.0 { 3 } else { 2 };
        format!(" ×{}", significant(next, digits))
    });
    told(shade, &format!("{name}{margin}"))
}

/// The legend of a map of winners. `idle` says why a tile is empty.
pub(super) fn legend_of_winners(idle: &str) -> Vec<(Tile, String)> {
    let entries = [
        (Shade::Open, "stiffness limits the step (explicit)"),
        (Shade::Fair, "it does not (implicit)"),
        (Shade::Still, "it takes more sweeps or substeps (local solves)"),
        (Shade::Tie, "a tie, whatever the kinds"),
        (Shade::Idle, idle),
    ];
    entries.map(|(shade, text)| (told(shade, ""), text.to_owned())).into()
}

/// The meaning of the signs in a map of winners. `bound` says which times are a tie.
pub(super) fn signs_of_winners(bound: &str) -> String {
    format!(
        "×2.5: the next method takes 2.5 times as long. A tie is {bound}: two methods are named, \
         and +3 counts three more."
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_winner_has_the_colour_of_its_kind_and_a_tie_has_none() {
        let of = |name: &str, is_explicit: bool| winner(name, is_explicit, &[], Some(3.0)).shade;
        assert_eq!(of("symplectic-euler", true), Shade::Open);
        assert_eq!(of("bdf2", false), Shade::Fair);
        assert_eq!(of("xpbd-lines", false), Shade::Still);
        assert_eq!(winner("bdf2", false, &["dirk"], None).shade, Shade::Tie);
    }
}
