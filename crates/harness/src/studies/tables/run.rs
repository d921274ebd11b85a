//! Experiment `tables`: the paper's tables 2 and 3.

use crate::facts::{Fact, fact};
use crate::methods::Choice;
use crate::record::Phases;
use crate::run::{Runner, Simulation};
use crate::scenes::{bundled, with_stiffness};
use crate::studies::tables::facts::{
    BestFit, Cell, FORCING_TERMS, Facts, PaperRow, Row, TimingRow,
};
use crate::studies::{Context, Measured, Start, cells, counts, finite, prepared, timed};
use crate::{HarnessError, reference_energy, system_hash};
use drape_model::{SystemSpec, TimeSpan};
use drape_report::number::median_s;
use std::collections::BTreeMap;

/// Simulated time of each row, s.
const DURATION: f64 = 1.0;
/// Number of repetitions of each timed run.
const REPETITIONS: usize = 5;
const QUICK_FORCING_TERMS: [f64; 3] = [0.1, 0.05, 0.01];
const ROBUST_FORCING_TERMS: [f64; 3] = [0.1, 0.03, 0.01];

/// A row as printed, with drape's reading of its exponent.
pub(crate) struct Printed {
    pub(crate) table: u32,
    pub(crate) row: u32,
    pub(crate) scene: &'static str,
    exponent: i32,
    pub(crate) step_s: f64,
    pub(crate) paper: PaperRow,
}

const fn paper(cg_iterations: u64, cg_s: f64, matrix_setup_s: f64, solver_s: f64) -> PaperRow {
    PaperRow { cg_iterations, cg_s, matrix_setup_s, solver_s }
}

/// Tables 2 and 3 of EEH.
pub(crate) const PRINTED: [Printed; 6] = [
    Printed {
        table: 2,
        row: 1,
        scene: "square-table-1e4",
        exponent: 4,
        step_s: 0.01,
        paper: paper(192, 1.14, 1.31, 3.34),
    },
    Printed {
        table: 2,
        row: 2,
        scene: "square-table-1e4-h02",
        exponent: 4,
        step_s: 0.02,
        paper: paper(233, 1.04, 0.7, 2.16),
    },
    Printed {
        table: 2,
        row: 3,
        scene: "square-table-1e6-h005",
        exponent: 6,
        step_s: 0.005,
        paper: paper(2601, 8.07, 2.67, 12.47),
    },
    Printed {
        table: 2,
        row: 4,
        scene: "square-table-2704-1e6",
        exponent: 6,
        step_s: 0.01,
        paper: paper(1344, 32.29, 10.46, 49.64),
    },
    Printed {
        table: 3,
        row: 1,
        scene: "hanging-textile-1e4",
        exponent: 4,
        step_s: 0.01,
        paper: paper(58, 0.54, 1.3, 2.7),
    },
    Printed {
        table: 3,
        row: 2,
        scene: "hanging-textile-1e6",
        exponent: 6,
        step_s: 0.001,
        paper: paper(614, 5.56, 12.66, 27.02),
    },
];

/// A power of ten without rounding: a library's power function may differ between machines.
fn power_of_ten(exponent: i32) -> f64 {
    (0..exponent).fold(1.0, |power, _| power * 10.0)
}

/// A printed row with one reading of its exponent.
struct Reading {
    printed: &'static Printed,
    exponent: i32,
    simulation: Simulation,
    hash: String,
    reference_energy: f64,
}

/// The scene of a row with one reading of its exponent.
fn spec(scene: &str, exponent: i32) -> Result<SystemSpec, HarnessError> {
    Ok(with_stiffness(bundled(scene)?, power_of_ten(exponent)).discretise()?)
}

impl Reading {
    fn new(printed: &'static Printed, exponent: i32) -> Result<Self, HarnessError> {
        let spec = spec(printed.scene, exponent)?;
        let (system, state) = spec.build()?;
        let simulation = Simulation { system, state };
        let reference_energy = reference_energy(&simulation, DURATION)?;
        let hash = system_hash(&spec);
        Ok(Self { printed, exponent, simulation, hash, reference_energy })
    }

    fn assumed(&self) -> bool {
        self.exponent == self.printed.exponent
    }

    fn id(&self) -> String {
        format!("table{}-row{}-1e{}", self.printed.table, self.printed.row, self.exponent)
    }
}

/// Settings of Algorithm 1 as printed, over all springs.
const AS_PRINTED: &str = "safeguard=paper,norm=euclid,start=extrapolated";

/// The method of a variant: EEH (21), Algorithm 1 as printed, or its safeguarded form.
fn form(variant: &str, forcing_term: f64) -> String {
    match variant {
        "plain" => format!("imex-euler:norm=euclid,forcing_term={forcing_term}"),
        "updated-paper" => {
            format!("imex-updated:{AS_PRINTED},forcing_term={forcing_term}")
        }
        _ => format!("imex-updated:forcing_term={forcing_term}"),
    }
}

fn sweep(reading: &Reading, quick: bool) -> Vec<(&'static str, f64)> {
    let terms: &[f64] = if quick { &QUICK_FORCING_TERMS } else { &FORCING_TERMS };
    let mut sweep: Vec<_> = ["plain", "updated-paper"]
        .into_iter()
        .flat_map(|variant| terms.iter().map(move |&term| (variant, term)))
        .collect();
    if reading.assumed() && !quick {
        sweep.extend(ROBUST_FORCING_TERMS.map(|term| ("updated-robust", term)));
    }
    sweep
}

fn cell(reading: &Reading, variant: &str, forcing_term: f64) -> Result<Cell, HarnessError> {
    let method = form(variant, forcing_term);
    let (choice, run) = counts(&reading.simulation, &method, reading.printed.step_s, DURATION)?;
    let totals = run.outcome.totals;
    Ok(Cell {
        variant: variant.to_owned(),
        method: choice.full_id(),
        forcing_term,
        cg_iterations: totals.cg_iterations,
        outer_passes: totals.outer_passes,
        newton_iterations: totals.newton_iterations,
        matvecs: totals.matvecs,
        unconverged_steps: run.outcome.unconverged,
        energy_gain_j: finite(run.energy.gain),
        energy_climb: finite(run.energy.climb / reading.reference_energy),
        verdict: run.verdict(reading.reference_energy),
        portable: choice.is_portable(),
    })
}

fn best_fit(cells: &[Cell], paper: u64) -> Vec<BestFit> {
    let distance = |cell: &Cell| {
        let ratio = cell.cg_iterations.max(1) as f64 / paper as f64;
        ratio.max(1.0 / ratio)
    };
    ["plain", "updated-paper"]
        .into_iter()
        .filter_map(|variant| {
            let candidates = cells.iter().filter(|cell| cell.variant == variant);
            candidates.min_by(|a, b| distance(a).total_cmp(&distance(b)))
        })
        .map(|cell| BestFit {
            variant: cell.variant.clone(),
            forcing_term: cell.forcing_term,
            cg_iterations: cell.cg_iterations,
            ratio: cell.cg_iterations as f64 / paper as f64,
        })
        .collect()
}

fn row(reading: &Reading, cells: Vec<Cell>) -> Result<Row, HarnessError> {
    let printed = reading.printed;
    let tension = bundled(printed.scene)?.effects.tension;
    Ok(Row {
        id: reading.id(),
        table: printed.table,
        row: printed.row,
        scene: printed.scene.to_owned(),
        particles: reading.simulation.system.len(),
        stiffness_over_mass_per_s2: power_of_ten(reading.exponent),
        assumed_reading: reading.assumed(),
        damping_over_mass_per_s: tension
            .and_then(|law| law.damping_over_mass_per_s)
            .unwrap_or_default(),
        step_s: printed.step_s,
        paper: printed.paper,
        best_fit: best_fit(&cells, printed.paper.cg_iterations),
        cells,
    })
}

/// How the timings are taken.
pub(super) fn timing() -> String {
    format!(
        "One run at a time on one thread of an otherwise idle process. Samples are {REPETITIONS} \
         repetitions with the phase clock off. Phases are those of the median of as many \
         repetitions with the clock on. Plain CG runs at ε = 0.05, updated CG as printed at ε = \
         0.01. `kept` sets up matrix and IC(0) once. `rebuilt` sets them up in each step but the \
         first, as the paper's varying moduli require. The first set-up, with all allocation, is \
         not a part of the steps; its time is `prepare_s`."
    )
}

/// How the facts are measured.
pub(super) fn method() -> String {
    "Each row of the paper's tables 2 and 3 runs for one second, with plain IMEX Euler (21) and \
     with updated CG (Algorithm 1), over a sweep of the forcing term. The record sums the CG \
     iterations. Both methods use IC(0) and the extrapolated start (22). The exponents of k/m are \
     read as 4 and 6; the study also runs the exponents one below and one above. The scenes mark \
     as assumed what the paper does not state. A verdict compares the greatest rise of the total \
     energy above its start with the energy that the scene sets free. Up to 2 % of it is stable, \
     up to half is marginal, more is unstable. Updated CG may update up to 200 times a step; a \
     step that reaches this cap counts as unconverged."
        .to_owned()
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    let start =
        |row: &'static Printed| Start::new(row.scene, move || spec(row.scene, row.exponent));
    PRINTED.iter().map(start).collect()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let readings = readings(context)?;
    let inputs: Vec<_> = readings
        .iter()
        .flat_map(|reading| {
            sweep(reading, context.quick)
                .into_iter()
                .map(move |(variant, term)| (reading, variant, term))
        })
        .collect();
    let results = cells(context, "counts", &inputs, |&(reading, variant, term)| {
        cell(reading, variant, term)
    })?;
    let mut results = results.all()?.into_iter();
    let mut rows = Vec::new();
    for reading in &readings {
        let count = sweep(reading, context.quick).len();
        rows.push(row(reading, results.by_ref().take(count).collect())?);
    }
    rows.sort_by_key(|row| !row.assumed_reading);
    let assumed = || readings.iter().filter(|reading| reading.assumed());
    let hashes: BTreeMap<_, _> =
        assumed().map(|reading| (reading.printed.scene.to_owned(), reading.hash.clone())).collect();
    let timings =
        if context.quick { None } else { Some(times(context, &assumed().collect::<Vec<_>>())?) };
    Ok(Measured { facts: Facts { rows }, timings, scenes: hashes, seed: None })
}

fn readings(context: &Context<'_>) -> Result<Vec<Reading>, HarnessError> {
    let chosen: Vec<_> = PRINTED
        .iter()
        .filter(|printed| !context.quick || printed.exponent == 4)
        .flat_map(|printed| {
            let around = if context.quick { 0..=0 } else { -1..=1 };
            around.map(move |offset| (printed, printed.exponent + offset))
        })
        .collect();
    prepared(context, "scenes", &chosen, |&(printed, exponent)| Reading::new(printed, exponent))
}

/// Times plain and updated CG, with the matrix kept and with the matrix rebuilt in each step. One
/// run is timed at a time.
fn times(context: &Context<'_>, readings: &[&Reading]) -> Result<Vec<TimingRow>, HarnessError> {
    let mut cases = Vec::new();
    for reading in readings {
        for (variant, forcing_term) in [("plain", 0.05), ("updated-paper", 0.01)] {
            cases
                .extend(["kept", "rebuilt"].map(|matrix| (reading, variant, forcing_term, matrix)));
        }
    }
    timed(context, "timings", &cases, |&(reading, variant, forcing_term, matrix)| {
        let method = format!("{},matrix={matrix}", form(variant, forcing_term));
        time(reading, variant, matrix, &Choice::parse(&method, &[])?)
    })?
    .all()
}

fn time(
    reading: &Reading,
    variant: &str,
    matrix: &str,
    choice: &Choice,
) -> Result<TimingRow, HarnessError> {
    let span = TimeSpan { step_s: reading.printed.step_s, duration_s: DURATION };
    let once =
        |phases| Runner::new(choice, span).phases(phases).go(&mut reading.simulation.clone());
    let mut samples_ns = Vec::new();
    for _ in 0..REPETITIONS {
        samples_ns.push(once(false)?.wall.as_nanos() as u64);
    }
    let mut phased = (0..REPETITIONS).map(|_| once(true)).collect::<Result<Vec<_>, _>>()?;
    phased.sort_by_key(|pass| pass.wall);
    let phased = phased.swap_remove(REPETITIONS / 2);
    Ok(TimingRow {
        id: reading.id(),
        variant: variant.to_owned(),
        method: choice.full_id(),
        matrix: matrix.to_owned(),
        cg_iterations: phased.totals.cg_iterations,
        steps: phased.steps,
        solver_s: median_s(&samples_ns),
        samples_ns,
        prepare_s: phased.totals.prepare_seconds,
        phases_s: phased.phases.unwrap_or_else(Phases::default),
    })
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let cells = facts.rows.iter().flat_map(|row| {
        row.cells.iter().map(move |cell| {
            let key = format!("{} {} ε={}", row.id, cell.variant, cell.forcing_term);
            fact(key, cell.portable, cell)
        })
    });
    let rows = facts.rows.iter().map(|row| {
        let bare = Row { cells: Vec::new(), best_fit: Vec::new(), ..row.clone() };
        fact(row.id.clone(), true, &bare)
    });
    rows.chain(cells).collect()
}
