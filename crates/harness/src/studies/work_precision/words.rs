//! The words of the study `work-precision`: its question, and the findings from its numbers.

use super::facts::{
    Facts, Kind, LEAD, Row, STIFFNESS, Scene, Winner, cheapest, rows_of, saved, tally,
};
use drape_report::Words;
use drape_report::number::{percent, power, setting, significant};

/// The question that the study answers.
pub(super) const QUESTION: &str = "Which method is the cheapest for a given error, and how do \
                                   stiffness, damping and size change the answer?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["order", "stability", "locking"];

/// Level of error of the conclusion.
const LEVEL: f64 = 1e-2;
/// Levels of error of an observation: a large one and a small one.
const BESIDE: [f64; 2] = [1e-1, 1e-3];

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusions = [
        ("light", light(facts)),
        ("heavy", "On the hanging sheet with heavy damping, d/m = √(k/m),".to_owned()),
    ];
    let conclusions: Vec<_> =
        conclusions.iter().filter_map(|(damping, begin)| turn(facts, damping, begin)).collect();
    let conclusion = if conclusions.is_empty() {
        format!("No method reaches an error of {} on a hanging sheet.", percent(LEVEL, 1))
    } else {
        format!(
            "In `work-precision` a kind of method, explicit or implicit, leads if its best one needs \
             less than half of the modelled time of the other kind's, for an error of {}. {}",
            percent(LEVEL, 1),
            conclusions.join(" ")
        )
    };
    let observations = [levels(facts), shapes(facts), sizes(facts), adaptive(facts), missed(facts)];
    Words {
        conclusion,
        observations: observations.into_iter().flatten().collect(),
        caveats: caveats(facts),
    }
}

/// The begin of a sentence on light damping, with its value if all hanging sheets share one.
fn light(facts: &Facts) -> String {
    let values: Vec<f64> =
        series(facts, "light").iter().map(|scene| scene.damping_over_mass_per_s).collect();
    match values.split_first() {
        Some((first, others)) if others.iter().all(|other| other == first) => {
            format!("On the hanging sheet with light damping, d/m = {} s⁻¹,", setting(*first))
        }
        _ => "On the hanging sheet with light damping,".to_owned(),
    }
}

fn winner<'a>(facts: &'a Facts, scene: &Scene, level: f64) -> Option<&'a Winner> {
    facts.winners.iter().find(|winner| winner.scene == scene.id && winner.level == level)
}

/// The kind that leads on a scene; a tie where a method of the other kind costs less than [`LEAD`]
/// times as much.
fn kind(facts: &Facts, scene: &Scene, level: f64) -> Option<Kind> {
    winner(facts, scene, level)?.kind()
}

/// The hanging sheets with one kind of damping, softest first.
fn series<'a>(facts: &'a Facts, damping: &str) -> Vec<&'a Scene> {
    let is_in = |scene: &&Scene| {
        let is_series = scene.series.iter().any(|series| series == STIFFNESS);
        scene.scene == "hanging" && scene.damping == damping && is_series
    };
    let mut scenes: Vec<_> = facts.scenes.iter().filter(is_in).collect();
    scenes.sort_by(|a, b| a.stiffness_over_mass_per_s2.total_cmp(&b.stiffness_over_mass_per_s2));
    scenes
}

/// Which kind leads on the hanging sheet, and from which stiffness on.
fn turn(facts: &Facts, damping: &str, begin: &str) -> Option<String> {
    let known =
        |scene: &&Scene| Some((scene.stiffness_over_mass_per_s2, kind(facts, scene, LEVEL)?));
    let kinds: Vec<_> = series(facts, damping).iter().filter_map(known).collect();
    let (first, last) = (kinds.first()?, kinds.last()?);
    let all = |kind: Kind| kinds.iter().all(|(_, other)| *other == kind);
    let place = match kinds.len() {
        1 => format!("at k/m = {} s⁻²", power(first.0)),
        _ => "at every stiffness".to_owned(),
    };
    let explicit = kinds.iter().rposition(|(_, kind)| *kind == Kind::Explicit);
    let implicit = kinds.iter().position(|(_, kind)| *kind == Kind::Implicit);
    Some(match (explicit, implicit) {
        (Some(_), _) if all(Kind::Explicit) => format!("{begin} explicit methods lead {place}."),
        (_, Some(_)) if all(Kind::Implicit) => format!("{begin} implicit methods lead {place}."),
        (Some(turn), Some(from)) if turn < from => {
            let (turn, from) = (power(kinds[turn].0), power(kinds[from].0));
            format!(
                "{begin} explicit methods lead only up to k/m = {turn} s⁻², implicit ones only from \
                 {from} s⁻² on."
            )
        }
        (Some(_), Some(_)) => {
            format!(
                "{begin} now explicit, now implicit methods lead from {} to {} s⁻².",
                power(first.0),
                power(last.0)
            )
        }
        (Some(turn), None) => {
            let turn = power(kinds[turn].0);
            format!(
                "{begin} explicit methods lead only up to k/m = {turn} s⁻², implicit ones nowhere."
            )
        }
        (None, Some(from)) => {
            let from = power(kinds[from].0);
            format!(
                "{begin} implicit methods lead only from k/m = {from} s⁻² on, explicit ones nowhere."
            )
        }
        (None, None) => format!("{begin} explicit and implicit methods tie {place}."),
    })
}

/// On how many scenes each kind leads at an error of `level`; `None` if no run reaches it on any.
fn leads<'a>(
    facts: &Facts,
    scenes: impl Iterator<Item = &'a Scene>,
    level: f64,
) -> Option<[usize; 3]> {
    let kinds: Vec<_> = scenes.filter_map(|scene| kind(facts, scene, level)).collect();
    (!kinds.is_empty()).then(|| tally(kinds.iter().copied()))
}

/// The sentence about leads that have been counted.
fn told([explicit, implicit, tie]: [usize; 3]) -> String {
    let all = explicit + implicit + tie;
    format!(
        "explicit methods lead in {explicit} of {all} scenes, implicit ones in {implicit}, and \
         both kinds tie in {tie}"
    )
}

/// How the leads differ between a large error and a small one.
fn levels(facts: &Facts) -> Option<String> {
    let at = |level| {
        let leads = leads(facts, facts.scenes.iter(), level)?;
        Some(format!("for {} {}", percent(level, 1), told(leads)))
    };
    let [rough, small] = BESIDE.map(at);
    Some(format!("In all scenes, {}; {}.", rough?, small?))
}

fn shapes(facts: &Facts) -> Option<String> {
    let others = facts.scenes.iter().filter(|scene| scene.scene != "hanging");
    let leads = leads(facts, others, LEVEL)?;
    let error = percent(LEVEL, 1);
    Some(format!("On the thrown and the spread sheet, for {error}, {}.", told(leads)))
}

fn sizes(facts: &Facts) -> Option<String> {
    let is_sized = |scene: &&Scene| scene.series.iter().any(|series| series != STIFFNESS);
    let leads = leads(facts, facts.scenes.iter().filter(is_sized), LEVEL)?;
    let particles = || facts.scenes.iter().filter(is_sized).map(|scene| scene.particles);
    let (least, most) = (particles().min()?, particles().max()?);
    let error = percent(LEVEL, 1);
    (least < most)
        .then(|| format!("From {least} to {most} particles, for {error}, {}.", told(leads)))
}

/// What DOP853 costs. Its rows are those whose runs have no step length.
fn adaptive(facts: &Facts) -> Option<String> {
    let is_adaptive = |row: &&Row| row.runs.iter().all(|run| run.step_s.is_none());
    let mut ratios = Vec::new();
    for scene in series(facts, "light") {
        let rows = || rows_of(facts, &scene.id);
        let (Some((_, least)), true) = (cheapest(rows(), LEVEL), rows().any(|r| is_adaptive(&r)))
        else {
            continue;
        };
        let own = cheapest(rows().filter(is_adaptive), LEVEL);
        ratios
            .extend(own.map(|(row, run)| (run.modelled_s / least.modelled_s, row.label.as_str())));
    }
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (least, most) = (ratios.first()?, ratios.last()?);
    Some(format!(
        "`{}`, the adaptive method of the references, costs {} to {} times as much as the cheapest \
         method for {}, where it reaches that error.",
        least.1,
        significant(least.0, 2),
        significant(most.0, 2),
        percent(LEVEL, 1)
    ))
}

/// How many variants spend their budget on larger errors, at the stiffness where most do.
fn missed(facts: &Facts) -> Option<String> {
    let count = |scene: &&Scene| {
        let rows = rows_of(facts, &scene.id);
        rows.filter(|row| row.misses(LEVEL)).count()
    };
    let scene = series(facts, "light").into_iter().max_by_key(count)?;
    (count(&scene) > 0).then(|| {
        format!(
            "At k/m = {} s⁻² with light damping, {} of {} variants exhaust their budget before \
             they reach an error of {}.",
            power(scene.stiffness_over_mass_per_s2),
            count(&scene),
            rows_of(facts, &scene.id).count(),
            percent(LEVEL, 1)
        )
    })
}

fn caveats(facts: &Facts) -> Vec<String> {
    let at_level = || facts.winners.iter().filter(|w| w.level == LEVEL && w.label.is_some());
    let ties = at_level().filter(|winner| winner.ratio.is_some_and(|ratio| ratio < LEAD)).count();
    let narrow = at_level().filter(|winner| winner.is_narrow).count();
    let worst = facts.scenes.iter().map(|scene| scene.reference_error).fold(0.0, f64::max);
    let mut caveats = vec![
        format!(
            "Steps are powers of two, so a lead below a factor of 2 is a tie: {ties} of {} \
             winners lead by less. {narrow} more would tie if the error could be a tenth larger.",
            at_level().count()
        ),
        "Modelled time is counted work times its price; each form's prices were measured on \
         one machine. The table of prices compares each form's model with the clock."
            .to_owned(),
        format!(
            "Errors are measured at the end of a short motion; the references are off by at most \
             {} of it.",
            significant(worst, 2)
        ),
    ];
    caveats.extend(noise(facts));
    caveats.extend(flawed(facts));
    caveats
}

/// Where noise prevents a ranking.
fn noise(facts: &Facts) -> Option<String> {
    let most = facts.scenes.iter().max_by(|a, b| a.floor.total_cmp(&b.floor))?;
    let least = BESIDE.into_iter().fold(LEVEL, f64::min);
    let noisy = facts.scenes.iter().filter(|scene| !scene.ranks(least)).count();
    (most.floor > 0.0).then(|| {
        format!(
            "In {noisy} of {} scenes an error of {} is noise: a start that differs by 1 µm changes \
             the end by more than half of it. At most it changes the end by {} % of the motion \
             ({}).",
            facts.scenes.len(),
            percent(least, 1),
            significant(100.0 * most.floor, 2),
            most.id
        )
    })
}

/// How often a run with a flaw would have won.
fn flawed(facts: &Facts) -> Option<String> {
    let count = saved(facts.winners.iter(), &facts.rows);
    (count > 0).then(|| {
        format!(
            "At {count} of {} places a cheaper run is near the true end, but it has gained energy \
             or hardly moves. Such runs do not win.",
            facts.winners.len()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::facts::Tied;
    use super::*;

    fn scene(damping: &str, stiffness: f64) -> Scene {
        Scene {
            id: format!("{damping} {stiffness:e}"),
            scene: "hanging".to_owned(),
            damping: damping.to_owned(),
            series: vec![STIFFNESS.to_owned()],
            particles: 400,
            springs: 1482,
            stiffness_over_mass_per_s2: stiffness,
            damping_over_mass_per_s: 10.0,
            greatest_frequency_per_s: 1e3,
            span_s: 0.25,
            motion_m: 0.1,
            reference_error: 1e-11,
            reference_tolerance: 1e-10,
            floor: 0.0,
            energy_floor: 0.0,
            budget: 1e9,
        }
    }

    /// Lightly damped scenes at k/m = 1, 10, …, each with its winner's kind, runner-up's kind and
    /// lead.
    fn facts(damping: &str, winners: &[(bool, bool, f64)]) -> Facts {
        let mut facts = Facts { scenes: Vec::new(), rows: Vec::new(), winners: Vec::new() };
        let label = |is_explicit: bool| if is_explicit { "fast" } else { "firm" }.to_owned();
        for (n, &(is_explicit, is_second_explicit, ratio)) in winners.iter().enumerate() {
            let scene = scene(damping, f64::powi(10.0, n as i32));
            let tied = (ratio < LEAD).then(|| Tied {
                label: label(is_second_explicit),
                is_explicit: is_second_explicit,
                ratio,
            });
            facts.winners.push(Winner {
                scene: scene.id.clone(),
                level: LEVEL,
                label: Some(label(is_explicit)),
                is_explicit: Some(is_explicit),
                value: Some(1.0),
                modelled_s: Some(1.0),
                energy: None,
                retained: None,
                runner_up: Some(label(is_second_explicit)),
                ratio: Some(ratio),
                tied: tied.into_iter().collect(),
                is_narrow: false,
            });
            facts.scenes.push(scene);
        }
        facts
    }

    #[test]
    fn the_conclusion_says_where_which_kind_leads() {
        let (explicit, implicit) = ((true, true, 3.0), (false, false, 3.0));
        let tie = (true, false, 1.5);
        for (winners, said) in [
            (&[explicit, explicit][..], "explicit methods lead at every stiffness."),
            (&[implicit, implicit], "implicit methods lead at every stiffness."),
            (&[explicit], "explicit methods lead at k/m = 1 s⁻²."),
            (
                &[explicit, tie, implicit],
                "explicit methods lead only up to k/m = 1 s⁻², implicit ones only from 10² s⁻² on.",
            ),
            (&[implicit, explicit], "now explicit, now implicit methods lead from 1 to 10 s⁻²."),
            (&[explicit, tie, implicit, explicit], "now explicit, now implicit"),
            (&[tie, implicit], "implicit methods lead only from k/m = 10 s⁻² on, explicit ones no"),
            (&[explicit, tie], "explicit methods lead only up to k/m = 1 s⁻², implicit ones no"),
        ] {
            for (damping, begin) in [
                ("light", "On the hanging sheet with light damping, d/m = 10 s⁻¹, "),
                ("heavy", "On the hanging sheet with heavy damping, d/m = √(k/m), "),
            ] {
                let conclusion = words(&facts(damping, winners)).conclusion;
                let first = "In `work-precision` a kind of method, explicit or implicit, leads if \
                             its best one needs less than half of the modelled time of the other \
                             kind's, for an error of 1 %.";
                let all = format!("{first} {begin}{said}");
                assert!(conclusion.starts_with(&all), "{conclusion}");
            }
        }
        let words = words(&facts("light", &[tie]));
        assert!(words.conclusion.contains("explicit and implicit methods tie at k/m"), "{words:?}");
        assert!(words.caveats[0].contains("1 of 1 winners lead by less"), "{words:?}");
    }

    #[test]
    fn without_any_winner_it_says_so() {
        let mut facts = facts("light", &[(true, true, 3.0)]);
        facts.winners[0].label = None;
        facts.winners[0].is_explicit = None;
        let words = words(&facts);
        assert_eq!(words.conclusion, "No method reaches an error of 1 % on a hanging sheet.");
        assert!(words.observations.is_empty(), "{words:?}");
    }
}
