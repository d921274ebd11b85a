//! The words of the study `animation`: its question, and what its numbers say.

use super::facts::{Facts, GOOD, Run, Scene};
use drape_report::number::significant;
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str =
    "What must be paid for a frame that neither explodes, stands still nor shows a wrong shape?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["locking", "work-precision"];

/// Most names in a sentence.
const MOST: usize = 8;

/// What the facts say. Times belong to a machine and stand in the figures.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion = [in_one_call(facts), explicit(facts)].into_iter().flatten();
    let conclusion = conclusion.collect::<Vec<_>>().join(" ");
    let observations =
        [nearest(facts), still(facts), gaining(facts), never(facts)].into_iter().flatten();
    Words { conclusion, observations: observations.collect(), caveats: caveats(facts) }
}

fn runs<'a>(facts: &'a Facts, scene: &'a Scene) -> impl Iterator<Item = &'a Run> + Clone {
    facts.runs.iter().filter(move |run| run.scene == scene.id)
}

/// All labels, in the record's order.
fn labels(facts: &Facts) -> Vec<&str> {
    let mut labels: Vec<&str> = Vec::new();
    for run in &facts.runs {
        if !labels.contains(&run.label.as_str()) {
            labels.push(&run.label);
        }
    }
    labels
}

/// Names in a row, the first few by name.
fn listed(names: &[&str]) -> String {
    match names {
        [] => "none".to_owned(),
        names if names.len() > MOST => {
            format!("{} and {} more", names[..MOST].join("; "), names.len() - MOST)
        }
        names => names.join("; "),
    }
}

/// The forms for which one call a frame is enough in the most scenes.
fn in_one_call(facts: &Facts) -> Option<String> {
    let is_good = |label: &str, scene: &Scene| {
        let mut once = runs(facts, scene).filter(|run| run.label == label && run.substeps == 1);
        once.any(|run| run.is_good(scene))
    };
    let good: Vec<(&str, usize)> = labels(facts)
        .into_iter()
        .map(|label| (label, facts.scenes.iter().filter(|scene| is_good(label, scene)).count()))
        .collect();
    let (all, most) = (facts.scenes.len(), good.iter().map(|(_, count)| *count).max()?);
    let names: Vec<_> =
        good.iter().filter(|(_, count)| *count == most).map(|(label, _)| *label).collect();
    let enough = format!("to {} mm or twice the noise", significant(1e3 * GOOD, 2));
    Some(match most {
        0 => format!("One call a frame is enough for no form, {enough}."),
        most if most == all => {
            format!("One call a frame is enough in every scene, {enough}, for {}.", listed(&names))
        }
        most => format!(
            "One call a frame, {enough}, is enough in at most {most} of {all} scenes: for {}.",
            listed(&names)
        ),
    })
}

/// How many calls explicit forms need.
fn explicit(facts: &Facts) -> Option<String> {
    let least = |scene: &Scene| {
        let own = runs(facts, scene).filter(|run| run.is_good(scene) && run.is_limited);
        own.map(|run| run.substeps).min()
    };
    let needs: Vec<_> = facts
        .scenes
        .iter()
        .filter_map(|scene| Some(format!("{} on {}", least(scene)?, scene.id)))
        .collect();
    (!needs.is_empty()).then(|| {
        format!(
            "Steps that stiffness limits need these calls a frame at least: {}.",
            needs.join(", ")
        )
    })
}

/// The nearest motion with one call.
fn nearest(facts: &Facts) -> Option<String> {
    let best = |scene: &Scene| {
        let own = runs(facts, scene).filter(|run| run.substeps == 1 && run.is_sound());
        let own = own.filter_map(|run| Some((scene.error(run)?, run)));
        let (error, run) = own.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let (error, floor) = (1e3 * error, 1e3 * scene.floor_m());
        Some(format!(
            "{} {} mm ({}, noise {} mm)",
            run.label,
            significant(error, 2),
            scene.id,
            significant(floor, 2)
        ))
    };
    let all: Vec<_> = facts.scenes.iter().filter_map(best).collect();
    (!all.is_empty()).then(|| format!("The nearest with one call a frame are: {}.", all.join("; ")))
}

/// Forms that stand still at one call a frame somewhere.
fn still(facts: &Facts) -> Option<String> {
    let is_still = |label: &&str| {
        let mut own = facts.runs.iter().filter(|run| run.label == **label && run.substeps == 1);
        own.any(|run| run.verdict == Verdict::Locked)
    };
    let still: Vec<_> = labels(facts).into_iter().filter(is_still).collect();
    (!still.is_empty()).then(|| {
        format!(
            "Forms that lose more than half of the motion with one call a frame: {} ({}).",
            still.len(),
            listed(&still)
        )
    })
}

/// Forms that gain energy although stiffness does not limit them.
fn gaining(facts: &Facts) -> Option<String> {
    let gains = |run: &&Run| {
        !run.is_limited
            && run.substeps <= 4
            && matches!(run.verdict, Verdict::Marginal | Verdict::Unstable | Verdict::Diverged)
    };
    let names = labels(facts);
    let gaining: Vec<_> = names
        .into_iter()
        .filter(|label| facts.runs.iter().any(|run| run.label == *label && gains(&run)))
        .collect();
    (!gaining.is_empty()).then(|| {
        format!(
            "Forms that gain energy with one to four calls a frame: {} ({}).",
            gaining.len(),
            listed(&gaining)
        )
    })
}

/// Forms that are good nowhere.
fn never(facts: &Facts) -> Option<String> {
    let is_good = |label: &str| {
        facts
            .scenes
            .iter()
            .any(|scene| runs(facts, scene).any(|run| run.label == label && run.is_good(scene)))
    };
    let never: Vec<_> = labels(facts).into_iter().filter(|label| !is_good(label)).collect();
    (!never.is_empty())
        .then(|| format!("No number of calls that was tried suits {}.", listed(&never)))
}

fn caveats(facts: &Facts) -> Vec<String> {
    let floors: Vec<_> = facts
        .scenes
        .iter()
        .map(|scene| format!("{} mm ({})", significant(1e3 * scene.floor_m(), 2), scene.id))
        .collect();
    let spans: Vec<_> = facts.scenes.iter().map(|scene| scene.span_s).collect();
    let longest = spans.iter().copied().fold(0.0, f64::max);
    vec![
        format!(
            "One micrometre at the start moves what ranks by {}: smaller errors rank nothing.",
            floors.join(", ")
        ),
        format!("A scene lasts {} s at most; cloth that folds for longer is noise.", longest),
        "A form is one choice of settings; tuning may move it.".to_owned(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        Scene {
            id: "s".to_owned(),
            fabric: "denim".to_owned(),
            measure: super::super::facts::Measure::Shape,
            particles: 4,
            springs: 4,
            stiffness_n_per_m: 1.0,
            stiffness_over_mass_per_s2: 1.0,
            theta: 1.0,
            damping_over_stiffness_s: 0.0,
            frames_per_s: 60,
            span_s: 2.0,
            limit_substeps: 40,
            reference_substeps: 160,
            members: 2,
            shape_floor_m: 1e-4,
            trajectory_floor_m: 1e-4,
            reference_error_m: 1e-5,
            strain: 0.01,
            released_j: 1.0,
            prestress: 0.0,
            portable: true,
        }
    }

    fn run(label: &str, substeps: u32, verdict: Verdict, error: f64) -> Run {
        Run {
            scene: "s".to_owned(),
            label: label.to_owned(),
            method: label.to_owned(),
            substeps,
            is_limited: substeps > 8,
            verdict,
            shape_error_m: Some(error),
            trajectory_error_m: Some(error),
            excess_strain: Some(0.0),
            retained: Some(1.0),
            kinetic: Some(1.0),
            gain: 0.0,
            force_evaluations: 1,
            matvecs: 0,
            factorisations: 0,
            newton_iterations: 0,
            cg_iterations: 0,
            unconverged_steps: 0,
            portable: true,
        }
    }

    #[test]
    fn what_is_enough_is_told_from_what_locks_gains_or_errs() {
        let runs = vec![
            run("good", 1, Verdict::Stable, 0.002),
            run("wrong", 1, Verdict::Stable, 0.02),
            run("wrong", 4, Verdict::Stable, 0.005),
            run("still", 1, Verdict::Locked, 0.3),
            run("loud", 1, Verdict::Unstable, 0.001),
            run("explicit", 48, Verdict::Stable, 0.0001),
        ];
        let said = words(&Facts { scenes: vec![scene()], runs });
        assert_eq!(
            said.conclusion,
            "One call a frame is enough in every scene, to 10 mm or twice the noise, for good. \
             Steps that stiffness limits need these calls a frame at least: 48 on s."
        );
        let all = said.observations.join(" ");
        for sentence in [
            "good 2.0 mm (s, noise 0.10 mm)",
            "lose more than half of the motion with one call a frame: 1 (still).",
            "gain energy with one to four calls a frame: 1 (loud).",
            "suits still; loud.",
        ] {
            assert!(all.contains(sentence), "{sentence}: {all}");
        }
    }
}
