//! Accuracy against work, and work against size.

use super::{CURVES, provenance, record};
use drape_harness::record::Phases;
use drape_harness::studies::scaling::facts as scaling;
use drape_harness::studies::work_precision::facts as work_precision;
use drape_report::Verdict;
use drape_report::{Record, TIMINGS_FORMAT, Timings};

pub(crate) fn timings_of<R>(experiment: &str, rows: Vec<R>) -> Timings<R> {
    Timings {
        format: TIMINGS_FORMAT.to_owned(),
        experiment: experiment.to_owned(),
        method: "One at a time.".to_owned(),
        rows,
        provenance: provenance(),
    }
}

/// Series over the stiffness, over the size, and of another scene; errors of order 1 and 2, the
/// coarsest run of the first methods diverges; `quick`: one scene only.
pub(crate) fn work_precision(quick: bool) -> Record<work_precision::Facts> {
    let scene = |name: &str, damping: &str, k_over_m: f64, particles: usize, series: &[&str]| {
        work_precision::Scene {
            id: format!("{name} {damping} {k_over_m:e} n={particles}"),
            scene: name.to_owned(),
            damping: damping.to_owned(),
            series: series.iter().map(|s| (*s).to_owned()).collect(),
            particles,
            springs: 3 * particles,
            stiffness_over_mass_per_s2: k_over_m,
            damping_over_mass_per_s: 10.0,
            greatest_frequency_per_s: (10.0 * k_over_m).sqrt(),
            span_s: 0.25,
            motion_m: 0.2,
            reference_error: 1e-9,
            reference_tolerance: 1e-11,
            floor: 1e-6,
            energy_floor: 1e-6,
            budget: 1e8,
        }
    };
    let sizes = ["stiffness", "size, k/m fixed", "size, material fixed"];
    let mut scenes = vec![scene("hanging", "light", 1e4, 400, &sizes)];
    for k_over_m in [1e2, 1e6, 1e8, 1e10] {
        scenes.push(scene("hanging", "light", k_over_m, 400, &sizes[..1]));
        scenes.push(scene("hanging", "heavy", k_over_m, 400, &sizes[..1]));
    }
    scenes.push(scene("hanging", "light", 1e4, 1600, &sizes[1..2]));
    scenes.push(scene("hanging", "light", 4e4, 1600, &sizes[2..]));
    scenes.push(scene("thrown", "light", 1e8, 400, &sizes[..1]));
    scenes.push(scene("spread", "light", 1e8, 400, &sizes[..1]));
    scenes.truncate(if quick { 1 } else { scenes.len() });
    let (mut rows, mut winners) = (Vec::new(), Vec::new());
    for scene in &scenes {
        for (n, (method, label)) in CURVES.into_iter().enumerate() {
            let p = 1 + n as i32 % 2;
            let run = |step: i32| {
                let is_lost = n < 3 && step == 0;
                let steps = 8.0 * 2f64.powi(step);
                let verdict = if is_lost { Verdict::Diverged } else { Verdict::Completed };
                work_precision::Run {
                    error: (!is_lost).then(|| 0.2 * 2f64.powi(-p * step)),
                    modelled_s: 1e-3 * 2f64.powi(step) * (1.0 + n as f64),
                    effort: 1e5 * 2f64.powi(step) * (1.0 + n as f64),
                    steps: 8,
                    force_evaluations: 8,
                    ..work_precision::Run::uncounted(steps, Some(0.25 / steps), verdict)
                }
            };
            rows.push(work_precision::Row {
                scene: scene.id.clone(),
                label: label.to_owned(),
                method: method.to_owned(),
                knob: "steps".to_owned(),
                is_headline: n % 2 == 0,
                runs: (0..6).map(run).collect(),
            });
        }
        for (n, level) in [1e-1, 1e-2, 1e-3, 1e-4].into_iter().enumerate() {
            let tied = (n == 0).then(|| work_precision::Tied {
                label: "imex-euler".to_owned(),
                is_explicit: false,
                ratio: 1.75,
            });
            winners.push(work_precision::Winner {
                scene: scene.id.clone(),
                level,
                label: (n < 2).then(|| CURVES[2 + 5 * n].1.to_owned()),
                is_explicit: (n < 2).then_some(n == 0),
                value: (n < 2).then_some(16.0),
                modelled_s: (n < 2).then_some(6e-3),
                energy: (n < 2).then_some(-0.01),
                retained: (n < 2).then_some(0.98),
                runner_up: (n == 0).then(|| "imex-euler".to_owned()),
                ratio: (n == 0).then_some(1.75),
                tied: tied.into_iter().collect(),
                is_narrow: false,
            });
        }
    }
    record("work-precision", quick, work_precision::Facts { scenes, rows, winners })
}

/// Times of every completed run of the hanging sheets; one was not verified.
pub(crate) fn work_precision_timings() -> Timings<work_precision::TimingRow> {
    let facts = work_precision(false).facts;
    let is_timed = |row: &&work_precision::Row| row.scene.starts_with("hanging light");
    let mut rows = Vec::new();
    for row in facts.rows.iter().filter(is_timed) {
        for run in &row.runs {
            let Some(error) = run.error else { continue };
            rows.push(work_precision::TimingRow {
                probe_s: None,
                scene: row.scene.clone(),
                label: row.label.clone(),
                value: run.value,
                samples_ns: vec![(5.0 * run.effort) as u64],
                seconds: 5e-9 * run.effort,
                error,
                is_verified: !rows.is_empty(),
            });
        }
    }
    timings_of("work-precision", rows)
}

/// Iterations that grow with the mesh; `quick`: small meshes.
pub(crate) fn scaling(quick: bool) -> Record<scaling::Facts> {
    let mut cells = Vec::new();
    for series in ["k/m fixed", "material fixed"] {
        for side in [10_u32, 20, 52, 100, 316, 1000] {
            let factor = if series == "k/m fixed" { 1.0 } else { f64::from(side * side) / 400.0 };
            for label in ["symplectic-euler", "imex-euler", "baraff-witkin"] {
                cells.push(scaling::Cell {
                    series: series.to_owned(),
                    side,
                    particles: (side * side) as usize,
                    springs: (4 * side * side) as usize,
                    stiffness_over_mass_per_s2: 1e4 * factor,
                    damping_over_mass_per_s: 10.0 * factor,
                    step_s: 0.01,
                    steps: 3,
                    label: label.to_owned(),
                    method: label.to_owned(),
                    cg_per_step: if label == "symplectic-euler" {
                        0.0
                    } else {
                        factor.sqrt() + 2.0
                    },
                    matvecs: 9,
                    force_evaluations: 3,
                    newton_iterations: 0,
                    unconverged_steps: 0,
                    verdict: Verdict::Completed,
                    portable: true,
                });
            }
        }
    }
    cells.retain(|cell| !quick || cell.side < 100);
    record("scaling", quick, scaling::Facts { cells })
}

/// Times of the cells with k/m fixed, and the memory's bandwidth.
pub(crate) fn scaling_timings() -> Timings<scaling::TimingRow> {
    let cells = scaling(false).facts.cells.into_iter().filter(|cell| cell.series == "k/m fixed");
    let mut rows: Vec<_> = cells
        .map(|cell| {
            let whole = 40.0 * cell.particles as f64 * (1.0 + cell.cg_per_step);
            scaling::TimingRow::Run(scaling::RunTiming {
                series: cell.series,
                particles: cell.particles,
                label: cell.label,
                steps: cell.steps,
                samples_ns: vec![(whole * cell.steps as f64) as u64],
                ns_per_particle_step: whole / cell.particles as f64,
                least_bytes: (cell.cg_per_step > 0.0).then_some(500.0),
                prepare_s: 1e-3,
                phases_s: Phases {
                    forces: 0.5e-9 * whole,
                    matrix_setup: 0.0,
                    solve: 2e-9 * whole,
                    contact: 0.0,
                    update: 0.5e-9 * whole,
                },
            })
        })
        .collect();
    rows.extend([100_usize, 1_000_000].map(|particles| {
        scaling::TimingRow::Memory(scaling::Memory {
            particles,
            springs: 6 * particles,
            label: "imex-euler".to_owned(),
            system_bytes: 213 * particles as u64,
            state_bytes: 48 * particles as u64,
            integrator_bytes: 301 * particles as u64,
            build_s: 1e-7 * particles as f64,
            prepare_s: 2e-7 * particles as f64,
        })
    }));
    rows.push(scaling::TimingRow::Triad {
        bytes: 24 << 23,
        samples_ns: vec![20_000_000],
        bytes_per_s: 1e10,
    });
    timings_of("scaling", rows)
}
