//! The words of the study `animation`: its question, and the findings from its numbers.

use super::facts::{Facts, GOOD, LIVELY, Measure, Run, STRETCHED, Scene};
use crate::studies::names::{count, labels, methods, range, told, verb};
use drape_report::number::significant;
use drape_report::{Verdict, Words};
use std::cmp::Reverse;

/// The question that the study answers.
pub(super) const QUESTION: &str =
    "What does a frame cost that neither explodes, stands still nor shows a wrong shape?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["locking", "work-precision"];
/// The question of the long study.
pub(super) const LONG_QUESTION: &str =
    "Do the findings for small cloth and short scenes hold for larger cloth and for five seconds?";
/// Studies that a reader should know before the long study.
pub(super) const LONG_BUILDS_ON: &[&str] = &["animation"];

/// With at least this noise, true motions have gone different ways, m. It is the width of the
/// cloth.
const APART_M: f64 = 1.0;

/// The findings that the facts support. Times belong to a machine, so only figures show them.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion = [in_one_call(facts), explicit(facts)].into_iter().flatten();
    let conclusion = conclusion.collect::<Vec<_>>().join(" ");
    let observations =
        [nearest(facts), growing(facts), still(facts), gaining(facts), lost(facts), never(facts)];
    Words {
        conclusion,
        observations: observations.into_iter().flatten().collect(),
        caveats: caveats(facts),
    }
}

/// The findings of the long study, and what it has not run yet.
pub(super) fn long(facts: &Facts) -> Words {
    let mut ran = facts.clone();
    ran.scenes.retain(|scene| runs(facts, scene).next().is_some());
    let Words { conclusion, observations, mut caveats } = words(&ran);
    let lacking = facts.missing.iter().flat_map(|missing| {
        let kinds = [("runs", missing.not_run.len()), ("timings", missing.not_timed.len())];
        kinds.into_iter().filter(|(_, number)| *number > 0).map(|(what, number)| {
            format!("{what} of {} on \u{201c}{}\u{201d}", count(number, "method"), missing.scene)
        })
    });
    let lacking = lacking.collect::<Vec<_>>().join(", ");
    if !lacking.is_empty() {
        caveats.push(format!("Still missing: {lacking}. `drape reproduce --long` runs them."));
    }
    for missing in facts.missing.iter().filter(|missing| !missing.over_budget.is_empty()) {
        let names: Vec<_> = missing.over_budget.iter().map(|name| format!("`{name}`")).collect();
        caveats.push(format!(
            "Left out on \u{201c}{}\u{201d}, since they have no sound run over a shorter span and \
             exceed the budget there: {}.",
            missing.scene,
            names.join(", ")
        ));
    }
    let early = ran.scenes.iter().filter(|scene| scene.measure == Measure::Trajectory);
    for scene in early {
        caveats.push(format!(
            "On the scene \u{201c}{}\u{201d}, the distance at 0.3 s ranks the runs; the time \
             after it only decides whether a run is stable.",
            scene.id
        ));
    }
    let mut origins: Vec<_> = ran.scenes.iter().filter_map(|s| s.computed.as_ref()).collect();
    origins.sort_unstable();
    origins.dedup();
    for origin in origins {
        let own = ran.scenes.iter().filter(|scene| scene.computed.as_ref() == Some(origin));
        let names: Vec<_> = own.map(|scene| format!("\u{201c}{}\u{201d}", scene.id)).collect();
        caveats.push(format!(
            "Computed apart from the rest of the record, at commit {} on {}: {}.",
            origin.commit.get(..8).unwrap_or(&origin.commit),
            origin.cpu,
            names.join("; ")
        ));
    }
    let apart = ran.scenes.iter().filter(|scene| scene.shape_floor_m >= APART_M);
    for scene in apart {
        caveats.push(format!(
            "On the scene \u{201c}{}\u{201d}, a true motion is {} m from the nearest other one, on \
             average: chance decides which way the cloth goes.",
            scene.id,
            significant(scene.shape_floor_m, 2)
        ));
    }
    if ran.scenes.iter().any(|scene| scene.measure == Measure::Kept) {
        caveats.push(
            "After seconds in the wind, two true motions are as far apart as any two \
             runs, so no distance ranks the runs there."
                .to_owned(),
        );
    }
    let conclusion =
        if ran.scenes.is_empty() { "No scene has been run yet.".to_owned() } else { conclusion };
    Words { conclusion, observations, caveats }
}

fn runs<'a>(facts: &'a Facts, scene: &'a Scene) -> impl Iterator<Item = &'a Run> + Clone {
    facts.runs.iter().filter(move |run| run.scene == scene.id)
}

/// The labels of some runs, each once.
fn forms<'a>(runs: impl Iterator<Item = &'a Run>) -> Vec<&'a str> {
    labels(runs.map(|run| run.label.as_str()))
}

/// A length in millimetres, as text.
fn mm(metres: f64) -> String {
    significant(1e3 * metres, 2)
}

/// The forms for which one call a frame is enough in most scenes, after the measure of a good
/// frame.
fn in_one_call(facts: &Facts) -> Option<String> {
    let is_good = |label: &str, scene: &Scene| {
        let mut once = runs(facts, scene).filter(|run| run.label == label && run.substeps == 1);
        once.any(|run| run.is_good(scene))
    };
    let good: Vec<(&str, usize)> = forms(facts.runs.iter())
        .into_iter()
        .map(|label| (label, facts.scenes.iter().filter(|scene| is_good(label, scene)).count()))
        .collect();
    let (all, most) = (facts.scenes.len(), good.iter().map(|(_, count)| *count).max()?);
    let names: Vec<_> =
        good.iter().filter(|(_, count)| *count == most).map(|(label, _)| *label).collect();
    let scale = scale(facts);
    let lacks = |scene: &&Scene| {
        names.iter().any(|label| runs(facts, scene).all(|run| run.label != *label))
    };
    let not_run = match facts.scenes.iter().filter(lacks).count() {
        0 => String::new(),
        number => format!(" (not run on {number} of them)"),
    };
    let is_divided = |label: &&str| !in_a_call(facts, label).is_empty();
    let within = if names.iter().any(is_divided) {
        "; the substeps or stages are inside the call"
    } else {
        ""
    };
    let said = match most {
        0 => "One call a frame is enough for no form.".to_owned(),
        most if most == all => {
            format!(
                "One call a frame is enough in every scene that was run, with {}{within}.",
                methods(&names)
            )
        }
        most => format!(
            "One call a frame is enough in at most {most} of {all} scenes{not_run}, with {}{within}.",
            methods(&names)
        ),
    };
    Some(format!("{scale} {said}"))
}

/// The measure of a good frame, in words.
fn scale(facts: &Facts) -> String {
    let has = |is_it: fn(Measure) -> bool| facts.scenes.iter().any(|scene| is_it(scene.measure));
    let near = format!("is off by at most {} mm or twice the noise", mm(GOOD));
    let lively = format!("keeps its kinetic energy within a factor of {LIVELY}");
    let strain = format!("stretches by at most {} % more", 100.0 * STRETCHED);
    match (has(|measure| measure != Measure::Kept), has(|measure| measure == Measure::Kept)) {
        (true, true) => format!(
            "A frame is good if it {near} and {lively}; after seconds in the wind, if it is as near \
             at 0.3 s, {lively} and {strain}."
        ),
        (false, true) => {
            format!("A frame is good if it {near} at 0.3 s, {lively} and {strain}.")
        }
        _ => format!("A frame is good if it {near} and {lively}."),
    }
}

/// How few evaluations of the forces a good frame of a limited form takes. A call of some methods
/// has several.
fn explicit(facts: &Facts) -> Option<String> {
    let least = |scene: &Scene| {
        let frames = (scene.span_s * f64::from(scene.frames_per_s)).round();
        let own = runs(facts, scene).filter(|run| run.is_good(scene) && run.is_limited);
        let a_frame = own.map(|run| (run.counts.force_evaluations as f64 / frames).floor());
        a_frame.reduce(f64::min)
    };
    let needs: Vec<_> = facts.scenes.iter().filter_map(least).collect();
    let sweeps = range(&needs, |sweeps| sweeps.to_string())?;
    let by_scene = if sweeps.contains(" to ") { ", by scene" } else { "" };
    Some(format!(
        "Methods whose step stiffness limits evaluate the forces at least {sweeps} times for a good \
         frame{by_scene}."
    ))
}

/// The largest error of the best run with one call a frame, over all scenes.
fn nearest(facts: &Facts) -> Option<String> {
    let best = |scene: &Scene| {
        let own = runs(facts, scene).filter(|run| run.substeps == 1 && run.is_sound());
        own.filter_map(|run| scene.error(run)).reduce(f64::min)
    };
    let most = facts.scenes.iter().filter_map(best).reduce(f64::max)?;
    let most = mm(most);
    Some(format!(
        "With one call a frame, the nearest run that is stable and moves is off by at most {most} mm \
         on any scene."
    ))
}

/// The fewest parts in a frame of a sound run of a form on a mesh.
struct Need {
    particles: usize,
    number: u32,
    /// Whether it is only known that more are needed.
    is_more: bool,
}

impl Need {
    /// On each mesh of the hanging cloth, coarsest first. Of several scenes with one mesh the most
    /// demanding counts.
    fn of(facts: &Facts, label: &str) -> Vec<Self> {
        let of = |scene: &Scene| {
            let own = runs(facts, scene).filter(|run| run.label == label);
            let least = own.clone().filter(|run| run.is_sound()).map(Run::parts_of_a_frame).min();
            let is_tried =
                |run: &&Run| !matches!(run.verdict, Verdict::Refused | Verdict::OverBudget);
            let most = own.filter(is_tried).map(Run::parts_of_a_frame).max()?;
            let (number, is_more) = (least.unwrap_or(most), least.is_none());
            Some(Self { particles: scene.particles, number, is_more })
        };
        let hanging = facts.scenes.iter().filter(|scene| scene.id.starts_with("hanging"));
        let mut needs: Vec<_> = hanging.filter_map(of).collect();
        needs.sort_unstable_by_key(|need| (need.particles, Reverse((need.is_more, need.number))));
        needs.dedup_by_key(|need| need.particles);
        needs
    }

    fn told(&self) -> String {
        let more = if self.is_more { "more than " } else { "" };
        format!("{more}{} for {} particles", self.number, self.particles)
    }
}

/// Number of meshes from which on a growth shows.
const MESHES: usize = 3;

/// How the substeps of a form without a stiffness limit grow with the mesh, beside the steps of the
/// limited form that needs the fewest.
fn growing(facts: &Facts) -> Option<String> {
    let least = |is_meant: &dyn Fn(&Run) -> bool| {
        let all = forms(facts.runs.iter().filter(|run| is_meant(run))).into_iter();
        let all = all.map(|label| (label, Need::of(facts, label)));
        let all = all.filter(|(_, needs)| {
            let ends = needs.first().zip(needs.last());
            let rises = ends.is_some_and(|(coarse, fine)| coarse.number < fine.number);
            needs.len() >= MESHES && rises
        });
        // The finest mesh counts first.
        let from_the_finest = |needs: &[Need]| -> Vec<_> {
            needs.iter().rev().map(|need| (need.is_more, need.number)).collect()
        };
        all.min_by_key(|(_, needs)| from_the_finest(needs)).map(|(label, needs)| {
            let told: Vec<_> = needs.iter().map(Need::told).collect();
            (label.to_owned(), told.join(", "))
        })
    };
    let is_divided = |run: &Run| {
        let scene = facts.scenes.iter().find(|scene| scene.id == run.scene);
        let parts = scene.and_then(|scene| run.parts(scene));
        run.inside.is_some() && parts.is_some_and(|(_, what)| what == "substeps")
    };
    let (form, substeps) = least(&is_divided)?;
    let (other, steps) = least(&|run| run.is_limited)?;
    Some(format!(
        "The substeps of a frame in which `{form}` keeps its energy and its motion grow with the \
         mesh, like the steps of `{other}`: at least {substeps}, beside {steps}."
    ))
}

/// Forms that lose more than half of the motion in some scene at one call a frame.
fn still(facts: &Facts) -> Option<String> {
    let own = facts.runs.iter().filter(|run| run.substeps == 1);
    let still = forms(own.filter(|run| run.verdict == Verdict::Locked));
    let rest = "more than half of the motion in some scene with one call a frame";
    told(&still, ["loses", "lose"], rest)
}

/// Forms that gain energy although stiffness does not limit them.
fn gaining(facts: &Facts) -> Option<String> {
    let gains = |run: &&Run| {
        !run.is_limited && run.substeps <= 4 && run.inside.is_none() && run.verdict.gains_energy()
    };
    let gaining = forms(facts.runs.iter().filter(gains));
    let verbs = ["without a stiffness limit gains energy", "without a stiffness limit gain energy"];
    told(&gaining, verbs, "in some scene with one to four calls a frame")
}

/// Forms with which the cloth slides off the ball.
fn lost(facts: &Facts) -> Option<String> {
    let lost = facts.runs.iter().filter(|run| run.verdict == Verdict::LostContact);
    told(&forms(lost), ["lets", "let"], "the cloth slide off the ball, where it should stay")
}

/// Forms without a good run.
fn never(facts: &Facts) -> Option<String> {
    let is_good = |label: &str| {
        facts
            .scenes
            .iter()
            .any(|scene| runs(facts, scene).any(|run| run.label == label && run.is_good(scene)))
    };
    let all = forms(facts.runs.iter());
    let never: Vec<_> = all.into_iter().filter(|label| !is_good(label)).collect();
    told(&never, ["has", "have"], "no good run in any scene")
}

/// The fewest parts of a good call of a form, where one call a frame is enough: a number for each
/// such scene, and what the parts are.
fn in_a_call<'a>(facts: &'a Facts, label: &str) -> Vec<(u32, &'a str)> {
    let least = |scene: &'a Scene| {
        let own = runs(facts, scene).filter(|run| run.label == label && run.substeps == 1);
        own.filter(|run| run.is_good(scene)).filter_map(|run| run.parts(scene)).min()
    };
    facts.scenes.iter().filter_map(least).collect()
}

/// What a call holds, one sentence for each form whose call has parts.
fn divided(facts: &Facts) -> impl Iterator<Item = String> {
    forms(facts.runs.iter()).into_iter().filter_map(move |label| {
        let parts = in_a_call(facts, label);
        let what = parts.first()?.1;
        let numbers: Vec<_> = parts.iter().map(|(number, _)| f64::from(*number)).collect();
        let numbers = range(&numbers, |number| number.to_string())?;
        let scenes = count(parts.len(), "scene");
        Some(format!(
            "One call of `{label}` is not one step: a good one has at least {numbers} {what} \
             ({scenes})."
        ))
    })
}

/// The largest number of parts in a frame with which a form gains energy, where the study varies
/// that number.
fn too_few(facts: &Facts) -> impl Iterator<Item = String> {
    forms(facts.runs.iter()).into_iter().filter_map(move |label| {
        let gains = |run: &&Run| run.verdict.gains_energy();
        let own = facts.runs.iter().filter(|run| run.label == label).filter(gains);
        let most = own.filter_map(|run| Some((run.inside? * run.substeps, run)));
        let (most, run) = most.max_by_key(|(number, _)| *number)?;
        let scene = facts.scenes.iter().find(|scene| scene.id == run.scene)?;
        let what = run.parts(scene)?.1;
        Some(format!("`{label}` gains energy in some scene with up to {most} {what} a frame."))
    })
}

/// Scenes where a large error counts as good, or where the true motion is as uncertain as the noise.
fn blurred(facts: &Facts) -> impl Iterator<Item = String> {
    let ranked = facts.scenes.iter().filter(|scene| scene.measure != Measure::Kept);
    ranked.filter(|scene| scene.good_m() > GOOD).map(|scene| {
        let good = mm(scene.good_m());
        let has_coarse_truth =
            scene.measure == Measure::Shape && scene.reference_error_m > scene.floor_m();
        let truth = if has_coarse_truth {
            let [error, floor] = [scene.reference_error_m, scene.floor_m()].map(mm);
            format!(
                " Twice the step moves the true motion by {error} mm there, more than the noise of \
                 {floor} mm."
            )
        } else {
            String::new()
        };
        format!(
            "On the scene \u{201c}{}\u{201d}, a run counts as good up to {good} mm, twice the \
             noise.{truth}",
            scene.id
        )
    })
}

fn caveats(facts: &Facts) -> Vec<String> {
    let of = |value: &dyn Fn(&Scene) -> f64| facts.scenes.iter().map(value).collect::<Vec<f64>>();
    let mut caveats = Vec::new();
    let ranked = facts.scenes.iter().filter(|scene| scene.measure != Measure::Kept);
    if let Some(floor) = ranked.map(Scene::floor_m).reduce(f64::max) {
        caveats.push(format!(
            "A start that differs by 1 µm changes the ranking error by up to {} mm; smaller errors \
             mean nothing.",
            mm(floor)
        ));
    }
    if let Some(spans) = range(&of(&|scene| scene.span_s), |span| significant(span, 2)) {
        let longer = "where cloth folds for longer, noise hides the errors";
        caveats.push(format!("A scene lasts {spans} s; {longer}."));
    }
    let is_thin = |scene: &&Scene| !scene.has_all_forms;
    let thin = facts.scenes.iter().filter(is_thin).count();
    if thin > 0 {
        let scenes = format!("{} {}", count(thin, "scene"), verb(thin, "runs", "run"));
        caveats.push(format!("{scenes} only one form of each method."));
    }
    caveats.extend(blurred(facts));
    caveats.extend(divided(facts));
    caveats.extend(too_few(facts));
    caveats.push("A form is one choice of settings; tuning may change its place.".to_owned());
    caveats
}

#[cfg(test)]
mod tests {
    use super::super::facts::{Counters, Measure, Missing, Origin, leaders};
    use super::*;

    fn scene() -> Scene {
        Scene {
            id: "s".to_owned(),
            fabric: "denim".to_owned(),
            measure: Measure::Shape,
            has_all_forms: true,
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
            computed: None,
        }
    }

    fn run(label: &str, substeps: u32, verdict: Verdict, error: f64) -> Run {
        Run {
            scene: "s".to_owned(),
            label: label.to_owned(),
            method: label.to_owned(),
            substeps,
            inside: None,
            is_limited: substeps > 8,
            verdict,
            shape_error_m: Some(error),
            trajectory_error_m: Some(error),
            excess_strain: Some(0.0),
            retained: Some(1.0),
            kinetic: Some(1.0),
            contact: None,
            gain: 0.0,
            counts: Counters::default(),
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
            // Two sweeps in each of 24 calls, over 120 frames.
            Run {
                counts: Counters { force_evaluations: 5761, ..Counters::default() },
                ..run("explicit", 24, Verdict::Stable, 0.0001)
            },
            run("slippery", 2, Verdict::LostContact, 0.0001),
        ];
        let facts = Facts { scenes: vec![scene()], runs, missing: Vec::new() };
        let said = words(&facts);
        assert_eq!(
            said.conclusion,
            "A frame is good if it is off by at most 10 mm or twice the noise and keeps its kinetic \
             energy within a factor of 1.5. One call a frame is enough in every scene that was run, with `good`. Methods whose step stiffness limits \
             evaluate the forces at least 48 times for a good frame."
        );
        let all = said.observations.join(" ");
        for sentence in [
            "With one call a frame, the nearest run that is stable and moves is off by at most 2.0 \
             mm on any scene.",
            "1 form loses more than half of the motion in some scene with one call a frame; its \
             method is `still`.",
            "1 form without a stiffness limit gains energy in some scene with one to four calls a \
             frame; its method is `loud`.",
            "1 form lets the cloth slide off the ball, where it should stay; its method is \
             `slippery`.",
            "3 forms have no good run in any scene; their methods are `still`, `loud` and \
             `slippery`.",
        ] {
            assert!(all.contains(sentence), "{sentence}: {all}");
        }
    }

    #[test]
    fn a_call_says_how_many_substeps_it_has() {
        let lines = |number: u32, verdict: Verdict| Run {
            method: format!("xpbd-lines:substeps={number},iterations=1,order=2"),
            inside: Some(number),
            ..run("xpbd-lines", 1, verdict, 0.002)
        };
        let runs = vec![lines(4, Verdict::Unstable), lines(6, Verdict::Stable)];
        assert_eq!(runs[1].calls(&scene()), "1 call of 6 substeps");
        assert_eq!(run("symplectic-euler", 32, Verdict::Stable, 0.1).calls(&scene()), "32 steps");
        let counts = Counters { force_evaluations: 120 * 262, ..Counters::default() };
        let stages = Run { counts, ..run("rkc", 1, Verdict::Stable, 0.1) };
        assert_eq!(stages.calls(&scene()), "1 call of 262 force evaluations");
        let noisy = Scene { shape_floor_m: 0.02, reference_error_m: 0.03, ..scene() };
        let said = words(&Facts { scenes: vec![noisy], runs, missing: Vec::new() });
        let within = "with `xpbd-lines`; the substeps or stages are inside the call.";
        assert!(said.conclusion.contains(within), "{said:?}");
        let caveats = said.caveats.join(" ");
        for sentence in [
            "One call of `xpbd-lines` is not one step: a good one has at least 6 substeps (1 scene).",
            "`xpbd-lines` gains energy in some scene with up to 4 substeps a frame.",
            "a run counts as good up to 40 mm, twice the noise. Twice the step moves the true \
             motion by 30 mm there, more than the noise of 20 mm.",
        ] {
            assert!(caveats.contains(sentence), "{sentence}: {caveats}");
        }
    }

    #[test]
    fn substeps_that_grow_with_the_mesh_are_told_beside_explicit_steps() {
        let meshes = [(4, 6, 32), (16, 20, 96), (64, 0, 256)];
        let mut facts = Facts { scenes: Vec::new(), runs: Vec::new(), missing: Vec::new() };
        for (particles, substeps, steps) in meshes {
            let id = format!("hanging, {particles}");
            facts.scenes.push(Scene { id: id.clone(), particles, ..scene() });
            let lines = |number: u32, verdict| Run {
                scene: id.clone(),
                method: format!("xpbd-lines:substeps={number},iterations=1,order=2"),
                inside: Some(number),
                ..run("xpbd-lines", 2, verdict, 0.002)
            };
            facts.runs.push(lines(40, Verdict::Unstable));
            // A form that needs as many on every mesh, and one that needs more on coarse ones.
            let slow = |number: u32, verdict| Run {
                label: "xpbd".to_owned(),
                method: format!("xpbd:substeps={number}"),
                inside: Some(number),
                ..lines(number, verdict)
            };
            facts.runs.push(slow(40, Verdict::Unstable));
            facts
                .runs
                .push(Run { label: "xpbd, order 2".to_owned(), ..slow(40, Verdict::Unstable) });
            if particles < 64 {
                let sound = slow(18 + particles as u32, Verdict::Stable);
                facts.runs.push(Run { label: "xpbd, order 2".to_owned(), ..sound });
            }
            if substeps > 0 {
                facts.runs.push(lines(substeps / 2, Verdict::Stable));
            }
            let explicit = run("symplectic-euler", steps, Verdict::Stable, 0.001);
            facts.runs.push(Run { scene: id, ..explicit });
        }
        assert_eq!(
            growing(&facts).as_deref(),
            Some(
                "The substeps of a frame in which `xpbd-lines` keeps its energy and its motion grow with \
                 the mesh, like the steps of `symplectic-euler`: at least 6 for 4 particles, 20 for 16 \
                 particles, more than 80 for 64 particles, beside 32 for 4 particles, 96 for 16 \
                 particles, 256 for 64 particles."
            )
        );
        facts.scenes.pop();
        assert_eq!(growing(&facts), None);
    }

    #[test]
    fn a_scene_that_was_computed_apart_says_where() {
        let origin = Origin { commit: "0123456789ab".to_owned(), cpu: "a processor".to_owned() };
        let apart = Scene { computed: Some(origin), ..scene() };
        let runs = vec![run("good", 1, Verdict::Stable, 0.002)];
        let said = long(&Facts { scenes: vec![apart], runs, missing: Vec::new() });
        let caveat = "Computed apart from the rest of the record, at commit 01234567 on a processor: \
                      \u{201c}s\u{201d}.";
        assert!(said.caveats.iter().any(|told| told == caveat), "{said:?}");
    }

    /// Errors are known to a part of themselves only, and times to the ladder of steps.
    #[test]
    fn a_method_that_a_slightly_larger_error_puts_first_ties() {
        let of = |method: &str, error: f64| run(method, 1, Verdict::Stable, error);
        let errors = [("a", 0.0095), ("b", 0.0105), ("c", 0.0098), ("d", 0.02), ("e", 0.009)];
        let runs = errors.map(|(method, error)| of(method, error));
        let times = [1.0, 0.4, 1.9, 0.1, 2.5];
        let within = |share: f64| {
            let mut own: Vec<(&Run, f64)> = runs.iter().zip(times).collect();
            own.retain(|(run, _)| run.is_good_within(&scene(), share));
            own.sort_by(|a, b| a.1.total_cmp(&b.1));
            own
        };
        let first = leaders(within);
        let names: Vec<_> = first.iter().map(|(run, _)| run.id()).collect();
        // "e" leads where "a" and "c" are too far off, "b" where it is not.
        assert_eq!(names, ["a", "c", "e", "b"]);
        let twice = |share: f64| if share < 1.0 { Vec::new() } else { within(1.0) };
        assert_eq!(leaders(twice).len(), 2);
        assert!(leaders(|_| Vec::new()).is_empty());
    }

    #[test]
    fn a_method_that_a_slightly_wider_bound_on_energy_puts_first_ties() {
        let kept = [("lively", 1.0), ("inside", 0.7), ("outside", 0.65), ("dull", 0.5)];
        let of = |(method, kept): (&str, f64)| Run {
            kinetic: Some(kept),
            ..run(method, 1, Verdict::Stable, 0.002)
        };
        let runs = kept.map(of);
        let times = [9.0, 3.0, 1.0, 0.1];
        let within = |share: f64| {
            let mut own: Vec<(&Run, f64)> = runs.iter().zip(times).collect();
            own.retain(|(run, _)| run.is_good_within(&scene(), share));
            own.sort_by(|a, b| a.1.total_cmp(&b.1));
            own
        };
        let names: Vec<_> = leaders(within).iter().map(|(run, _)| run.id()).collect();
        assert_eq!(names, ["inside", "lively", "outside"]);
    }

    #[test]
    fn where_no_distance_ranks_the_start_energy_and_strain_decide() {
        let wind = Scene { measure: Measure::Kept, span_s: 5.0, ..scene() };
        let of = |label: &str, kinetic: f64, strain: f64| Run {
            kinetic: Some(kinetic),
            excess_strain: Some(strain),
            trajectory_error_m: Some(0.002),
            ..run(label, 1, Verdict::Stable, 0.3)
        };
        for (run, is_good) in [
            (of("far but lively", 1.0, 0.0), true),
            (of("slow", 0.6, 0.0), false),
            (of("slower, but near enough", 0.7, 0.0), true),
            (of("restless", 1.6, 0.0), false),
            (of("quicker, but near enough", 1.4, 0.0), true),
            (of("stretched", 1.0, 0.02), false),
            // A cloth that stretches less than the true one is too stiff, which no limit forbids.
            (of("short", 1.0, -0.02), true),
            (Run { kinetic: None, ..of("unknown energy", 1.0, 0.0) }, false),
            (Run { trajectory_error_m: Some(0.02), ..of("far at first", 1.0, 0.0) }, false),
            (Run { trajectory_error_m: None, ..of("unknown start", 1.0, 0.0) }, false),
            (Run { excess_strain: None, ..of("unknown strain", 1.0, 0.0) }, false),
            (Run { verdict: Verdict::Unstable, ..of("loud", 1.0, 0.0) }, false),
        ] {
            assert_eq!(run.is_good(&wind), is_good, "{}", run.label);
            assert_eq!(wind.error(&run), None);
        }
        // Near a shape that noise blurs, a run may still be sluggish or restless.
        for (kinetic, is_good) in [(1.0, true), (0.6, false), (1.6, false)] {
            let run = Run { kinetic: Some(kinetic), ..run("near", 1, Verdict::Stable, 0.001) };
            assert_eq!(run.is_good(&scene()), is_good, "{kinetic}");
        }
        let runs = vec![of("lively", 1.0, 0.0)];
        let said = long(&Facts { scenes: vec![wind], runs, missing: Vec::new() });
        let scale = "A frame is good if it is off by at most 10 mm or twice the noise at 0.3 s, \
                     keeps its kinetic energy within a factor of 1.5 and stretches by at most 1 % \
                     more. One call a frame is enough in every scene";
        assert!(said.conclusion.starts_with(scale), "{said:?}");
        let caveats = said.caveats.join(" ");
        assert!(caveats.contains("no distance ranks the runs there."), "{caveats}");
        let lost = Scene { measure: Measure::Trajectory, shape_floor_m: 3.9, ..scene() };
        let runs = vec![run("near", 1, Verdict::Stable, 0.001)];
        let told = long(&Facts { scenes: vec![lost], runs, missing: Vec::new() }).caveats.join(" ");
        for sentence in [
            "the distance at 0.3 s ranks the runs",
            "a true motion is 3.9 m from the nearest other one",
        ] {
            assert!(told.contains(sentence), "{sentence}: {told}");
        }
        assert!(!caveats.contains("1 µm"), "{caveats}");
    }

    #[test]
    fn a_long_study_says_what_it_lacks() {
        let none = Facts { scenes: Vec::new(), runs: Vec::new(), missing: Vec::new() };
        assert_eq!(long(&none).conclusion, "No scene has been run yet.");
        let staged = Facts { scenes: vec![scene()], ..none };
        assert_eq!(long(&staged).conclusion, "No scene has been run yet.");
        assert!(long(&staged).observations.is_empty(), "{:?}", long(&staged));
        let missing = |not_run: &[&str], not_timed: &[&str]| Missing {
            scene: "s".to_owned(),
            not_run: not_run.iter().map(|&label| label.to_owned()).collect(),
            not_timed: not_timed.iter().map(|&label| label.to_owned()).collect(),
            over_budget: Vec::new(),
        };
        let runs = vec![run("good", 1, Verdict::Stable, 0.002)];
        let dear = Missing { over_budget: vec!["g".to_owned()], ..missing(&[], &[]) };
        let missing = vec![missing(&["a", "b"], &["c"]), missing(&[], &["d", "e", "f"]), dear];
        let empty = Scene { id: "t".to_owned(), ..scene() };
        let said = long(&Facts { scenes: vec![scene(), empty], runs, missing });
        // A scene without runs does not count as a failure of the method.
        assert!(said.conclusion.contains("in every scene that was run, with `good`"), "{said:?}");
        // Nor does a scene with runs of other methods alone.
        let elsewhere =
            |label: &str| Run { scene: "t".to_owned(), ..run(label, 1, Verdict::Stable, 0.5) };
        let runs = vec![run("good", 1, Verdict::Stable, 0.002), elsewhere("other")];
        let empty = Scene { id: "t".to_owned(), ..scene() };
        let partly = long(&Facts { scenes: vec![scene(), empty], runs, missing: Vec::new() });
        let told = "in at most 1 of 2 scenes (not run on 1 of them), with `good`";
        assert!(partly.conclusion.contains(told), "{partly:?}");
        let caveats = said.caveats.join(" ");
        assert!(!caveats.contains("chance") && !caveats.contains("0.3 s"), "{caveats}");
        for sentence in [
            "Still missing: runs of 2 methods on",
            ", timings of 1 method on",
            ", timings of 3 methods",
            "--long",
            "exceed the budget there: `g`.",
        ] {
            assert!(caveats.contains(sentence), "{sentence}: {caveats}");
        }
    }
}
