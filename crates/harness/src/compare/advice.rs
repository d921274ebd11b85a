//! What a record advises, in a few lines.

use super::facts::{End, Facts, Form, Run, Scene, TIE, Truth};
use crate::judgement::percent;
use drape_report::number::significant;
use drape_report::{Verdict, printable};

/// Names in a list; the others are counted.
const NAMES: usize = 5;
/// Factors on the target at which the advice is read again, to see whether it changes.
const OTHER_TARGETS: [f64; 2] = [0.25, 4.0];

/// A run that the advice names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Place of the run in [`Facts::runs`].
    pub run: usize,
    /// Its time over that of the advised one.
    pub times: f64,
}

/// What a record advises.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Advice {
    /// The cheapest run that meets the target; `None` where no run does.
    pub take: Option<Pick>,
    /// The other forms within a factor of 1.5: ties.
    pub ties: Vec<Pick>,
    /// The next form after the ties.
    pub runner_up: Option<Pick>,
    /// Labels of the forms that are slower than the advised one and stand in no other list.
    pub slower: Vec<String>,
    /// Labels of the forms that met the target with no number of steps and stand in no other list.
    pub missed: Vec<String>,
    /// Forms that meet the target on the scene, but not on the pushed cloth.
    pub strays: Vec<String>,
    /// Forms that meet the target only by runs in which the solver stopped most steps before its
    /// tolerance. Without a true motion such runs agree with themselves, however wrong they are.
    pub doubtful: Vec<String>,
    /// Where no run meets the target, the sound run with the least error.
    pub closest: Option<Pick>,
    /// Forms that gained energy, with the most steps a frame at which they did.
    pub explodes: Vec<(String, u32)>,
    /// The same for forms that are [fragile](Run::is_fragile).
    pub fragile: Vec<(String, u32)>,
    /// The same for forms that stand still.
    pub locks: Vec<(String, u32)>,
    /// Forms that were refused, with the reason.
    pub refused: Vec<(String, String)>,
    /// Other targets, m, for which the advice names another form, each with the place of its run.
    pub other_targets: Vec<(f64, usize)>,
}

/// Places of the runs that meet a target, m: the cheapest run of each form, the cheapest first.
/// Without a true motion, runs whose solver stopped most steps before its tolerance count only
/// where no other run meets the target.
pub(super) fn ranking(target_m: f64, (scene, truth): (&Scene, &Truth), runs: &[Run]) -> Vec<usize> {
    let mut best: Vec<usize> = Vec::new();
    for (n, run) in runs.iter().enumerate().filter(|(_, run)| truth.is_met(target_m, run)) {
        match best.iter_mut().find(|other| runs[**other].form == run.form) {
            Some(other) if run.frame_s < runs[*other].frame_s => *other = n,
            Some(_) => {}
            None => best.push(n),
        }
    }
    let is_firm = |n: &usize| truth.is_trusted || !runs[*n].is_rough(scene.frames);
    if best.iter().any(is_firm) {
        best.retain(is_firm);
    }
    best.sort_by(|a, b| runs[*a].frame_s.total_cmp(&runs[*b].frame_s));
    best
}

/// Reads the advice from a record.
pub fn advise(facts: &Facts) -> Advice {
    let Facts { scene, runs, truth, .. } = facts;
    let ranked = ranking(scene.target_m, (scene, truth), runs);
    let least = ranked.first().map_or(f64::NAN, |&n| runs[n].frame_s);
    let pick = |&run: &usize| Pick { run, times: runs[run].frame_s / least };
    let picks: Vec<Pick> = ranked.iter().map(pick).collect();
    let (ties, slower): (Vec<Pick>, Vec<Pick>) =
        picks.iter().skip(1).partition(|pick| pick.times <= TIE);
    let is_sound = |run: &Run| run.is_sound() && !run.is_fragile() && run.error_m.is_some();
    let sound = (0..runs.len()).filter(|&n| is_sound(&runs[n]));
    let error = |n: &usize| {
        let run = &runs[*n];
        run.error_m.unwrap_or(f64::INFINITY).max(run.pushed_m.unwrap_or(0.0))
    };
    let closest = sound.min_by(|a, b| error(a).total_cmp(&error(b)));
    let failed = |is: &dyn Fn(&Run) -> bool| {
        let most = |(form, _): (usize, _)| {
            let own = runs.iter().filter(|run| run.form == form && is(run));
            Some((facts.forms[form].label.clone(), own.map(|run| run.substeps).max()?))
        };
        let mut forms: Vec<(String, u32)> =
            facts.forms.iter().enumerate().filter_map(most).collect();
        forms.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
        forms
    };
    let refused = |form: &Form| Some((form.label.clone(), form.refusal.clone()?));
    let (explodes, fragile) = (failed(&Run::explodes), failed(&Run::is_fragile));
    let locks = failed(&|run| run.verdict == Verdict::Locked);
    let is_left_out = |(form, _): &(usize, &Form)| {
        let ranks = |n: &usize| runs[*n].form == *form;
        !ranked.iter().any(ranks) && runs.iter().any(|run| run.form == *form && facts.is_met(run))
    };
    let left_out = facts.forms.iter().enumerate().filter(is_left_out);
    let strays = |form: &usize| {
        let own = || runs.iter().filter(|run| run.form == *form);
        own().any(|run| facts.strays(run)) && !own().any(|run| facts.is_met(run))
    };
    let strays = (0..facts.forms.len()).filter(strays);
    let strays: Vec<String> = strays.map(|form| facts.forms[form].label.clone()).collect();
    let doubtful: Vec<String> = left_out.map(|(_, form)| form.label.clone()).collect();
    let (take, runner_up) = (picks.first().copied(), slower.first().copied());
    let closest = closest.filter(|_| ranked.is_empty()).map(|run| Pick { run, times: 1.0 });
    let mut told: Vec<&str> =
        explodes.iter().chain(&fragile).chain(&locks).map(|(label, _)| label.as_str()).collect();
    told.extend(doubtful.iter().chain(&strays).map(String::as_str));
    let named = take.iter().chain(&ties).chain(&runner_up).chain(&closest);
    told.extend(named.map(|pick| facts.form_of(&runs[pick.run]).label.as_str()));
    let ended = |ends: &[End]| -> Vec<String> {
        let own = facts.forms.iter().filter(|form| ends.contains(&form.end));
        let labels = own.map(|form| form.label.as_str()).filter(|label| !told.contains(label));
        labels.map(str::to_owned).collect()
    };
    let other = |factor: f64| {
        let target = factor * scene.target_m;
        let first = *ranking(target, (scene, truth), runs).first()?;
        let is_other = ranked.first().is_none_or(|&now| runs[now].form != runs[first].form);
        (truth.good_m(target) != facts.good_m() && is_other).then_some((target, first))
    };
    Advice {
        take,
        runner_up,
        slower: ended(&[End::Good, End::Dominated]),
        missed: ended(&[End::Exhausted]),
        ties,
        strays,
        doubtful,
        closest,
        explodes,
        fragile,
        locks,
        refused: facts.forms.iter().filter_map(refused).collect(),
        other_targets: OTHER_TARGETS.into_iter().filter_map(other).collect(),
    }
}

fn length(metres: f64) -> String {
    format!("{} mm", significant(1e3 * metres, 2))
}

fn milliseconds(seconds: f64) -> String {
    format!("{} ms a frame", significant(1e3 * seconds, 2))
}

fn steps(substeps: u32) -> String {
    if substeps == 1 { "1 step a frame".to_owned() } else { format!("{substeps} steps a frame") }
}

/// A few names, and how many others.
fn listed(names: &[String], mark: &str) -> String {
    let more = names.len().saturating_sub(NAMES);
    let names = names[..names.len() - more].join(mark);
    if more > 0 { format!("{names}{mark}{more} more") } else { names }
}

/// A word, quoted where a shell would not take it as one word.
pub fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// The command that makes a run.
pub(super) fn command(facts: &Facts, run: &Run) -> String {
    let step = facts.scene.frame_s / f64::from(run.substeps);
    let duration = facts.scene.frame_s * f64::from(facts.scene.frames);
    let method = quoted(&facts.form_of(run).method);
    let scene = quoted(&facts.scene.name);
    format!("drape run {scene} --method {method} --dt {step} --duration {duration}")
}

/// The advice in at most twelve lines.
pub fn lines(facts: &Facts, advice: &Advice) -> Vec<String> {
    let (scene, truth) = (&facts.scene, &facts.truth);
    let said = |pick: &Pick| {
        let run = &facts.runs[pick.run];
        format!("{}, {}", facts.form_of(run).label, steps(run.substeps))
    };
    let mut lines = vec![format!(
        "{}: {} particles, {} frames of {} s; wanted: {} within {}",
        printable(&scene.name),
        scene.particles,
        scene.frames,
        significant(scene.frame_s, 3),
        scene.metric.name(),
        length(scene.target_m)
    )];
    let mut told = |word: &str, text: String| lines.push(format!("{word:<11}{text}"));
    let good = facts.good_m();
    let raised = if good > scene.target_m {
        format!("; noise moves it by {}, so {} counts as met", length(0.5 * good), length(good))
    } else {
        String::new()
    };
    told(
        "held to",
        match (&truth.method, truth.error_m, truth.is_trusted) {
            (Some(method), Some(error), true) => {
                let id = method.split(':').next().unwrap_or(method);
                let error = length(error);
                format!("{id} at {}, error {error}{raised}", steps(truth.substeps))
            }
            _ => {
                let why = truth.remark.as_deref().unwrap_or("none was found");
                format!("itself at half the steps, also its error bar; no true motion ({why})")
            }
        },
    );
    if !truth.is_trusted {
        let advised = advice.take.as_ref().or(advice.closest.as_ref());
        let doubt = advised.map_or("", |_| "runs that agree with themselves may still be wrong; ");
        told("warning", format!("{doubt}a longer --budget may find the true motion"));
    } else if !truth.moves {
        told("note", "nothing moves in this scene: only the time tells methods apart".to_owned());
    }
    let expect = |run: &Run| {
        let error = run.error_m.map_or_else(String::new, |error| {
            format!("{} error {}, ", scene.metric.name(), length(error))
        });
        let solves = if run.unconverged_steps > 0 {
            format!("; {} steps stopped before their tolerance", run.unconverged_steps)
        } else {
            String::new()
        };
        let pushed = match (run.holds_when_pushed, truth.is_trusted && truth.moves) {
            (None, true) => "; the time did not suffice to push it",
            _ => "",
        };
        let open = match run.verdict {
            Verdict::Open => {
                "; whether it gains energy beyond the work of pins, obstacles and wind is not known: \
                 `drape run` may end with another verdict"
            }
            _ => "",
        };
        let slow = run.foreseen.map_or_else(String::new, |share| {
            format!(
                "; by theory it keeps {} of a motion against the springs: `drape run`, which looks \
                 at a few windows, may say `locked`",
                percent(share)
            )
        });
        format!("{error}{}{solves}{pushed}{open}{slow}", milliseconds(run.frame_s))
    };
    let left = facts.forms.iter().filter(|form| form.end == End::OutOfTime).count();
    match (&advice.take, &advice.closest) {
        (Some(pick), _) => {
            let run = &facts.runs[pick.run];
            told("take", format!("{}: {}", steps(run.substeps), facts.form_of(run).method));
            told("expect", expect(run));
        }
        (None, Some(pick)) => {
            told("take", format!("none meets the target in this time; closest: {}", said(pick)));
            told("expect", expect(&facts.runs[pick.run]));
        }
        (None, None) if facts.runs.is_empty() => {
            told("take", "none: the time did not suffice for a run".to_owned());
        }
        (None, None) => {
            let when = if left > 0 { " in this time" } else { "" };
            told("take", format!("none{when}: no run was stable, moved and could be judged"))
        }
    }
    if !advice.ties.is_empty() {
        let ties: Vec<String> = advice.ties.iter().map(said).collect();
        told("ties", format!("{} (within a factor of {TIE})", listed(&ties, "; ")));
    }
    let next =
        |pick: &Pick| format!("{}: {} times the time", said(pick), significant(pick.times, 2));
    let mut behind: Vec<String> = advice.runner_up.iter().map(next).collect();
    // Labels have commas.
    for (first, later, forms) in [
        ("slower", "Slower", &advice.slower),
        ("never within the target", "Never within the target", &advice.missed),
        ("within the target until pushed", "Within the target until pushed", &advice.strays),
        (
            "most steps short of their tolerance",
            "Most steps short of their tolerance",
            &advice.doubtful,
        ),
    ] {
        if !forms.is_empty() {
            let word = if behind.is_empty() { first } else { later };
            behind.push(format!("{word}: {}", listed(forms, "; ")));
        }
    }
    if !behind.is_empty() {
        let word = if advice.runner_up.is_some() { "runner-up" } else { "others" };
        told(word, behind.join(". "));
    }
    let up_to = |forms: &[(String, u32)]| -> Vec<String> {
        forms.iter().map(|(label, most)| format!("{label} {most}")).collect()
    };
    let mut exploding = Vec::new();
    for (when, forms) in [("up to", &advice.explodes), ("when pushed, up to", &advice.fragile)] {
        if !forms.is_empty() {
            exploding.push(format!("{when} so many steps: {}", listed(&up_to(forms), "; ")));
        }
    }
    if !exploding.is_empty() {
        told("explodes", exploding.join("; "));
    }
    if !advice.locks.is_empty() {
        told("locks", format!("up to so many steps: {}", listed(&up_to(&advice.locks), "; ")));
    }
    if !advice.refused.is_empty() {
        let mut reasons: Vec<(&str, Vec<String>)> = Vec::new();
        for (label, reason) in &advice.refused {
            match reasons.iter_mut().find(|(other, _)| other == reason) {
                Some((_, labels)) => labels.push(label.clone()),
                None => reasons.push((reason, vec![label.clone()])),
            }
        }
        let said =
            |(reason, labels): &(&str, Vec<String>)| format!("{reason}: {}", listed(labels, ", "));
        let reasons: Vec<String> = reasons.iter().map(said).collect();
        told("refused", listed(&reasons, "; "));
    }
    let other = |&(target, run): &(f64, usize)| {
        format!("an error of {}: {}", length(target), said(&Pick { run, times: 1.0 }))
    };
    let mut changes: Vec<String> = advice.other_targets.iter().map(other).collect();
    if left > 0 {
        changes.push(format!("a longer --budget: {left} forms were not run to their end"));
    }
    if !truth.is_trusted {
        changes.push("the true motion, which was not found".to_owned());
    } else if changes.is_empty() {
        changes.push("no target four times as hard or easy, among the runs made".to_owned());
    }
    told("changes it", changes.join("; "));
    if let Some(pick) = advice.take.as_ref().or(advice.closest.as_ref()) {
        told("run it", command(facts, &facts.runs[pick.run]));
    }
    lines
}
