//! The grid's geometry, and energies, forces and momenta of a system.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{EffectKind, State, SystemSpec, TimeSpan, Vec3, parse};

fn grid(rows: u32, columns: u32, more: &str) -> SystemSpec {
    let law = r#"{ "stiffness_over_mass_per_s2": 100, "damping_n_s_per_m": 0.5 }"#;
    let text = format!(
        r#"{{ "format": "drape-scene/1", "name": "grid", "cloth": {{ "grid": {{ "rows": {rows},
        "columns": {columns}, "size_m": [3, 2], "center_m": [1, -2, 0.5], "mass_kg": 0.6 }} }},
        "effects": {{ "tension": {law}, "shear": {law}, "bending": {law} }}, {more}
        "time": {{ "step_s": 0.1, "duration_s": 1 }} }}"#
    );
    parse("grid", &text).unwrap().spec().clone()
}

fn count(spec: &SystemSpec, effect: &str) -> usize {
    spec.springs.iter().filter(|s| s.effect.name() == effect).count()
}

#[test]
fn every_effect_has_its_number_of_springs_and_none_twice() {
    for (rows, columns) in [(1, 1), (1, 2), (1, 7), (5, 1), (2, 2), (3, 4), (20, 20), (6, 11)] {
        let spec = grid(rows, columns, "");
        let (r, c) = (rows as usize, columns as usize);
        assert_eq!(count(&spec, "tension"), r * (c - 1) + (r - 1) * c, "{r} × {c}");
        assert_eq!(count(&spec, "shear"), 2 * (r - 1) * (c - 1), "{r} × {c}");
        let bending = r * c.saturating_sub(2) + r.saturating_sub(2) * c;
        assert_eq!(count(&spec, "bending"), bending, "{r} × {c}");
        assert_eq!(spec.triangles.len(), 2 * (r - 1) * (c - 1), "{r} × {c}");
        let mut pairs: Vec<_> = spec.springs.iter().map(|s| (s.i.min(s.j), s.i.max(s.j))).collect();
        pairs.sort_unstable();
        pairs.dedup();
        assert_eq!(pairs.len(), spec.springs.len(), "{r} × {c}: a spring twice");
    }
}

#[test]
fn a_grid_has_its_mass_its_centre_and_relaxed_springs() {
    for (rows, columns) in [(1, 1), (1, 7), (5, 1), (3, 4), (20, 20)] {
        let spec = grid(rows, columns, "");
        let n = spec.particles.mass_kg.len();
        assert_eq!(n, (rows * columns) as usize);
        assert!((spec.particles.mass_kg.iter().sum::<f64>() - 0.6).abs() < 1e-14);
        let x: Vec<Vec3> = spec.particles.position_m.iter().map(|&p| p.into()).collect();
        let center = Vec3::new(1.0, -2.0, 0.5);
        for (a, b) in x.iter().zip(x.iter().rev()) {
            assert!((a + b - center * 2.0).norm() < 1e-14, "not symmetric about the centre");
        }
        for spring in &spec.springs {
            let length = (x[spring.i as usize] - x[spring.j as usize]).norm();
            assert!((length - spring.rest_length_m).abs() < 1e-14, "{spring:?}: {length}");
            assert!((spring.stiffness_n_per_m - 100.0 * 0.6 / n as f64).abs() < 1e-12);
            assert_eq!(spring.damping_n_s_per_m, 0.5);
        }
        if rows > 1 && columns > 1 {
            let extent = x[n - 1] - x[0];
            assert!((extent - Vec3::new(3.0, 2.0, 0.0)).norm() < 1e-14);
        }
    }
}

#[test]
fn triangles_cover_the_sheet_and_face_up() {
    let spec = grid(4, 6, "");
    let x = |i: u32| Vec3::from(spec.particles.position_m[i as usize]);
    let mut area = 0.0;
    for &[a, b, c] in &spec.triangles {
        let normal = (x(b) - x(a)).cross(&(x(c) - x(a)));
        assert!(normal.z > 0.0 && normal.xy().norm() < 1e-14, "{normal:?}");
        area += 0.5 * normal.norm();
    }
    assert!((area - 6.0).abs() < 1e-12, "{area}");
}

#[test]
fn pins_by_row_and_column_and_by_index_are_the_same() {
    let spec = grid(
        3,
        4,
        r#""pins": [{ "row": 2, "column": 1 }, { "particle": 9 }, { "row": 0, "column": 3 }],"#,
    );
    let pins: Vec<u32> = spec.pins.iter().map(|pin| pin.particle).collect();
    assert_eq!(pins, [9, 9, 3]);
    let (system, _) = spec.build().unwrap();
    let pinned: Vec<usize> = (0..12).filter(|&i| system.pinned()[i]).collect();
    assert_eq!(pinned, [3, 9]);
    assert_eq!(spec.particles.position_m[3], [2.5, -3.0, 0.5]);
}

#[test]
fn the_number_of_steps_counts_a_shortened_last_one() {
    let steps = |step_s, duration_s| TimeSpan { step_s, duration_s }.steps();
    assert_eq!(steps(0.01, 1.0), (100, None));
    assert_eq!(steps(0.1, 0.3), (3, None));
    assert_eq!(steps(1.0, 1e-10), (0, Some(1e-10)));
    let (whole, last) = steps(0.3, 1.0);
    assert_eq!(whole, 3);
    assert!((last.unwrap() - 0.1).abs() < 1e-12);
}

/// A deformed, moving sheet.
fn moving(more: &str) -> (drape_model::System, State) {
    let (system, mut state) = grid(4, 5, more).build().unwrap();
    for (k, (x, v)) in state.x.iter_mut().zip(&mut state.v).enumerate() {
        let s = k as f64;
        *x += Vec3::new((1.3 * s).sin(), (2.1 * s).cos(), (0.7 * s).sin()) * 0.1;
        *v = Vec3::new((0.9 * s).cos(), (1.7 * s).sin(), (2.3 * s).cos());
    }
    (system, state)
}

fn force(system: &drape_model::System, state: &State) -> Vec<Vec3> {
    let mut out = vec![Vec3::zeros(); state.len()];
    system.forces(state.level(), &mut out);
    out
}

#[test]
fn momenta_are_sums_over_particles_and_shift_with_the_frame() {
    let (system, mut state) = moving("");
    let (p, l) = (system.momentum(&state), system.angular_momentum(&state));
    let m = 0.6 / 20.0;
    let direct: Vec3 = state.v.iter().sum();
    assert!((p - direct * m).norm() < 1e-15);
    let (shift, boost) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(-0.5, 0.25, 2.0));
    state.x.iter_mut().for_each(|x| *x += shift);
    assert!((system.angular_momentum(&state) - l - shift.cross(&p)).norm() < 1e-13);
    let kinetic = system.kinetic_energy(&state.v);
    state.v.iter_mut().for_each(|v| *v += boost);
    assert!((system.momentum(&state) - p - boost * 0.6).norm() < 1e-14);
    let expected = kinetic + p.dot(&boost) + 0.3 * boost.norm_squared();
    assert!((system.kinetic_energy(&state.v) - expected).abs() < 1e-13);
}

#[test]
fn springs_give_neither_momentum_nor_with_projected_damping_torque() {
    for (law, keeps_spin) in [("full", false), ("projected", true)] {
        let (system, state) = moving(&format!(r#""damping": "{law}","#));
        let f = force(&system, &state);
        let total: Vec3 = f.iter().sum();
        assert!(total.norm() < 1e-12, "{law}: {total:?}");
        let torque: Vec3 = state.x.iter().zip(&f).map(|(x, f)| x.cross(f)).sum();
        assert_eq!(torque.norm() < 1e-12, keeps_spin, "{law}: {torque:?}");
    }
}

#[test]
fn forces_are_the_slope_of_the_energy_and_damping_takes_energy_away() {
    for law in ["full", "projected"] {
        let more = format!(r#""damping": "{law}","#);
        let (system, mut state) = moving(&more);
        let damped = force(&system, &state);
        let v = std::mem::replace(&mut state.v, vec![Vec3::zeros(); 20]);
        let f = force(&system, &state);
        let power: f64 = damped.iter().zip(&f).zip(&v).map(|((a, b), v)| (a - b).dot(v)).sum();
        assert!(power < -1e-3, "{law}: {power}");
        for (k, axis) in [(0, 0), (7, 1), (11, 2), (19, 0)] {
            let mut energy = |offset: f64| {
                let x = state.x[k][axis];
                state.x[k][axis] = x + offset;
                let energy = system.potential_energy(&state.x);
                state.x[k][axis] = x;
                energy
            };
            let slope = (energy(1e-5) - energy(-1e-5)) / 2e-5;
            assert!((slope + f[k][axis]).abs() < 1e-8, "{law}: {slope} and {}", f[k][axis]);
        }
    }
}

#[test]
fn gravity_energy_is_weight_times_height_and_named_apart() {
    let text = r#"{ "format": "drape-system/1", "particles": { "mass_kg": [2, 3],
        "position_m": [[5, 0, 1.5], [0, 7, -1]] },
        "effects": { "gravity": { "m_s2": [0, 0, -10] } } }"#;
    let (mut system, state) = parse("gravity", text).unwrap().spec().build().unwrap();
    let energies: Vec<_> = system.energies(&state.x).collect();
    assert_eq!(energies, [("gravity", 2.0 * 10.0 * 1.5 - 3.0 * 10.0)]);
    assert_eq!(system.total_energy(&state), 0.0);
    assert_eq!(force(&system, &state), [Vec3::new(0.0, 0.0, -20.0), Vec3::new(0.0, 0.0, -30.0)]);
    let before = system.revisions();
    assert!(
        !system.set_mass(&[1.0])
            && !system.set_mass(&[1.0, 0.0])
            && !system.set_mass(&[1.0, 1e-162])
            && !system.set_mass(&[1.0, f64::NAN])
    );
    assert!(
        !system.scale_stiffness(EffectKind::Tension, 2.0)
            && !system.scale_damping(EffectKind::Gravity, 2.0)
    );
    assert!(!system.set_pinned(2, true));
    assert_eq!(system.revisions(), before);
    assert!(system.set_mass(&[1.0, 1.0]) && system.set_pinned(0, true));
    assert_ne!(system.revisions().mass, before.mass);
    assert_ne!(system.revisions().pins, before.pins);
    assert_eq!(system.revisions().topology, before.topology);
}

#[test]
fn display_positions_lie_outside_and_leave_the_others_alone() {
    let more = r#""obstacles": [{ "plane": { "point_m": [0, 0, 0.5], "normal": [0, 0, 1] } },
        { "sphere": { "center_m": [1, -2, 0.6], "radius_m": 0.5 } },
        { "plane": { "point_m": [0.2, 0, 0], "normal": [1, 0, 0] } }],"#;
    let (system, state) = moving(more);
    let shown = system.display_positions(&state.x, 0.0);
    let mut moved = 0;
    for (x, shown) in state.x.iter().zip(&shown) {
        let depth = |x: &Vec3| {
            system.obstacles().iter().map(|o| o.distance(x).0).fold(f64::INFINITY, f64::min)
        };
        assert!(depth(shown) > -1e-9, "{shown:?} lies {} deep", -depth(shown));
        assert_eq!(depth(x) >= 0.0, x == shown);
        moved += usize::from(x != shown);
    }
    assert!(moved > 3 && moved < 20, "{moved}");
}

#[test]
fn display_positions_lie_outside_of_obstacles_where_those_are_at_the_time() {
    let more = r#""obstacles": [{ "plane": { "point_m": [0, 0, 0.5], "normal": [0, 0, 1],
        "path": [{ "time_s": 2, "offset_m": [0, 0, 1] }] } }],"#;
    let (system, state) = moving(more);
    for t in [0.0, 0.5, 1.5, 3.0] {
        let surface = 0.5 + 0.5 * f64::min(t, 2.0);
        for (x, shown) in state.x.iter().zip(&system.display_positions(&state.x, t)) {
            assert!((shown.z - x.z.max(surface)).abs() < 1e-12, "{shown:?} at {t} s");
            assert_eq!((shown.x, shown.y), (x.x, x.y));
        }
    }
}
