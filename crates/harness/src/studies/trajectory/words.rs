//! The words of the study `trajectory`: its question, and the findings from its numbers.

use super::facts::{
    Beside, Facts, Flaw, HALF, Kind, LEAD, PICTURE_S, Row, Run, Scene, Winner, overtaken, saved,
    tally,
};
use crate::studies::names;
use drape_report::Words;
use drape_report::number::{percent, power, significant};

/// The question that the study answers.
pub(super) const QUESTION: &str =
    "Which method follows a smooth motion at least cost, for each stiffness and damping?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["work-precision"];

/// Level of error of the findings, and a larger one.
const LEVEL: f64 = 1e-2;
const ROUGH: f64 = 1e-1;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let parts = [count(facts), implicit(facts), leaders(facts)];
    let observations =
        [unranked(facts), noise(facts), by_energy(facts), beside(facts), retained(facts)];
    Words {
        conclusion: parts.into_iter().flatten().collect::<Vec<_>>().join(" "),
        observations: observations.into_iter().flatten().collect(),
        caveats: caveats(facts),
    }
}

/// The winner of a scene at an error; `None` if the error is too small to rank there.
pub(super) fn winner<'a>(facts: &'a Facts, scene: &Scene, level: f64) -> Option<&'a Winner> {
    facts.winners.iter().find(|winner| winner.scene == scene.id && winner.level == level)
}

/// The winners at an error on the damped sheets. Counts leave out the others: their modelled times
/// are guesses.
pub(super) fn counted(facts: &Facts, level: f64) -> impl Iterator<Item = &Winner> + Clone {
    let damped = facts.scenes.iter().filter(|scene| scene.is_damped());
    damped.filter_map(move |scene| winner(facts, scene, level))
}

/// The damped sheets on which an error ranks and is reached, each with the kind that leads.
fn kinds(facts: &Facts) -> Vec<(&Scene, Kind)> {
    let of = |scene| Some((scene, winner(facts, scene, LEVEL)?.kind()?));
    facts.scenes.iter().filter(|scene| scene.is_damped()).filter_map(of).collect()
}

fn error() -> String {
    percent(LEVEL, 1)
}

/// How often each kind leads.
fn count(facts: &Facts) -> Option<String> {
    let kinds = kinds(facts);
    let [explicit, implicit, tie] = tally(kinds.iter().map(|(_, kind)| *kind));
    let ranked = counted(facts, LEVEL).count();
    let missed = match ranked - kinds.len() {
        0 => String::new(),
        count => format!("; on {count} no method gets there within its budget"),
    };
    (!kinds.is_empty()).then(|| {
        format!(
            "For an error of {}, explicit methods lead by a factor of {LEAD} on {explicit} of \
             {ranked} damped sheets, implicit ones on {implicit}, and both kinds tie on \
             {tie}{missed}.",
            error()
        )
    })
}

/// The least stiffness with which implicit methods lead, and their least damping if others are
/// damped less.
fn implicit(facts: &Facts) -> Option<String> {
    let kinds = kinds(facts);
    let own = || kinds.iter().filter(|(_, kind)| *kind == Kind::Implicit).map(|(scene, _)| *scene);
    let least = |of: fn(&Scene) -> f64| own().map(of).reduce(f64::min);
    let stiffness = least(|scene| scene.stiffness_over_mass_per_s2)?;
    let ratio = least(|scene| scene.damping_ratio)?;
    let is_less = |(scene, _): &(&Scene, Kind)| {
        scene.stiffness_over_mass_per_s2 >= stiffness && scene.damping_ratio < ratio
    };
    let ratio = kinds.iter().any(is_less).then(|| {
        let ratio = significant(ratio, 2);
        format!(", and only where the stiffest mode has a damping ratio of at least {ratio}")
    });
    let (stiffness, ratio) = (power(stiffness), ratio.unwrap_or_default());
    Some(format!("Implicit methods lead only from k/m = {stiffness} s⁻² on{ratio}."))
}

/// On how many sheets noise prevents a ranking.
fn unranked(facts: &Facts) -> Option<String> {
    let noisy = facts.scenes.iter().filter(|scene| !scene.ranks(LEVEL)).count();
    (noisy > 0).then(|| {
        format!(
            "On {noisy} of {} sheets, an error of {} cannot be ranked: a start that differs by \
             1 µm changes the end by more than half of it.",
            facts.scenes.len(),
            error()
        )
    })
}

/// The id of a form's method: the label up to a comma.
pub(super) fn id(label: &str) -> &str {
    label.split(',').next().unwrap_or(label)
}

/// Methods that are the cheapest or tie for an error, with their numbers of damped sheets: the
/// largest first.
pub(super) fn frequent(facts: &Facts, level: f64) -> Vec<(&str, usize)> {
    frequent_among(counted(facts, level))
}

/// The same count for given winners.
fn frequent_among<'a>(winners: impl Iterator<Item = &'a Winner>) -> Vec<(&'a str, usize)> {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for winner in winners {
        let tied = winner.tied.iter().map(|tied| tied.label.as_str());
        let mut names: Vec<&str> =
            winner.label.as_deref().into_iter().chain(tied).map(id).collect();
        names.sort_unstable();
        names.dedup();
        for name in names {
            match counts.iter_mut().find(|(known, _)| *known == name) {
                Some((_, count)) => *count += 1,
                None => counts.push((name, 1)),
            }
        }
    }
    counts.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
    counts
}

/// The methods that are the cheapest or tie most often: where explicit or implicit methods lead, and
/// where both tie.
fn leaders(facts: &Facts) -> Option<String> {
    let most = |meant: Kind| {
        let counts = frequent_among(counted(facts, LEVEL).filter(|w| w.kind() == Some(meant)));
        let most = counts.first()?.1;
        let names: Vec<_> =
            counts.iter().take_while(|(_, count)| *count == most).map(|(name, _)| *name).collect();
        Some(names::methods(&names))
    };
    let places = [
        ("where explicit methods lead", Kind::Explicit),
        ("where implicit ones lead", Kind::Implicit),
        ("where both kinds tie", Kind::Tie),
    ];
    let parts: Vec<String> =
        places.into_iter().filter_map(|(at, of)| Some(format!("{} {at}", most(of)?))).collect();
    (!parts.is_empty()).then(|| format!("Cheapest or tied most often: {}.", parts.join("; ")))
}

/// The least and the greatest noise of a sheet.
fn noise(facts: &Facts) -> Option<String> {
    let of = |scene: &&Scene| scene.floor;
    let by = |a: &&Scene, b: &&Scene| of(a).total_cmp(&of(b));
    let (least, most) = (facts.scenes.iter().min_by(by)?.floor, facts.scenes.iter().max_by(by)?);
    let share = |floor: f64| format!("{} %", significant(100.0 * floor, 2));
    (facts.scenes.len() > 1).then(|| {
        format!(
            "A start that differs by 1 µm changes the end by {} to {} of the motion, most at {}.",
            share(least),
            share(most.floor),
            most.id
        )
    })
}

/// Runs of a scene.
pub(super) fn runs<'a>(
    facts: &'a Facts,
    scene: &'a Scene,
) -> impl Iterator<Item = (&'a Row, &'a Run)> + Clone {
    let rows = facts.rows.iter().filter(move |row| row.scene == scene.id);
    rows.flat_map(|row| row.runs.iter().map(move |run| (row, run)))
}

/// The run with the least modelled time, of those that `is_good` accepts.
pub(super) fn cheapest<'a>(
    runs: impl Iterator<Item = (&'a Row, &'a Run)>,
    is_good: impl Fn(&Run) -> bool,
) -> Option<(&'a Row, &'a Run)> {
    runs.filter(|(_, run)| is_good(run))
        .min_by(|(_, a), (_, b)| a.modelled_s.total_cmp(&b.modelled_s))
}

/// On how many sheets a ranking by energy has another winner than one by the trajectory. A sheet
/// that stands still keeps its energy, so a run must keep half of the motion.
fn by_energy(facts: &Facts) -> Option<String> {
    let mut all = 0;
    let mut others = 0;
    for scene in facts.scenes.iter().filter(|s| s.ranks(LEVEL) && s.energy_floor <= 0.5 * LEVEL) {
        let is_right = |beside: Beside| beside.energy.abs() <= LEVEL && beside.retained >= HALF;
        let good = |run: &Run| run.flaw.is_none() && run.beside.is_some_and(is_right);
        let Some(winner) = winner(facts, scene, LEVEL).filter(|w| w.label.is_some()) else {
            continue;
        };
        let Some((row, _)) = cheapest(runs(facts, scene), good) else { continue };
        let tied = winner.tied.iter().map(|tied| tied.label.as_str());
        let mut known = winner.label.as_deref().into_iter().chain(tied);
        all += 1;
        others += usize::from(!known.any(|label| id(label) == id(&row.label)));
    }
    let error = error();
    (all > 0).then(|| {
        format!(
            "On {others} of {all} sheets, a ranking by final energy (error at most {error}) has \
             another winner than a ranking by trajectory."
        )
    })
}

/// The other errors of runs that follow the trajectory and have no flaw.
fn beside(facts: &Facts) -> Option<String> {
    let good = facts.scenes.iter().filter(|scene| scene.ranks(LEVEL)).flat_map(|scene| {
        let own = runs(facts, scene).map(|(_, run)| run);
        own.filter(|run| run.is_good(LEVEL))
    });
    let good: Vec<_> = good.filter_map(|run| run.beside).collect();
    let most = |of: fn(&Beside) -> f64| good.iter().map(of).reduce(f64::max);
    Some(format!(
        "Runs that may win at {} are off by up to {} mm in shape, {} % in strain and {} % in energy.",
        error(),
        significant(1e3 * most(|b| b.shape_m)?, 2),
        significant(100.0 * most(|b| b.strain.abs())?, 2),
        significant(100.0 * most(|b| b.energy.abs())?, 2)
    ))
}

/// The share of the motion that runs near the trajectory keep.
fn retained(facts: &Facts) -> Option<String> {
    let all = facts.rows.iter().flat_map(|row| &row.runs);
    let shown = all.filter(|run| !run.skips_pictures());
    let near = shown.filter(|run| run.error.is_some_and(|error| error <= ROUGH));
    let kept: Vec<f64> = near.filter_map(|run| Some(run.beside?.retained)).collect();
    let kept = names::range(&kept, |share| significant(share, 3))?;
    Some(format!("Runs within {} of the trajectory keep {kept} of the motion.", percent(ROUGH, 1)))
}

fn caveats(facts: &Facts) -> Vec<String> {
    let ranked = counted(facts, LEVEL).filter(|winner| winner.label.is_some());
    let ties = ranked.clone().filter(|winner| !winner.tied.is_empty()).count();
    let narrow = ranked.clone().filter(|winner| winner.is_narrow).count();
    let mut caveats = vec![
        format!(
            "Steps are powers of two and modelled time is off by some per cent, so a lead below a \
             factor of {LEAD} is a tie: {ties} of {} winners lead by less. {narrow} more would tie \
             if the error could be a tenth larger.",
            ranked.count()
        ),
        "The motion is short and smooth, without contact: `animation-long` asks about five seconds and \
         `rest` about where cloth comes to lie."
            .to_owned(),
    ];
    let others = [budget(facts), coarsest(facts), flawed(facts), undamped(facts), small(facts)];
    caveats.extend(others.into_iter().flatten());
    caveats
}

/// How much of the budget the slowest winner takes.
fn budget(facts: &Facts) -> Option<String> {
    let budget = facts.scenes.iter().map(|scene| scene.budget_s).reduce(f64::max)?;
    Some(format!(
        "Every run has at least {budget} s of modelled time, and the slowest winner takes {} s: \
         of slower methods only the least delay is known.",
        significant(slowest(facts)?, 2)
    ))
}

/// The modelled time of the slowest winner, s.
fn slowest(facts: &Facts) -> Option<f64> {
    let named = facts.winners.iter().filter(|winner| winner.label.is_some());
    named.filter_map(|winner| winner.modelled_s).reduce(f64::max)
}

/// How often the winner takes the longest step that may win, and how often a longer one is cheaper.
fn coarsest(facts: &Facts) -> Option<String> {
    let ranked = || facts.winners.iter().filter(|winner| winner.label.is_some());
    let is_longest = |winner: &&Winner| {
        let step = winner.run(&facts.rows).and_then(|run| run.step_s);
        step.is_some_and(|step| 2.0 * step > PICTURE_S)
    };
    let longest = ranked().filter(is_longest).count();
    let skipped = overtaken(ranked(), &facts.rows, |flaw| flaw == Flaw::SkipsPictures);
    (longest + skipped > 0).then(|| {
        format!(
            "{longest} of {} winners take the longest step that may win, with a state for each \
             picture of a film; their errors may be far smaller than asked for. {skipped} winners \
             have a cheaper run with longer steps, which shows the end and not the motion. Its \
             time is extrapolated: prices were fitted to runs of eight steps and more.",
            ranked().count()
        )
    })
}

/// How often a run with a flaw would have won.
fn flawed(facts: &Facts) -> Option<String> {
    let at = |level: f64| {
        let own = facts.winners.iter().filter(move |winner| winner.level == level);
        saved(own, &facts.rows)
    };
    let (rough, small) = (at(ROUGH), at(LEVEL));
    (rough + small > 0).then(|| {
        format!(
            "On {rough} sheets at {} and on {small} at {} a cheaper run is near the true end, but it \
             has gained energy or hardly moves. Such runs do not win.",
            percent(ROUGH, 1),
            error()
        )
    })
}

/// The sheets that the counts leave out.
fn undamped(facts: &Facts) -> Option<String> {
    let count = facts.scenes.iter().filter(|scene| !scene.is_damped()).count();
    (count > 0).then(|| {
        format!(
            "Counts leave out the {count} sheets without damping: prices of work were fitted to \
             damped sheets, so modelled times without damping are guesses."
        )
    })
}

/// Where sheets are smaller than usual, and where one hardly moves.
fn small(facts: &Facts) -> Option<String> {
    let particles = || facts.scenes.iter().map(|scene| scene.particles);
    let (least, most) = (particles().min()?, particles().max()?);
    let small = facts.scenes.iter().filter(|scene| scene.particles == least);
    let from = small.map(|scene| scene.stiffness_over_mass_per_s2).reduce(f64::min)?;
    let slowest = facts.scenes.iter().min_by(|a, b| a.motion_m.total_cmp(&b.motion_m))?;
    (least < most).then(|| {
        format!(
            "From k/m = {} s⁻² on sheets have {least} particles, below {most}: a column is not one \
             cloth at another stiffness. At {} the sheet moves only {} mm in {} s.",
            power(from),
            slowest.id,
            significant(1e3 * slowest.motion_m, 1),
            slowest.span_s
        )
    })
}

#[cfg(test)]
mod tests;
