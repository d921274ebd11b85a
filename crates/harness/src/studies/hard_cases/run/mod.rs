//! Experiment `hard-cases`: every method on scenes where methods fail.

mod cell;
mod explanations;
mod scenes;
mod survey;
#[cfg(test)]
mod tests;
mod tweak;

use crate::HarnessError;
use crate::facts::{Fact, fact};
use crate::studies::hard_cases::facts::{Case, Facts};
use crate::studies::{Context, Measured, Start, cells, prepared};
use cell::{BUDGET, SEEDS, Stage, cell};
use std::collections::BTreeMap;

pub(crate) use survey::{HardCase, survey};

/// The cases and their cells.
fn facts(context: &Context<'_>, cases: &[scenes::Case]) -> Result<(Facts, Hashes), HarnessError> {
    let settings: Vec<_> =
        cases.iter().flat_map(|case| [false, true].map(|is_damped| (case, is_damped))).collect();
    let stages =
        prepared(context, "scenes", &settings, |&(case, is_damped)| Stage::new(case, is_damped))?;
    let forms = tweak::forms();
    let pairs: Vec<_> =
        stages.iter().flat_map(|stage| forms.iter().map(move |form| (form, stage))).collect();
    let cells = cells(context, "verdicts", &pairs, |(form, stage)| cell(form, stage))?.all()?;
    let unexplained = cells.iter().filter(|cell| cell.differs && cell.explanation.is_none());
    let unexplained = unexplained.map(|cell| {
        let damping = if cell.is_damped { "damped" } else { "undamped" };
        format!("{}, {damping}: {} is {}", cell.case, cell.method, cell.verdict)
    });
    let facts = Facts {
        unexplained: unexplained.collect(),
        cases: cases.iter().map(|case| of_case(case, &stages)).collect(),
        methods: forms.iter().map(|form| form.label.to_owned()).collect(),
        cells,
    };
    let hash = |stage: &Stage<'_>| (stage.case.name(), stage.hash.clone());
    Ok((facts, stages.iter().filter(|stage| stage.is_damped).map(hash).collect()))
}

type Hashes = BTreeMap<String, String>;

fn of_case(case: &scenes::Case, stages: &[Stage<'_>]) -> Case {
    let mut record = Case {
        name: case.name(),
        scene: case.scene.to_owned(),
        judged: case.judged().to_owned(),
        particles: 0,
        springs: 0,
        step_s: 0.0,
        steps: 0,
        duration_s: 0.0,
        released_undamped_j: 0.0,
        released_damped_j: 0.0,
    };
    for stage in stages.iter().filter(|stage| stage.case.name() == record.name) {
        let schedule = &stage.case.setup.schedule;
        record.particles = stage.scenery.spec.particles.mass_kg.len();
        record.springs = stage.scenery.spec.springs.len();
        record.step_s = schedule.time.step_s;
        record.steps = schedule.steps();
        record.duration_s = schedule.time.duration_s;
        let released = stage.reference.energy;
        if stage.is_damped {
            record.released_damped_j = released;
        } else {
            record.released_undamped_j = released;
        }
    }
    record
}

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "Every method runs every case without and with damping, for at least 2 s and 200 steps. \
         Damping is full: d/m = 40 s⁻¹ for tension springs, a tenth of that for shear springs. A \
         case has {} starts, and the worst verdict counts. Each start is perturbed by up to 1e-4 \
         mesh widths, or by less if that would store more than a thousandth of the available \
         energy. E_ref is the energy that the scene sets free on its true motion. Symplectic \
         Euler at a quarter of its stability limit computes that motion, at most at k/m = 1e7, in \
         H03 at most at 1e6, in H07 and H22 with a mass ratio of 10. A run is stable if its \
         energy H never exceeds its start by more than 0.02 E_ref, marginal up to 0.5 E_ref, and \
         unstable above. It has diverged if a position is not finite, or farther away than a \
         thousand scene sizes plus twice the distance that fall and throw can cover. Without \
         damping and contacts, the energy of symplectic methods may oscillate by 0.5 E_ref, but \
         must not drift by more than 0.05 E_ref over the run. A step counts as a rise if H grows \
         by more than 1e-9 E_ref and round-off. Theory uses only the scene and the settings. \
         Three of its rules were derived after first runs had failed: for terzopoulos-fleischer; \
         for baraff-witkin and the two-step methods in H16; and for the divided steps of leapfrog \
         in H14. A run ends over budget after {BUDGET:e} visits of a spring, which are counted, \
         not timed.",
        SEEDS.len()
    )
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    let both = |case: scenes::Case| {
        let make = case.setup.system;
        [true, false].map(|is_damped| {
            let undamped = if is_damped { "" } else { ", undamped" };
            let name = format!("{}{undamped}", case.name());
            Start::new(name, move || Ok(scenes::Scenery::new(make, is_damped)?.spec))
        })
    };
    scenes::all().into_iter().flat_map(both).collect()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts>, HarnessError> {
    let mut cases = scenes::all();
    cases.retain(|case| case.is_quick || !context.quick);
    let (facts, hashes) = facts(context, &cases)?;
    let (facts, scenes, seed) = (facts, hashes, Some(SEEDS[0]));
    Ok(Measured { facts, timings: None, scenes, seed })
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let cases = facts.cases.iter().map(|case| fact(case.name.clone(), true, case));
    let cells = facts.cells.iter().map(|c| {
        let damping = if c.is_damped { "damped" } else { "undamped" };
        let mut fact = fact(format!("{}, {damping}: {}", c.case, c.method), c.portable, c);
        if let serde_json::Value::Object(values) = &mut fact.values
            && !c.portable
        {
            // Long runs on hard scenes are chaotic. Where a library's functions rounded, only the
            // verdict can be repeated.
            values.retain(|_, value| !value.is_number());
        }
        fact
    });
    cases.chain(cells).collect()
}
