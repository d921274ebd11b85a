//! Which method to take for what: the five uses on the first page, each answered from records.

mod frames;

use super::{regret, rest, scaling, trajectory};
use drape_report::file::read_json;
use drape_report::number::significant;
use drape_report::page::{Table, texts};
use drape_report::{Record, Timings};
use frames::{FILM, Frames, of_frames};
pub use frames::{
    bound_of_film, bounded, command_of_film, in_one_call, light_damping, on_large_cloth,
    on_large_cloth_for_long, substeps_of_lines,
};
use serde::de::DeserializeOwned;
use std::path::Path;
use trajectory::facts::{Facts, Winner};

/// A use and the method to take for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Use {
    /// The use.
    pub what: &'static str,
    /// The method, with those that tie.
    pub take: String,
    /// The cloth on which it was measured, and to which error.
    pub measured: String,
    /// What a comparison advises for the bundled scene of the use; empty without one.
    pub bundled: String,
    /// What the records say.
    pub why: String,
}

/// The answer to a use.
struct Answer {
    take: String,
    measured: String,
    bundled: String,
    why: String,
}

/// The five uses, each with the method to take and the numbers behind it. They come from the
/// records in the folder `results`.
///
/// # Errors
/// A message if a record cannot be read or lacks a number.
pub fn all_uses(results: &Path) -> Result<[Use; 5], String> {
    let round = at_rest(results, Tables::Round)?;
    let all = at_rest(results, Tables::All)?;
    let answers = [
        (
            "a curtain in a film at 24 frames a second",
            of_frames(results, &Frames::of(results, FILM.0, FILM.1)?, "curtain")?,
        ),
        (
            "a skirt in a game at 60 frames a second",
            of_frames(results, &Frames::of(results, "animation-long", "held")?, "skirt")?,
        ),
        ("a drape test for a textile laboratory", laid(results, round.as_ref())?),
        ("a teaching demonstration", taught(results)?),
        ("a still of a million particles", of_a_million(results, all.as_ref())?),
    ];
    Ok(answers.map(|(what, answer)| {
        let Answer { take, measured, bundled, why } = answer;
        Use { what, take, measured, bundled, why }
    }))
}

/// The heads of the columns of a use, from the second on.
pub const COLUMNS: [&str; 3] = ["take", "measured on", "for the bundled scene"];

/// The processors whose times rank the methods, with their studies.
///
/// # Errors
/// A message if timings cannot be read.
pub fn measured_on(results: &Path) -> Result<String, String> {
    let mut processors: Vec<(String, Vec<String>)> = Vec::new();
    for study in ["animation", "animation-long", "rest", "regret", "scaling"] {
        let processor = processor(results, study)?;
        let study = format!("`{study}`");
        match processors.iter_mut().find(|(known, _)| *known == processor) {
            Some((_, studies)) => studies.push(study),
            None => processors.push((processor, vec![study])),
        }
    }
    let told = processors.iter().map(|(cpu, studies)| format!("{}: {cpu}", studies.join(", ")));
    Ok(format!("Times of {}.", told.collect::<Vec<_>>().join("; of ")))
}

/// The processor of the timings of a study.
///
/// # Errors
/// A message if they cannot be read.
pub fn processor(results: &Path, study: &str) -> Result<String, String> {
    let path = results.join("timings").join(study).with_extension("json");
    let timings = read_json(&path).map_err(|error| error.to_string())?;
    let timings: Timings<serde_json::Value> = timings;
    Ok(timings.provenance.cpu)
}

/// The table of the report; `None` if a record is missing or lacks a number.
pub(super) fn table(results: &Path) -> Option<Table> {
    let uses = all_uses(results).ok()?;
    let measured_on = measured_on(results).ok()?;
    let line = |Use { what, take, measured, bundled, why }: Use| {
        vec![what.to_owned(), take, measured, bundled, why]
    };
    let [take, measured, bundled] = COLUMNS;
    Some(Table {
        title: format!("**Which method for what**, and what the records say. {measured_on}"),
        header: texts(&["use", take, measured, bundled, "the record says"]),
        names: 5,
        rows: uses.into_iter().map(line).collect(),
    })
}

/// The facts of a study in the folder `results`.
///
/// # Errors
/// A message if the record cannot be read.
pub fn facts<F: DeserializeOwned>(results: &Path, study: &str) -> Result<F, String> {
    let path = results.join(study).with_extension("json");
    read_json(&path).map(|record: Record<F>| record.facts).map_err(|error| error.to_string())
}

/// The rows of the timings of a study in the folder `results`.
///
/// # Errors
/// A message if the timings cannot be read.
pub fn timings<R: DeserializeOwned>(results: &Path, study: &str) -> Result<Vec<R>, String> {
    let path = results.join("timings").join(study).with_extension("json");
    read_json(&path).map(|timings: Timings<R>| timings.rows).map_err(|error| error.to_string())
}

/// Level of error for which the pages name winners.
pub const LEVEL: f64 = 0.01;

/// Light and heavy damping, by their names in `trajectory`: a hundredth of the critical damping of
/// the stiffest mode, and critical damping.
pub const DAMPINGS: [&str; 2] = ["ζ = 0.01", "ζ = 1"];

/// The sheets of `trajectory` with this damping, softest first. Each has its stiffness over mass
/// (1/s²) and the winner at this level of error; `None` if noise prevents a ranking.
pub fn wins<'a>(facts: &'a Facts, damping: &str, level: f64) -> Vec<(f64, Option<&'a Winner>)> {
    let own = facts.scenes.iter().filter(|scene| scene.damping == damping);
    let mut wins: Vec<(f64, Option<&Winner>)> = own
        .map(|scene| {
            let is_its = |w: &&Winner| w.scene == scene.id && w.level == level;
            (scene.stiffness_over_mass_per_s2, facts.winners.iter().find(is_its))
        })
        .collect();
    wins.sort_by(|a, b| a.0.total_cmp(&b.0));
    wins
}

/// The methods that tie with a winner, without the winner's own.
pub fn tied(winner: &Winner) -> Vec<&str> {
    let mut methods: Vec<&str> = Vec::new();
    for name in winner.tied.iter().map(|tied| method(&tied.label)) {
        if name != winning(winner) && !methods.contains(&name) {
            methods.push(name);
        }
    }
    methods
}

/// The method of a label: the text before the first comma.
fn method(label: &str) -> &str {
    label.split(',').next().unwrap_or_default()
}

/// The method of a winner; `none` if no run reaches the error.
pub fn winning(winner: &Winner) -> &str {
    winner.label.as_deref().map_or("none", method)
}

/// A method with the settings that are not its defaults, as the command takes it.
fn short(method: &str) -> String {
    crate::methods::Choice::parse(method, &[])
        .map_or_else(|_| method.to_owned(), |choice| choice.short_id())
}

/// The text about other methods that are as good; empty without any. It names the first ones and
/// counts the others.
fn ties(what: &str, labels: &[String]) -> String {
    const SHOWN: usize = 3;
    if labels.is_empty() {
        return String::new();
    }
    let (first, others) = labels.split_at(labels.len().min(SHOWN));
    let more = if others.is_empty() { String::new() } else { format!(" +{} more", others.len()) };
    format!("; {what}: {}{more}", first.join(", "))
}

/// The length of a step in s as a fraction, which the command takes; `steps` are `seconds` long. No
/// digit is rounded: a step that is slightly longer can be unstable.
fn step_s(seconds: f64, steps: f64) -> String {
    let inverse = steps / seconds;
    let whole = inverse.round();
    if (inverse - whole).abs() <= 1e-9 * whole {
        format!("1/{whole:.0}")
    } else {
        format!("{seconds}/{steps:.0}")
    }
}

/// What `drape compare` advises for a bundled scene; empty texts if it was not asked for.
#[derive(Default)]
struct Advised {
    /// The scene with the form and its step.
    take: String,
    /// A sentence that goes on the reason.
    why: String,
}

/// The advice for a bundled scene.
fn advised(results: &Path, scene: &str) -> Result<Advised, String> {
    use regret::facts::TimingRow;
    let timings: Vec<TimingRow> = timings(results, "regret")?;
    let Some(row) = timings.into_iter().find(|row| row.scene == scene) else {
        return Ok(Advised::default());
    };
    let steps = row.substeps.max(1);
    let dt = step_s(1.0 / row.frames_per_s, f64::from(steps));
    let many = if steps == 1 { "step" } else { "steps" };
    let advice = row.label.as_ref().map_or_else(
        || "nothing".to_owned(),
        |label| format!("`{label}`, {steps} {many} a frame (`--dt {dt}`)"),
    );
    let why = format!(
        ". For the motion of the bundled scene `{scene}` ({} particles) at {} frames a second, within \
         {:.1} mm or twice the noise, `drape compare` advises in {:.0} s: {advice} (`regret`, on {})",
        row.particles,
        row.frames_per_s,
        1e3 * row.target_m,
        row.budget_s,
        processor(results, "regret")?
    );
    let take = format!("`{scene}` at {} Hz: {advice}", row.frames_per_s);
    Ok(Advised { take, why })
}

/// A tenth of a second, the unit in which `rest` counts steps.
const TENTH_S: f64 = 0.1;

/// Tables of the study `rest`.
#[derive(Clone, Copy, PartialEq)]
enum Tables {
    /// The round ones, those of drape tests.
    Round,
    All,
}

/// The form that is nearest to the cheapest on each of some tables.
struct Rest {
    /// The form with its settings.
    form: String,
    /// The labels of others that are as near.
    near: Vec<String>,
    /// The most that it takes over the least time on a table.
    ratio: f64,
    /// Its fastest steps on the tables, by fabric.
    steps: String,
    /// What it is measured on.
    measured: String,
    why: String,
}

/// The form for a drape test.
fn laid(results: &Path, rest: Option<&Rest>) -> Result<Answer, String> {
    let Advised { take: bundled, why: advised } = advised(results, "drape-test")?;
    let Some(Rest { form, near, steps, measured, why, .. }) = rest else {
        return Ok(Answer {
            take: "none".to_owned(),
            measured: "study `rest`".to_owned(),
            bundled,
            why: format!("`rest`: no form comes to rest on all{advised}"),
        });
    };
    let take = format!("`{form}`, steps of {steps}{}", ties("tie", near));
    let why = format!(
        "{why}. How near drape coefficients come to published ones: study `fabric`. They differ \
         from mesh to mesh; on some fabrics they lie outside the published range{advised}"
    );
    let ties = format!(
        "; methods tie that fall less than {} times as far behind the fastest",
        rest::facts::TIE
    );
    let measured = measured.clone() + if near.is_empty() { "" } else { &ties };
    Ok(Answer { take, measured, bundled, why })
}

/// The form for the way to rest; `None` where no form comes to rest on all tables.
fn at_rest(results: &Path, tables: Tables) -> Result<Option<Rest>, String> {
    use rest::facts::{Facts, Run, Scene, TIE, TimingRow};
    let facts: Facts = facts(results, "rest")?;
    let timings: Vec<TimingRow> = timings(results, "rest")?;
    let is_meant = |id: &str| tables == Tables::All || id.starts_with("round");
    // Where cloth buckles into one of several shapes, a tolerance decides which runs are right.
    let is_clear = |scene: &&Scene| scene.accepted.len() == 1;
    let (clear, other): (Vec<_>, Vec<_>) =
        facts.scenes.iter().filter(|scene| is_meant(&scene.id)).partition(is_clear);
    let meant: Vec<&str> = clear.iter().map(|scene| scene.id.as_str()).collect();
    let time = |run: &Run| timings.iter().find(|row| row.is_of(run)).map(|row| row.seconds);
    let right = facts.runs.iter().filter(|run| run.is_right());
    let right: Vec<(&Run, f64)> = right.filter_map(|run| Some((run, time(run)?))).collect();
    let least = |scene: &str, label: Option<&str>| {
        let own = right.iter().filter(|(run, _)| run.scene == scene);
        let own = own.filter(|(run, _)| label.is_none_or(|label| run.label == label));
        own.map(|(_, seconds)| *seconds).fold(f64::INFINITY, f64::min)
    };
    let ratio = |label: &str| {
        let ratios = meant.iter().map(|scene| least(scene, Some(label)) / least(scene, None));
        ratios.fold(0.0, f64::max)
    };
    let mut labels: Vec<&str> = right.iter().map(|(run, _)| run.label.as_str()).collect();
    labels.sort_unstable();
    labels.dedup();
    labels.retain(|label| ratio(label).is_finite());
    labels.sort_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    let Some(first) = labels.first() else { return Ok(None) };
    let near = labels[1..].iter().take_while(|label| ratio(label) <= TIE * ratio(first));
    let form_of = |label: &str| {
        let run = right.iter().find(|(run, _)| run.label == label);
        run.map_or_else(|| label.to_owned(), |(run, _)| short(&run.method))
    };
    let near: Vec<_> = near.map(|label| format!("`{}`", form_of(label))).collect();
    let fastest: Vec<(f64, u32)> = meant
        .iter()
        .map(|scene| {
            let seconds = least(scene, Some(first));
            let own = |(run, time): &&(&Run, f64)| {
                (run.scene.as_str(), run.label.as_str(), *time) == (*scene, *first, seconds)
            };
            (seconds, right.iter().find(own).map_or(0, |(run, _)| run.steps))
        })
        .collect();
    let told = |(scene, (seconds, steps)): (&&str, &(f64, u32))| {
        let (ms, step) = (1e3 * seconds, step_of(*steps));
        format!("{ms:.0} ms ({}, step {step} s)", cloth(scene))
    };
    let told: Vec<_> = meant.iter().zip(&fastest).map(told).collect();
    let is_wild = |run: &&Run| {
        run.verdict.gains_energy() && run.label == **first && meant.contains(&run.scene.as_str())
    };
    let wild: Vec<_> = facts.runs.iter().filter(is_wild).map(wildly).collect();
    let wild = match wild.is_empty() {
        true => String::new(),
        false => format!(". It gains energy with {}", wild.join(", ")),
    };
    let mut steps: Vec<String> = Vec::new();
    for (scene, (_, number)) in meant.iter().zip(&fastest) {
        let fabric = scene.split(", ").nth(1).unwrap_or_default();
        let step = format!("{} s ({fabric})", step_of(*number));
        if !steps.contains(&step) {
            steps.push(step);
        }
    }
    let steps = steps.join(", ");
    let mut elsewhere = String::new();
    for scene in facts.scenes.iter().filter(|scene| !is_meant(&scene.id)) {
        let times = least(&scene.id, Some(first)) / least(&scene.id, None);
        elsewhere.push_str(&format!("; on the {} {times:.1} times", scene.id));
    }
    let mut sizes: Vec<usize> = clear.iter().map(|scene| scene.particles).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let sizes: Vec<_> = sizes.iter().map(usize::to_string).collect();
    let kind = if tables == Tables::Round { "round tables" } else { "tables" };
    let many: String = other
        .iter()
        .map(|scene| {
            format!(". Not counted: {}, whose cloth buckles into one of several shapes", scene.id)
        })
        .collect();
    let measured = format!(
        "cloth of {} particles on {} {kind} (study `rest`): least computing time \
         until the cloth lies still",
        sizes.join(" or "),
        meant.len()
    );
    let why = format!(
        "`rest`, {} {kind}: until the cloth lies still it computes for {}. That is at most {:.1} \
         times the least computing time{elsewhere}{wild}{many}",
        meant.len(),
        told.join(", "),
        ratio(first)
    );
    Ok(Some(Rest { form: form_of(first), near, ratio: ratio(first), steps, measured, why }))
}

/// A run on a table, by its step and cloth.
fn wildly(run: &rest::facts::Run) -> String {
    format!("steps of {} s ({})", step_of(run.steps), cloth(&run.scene))
}

/// The length of a step in s, of which so many make a tenth of a second.
fn step_of(steps: u32) -> String {
    step_s(TENTH_S, f64::from(steps))
}

/// The cloth of a table of `rest`: its id without the shape of the table.
fn cloth(scene: &str) -> &str {
    scene.split_once(", ").map_or(scene, |(_, cloth)| cloth)
}

/// The winner on a soft sheet.
fn taught(results: &Path) -> Result<Answer, String> {
    let facts: Facts = facts(results, "trajectory")?;
    let wins = wins(&facts, DAMPINGS[0], LEVEL);
    let lacks = |what: &str| {
        let record = results.join("trajectory.json");
        let (record, damping) = (record.display(), DAMPINGS[0]);
        format!("{record} has {what} for k/m = 10⁴ s⁻² and {damping}; run `drape reproduce`")
    };
    let soft = wins.iter().find(|(stiffness, _)| *stiffness == 1e4);
    let soft = soft.ok_or_else(|| lacks("no sheet"))?.1.ok_or_else(|| lacks("no winner"))?;
    let why = format!(
        "`trajectory`, k/m = 10⁴ s⁻², {}: the least modelled time for 1 %; its step is a line of \
         mathematics. The course has lessons on such explicit methods, and the lab shows \
         methods side by side",
        DAMPINGS[0]
    );
    let near: Vec<_> = tied(soft).iter().map(|name| format!("`{name}`")).collect();
    let step = soft.run(&facts.rows).and_then(|run| run.step_s);
    let step = step.map(|step| format!(", step {} s", step_s(step, 1.0)));
    let step = step.unwrap_or_default();
    let take = format!("`{}`{step}{}", winning(soft), ties("tie", &near));
    let measured = "a soft hanging sheet (k/m = 10⁴ s⁻²), within 1 %, by modelled time";
    Ok(Answer { take, measured: measured.to_owned(), bundled: String::new(), why })
}

/// The times of a million particles, and the form that is first on small cloth.
fn of_a_million(results: &Path, rest: Option<&Rest>) -> Result<Answer, String> {
    use scaling::facts::{Facts, RunTiming, TimingRow};
    let counted: Facts = facts(results, "scaling")?;
    let timings: Vec<TimingRow> = timings(results, "scaling")?;
    let largest = timings.iter().filter_map(|row| match row {
        TimingRow::Run(run) => Some(run),
        _ => None,
    });
    let is_meant = |run: &&RunTiming| run.series == "k/m fixed" && run.particles >= 1_000_000;
    let told: Vec<_> = largest
        .filter(is_meant)
        .map(|run| {
            let seconds = 1e-9 * run.ns_per_particle_step * run.particles as f64;
            let is_its = |cell: &&scaling::facts::Cell| {
                (&cell.series, cell.particles, &cell.label)
                    == (&run.series, run.particles, &run.label)
            };
            let cell = counted.cells.iter().find(is_its);
            let step = cell.map(|cell| format!(" for {} ms", significant(1e3 * cell.step_s, 2)));
            format!("`{}` {seconds:.2} s{}", run.label, step.unwrap_or_default())
        })
        .collect();
    let why = format!(
        "`scaling`, 10⁶ particles on a soft sheet, a step: {}. Nobody measured the way to rest, or \
         the methods of the second column, at that size",
        told.join(", ")
    );
    let take = rest.map_or_else(String::new, |rest| {
        let Rest { form, ratio, .. } = rest;
        // Within the digits that are told, it is the first on every table.
        if *ratio < 1.05 {
            format!("; on small cloth `{form}` lies still after the least computing time")
        } else {
            format!("; on small cloth `{form}` takes at most {ratio:.1} times the least time")
        }
    });
    let measured = rest.map_or_else(|| "study `rest`".to_owned(), |rest| rest.measured.clone());
    let first = "unproven at that size: compare a coarser mesh of your cloth first";
    Ok(Answer { take: format!("{first}{take}"), measured, bundled: String::new(), why })
}

#[cfg(test)]
mod tests {
    use super::{TENTH_S, step_of, step_s};

    #[test]
    fn a_step_is_told_as_a_fraction_that_is_exact() {
        assert_eq!(step_s(1.0 / 24.0, 31.0), "1/744");
        assert_eq!(step_s(1.0 / 60.0, 19.0), "1/1140");
        assert_eq!(step_of(3), "1/30");
        assert_eq!(step_s(0.4, 3.0), "0.4/3");
        for steps in 1..=64 {
            let told = step_of(steps);
            let parts = told.split('/').map(|part| part.parse().unwrap_or(f64::NAN));
            let step = parts.reduce(|above, below| above / below).unwrap_or(f64::NAN);
            assert!((step * f64::from(steps) / TENTH_S - 1.0).abs() < 1e-12, "{told}");
        }
    }
}
