//! Angles, hinges and air from a scene to the running system.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{
    AngleEffect, BlockSink, Mat3, SpringEffect, SpringSpec, State, System, SystemSpec, Tangent,
    Vec3, load, parse,
};
use serde_json::{Value, json};
use std::f64::consts::PI;

/// A grid of so many rows and columns with unit mesh width, and these effects.
fn grid(rows: u32, columns: u32, effects: Value) -> Result<SystemSpec, String> {
    let scene = json!({
        "format": "drape-scene/1", "name": "grid",
        "cloth": { "grid": { "rows": rows, "columns": columns, "size_m": [columns - 1, rows - 1],
            "center_m": [0, 0, 0], "mass_kg": 1 } },
        "effects": effects, "time": { "step_s": 0.1, "duration_s": 1 }
    });
    read(&scene)
}

fn read(value: &Value) -> Result<SystemSpec, String> {
    let input = parse("file.json", &value.to_string()).map_err(|error| error.to_string())?;
    Ok(input.spec().clone())
}

fn all_effects() -> Value {
    json!({
        "shear_angle": { "stiffness_n_m": 0.7 }, "bending_angle": { "stiffness_n_m": 0.3 },
        "bending_hinge": { "stiffness_n_m": 0.2 },
        "air": { "drag": { "quadratic": { "coefficient": 1.1 } },
            "wind": { "velocity_m_s": [1, 2, 3],
                "gust": { "amplitude_m_s": [0, 1, 0], "period_s": 2 } } }
    })
}

fn forces(system: &System, state: &State) -> Vec<Vec3> {
    let mut out = vec![Vec3::zeros(); state.len()];
    system.forces(state.level(), &mut out);
    out
}

fn energy(system: &System, name: &str, x: &[Vec3]) -> f64 {
    let effect = system.effects().find(|effect| effect.name() == name).unwrap();
    effect.energy(system.mass(), x)
}

#[test]
fn a_grid_has_its_number_of_angles_and_hinges_and_is_at_rest() {
    for (rows, columns) in [(2, 2), (2, 5), (4, 3), (7, 8)] {
        let spec = grid(rows, columns, all_effects()).unwrap();
        let (r, c) = (rows as usize, columns as usize);
        let count = |effect| spec.angles.iter().filter(|angle| angle.effect == effect).count();
        assert_eq!(count(AngleEffect::ShearAngle), 4 * (r - 1) * (c - 1), "{r} × {c}");
        assert_eq!(count(AngleEffect::BendingAngle), r * (c - 2) + (r - 2) * c, "{r} × {c}");
        let edges = 2 * (r - 1) * (c - 1) + (r - 1) * (c - 2) + (r - 2) * (c - 1);
        assert_eq!(spec.hinges.len(), edges - (r - 1) * (c - 1), "{r} × {c}");
        assert!(spec.hinges.iter().all(|hinge| hinge.rest_rad == 0.0));
        let (system, state) = spec.build().unwrap();
        let names: Vec<_> = system.effects().map(|effect| effect.name()).collect();
        let bends = ["shear_angle", "bending_angle", "bending_hinge", "air"];
        let present = bends.iter().filter(|n| **n != "bending_angle" || c > 2 || r > 2);
        assert_eq!(names, present.copied().collect::<Vec<_>>());
        let still = SystemSpec { effects: Default::default(), ..spec };
        let (still, _) = still.build().unwrap();
        assert!(forces(&still, &state).iter().all(|f| f.norm() < 1e-14));
    }
}

#[test]
fn a_sheared_sheet_has_the_energy_of_one_angle_for_each_particle_inside() {
    let (system, state) = grid(5, 6, all_effects()).unwrap().build().unwrap();
    let shear = 0.3_f64;
    let x: Vec<_> = state.x.iter().map(|x| x + Vec3::x() * (shear * x.y)).collect();
    let change = shear.atan(); // of the angle between warp and weft
    // A corner of a cell has a fourth of the stiffness, and every cell four corners.
    let expected = 0.5 * 0.7 * change * change * f64::from(4 * 5);
    assert!((energy(&system, "shear_angle", &x) / expected - 1.0).abs() < 1e-12);
    assert!(energy(&system, "bending_angle", &x) < 1e-28, "straight rows stay straight");
    assert!(energy(&system, "bending_hinge", &x) < 1e-28, "in the plane");
}

#[test]
fn a_sheet_bent_to_a_cylinder_has_the_energy_of_its_curvature() {
    let n = 41;
    let (system, state) = grid(n, n, all_effects()).unwrap().build().unwrap();
    let radius = 100.0;
    let bend =
        |x: &Vec3| Vec3::new(radius * (x.x / radius).sin(), x.y, -radius * (x.x / radius).cos());
    let x: Vec<_> = state.x.iter().map(bend).collect();
    // Each particle inside a row turns by h/R.
    let expected = 0.5 * 0.3 / (radius * radius) * f64::from(n * (n - 2));
    let found = energy(&system, "bending_angle", &x);
    assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    // Hinges: of the energy k ∫∫ κ²/2 at least the order of magnitude, on a mesh that prefers one
    // diagonal.
    let area = f64::from((n - 1) * (n - 1));
    let ratio = energy(&system, "bending_hinge", &x) / (0.5 * 0.2 / (radius * radius) * area);
    assert!((1.0..6.0).contains(&ratio), "{ratio}");
}

/// A tent of two triangles that is bent at rest.
fn tent() -> Value {
    json!({
        "format": "drape-scene/1", "name": "tent",
        "cloth": { "particles": {
            "particles": { "mass_kg": [1, 1, 1, 1],
                "position_m": [[0, 0, 0], [0, 2, 0], [-1, 1, -1], [1, 1, -1]] },
            "triangles": [[0, 1, 2], [1, 0, 3]] } },
        "effects": { "bending_hinge": { "stiffness_n_m": 0.5 } },
        "time": { "step_s": 0.1, "duration_s": 1 }
    })
}

#[test]
fn triangles_of_any_cloth_bend_about_their_rest() {
    let spec = read(&tent()).unwrap();
    let [hinge] = spec.hinges[..] else { panic!("{:?}", spec.hinges) };
    assert_eq!([hinge.i, hinge.j, hinge.k, hinge.l], [0, 1, 2, 3]);
    assert!((hinge.rest_rad.abs() - 0.5 * PI).abs() < 1e-15, "{hinge:?}");
    // 3 k |E|²/(A₁ + A₂), two triangles of area √2 over an edge of 2.
    assert!((hinge.stiffness_n_m - 3.0 * 0.5 * 4.0 / 8.0_f64.sqrt()).abs() < 1e-14, "{hinge:?}");
    let (system, state) = spec.build().unwrap();
    assert!(forces(&system, &state).iter().all(|f| f.norm() < 1e-15));
}

/// The particles in another order.
fn shuffled(spec: &SystemSpec) -> SystemSpec {
    let mut order: Vec<u32> = (0..spec.particles.mass_kg.len() as u32).collect();
    order.sort_by_key(|i| ((f64::from(*i) * 12.9898).sin() * 43_758.545).fract().to_bits());
    let new = |i: u32| order[i as usize];
    let mut out = spec.clone();
    for (i, x) in spec.particles.position_m.iter().enumerate() {
        out.particles.position_m[new(i as u32) as usize] = *x;
    }
    for angle in &mut out.angles {
        [angle.i, angle.j, angle.k] = [angle.i, angle.j, angle.k].map(new);
    }
    for hinge in &mut out.hinges {
        [hinge.i, hinge.j, hinge.k, hinge.l] = [hinge.i, hinge.j, hinge.k, hinge.l].map(new);
    }
    for spring in &mut out.springs {
        [spring.i, spring.j] = [spring.i, spring.j].map(new);
    }
    out.triangles.iter_mut().flatten().for_each(|i| *i = new(*i));
    out
}

#[test]
fn another_order_of_the_particles_carries_angles_hinges_and_triangles_along() {
    let mut spec = grid(36, 36, all_effects()).unwrap();
    let pairs = spec.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c)]);
    spec.springs = pairs
        .map(|(i, j)| SpringSpec {
            effect: SpringEffect::Tension,
            i,
            j,
            rest_length_m: 0.9,
            stiffness_n_per_m: 2.0,
            ..SpringSpec::default()
        })
        .collect();
    for (i, x) in spec.particles.position_m.iter_mut().enumerate() {
        let s = i as f64;
        *x = [x[0] + 0.1 * s.sin(), x[1] + 0.1 * (2.0 * s).cos(), 0.2 * (3.0 * s).sin()];
    }
    let spec = shuffled(&spec);
    let (given, start) = spec.build().unwrap();
    let (ordered, state, numbering) = spec.build_ordered().unwrap();
    assert!(!numbering.is_identity());
    let expected = forces(&given, &start);
    for (k, f) in forces(&ordered, &state).iter().enumerate() {
        let g = expected[numbering.given(k)];
        assert!((f - g).norm() < 1e-12 * (1.0 + g.norm()), "{f:?} {g:?}");
    }
}

#[test]
fn a_frozen_system_names_only_what_its_scene_names_and_reads_back() {
    let text = serde_json::to_string(load("hanging-textile-1e4").unwrap().spec()).unwrap();
    assert!(["angles", "hinges", "air"].iter().all(|key| !text.contains(&format!("\"{key}\""))));
    let spec = grid(4, 5, all_effects()).unwrap();
    let text = serde_json::to_string(&spec).unwrap();
    let back = read(&serde_json::from_str(&text).unwrap()).unwrap();
    assert_eq!(back, spec);
    let [(system, state), (again, _)] = [&spec, &back].map(|spec| spec.build().unwrap());
    assert_eq!(forces(&system, &state), forces(&again, &state));
}

/// Adds up the blocks on the diagonal.
struct Diagonal(Vec<Mat3>);

impl BlockSink for Diagonal {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.add_general_pair(i, j, block);
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.0[i] += block;
        self.0[j] += block.transpose();
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.0[i] += block;
    }
}

#[test]
fn stencils_one_by_one_add_up_to_the_effect() {
    let mut spec = grid(4, 5, all_effects()).unwrap();
    for (i, x) in spec.particles.position_m.iter_mut().enumerate() {
        let s = i as f64;
        *x = [x[0] + 0.1 * s.sin(), x[1] + 0.1 * (2.0 * s).cos(), 0.2 * (3.0 * s).sin()];
    }
    let (system, state) = spec.build().unwrap();
    let mut count = 0;
    for effect in system.effects() {
        let Some(stencils) = effect.stencils() else { continue };
        let mut expected = vec![Vec3::zeros(); state.len()];
        effect.add_force(system.mass(), &state.x, &mut expected);
        let mut diagonal = Diagonal(vec![Mat3::zeros(); state.len()]);
        effect.add_stiffness(&state.x, 1.0, Tangent::Projected, &mut diagonal);
        let mut stencil = 0;
        stencils.visit(&mut |particles| {
            for (place, &i) in particles.iter().enumerate() {
                let i = i as usize;
                let (force, block) = stencils.local(stencil, place, &state.x);
                expected[i] -= force;
                diagonal.0[i] -= block;
            }
            stencil += 1;
        });
        assert!(expected.iter().all(|f| f.norm() < 1e-13), "{}", effect.name());
        assert!(diagonal.0.iter().all(|k| k.norm() < 1e-12), "{}", effect.name());
        count += stencil;
    }
    assert_eq!(count, 48 + 22 + 29, "angles of shear and of bending, hinges");
}

#[test]
fn only_springs_that_are_not_linear_have_a_law() {
    let text = json!({
        "format": "drape-system/1",
        "particles": { "mass_kg": [1, 1, 1], "position_m": [[0, 0, 0], [1, 0, 0], [2, 0, 0]] },
        "springs": [
            { "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1,
                "stiffness_n_per_m": 2, "pieces": [
                { "up_to_strain": 0.5, "stiffness_n_per_m": 2 }, { "stiffness_n_per_m": 8 }] },
            { "effect": "shear", "i": 1, "j": 2, "rest_length_m": 1, "stiffness_n_per_m": 3 }]
    });
    let (system, _) = read(&text).unwrap().build().unwrap();
    let splits: Vec<_> = system.effects().filter_map(|effect| effect.split()).collect();
    let law = splits[0].law(0).expect("two slopes");
    assert_eq!([law.slope(1.0, 1.25), law.slope(1.0, 2.0)], [2.0, 8.0]);
    assert!(splits[0].law(1).is_none() && splits[1].law(0).is_none());
}

/// The angles one by one add up to the energy and the force of the effect.
#[test]
fn the_angles_of_an_effect_give_its_energy_and_its_force() {
    let (system, mut state) = grid(4, 5, all_effects()).unwrap().build().unwrap();
    for (i, x) in state.x.iter_mut().enumerate() {
        let a = i as f64;
        *x += Vec3::new(a.sin(), (2.0 * a).cos(), (3.0 * a).sin()) * 0.2;
    }
    for name in ["shear_angle", "bending_angle", "bending_hinge"] {
        let effect = system.effects().find(|effect| effect.name() == name).unwrap();
        let stencils = effect.stencils().unwrap();
        let mut members = Vec::new();
        stencils.visit(&mut |particles| members.push(particles.to_vec()));
        let (mut energy, mut force) = (0.0, vec![Vec3::zeros(); state.len()]);
        for (place, members) in members.iter().enumerate() {
            let at = |k: usize| state.x[members.get(k).copied().unwrap_or_default() as usize];
            let turn = stencils.turn(place, &[at(0), at(1), at(2), at(3)]).unwrap();
            energy += 0.5 * turn.stiffness * turn.excess * turn.excess;
            for (&i, gradient) in members.iter().zip(&turn.gradient) {
                force[i as usize] -= gradient * (turn.stiffness * turn.excess);
            }
        }
        let mut expected = vec![Vec3::zeros(); state.len()];
        effect.add_force(system.mass(), &state.x, &mut expected);
        let wrong = force.iter().zip(&expected).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(wrong < 1e-12, "{name}: {wrong:e} N");
        assert!((energy - effect.energy(system.mass(), &state.x)).abs() < 1e-13, "{name}");
    }
    let spring = system.effects().find(|effect| effect.name() == "air").unwrap();
    assert!(spring.stencils().is_none());
}
