//! Drape's own steps of a case, timed one by one as a peer times its own.

use crate::error::PeersError;
use crate::program::Sample;
use drape_benches::{HangingSheet, Mesh, STEP_S};
use drape_harness::HarnessError;
use drape_harness::methods::{Choice, MethodError};
use drape_integrator::{PhaseClock, TimeStep};
use drape_report::number::median;
use std::time::Instant;

/// Takes `steps` steps of `method` from the start of the sheet.
pub(crate) fn take(
    method: &str,
    side: u32,
    mesh: Mesh,
    steps: u32,
    stiffness: f64,
) -> Result<Sample, PeersError> {
    let HangingSheet { spec, middle } = HangingSheet::new(side, stiffness, mesh)?;
    let (system, mut state, numbering) = spec.build_ordered()?;
    drop(spec);
    let h = TimeStep::new(STEP_S).map_err(HarnessError::from)?;
    let choice = Choice::parse(method, &[]).map_err(HarnessError::from)?;
    let build = |error| HarnessError::from(MethodError::from(error));
    let mut integrator = choice.build().map_err(build)?;
    integrator.prepare(&system, h).map_err(HarnessError::from)?;
    let mut clock = PhaseClock::off();
    let mut seconds = Vec::with_capacity(steps as usize);
    let mut iterations = 0;
    for _ in 0..steps {
        let begin = Instant::now();
        let report = integrator.step(&system, &mut state, h, &mut clock);
        seconds.push(begin.elapsed().as_secs_f64());
        iterations += report.map_err(HarnessError::from)?.cg_iterations;
    }
    let count = f64::from(steps.max(1));
    Ok(Sample {
        mean_us: Some(1e6 * seconds.iter().sum::<f64>() / count),
        median_us: 1e6 * median(seconds.iter().copied()).unwrap_or(f64::NAN),
        iterations: f64::from(iterations) / count,
        middle: state.x[numbering.internal(middle)].z,
        lowest: state.x.iter().map(|x| x.z).fold(f64::INFINITY, f64::min),
    })
}

/// The line that tells them, in a peer's words.
pub(crate) fn line(sample: &Sample) -> String {
    let Sample { median_us, mean_us, iterations, middle, lowest } = sample;
    let mean = mean_us.unwrap_or(*median_us);
    format!(
        "total {median_us:.3} (med) {mean:.3} (mean) | iterations {iterations:.3} | ymin {lowest:.9} xmid {middle:.9}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_meshes_give_the_same_motion_and_a_direct_solve_agrees() {
        let run = |method, mesh| take(method, 9, mesh, 60, 1e4).expect("a run");
        let exact = run("imex-euler:solver=cholesky", Mesh::Grid);
        let other = run("imex-euler:solver=cholesky", Mesh::General);
        assert!((exact.middle - other.middle).abs() < 1e-9, "{exact:?} {other:?}");
        let loose = run("imex-euler", Mesh::Grid);
        assert!((exact.lowest - loose.lowest).abs() < 1e-2 * exact.lowest.abs());
        assert!(exact.lowest < -0.3, "it falls: {exact:?}");
    }
}
