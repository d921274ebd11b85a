//! Experiment `collision`: ways out of an obstacle (EEH section 6).

mod bounce;
mod fall;
#[cfg(test)]
mod tests;

use crate::HarnessError;
use crate::facts::{Fact, fact};
use crate::studies::collision::facts::{Facts, POSITION, Row, TELEPORT, VELOCITY};
use crate::studies::{Context, Measured, Start, prepared, taken};
use drape_report::Verdict;
use fall::{Case, DURATION, SIDE, STEP, Stage, Target};
use rayon::prelude::*;

/// A method with a way out of the obstacle.
#[derive(Clone, Copy, Debug)]
struct Form {
    label: &'static str,
    way_out: &'static str,
    method: &'static str,
    /// Whether the form runs only in the middle of the sweep.
    is_costly: bool,
}

const fn form(label: &'static str, way_out: &'static str, method: &'static str) -> Form {
    Form { label, way_out, method, is_costly: false }
}

const fn costly(form: Form) -> Form {
    Form { is_costly: true, ..form }
}

const IMEX: &str = "imex-euler:implicit=springs";
const IMEX_LAST: &str = "imex-euler:implicit=springs,start=last";
const UPDATED: &str = "imex-updated:implicit=springs";
const BACKWARD: &str = "backward-euler:solver=cholesky";
const DESBRUN: &str = "desbrun";

const FORMS: [Form; 13] = [
    form("imex-euler", VELOCITY, IMEX),
    form("imex-euler", TELEPORT, IMEX),
    // A move by hand ends the extrapolation of the start value. This form shows what that alone
    // costs.
    form("imex-euler from v_n", VELOCITY, IMEX_LAST),
    form("imex-euler from v_n", TELEPORT, IMEX_LAST),
    form("imex-updated", VELOCITY, UPDATED),
    form("imex-updated", TELEPORT, UPDATED),
    form("baraff-witkin", VELOCITY, "baraff-witkin:contact=velocity"),
    form("baraff-witkin", POSITION, "baraff-witkin:contact=position"),
    form("baraff-witkin", TELEPORT, "baraff-witkin"),
    costly(form("backward-euler", VELOCITY, BACKWARD)),
    costly(form("backward-euler", TELEPORT, BACKWARD)),
    form("desbrun", VELOCITY, DESBRUN),
    form("desbrun", TELEPORT, DESBRUN),
];

/// The scenes: each obstacle, speed and stiffness; the middle speed with half the step; and a sheet
/// that lies on the table, with and without shear springs.
fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for target in [Target::Table, Target::Sphere, Target::Plane] {
        for stiffness in [1e4, 1e6] {
            for (speed, step) in [(1.0, STEP), (3.0, STEP), (10.0, STEP), (3.0, 0.5 * STEP)] {
                cases.push(Case { target, speed, stiffness, step, has_shear: true });
            }
        }
    }
    for has_shear in [true, false] {
        let lying = |stiffness| Case {
            target: Target::Table,
            speed: 0.0,
            stiffness,
            step: STEP,
            has_shear,
        };
        cases.extend([1e4, 1e6].map(lying));
    }
    cases
}

fn bounces() -> Vec<bounce::Case> {
    let mut cases = Vec::new();
    for restitution in [0.0, 0.5, 1.0] {
        for speed in [1.0, 3.0, 10.0] {
            for target in [Target::Plane, Target::Table, Target::Sphere] {
                cases.push(bounce::Case { is_sheet: false, target, speed, restitution });
            }
        }
        let target = Target::Plane;
        cases.push(bounce::Case { is_sheet: true, target, speed: 3.0, restitution });
    }
    cases
}

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "A sheet of {SIDE} × {SIDE} particles falls without friction and restitution on a table \
         of half its width, a sphere of 0.3 m radius or a plane. It has structural springs, shear \
         springs of a tenth of the stiffness, and full damping of d/m = 40 s⁻¹. Vertical speeds \
         of 0.3 m/s ripple it. It meets the obstacle within 0.1 s and runs for {DURATION} s with \
         h = {STEP} s, or half of that in some scenes. A flat sheet that lies on the table (speed \
         0) runs for 1 s, with and without shear springs. A method leaves the obstacle in one of \
         three ways. `velocity` is the constraint of EEH section 6. `position` is Baraff and \
         Witkin's alteration of positions within the step. With `teleport` the method does not \
         know of the obstacle. After each step the study moves particles that are inside to the \
         surface and removes their normal velocity, and the method forgets its history. The \
         iterations are CG iterations, and for backward Euler Newton iterations with one \
         factorisation each. Depth is measured at the end of a step, before the study moves \
         anything. The energy of release sums the rises of the energy in steps in which particles \
         leave the obstacle. Gains refer to the initial kinetic energy plus the energy that the \
         drop and a further sag of 0.25 m set free. Restitution is tested with one particle and \
         with a flat sheet. The study measures the normal speed of the centre of mass after the \
         first contact over the speed before it, and the height that it reaches again."
    )
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    cases().into_iter().map(|case| Start::new(case.id(), move || case.spec())).collect()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts>, HarnessError> {
    let mut chosen = cases();
    chosen.retain(|case| !context.quick || (case.is_middle() && case.target == Target::Table));
    let stages = prepared(context, "scenes", &chosen, Stage::new)?;
    let pairs: Vec<_> = stages
        .iter()
        .flat_map(|stage| FORMS.iter().map(move |form| (form, stage)))
        .filter(|(form, stage)| !form.is_costly || (stage.case.is_middle() && !context.quick))
        .collect();
    let rows = taken(context, "falls", &pairs, |(form, stage)| fall::row(form, stage))?;
    let mut bouncing = bounces();
    bouncing.retain(|case| !context.quick || !case.is_sheet);
    let pairs: Vec<_> =
        bouncing.iter().flat_map(|case| FORMS.iter().map(move |form| (form, case))).collect();
    let bounces = taken(context, "rebounds", &pairs, |(form, case)| bounce::bounce(form, case))?;
    let scenes = stages.iter().map(|stage| stage.scene.clone()).collect();
    let facts = Facts { scenes, rows: rows.all()?, bounces: bounces.all()? };
    let (facts, scenes, seed) = (
        facts,
        stages.iter().map(|stage| (stage.scene.id.clone(), stage.hash.clone())).collect(),
        None,
    );
    Ok(Measured { facts, timings: None, scenes, seed })
}

/// The runs of the paper's system in all scenes, with the constraint and with repositioning.
pub(in crate::studies) fn repositioned() -> Result<Vec<Row>, HarnessError> {
    let stages = cases().iter().map(Stage::new).collect::<Result<Vec<_>, _>>()?;
    let own = |form: &&Form| [IMEX, UPDATED].contains(&form.method);
    let pairs: Vec<_> = stages
        .iter()
        .flat_map(|stage| FORMS.iter().filter(own).map(move |form| (form, stage)))
        .collect();
    pairs.par_iter().map(|(form, stage)| fall::row(form, stage)).collect()
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let Facts { scenes, rows, bounces } = facts;
    let scenes = scenes.iter();
    let scenes = scenes.map(|scene| fact(format!("scene {}", scene.id), scene.portable, scene));
    let rows = rows.iter().map(|row| {
        let key = format!("{} {} {}", row.scene, row.label, row.way_out);
        if row.portable {
            return fact(key, true, row);
        }
        // Contacts open and close, so the effect of round-off on a run cannot be bounded.
        fact(key, false, &Stability { is_stable: row.verdict == Verdict::Stable })
    });
    let bounces = bounces.iter().map(|bounce| {
        let key = format!(
            "{} on {} at {} m/s, e = {}: {} {}",
            bounce.body,
            bounce.obstacle,
            bounce.speed_m_s,
            bounce.restitution,
            bounce.label,
            bounce.way_out
        );
        fact(key, bounce.portable, bounce)
    });
    scenes.chain(rows).chain(bounces).collect()
}

/// The part of a run that is compared if its bits depend on the machine.
#[derive(serde::Serialize)]
struct Stability {
    is_stable: bool,
}
