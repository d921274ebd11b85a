//! What is run for claim C11.

use super::meshes::Mesh;
use super::scenes::{build, hanging, run};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c11::LIMIT;
use crate::run::Simulation;
use crate::studies::sheet::Sheet;
use drape_integrator::Implicit;
use drape_model::{System, Tangent, Vec3};
use drape_oracle::Random;
use drape_solvers::vector::norm;

pub(super) const TRIAL: Trial = Trial {
    id: "C11",
    scenes: || {
        "sheets at rest: grids of 6 × 6 and 12 × 12, with shear springs, a triangle mesh, a random \
         mesh; spectral and Frobenius norm"
            .to_owned()
    },
    portable: true,
    is_quick: true,
    run: evidence,
    seconds: None,
};

const PRODUCTS: usize = 200;

/// Which part of the springs' Jacobian.
#[derive(Clone, Copy)]
enum Part {
    /// `∂F1 = −L_k`.
    Linear,
    /// `∂F2 = K_1 − K`, where `K` is the whole.
    Rest,
}

/// `out ← ∂F w`, up to its sign.
fn multiply(system: &System, x: &[Vec3], part: Part, w: &[Vec3], out: &mut [Vec3]) {
    out.fill(Vec3::zeros());
    Implicit::Springs.add_linear_spring_forces(system, w, out);
    if let Part::Rest = part {
        let mut whole = vec![Vec3::zeros(); w.len()];
        Implicit::Springs.multiply_stiffness(system, x, Tangent::Exact, w, &mut whole);
        out.iter_mut().zip(&whole).for_each(|(out, whole)| *out += whole);
    }
}

/// Spectral norm, by power iteration.
fn spectral_norm(system: &System, x: &[Vec3], part: Part) -> f64 {
    let mut random = Random::new(1);
    let mut w: Vec<_> = (0..system.len()).map(|_| random.vector()).collect();
    let mut product = w.clone();
    let mut size = 0.0;
    for _ in 0..PRODUCTS {
        multiply(system, x, part, &w, &mut product);
        size = norm(&product) / norm(&w);
        let scale = 1.0 / norm(&product).max(f64::MIN_POSITIVE);
        w.iter_mut().zip(&product).for_each(|(w, p)| *w = p * scale);
    }
    size
}

/// Frobenius norm, column by column.
fn frobenius_norm(system: &System, x: &[Vec3], part: Part) -> f64 {
    let mut w = vec![Vec3::zeros(); system.len()];
    let mut product = w.clone();
    let mut sum = 0.0;
    for column in 0..3 * system.len() {
        w[column / 3][column % 3] = 1.0;
        multiply(system, x, part, &w, &mut product);
        w[column / 3][column % 3] = 0.0;
        sum += norm(&product) * norm(&product);
    }
    sum.sqrt()
}

fn scenes() -> Result<Vec<(&'static str, Simulation)>, HarnessError> {
    let sheet = |side: u32| hanging(side, 1e4, 0.0);
    Ok(vec![
        ("grid 6 × 6", build(&sheet(6).spec()?)?),
        ("grid 12 × 12", build(&sheet(12).spec()?)?),
        ("grid 12 × 12 with shear", build(&Sheet { shear: 1e3, ..sheet(12) }.spec()?)?),
        ("triangles", build(&Mesh::Triangles.hanging(12, 1e4, 0.0)?)?),
        ("random mesh", build(&Mesh::Random(1).hanging(12, 1e4, 0.0)?)?),
    ])
}

/// How far the middle of the sheet has fallen after 0.3 s at k/m = 1e6 and h = 0.01 with a method,
/// m.
fn fall(method: &str) -> Result<f64, HarnessError> {
    let start = build(&hanging(12, 1e6, 40.0).spec()?)?;
    let state = run(&start, method, 0.01, 0.3, None)?.state;
    let height = |x: &[Vec3]| x.iter().map(|x| x.z).sum::<f64>() / x.len() as f64;
    Ok(height(&start.state.x) - height(&state.x))
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut numbers = Vec::new();
    for (name, Simulation { system, state }) in scenes()? {
        let ratio = |of: fn(&System, &[Vec3], Part) -> f64| {
            of(&system, &state.x, Part::Rest) / of(&system, &state.x, Part::Linear)
        };
        for (norm, value) in
            [("spectral", ratio(spectral_norm)), ("Frobenius", ratio(frobenius_norm))]
        {
            numbers
                .push(Number::new(format!("ratio, {norm} norm, {name}"), value, "").against(LIMIT));
        }
    }
    let falls = [
        ("IMEX Euler, without ∂F2", fall("imex-euler:norm=euclid,forcing_term=1e-8")?),
        ("Baraff-Witkin, with ∂F2 in the matrix", fall("baraff-witkin:forcing_term=1e-8")?),
    ];
    for (name, fall) in falls {
        numbers.push(Number::new(format!("mean fall in 0.3 s, k/m = 1e6, {name}"), fall, "m"));
    }
    Ok(numbers)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::studies::sheet::pair;

    /// One spring at rest: both have the eigenvalue 2k; ∂F1 three times, ∂F2 twice.
    #[test]
    fn norms_of_a_single_spring_are_known() {
        let start = build(&pair(1e4)).unwrap();
        let (system, x) = (&start.system, &start.state.x);
        let k = 1e4 * 1e-3;
        for (part, count) in [(Part::Linear, 3.0_f64), (Part::Rest, 2.0)] {
            assert!((spectral_norm(system, x, part) / (2.0 * k) - 1.0).abs() < 1e-12);
            assert!(
                (frobenius_norm(system, x, part) / (2.0 * k * count.sqrt()) - 1.0).abs() < 1e-12
            );
        }
    }
}
