//! Experiment `hard-cases`: every method where methods fail.

mod cell;
mod expectation;
mod explanations;
mod linear;
mod scenes;
mod survey;
#[cfg(test)]
mod tests;
mod tweak;

use cell::{BUDGET, SEEDS, Stage, cell};
use crate::HarnessError;
use crate::facts::{Fact, fact};
use crate::studies::hard_cases::facts::{Case, Cell, Facts};
use crate::studies::{Account, Context, cells, prepared, short};
use drape_report::Record;
use expectation::{Kind, NOTHING_MOVES};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use super::STUDY;

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
    let cells = cells(context, "verdicts", &pairs, |(form, stage)| cell(form, stage))?;
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

pub(super) fn run(context: &Context<'_>) -> Result<Vec<PathBuf>, HarnessError> {
    let mut cases = scenes::all();
    cases.retain(|case| case.is_quick || !context.quick);
    let (facts, hashes) = facts(context, &cases)?;
    let findings = findings(&facts);
    let account = Account {
        method: format!(
            "Every method runs every case without and with damping (full; 40/s over the mass for tension springs, a \
             tenth for shear springs) for at least 2 s and 200 steps, from {} starts that are perturbed by up to 1e-4 \
             mesh widths (less where that would store more than a thousandth of the available energy in the \
             springs); the worst verdict counts. The verdict is by the total energy H against E_ref, what the scene \
             sets free on its true motion (symplectic Euler at a quarter of its stability limit; at most k/m = 1e7, \
             in H03 1e6, in H07 a mass ratio of 10): stable if H never exceeds its start by more than 0.02 E_ref, \
             marginal up to 0.5, unstable above, diverged if a position is not finite or a thousand scene sizes \
             away. Undamped and without contacts, symplectic methods may oscillate by 0.5 E_ref, but must not drift \
             by more than 0.05 E_ref over the run. A step counts as a rise if H grows by more than 1e-9 E_ref and \
             round-off. What theory says follows from the scene and the settings alone. Its rules for \
             terzopoulos-fleischer, in H16 for baraff-witkin and the two-step methods, and in H14 for the divided steps of \
             leapfrog, were derived after first runs \
             had failed: where they agree they explain, they do not predict. A run ends \
             over budget after {BUDGET:e} visits of a spring, which are counted, not timed: about two seconds.",
            SEEDS.len()
        ),
        findings,
        facts,
        scenes: hashes,
        seed: Some(SEEDS[0]),
    };
    Ok(vec![context.write(&STUDY, account)?])
}

fn list(texts: impl IntoIterator<Item = String>) -> String {
    texts.into_iter().collect::<Vec<_>>().join(", ")
}

/// Its facts, as they are compared.
pub(crate) fn comparable(record: &Record<Facts>) -> Vec<Fact> {
    let cases = record.facts.cases.iter().map(|case| fact(case.name.clone(), true, case));
    let cells = record.facts.cells.iter().map(|c| {
        let damping = if c.is_damped { "damped" } else { "undamped" };
        let mut fact = fact(format!("{}, {damping}: {}", c.case, c.method), c.portable, c);
        if let serde_json::Value::Object(values) = &mut fact.values
            && !c.portable
        {
            // Long runs on hard scenes are chaotic: of what passed through a library only the verdict is repeatable.
            values.retain(|_, value| !value.is_number());
        }
        fact
    });
    cases.chain(cells).collect()
}

/// What the numbers say.
fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    let decided = |cell: &&Cell| {
        matches!(cell.verdict.as_str(), "stable" | "marginal" | "unstable" | "diverged")
    };
    let of = |method: &str| facts.cells.iter().filter(|c| c.method == method).collect::<Vec<_>>();
    let (mut everywhere, mut others) = (Vec::new(), Vec::new());
    for method in &facts.methods {
        let cells = of(method);
        let count = |verdict: &str| cells.iter().filter(|c| c.verdict == verdict).count();
        let (all, stable) = (cells.iter().copied().filter(|c| decided(c)).count(), count("stable"));
        if all == stable {
            everywhere.push(format!("{method} ({stable})"));
        } else {
            others.push(format!("{method} {stable} of {all}"));
        }
    }
    if !everywhere.is_empty() {
        findings.push(format!("Stable in every run that came to a verdict: {}.", list(everywhere)));
    }
    if !others.is_empty() {
        findings.push(format!("Stable runs of those that came to a verdict: {}.", list(others)));
    }
    findings.extend(theorem_finding(facts));
    findings.extend(explicit_shear_finding(facts));
    findings.extend(safeguard_finding(facts));
    findings.extend(rest_finding(facts));
    findings.extend(budget_finding(facts));
    let differing: Vec<_> = facts.cells.iter().filter(|cell| cell.differs).collect();
    let explained = differing.len() - facts.unexplained.len();
    let predicted =
        facts.cells.iter().filter(decided).filter(|c| c.expected != "no theorem").count();
    let trivial = facts.cells.iter().filter(decided).filter(|c| c.reason == NOTHING_MOVES).count();
    findings.push(format!(
        "Theory says something about {predicted} of the cells with a verdict ({trivial} of them without a moving \
         spring); {} differ from it, {explained} with an explanation below.",
        differing.len()
    ));
    if !facts.unexplained.is_empty() {
        findings.push(format!("Unexplained: {}.", facts.unexplained.join("; ")));
    }
    findings
}

/// Allowance for round-off over `E_ref` beyond which a count of rises says nothing.
const VISIBLE: f64 = 1e-3;

/// The energy theorem, counted.
fn theorem_finding(facts: &Facts) -> Option<String> {
    let count = |is_counted: &dyn Fn(&Cell) -> bool| {
        let cells = facts.cells.iter().filter(|cell| is_counted(cell));
        cells.fold((0, 0), |(steps, rises), c| (steps + c.steps, rises + c.rises))
    };
    let is_seen = |cell: &Cell| cell.round_off <= VISIBLE;
    let is_monotone = |cell: &Cell| cell.expected == Kind::Monotone.name();
    let (steps, rises) = count(&|cell| is_monotone(cell) && is_seen(cell));
    let (newton, newton_rises) = count(&|cell| cell.method == "backward-euler" && is_seen(cell));
    let blind = facts.cells.iter().filter(|cell| is_monotone(cell) && !is_seen(cell));
    let blind: BTreeSet<_> = blind.map(|cell| cell.case.clone()).collect();
    let blind = if blind.is_empty() {
        String::new()
    } else {
        format!(
            " Not counted, because the allowance for round-off exceeds {} E_ref there: {}.",
            short(VISIBLE),
            list(blind)
        )
    };
    (steps > 0).then(|| {
        format!(
            "Where the energy theorem of IMEX Euler holds, the energy rose in {rises} of {steps} steps; that of \
             backward Euler, which has no such theorem, in {newton_rises} of {newton}.{blind}"
        )
    })
}

/// H16: which springs may stay out of the matrix.
fn explicit_shear_finding(facts: &Facts) -> Option<String> {
    let cells = facts.cells.iter().filter(|cell| cell.case.starts_with("H16"));
    let outside = cells.filter(|cell| cell.settings.contains("implicit=tension"));
    let (failing, holding): (Vec<_>, Vec<_>) = outside.partition(|cell| cell.verdict != "stable");
    let names = |cells: &[&Cell]| {
        let names: BTreeSet<_> = cells.iter().map(|cell| cell.method.as_str()).collect();
        list(names.into_iter().map(str::to_owned))
    };
    (!failing.is_empty()).then(|| {
        let but = match holding.as_slice() {
            [] => String::new(),
            holding => format!("; not with {}", names(holding)),
        };
        format!(
            "Shear springs as stiff as the tension springs must stand in the matrix: left out of it, they make the \
             sheet unstable with {}{but}.",
            names(&failing)
        )
    })
}

/// H20: what the paper's algorithm gains and its safeguards keep.
fn safeguard_finding(facts: &Facts) -> Option<String> {
    let at = |method: &str| {
        let cells = facts.cells.iter().filter(|c| c.case.starts_with("H20") && c.method == method);
        cells.max_by(|a, b| a.gain.total_cmp(&b.gain))
    };
    let (paper, robust) = (at("imex-updated (paper)")?, at("imex-updated")?);
    Some(format!(
        "At k/m = 1e6 and ε = 0.1 updated CG as printed is {} (its energy rises by up to {} times what the scene sets free), \
         its safeguarded form {}.",
        paper.verdict,
        short(paper.gain),
        robust.verdict
    ))
}

/// What was not found out.
fn budget_finding(facts: &Facts) -> Option<String> {
    let count = |method: &String| {
        let is_over = |c: &&Cell| c.method == *method && c.verdict == "over budget";
        let count = facts.cells.iter().filter(is_over).count();
        (count > 0).then(|| format!("{method} {count}"))
    };
    let counts: Vec<_> = facts.methods.iter().filter_map(count).collect();
    (!counts.is_empty()).then(|| format!("Cells that ended over budget: {}.", list(counts)))
}

/// Who does not keep still.
fn rest_finding(facts: &Facts) -> Option<String> {
    let restless = |cell: &&Cell| cell.strayed_m.is_some() && !cell.note.is_empty();
    let name = |cell: &Cell| {
        let damping = if cell.is_damped { "damped" } else { "undamped" };
        let way = cell.strayed_m.filter(|way| *way < f64::MAX);
        let way = way.map_or("without end".to_owned(), |way| format!("{} m", short(way)));
        format!("{} {damping} ({way})", cell.method)
    };
    let moving: Vec<_> = facts.cells.iter().filter(restless).map(name).collect();
    let looked = facts.cells.iter().any(|cell| cell.strayed_m.is_some());
    looked.then(|| {
        if moving.is_empty() {
            "The sheet at rest keeps still with every method.".to_owned()
        } else {
            format!("The sheet at rest does not keep still with {}.", list(moving))
        }
    })
}
