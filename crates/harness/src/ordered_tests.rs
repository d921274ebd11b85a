//! A system in any order moves as the same system in a good order, and its messages use the given
//! indices of the particles.

use super::*;
use crate::run::{Moment, Runner};
use drape_model::{SceneFile, SpringSpec, parse};

/// A sheet of 36 × 30 particles that falls on a ball while two corners hold it.
fn sheet() -> SystemSpec {
    let text = r#"{ "format": "drape-scene/1", "name": "sheet", "cloth": { "grid": { "rows": 36, "columns": 30,
        "size_m": [1.2, 1], "center_m": [0, 0, 0], "mass_kg": 1.08, "velocity_m_s": [0.1, 0.2, 0.3] } },
        "effects": {
            "tension": { "stiffness_over_mass_per_s2": 1e4, "damping_over_mass_per_s": 10 },
            "shear": { "stiffness_over_mass_per_s2": 2e3 }, "bending": { "stiffness_over_mass_per_s2": 5e2 },
            "gravity": { "m_s2": [0, 0, -9.81] } },
        "pins": [{ "row": 0, "column": 0 }, { "row": 0, "column": 29 }],
        "obstacles": [{ "sphere": { "center_m": [0.1, 0.2, -0.21], "radius_m": 0.2 } }],
        "time": { "step_s": 0.1, "duration_s": 1 } }"#;
    match parse("sheet", text).unwrap() {
        SceneFile::Scene(_, spec) | SceneFile::System(spec) => spec,
    }
}

/// The same sheet with particles and springs in disorder, and the new index of each particle.
fn shuffled(spec: &SystemSpec) -> (SystemSpec, Vec<u32>) {
    fn shuffle<T>(list: &mut [T]) {
        let mut random = 1_u64;
        for last in (1..list.len()).rev() {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            list.swap(last, (random >> 33) as usize % (last + 1));
        }
    }
    let mut new: Vec<u32> = (0..spec.particles.mass_kg.len() as u32).collect();
    shuffle(&mut new);
    let mut out = spec.clone();
    for (i, &k) in new.iter().enumerate() {
        let (k, particles) = (k as usize, &mut out.particles);
        particles.mass_kg[k] = spec.particles.mass_kg[i];
        particles.position_m[k] = spec.particles.position_m[i];
        particles.velocity_m_s[k] = spec.particles.velocity_m_s[i];
    }
    for s in &mut out.springs {
        (s.i, s.j) = (new[s.i as usize], new[s.j as usize]);
    }
    shuffle(&mut out.springs);
    out.pins.iter_mut().for_each(|pin| pin.particle = new[pin.particle as usize]);
    out.triangles.iter_mut().flatten().for_each(|i| *i = new[*i as usize]);
    (out, new)
}

fn plain(spec: &SystemSpec) -> Simulation {
    let (system, state) = spec.build().unwrap();
    Simulation { system, state }
}

const TIME: TimeSpan = TimeSpan { step_s: 2e-3, duration_s: 0.05 };

fn choice(text: &str) -> Choice {
    Choice::parse(text, &[]).unwrap()
}

#[test]
fn a_shuffled_sheet_ends_where_the_sheet_ends() {
    let natural = sheet();
    let (spec, new) = shuffled(&natural);
    for (method, allowed) in [
        ("explicit-euler", 1e-9),
        ("symplectic-euler", 1e-9),
        ("adams-bashforth2", 1e-9),
        ("kang", 1e-9),
        ("imex-euler:forcing_term=1e-14", 1e-9),
        ("imex-euler:solver=cholesky", 1e-9),
        ("imex-sbdf2:forcing_term=1e-14", 1e-9),
        ("baraff-witkin:forcing_term=1e-14", 1e-9),
        ("terzopoulos-fleischer", 1e-9),
        ("backward-euler:cg_tolerance=1e-10", 1e-6),
    ] {
        let choice = choice(method);
        let mut plain = plain(&natural);
        let wanted = Runner::new(&choice, TIME).series().go(&mut plain).unwrap();
        let mut ordered = OrderedSimulation::new(&spec, &choice).unwrap();
        assert!(!ordered.numbering().is_identity());
        let mut last = None;
        let look = |moment: &Moment<'_>| last = Some(moment.moving().state().into_owned());
        let found = ordered.simulate(TIME, |runner| runner.series().observe(look)).unwrap();
        let state = ordered.state();
        assert_eq!(last.as_ref(), Some(&*state), "{method}: observed");
        assert_eq!(state.t, plain.state.t);
        for (i, &k) in new.iter().enumerate() {
            let k = k as usize;
            let apart = (state.x[k] - plain.state.x[i]).norm();
            assert!(apart <= allowed, "{method}: particle {i} is {apart:e} m off");
            let apart = (state.v[k] - plain.state.v[i]).norm();
            assert!(apart <= 1e3 * allowed, "{method}: particle {i} is {apart:e} m/s off");
        }
        assert_eq!(found.series.len(), wanted.series.len());
        for (a, b) in found.series.iter().zip(&wanted.series) {
            let (a, b) = (a.energy_j["total"], b.energy_j["total"]);
            assert!(
                (a - b).abs() <= 10.0 * allowed.max(1e-9) * (1.0 + b.abs()),
                "{method}: {a} J, {b} J"
            );
        }
    }
}

#[test]
fn what_is_in_good_order_or_depends_on_it_runs_as_given() {
    let natural = sheet();
    let (disorder, _) = shuffled(&natural);
    for (spec, method) in [
        (&natural, "imex-euler"),
        (&disorder, "provot"),
        (&disorder, "desbrun:inverse_dynamics=true"),
    ] {
        let choice = choice(method);
        let mut plain = plain(spec);
        Runner::new(&choice, TIME).go(&mut plain).unwrap();
        let mut ordered = OrderedSimulation::new(spec, &choice).unwrap();
        ordered.simulate(TIME, |runner| runner).unwrap();
        assert!(ordered.numbering().is_identity(), "{method}");
        assert_eq!(*ordered.state(), plain.state, "{method}");
    }
    assert!(!choice("desbrun").follows_springs());
}

#[test]
fn a_particle_that_is_lost_is_called_by_its_given_index() {
    let (mut spec, new) = shuffled(&sheet());
    let lost = [new[500] as usize, new[700] as usize];
    // This spring drives the two apart before the other particles can follow.
    let [i, j] = lost.map(|k| k as u32);
    let (rest_length_m, stiffness_n_per_m) = (1e6, 1e6);
    spec.springs.push(SpringSpec { i, j, rest_length_m, stiffness_n_per_m, ..Default::default() });
    let choice = choice("explicit-euler");
    let mut ordered = OrderedSimulation::new(&spec, &choice).unwrap();
    let first = lost[0].min(lost[1]);
    assert_ne!(ordered.numbering().internal(first), first);
    let outcome = ordered.simulate(TIME, |runner| runner).unwrap();
    let criterion = outcome.divergence.unwrap().criterion;
    assert!(criterion.starts_with(&format!("particle {first} is farther")), "{criterion}");
}

/// A flat sheet with these effects and no gravity, its particles displaced by up to a micrometre.
fn shaken(effects: &str) -> SystemSpec {
    let text = format!(
        r#"{{ "format": "drape-scene/1", "name": "shaken", "cloth": {{ "grid": {{ "rows": 9, "columns": 8,
        "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 0.1 }} }}, "effects": {{ {effects} }},
        "time": {{ "step_s": 0.01, "duration_s": 1 }} }}"#
    );
    let SceneFile::Scene(_, mut spec) = parse("shaken", &text).unwrap() else { unreachable!() };
    let mut random = 1_u64;
    for x in spec.particles.position_m.iter_mut().flatten() {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        *x += 1e-6 * ((random >> 33) as f64 / (1_u64 << 30) as f64 - 1.0);
    }
    spec
}

/// The greatest speed at the end of a run of 400 steps of a length over the limit, m/s; infinite if
/// it diverged.
fn speed_after(spec: &SystemSpec, method: &str, share: f64) -> f64 {
    let choice = Choice::parse(method, &[]).unwrap();
    let mut simulation = OrderedSimulation::new(spec, &choice).unwrap();
    let step_s = share * simulation.explicit_numbers().limit();
    let time = TimeSpan { step_s, duration_s: 400.0 * step_s };
    let outcome = simulation.simulate(time, |runner| runner).unwrap();
    let speed = simulation.state().v.iter().fold(0.0, |most: f64, v| most.max(v.norm()));
    if outcome.divergence.is_some() { f64::INFINITY } else { speed }
}

#[test]
fn a_step_below_the_limit_is_stable_and_one_above_blows_up() {
    const ANGLES: &str = r#""tension": { "stiffness_over_mass_per_s2": 1e2 }, "bending_angle": { "stiffness_n_m": 0.01 }"#;
    /// Springs that hold a sheet about twice as strongly across as along.
    const STIFFER: &str = r#""tension": { "stiffness_over_mass_per_s2": 5e2 }, "bending_angle": { "stiffness_n_m": 0.01 }"#;
    const SPRINGS: &str = r#""tension": { "stiffness_over_mass_per_s2": 1e4 },
        "bending": { "stiffness_over_mass_per_s2": 1e3 }"#;
    for (effects, method) in [
        (ANGLES, "imex-euler"),
        (STIFFER, "imex-euler"),
        (ANGLES, "symplectic-euler"),
        (SPRINGS, "symplectic-euler"),
        (SPRINGS, "leapfrog"),
    ] {
        let spec = shaken(effects);
        let [below, above] = [0.95, 1.05].map(|share| speed_after(&spec, method, share));
        assert!(below < 0.01 && above > 0.1, "{method}, {effects}: {below:e}, {above:e}");
    }
}

/// A triangle that falls in still air at its terminal speed.
#[test]
fn a_fall_at_terminal_speed_is_steady_below_the_limit_and_not_above() {
    let (speed, disturbed) = (5.0, 1e-4);
    let drag = 3.0 * 0.1 * 9.81 / (0.5 * speed * speed); // ½ ρ C of ½ m² and 0.3 kg
    let text = format!(
        r#"{{ "format": "drape-system/1", "triangles": [[0, 1, 2]], "effects": {{ "gravity": {{ "m_s2": [0, 0, -9.81] }},
        "air": {{ "drag": {{ "quadratic": {{ "coefficient": {drag}, "density_kg_m3": 2 }} }} }} }},
        "particles": {{ "mass_kg": [0.1, 0.1, 0.1], "position_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
            "velocity_m_s": [[0, 0, -{v}], [0, 0, -{v}], [0, 0, -{v}]] }} }}"#,
        v = speed + disturbed
    );
    let SceneFile::System(spec) = parse("fall", &text).unwrap() else { unreachable!() };
    let strays = |share| (speed_after(&spec, "symplectic-euler", share) - speed).abs();
    assert!(strays(0.95) < 1e-3 * disturbed, "{}", strays(0.95));
    assert!(strays(1.05) > 100.0 * disturbed, "{}", strays(1.05));
}

/// A sheet that flies on, until a remaining vibration blows up.
#[test]
fn the_peak_before_a_rise_leaves_out_what_the_blow_up_made_fast() {
    let mut spec = shaken(r#""tension": { "stiffness_over_mass_per_s2": 1e4 }"#);
    spec.particles.velocity_m_s = vec![[0.3, 0.0, 0.1]; spec.particles.mass_kg.len()];
    let mut simulation = OrderedSimulation::new(&spec, &choice("symplectic-euler")).unwrap();
    let start = simulation.moving().energy();
    let (mut all, mut before) = (Peak::default(), Peak::before_a_rise_above(start));
    let step_s = 1.5 * simulation.explicit_numbers().limit();
    let time = TimeSpan { step_s, duration_s: 1000.0 * step_s };
    let look = |moment: &Moment<'_>| {
        all.look(moment.moving());
        before.look(moment.moving());
    };
    let outcome = simulation.simulate(time, |runner| runner.observe(look)).unwrap();
    assert!(outcome.divergence.is_some());
    assert!(all.energy > 1e3 * start, "{} J of {start} J", all.energy);
    let kept = before.energy / start;
    assert!((0.99..=2.0).contains(&kept), "{kept}");
}

#[test]
fn the_peak_is_the_fastest_of_the_states_that_were_looked_at() {
    let choice = Choice::parse("symplectic-euler", &[]).unwrap();
    let mut simulation = OrderedSimulation::new(&sheet(), &choice).unwrap();
    let (mut peak, mut fastest) = (Peak::default(), (0.0, 0.0));
    assert_eq!(simulation.explicit_numbers_at_peak(&peak), None);
    let time = TimeSpan { step_s: 1e-3, duration_s: 1.0 };
    let look = |moment: &Moment<'_>| {
        peak.look(moment.moving());
        let energy = moment.system.kinetic_energy(&moment.state.v);
        if energy > fastest.0 {
            fastest = (energy, moment.state.t);
        }
    };
    simulation.simulate(time, |runner| runner.observe(look)).unwrap();
    let (time, _) = simulation.explicit_numbers_at_peak(&peak).unwrap();
    assert!(time == fastest.1 && time < 1.0, "{time}, {fastest:?}");
}
