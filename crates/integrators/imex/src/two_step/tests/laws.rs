//! Laws that hold at any stiffness: spin, free fall, momentum.

use super::*;
use drape_oracle::laws::spin;

/// Two free particles on a spring of unit length that turn by `angle` a step; `θ = 2h²k/m`.
fn pair(theta: f64, angle: f64) -> (System, State) {
    let half = Vec3::x() * 0.5;
    let v = Vec3::y() * (0.5 * angle / H);
    let mut spec = particles(&[MASS; 2], &[half, -half], &[v, -v]);
    let law = coefficients_of(0.5 * theta, 0.0);
    spec.springs = vec![spring(SpringEffect::Tension, (0, 1), 1.0, law)];
    spec.build().unwrap()
}

fn relative(state: &State) -> (Vec3, Vec3) {
    (state.x[0] - state.x[1], state.v[0] - state.v[1])
}

fn angular_momentum(state: &State) -> f64 {
    let (d, v) = relative(state);
    d.cross(&v).z
}

/// A stiff pair starts by the law of backward Euler, which leaves it its spin, and goes on turning. A start by IMEX
/// Euler would leave 1/(1 + θ) of it.
#[test]
fn a_stiff_pair_keeps_its_spin() {
    for (scheme, theta) in SCHEMES.into_iter().flat_map(|s| [1.0, 1e4, 1e6].map(|t| (s, t))) {
        let mut run = Run::new(scheme, "", pair(theta, 1e-3), H);
        let before = angular_momentum(&run.state);
        run.step();
        let first = angular_momentum(&run.state);
        let law = spin::backward_euler(theta, 0.0, 1.0 / relative(&run.state).0.norm());
        assert!((first / before - law).abs() < 1e-9, "{scheme:?}, θ = {theta}: {}", first / before);
        // What does not damp stiff motion rings.
        let rings = matches!(scheme, Scheme::Cnab2 | Scheme::Cnlf);
        let tolerance = if rings { 0.02 } else { 1e-3 };
        for step in 0..100 {
            run.step();
            let kept = angular_momentum(&run.state) / first;
            assert!((kept - 1.0).abs() < tolerance, "{scheme:?}, θ = {theta}, step {step}: {kept}");
        }
        let turned = relative(&run.state).0;
        let angle = turned.y.atan2(turned.x);
        assert!((angle - 0.101).abs() < 1e-3, "{scheme:?}, θ = {theta}: turned by {angle}");
    }
}

/// What the docs say about fast rotation: in a turn of φ a step the methods that damp stiff motion lose φ² (SBDF2) or
/// φ²/2 (MCNAB2) of the spin a step, whatever the stiffness.
#[test]
fn spin_is_lost_with_the_square_of_the_angle_a_step() {
    let angle: f64 = 0.02;
    for (scheme, share) in [(Scheme::Sbdf2, 1.0), (Scheme::Mcnab2, 0.5)] {
        for theta in [1e3, 1e6] {
            let mut run = Run::new(scheme, "solver=cholesky", pair(theta, angle), H);
            run.steps(50);
            let before = angular_momentum(&run.state);
            run.steps(20);
            let loss = (1.0 - angular_momentum(&run.state) / before) / 20.0;
            let expected = share * angle * angle;
            assert!(
                (loss / expected - 1.0).abs() < 0.1,
                "{scheme:?}, θ = {theta}: {loss:e} a step"
            );
        }
    }
}

/// The velocity is that of free fall; the positions are what the formula gives for one particle, on a
/// parabola shifted by less than the `½ h² g` times 3/2 that the first step misses.
#[test]
fn a_free_sheet_falls_as_one_particle() {
    for (scheme, text) in SCHEMES.into_iter().flat_map(|s| ["", "solver=cholesky"].map(|t| (s, t)))
    {
        let mut spec = sheet(4, 1e6, 10.0, DampingLaw::Full);
        spec.pins.clear();
        let velocity = Vec3::new(3.0, -2.0, 1.0);
        spec.particles.velocity_m_s.fill(velocity.into());
        let (system, start) = spec.build().unwrap();
        let mut run = Run::new(scheme, text, (system, start.clone()), H);
        let Coefficients { a: [a0, a1, a2], b: [b0, b1, b2], .. } = scheme.at_constant_step();
        let (g, v) = (GRAVITY, |n: f64| velocity + GRAVITY * (n * H));
        let mut fallen = [v(1.0) * H, Vec3::zeros()];
        for step in 1..=60 {
            run.step();
            let n = f64::from(step);
            if step > 1 {
                let rates = v(n) * b0 + v(n - 1.0) * b1 + v(n - 2.0) * b2;
                fallen = [(rates * H - fallen[0] * a1 - fallen[1] * a2) / a0, fallen[0]];
            }
            for (i, x) in start.x.iter().enumerate() {
                assert!((run.state.v[i] - v(n)).norm() < 1e-9, "{scheme:?}, step {step}");
                assert!((run.state.x[i] - x - fallen[0]).norm() < 1e-9, "{scheme:?}, step {step}");
            }
            let parabola = velocity * (n * H) + g * (0.5 * n * n * H * H);
            let shift = (fallen[0] - parabola).norm() / (0.5 * H * H * g.norm());
            assert!(shift < 1.5 + 1e-9, "{scheme:?}, step {step}: {shift}");
        }
    }
}

#[test]
fn a_free_sheet_keeps_its_momentum() {
    for (scheme, law) in
        SCHEMES.into_iter().flat_map(|s| [DampingLaw::Full, DampingLaw::Projected].map(|l| (s, l)))
    {
        let mut spec = sheet(4, 1e4, 5.0, law);
        (spec.pins, spec.effects.gravity) = (Vec::new(), None);
        let mut run = Run::new(scheme, "solver=cholesky", stir(&spec), 0.01);
        let momentum = |run: &Run| {
            let terms = run.state.v.iter().zip(run.system.mass());
            terms.fold(Vec3::zeros(), |sum, (v, m)| sum + v * *m)
        };
        let (before, mut moved) = (momentum(&run), 0.0_f64);
        let start = run.state.x.clone();
        for _ in 0..50 {
            run.step();
            assert!((momentum(&run) - before).norm() < 1e-9, "{scheme:?}, {law:?}");
            moved = moved.max((run.state.x[5] - start[5]).norm());
        }
        assert!(moved > 0.01, "{scheme:?}: something moves");
    }
}
