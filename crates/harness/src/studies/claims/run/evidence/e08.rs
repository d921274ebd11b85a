//! What is run for claim C08.

use super::meshes::Mesh;
use super::scenes::{build, greatest, hanging, matrix};
use super::{Number, Trial};
use crate::HarnessError;
use crate::studies::sheet::Sheet;
use drape_model::SystemSpec;
use drape_solvers::ScalarMatrix;

pub(super) const TRIAL: Trial = Trial {
    id: "C08",
    scenes: || {
        "grids of 10 × 10 and 20 × 20, with shear springs, with masses 1 : 128, a triangle mesh \
         and a random mesh; mass, stiffness and step are powers of two, so that sums are exact; \
         h²k/m from 1 to 4¹²"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

/// Mass, stiffness and step are powers of two here, so that every sum is exact.
const MASS: f64 = 1.0 / 1024.0;
const STEP: f64 = 1.0 / 128.0;
/// Exponents of `h²k/m`, to the base 4.
const EXPONENTS: [i32; 5] = [0, 2, 4, 8, 12];

/// `A_ii − Σ_j |A_ij|` of each row, over the diagonal entry.
fn margins(a: &ScalarMatrix) -> Vec<(f64, f64)> {
    let margin = |i: usize| {
        let (columns, values) = a.row(i);
        let others = columns.iter().zip(values).filter(|(j, _)| **j as usize != i);
        let diagonal = a.diagonal(i);
        let margin = others.fold(diagonal, |margin, (_, value)| margin - value.abs());
        (margin, margin / diagonal)
    };
    (0..a.n()).map(margin).collect()
}

fn scenes() -> Result<Vec<SystemSpec>, HarnessError> {
    let sheet = |side: u32| hanging(side, 1.0, 0.0);
    let uneven = |mut spec: SystemSpec| {
        let mass = spec.particles.mass_kg.iter_mut().enumerate();
        mass.for_each(|(i, m)| *m = MASS * f64::from(1_u32 << (i % 8)));
        spec
    };
    Ok(vec![
        sheet(10).spec()?,
        sheet(20).spec()?,
        Sheet { shear: 0.25, ..sheet(20) }.spec()?,
        uneven(sheet(20).spec()?),
        Mesh::Triangles.hanging(20, 1.0, 0.0)?,
        Mesh::Random(1).hanging(12, 1.0, 0.0)?,
    ])
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut differing = 0;
    let mut rows = 0;
    let mut relative = Vec::new();
    for exponent in EXPONENTS {
        let theta = f64::from(4_i32.pow(exponent as u32));
        let mut widest: f64 = 0.0;
        for (scene, mut spec) in scenes()?.into_iter().enumerate() {
            for m in spec.particles.mass_kg.iter_mut().filter(|_| scene != 3) {
                *m = MASS;
            }
            for spring in &mut spec.springs {
                let share = if spring.stiffness_n_per_m < 0.5e-3 { 0.25 } else { 1.0 };
                spring.stiffness_n_per_m = share * theta * MASS / (STEP * STEP);
            }
            let system = build(&spec)?.system;
            let found = margins(&matrix(&system, STEP));
            let wrong = found.iter().zip(system.mass()).filter(|((margin, _), m)| margin != *m);
            differing += wrong.count();
            rows += found.len();
            if scene != 3 {
                widest = widest.max(greatest(found.iter().map(|(_, share)| *share)));
            }
        }
        relative.push((theta, widest));
    }
    Ok(numbers(differing, rows, &relative))
}

fn numbers(differing: usize, rows: usize, relative: &[(f64, f64)]) -> Vec<Number> {
    let mut numbers = vec![
        Number::new("rows whose margin is not m_i to the last bit", differing as f64, "")
            .against(0.0),
    ];
    numbers.push(Number::new("rows", rows as f64, ""));
    for (theta, share) in relative {
        let what = format!("greatest margin over diagonal, h²k/m = {theta}");
        numbers.push(Number::new(what, *share, ""));
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn margins_are_measured_row_by_row() {
        let mut a = ScalarMatrix::with_pattern(2, [(0, 1)]);
        a.add_diagonal(0, 1.0);
        a.add_diagonal(1, 3.0);
        a.add_edge(0, 1, 1.0);
        assert_eq!(margins(&a), [(1.0, 0.5), (3.0, 0.75)]);
    }
}
