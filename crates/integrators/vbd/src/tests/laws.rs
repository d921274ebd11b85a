//! Exact laws: the oscillator, two particles, free fall.

use super::support::{prepared, settings};
use crate::{VBD, Vbd};
use drape_integrator::{Integrator, PrepareError};
use drape_model::{DampingLaw, Effect, EffectKind, State, System, Vec3};
use drape_oracle::laws::{Drift, free_fall};
use drape_oracle::recurrence::{backward_euler, vbd_pair};
use drape_oracle::scenes::{Sheet, anchored, build, particles, tension};
use drape_oracle::seconds;
use nalgebra::{Vector2, Vector4};

const H: f64 = 1.0 / 64.0;
const MASS: f64 = 0.25;

/// One block is one equation: a single sweep solves it. Along the spring both laws of damping are
/// one.
#[test]
fn a_single_sweep_on_an_anchored_spring_is_backward_euler() {
    let (rest, start) = (4.0, (4.25, -1.5));
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        for (theta, eta) in [(0.36, 0.06), (1.0, 0.0), (100.0, 0.4), (1e4, 200.0)] {
            let springs = [(
                drape_model::SpringEffect::Tension,
                rest,
                theta * MASS / (H * H),
                eta * MASS / H,
            )];
            let (x, v) = (Vec3::x() * start.0, Vec3::x() * start.1);
            let mut spec = anchored(MASS, &springs, x, v);
            spec.damping = law;
            let mut run = prepared("sweeps=1", build(&spec), H);
            let mut exact = Vector2::new(start.0 - rest, H * start.1);
            let size = exact.norm();
            for (step, ratio) in [1.0, 2.0, 0.5, 1.5, 0.75].into_iter().cycle().take(50).enumerate()
            {
                run.step_by(ratio * H);
                exact.y *= ratio;
                exact = backward_euler(theta * ratio * ratio, eta * ratio) * exact;
                exact.y /= ratio;
                let found = Vector2::new(run.state.x[1].x - rest, H * run.state.v[1].x);
                let off = (found - exact).norm() / size;
                assert!(off < 1e-12, "{law:?}, θ={theta} η={eta}, step {step}: {off:e}");
            }
        }
    }
}

#[test]
fn a_pair_after_any_number_of_sweeps_is_its_recurrence() {
    for sweeps in [1, 2, 5, 20] {
        for (s, d) in [(0.5, 0.0), (3.0, 0.5), (50.0, 0.0), (50.0, 20.0)] {
            let x = [Vec3::x(), Vec3::x() * -0.5];
            let v = [Vec3::x() * 3.0, Vec3::x() * 40.0];
            let mut spec = particles(&[MASS; 2], &x, &v);
            spec.springs = vec![tension((0, 1), 0.0, s * MASS / (H * H), d * MASS / H)];
            let mut run = prepared(&format!("sweeps={sweeps}"), build(&spec), H);
            let mut exact = Vector4::new(x[0].x, x[1].x, H * v[0].x, H * v[1].x);
            let (matrix, mut size) = (vbd_pair(s, d, sweeps), exact.norm());
            for step in 0..40 {
                run.step();
                exact = matrix * exact;
                size = exact.norm().max(size);
                let State { x, v, .. } = &run.state;
                let found = Vector4::new(x[0].x, x[1].x, H * v[0].x, H * v[1].x);
                let off = (found - exact).norm() / size;
                assert!(off < 1e-12, "{sweeps} sweeps, s={s} d={d}, step {step}: {off:e}");
            }
        }
    }
}

/// Two particles of 1 kg in a steady rotation of 2 rad/s for 1 s, on a spring of rest length 1:
/// angular momentum and energy over those at the start, and the angle.
fn rotation(text: &str, theta: f64) -> [f64; 3] {
    let h = 0.01;
    let kappa = theta / (h * h);
    let length = kappa / (kappa - 4.0);
    let x = [Vec3::x() * (0.5 * length), Vec3::x() * (-0.5 * length)];
    let v = x.map(|x| Vec3::z().cross(&x) * 2.0);
    let mut spec = particles(&[1.0; 2], &x, &v);
    spec.springs = vec![tension((0, 1), 1.0, 0.5 * kappa, 0.0)];
    let mut run = prepared(text, build(&spec), h);
    let spin = |state: &State| (state.x[0] - state.x[1]).cross(&(state.v[0] - state.v[1])).z;
    let (first, energy, mut angle) = (spin(&run.state), run.energy(), 0.0);
    for _ in 0..100 {
        let before = run.state.x[0] - run.state.x[1];
        run.step();
        let after = run.state.x[0] - run.state.x[1];
        angle += before.cross(&after).z.atan2(before.dot(&after));
    }
    [spin(&run.state) / first, angle, run.energy() / energy]
}

#[test]
fn where_the_sweeps_converge_two_particles_spin_as_with_backward_euler() {
    for (theta, expected) in
        [(1.0, [0.962_422_682_8, 1.961_709_49]), (100.0, [0.962_425_268_4, 1.961_647_10])]
    {
        let [spin, angle, energy] = rotation("sweeps=1000", theta);
        assert!((spin - expected[0]).abs() < 1e-9, "θ={theta}: {spin:.10}");
        assert!((angle - expected[1]).abs() < 1e-7, "θ={theta}: {angle:.8}");
        assert!(theta < 100.0 || (energy - 0.926_348_48).abs() < 1e-7, "{energy:.8}");
    }
}

/// Fall of an unpinned stiff sheet along its own plane in twenty steps over that of backward Euler.
fn fall(text: &str) -> f64 {
    let (steps, gravity) = (20, Vec3::x() * -9.81);
    let stiff = Sheet { tension: 1e6, shear: 1e5, damping: 4.0, ..Sheet::default() };
    let sheet = Sheet { side: 9, pinned: false, gravity, ..stiff };
    let (system, state) = sheet.build();
    let start = state.x.clone();
    let mut run = prepared(text, (system, state), H);
    run.steps(20);
    let (x, _) = free_fall(Drift::NewVelocity, Vec3::zeros(), Vec3::zeros(), gravity, H, steps);
    let fallen = run.state.x.iter().zip(&start).map(|(x, start)| (x - start).x);
    fallen.sum::<f64>() / start.len() as f64 / x.x
}

/// From the last positions the weight must be carried from particle to particle by the sweeps.
#[test]
fn a_free_sheet_falls_exactly_from_two_starts_and_stands_in_the_air_from_the_third() {
    for text in ["", "start=inertial", "sweeps=1", "sweeps=3,augmented=true"] {
        let share = fall(text);
        assert!((share - 1.0).abs() < 1e-11, "{text}: {share}");
    }
    let [few, many] = ["start=previous", "start=previous,sweeps=300"].map(fall);
    assert!(few < 0.5 && many > few, "{few} of the fall, {many} with 300 sweeps");
}

/// An effect with a Jacobian that nobody can ask for the force on one particle.
#[derive(Clone, Debug)]
struct Opaque;

impl Effect for Opaque {
    fn kind(&self) -> EffectKind {
        EffectKind::Own("opaque")
    }

    fn energy(&self, _mass: &[f64], _x: &[Vec3]) -> f64 {
        0.0
    }

    fn add_force(&self, _mass: &[f64], _x: &[Vec3], _out: &mut [Vec3]) {}

    fn has_jacobian(&self) -> bool {
        true
    }

    fn boxed_clone(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}

#[test]
fn an_effect_whose_force_cannot_be_asked_for_particle_by_particle_is_refused_by_name() {
    let (mut system, _): (System, State) = Sheet::default().build();
    let mut method = Vbd::new(settings(""));
    method.prepare(&system, seconds(H)).expect("springs and gravity");
    system.add_effect(Box::new(Opaque));
    let error = method.prepare(&system, seconds(H)).expect_err("opaque");
    assert!(
        matches!(&error, PrepareError::Unsupported { method, what, .. }
            if *method == VBD.id && what == "opaque"),
        "{error}"
    );
}
