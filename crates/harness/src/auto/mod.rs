//! `--method auto`: the form and the step for a scene and an error, without a run.
//!
//! The study `work-precision` measures the modelled time that each form needs on each of its scenes
//! for each error. A new scene is compared with these scenes by three numbers, and by whether a pin
//! holds it:
//!
//! * `ω`, Gershgorin's bound of its greatest angular frequency,
//! * `ζ = δ/ω`, where `δ` is the same bound of its damping over mass,
//! * `n`, its number of particles.
//!
//! A form is judged by its *factor* `f` on each scene of the study: its modelled time over that of
//! the fastest form there. Scenes near the new one weigh most. One at the same place outweighs all
//! others:
//!
//! ```text
//! q = exp(−d²)/(d² + 0.02)
//! d² = (Δ lg ω²)² + (Δ lg ζ)² + 0.3 (Δ lg n)² + 0.3 [one is held, the other is free]
//! score = (Σ q (ln f)² / Σ q)^½
//! ```
//!
//! A form that never gets to the error on a scene has `ln f = 5` there. The logarithm of the step
//! is the mean over the same scenes with the same weights. For forms that take tension at the old
//! level, the step scales with `1/ω`.
//!
//! No step is longer than the one asked for. A form that could take longer steps loses by that: its
//! score grows by the logarithm of its own step over the longest allowed one. The least score wins.
//!
//! [`judge`] checks the rule against the study itself, with and without the scene in question. The
//! table in the source is a digest of the record. `cargo run -p drape-tests --bin auto` writes the
//! table and `results/auto.md` anew.

#[cfg(test)]
mod tests;

use crate::HarnessError;
use crate::methods::Choice;
use crate::stability::gershgorin;
use crate::studies::variant::is_explicit;
use crate::studies::work_precision::facts::{Facts, Row, Run, Scene};
use drape_integrator::{PrepareError, TimeStep};
use drape_model::{System, SystemSpec, Violation};
use drape_report::number::{percent, significant};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// The id that stands for the choice.
pub const AUTO: &str = "auto";
/// The errors for which the table has numbers, as parts of the motion, the greatest first.
pub const LEVELS: [f64; 4] = [1e-1, 1e-2, 1e-3, 1e-4];
/// The error where the user gives none, as a part of the motion.
pub const USUAL_ERROR: f64 = 1e-2;
/// `ln f` of a form that does not get to an error.
const NEVER: f64 = 5.0;
/// Added to `d²` in the weight of a scene. A scene of the study at the very place of the new one
/// weighs 50, one at `d = 1` about 0.4.
const SAME: f64 = 0.02;
/// Weight of a change of size, and of pins.
const SIZE: f64 = 0.3;
const PINS: f64 = 0.3;
/// A damping `δ/ω` up to this value counts as none.
const UNDAMPED: f64 = 1e-6;
/// Bound of the damping of a scene of the study over the damping of one of its tension springs.
/// Four tension springs and four shear springs of a tenth meet at a particle, and Gershgorin's
/// bound counts each twice.
const DAMPING_BOUND: f64 = 8.8;

/// A scene as the rule sees it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// `ω`, 1/s.
    pub frequency_per_s: f64,
    /// `δ`, 1/s.
    pub damping_per_s: f64,
    /// `n`.
    pub particles: usize,
    /// Whether a pin holds it.
    pub is_held: bool,
}

impl Place {
    /// The place of a system; `None` for a system without springs.
    #[must_use]
    pub fn of(system: &System) -> Option<Self> {
        let (square, damping_per_s) = gershgorin(system);
        (square > 0.0).then(|| Self {
            frequency_per_s: square.sqrt(),
            damping_per_s,
            particles: system.len(),
            is_held: !system.pins().is_empty(),
        })
    }

    fn of_study(scene: &Scene) -> Self {
        Self {
            frequency_per_s: scene.greatest_frequency_per_s,
            damping_per_s: DAMPING_BOUND * scene.damping_over_mass_per_s,
            particles: scene.particles,
            is_held: scene.scene != "thrown",
        }
    }

    /// `d²`.
    fn distance(&self, other: &Self) -> f64 {
        let square = |x: f64| x * x;
        let ratio = |place: &Self| (place.damping_per_s / place.frequency_per_s).max(UNDAMPED);
        let pins = if self.is_held == other.is_held { 0.0 } else { PINS };
        square(2.0 * (self.frequency_per_s / other.frequency_per_s).log10())
            + square((ratio(self) / ratio(other)).log10())
            + SIZE * square((self.particles as f64 / other.particles as f64).log10())
            + pins
    }
}

/// What a form needs for an error on a scene; two numbers in the table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "(f64, f64)", into = "(f64, f64)")]
struct Reached {
    /// The step, s, or the value of `safety`.
    value: f64,
    /// Modelled time, s.
    modelled_s: f64,
}

impl From<(f64, f64)> for Reached {
    fn from((value, modelled_s): (f64, f64)) -> Self {
        Self { value, modelled_s }
    }
}

impl From<Reached> for (f64, f64) {
    fn from(reached: Reached) -> Self {
        (reached.value, reached.modelled_s)
    }
}

/// A form on a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Known {
    /// Method id with settings.
    method: String,
    /// Whether the method divides frames by itself and `safety` says how much.
    is_divided: bool,
    /// At each of [`LEVELS`], if it gets there.
    reached: Vec<Option<Reached>>,
}

/// A scene of the study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Studied {
    id: String,
    place: Place,
    forms: Vec<Known>,
}

/// What the study says, in short.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Commit that computed the record.
    pub commit: String,
    scenes: Vec<Studied>,
}

/// The parts of a record that the table needs.
#[derive(Deserialize)]
struct Record {
    facts: Facts,
    provenance: Origin,
}

#[derive(Deserialize)]
struct Origin {
    commit: String,
}

/// The table that is part of the source.
#[allow(clippy::expect_used, reason = "a test reads the same text")]
static TABLE: LazyLock<Table> =
    LazyLock::new(|| serde_json::from_str(include_str!("table.json")).expect("a valid table"));

/// The table that is part of the source.
#[must_use]
pub fn table() -> &'static Table {
    &TABLE
}

/// Four digits: what the table keeps.
fn rounded(value: f64) -> f64 {
    let digits = value.abs().log10().floor();
    if !digits.is_finite() {
        return value;
    }
    let scale = 10.0_f64.powi(3 - digits as i32);
    if scale.is_finite() { (value * scale).round() / scale } else { value }
}

/// The setting that the runs of a row vary: the step, s, or `safety`.
fn knob(row: &Row, run: &Run) -> Option<f64> {
    match row.knob.as_str() {
        "steps" => run.step_s,
        "safety" => Some(run.value),
        _ => None,
    }
}

/// The cheapest run of a row that gets to an error.
fn reached(row: &Row, level: f64) -> Option<Reached> {
    let cheapest = row.runs.iter().filter(|run| run.is_good(level));
    let cheapest = cheapest.min_by(|a, b| a.modelled_s.total_cmp(&b.modelled_s))?;
    Some(Reached { value: knob(row, cheapest)?, modelled_s: cheapest.modelled_s })
}

impl Table {
    /// The digest of a record of the study `work-precision`, from the record's JSON text.
    ///
    /// # Errors
    /// [`serde_json::Error`] where the text is no such record.
    pub fn of_record(text: &str) -> serde_json::Result<Self> {
        let Record { facts, provenance } = serde_json::from_str(text)?;
        let digest = |reached: Reached| Reached {
            value: rounded(reached.value),
            modelled_s: rounded(reached.modelled_s),
        };
        let form = |row: &Row| Known {
            method: row.method.clone(),
            is_divided: row.knob == "safety",
            reached: LEVELS.map(|level| reached(row, level).map(digest)).to_vec(),
        };
        let scene = |scene: &Scene| Studied {
            id: scene.id.clone(),
            place: Place::of_study(scene),
            forms: rows(&facts, &scene.id).map(form).collect(),
        };
        let scenes = facts.scenes.iter().map(scene).collect();
        Ok(Self { commit: provenance.commit, scenes })
    }
}

/// The rows of a scene that may be chosen.
fn rows<'a>(facts: &'a Facts, scene: &'a str) -> impl Iterator<Item = &'a Row> {
    let is_ours = |row: &&Row| Choice::parse(&row.method, &[]).is_ok();
    let is_turned = |row: &&Row| matches!(row.knob.as_str(), "steps" | "safety");
    facts.rows.iter().filter(move |row| row.scene == scene).filter(is_ours).filter(is_turned)
}

/// A form with what the rule says of it on a scene.
#[derive(Clone, Debug, PartialEq)]
struct Candidate<'a> {
    form: &'a Known,
    /// Least is best; `exp` of it is about the factor over the best form.
    score: f64,
    /// Step, s, or `safety`; `None` where the form gets to the error on no scene of the study.
    value: Option<f64>,
}

/// All forms on a scene for an error, the best one first. Leaves out the scene `but`.
fn ranking<'a>(
    table: &'a Table,
    place: &Place,
    level: usize,
    but: Option<&str>,
    longest: f64,
) -> Vec<Candidate<'a>> {
    struct Sum<'a> {
        form: &'a Known,
        squares: f64,
        steps: (f64, f64),
    }
    let mut sums: BTreeMap<(&str, bool), Sum<'a>> = BTreeMap::new();
    let mut total = 0.0;
    let scenes = || table.scenes.iter().filter(move |scene| Some(scene.id.as_str()) != but);
    for form in scenes().flat_map(|scene| &scene.forms) {
        let sum = Sum { form, squares: 0.0, steps: (0.0, 0.0) };
        sums.entry((form.method.as_str(), form.is_divided)).or_insert(sum);
    }
    for scene in scenes() {
        let reached = |form: &Known| form.reached.get(level).copied().flatten();
        let best = scene.forms.iter().filter_map(reached).map(|reached| reached.modelled_s);
        let best = best.fold(f64::INFINITY, f64::min);
        if best.is_infinite() {
            continue;
        }
        let distance = place.distance(&scene.place);
        let weight = (-distance).exp() / (distance + SAME);
        total += weight;
        for ((method, is_divided), sum) in &mut sums {
            let own =
                scene.forms.iter().find(|f| f.method == *method && f.is_divided == *is_divided);
            let found = own.and_then(reached);
            let factor = found.map_or(NEVER, |found| (found.modelled_s / best).ln().min(NEVER));
            sum.squares += weight * factor * factor;
            if let Some(found) = found {
                let scales = !is_divided && is_limited(method);
                let scale =
                    if scales { scene.place.frequency_per_s / place.frequency_per_s } else { 1.0 };
                sum.steps.0 += weight * (found.value * scale).ln();
                sum.steps.1 += weight;
            }
        }
    }
    let candidate = |Sum { form, squares, steps: (sum, weight) }| {
        let value = (weight > 0.0).then(|| f64::exp(sum / weight));
        let longer =
            value.filter(|_| !form.is_divided).map_or(0.0, |h| (h / longest).ln().max(0.0));
        let score = if total > 0.0 { f64::sqrt(squares / total) } else { NEVER };
        Candidate { form, score: score + longer, value }
    };
    let mut all: Vec<_> = sums.into_values().map(candidate).collect();
    all.sort_by(|a, b| a.score.total_cmp(&b.score));
    all
}

/// Whether the stiffness limits the step.
fn is_limited(method: &str) -> bool {
    Choice::parse(method, &[]).is_ok_and(|choice| is_explicit(choice.method()))
}

/// The error and the steps that the user asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// Greatest error, as a part of the motion.
    pub error: f64,
    /// The step that the user gave, s; the choice keeps it.
    pub step_s: Option<f64>,
    /// The step of the scene, s. Without a given step, the choice divides it evenly.
    pub frame_s: f64,
}

/// The error that a text such as `auto:error=0.01` and further settings ask for, as a part of the
/// motion; `None` where the text names a method.
///
/// # Errors
/// [`Violation`] for a setting other than `error`, and for an error outside the range of the study.
pub fn wanted(text: &str, more: &[String]) -> Result<Option<f64>, Violation> {
    let (id, settings) = text.split_once(':').unwrap_or((text, ""));
    if id != AUTO {
        return Ok(None);
    }
    let least = LEVELS[LEVELS.len() - 1];
    let wrong = |value: &str| Violation {
        path: "--method auto".to_owned(),
        value: format!("`{value}`"),
        expected: format!("error=E with E from {least} to 1, the error as a part of the motion"),
    };
    let mut error = USUAL_ERROR;
    let own = settings.split(',').filter(|text| !text.trim().is_empty());
    for text in own.chain(more.iter().map(String::as_str)) {
        let value = text.split_once('=').filter(|(key, _)| key.trim() == "error");
        let value = value.and_then(|(_, value)| value.trim().parse::<f64>().ok());
        error = value.filter(|e| (least..=1.0).contains(e)).ok_or_else(|| wrong(text))?;
    }
    Ok(Some(error))
}

/// The form and the step that were chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Pick {
    /// Method id with settings.
    pub method: String,
    /// The step, s.
    pub step_s: f64,
    /// Whether the error should be met with the step.
    pub is_met: bool,
    /// Why, in two or three sentences.
    pub reason: String,
}

/// Chooses a form and a step for a frozen system.
///
/// # Errors
/// [`HarnessError`] where a value of the system is refused, where the cloth has no springs, and
/// where every form refuses the system.
pub fn choose(spec: &SystemSpec, wish: Wish) -> Result<Pick, HarnessError> {
    let (system, _) = spec.build()?;
    let none = |value: &str| Violation {
        path: "--method auto".to_owned(),
        value: value.to_owned(),
        expected: "a cloth with springs that a method of the study supports; name a method"
            .to_owned(),
    };
    let place = Place::of(&system).ok_or_else(|| none("a cloth without springs"))?;
    let table = table();
    // The greatest level that is within the error.
    let level = LEVELS.iter().position(|level| *level <= wish.error * (1.0 + 1e-9));
    let level = level.unwrap_or(LEVELS.len() - 1);
    let supports = |candidate: &Candidate<'_>| {
        let choice = Choice::parse(&candidate.form.method, &[]);
        choice.is_ok_and(|choice| choice.method().check(&system).is_ok())
    };
    let longest = wish.step_s.unwrap_or(wish.frame_s);
    let mut all = ranking(table, &place, level, None, longest);
    all.retain(|candidate| candidate.value.is_some() && supports(candidate));
    loop {
        let (first, is_met) =
            first(&all, wish.step_s).ok_or_else(|| none("no form supports the scene"))?;
        let pick = picked(first, wish, is_met);
        if refuses(&pick, &system) {
            let method = first.form.method.clone();
            all.retain(|candidate| candidate.form.method != method);
            continue;
        }
        let reason = reason(table, &place, LEVELS[level], &pick, first, &all);
        return Ok(Pick { reason, ..pick });
    }
}

/// The form and the step of a candidate.
fn picked(candidate: &Candidate<'_>, wish: Wish, is_met: bool) -> Pick {
    let Known { method, is_divided, .. } = candidate.form;
    let longest = wish.step_s.unwrap_or(wish.frame_s);
    let value = candidate.value.unwrap_or(longest);
    let separator = if method.contains(':') { ',' } else { ':' };
    let (method, own) = if *is_divided {
        (format!("{method}{separator}safety={}", rounded(value)), wish.frame_s)
    } else {
        (method.clone(), part_of(wish.frame_s, value))
    };
    Pick { method, step_s: wish.step_s.unwrap_or(own), is_met, reason: String::new() }
}

/// Whether a form refuses a system whose effects its method supports: a limit of the step, for
/// example, is known for springs alone.
fn refuses(pick: &Pick, system: &System) -> bool {
    let integrator = Choice::parse(&pick.method, &[]).ok().and_then(|choice| choice.build().ok());
    let prepared = integrator.zip(TimeStep::new(pick.step_s).ok());
    let outcome = prepared.map(|(mut integrator, step)| integrator.prepare(system, step));
    matches!(outcome, Some(Err(PrepareError::Unsupported { .. })))
}

/// The first candidate that should keep the error with the given step, and `true`. Where no
/// candidate does, the candidate whose own step is the longest, and `false`.
fn first<'a>(all: &'a [Candidate<'a>], step: Option<f64>) -> Option<(&'a Candidate<'a>, bool)> {
    let own = |candidate: &Candidate<'_>| candidate.value.filter(|_| !candidate.form.is_divided);
    let serves = |candidate: &&Candidate<'_>| {
        own(candidate).zip(step).is_none_or(|(own, given)| own >= given * (1.0 - 1e-9))
    };
    if let Some(first) = all.iter().find(serves) {
        return Some((first, true));
    }
    let length = |candidate: &Candidate<'_>| own(candidate).unwrap_or(0.0);
    let longest = all.iter().max_by(|a, b| length(a).total_cmp(&length(b)));
    longest.map(|longest| (longest, false))
}

/// The longest step of at most `most`, s, that divides a frame evenly, s.
fn part_of(frame: f64, most: f64) -> f64 {
    frame / (frame / most * (1.0 - 1e-9)).ceil().max(1.0)
}

fn reason(
    table: &Table,
    place: &Place,
    level: f64,
    pick: &Pick,
    first: &Candidate<'_>,
    all: &[Candidate<'_>],
) -> String {
    let nearest = table
        .scenes
        .iter()
        .min_by(|a, b| place.distance(&a.place).total_cmp(&place.distance(&b.place)));
    let nearest = nearest.map_or_else(String::new, |scene| format!("`{}`", scene.id));
    let id = |candidate: &Candidate<'_>| candidate.form.method.split(':').next().map(str::to_owned);
    let own = id(first);
    let other = all.iter().find(|candidate| id(candidate) != own && candidate.score >= first.score);
    let next = other.map_or_else(String::new, |other| {
        let lead = (other.score - first.score).exp();
        format!(
            "; the next method, {}, takes some {} times as long as this one",
            other.form.method,
            significant(lead, 2)
        )
    });
    let short = if pick.is_met {
        String::new()
    } else {
        format!(
            " No form should keep this error with steps of {} s: this one comes nearest.",
            significant(pick.step_s, 2)
        )
    };
    format!(
        "{} with steps of {} s, for an error of {} of the motion. With ω = {}/s, damping {}/s and \
         {} particles the cloth is nearest to {nearest} of the study work-precision; weighed over \
         its scenes, this form takes some {} times as long as the fastest{next}.{short}",
        pick.method,
        significant(pick.step_s, 3),
        percent(level, 2),
        significant(place.frequency_per_s, 2),
        significant(place.damping_per_s, 2),
        place.particles,
        significant(first.score.exp(), 2),
    )
}

/// The rule on one scene and error of the study.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The scene.
    pub scene: String,
    /// The error.
    pub level: f64,
    /// The form.
    pub method: String,
    /// Least modelled time of the form at this error, over that of the best form; `None` where the
    /// form does not get to the error.
    pub regret: Option<f64>,
    /// Whether the form keeps the error with the foreseen step.
    pub is_met: bool,
    /// Modelled time with the foreseen step over that of the best form; `None` where the error is
    /// not met.
    pub with_step: Option<f64>,
}

/// Checks the rule against a record of the study `work-precision`, given as JSON text. With
/// `is_held_out`, the choice for each scene rests on the other scenes alone.
///
/// # Errors
/// [`serde_json::Error`] where the text is no such record.
pub fn judge(text: &str, is_held_out: bool) -> serde_json::Result<Vec<Case>> {
    let table = Table::of_record(text)?;
    let Record { facts, .. } = serde_json::from_str(text)?;
    let mut cases = Vec::new();
    for scene in &facts.scenes {
        for (number, level) in LEVELS.into_iter().enumerate() {
            let all: Vec<&Row> = rows(&facts, &scene.id).collect();
            let times = all.iter().filter_map(|row| reached(row, level));
            let best = times.map(|reached| reached.modelled_s).fold(f64::INFINITY, f64::min);
            let but = is_held_out.then_some(scene.id.as_str());
            let place = Place::of_study(scene);
            let ranked = ranking(&table, &place, number, but, f64::INFINITY);
            let Some(first) = ranked.first().filter(|_| best.is_finite()) else { continue };
            let is_own = |row: &&&Row| {
                row.method == first.form.method && (row.knob == "safety") == first.form.is_divided
            };
            let row = all.iter().find(is_own);
            let most = first.value.unwrap_or(f64::INFINITY) * (1.0 + 1e-3);
            let run = row.and_then(|row| {
                let turned = row.runs.iter().filter_map(|run| Some((knob(row, run)?, run)));
                let short = turned.filter(|(value, _)| *value <= most);
                short.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, run)| run)
            });
            let met = run.filter(|run| run.error.is_some_and(|error| error <= level));
            cases.push(Case {
                scene: scene.id.clone(),
                level,
                method: first.form.method.clone(),
                regret: row.and_then(|row| reached(row, level)).map(|r| r.modelled_s / best),
                is_met: met.is_some(),
                with_step: met.map(|run| run.modelled_s / best),
            });
        }
    }
    Ok(cases)
}
