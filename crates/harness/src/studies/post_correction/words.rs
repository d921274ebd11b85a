//! The words of the study `post-correction`: its question, and the findings from its numbers.

use super::facts::{
    DEPENDS, FORWARD, Facts, PERTURBED, Row, forward, groups, key, spread, usual_step,
};
use drape_report::number::significant;
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str =
    "Is a soft sheet whose springs are shortened after each step a stiff sheet?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["course"];

/// Change of momentum that round-off may cause, over mass and speed.
const ROUND_OFF: f64 = 1e-13;
/// A residual counts as falling with the step if it falls to this share or below.
const FALLS: f64 = 0.5;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion: Vec<_> = [approach(facts), residual(facts)].into_iter().flatten().collect();
    let conclusion = match &conclusion[..] {
        [] => "No corrected sheet was run.".to_owned(),
        sentences => sentences.join(" "),
    };
    let observations = [order(facts), kept(facts), energy(facts), spins(facts), sweeps(facts)];
    let observations = observations.into_iter().flatten().collect();
    Words { conclusion, observations, caveats: caveats(facts) }
}

/// The least and the greatest of some values, with two digits.
fn range(values: impl Iterator<Item = f64> + Clone) -> Option<(String, String)> {
    let least = values.clone().reduce(f64::min)?;
    let most = values.reduce(f64::max)?;
    Some((significant(least, 2), significant(most, 2)))
}

/// Whether narrower limits bring the soft sheet nearer to the stiff one, by mesh, method and
/// sweeps.
fn approach(facts: &Facts) -> Option<String> {
    type Series<'a> = ((&'a str, &'a str, u32), Vec<f64>);
    let mut series: Vec<Series<'_>> = Vec::new();
    for ((mesh, label, _, sweeps), rows) in groups(facts) {
        let last = rows.iter().find(|row| row.order == FORWARD).and_then(|row| row.distance.last());
        let Some(&last) = last else { continue };
        let of = (mesh, label, sweeps);
        match series.iter_mut().find(|(known, _)| *known == of) {
            Some((_, distances)) => distances.push(last),
            None => series.push((of, vec![last])),
        }
    }
    series.retain(|(_, distances)| distances.len() > 1);
    let falls = |distances: &[f64]| distances.windows(2).all(|pair| pair[1] <= pair[0]);
    let nearer = series.iter().filter(|(_, distances)| falls(distances)).count();
    let left = series.iter().filter_map(|(_, distances)| distances.last().copied());
    let left = left.reduce(f64::min);
    let Some(left) = left else {
        let all = forward(facts).filter_map(|row| row.distance.last().copied());
        let left = significant(100.0 * all.reduce(f64::min)?, 2);
        return Some(format!(
            "The corrected sheet ends at least {left} % of the motion away from the stiff one."
        ));
    };
    let left = significant(100.0 * left, 2);
    Some(match nearer {
        0 => format!(
            "No: narrower limits do not bring the corrected sheet nearer to the stiff one, which \
             stays at least {left} % of the motion \
             away."
        ),
        n => format!(
            "No: in {n} of {} series, every narrower limit brings the corrected sheet nearer to \
             the stiff one, but it stays at least {left} % of the motion away.",
            series.len()
        ),
    })
}

/// The residual of the differential equation, at the usual step and at shorter ones.
fn residual(facts: &Facts) -> Option<String> {
    let least = forward(facts).map(|row| row.residual).reduce(f64::min)?;
    let step = usual_step(facts);
    let shorter = facts.rows.iter().filter(|row| row.step_s < step);
    let mut tried = shorter.clone().peekable();
    let usual = |row: &Row| forward(facts).find(|usual| key(usual) == key(row));
    let is_less = |row: &Row| usual(row).is_some_and(|usual| row.residual < FALLS * usual.residual);
    let verdict = match tried.peek() {
        None => "",
        Some(_) if shorter.clone().any(is_less) => ", though it falls with the step",
        Some(_) => ", and it does not vanish with the step",
    };
    let size = if least >= 1.0 { ": as large as all forces" } else { "" };
    Some(format!(
        "The residual of its equation of motion is at least {} of the forces{size}{verdict}.",
        significant(least, 2)
    ))
}

fn order(facts: &Facts) -> Option<String> {
    let last: Vec<f64> =
        groups(facts).iter().filter_map(|(_, rows)| spread(rows).last().copied()).collect();
    let depends = last.iter().filter(|distance| **distance > DEPENDS).count();
    let most = last.iter().copied().reduce(f64::max)?;
    let disturbed = facts.rows.iter().filter(|row| row.order == PERTURBED);
    let disturbed = disturbed.flat_map(|row| &row.order_distance).copied().reduce(f64::max);
    let disturbed = disturbed.map_or_else(String::new, |distance| {
        format!("; a disturbed start changes it by at most {} %", significant(100.0 * distance, 1))
    });
    Some(format!(
        "The order of the sweep decides where the sheet ends in {depends} of {} groups, by up to \
         {} % of the motion{disturbed}.",
        last.len(),
        significant(100.0 * most, 2)
    ))
}

fn kept(facts: &Facts) -> Option<String> {
    let mut over: Vec<f64> = forward(facts).map(|row| row.elongation / row.limit).collect();
    over.sort_by(f64::total_cmp);
    let (least, most) = range(over.iter().copied())?;
    Some(format!("The longest spring is {least} to {most} times as elongated as the limit allows."))
}

fn energy(facts: &Facts) -> Option<String> {
    let given = forward(facts).map(|row| row.energy_given).reduce(f64::max)?;
    let taken = forward(facts).map(|row| row.energy_taken).reduce(f64::max)?;
    let held: Vec<_> = forward(facts).map(|row| 100.0 * row.weight_held).collect();
    let (least, most) = range(held.iter().copied())?;
    Some(format!(
        "Corrections carry {least} to {most} % of the weight; they add up to {} % of the energy of \
         the fall and remove up to {} %.",
        significant(100.0 * given, 2),
        significant(100.0 * taken, 2)
    ))
}

fn spins(facts: &Facts) -> Option<String> {
    let momentum = facts.spins.iter().map(|spin| spin.momentum_change).reduce(f64::max)?;
    let corrected = facts.spins.iter().filter(|spin| spin.limit.is_some());
    let left = corrected.map(|spin| spin.angular_momentum_left).reduce(f64::min)?;
    let kept = if momentum < ROUND_OFF { "keep the momentum" } else { "do not keep the momentum" };
    Some(format!(
        "Corrections {kept} of a free sheet, but leave as little as {} % of its angular momentum \
         after a second.",
        significant(100.0 * left, 2)
    ))
}

fn sweeps(facts: &Facts) -> Option<String> {
    let met = facts.sweeps.iter().filter(|run| run.met().is_some()).count();
    let most = facts.sweeps.iter().filter_map(|run| run.sweeps.last()).max()?;
    let worse =
        |run: &&super::facts::Sweeps| run.elongation.first().is_some_and(|left| *left > run.before);
    let all = facts.sweeps.len();
    Some(format!(
        "{met} of {all} stretched sheets meet the limit within {most} sweeps; the first sweep \
         lengthens the longest spring in {}.",
        facts.sweeps.iter().filter(worse).count()
    ))
}

fn caveats(facts: &Facts) -> Vec<String> {
    let errors = facts.meshes.iter().flat_map(|mesh| &mesh.reference_error).copied();
    let reference = errors.reduce(f64::max).map(|error| {
        format!(
            "The stiff sheet's own error is up to {} % of the motion.",
            significant(100.0 * error, 1)
        )
    });
    let own = forward(facts).map(|row| row.uncorrected_residual).reduce(f64::max);
    let own = own.filter(|residual| *residual > ROUND_OFF).map(|residual| {
        format!(
            "Without correction the step itself leaves a residual of up to {}.",
            significant(residual, 2)
        )
    });
    let diverged = facts.rows.iter().filter(|row| row.verdict != Verdict::Completed).count();
    let diverged =
        (diverged > 0).then(|| format!("{diverged} of {} runs diverged.", facts.rows.len()));
    [reference, own, diverged].into_iter().flatten().collect()
}
