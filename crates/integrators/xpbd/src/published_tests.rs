//! Beside the public solver of Newton 1.8.0, on one frozen sheet.

use crate::Xpbd;
use crate::settings::XpbdSettings;
use drape_oracle::published::{Relaxation, newton, vectors};
use drape_oracle::{Run, apart};

/// What single precision leaves of positions of 1 m after four steps, m.
const SINGLE: f64 = 5e-7;

/// `SolverXPBD` adds up the corrections of a sweep. The same loop that takes spring after spring
/// gives the positions of this crate, so that nothing else differs.
#[test]
fn on_a_net_the_public_solver_is_jacobis_form_of_this_sweep() {
    let published = newton();
    let case = published.case("net");
    for (&steps, theirs) in &case.position_after_m {
        let jacobi = published.relax(case, Relaxation::Jacobi, steps);
        let off = apart(&jacobi, &vectors(theirs));
        assert!(off < SINGLE, "{steps} steps: {off:e} m from the public solver");
        let in_turn = published.relax(case, Relaxation::GaussSeidel, steps);
        let sweeps = case.iterations.to_string();
        let settings = XpbdSettings::from_pairs([("substeps", "1"), ("iterations", &sweeps[..])]);
        let settings = settings.unwrap_or_else(|error| panic!("{error}"));
        let mut run =
            Run::new(Box::new(Xpbd::new(settings)), published.build(case), published.step_s);
        run.steps(steps);
        let off = apart(&run.state.x, &in_turn);
        assert!(off < 1e-12, "{steps} steps: {off:e} m from the loop in turn");
        let differs = apart(&jacobi, &in_turn);
        assert!(differs > 10.0 * SINGLE, "{steps} steps: the two forms differ by {differs:e} m");
    }
}
