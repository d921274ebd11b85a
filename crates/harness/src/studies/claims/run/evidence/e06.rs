//! What is run for claim C06.

use super::meshes::Mesh;
use super::scenes::{build, hanging, least, matrix};
use super::{Number, Timed, Trial};
use crate::HarnessError;
use crate::claims::c06::LIMIT;
use crate::methods::Choice;
use crate::studies::claims::facts::TimedCase;
use drape_integrator::{PhaseClock, TimeStep};
use drape_model::SystemSpec;
use drape_solvers::{LinearOperator, ScalarMatrix};
use std::collections::BTreeSet;
use std::time::Instant;

pub(super) const TRIAL: Trial = Trial {
    id: "C06",
    scenes: || {
        "the paper's sizes, n = 400 and 2704, on grids and on triangle meshes; multiplications \
         counted: dense by Cholesky, sparse with minimum-degree ordering, a step with its forces"
            .to_owned()
    },
    portable: true,
    is_quick: true,
    run: evidence,
    seconds: Some(seconds),
};

const STEP: f64 = 0.01;
/// Multiplications for the force of a spring.
const SPRING: f64 = 20.0;

/// Multiplications of a rebuild and of a step.
#[derive(Clone, Copy, Debug)]
struct Cost {
    rebuild: f64,
    step: f64,
}

impl Cost {
    fn steps(self) -> f64 {
        self.rebuild / self.step
    }
}

/// The dense inverse by Cholesky: `n³/6` for the factor, `n³/3` for the inverse of a symmetric
/// matrix from it; a step multiplies three vectors by it.
fn dense(n: f64, springs: f64) -> Cost {
    Cost { rebuild: n * n * n / 2.0, step: 3.0 * n * n + SPRING * springs }
}

/// The sparse Cholesky factor with columns of these lengths below the diagonal; a step solves with
/// it twice for three right-hand sides.
fn sparse(columns: &[usize], springs: f64) -> Cost {
    let sum = |f: fn(f64) -> f64| columns.iter().map(|&c| f(c as f64)).sum::<f64>();
    Cost {
        rebuild: sum(|c| 0.5 * c * (c + 3.0) + 1.0),
        step: 6.0 * sum(|c| c + 1.0) + SPRING * springs,
    }
}

/// Lengths of the factor's columns when the node with the fewest neighbours is always eliminated
/// first (minimum degree, the least number among equals).
fn minimum_degree(a: &ScalarMatrix) -> Vec<usize> {
    let neighbours = |i: usize| a.row(i).0.iter().map(|&j| j as usize).filter(move |&j| j != i);
    let mut graph: Vec<BTreeSet<usize>> = (0..a.size()).map(|i| neighbours(i).collect()).collect();
    let mut queue: BTreeSet<(usize, usize)> =
        graph.iter().enumerate().map(|(i, around)| (around.len(), i)).collect();
    let mut columns = Vec::with_capacity(graph.len());
    while let Some((degree, i)) = queue.pop_first() {
        columns.push(degree);
        let around = std::mem::take(&mut graph[i]);
        for &j in &around {
            queue.remove(&(graph[j].len(), j));
            graph[j].remove(&i);
            graph[j].extend(around.iter().filter(|&&k| k != j));
            queue.insert((graph[j].len(), j));
        }
    }
    columns
}

/// The sizes of the paper's tables, on a grid and on a triangle mesh.
fn scenes() -> Result<Vec<(String, SystemSpec)>, HarnessError> {
    let mut scenes = Vec::new();
    for side in [20, 52] {
        scenes.push((format!("grid, n = {}", side * side), hanging(side, 1e4, 40.0).spec()?));
        let mesh = Mesh::Triangles.hanging(side, 1e4, 40.0)?;
        scenes.push((format!("triangles, n = {}", mesh.particles.mass_kg.len()), mesh));
    }
    Ok(scenes)
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut numbers = Vec::new();
    for (name, spec) in scenes()? {
        let springs = spec.springs.len() as f64;
        let system = build(&spec)?.system;
        let inverse = dense(system.len() as f64, springs).steps();
        let factor = sparse(&minimum_degree(&matrix(&system, STEP)), springs).steps();
        let what = format!("steps that a rebuild costs, dense inverse, {name}");
        numbers.push(Number::new(what, inverse, "").against(LIMIT));
        let what = format!("steps that a rebuild costs, sparse Cholesky, {name}");
        numbers.push(Number::new(what, factor, "").against(LIMIT));
    }
    Ok(numbers)
}

/// Rebuilds and steps on the clock: the step size changes each time, or not.
fn seconds() -> Result<Timed, HarnessError> {
    let mut cases = Vec::new();
    let mut steps = Vec::new();
    for (method, side) in [("dense", 20), ("dense", 40), ("cholesky", 20), ("cholesky", 52)] {
        let start = build(&hanging(side, 1e4, 40.0).spec()?)?;
        let choice = Choice::parse(&format!("desbrun:inverse={method}"), &[])?;
        let mut integrator = choice.build().map_err(crate::methods::MethodError::from)?;
        integrator.prepare(&start.system, TimeStep::new(STEP)?)?;
        let mut state = start.state.clone();
        let mut time = |h: f64| -> Result<u64, HarnessError> {
            let (h, begin) = (TimeStep::new(h)?, Instant::now());
            integrator.step(&start.system, &mut state, h, &mut PhaseClock::off())?;
            Ok(u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX))
        };
        let plain = (0..30).map(|_| time(STEP)).collect::<Result<Vec<_>, _>>()?;
        let rebuilt = (0..4).map(|n| time(STEP * (1.0 + 0.01 * f64::from(n + 1))));
        let rebuilt = rebuilt.collect::<Result<Vec<_>, _>>()?;
        let case = |what: &str, samples_ns| TimedCase {
            what: format!("{what}, {method}, n = {}", side * side),
            samples_ns,
        };
        let (plain, rebuilt) = (case("a step", plain), case("a step with a rebuild", rebuilt));
        steps.push((method, rebuilt.median_s() / plain.median_s() - 1.0));
        cases.extend([plain, rebuilt]);
    }
    let dense = steps.iter().filter(|(method, _)| *method == "dense").map(|(_, steps)| *steps);
    let least = least(dense);
    let number =
        Number::new("least cost of a rebuild in steps, dense inverse", least, "").against(LIMIT);
    Ok((cases, number))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain has no fill-in; a star neither, if its centre comes last; a ring fills in one entry
    /// a node but the last three.
    #[test]
    fn minimum_degree_finds_the_known_factors() {
        let columns = |n: usize, edges: &[(usize, usize)]| {
            let matrix = ScalarMatrix::with_pattern(n, edges.iter().copied());
            minimum_degree(&matrix).iter().sum::<usize>()
        };
        assert_eq!(columns(5, &[(0, 1), (1, 2), (2, 3), (3, 4)]), 4);
        assert_eq!(columns(5, &[(0, 1), (0, 2), (0, 3), (0, 4)]), 4);
        assert_eq!(columns(5, &[(0, 1), (1, 2), (2, 3), (3, 4), (4, 0)]), 7);
    }
}
