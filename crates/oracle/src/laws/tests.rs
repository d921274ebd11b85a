//! Each law against the few lines of its step.

use super::*;
use crate::Random;

/// Two free particles of mass `m` on a spring, with full or projected damping, and a step size.
struct Pair {
    mass: f64,
    stiffness: f64,
    damping: f64,
    rest: f64,
    h: f64,
}

type Two = [Vec3; 2];

/// `a + s b` for both particles.
fn add(a: Two, s: f64, b: Two) -> Two {
    [a[0] + b[0] * s, a[1] + b[1] * s]
}

/// Angular momentum about the centre over `½ m`.
fn spin_of(x: Two, v: Two) -> Vec3 {
    (x[1] - x[0]).cross(&(v[1] - v[0]))
}

fn length(x: Two) -> f64 {
    (x[1] - x[0]).norm()
}

impl Pair {
    /// From the parameters of the relative motion.
    fn new(theta: f64, eta: f64) -> Self {
        let (mass, h) = (0.25, 1.0 / 64.0);
        let (stiffness, damping) = (0.5 * theta * mass / (h * h), 0.5 * eta * mass / h);
        Self { mass, stiffness, damping, rest: 0.5, h }
    }

    /// Force of the spring over mass.
    fn spring(&self, x: Two) -> Two {
        let d = x[1] - x[0];
        let pull = d * (self.stiffness * (1.0 - self.rest / d.norm()) / self.mass);
        [pull, -pull]
    }

    /// Full damping over mass.
    fn full(&self, v: Two) -> Two {
        let pull = (v[1] - v[0]) * (self.damping / self.mass);
        [pull, -pull]
    }

    /// Damping along `x_2 − x_1` over mass.
    fn projected(&self, x: Two, v: Two) -> Two {
        let d = (x[1] - x[0]).normalize();
        let pull = d * (d.dot(&(v[1] - v[0])) * self.damping / self.mass);
        [pull, -pull]
    }

    /// `(1 + a) z_i − a z_j = b_i`, solved: `a` is `h²k/m`, `hc/m` or their sum.
    fn solve(a: f64, b: Two) -> Two {
        let determinant = 1.0 + 2.0 * a;
        [0, 1].map(|i| (b[i] * (1.0 + a) + b[1 - i] * a) / determinant)
    }

    fn s(&self) -> f64 {
        self.h * self.h * self.stiffness / self.mass
    }

    fn d(&self) -> f64 {
        self.h * self.damping / self.mass
    }

    /// `v` with `v = v_start + h a(v)` by repetition, which contracts for the small steps used
    /// here.
    fn fixed_point(&self, h: f64, start: Two, acceleration: impl Fn(Two) -> Two) -> Two {
        (0..400).fold(start, |v, _| add(start, h, acceleration(v)))
    }
}

/// Stretched and compressed pairs with any velocities; `low` and `high` bound the length over `ℓ`.
fn starts(seed: u64, low: f64, high: f64) -> impl Iterator<Item = (Two, Two)> {
    let mut random = Random::new(seed);
    (0..20).map(move |_| {
        let x = random.vector();
        let d = random.vector().normalize() * (0.5 * random.between(low, high));
        ([x, x + d], [random.vector() * 4.0, random.vector() * 4.0])
    })
}

const THETAS: [f64; 5] = [0.01, 0.3, 1.0, 100.0, 1e4];
const ETAS: [f64; 3] = [0.0, 0.125, 3.0];

/// Checks `factor(ℓ/L_n)` against a step from `(x, v)` that needs no iteration.
fn assert_law(
    name: &str,
    step: impl Fn(&Pair, Two, Two) -> (Two, Two),
    factor: impl Fn(f64, f64, f64) -> f64,
) {
    for theta in THETAS {
        for eta in ETAS {
            let pair = Pair::new(theta, eta);
            for (x, v) in starts(21, 0.1, 3.0) {
                let (new_x, new_v) = step(&pair, x, v);
                let expected = spin_of(x, v) * factor(theta, eta, pair.rest / length(x));
                let speed = (v[1] - v[0]).norm() + (new_v[1] - new_v[0]).norm();
                let scale = (1.0 + eta) * (length(x) + length(new_x)) * (speed + theta / pair.h);
                let error = (spin_of(new_x, new_v) - expected).norm() / scale;
                assert!(error < 1e-14, "{name}, θ={theta} η={eta}: {error:e}");
            }
        }
    }
}

/// `x + hv'` with a velocity that is given.
fn drift(pair: &Pair, x: Two, v: Two) -> (Two, Two) {
    (add(x, pair.h, v), v)
}

#[test]
fn explicit_and_symplectic_steps_obey_their_laws_of_spin() {
    let kick = |p: &Pair, x, v| add(add(v, p.h, p.spring(x)), p.h, p.full(v));
    assert_law("explicit Euler", |p, x, v| (add(x, p.h, v), kick(p, x, v)), spin::explicit_euler);
    assert_law(
        "symplectic Euler",
        |p, x, v| drift(p, x, kick(p, x, v)),
        |_, eta, _| spin::symplectic_euler(eta),
    );
    assert_law(
        "symplectic Euler, implicit damping",
        |p, x, v| drift(p, x, Pair::solve(p.d(), add(v, p.h, p.spring(x)))),
        |_, eta, _| spin::symplectic_euler_implicit_damping(eta),
    );
    assert_law(
        "leapfrog",
        |p, x, v| {
            let half = 0.5 * p.h;
            let v = add(add(v, half, p.spring(x)), half, p.full(v));
            let x = add(x, p.h, v);
            (x, Pair::solve(0.5 * p.d(), add(v, half, p.spring(x))))
        },
        |_, eta, _| spin::leapfrog(eta),
    );
}

#[test]
fn steps_with_one_linear_system_obey_their_laws_of_spin() {
    assert_law(
        "IMEX Euler",
        |p, x, v| {
            // Total force at x_n, h² L_k v and h L_c v implicit.
            drift(p, x, Pair::solve(p.s() + p.d(), add(v, p.h, p.spring(x))))
        },
        |theta, eta, _| spin::imex_euler(theta, eta),
    );
    let filtered = |p: &Pair, x: Two, v: Two, damping: Two| {
        let viscosity = add([Vec3::zeros(); 2], p.s() / p.h, [v[1] - v[0], v[0] - v[1]]);
        add(add(p.spring(x), 1.0, viscosity), 1.0, damping)
    };
    assert_law(
        "Desbrun",
        |p, x, v| {
            let change = Pair::solve(p.s() + p.d(), filtered(p, x, v, p.full(v)));
            drift(p, x, add(v, p.h, change))
        },
        |theta, eta, _| spin::imex_euler(theta, eta),
    );
    assert_law(
        "Desbrun, projected damping",
        |p, x, v| {
            let change = Pair::solve(p.s() + p.d(), filtered(p, x, v, p.projected(x, v)));
            drift(p, x, add(v, p.h, change))
        },
        |theta, eta, _| spin::imex_euler_projected_damping(theta, eta),
    );
    for sweeps in 0..5 {
        let sweep = |p: &Pair, x: Two, v: Two, damping: Two| {
            let (force, a) = (filtered(p, x, v, damping), p.s() + p.d());
            let alone = force.map(|f| f * (p.h / (1.0 + a)));
            let correct = |last: Two, _| add(alone, a / (1.0 + a), [last[1], last[0]]);
            drift(p, x, add(v, 1.0, (0..sweeps).fold(alone, correct)))
        };
        assert_law(
            "Kang",
            |p, x, v| sweep(p, x, v, p.full(v)),
            |theta, eta, _| spin::kang(theta, eta, sweeps),
        );
        assert_law(
            "Kang, projected damping",
            |p, x, v| sweep(p, x, v, p.projected(x, v)),
            |theta, eta, _| spin::kang_projected_damping(theta, eta, sweeps),
        );
    }
}

/// As [`assert_law`], for a step whose transverse stiffness follows the length. Its law divides by
/// `1 + θ (1 − ℓ/L)` plus some damping, which vanishes for some compressed springs. Cases near
/// these are left out.
fn assert_law_of_tangent(
    name: &str,
    step: impl Fn(&Pair, Two, Two) -> (Two, Two),
    factor: impl Fn(f64, f64, f64) -> f64,
) {
    let mut checked = 0;
    for (theta, eta) in THETAS.into_iter().flat_map(|theta| ETAS.map(|eta| (theta, eta))) {
        let pair = Pair::new(theta, eta);
        for (x, v) in starts(22, 0.1, 3.0) {
            let law = factor(theta, eta, pair.rest / length(x));
            if law.abs() > 10.0 {
                continue;
            }
            let (new_x, new_v) = step(&pair, x, v);
            let error = (spin_of(new_x, new_v) - spin_of(x, v) * law).norm();
            let speed = (v[1] - v[0]).norm() + (new_v[1] - new_v[0]).norm();
            let scale = (1.0 + eta) * (length(x) + length(new_x)) * (speed + theta / pair.h);
            assert!(error < 1e-13 * scale, "{name}, θ={theta} η={eta}: {error:e}");
            checked += 1;
        }
    }
    assert!(checked > 280, "{name}: {checked}");
}

#[test]
fn terzopoulos_fleischer_obeys_its_law_of_spin() {
    let secant = |p: &Pair, x: Two| p.s() * (1.0 - p.rest / length(x)) + 0.5 * p.d();
    assert_law_of_tangent(
        "full damping",
        |p, x, v| {
            // (M + h²K + ½hL_c) v' = (M − ½hL_c) v − hKx
            let right = add(add(v, p.h, p.spring(x)), 0.5 * p.h, p.full(v));
            drift(p, x, Pair::solve(secant(p, x), right))
        },
        spin::terzopoulos_fleischer,
    );
    assert_law_of_tangent(
        "projected damping",
        |p, x, v| {
            // The same with −hD v + ½hL_c v on the right.
            let right = add(add(v, p.h, p.spring(x)), p.h, p.projected(x, v));
            drift(p, x, Pair::solve(secant(p, x), add(right, -0.5 * p.h, p.full(v))))
        },
        spin::terzopoulos_fleischer_projected_damping,
    );
}

/// On the relative motion: `(1 + η + h²H) Δw = −h²F − (h²H + η) w` with the Hessian `H` at the old
/// state, as it is or with its negative part cut off.
#[test]
fn baraff_witkin_obeys_the_law_of_backward_euler_at_the_old_length() {
    use drape_model::Mat3;
    for clamp in [false, true] {
        let seen = |ratio: f64| if clamp { ratio.min(1.0) } else { ratio };
        assert_law_of_tangent(
            "Baraff-Witkin",
            |p, x, v| {
                let (d, w) = (x[1] - x[0], (v[1] - v[0]) * p.h);
                let along = d.normalize() * d.normalize().transpose();
                let transverse = 1.0 - seen(p.rest / d.norm());
                let hessian = along + (Mat3::identity() - along) * transverse;
                let stiffness = hessian * (2.0 * p.s()) + Mat3::identity() * (2.0 * p.d());
                let force = -d * (2.0 * p.s() * (1.0 - p.rest / d.norm()));
                let inverse = (Mat3::identity() + stiffness).try_inverse().expect("definite");
                let new_w = w + inverse * (force - stiffness * w);
                ([Vec3::zeros(), d + new_w], [Vec3::zeros(), new_w / p.h])
            },
            |theta, eta, ratio| spin::backward_euler(theta, eta, seen(ratio)),
        );
    }
}

#[test]
fn implicit_steps_obey_their_laws_of_spin() {
    for (theta, eta) in [(0.01, 0.0), (0.3, 0.0), (0.3, 0.125), (0.2, 0.3), (0.0, 0.5)] {
        let pair = Pair::new(theta, eta);
        let h = pair.h;
        for (x, v) in starts(23, 0.7, 1.6) {
            let case = format!("θ={theta} η={eta}");
            let law = |x: Two, v: Two, factor: f64, found: (Two, Two)| {
                let error = (spin_of(found.0, found.1) - spin_of(x, v) * factor).norm();
                assert!(error < 1e-13 * (1.0 + length(x)) * 8.0, "{case}: {error:e}");
            };
            let forces = |x: Two, v: Two| add(pair.spring(x), 1.0, pair.full(v));

            let new = pair.fixed_point(h, v, |v| forces(add(x, h, v), v));
            let (new_x, new) = drift(&pair, x, new);
            let backward = spin::backward_euler(theta, eta, pair.rest / length(new_x));
            law(x, v, backward, (new_x, new));

            let end = |start: Two, middle: Two| add(add(middle, 1.0, middle), -1.0, start);
            let middle_v = pair.fixed_point(0.5 * h, v, |v| forces(add(x, 0.5 * h, v), v));
            let middle_x = add(x, 0.5 * h, middle_v);
            let factor = spin::implicit_midpoint(theta, eta, pair.rest / length(middle_x));
            law(x, v, factor, (end(x, middle_x), end(v, middle_v)));

            let first = add(v, 0.5 * h, forces(x, v));
            let moved = |new: Two| add(x, 0.5 * h, add(v, 1.0, new));
            let last_v = pair.fixed_point(0.5 * h, first, |new| forces(moved(new), new));
            let last_x = moved(last_v);
            let ratios = [x, last_x].map(|x| pair.rest / length(x));
            let factor = spin::trapezoid(theta, eta, ratios[0], ratios[1]);
            law(x, v, factor, (last_x, last_v));

            let along = |x: Two, v: Two| add(pair.spring(x), 1.0, pair.projected(x, v));
            let middle_v = pair.fixed_point(0.5 * h, v, |v| along(add(x, 0.5 * h, v), v));
            let middle_x = add(x, 0.5 * h, middle_v);
            law(x, v, 1.0, (end(x, middle_x), end(v, middle_v)));

            // BDF2 from (x, v) and the step of backward Euler: backward Euler with 2h/3 from X*,
            // V*.
            let combine = |new: Two, old: Two| {
                add([Vec3::zeros(); 2], 1.0 / 3.0, add(add(new, 3.0, new), -1.0, old))
            };
            let (start_x, start_v) = (combine(new_x, x), combine(new, v));
            let tau = 2.0 / 3.0 * h;
            let last_v = pair.fixed_point(tau, start_v, |v| forces(add(start_x, tau, v), v));
            let last_x = add(start_x, tau, last_v);
            let after = pair.rest / length(last_x);
            let factor = spin::backward_euler(4.0 / 9.0 * theta, 2.0 / 3.0 * eta, after);
            law(start_x, start_v, factor, (last_x, last_v));
        }
    }
}

#[test]
fn the_laws_of_spin_tell_the_methods_apart() {
    let (theta, eta, ratio) = (1.3, 0.25, 0.4);
    let factors = [
        spin::explicit_euler(theta, eta, ratio),
        spin::symplectic_euler(eta),
        spin::symplectic_euler_implicit_damping(eta),
        spin::leapfrog(eta),
        spin::backward_euler(theta, eta, ratio),
        spin::implicit_midpoint(theta, eta, ratio),
        spin::trapezoid(theta, eta, ratio, 0.9),
        spin::imex_euler(theta, eta),
        spin::imex_euler_projected_damping(theta, eta),
        spin::terzopoulos_fleischer(theta, eta, ratio),
        spin::kang(theta, eta, 0),
        spin::kang(theta, eta, 1),
        spin::kang(theta, eta, 2),
    ];
    for (i, a) in factors.iter().enumerate() {
        assert!(factors[..i].iter().all(|b| (a - b).abs() > 0.001), "{factors:?}");
    }
    let a = 0.5 * (theta + eta);
    assert!((spin::kang(theta, eta, 1) - (1.0 + a * a) / ((1.0 + a) * (1.0 + a))).abs() < 1e-15);
    assert!((spin::kang(theta, eta, 0) - (1.0 - a) / (1.0 + a)).abs() < 1e-15);
    assert!((spin::kang(theta, eta, 100) - spin::imex_euler(theta, eta)).abs() < 1e-15);
}

const H: f64 = 0.25;

fn gravity() -> Vec3 {
    Vec3::new(0.0, 1.0, -9.81)
}

fn start() -> (Vec3, Vec3) {
    (Vec3::new(1.0, 2.0, 3.0), Vec3::new(-1.0, 0.5, 4.0))
}

fn assert_level(found: (Vec3, Vec3), expected: (Vec3, Vec3), case: &str) {
    let error = (found.0 - expected.0).norm() + (found.1 - expected.1).norm();
    assert!(error < 1e-12, "{case}: {error:e}");
}

#[test]
fn the_parabola_is_what_repeated_steps_give() {
    let (g, (x0, v0)) = (gravity(), start());
    for drift in [Drift::OldVelocity, Drift::NewVelocity, Drift::MeanVelocity] {
        let (mut x, mut v) = (x0, v0);
        for steps in 1..10 {
            let old = v;
            v += g * H;
            x += match drift {
                Drift::OldVelocity => old,
                Drift::NewVelocity => v,
                _ => (old + v) * 0.5,
            } * H;
            let case = format!("{drift:?}, step {steps}");
            assert_level((x, v), free_fall(drift, x0, v0, g, H, steps), &case);
        }
    }
}

/// After a first step of backward Euler (order 2), or exact first steps.
#[test]
fn multistep_methods_fall_on_the_parabolas_of_their_start() {
    let (g, (x0, v0)) = (gravity(), start());
    let fall = |drift, steps| free_fall(drift, x0, v0, g, H, steps);
    let methods = [
        (Multistep::adams_bashforth(&[1.0]), None),
        (Multistep::adams_bashforth(&[1.0; 2]), None),
        (Multistep::bdf(&[1.0; 2]), None),
        (Multistep::sbdf2(1.0), Some(Drift::Bdf2AfterBackwardEuler)),
        (Multistep::cnab2(1.0), Some(Drift::MeanAfterBackwardEuler)),
        (Multistep::mcnab2(1.0), Some(Drift::MeanAfterBackwardEuler)),
        (Multistep::cnlf(), Some(Drift::CnlfAfterBackwardEuler)),
    ];
    for (method, after_backward_euler) in methods {
        for more in 0..30 {
            let case = format!("{method:?}, {more} steps more");
            let exact = Drift::MeanVelocity;
            let history = [2, 1, 0].map(|n| fall(exact, n));
            let found = constant_acceleration(&method, &history, g, H, more);
            assert_level(found, fall(exact, 2 + more), &case);
            if let Some(drift) = after_backward_euler {
                let history = [fall(Drift::NewVelocity, 1), fall(Drift::NewVelocity, 0)];
                let found = constant_acceleration(&method, &history, g, H, more);
                assert_level(found, fall(drift, 1 + more), &case);
            }
        }
    }
}

/// Uneven steps, one at a time, stay on the exact parabola.
#[test]
fn uneven_steps_fall_on_the_exact_parabola() {
    let (g, (x0, v0)) = (gravity(), start());
    let level = |t: f64| (x0 + v0 * t + g * (0.5 * t * t), v0 + g * t);
    let (sizes, times) = ([0.5, 0.75, 0.25], [0.0, 0.5, 1.25, 1.5]);
    let history = [2, 1, 0].map(|i| level(times[i]));
    let h = sizes[2];
    let earlier = [sizes[1] / h, sizes[0] / h];
    for method in [
        Multistep::adams_bashforth(&earlier[..1]),
        Multistep::adams_bashforth(&earlier),
        Multistep::bdf(&earlier),
        Multistep::sbdf2(1.0 / earlier[0]),
        Multistep::cnab2(1.0 / earlier[0]),
        Multistep::mcnab2(1.0 / earlier[0]),
    ] {
        let found = constant_acceleration(&method, &history, g, h, 1);
        assert_level(found, level(times[3]), &format!("{method:?}"));
    }
}
