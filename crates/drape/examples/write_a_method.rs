//! A time integrator of your own: symplectic Euler that moves the positions first.
//! `cargo run --example write_a_method` runs it with two step sizes and judges the energy.

#![allow(clippy::print_stdout, reason = "an example shows its numbers")]

use drape::integrator::*;
use drape::model::{Level, State, System, TimeSpan, Vec3};
use drape::{Runner, Simulation, reference_energy};

static POSITIONS_FIRST: Method = Method {
    id: "positions-first",
    name: "symplectic Euler, positions first",
    source: "the adjoint of symplectic Euler",
    order: Order::One,
    class: StabilityClass::Symplectic,
    conserves: &[Quantity::Momentum, Quantity::AngularMomentum],
    theory: "stable if h²λ + 2hδ < 4",
    supports: Supports::Explicit,
    refuses: &["contact", "friction"],
    settings: &[],
};

#[derive(Debug, Default)]
struct PositionsFirst(Vec<Vec3>);

impl Integrator for PositionsFirst {
    fn method(&self) -> &'static Method {
        &POSITIONS_FIRST
    }
    fn prepare(&mut self, system: &System, _: TimeStep) -> Result<(), PrepareError> {
        self.0 = vec![Vec3::zeros(); system.len()]; // a step allocates nothing
        POSITIONS_FIRST.check(system)
    }
    #[rustfmt::skip]
    fn step(&mut self, system: &System, state: &mut State, h: TimeStep, _: &mut PhaseClock)
        -> Result<StepReport, StepError> {
        let (h, force) = (h.seconds(), &mut self.0);
        drift(h, &state.v, &mut state.x); // x_{n+1} = x_n + h v_n
        system.forces(Level { t: state.t + h, x: &state.x, v: &state.v }, force);
        system.clear_pinned(force);
        kick(system, h, force, &mut state.v); // v_{n+1} = v_n + h M⁻¹ f(x_{n+1}, v_n)
        state.t += h;
        Ok(StepReport { force_evaluations: 1, ..StepReport::default() })
    }
    fn restart(&mut self, _: &State) {}
}
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sheet = Simulation::load("hanging-textile-1e4")?;
    for step_s in [1e-3, 2e-2] {
        let time = TimeSpan { step_s, duration_s: 0.5 };
        let run = Runner::with(&mut PositionsFirst::default(), time).count(&sheet)?;
        let verdict = run.verdict(reference_energy(&sheet, 0.5)?);
        println!("h = {step_s} s: {}, {} steps", verdict.name(), run.outcome.steps);
    }
    Ok(())
}
