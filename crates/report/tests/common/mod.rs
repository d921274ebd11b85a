//! Synthetic records, shaped like real ones: counts grow like the square root of the stiffness.

use drape_records::tables::{BestFit, PaperRow, Phases, Row, TimingRow};
use drape_records::{Provenance, RECORD_FORMAT, Record, TIMINGS_FORMAT, Timings, cg, tables};
use std::collections::BTreeMap;

fn provenance() -> Provenance {
    Provenance {
        version: "0.1.0".to_owned(),
        commit: Some("0123456789abcdef".to_owned()),
        dirty: Some(true),
        cargo_lock_sha256: "feed".to_owned(),
        rustc: "rustc 1.89.0 (test)\nbinary: rustc".to_owned(),
        build: "release, opt-level 3, x86_64".to_owned(),
        cpu: "A | processor".to_owned(),
        threads: 2,
        scene_sha256: BTreeMap::from([("hanging-textile".to_owned(), "beef".to_owned())]),
        seed: None,
        date: "2025-01-02T03:04:05Z".to_owned(),
    }
}

fn record<F>(experiment: &str, quick: bool, facts: F) -> Record<F> {
    Record {
        format: RECORD_FORMAT.to_owned(),
        experiment: experiment.to_owned(),
        question: format!("What does {experiment} ask?"),
        method: "Counted with ‖r‖ ≤ ε‖b‖ in every step.".to_owned(),
        command: format!("drape experiment {experiment}"),
        quick,
        findings: vec!["A first finding.".to_owned(), "A second finding, a | b.".to_owned()],
        figures: Vec::new(),
        facts,
        provenance: provenance(),
    }
}

/// Table, row, particles, k/m, h, the paper's count and its seconds (CG, matrix set-up, solver).
type Printed = (u32, u32, usize, f64, f64, u64, [f64; 3]);

const ROWS: [Printed; 6] = [
    (2, 1, 400, 1e4, 0.01, 192, [1.14, 1.31, 3.34]),
    (2, 2, 400, 1e4, 0.02, 233, [1.04, 0.7, 2.16]),
    (2, 3, 400, 1e6, 0.005, 2601, [8.07, 2.67, 12.47]),
    (2, 4, 2704, 1e6, 0.01, 1344, [32.29, 10.46, 49.64]),
    (3, 1, 400, 1e4, 0.01, 58, [0.54, 1.3, 2.7]),
    (3, 2, 400, 1e6, 0.001, 614, [5.56, 12.66, 27.02]),
];

fn row(n: usize, shift: i32) -> Row {
    let (table, row, particles, k_over_m, step_s, count, seconds) = ROWS[n];
    let k_over_m = k_over_m * 10f64.powi(shift);
    let mut cells = Vec::new();
    let mut best_fit = Vec::new();
    for (v, variant) in ["plain", "updated-paper", "updated-robust"].into_iter().enumerate() {
        let mut best: Option<BestFit> = None;
        for forcing_term in [0.2, 0.1, 0.07, 0.05, 0.03, 0.01, 1e-3, 1e-4] {
            let growth: f64 = 1.0 + 0.35 * (v as f64 + 0.4) * (0.2f64 / forcing_term).ln();
            let ours = (0.6 * count as f64 * growth * 10f64.powf(0.5 * f64::from(shift))) as u64;
            let failed = v == 1 && forcing_term > 0.06 && k_over_m > 1e5;
            let ratio = ours as f64 / count as f64;
            if best.as_ref().is_none_or(|b| ratio.ln().abs() < b.ratio.ln().abs()) {
                best = Some(BestFit {
                    variant: variant.to_owned(),
                    forcing_term,
                    cg_iterations: ours,
                    ratio,
                });
            }
            cells.push(tables::Cell {
                variant: variant.to_owned(),
                method: "imex-euler".to_owned(),
                forcing_term,
                cg_iterations: if failed { ours * 3 } else { ours },
                outer_passes: v as u64 * 100,
                newton_iterations: 0,
                matvecs: ours + 100,
                unconverged_steps: 0,
                energy_gain_j: if failed { 3.2e140 } else { 1.5e-12 },
                energy_climb: 0.0,
                verdict: if failed {
                    "diverged"
                } else if v == 2 && forcing_term > 0.15 {
                    "marginal"
                } else {
                    "stable"
                }
                .to_owned(),
                portable: true,
            });
        }
        best_fit.extend(best);
    }
    Row {
        id: format!("table{table}-row{row}-{k_over_m:e}"),
        table,
        row,
        scene: "scene".to_owned(),
        particles,
        stiffness_over_mass_per_s2: k_over_m,
        assumed_reading: shift == 0,
        damping_over_mass_per_s: 40.0,
        step_s,
        paper: PaperRow {
            cg_iterations: count,
            cg_s: seconds[0],
            matrix_setup_s: seconds[1],
            solver_s: seconds[2],
        },
        cells,
        best_fit,
    }
}

/// All six rows and their neighbouring readings; `quick`: the first row only.
pub(crate) fn tables(quick: bool) -> Record<tables::Facts> {
    let mut rows: Vec<Row> = (0..6).map(|n| row(n, 0)).collect();
    rows.extend((0..6).flat_map(|n| [row(n, -1), row(n, 1)]));
    if quick {
        rows.truncate(1);
    }
    record("tables", quick, tables::Facts { rows })
}

/// Timings of the six rows, plain and updated, matrix kept and rebuilt.
pub(crate) fn timings() -> Timings<TimingRow> {
    let mut rows = Vec::new();
    for n in 0..6 {
        for variant in ["plain", "updated-paper"] {
            for matrix in ["kept", "rebuilt"] {
                let setup = if matrix == "kept" { 2e-5 } else { 4.2e-3 };
                rows.push(TimingRow {
                    id: row(n, 0).id,
                    variant: variant.to_owned(),
                    method: variant.to_owned(),
                    matrix: matrix.to_owned(),
                    cg_iterations: ROWS[n].5,
                    steps: 100,
                    samples_ns: vec![9_100_000, 8_900_000, 9_400_000],
                    solver_s: 0.0091 * (n + 1) as f64,
                    prepare_s: 1e-4,
                    phases_s: Phases {
                        forces: 1.3e-3,
                        matrix_setup: setup,
                        solve: 3.7e-3 * (n as f64 + 1.0),
                        contact: 2e-4,
                        update: 5e-4,
                    },
                });
            }
        }
    }
    Timings {
        format: TIMINGS_FORMAT.to_owned(),
        experiment: "tables".to_owned(),
        method: "One at a time.".to_owned(),
        rows,
        provenance: provenance(),
    }
}

/// The settings of a cell that differ from the base point's.
struct At {
    series: &'static str,
    material: &'static str,
    particles: usize,
    k_over_m: f64,
    step_s: f64,
    forcing_term: f64,
    preconditioner: usize,
    start: usize,
    variant: usize,
}

const BASE: At = At {
    series: "stiffness",
    material: "fixed-k-over-m",
    particles: 400,
    k_over_m: 1e4,
    step_s: 0.01,
    forcing_term: 0.05,
    preconditioner: 2,
    start: 0,
    variant: 0,
};

fn cell(at: &At) -> cg::Cell {
    let theta = at.step_s * at.step_s * at.k_over_m;
    let size = (at.particles as f64 / 400.0).powf(0.25);
    let growth = theta.sqrt() * size * [3.0, 2.4, 1.0][at.preconditioner];
    let tolerance = 1.0 + 0.2 * (0.05f64 / at.forcing_term).ln().max(-2.0);
    let raw = growth * tolerance * [0.35, 0.9, 0.3][at.start] * (1.0 + 0.6 * at.variant as f64);
    let steps = (1.0 / at.step_s).round() as u64;
    let cg_iterations = if raw < 0.04 { 0 } else { (raw * steps as f64) as u64 };
    let verdict = match (at.variant, at.k_over_m) {
        (1, k) if k >= 1e7 => "diverged",
        (1, k) if k >= 1e6 => "unstable",
        (2, k) if k >= 1e8 => "marginal",
        _ => "stable",
    };
    cg::Cell {
        series: at.series.to_owned(),
        material: at.material.to_owned(),
        particles: at.particles,
        stiffness_over_mass_per_s2: at.k_over_m,
        step_s: at.step_s,
        theta,
        variant: ["plain", "updated-paper", "updated-robust"][at.variant].to_owned(),
        preconditioner: ["none", "jacobi", "ic0"][at.preconditioner].to_owned(),
        start: ["extrapolated", "last", "best"][at.start].to_owned(),
        forcing_term: at.forcing_term,
        method: "imex-euler".to_owned(),
        steps,
        cg_iterations,
        cg_per_step: cg_iterations as f64 / steps as f64,
        outer_passes: 0,
        newton_iterations: 0,
        idle_steps: 0,
        unconverged_steps: 0,
        energy_gain_j: if verdict == "diverged" { 1e200 } else { 0.0 },
        energy_climb: 0.0,
        verdict: verdict.to_owned(),
        portable: true,
    }
}

/// All series; `quick`: one cell at the base solver and nothing else.
pub(crate) fn cg(quick: bool) -> Record<cg::Facts> {
    let mut cells = Vec::new();
    let stiffnesses: Vec<f64> = (2..=8).map(|n| 10f64.powi(n)).collect();
    for particles in [400, 2704] {
        for &k_over_m in &stiffnesses {
            for preconditioner in 0..3 {
                for start in 0..3 {
                    cells.push(cell(&At { particles, k_over_m, preconditioner, start, ..BASE }));
                }
            }
            // The robust form starts at the better of both.
            for (variant, start) in [(1, 0), (2, 2)] {
                cells.push(cell(&At { particles, k_over_m, variant, start, ..BASE }));
            }
        }
    }
    for &k_over_m in &stiffnesses {
        for step_s in [0.001, 0.002, 0.005, 0.01, 0.02, 0.05] {
            for variant in 0..2 {
                cells.push(cell(&At { series: "step", k_over_m, step_s, variant, ..BASE }));
            }
        }
        for forcing_term in [0.2, 0.05, 1e-2, 1e-3, 1e-4, 1e-6] {
            cells.push(cell(&At { series: "forcing-term", k_over_m, forcing_term, ..BASE }));
        }
        let fixed = At { material: "fixed-material", particles: 2704, ..BASE };
        cells.push(cell(&At { k_over_m: k_over_m * 7.2, ..fixed }));
    }
    let mut motion = Vec::new();
    for (n, label) in ["imex-euler", "imex-updated", "imex-updated, tension only", "backward-euler"]
        .into_iter()
        .enumerate()
    {
        for &k_over_m in &stiffnesses {
            let diverged = n == 1 && k_over_m > 1e7;
            motion.push(cg::Motion {
                stiffness_over_mass_per_s2: k_over_m,
                step_s: 0.01,
                label: label.to_owned(),
                method: label.to_owned(),
                fall_m: match n {
                    _ if diverged => 4.5e120,
                    0 => -0.456 / (1.0 + k_over_m / 2.5e5),
                    1 => -0.456 / (1.0 + k_over_m / 1e9),
                    2 => -0.456 / (1.0 + k_over_m / 1e8),
                    _ => -0.456,
                },
                unconverged_steps: 0,
                energy_gain_j: 0.0,
                verdict: if diverged { "diverged" } else { "stable" }.to_owned(),
                portable: true,
            });
        }
    }
    if quick {
        cells.retain(|cell| cell.preconditioner == "ic0" && cell.start == "extrapolated");
        cells.truncate(1);
        motion.clear();
    }
    record("cg-vs-stiffness", quick, cg::Facts { cells, motion })
}
