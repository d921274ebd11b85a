use super::*;
use crate::{History, Order, Scheme, StabilityClass};
use drape_model::parse;

static FALL: Method = Method {
    id: "fall",
    name: "a method for these tests",
    source: "none",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[],
    theory: "none",
    supports: crate::Supports::Explicit,
    refuses: &[],
    settings: &[],
};

/// Backward Euler of a fall, with a solver that fails for steps above a limit.
#[derive(Debug)]
struct Fall {
    history: History<1>,
    contacts: ContactSet,
    sizes: Vec<f64>,
}

impl Scheme for Fall {
    /// The limit, s.
    type Settings = f64;

    fn method(_limit: &f64) -> &'static Method {
        &FALL
    }

    fn new(system: &System, _limit: &f64, _h: f64) -> Result<Self, PrepareError> {
        let (history, contacts) = (History::new(system.len(), 3), ContactSet::new(system));
        Ok(Self { history, contacts, sizes: Vec::new() })
    }

    fn step(
        &mut self,
        limit: &f64,
        _system: &System,
        state: &mut State,
        h: f64,
        _clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        self.sizes.push(h);
        self.history.push(h, [&state.v]);
        for (x, v) in state.x.iter_mut().zip(&mut state.v) {
            v.z -= 9.81 * h;
            *x += *v * h;
        }
        state.t += h;
        let solve = if h > *limit { SolveStatus::IterationLimit } else { SolveStatus::Converged };
        Ok(StepReport { solve, force_evaluations: 1, ..StepReport::default() })
    }

    fn restart(&mut self) {
        self.history.restart();
    }

    fn is_portable(_limit: &f64) -> bool {
        true
    }
}

impl Rewind for Fall {
    type Past = History<1>;

    fn past(&mut self) -> (&mut History<1>, &mut ContactSet) {
        (&mut self.history, &mut self.contacts)
    }

    fn tolerance(_limit: &f64) -> f64 {
        0.0
    }
}

/// A particle in free fall beside a spring of 1 m, which sets the mesh width.
fn falling(limit: f64, tolerance: f64) -> (Adaptive<Fall>, System, State) {
    let text = r#"{ "format": "drape-system/1", "particles": { "mass_kg": [1, 1],
        "position_m": [[0, 0, 0], [1, 0, 0]] }, "effects": { "gravity": { "m_s2": [0, 0, -9.81] } },
        "springs": [{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1,
            "stiffness_n_per_m": 1 }] }"#;
    let (system, state) = parse("test", text).expect("valid").spec().build().expect("valid");
    let mut adaptive = Adaptive::new(Stepper::new(limit), tolerance);
    adaptive.prepare(&system, TimeStep::new(0.1).expect("positive")).expect("supported");
    (adaptive, system, state)
}

fn fall(adaptive: &mut Adaptive<Fall>) -> &mut Fall {
    adaptive.method.prepared().expect("prepared")
}

fn step(adaptive: &mut Adaptive<Fall>, system: &System, state: &mut State) -> StepReport {
    let h = TimeStep::new(0.1).expect("positive");
    adaptive.step(system, state, h, &mut PhaseClock::off()).expect("no contract is broken")
}

/// In free fall the local error is always `g h²/2`, so the step size settles below `√(2 tol/g)`.
#[test]
fn the_step_size_settles_where_the_error_is_a_little_below_the_tolerance() {
    let (mut adaptive, system, mut state) = falling(1.0, 1e-3);
    let largest = (2.0 * 1e-3 / 9.81_f64).sqrt();
    let reports: Vec<_> = (0..20).map(|_| step(&mut adaptive, &system, &mut state)).collect();
    let last = reports[19];
    // The dead band keeps a step that the controller would lengthen by less than 1.3 = 0.9 e^−0.15.
    assert!(last.error_estimate <= 1.0 && last.error_estimate > 0.086, "{last:?}");
    assert!((0.1 / last.substeps as f64) < largest, "{last:?}");
    assert_eq!((last.rejected, last.solve), (0, SolveStatus::Converged));
    // Steady state keeps the bits of the step size, and so takes no set-up.
    let sizes = &fall(&mut adaptive).sizes;
    let steady = &sizes[sizes.len() - 2 * last.substeps as usize..];
    assert!(steady.iter().all(|h| h.to_bits() == steady[0].to_bits()), "{steady:?}");
    assert!((last.next_step - steady[0]).abs() < 1e-15);
}

#[test]
fn every_call_ends_where_it_was_asked_to() {
    let (mut adaptive, system, mut state) = falling(1.0, 3e-4);
    let mut end = 0.0;
    for _ in 0..7 {
        step(&mut adaptive, &system, &mut state);
        end += 0.1;
        assert_eq!(state.t.to_bits(), f64::to_bits(end));
    }
    let sum: f64 = fall(&mut adaptive).sizes.iter().sum();
    let rejected: f64 = sum - 0.7;
    assert!(rejected.abs() < 1e-12, "no attempt was rejected, and the sum is right: {rejected}");
}

/// The rejected attempts leave no trace: the accepted ones alone give the same bits.
#[test]
fn a_rejected_substep_leaves_no_trace() {
    let (mut adaptive, system, mut state) = falling(0.011, 1.0);
    let report = step(&mut adaptive, &system, &mut state);
    assert!(report.rejected > 0 && report.solve == SolveStatus::Converged, "{report:?}");
    let accepted: Vec<f64> =
        fall(&mut adaptive).sizes.iter().copied().filter(|h| *h <= 0.011).collect();
    assert_eq!(accepted.len(), report.substeps as usize);
    assert_eq!(report.force_evaluations as usize, fall(&mut adaptive).sizes.len() + 1);
    let (mut plain, system, mut replayed) = falling(1.0, 1.0);
    for h in accepted {
        let h = TimeStep::new(h).expect("positive");
        plain.method.step(&system, &mut replayed, h, &mut PhaseClock::off()).expect("steps");
    }
    assert_eq!((&state.x, &state.v), (&replayed.x, &replayed.v));
    let (history, other) = (&fall(&mut adaptive).history, &fall(&mut plain).history);
    assert_eq!((history.len(), other.len()), (3, 3));
    for age in 0..3 {
        let level = |history: &History<1>| (history.step(age), history.field(age, 0).to_vec());
        assert_eq!(level(history), level(other), "{age}");
    }
}

#[test]
fn a_solver_that_always_fails_ends_in_an_honest_report() {
    let (mut adaptive, system, mut state) = falling(0.0, 1.0);
    let report = step(&mut adaptive, &system, &mut state);
    assert_eq!(report.solve, SolveStatus::IterationLimit);
    assert!(report.rejected < 100 && state.t == 0.1 && state.is_finite(), "{report:?}");
    adaptive.method.settings = 1.0;
    let report = step(&mut adaptive, &system, &mut state);
    assert_eq!((report.solve, state.t), (SolveStatus::Converged, 0.2));
}

#[test]
fn restart_forgets_the_step_size() {
    let (mut adaptive, system, mut state) = falling(1.0, 1e-3);
    let first = step(&mut adaptive, &system, &mut state);
    step(&mut adaptive, &system, &mut state);
    state.v.fill(Vec3::zeros());
    adaptive.restart(&state);
    let again = step(&mut adaptive, &system, &mut state);
    assert_eq!(
        (first.substeps, first.force_evaluations),
        (again.substeps, again.force_evaluations)
    );
}
