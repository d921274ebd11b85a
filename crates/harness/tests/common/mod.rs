//! Synthetic records, shaped like real ones: counts grow like the square root of the stiffness.

#![allow(clippy::unwrap_used, reason = "tests")]

mod animation;
mod contacts;
mod control;
mod course;
mod effects;
mod energy;
mod fabric;
mod regret;
mod rest;
mod stability;
mod trajectory;
mod work;

pub(crate) use animation::{animation, animation_long, animation_long_timings, animation_timings};
pub(crate) use contacts::{collision, inverse, inverse_timings, post_correction};
pub(crate) use control::control;
pub(crate) use course::course;
pub(crate) use effects::{effects, effects_timings};
pub(crate) use energy::energy;
pub(crate) use fabric::fabric;
pub(crate) use regret::{regret, regret_timings};
pub(crate) use rest::{rest, rest_timings};
pub(crate) use stability::{locking, stability};
pub(crate) use trajectory::trajectory;
pub(crate) use work::{scaling, scaling_timings, work_precision, work_precision_timings};

use drape_harness::record::Phases;
use drape_harness::studies::cg_vs_stiffness::facts as cg;
use drape_harness::studies::claims::facts as claims;
use drape_harness::studies::hard_cases::facts as hard_cases;
use drape_harness::studies::momentum::facts as momentum;
use drape_harness::studies::order::facts as order;
use drape_harness::studies::tables::facts as tables;
use drape_harness::studies::tables::facts::{BestFit, PaperRow, Row, TimingRow};
use drape_report::file::write_json;
use drape_report::{Provenance, RECORD_FORMAT, Record, TIMINGS_FORMAT, Timings};
use drape_report::{Verdict, Words};
use std::collections::BTreeMap;
use std::path::Path;
use tempfile::TempDir;

/// A results folder with all records.
pub(crate) fn complete() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_json(&path("course.json"), &course(false)).unwrap();
    write_json(&path("tables.json"), &tables(false)).unwrap();
    write_json(&path("timings/tables.json"), &timings()).unwrap();
    write_json(&path("cg-vs-stiffness.json"), &cg(false)).unwrap();
    write_json(&path("hard-cases.json"), &hard_cases(false)).unwrap();
    write_json(&path("order.json"), &order(false)).unwrap();
    write_json(&path("momentum.json"), &momentum(false)).unwrap();
    write_json(&path("energy.json"), &energy(false)).unwrap();
    write_json(&path("stability.json"), &stability(false)).unwrap();
    write_json(&path("locking.json"), &locking(false)).unwrap();
    write_json(&path("collision.json"), &collision(false)).unwrap();
    write_json(&path("effects.json"), &effects()).unwrap();
    write_json(&path("timings/effects.json"), &effects_timings()).unwrap();
    write_json(&path("post-correction.json"), &post_correction(false)).unwrap();
    write_json(&path("precomputed-inverse.json"), &inverse(false)).unwrap();
    write_json(&path("timings/precomputed-inverse.json"), &inverse_timings()).unwrap();
    write_json(&path("solver-control.json"), &control()).unwrap();
    write_json(&path("work-precision.json"), &work_precision(false)).unwrap();
    write_json(&path("timings/work-precision.json"), &work_precision_timings()).unwrap();
    write_json(&path("trajectory.json"), &trajectory()).unwrap();
    write_json(&path("animation.json"), &animation()).unwrap();
    write_json(&path("timings/animation.json"), &animation_timings()).unwrap();
    write_json(&path("animation-long.json"), &animation_long()).unwrap();
    write_json(&path("timings/animation-long.json"), &animation_long_timings()).unwrap();
    write_json(&path("regret.json"), &regret()).unwrap();
    write_json(&path("timings/regret.json"), &regret_timings()).unwrap();
    write_json(&path("rest.json"), &rest()).unwrap();
    write_json(&path("timings/rest.json"), &rest_timings()).unwrap();
    write_json(&path("fabric.json"), &fabric()).unwrap();
    write_json(&path("scaling.json"), &scaling(false)).unwrap();
    write_json(&path("timings/scaling.json"), &scaling_timings()).unwrap();
    let (claims, seconds) = claims();
    write_json(&path("claims.json"), &claims).unwrap();
    write_json(&path("timings/claims.json"), &seconds).unwrap();
    folder
}

/// The results that are kept with the source.
pub(crate) fn committed() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../results"))
}

/// A folder with the committed records.
pub(crate) fn copy_of_committed() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("timings")).unwrap();
    for below in ["", "timings"] {
        for entry in std::fs::read_dir(committed().join(below)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "json") {
                let name = path.file_name().unwrap();
                std::fs::copy(&path, folder.path().join(below).join(name)).unwrap();
            }
        }
    }
    folder
}

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

pub(crate) fn record<F>(experiment: &str, quick: bool, facts: F) -> Record<F> {
    Record {
        format: RECORD_FORMAT.to_owned(),
        experiment: experiment.to_owned(),
        question: format!("What does {experiment} ask?"),
        method: "Counted with ‖r‖ ≤ ε‖b‖ in every step.".to_owned(),
        command: format!("drape experiment {experiment}"),
        quick,
        words: Words {
            conclusion: format!("The conclusion of {experiment}."),
            observations: vec!["An observation, a | b.".to_owned()],
            caveats: vec!["A caveat.".to_owned()],
        },
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
                    Verdict::Diverged
                } else if v == 2 && forcing_term > 0.15 {
                    Verdict::Marginal
                } else {
                    Verdict::Stable
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
        (1, k) if k >= 1e7 => Verdict::Diverged,
        (1, k) if k >= 1e6 => Verdict::Unstable,
        (2, k) if k >= 1e8 => Verdict::Marginal,
        _ => Verdict::Stable,
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
        energy_gain_j: if verdict == Verdict::Diverged { 1e200 } else { 0.0 },
        energy_climb: 0.0,
        verdict,
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
                verdict: if diverged { Verdict::Diverged } else { Verdict::Stable },
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

/// Methods of the table of verdicts: as many as fit.
pub(crate) const METHODS: [&str; 20] = [
    "explicit-euler",
    "symplectic-euler",
    "leapfrog",
    "leapfrog (auto)",
    "provot",
    "backward-euler",
    "baraff-witkin",
    "desbrun",
    "kang",
    "terzopoulos-fleischer",
    "adams-bashforth2",
    "bdf2",
    "imex-euler",
    "imex-euler (exact)",
    "imex-updated",
    "imex-updated (paper)",
    "imex-sbdf2",
    "imex-cnab2",
    "imex-mcnab2",
    "imex-cnlf",
];

fn hard_case(n: usize) -> hard_cases::Case {
    hard_cases::Case {
        name: format!("H{n:02} longest of titles"),
        scene: "A sheet that hangs by two corners.".to_owned(),
        judged: "closed".to_owned(),
        particles: 144,
        springs: 506,
        step_s: 0.01,
        steps: 200,
        duration_s: 2.0,
        released_undamped_j: 0.7,
        released_damped_j: 0.8,
    }
}

fn hard_cell(case: &hard_cases::Case, method: usize, is_damped: bool) -> hard_cases::Cell {
    let verdicts = [
        Verdict::Stable,
        Verdict::Marginal,
        Verdict::Unstable,
        Verdict::Diverged,
        Verdict::OverBudget,
        Verdict::Refused,
        Verdict::NotApplicable,
    ];
    let differs = method == 1 && is_damped;
    hard_cases::Cell {
        case: case.name.clone(),
        method: METHODS[method].to_owned(),
        is_damped,
        settings: METHODS[method].to_owned(),
        verdict: verdicts[method % 7],
        note: String::new(),
        expected: if method.is_multiple_of(2) {
            hard_cases::Expected::NoTheorem
        } else {
            hard_cases::Expected::Stable
        },
        reason: "so it is".to_owned(),
        differs,
        explanation: (differs && case.name.starts_with("H01")).then(|| "a reason | why".to_owned()),
        runs: 3,
        gain: if method % 7 == 3 { f64::MAX } else { 0.123 },
        drift: 0.0,
        rises: 0,
        round_off: 0.0,
        steps: 600,
        reached_s: 1.25,
        cg_iterations: 0,
        newton_iterations: 0,
        unconverged_steps: 0,
        strayed_m: None,
        strayed_m_per_s: None,
        portable: true,
    }
}

/// Every kind of verdict; `quick`: one case only.
pub(crate) fn hard_cases(quick: bool) -> Record<hard_cases::Facts> {
    let cases: Vec<_> = (1..=if quick { 1 } else { 28 }).map(hard_case).collect();
    let mut cells = Vec::new();
    for case in &cases {
        for method in 0..METHODS.len() {
            cells.extend([false, true].map(|is_damped| hard_cell(case, method, is_damped)));
        }
    }
    let methods = METHODS.map(str::to_owned).to_vec();
    let facts = hard_cases::Facts { cases, methods, cells, unexplained: Vec::new() };
    record("hard-cases", quick, facts)
}

/// Method and label of some curves: as many in the first family as there are colours, one in
/// another, and one of a method that the families do not know.
pub(crate) const CURVES: [(&str, &str); 9] = [
    ("explicit-euler", "explicit-euler"),
    ("symplectic-euler:damping=implicit", "symplectic-euler, implicit damping"),
    ("leapfrog", "leapfrog"),
    ("provot", "provot"),
    ("provot:limit=10", "provot, limit out of reach"),
    ("adams-bashforth2", "adams-bashforth2"),
    ("adams-bashforth2:steps=3", "adams-bashforth, 3 steps"),
    ("imex-updated:safeguard=paper", "imex-updated, as printed, ε = 0.01"),
    ("unheard-of", "unheard-of"),
];

/// Errors of order 1 and 2; some runs diverge where the springs are stiff; `quick`: the smooth
/// scene only.
pub(crate) fn order(quick: bool) -> Record<order::Facts> {
    let scene = |id: &str, k_over_m: f64, damping: &str| order::Scene {
        id: id.to_owned(),
        resolved: k_over_m < 1e3,
        stiffness_over_mass_per_s2: k_over_m,
        damping_over_mass_per_s: 2.0,
        damping: damping.to_owned(),
        greatest_frequency_per_s: (10.0 * k_over_m).sqrt(),
        span_s: 0.25,
        reference_error_m: 2.7e-12,
        portable: false,
    };
    let mut scenes = vec![
        scene("smooth", 400.0, "full"),
        scene("smooth-projected", 400.0, "projected"),
        scene("stiff-1e4", 1e4, "full"),
        scene("stiff-1e6", 1e6, "full"),
    ];
    scenes.truncate(if quick { 1 } else { 4 });
    let mut rows = Vec::new();
    for scene in &scenes {
        for (n, (method, label)) in CURVES.into_iter().enumerate() {
            let p = 1 + n as u32 % 2;
            let run = |step: usize| {
                let step_s = 0.01 / f64::from(1 << step);
                let is_lost = !scene.resolved && n < 3 && step < 2 * n;
                let error = (!is_lost).then(|| 4.0 * step_s.powi(p as i32));
                let verdict = if is_lost { Verdict::Diverged } else { Verdict::Completed };
                order::Run { step_s, error, verdict, unconverged_steps: n as u64 / 8 }
            };
            let has_order = scene.resolved || n != 2;
            rows.push(order::Row {
                scene: scene.id.clone(),
                label: label.to_owned(),
                method: method.to_owned(),
                theory: (n != 3).then_some(p),
                order: has_order.then_some(if n == 4 { -0.25 } else { f64::from(p) }),
                fitted: 4,
                accepted: (scene.resolved && n != 3).then_some(n != 4),
                error_constant: (n != 3 && has_order).then_some(4.0),
                runs: (0..4).map(run).collect(),
                portable: false,
            });
        }
    }
    record("order", quick, order::Facts { scenes, rows })
}

/// Sheets and pairs whose spin decays; some runs are unstable; `quick`: a spinning sheet and a
/// pair.
pub(crate) fn momentum(quick: bool) -> Record<momentum::Facts> {
    let scene = |id: &str, particles: usize, k_over_m: f64, gravity: f64| momentum::Scene {
        id: id.to_owned(),
        particles,
        stiffness_over_mass_per_s2: k_over_m,
        spin_per_s: [0.0, 0.0, 2.0],
        gravity_m_s2: [0.0, 0.0, gravity],
        duration_s: 1.0,
        step_s: 0.01,
        greatest_frequency_per_s: (8.0 * k_over_m).sqrt(),
        mass_kg: 0.4,
        size_m: 1.4,
        speed_m_s: 1.4,
        time_s: (0..=10).map(|n| 0.1 * f64::from(n)).collect(),
        portable: true,
    };
    let mut scenes = vec![
        scene("spin-1e4", 400, 1e4, 0.0),
        scene("pair-1e4", 2, 1e4, 0.0),
        scene("spin-1e6", 400, 1e6, 0.0),
        scene("fall-1e4", 400, 1e4, -9.81),
    ];
    scenes.truncate(if quick { 2 } else { 4 });
    let mut rows = Vec::new();
    for scene in &scenes {
        for (n, (method, label)) in CURVES.into_iter().enumerate() {
            let is_unstable = n == 0 && scene.id == "spin-1e6";
            let spin: Vec<f64> = scene.time_s.iter().map(|t| (-t * n as f64).exp()).collect();
            let value = |value: f64| (!is_unstable).then_some(value);
            rows.push(momentum::Row {
                scene: scene.id.clone(),
                label: label.to_owned(),
                method: method.to_owned(),
                step_s: if n < 7 { 3.125e-4 } else { 0.01 },
                momentum_drift: value(if n == 7 { 1e-3 } else { 3e-15 }),
                angular_momentum_drift: value(1e-3),
                final_spin: value(spin[10]),
                law: value(spin[10]).filter(|_| scene.particles == 2 && n < 3),
                energy_gain: value(0.0),
                spin: if is_unstable { spin[..4].to_vec() } else { spin },
                states_momentum: true,
                states_angular_momentum: false,
                verdict: if is_unstable { Verdict::Unstable } else { Verdict::Completed }
                    .to_owned(),
                unconverged_steps: 0,
                portable: true,
            });
        }
    }
    record("momentum", quick, momentum::Facts { scenes, rows })
}

/// Claims and expectations of each verdict; the seconds bear out the refuted one and contradict C02, which is
/// confirmed.
pub(crate) fn claims() -> (Record<claims::Facts>, Timings<claims::TimingRow>) {
    use claims::{Number, Ruling, TimedCase, TimingRow};
    let numbers = || {
        vec![
            Number::new("ratio", 1.75, "").against(1.5),
            Number::new("iterations", 12.0, "1/step"),
            Number::new("gain", f64::INFINITY, "J"),
        ]
    };
    // Of a claim that is refuted with a repair.
    let jacobians = || {
        let fall = "mean fall in 0.3 s, k/m = 1e6";
        vec![
            Number::new("ratio, spectral norm, a sheet", 0.9, "").against(0.1),
            Number::new(format!("{fall}, IMEX Euler, without ∂F2"), 0.1, "m"),
            Number::new(format!("{fall}, Baraff-Witkin, with ∂F2 in the matrix"), 0.4, "m"),
        ]
    };
    let row = |id: &str, verdict: Ruling| claims::Row {
        id: id.to_owned(),
        verdict,
        numbers: if id == "C11" { jacobians() } else { numbers() },
        scenes: "a sheet | a table".to_owned(),
        portable: true,
    };
    let timing = |id: &str, verdict: Ruling| TimingRow {
        id: id.to_owned(),
        cases: vec![TimedCase {
            what: "a solve".to_owned(),
            samples_ns: vec![3_000_000, 2_000_000],
        }],
        number: Number::new("ratio of the seconds", 1.25, "").against(1.5),
        verdict,
    };
    let verdict = |n: usize| match n {
        11 => Ruling::Fails,
        4 => Ruling::Undecided,
        _ => Ruling::Holds,
    };
    let mut rows: Vec<_> = (1..30).map(|n| row(&format!("C{n:02}"), verdict(n))).collect();
    // Expectations about later methods, one of them confirmed.
    let expected = |n: usize| if n == 1 { Ruling::Holds } else { Ruling::Fails };
    rows.extend((1..9).map(|n| row(&format!("M{n:02}"), expected(n))));
    let rows_of_time = vec![timing("C11", Ruling::Fails), timing("C02", Ruling::Fails)];
    let timings = Timings {
        format: TIMINGS_FORMAT.to_owned(),
        experiment: "claims".to_owned(),
        method: "One after the other.".to_owned(),
        rows: rows_of_time,
        provenance: provenance(),
    };
    (record("claims", false, claims::Facts { claims: rows }), timings)
}
