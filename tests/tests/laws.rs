//! Spin of two particles, free fall, hanging chain: laws that hold at any amplitude.

use drape_model::{DampingLaw, State, System, Vec3};
use drape_oracle::laws::{Drift, free_fall, hanging_chain, spin};
use drape_tests::{
    GRAVITY, Random, Run, Sheet, apart, assert_covers, build, gravity, particles, pin, prepared,
    tension,
};
use nalgebra::{DMatrix, DVector};

const H: f64 = 1.0 / 64.0;

/// Where Newton's method ends.
const NEWTON: f64 = 1e-9;

/// `θ`, `η`, `ℓ/L` before and after the step.
type Factor = fn(f64, f64, f64, f64) -> f64;

/// How much of the springs' force is left to round off across the spring.
#[derive(Clone, Copy, Debug, PartialEq)]
enum RoundOff {
    /// The force itself, `θ (L + ℓ)/h` as a velocity. Nothing implicit divides it, or only an
    /// inverse whose own entries are rounded.
    Force,
    /// Eight times the force: an iteration stops where its residual falls no further.
    Residual,
    /// The force over `1 + θ`: the whole stiffness stands in the matrix.
    Filtered,
    /// The secant, which grows without limit as a spring collapses: `θ ℓ/L` times the force.
    Secant,
}

use RoundOff::{Filtered, Force, Residual, Secant};

struct Case {
    id: &'static str,
    law: DampingLaw,
    theta: &'static [f64],
    factor: Factor,
    round_off: RoundOff,
    /// Beside round-off, of the angular momentum before or after the step.
    tolerance: f64,
}

const fn case(
    id: &'static str,
    law: DampingLaw,
    theta: &'static [f64],
    round_off: RoundOff,
    factor: Factor,
) -> Case {
    Case { id, law, theta, factor, round_off, tolerance: 1e-12 }
}

impl Case {
    /// Not solved to round-off.
    const fn within(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }
}

/// Of one step: sixteen roundings of the largest term.
const ROUNDINGS: f64 = 16.0 * f64::EPSILON;
const SMALL: &[f64] = &[0.01, 0.3];
const ANY: &[f64] = &[0.01, 1.0, 100.0, 1e4, 1e8];
/// Where the law leaves less of the spin at `θ = 10⁸` than round-off does, there is nothing to
/// test.
const SHARP: &[f64] = &[0.01, 1.0, 100.0, 1e4];
const UPDATED: &[f64] = &[0.01, 1.0, 50.0];
const FULL: DampingLaw = DampingLaw::Full;
const PROJECTED: DampingLaw = DampingLaw::Projected;
const CHOLESKY: &str = "imex-euler:solver=cholesky";
const NEWTONS: &str = "backward-euler:residual=1e-16,max_iterations=10000,solver=cholesky";
const BDF1: &str = "bdf2:steps=1,residual=1e-16,max_iterations=10000,solver=cholesky";
const ALGORITHM_1: &str = "imex-updated:forcing_term=1e-16,max_outer=100000,newton_above=1e300";
const TRAPEZOID: &str = "generalized-alpha:family=newmark,rho_inf=1,residual=1e-16,solver=cholesky";
const PROJECTIVE: &str = "projective:acceleration=anderson,iterations=1000,residual=1e-16";
const ENERGY_MOMENTUM: &str = "energy-momentum:residual=1e-16,on_failure=report";
const IMPLICIT_DAMPING: &str = "symplectic-euler:damping=implicit";
const SWEEPS: &str = "vbd:sweeps=1000";
const EXPLICIT_DAMPING: &str = "leapfrog:damping=explicit";
const CLAMPED: &str = "terzopoulos-fleischer:clamp=true";

/// The factors of the spin, each with the damping that it holds for.
const SPINS: [Case; 42] = [
    case("explicit-euler", FULL, SMALL, Force, |theta, eta, before, _| {
        spin::explicit_euler(theta, eta, before)
    }),
    case("symplectic-euler", FULL, SMALL, Force, |_, eta, _, _| spin::symplectic_euler(eta)),
    case("symplectic-euler", PROJECTED, SMALL, Force, |_, _, _, _| spin::symplectic_euler(0.0)),
    case(IMPLICIT_DAMPING, FULL, SMALL, Force, |_, eta, _, _| {
        spin::symplectic_euler_implicit_damping(eta)
    }),
    case(IMPLICIT_DAMPING, PROJECTED, SMALL, Force, |_, _, _, _| spin::symplectic_euler(0.0)),
    case("provot:limit=10", FULL, SMALL, Force, |_, eta, _, _| spin::symplectic_euler(eta)),
    case("adams-bashforth2:steps=1", FULL, SMALL, Force, |theta, eta, before, _| {
        spin::explicit_euler(theta, eta, before)
    }),
    case("leapfrog:solver=cholesky", FULL, SMALL, Force, |_, eta, _, _| spin::leapfrog(eta)),
    case("leapfrog:solver=cg", FULL, SMALL, Force, |_, eta, _, _| spin::leapfrog(eta)),
    case("terzopoulos-fleischer", FULL, SMALL, Secant, |theta, eta, before, _| {
        spin::terzopoulos_fleischer(theta, eta, before)
    }),
    case(CLAMPED, FULL, ANY, Force, |theta, eta, before, _| {
        spin::terzopoulos_fleischer(theta, eta, before.min(1.0))
    }),
    case("baraff-witkin:solver=cholesky", FULL, ANY, Force, |theta, eta, before, _| {
        spin::baraff_witkin(theta, eta, before)
    }),
    case("baraff-witkin:forcing_term=1e-14", FULL, UPDATED, Force, |theta, eta, before, _| {
        spin::baraff_witkin(theta, eta, before)
    }),
    case("desbrun:torque=none", FULL, ANY, Filtered, |theta, eta, _, _| {
        spin::imex_euler(theta, eta)
    }),
    case("desbrun:torque=none,inverse=dense", FULL, SHARP, Force, |theta, eta, _, _| {
        spin::imex_euler(theta, eta)
    }),
    // What the filter took is given back; what the damping of the scene takes from `v_n` is not.
    case("desbrun", FULL, ANY, Filtered, |_, eta, _, _| 1.0 - eta),
    case("desbrun:inverse=dense", FULL, ANY, Force, |_, eta, _, _| 1.0 - eta),
    case("desbrun", PROJECTED, ANY, Filtered, |_, _, _, _| 1.0),
    case("kang", FULL, ANY, Filtered, |theta, eta, _, _| spin::kang(theta, eta, 1)),
    case("kang:sweeps=5", FULL, ANY, Filtered, |theta, eta, _, _| spin::kang(theta, eta, 5)),
    case("imex-euler:solver=cholesky,implicit=springs", FULL, ANY, Filtered, |theta, eta, _, _| {
        spin::imex_euler(theta, eta)
    }),
    case(BDF1, FULL, ANY, Residual, |theta, eta, _, after| spin::backward_euler(theta, eta, after))
        .within(NEWTON),
    case(NEWTONS, FULL, ANY, Residual, |theta, eta, _, after| {
        spin::backward_euler(theta, eta, after)
    })
    .within(NEWTON),
    case(NEWTONS, PROJECTED, ANY, Residual, |theta, _, _, after| {
        spin::backward_euler(theta, 0.0, after)
    })
    .within(NEWTON),
    case(CHOLESKY, FULL, ANY, Filtered, |theta, eta, _, _| spin::imex_euler(theta, eta)),
    case("imex-euler:forcing_term=1e-14", FULL, ANY, Filtered, |theta, eta, _, _| {
        spin::imex_euler(theta, eta)
    }),
    case(CHOLESKY, PROJECTED, ANY, Filtered, |theta, eta, _, _| {
        spin::imex_euler_projected_damping(theta, eta)
    }),
    case(ALGORITHM_1, FULL, UPDATED, Residual, |theta, eta, _, after| {
        spin::backward_euler(theta, eta, after)
    })
    .within(NEWTON),
    case(TRAPEZOID, FULL, SMALL, Residual, |theta, eta, before, after| {
        spin::trapezoid(theta, eta, before, after)
    })
    .within(NEWTON),
    case(SWEEPS, FULL, UPDATED, Residual, |theta, eta, _, after| {
        spin::backward_euler(theta, eta, after)
    })
    .within(NEWTON),
    case(SWEEPS, PROJECTED, UPDATED, Residual, |theta, _, _, after| {
        spin::backward_euler(theta, 0.0, after)
    })
    .within(NEWTON),
    case(EXPLICIT_DAMPING, FULL, SMALL, Force, |_, eta, _, _| spin::kicks(&[0.5, 0.5], eta, 2)),
    case(EXPLICIT_DAMPING, PROJECTED, SMALL, Force, |_, _, _, _| 1.0),
    case("srkn4", FULL, SMALL, Force, |_, eta, _, _| spin::kicks(&BLANES_MOAN, eta, 5)),
    case("srkn4", PROJECTED, SMALL, Force, |_, _, _, _| 1.0),
    // Three short steps of two half kicks each.
    case("multirate", FULL, SMALL, Force, |_, eta, _, _| spin::kicks(&[1.0 / 6.0; 6], eta, 2)),
    case("multirate", PROJECTED, SMALL, Force, |_, _, _, _| 1.0),
    case(PROJECTIVE, FULL, UPDATED, Residual, |theta, eta, _, after| {
        spin::backward_euler(theta, eta, after)
    })
    .within(NEWTON),
    case(PROJECTIVE, PROJECTED, UPDATED, Residual, |theta, _, _, after| {
        spin::backward_euler(theta, 0.0, after)
    })
    .within(NEWTON),
    case("xpbd:substeps=1", FULL, ANY, Force, |theta, eta, _, after| {
        spin::backward_euler(theta, eta, after)
    }),
    // The damping first: what it expects of the spring has no moment.
    case("xpbd-lines:substeps=1,order=1", FULL, ANY, Force, |theta, eta, _, after| {
        spin::backward_euler(theta, 0.0, after) / (1.0 + eta)
    }),
    // At `θ = 10` Newton's method misses the solution of some steps from a strongly squeezed spring.
    case(ENERGY_MOMENTUM, FULL, SMALL, Residual, |theta, eta, before, after| {
        spin::energy_momentum(theta, eta, before, after)
    })
    .within(NEWTON),
];

/// The kicks of the method of order 4.
const BLANES_MOAN: [f64; 7] = {
    let (b1, b2, b3) = (0.082_984_406_417_405_2, 0.396_309_801_498_368, -0.039_056_304_922_348_6);
    [b1, b2, b3, 1.0 - 2.0 * (b1 + b2 + b3), b3, b2, b1]
};

/// Those of several steps keep their spin to their order: see the tests of stiff and of fast pairs.
const WITHOUT_SPIN_LAW: [(&str, &str); 8] = [
    ("imex-sbdf2", TWO_STEPS),
    ("imex-cnab2", TWO_STEPS),
    ("imex-mcnab2", TWO_STEPS),
    ("imex-cnlf", TWO_STEPS),
    (
        "midpoint",
        "with damping its law asks for the length in the middle of the step; see its tests",
    ),
    ("dirk", "of several stages, each with a law; its own tests know its spin from 30 digits"),
    ("rkc", "its stages mix positions and velocities"),
    ("exponential", "the tangent stretches a spring that turns, by no factor in closed form"),
];
const TWO_STEPS: &str = "of two steps";

/// Their stages pull along directions of their own: see the tests of the methods.
const SEVERAL_STAGES: [(&str, &str); 2] =
    [("imex-rk", "of several stages"), ("rosenbrock", "of several stages")];

#[test]
fn every_method_has_its_laws() {
    let without = [&WITHOUT_SPIN_LAW[..], &SEVERAL_STAGES].concat();
    assert_covers("spin", SPINS.iter().map(|case| case.id), &without);
    assert_covers("free fall", FALLS.map(|(id, _, _)| id), &[]);
    let filtered = "its filter leaves gravity alone: see the test of an unfiltered weight";
    let exceptions = [("desbrun", filtered), ("kang", filtered)];
    assert_covers("hanging chain", CHAINS.map(|(id, _)| id), &exceptions);
}

/// The mass of each of two particles, kg, and the rest length of their spring, m.
const MASS: f64 = 0.25;
const REST: f64 = 0.5;

/// A step of two particles: what it did to their spin and momentum, and what round-off may.
struct SpinStep {
    /// `d × v` before and after, m²/s.
    spin: [Vec3; 2],
    /// `ℓ/L` before and after.
    ratio: [f64; 2],
    /// The largest term that adds up to the velocity, m/s, and what is left of it across the
    /// spring.
    terms: [f64; 2],
    /// The greater length, m.
    length: f64,
    /// `Σ m v` after, kg m/s.
    momentum: Vec3,
}

impl SpinStep {
    fn take(run: &mut Run, theta: f64, round_off: RoundOff) -> Self {
        let relative = |run: &Run| {
            let (x, v) = (&run.state.x, &run.state.v);
            (x[1] - x[0], v[1] - v[0])
        };
        let before = relative(run);
        run.step();
        let after = relative(run);
        let momentum = run.system.momentum(&run.state);
        let velocity = momentum.norm() / MASS + before.1.norm() + after.1.norm();
        let force = theta * (before.0.norm() + REST) / H;
        let collapse = 1.0 + theta * REST / before.0.norm().max(1e-12);
        let terms = match round_off {
            Force => [velocity + force; 2],
            Residual => [velocity + force, 8.0 * (velocity + force)],
            Filtered => [velocity + force, velocity + force / (1.0 + theta)],
            Secant => [(velocity + force) * collapse; 2],
        };
        Self {
            spin: [before, after].map(|(d, v)| d.cross(&v)),
            ratio: [before, after].map(|(d, _)| REST / d.norm()),
            terms,
            length: before.0.norm().max(after.0.norm()),
            momentum,
        }
    }
}

/// Two particles in random motion on a spring whose length over its rest length is between `least`
/// and `most`.
fn random_pair(
    random: &mut Random,
    law: DampingLaw,
    (theta, eta): (f64, f64),
    (least, most): (f64, f64),
) -> (System, State) {
    let (k, c) = (0.5 * theta * MASS / (H * H), 0.5 * eta * MASS / H);
    let d = random.vector().normalize() * (REST * random.between(least, most));
    let velocities = [random.vector() * 8.0, random.vector() * 8.0];
    let mut spec = particles(&[MASS; 2], &[Vec3::zeros(), d], &velocities);
    spec.damping = law;
    spec.springs = vec![tension((0, 1), REST, k, c)];
    build(&spec)
}

/// A factor that is wrong by this much does not pass.
const WRONG: f64 = 1e-3;

/// Stretched, compressed and fast: each step multiplies the angular momentum by the factor that the
/// method's formulas give, and leaves the momentum alone. With every method and `θ` there are steps
/// in which [`WRONG`] stands out from round-off.
#[test]
fn two_particles_spin_as_the_law_of_each_method_says() {
    let mut random = Random::new(3);
    for Case { id, law, theta, factor, round_off, tolerance } in &SPINS {
        for (&theta, eta) in theta.iter().flat_map(|theta| [(theta, 0.0), (theta, 0.125)]) {
            let mut sharp = false;
            for ratios in [(0.1, 1.0), (1.0, 3.0), (0.1, 1.0), (1.0, 3.0)] {
                let pair = random_pair(&mut random, *law, (theta, eta), ratios);
                let mut run = prepared(id, pair, H);
                let momentum = run.system.momentum(&run.state);
                let mut drift_bound = 0.0;
                for step in 0..200 {
                    let case = format!("{id}, {law:?}, θ={theta} η={eta}, step {step}");
                    let taken = SpinStep::take(&mut run, theta, *round_off);
                    let ([before, after], [along, across]) = (taken.spin, taken.terms);
                    let factor = factor(theta, eta, taken.ratio[0], taken.ratio[1]);
                    let bound = tolerance * before.norm().max(after.norm())
                        + ROUNDINGS * taken.length * across;
                    let wrong = (after - before * factor).norm();
                    assert!(wrong <= bound, "{case}: spin off by {wrong:e}, allowed {bound:e}");
                    sharp |= WRONG * factor.abs() * before.norm() > 2.0 * bound;
                    drift_bound += ROUNDINGS * MASS * along;
                    let drift = (taken.momentum - momentum).norm();
                    assert!(drift <= drift_bound, "{case}: momentum off by {drift:e}");
                }
            }
            assert!(sharp, "{id}, {law:?}, θ={theta} η={eta}: the bound tests nothing");
        }
    }
}

/// A factor of another method does not pass: the law of backward Euler is not that of IMEX Euler.
#[test]
fn the_laws_of_spin_tell_the_methods_apart() {
    let (theta, eta) = (1.0, 0.0);
    let factors = [
        spin::explicit_euler(theta, eta, 0.5),
        spin::symplectic_euler(eta),
        spin::backward_euler(theta, eta, 0.5),
        spin::imex_euler(theta, eta),
    ];
    for (i, a) in factors.iter().enumerate() {
        assert!(factors[..i].iter().all(|b| (a - b).abs() > 0.1), "{factors:?}");
    }
}

/// Stiffness over mass, 1/s². Explicit methods stay below their limits: round-off must not grow.
const SOFT: f64 = 100.0;
const STIFF: f64 = 1e6;

/// The parabola of each method.
const FALLS: [(&str, f64, Drift); 57] = [
    ("explicit-euler", SOFT, Drift::OldVelocity),
    ("symplectic-euler", SOFT, Drift::NewVelocity),
    ("symplectic-euler:damping=implicit", SOFT, Drift::NewVelocity),
    ("provot", SOFT, Drift::NewVelocity),
    ("leapfrog", SOFT, Drift::MeanVelocity),
    ("leapfrog:step=auto", STIFF, Drift::MeanVelocity),
    ("adams-bashforth2:steps=1", SOFT, Drift::OldVelocity),
    ("adams-bashforth2", SOFT, Drift::MeanVelocity),
    ("adams-bashforth2:steps=3", SOFT, Drift::MeanVelocity),
    ("bdf2:steps=1", STIFF, Drift::NewVelocity),
    ("bdf2", STIFF, Drift::Bdf2AfterBackwardEuler),
    ("bdf2:steps=3", SOFT, Drift::MeanVelocity),
    // At rest lengths its springs have no stiffness: round-off grows where they are stiff.
    ("terzopoulos-fleischer", SOFT, Drift::NewVelocity),
    ("baraff-witkin:forcing_term=1e-14", STIFF, Drift::NewVelocity),
    ("baraff-witkin:solver=cholesky", STIFF, Drift::NewVelocity),
    ("desbrun", STIFF, Drift::NewVelocity),
    ("desbrun:inverse=dense,torque=none", STIFF, Drift::NewVelocity),
    // Were gravity swept with the springs, the stiff sheet would stand still.
    ("kang", STIFF, Drift::NewVelocity),
    ("kang:sweeps=4", STIFF, Drift::NewVelocity),
    ("imex-sbdf2:forcing_term=1e-14", STIFF, Drift::Bdf2AfterBackwardEuler),
    ("imex-cnab2:forcing_term=1e-14", STIFF, Drift::MeanAfterBackwardEuler),
    ("imex-mcnab2:solver=cholesky", STIFF, Drift::MeanAfterBackwardEuler),
    ("imex-sbdf2:solver=cholesky", STIFF, Drift::Bdf2AfterBackwardEuler),
    ("imex-cnab2:solver=cholesky", STIFF, Drift::MeanAfterBackwardEuler),
    ("imex-mcnab2:forcing_term=1e-14", STIFF, Drift::MeanAfterBackwardEuler),
    ("imex-cnlf:solver=cholesky", SOFT, Drift::CnlfAfterBackwardEuler),
    ("backward-euler", STIFF, Drift::NewVelocity),
    ("imex-euler:forcing_term=1e-14", STIFF, Drift::NewVelocity),
    ("imex-euler:solver=cholesky,implicit=springs", STIFF, Drift::NewVelocity),
    ("imex-updated:forcing_term=1e-12", STIFF, Drift::NewVelocity),
    ("imex-updated:safeguard=paper,forcing_term=1e-14", STIFF, Drift::NewVelocity),
    ("midpoint", STIFF, Drift::MeanVelocity),
    ("dirk", STIFF, Drift::MeanVelocity),
    ("dirk:tableau=sdirk4,solver=cholesky", STIFF, Drift::MeanVelocity),
    ("generalized-alpha", STIFF, Drift::MeanVelocity),
    ("vbd", STIFF, Drift::NewVelocity),
    ("vbd:start=inertial,sweeps=3", STIFF, Drift::NewVelocity),
    ("imex-rk", STIFF, Drift::MeanVelocity),
    ("imex-rk:tableau=ars443", STIFF, Drift::MeanVelocity),
    // What they add to the last stage carries the round-off of the explicit force.
    ("imex-rk:tableau=ark3", SOFT, Drift::MeanVelocity),
    ("imex-rk:tableau=ark4", SOFT, Drift::MeanVelocity),
    ("rosenbrock", STIFF, Drift::MeanVelocity),
    ("rosenbrock:tableau=rodas4", STIFF, Drift::MeanVelocity),
    ("leapfrog:damping=explicit", SOFT, Drift::MeanVelocity),
    ("rkc", SOFT, Drift::MeanVelocity),
    ("srkn4", SOFT, Drift::MeanVelocity),
    ("multirate", SOFT, Drift::MeanVelocity),
    ("projective", STIFF, Drift::NewVelocity),
    ("projective:acceleration=lbfgs", STIFF, Drift::NewVelocity),
    ("xpbd:substeps=1", STIFF, Drift::NewVelocity),
    ("xpbd", STIFF, Drift::Substeps(20)),
    ("xpbd:substeps=1,order=2", SOFT, Drift::Bdf2AfterBackwardEuler),
    ("xpbd-lines:substeps=1,order=1", STIFF, Drift::NewVelocity),
    ("xpbd-lines:substeps=20,order=1", STIFF, Drift::Substeps(20)),
    ("xpbd-lines:substeps=1", SOFT, Drift::Bdf2AfterBackwardEuler),
    ("exponential", STIFF, Drift::MeanVelocity),
    ("energy-momentum", STIFF, Drift::MeanVelocity),
];

/// An unpinned sheet falls by the method's own parabola and feels no spring.
#[test]
fn a_free_sheet_falls_on_the_discrete_parabola() {
    let velocity = Vec3::new(1.0, -2.0, 3.0);
    for (id, tension, drift) in FALLS {
        // Widths of 1/8 m: the lengths of the springs are met exactly.
        let shear = 0.1 * tension;
        let sheet =
            Sheet { side: 9, tension, shear, damping: 4.0, pinned: false, ..Sheet::default() };
        let (system, mut state) = sheet.build();
        state.v.fill(velocity);
        let start = state.clone();
        let mut run = prepared(id, (system, state), H);
        for steps in 1..=20 {
            run.step();
            let mut tension = vec![Vec3::zeros(); run.state.len()];
            for effect in run.system.effects().filter(|effect| effect.name() != "gravity") {
                effect.add_force(run.system.mass(), &run.state.x, &mut tension);
            }
            for i in 0..run.state.len() {
                let (x, v) = free_fall(drift, start.x[i], velocity, GRAVITY, H, steps);
                let errors = (run.state.x[i] - x).norm() + (run.state.v[i] - v).norm();
                assert!(errors < 1e-11, "{id}, step {steps}, particle {i}: {errors:e}");
                let force = tension[i].norm() / (run.system.mass()[i] * GRAVITY.norm());
                assert!(force < 1e-7, "{id}, step {steps}, particle {i}: {force:e} of its weight");
            }
        }
    }
}

const LINKS: usize = 8;
const CHAIN_DAMPING: f64 = 20.0;

/// A chain that hangs from particle 0, with different masses and springs.
struct Chain {
    masses: Vec<f64>,
    stiffness: Vec<f64>,
    rest: Vec<f64>,
}

impl Chain {
    fn new() -> Self {
        Self {
            masses: (0..LINKS).map(|j| 0.5 + 0.125 * j as f64).collect(),
            stiffness: (0..LINKS).map(|j| 1000.0 - 50.0 * j as f64).collect(),
            rest: (0..LINKS).map(|j| 0.25 + 0.03125 * (j % 3) as f64).collect(),
        }
    }

    /// Lengths of the springs after 64 s.
    fn lengths(&self, id: &str, h: f64) -> Vec<f64> {
        let mut positions = vec![Vec3::zeros()];
        for length in &self.rest {
            let last = positions[positions.len() - 1];
            positions.push(last - Vec3::z() * *length);
        }
        let masses: Vec<f64> = std::iter::once(1.0).chain(self.masses.iter().copied()).collect();
        let mut spec = particles(&masses, &positions, &[]);
        spec.pins = vec![pin(0)];
        spec.effects.gravity = gravity();
        let link = |j| {
            let (rest, k) = (self.rest[j], self.stiffness[j]);
            tension((j, j + 1), rest, k, CHAIN_DAMPING)
        };
        spec.springs = (0..LINKS).map(link).collect();
        let mut run = prepared(id, build(&spec), h);
        for _ in 0..(64.0 / h) as usize {
            run.step();
        }
        (0..LINKS).map(|j| (run.state.x[j + 1] - run.state.x[j]).norm()).collect()
    }

    /// `A = M + h² L_k + h L_c` of the particles that hang.
    fn matrix(&self, h: f64) -> DMatrix<f64> {
        let mut a = DMatrix::from_diagonal(&DVector::from_row_slice(&self.masses));
        for j in 0..LINKS {
            let weight = h * h * self.stiffness[j] + h * CHAIN_DAMPING;
            a[(j, j)] += weight;
            if j > 0 {
                a[(j - 1, j - 1)] += weight;
                a[(j, j - 1)] -= weight;
                a[(j - 1, j)] -= weight;
            }
        }
        a
    }
}

/// The step size with which each method goes to rest.
const CHAINS: [(&str, f64); 38] = [
    ("symplectic-euler", 1.0 / 512.0),
    ("symplectic-euler:damping=implicit", 1.0 / 512.0),
    ("explicit-euler", 1.0 / 4096.0),
    ("leapfrog", 1.0 / 256.0),
    ("leapfrog:step=auto", 1.0 / 32.0),
    ("provot:limit=10", 1.0 / 512.0),
    ("adams-bashforth2", 1.0 / 1024.0),
    ("adams-bashforth2:steps=1", 1.0 / 4096.0),
    ("adams-bashforth2:steps=3", 1.0 / 1024.0),
    ("terzopoulos-fleischer", 1.0 / 256.0),
    ("baraff-witkin:forcing_term=1e-9", 1.0 / 32.0),
    ("bdf2", 1.0 / 32.0),
    ("bdf2:steps=1", 1.0 / 32.0),
    ("bdf2:steps=3", 1.0 / 32.0),
    ("backward-euler", 1.0 / 32.0),
    ("imex-euler:solver=cholesky", 1.0 / 32.0),
    ("imex-euler:forcing_term=1e-9", 1.0 / 32.0),
    ("imex-updated:forcing_term=1e-9", 1.0 / 32.0),
    ("imex-sbdf2:forcing_term=1e-9", 1.0 / 32.0),
    ("imex-cnab2:forcing_term=1e-9", 1.0 / 32.0),
    ("imex-mcnab2:forcing_term=1e-9", 1.0 / 32.0),
    ("imex-cnlf:forcing_term=1e-9", 1.0 / 32.0),
    ("midpoint", 1.0 / 32.0),
    ("dirk", 1.0 / 32.0),
    ("generalized-alpha", 1.0 / 32.0),
    ("vbd", 1.0 / 32.0),
    ("imex-rk", 1.0 / 32.0),
    ("imex-rk:tableau=ark3", 1.0 / 32.0),
    ("rosenbrock", 1.0 / 32.0),
    ("leapfrog:damping=explicit", 1.0 / 256.0),
    ("rkc", 1.0 / 32.0),
    ("srkn4", 1.0 / 256.0),
    ("multirate", 1.0 / 256.0),
    ("projective:acceleration=lbfgs,iterations=1000,residual=1e-9", 1.0 / 32.0),
    // One sweep balances the weight at lengths that are off by some multiples of h²g.
    ("xpbd:substeps=4,iterations=40", 1.0 / 64.0),
    // The chain is one line.
    ("xpbd-lines:substeps=4", 1.0 / 64.0),
    ("exponential:krylov_tol=1e-8", 1.0 / 32.0),
    ("energy-momentum", 1.0 / 32.0),
];

/// A damped chain comes to rest with each spring stretched by the weight below it.
#[test]
fn a_hanging_chain_comes_to_rest_at_its_static_lengths() {
    let chain = Chain::new();
    let expected = hanging_chain(&chain.masses, &chain.stiffness, &chain.rest, GRAVITY.norm());
    for (id, h) in CHAINS {
        for (j, (length, expected)) in chain.lengths(id, h).iter().zip(&expected).enumerate() {
            assert!((length - expected).abs() < 1e-8, "{id}, spring {j}: {length}, not {expected}");
        }
    }
}

/// Desbrun and Kang do not reach the static lengths: what balances the weight is not the springs'
/// force but what their filter `W` makes of it, `h W F = −h g`. For the exact filter, `W = A⁻¹`,
/// this stretches the springs at the pin by `(h² + hc/k) g` too much, which vanishes with `h`; for
/// Kang's two sweeps, `W = 2 D⁻¹ − D⁻¹ A D⁻¹`, all of them, by much more.
#[test]
fn an_unfiltered_weight_stretches_the_chain_of_desbrun_and_kang_too_far() {
    let (chain, g, h) = (Chain::new(), GRAVITY.norm(), 1.0 / 32.0);
    let a = chain.matrix(h);
    let inverse_diagonal = DMatrix::from_diagonal(&a.diagonal().map(|d| 1.0 / d));
    let kang = &inverse_diagonal * 2.0 - &inverse_diagonal * &a * &inverse_diagonal;
    let exact = a.clone().try_inverse().expect("positive definite");
    let fall = DVector::from_element(LINKS, g);
    for (id, filter) in [("desbrun", &exact), ("desbrun:inverse=dense", &exact), ("kang", &kang)] {
        let force = filter.clone().lu().solve(&fall).expect("regular"); // of the springs, upward
        let lengths = chain.lengths(id, h);
        let below = |j: usize| force.rows(j, LINKS - j).sum();
        for j in 0..LINKS {
            let expected = chain.rest[j] + below(j) / chain.stiffness[j];
            assert!((lengths[j] - expected).abs() < 1e-8, "{id}, {j}: {} {expected}", lengths[j]);
        }
        let right = hanging_chain(&chain.masses, &chain.stiffness, &chain.rest, g);
        let excess = (h * h + h * CHAIN_DAMPING / chain.stiffness[0]) * g;
        let top = lengths[0] - right[0];
        if id == "kang" {
            assert!(top > 2.0 * excess && lengths[LINKS - 1] > 1.01 * right[LINKS - 1], "{top}");
        } else {
            assert!((top - excess).abs() < 1e-8, "{id}: {top}, not {excess}");
            assert!((lengths[1] - right[1]).abs() < 1e-8, "{id}: only at the pin");
        }
    }
}

/// With lagged secants the length 0 attracts: from a compressed spring of length `L` a step leads
/// to about `L²/(θℓ)`. A real spring, and every other method, pushes the particles apart again.
#[test]
fn a_strongly_compressed_spring_collapses_for_terzopoulos_and_fleischer_only() {
    let (mass, rest, theta) = (0.25, 0.5, 0.3);
    let k = 0.5 * theta * mass / (H * H);
    let length = |id: &str| {
        let mut spec = particles(&[mass; 2], &[Vec3::zeros(), Vec3::x() * (0.1 * rest)], &[]);
        spec.springs = vec![tension((0, 1), rest, k, 0.0)];
        let mut run = prepared(id, build(&spec), H);
        let longest = (0..100).map(|_| {
            run.step();
            (run.state.x[1] - run.state.x[0]).norm()
        });
        longest.fold(0.0, f64::max) / rest
    };
    let collapsed = length("terzopoulos-fleischer");
    assert!(collapsed < 0.2, "{collapsed}");
    for id in ["symplectic-euler", "backward-euler", "baraff-witkin", "imex-euler", "bdf2"] {
        assert!(length(id) > 0.9, "{id}: {}", length(id));
    }
}

/// Without pins a uniform gravity passes the filter unchanged: then Desbrun's predictor is IMEX
/// Euler.
#[test]
fn desbruns_predictor_is_imex_euler_where_gravity_is_filtered_alike() {
    let free = Sheet {
        side: 8,
        tension: 1e5,
        shear: 1e4,
        damping: 40.0,
        pinned: false,
        ..Sheet::default()
    };
    let start = || {
        let (system, mut state) = free.build();
        let mut random = Random::new(4);
        state.v.iter_mut().for_each(|v| *v = random.vector());
        (system, state)
    };
    for inverse in ["cholesky", "dense"] {
        let mut desbrun = prepared(&format!("desbrun:torque=none,inverse={inverse}"), start(), H);
        let mut imex = prepared("imex-euler:implicit=springs,solver=cholesky", start(), H);
        for step in 0..100 {
            desbrun.step();
            imex.step();
            let apart = apart(&desbrun.state.x, &imex.state.x);
            assert!(apart < 1e-10, "{inverse}, step {step}: {apart:e} m");
        }
    }
    // With pins it is not filtered, and the two part.
    let pinned = || Sheet { pinned: true, ..free }.build();
    let mut desbrun = prepared("desbrun:torque=none", pinned(), H);
    let mut imex = prepared("imex-euler:implicit=springs,solver=cholesky", pinned(), H);
    desbrun.steps(20);
    imex.steps(20);
    assert!(apart(&desbrun.state.x, &imex.state.x) > 0.01);
}

/// At rest the round-off of the positions alone keeps the residual above its tolerance. Newton's
/// method must see that and stop, not use up its iterations.
#[test]
fn newton_stops_where_round_off_ends_all_progress() {
    let (mass, rest) = (0.25, 0.5);
    let mut random = Random::new(9);
    for theta in [1e2, 1e4, 1e8] {
        for _ in 0..20 {
            let d = random.vector().normalize() * rest;
            let slow = [random.vector() * 1e-8, random.vector() * 1e-8];
            let mut spec = particles(&[mass; 2], &[Vec3::zeros(), d], &slow);
            let k = 0.5 * theta * mass / (H * H);
            spec.springs = vec![tension((0, 1), rest, k, 0.0)];
            let mut run =
                prepared("backward-euler:residual=1e-16,solver=cholesky", build(&spec), H);
            for step in 0..20 {
                let report = run.step();
                assert!(report.newton_iterations < 10, "θ={theta}, step {step}: {report:?}");
            }
        }
    }
}

/// Two free particles of half a unit of length to their centre that turn by `angle` a step;
/// `θ = 2h²k/m`.
fn turning(theta: f64, angle: f64) -> (System, State) {
    let half = Vec3::x() * 0.5;
    let v = Vec3::y() * (0.5 * angle / H);
    let mut spec = particles(&[MASS; 2], &[half, -half], &[v, -v]);
    spec.springs = vec![tension((0, 1), 1.0, 0.5 * theta * MASS / (H * H), 0.0)];
    build(&spec)
}

fn relative(state: &State) -> (Vec3, Vec3) {
    (state.x[0] - state.x[1], state.v[0] - state.v[1])
}

fn turn_of(state: &State) -> f64 {
    let (d, v) = relative(state);
    d.cross(&v).z
}

/// A two-step method starts by the law of backward Euler, which leaves a stiff pair its spin, and
/// goes on turning. A start by IMEX Euler would leave `1/(1 + θ)` of it.
#[test]
fn a_stiff_pair_keeps_its_spin_with_two_step_methods() {
    let two_steps = WITHOUT_SPIN_LAW.iter().filter(|(_, reason)| *reason == TWO_STEPS);
    for (id, theta) in two_steps.flat_map(|m| [1.0, 1e4, 1e6].map(|t| (m.0, t))) {
        let mut run = prepared(id, turning(theta, 1e-3), H);
        let before = turn_of(&run.state);
        run.step();
        let first = turn_of(&run.state);
        let law = spin::backward_euler(theta, 0.0, 1.0 / relative(&run.state).0.norm());
        assert!((first / before - law).abs() < 1e-9, "{id}, θ={theta}: {}", first / before);
        // What does not damp stiff motion rings.
        let rings = matches!(id, "imex-cnab2" | "imex-cnlf");
        let tolerance = if rings { 0.02 } else { 1e-3 };
        for step in 0..100 {
            run.step();
            let kept = turn_of(&run.state) / first;
            assert!((kept - 1.0).abs() < tolerance, "{id}, θ={theta}, step {step}: {kept}");
        }
        let turned = relative(&run.state).0;
        let angle = turned.y.atan2(turned.x);
        assert!((angle - 0.101).abs() < 1e-3, "{id}, θ={theta}: turned by {angle}");
    }
}

/// In a turn of φ a step the methods that damp stiff motion lose φ² (SBDF2) or φ²/2 (MCNAB2) of the
/// spin a step, whatever the stiffness.
#[test]
fn spin_is_lost_with_the_square_of_the_angle_a_step() {
    let angle: f64 = 0.02;
    for (id, share) in [("imex-sbdf2", 1.0), ("imex-mcnab2", 0.5)] {
        for theta in [1e3, 1e6] {
            let mut run = prepared(&format!("{id}:solver=cholesky"), turning(theta, angle), H);
            run.steps(50);
            let before = turn_of(&run.state);
            run.steps(20);
            let loss = (1.0 - turn_of(&run.state) / before) / 20.0;
            let expected = share * angle * angle;
            assert!((loss / expected - 1.0).abs() < 0.1, "{id}, θ={theta}: {loss:e} a step");
        }
    }
}

/// Two free particles that turn about each other: the loss of spin falls with the order.
#[test]
fn the_error_of_the_spin_falls_with_the_number_of_steps() {
    let (x, v) = ([Vec3::x() * -0.25, Vec3::x() * 0.25], [-Vec3::y(), Vec3::y()]);
    let mut spec = particles(&[0.25; 2], &x, &v);
    spec.springs = vec![tension((0, 1), 0.4, 10.0, 0.0)];
    for (family, steps) in ["adams-bashforth2:", "bdf2:residual=1e-16,solver=cholesky,"]
        .into_iter()
        .flat_map(|family| [1, 2, 3].map(|steps| (family, steps)))
    {
        let id = format!("{family}steps={steps}");
        let error = |count: u32| {
            let mut run = prepared(&id, build(&spec), 1.0 / f64::from(count));
            let start = run.system.angular_momentum(&run.state).z;
            run.steps(count as usize);
            assert!(run.state.x.iter().all(|x| x.z == 0.0), "{id} leaves the plane");
            (run.system.angular_momentum(&run.state).z / start - 1.0).abs()
        };
        let order = (error(200) / error(400)).log2();
        assert!(order > f64::from(steps) - 0.2, "{id}: {order}");
    }
}
