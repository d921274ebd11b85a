//! On the oscillator `x'' = −κx − δx'` every step is the method's own recurrence, start-up included.

use super::{Family, Run, STEPS, adams, bdf, build, particles, pin, spring};
use crate::Steps;
use drape_model::{State, System, Vec3};
use drape_oracle::recurrence::{self, Recurrence, explicit_euler};
use nalgebra::{Matrix2, Vector2};

const STEPS_TAKEN: usize = 100;
/// A power of two, so that `θ = h²k/m` and `η = hc/m` are met exactly.
const H: f64 = 1.0 / 64.0;
const MASS: f64 = 0.25;
const PARAMETERS: [(f64, f64); 4] = [(0.36, 0.06), (100.0, 0.4), (100.0, 0.0), (1.0, 0.0)];

/// The recurrence of each step, given how many levels are known.
type Law = fn(Steps, usize, f64, f64) -> Recurrence;

/// `h` times the matrix of the differential equation of `(x, hv)`.
fn slope(theta: f64, eta: f64) -> Matrix2<f64> {
    Matrix2::new(0.0, 1.0, -theta, -eta)
}

fn adams_law(steps: Steps, known: usize, theta: f64, eta: f64) -> Recurrence {
    match known.min(steps.count()) {
        1 if steps == Steps::One => explicit_euler(theta, eta).into(),
        1 => {
            let j = slope(theta, eta);
            (Matrix2::identity() + j + j * j * 0.5).into() // Heun
        }
        k => recurrence::adams_bashforth(k, theta, eta),
    }
}

fn bdf_law(steps: Steps, known: usize, theta: f64, eta: f64) -> Recurrence {
    match known.min(steps.count()) {
        1 if steps == Steps::Three => {
            let (one, j, gamma) = (Matrix2::identity(), slope(theta, eta), 1.0 - 0.5_f64.sqrt());
            let inverse = (one - j * gamma).try_inverse().expect("regular");
            (inverse * inverse * (one + j * (1.0 - 2.0 * gamma))).into() // Alexander
        }
        1 => recurrence::backward_euler(theta, eta).into(),
        k => recurrence::bdf(k, theta, eta),
    }
}

const FAMILIES: [(Family, Law, f64); 2] = [(adams, adams_law, 1e-12), (bdf, bdf_law, 1e-9)];

/// One particle on a spring whose other end is pinned at the origin.
fn anchored(rest: f64, (theta, eta): (f64, f64), x: Vec3, v: Vec3) -> (System, State) {
    let mut spec = particles(&[MASS; 2], &[Vec3::zeros(), x], &[Vec3::zeros(), v]);
    spec.pins = vec![pin(0)];
    spec.springs = vec![spring((0, 1), rest, theta * MASS / (H * H), eta * MASS / H)];
    build(&spec)
}

/// The worst deviation of `coordinate` from the law, relative to the solution or, where that is larger, to `floor`,
/// over as many steps as the exact `x` stays below `range`.
fn worst_deviation(
    run: &mut Run,
    law: impl Fn(usize) -> Recurrence,
    floor: f64,
    range: f64,
    coordinate: impl Fn(&State) -> (f64, f64),
) -> (usize, f64) {
    let pair = |state: &State| {
        let (x, v) = coordinate(state);
        Vector2::new(x, H * v)
    };
    let mut levels = vec![pair(&run.state)];
    let mut worst: f64 = 0.0;
    for step in 0..STEPS_TAKEN {
        levels.insert(0, law(levels.len()).next(&levels));
        if levels[0].x.abs() > range {
            return (step, worst);
        }
        run.step();
        let deviation = (pair(&run.state) - levels[0]).norm();
        worst = worst.max(deviation / levels[0].norm().max(floor));
    }
    (STEPS_TAKEN, worst)
}

#[test]
fn an_anchored_spring_of_rest_length_zero_moves_by_the_recurrence() {
    let (x, v) = (Vec3::new(1.0, -0.5, 0.75), Vec3::new(0.0, 40.0, 7.0));
    for (family, law, tolerance) in FAMILIES {
        for (steps, (theta, eta)) in STEPS.iter().flat_map(|s| PARAMETERS.map(|p| (*s, p))) {
            for axis in 0..3 {
                let mut run = Run::new(family(steps), anchored(0.0, (theta, eta), x, v), H);
                let law = |known| law(steps, known, theta, eta);
                let at = |state: &State| (state.x[1][axis], state.v[1][axis]);
                let (_, worst) = worst_deviation(&mut run, law, 0.0, f64::INFINITY, at);
                let case = format!("{}, {steps:?}", run.integrator.method().id);
                assert!(worst < tolerance, "{case}, θ={theta} η={eta}, axis {axis}: {worst:e}");
            }
        }
    }
}

#[test]
fn motion_along_a_spring_with_a_rest_length_obeys_the_same_recurrence() {
    let (rest, amplitude) = (4.0, 1.0 / 256.0);
    let along = Vec3::new(0.0, 0.6, -0.8);
    for (family, law, tolerance) in FAMILIES {
        for (steps, (theta, eta)) in STEPS.iter().flat_map(|s| PARAMETERS.map(|p| (*s, p))) {
            let system = anchored(rest, (theta, eta), along * (rest + amplitude), Vec3::zeros());
            let mut run = Run::new(family(steps), system, H);
            let law = |known| law(steps, known, theta, eta);
            let at = |state: &State| (along.dot(&state.x[1]) - rest, along.dot(&state.v[1]));
            let (taken, worst) = worst_deviation(&mut run, law, rest, 0.5 * rest, at);
            let case = format!("{}, {steps:?}", run.integrator.method().id);
            assert!(taken > 0 && worst < tolerance, "{case}, θ={theta} η={eta}: {worst:e}");
        }
    }
}

/// In the long run `z_{n+2} = a z_{n+1} + b z_n` with the largest pair of roots; the motion of two coordinates
/// tells `a` and `b`.
#[test]
fn the_motion_grows_by_the_golden_spectral_radii() {
    let golden = [
        ((0.36, 0.06), 150, 1.022636719997, 0.960430687463),
        ((100.0, 0.4), 40, 14.986654277395, 0.299261781144),
        ((100.0, 0.0), 40, 15.000014689889, 0.300749568269),
        ((1.0, 0.0), 150, 1.522339130833, 0.933321058436),
    ];
    for ((theta, eta), run_in, adams_radius, bdf_radius) in golden {
        for (family, radius) in [(adams as Family, adams_radius), (bdf, bdf_radius)] {
            let system = anchored(0.0, (theta, eta), Vec3::x(), Vec3::y());
            let mut run = Run::new(family(Steps::Two), system, H);
            (0..run_in).for_each(|_| {
                run.step();
            });
            let levels = [(); 3].map(|()| {
                run.step();
                Vector2::new(run.state.x[1].x, run.state.x[1].y)
            });
            let matrix = Matrix2::from_columns(&[levels[1], levels[0]]);
            let fit = matrix.try_inverse().expect("two independent motions") * levels[2];
            let discriminant: f64 = 0.25 * fit.x * fit.x + fit.y;
            let found = match discriminant < 0.0 {
                true => (-fit.y).sqrt(),
                false => 0.5 * fit.x.abs() + discriminant.sqrt(),
            };
            let id = run.integrator.method().id;
            assert!((found / radius - 1.0).abs() < 1e-6, "{id}, ({theta}, {eta}): {found:.12}");
        }
    }
}
