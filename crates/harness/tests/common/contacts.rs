//! Synthetic records of contacts, corrections by hand and kept inverses.

use super::{provenance, record};
use drape_harness::studies::collision::facts as collision;
use drape_harness::studies::post_correction::facts as post_correction;
use drape_harness::studies::precomputed_inverse::facts as precomputed_inverse;
use drape_harness::studies::precomputed_inverse::facts::{CG, CHOLESKY, DENSE};
use drape_report::Verdict;
use drape_report::{Record, TIMINGS_FORMAT, Timings};

/// Falls whose other ways out take twice the iterations, one of them unstable; `quick`: the table
/// alone.
pub(crate) fn collision(quick: bool) -> Record<collision::Facts> {
    use collision::{POSITION, TELEPORT, VELOCITY};
    let scene = |obstacle: &str, stiffness: f64| collision::Scene {
        id: format!("{obstacle}-3-{stiffness:e}"),
        obstacle: obstacle.to_owned(),
        speed_m_s: 3.0,
        stiffness_over_mass_per_s2: stiffness,
        step_s: 0.01,
        steps: 60,
        particles: 400,
        drop_m: 0.3,
        available_j: 4.0,
        portable: true,
    };
    let mut scenes =
        vec![scene("table", 1e4), scene("table", 1e6), scene("sphere", 1e4), scene("sphere", 1e6)];
    scenes.truncate(if quick { 2 } else { 4 });
    let forms = [
        ("imex-euler", VELOCITY),
        ("imex-euler", TELEPORT),
        ("baraff-witkin", VELOCITY),
        ("baraff-witkin", POSITION),
        ("baraff-witkin", TELEPORT),
    ];
    let mut rows = Vec::new();
    for scene in &scenes {
        for (n, (label, way_out)) in forms.into_iter().enumerate() {
            let is_unstable = n == 4 && scene.stiffness_over_mass_per_s2 > 1e5;
            let is_drawn = scene.obstacle == "table";
            let rate = if way_out == VELOCITY { 2 } else { 4 };
            rows.push(collision::Row {
                scene: scene.id.clone(),
                label: label.to_owned(),
                way_out: way_out.to_owned(),
                method: label.to_owned(),
                steps_before: 10,
                steps_after: 50,
                iterations_before: 10,
                iterations_after: 50 * rate,
                iterations_by_step: if is_drawn { vec![rate as u32; 60] } else { Vec::new() },
                teleports: 0,
                depth_m: 0.02,
                depth_over_reach: 0.7,
                displayed_depth_m: 0.0,
                release_j: 0.1,
                climb_j: 0.1,
                gain: if is_unstable { 3.0 } else { 0.0 },
                unconverged_steps: 0,
                verdict: if is_unstable { Verdict::Unstable } else { Verdict::Stable },
                portable: true,
            });
        }
    }
    let bounce = |restitution: f64, way_out: &str| collision::Bounce {
        body: "particle".to_owned(),
        obstacle: "plane".to_owned(),
        label: "imex-euler".to_owned(),
        way_out: way_out.to_owned(),
        method: "imex-euler".to_owned(),
        speed_m_s: 3.0,
        restitution,
        measured: Some(restitution),
        height_m: Some(0.5 * restitution),
        height_theory_m: Some(0.5 * restitution),
        portable: true,
    };
    let bounces = vec![bounce(0.0, VELOCITY), bounce(1.0, VELOCITY), bounce(1.0, TELEPORT)];
    record("collision", quick, collision::Facts { scenes, rows, bounces })
}

/// Corrected sheets that come nearer to the stiff one; `quick`: one limit.
pub(crate) fn post_correction(quick: bool) -> Record<post_correction::Facts> {
    use post_correction::{FORWARD, Mesh, PERTURBED, Row, Spin, Sweeps};
    let mesh = |id: &str| Mesh {
        id: id.to_owned(),
        particles: 400,
        springs: 1500,
        stiffness_over_mass_per_s2: 1e4,
        reference_stiffness_over_mass_per_s2: 1e7,
        damping_over_mass_per_s: 10.0,
        time_s: vec![0.25, 0.5],
        motion_m: vec![0.3, 0.8],
        reference_error: vec![1e-4, 1e-3],
        uncorrected_distance: vec![0.5, 0.9],
        uncorrected_elongation: 4.0,
        reference_elongation: 0.01,
        released_j: 2.0,
        portable: true,
    };
    let meshes = vec![mesh("grid"), mesh("triangles")];
    let limits: &[f64] = if quick { &[0.1] } else { &[0.1, 0.05, 0.01] };
    let (mut rows, mut spins, mut sweeps) = (Vec::new(), Vec::new(), Vec::new());
    for mesh in &meshes {
        for &limit in limits {
            for (label, count) in [("provot", 1), ("provot", 10), ("desbrun", 1)] {
                for (n, order) in [FORWARD, "backward", PERTURBED].into_iter().enumerate() {
                    rows.push(Row {
                        mesh: mesh.id.clone(),
                        label: label.to_owned(),
                        method: label.to_owned(),
                        limit,
                        sweeps: count,
                        order: order.to_owned(),
                        step_s: 0.0025,
                        distance: vec![limit, 2.0 * limit / f64::from(count)],
                        order_distance: if n == 0 { Vec::new() } else { vec![1e-3, 0.02] },
                        energy_taken: 0.1,
                        energy_given: 0.4,
                        weight_held: 0.9,
                        residual: 1.1,
                        uncorrected_residual: 0.0,
                        elongation: 3.0 * limit,
                        verdict: Verdict::Completed,
                        portable: true,
                    });
                }
            }
            for order in ["forward", "alternating"] {
                sweeps.push(Sweeps {
                    mesh: mesh.id.clone(),
                    limit,
                    order: order.to_owned(),
                    before: 0.9,
                    sweeps: vec![1, 10, 100],
                    elongation: vec![1.0, 0.5, limit],
                    portable: true,
                });
            }
        }
        spins.push(Spin {
            mesh: mesh.id.clone(),
            label: "provot".to_owned(),
            method: "provot".to_owned(),
            limit: None,
            momentum_change: 0.0,
            angular_momentum_left: 1.0,
            angular_momentum_taken: 0.0,
            energy_left: 1.0,
            portable: true,
        });
    }
    record("post-correction", quick, post_correction::Facts { meshes, rows, spins, sweeps })
}

const SOLVERS: [(&str, &str); 4] =
    [(DENSE, "any"), (CHOLESKY, "any"), (CG, "k/m = 1e4"), (CG, "one fabric")];

fn sizes(quick: bool) -> &'static [usize] {
    if quick { &[100] } else { &[100, 400, 900] }
}

/// Solvers whose costs grow as they should; `quick`: the smallest size.
pub(crate) fn inverse(quick: bool) -> Record<precomputed_inverse::Facts> {
    let mut solvers = Vec::new();
    for &particles in sizes(quick) {
        for (place, (solver, series)) in SOLVERS.into_iter().enumerate() {
            let n = particles as f64;
            solvers.push(precomputed_inverse::Solver {
                particles,
                solver: solver.to_owned(),
                series: series.to_owned(),
                stiffness_over_mass_per_s2: 1e4,
                matrix_nonzeros: 9 * particles,
                kept_nonzeros: if place == 0 { particles * particles } else { 20 * particles },
                kept_bytes: 240 * particles as u64,
                setup_operations: if place == 0 { n * n * n } else { 100.0 * n },
                solve_operations: if place == 0 { 6.0 * n * n } else { 200.0 * n },
                cg_per_step: if place < 2 { 0.0 } else { 3.5 },
                disagreement: 1e-15,
                portable: false,
            });
        }
    }
    let change = |solver: &str| precomputed_inverse::Change {
        solver: solver.to_owned(),
        method: "desbrun".to_owned(),
        steps: 100,
        first: 1,
        step_size: 12,
        stiffness: 3,
        constraints: 2,
        changed: vec!["h halved".to_owned(), "k × 100".to_owned()],
        distance_to_fresh_m: vec![0.0, 1e-15],
        portable: false,
    };
    let changes = vec![change(DENSE), change(CG)];
    record("precomputed-inverse", quick, precomputed_inverse::Facts { solvers, changes })
}

/// Their times.
pub(crate) fn inverse_timings() -> Timings<precomputed_inverse::TimingRow> {
    let mut rows = Vec::new();
    for &particles in sizes(false) {
        for (place, (solver, series)) in SOLVERS.into_iter().enumerate() {
            let scale = if place == 0 { particles } else { 1 };
            let samples = |ns: usize| vec![(ns * particles * scale) as u64; 3];
            rows.push(precomputed_inverse::TimingRow {
                particles,
                solver: solver.to_owned(),
                series: series.to_owned(),
                method: "desbrun".to_owned(),
                setup_ns: samples(1000),
                rebuild_ns: samples(400),
                step_ns: samples(20),
                solve_ns: samples(10),
            });
        }
    }
    Timings {
        format: TIMINGS_FORMAT.to_owned(),
        experiment: "precomputed-inverse".to_owned(),
        method: "Five repetitions.".to_owned(),
        rows,
        provenance: provenance(),
    }
}
