//! Experiment `effects`: the cost of each effect.
//!
//! Each addition is measured by itself. All together has one addition for each place of a scene
//! (tension, shear, bending, damping, air, obstacle). Other additions of the same place are left
//! out there.

mod additions;
mod runs;
#[cfg(test)]
mod tests;

use crate::facts::{Fact, fact};
use crate::methods::{self, Choice};
use crate::studies::effects::facts::{EVERYTHING, Facts, NOTHING, Support, TimingRow};
use crate::studies::{Context, Measured, Start, cells, prepared, timed, variant};
use crate::{HarnessError, system_hash};
use additions::Addition;
use drape_integrator::Method;
use runs::Variant;

/// Simulated time, s.
const DURATION: f64 = 0.5;
/// Step of methods that take tension at the new time level, s.
const STEP: f64 = 0.01;
/// Step of methods that take tension at the old time level, s.
const EXPLICIT_STEP: f64 = 0.001;
/// Number of pairs of timed runs.
const PAIRS: usize = 5;
/// Ids of the methods that are timed.
fn timed_methods() -> impl Iterator<Item = &'static str> {
    methods::runs().filter(|(_, runs)| runs.are_effects_timed).map(|(method, _)| method.id)
}

fn step(method: &Method) -> f64 {
    if variant::is_explicit(method) { EXPLICIT_STEP } else { STEP }
}

/// How each method treats each effect that some method supports.
fn supports() -> Vec<Support> {
    let mut effects: Vec<&str> = Vec::new();
    for support in methods::all().flat_map(Method::supports) {
        if !effects.contains(&support.effect) {
            effects.push(support.effect);
        }
    }
    let of = |effect: &str, method: &'static Method| {
        let support = method.supports().find(|support| support.effect == effect);
        Support {
            effect: effect.to_owned(),
            method: method.id.to_owned(),
            treatment: support.map_or("refused", |support| support.treatment.name()).to_owned(),
        }
    };
    effects.iter().flat_map(|effect| methods::all().map(move |method| of(effect, method))).collect()
}

/// How the timings are taken.
pub(super) fn timing() -> String {
    format!(
        "The same run with and without the effect, in turns, {PAIRS} times each. One run at a \
         time on one thread, without set-up and with the phase clock off. The ratio is that of \
         the shortest runs. Bytes are the memory that the allocator holds for the system and for \
         the prepared method, less the memory without the effect."
    )
}

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "An undamped sheet of 20 × 20 particles, 1 m × 1 m, 0.4 kg, with tension springs of k/m = \
         1e4/s², falls for {DURATION} s from the horizontal and hangs by two corners. Each effect \
         is added to this scene alone, then all effects together. Where several effects take the \
         same place in a scene, such as two laws of bending, the last case has one of them. The \
         step is h = {STEP} s, or {EXPLICIT_STEP} s for methods that take tension at the old time \
         level. Every method runs at its defaults. The change is the distance between the final \
         particles with the effect and without it, with the same method."
    )
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    let start = |addition: Addition| {
        Start::new(addition.name, move || additions::scene(addition.name, &addition.adds))
    };
    additions::all().into_iter().map(start).collect()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let additions: Vec<Addition> = additions::all();
    let variants = prepared(context, "scenes", &additions, Variant::new)?;
    let nothing = &variants[0];
    let chosen: Vec<&'static Method> = methods::runs()
        .filter(|(_, runs)| !context.quick || runs.are_effects_quick)
        .map(|(method, _)| method)
        .collect();
    let pairs: Vec<_> = variants
        .iter()
        .filter(|variant| {
            let name = variant.effect.name.as_str();
            !context.quick || [NOTHING, EVERYTHING].contains(&name)
        })
        .flat_map(|variant| chosen.iter().map(move |method| (variant, *method)))
        .collect();
    let cells =
        cells(context, "runs", &pairs, |(variant, method)| variant.cell(nothing, method))?.all()?;
    let facts = Facts {
        scene: additions::base().to_string(),
        duration_s: DURATION,
        effects: variants.iter().map(|variant| variant.effect.clone()).collect(),
        methods: chosen.iter().map(|method| method.id.to_owned()).collect(),
        supports: supports(),
        cells,
    };
    let scenes: std::collections::BTreeMap<_, _> = variants
        .iter()
        .map(|variant| (variant.effect.name.clone(), system_hash(&variant.spec)))
        .collect();
    let mut timings = None;
    if !context.quick {
        let variants = variants[1..].iter();
        let pairs: Vec<_> = variants
            .flat_map(|variant| timed_methods().map(move |method| (variant, method)))
            .collect();
        let rows = timed(context, "timings", &pairs, |(variant, method)| {
            let choice = Choice::parse(method, &[])?;
            variant.time(nothing, &choice, context.allocated)
        })?
        .all()?;
        timings = Some(rows.into_iter().flatten().collect());
    }
    Ok(Measured { facts, timings, scenes, seed: None })
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let Facts { effects, supports, cells, .. } = facts;
    let effects =
        effects.iter().map(|effect| fact(format!("effect {}", effect.name), true, effect));
    let supports = supports.iter().map(|support| {
        fact(format!("support of {} by {}", support.effect, support.method), true, support)
    });
    let cells = cells
        .iter()
        .map(|cell| fact(format!("{} with {}", cell.effect, cell.method), cell.portable, cell));
    effects.chain(supports).chain(cells).collect()
}
