//! A time integrator of your own, with every command and every study of drape: implicit midpoint.
//! `cargo run --release --example write_a_method -- run hanging-textile-1e6 --method my-midpoint --dt 0.01`

use drape::integrator::*;
use drape::model::{State, System, Vec3};

static METHOD: Method = Method {
    id: "my-midpoint",
    name: "implicit midpoint of my own",
    source: "the Gauss method of one stage",
    order: Order::Two,
    class: StabilityClass::Symplectic,
    conserves: &[Quantity::Momentum, Quantity::AngularMomentum],
    theory: "A-stable on linear problems",
    supports: Supports::Blocks,
    refuses: &["air", "contact", "friction"],
    settings: &[],
};

/// The memory of a step: `new` allocates it, `step` allocates nothing.
#[derive(Debug)]
struct MyMidpoint(ImplicitStage, ContactSet, Constraints, Vec<Vec3>);

#[rustfmt::skip]
impl Scheme for MyMidpoint {
    type Settings = ();
    fn method(_: &()) -> &'static Method { &METHOD }
    fn new(system: &System, _: &(), _h: f64) -> Result<Self, PrepareError> {
        let (stage, contacts) = (ImplicitStage::new(system)?, ContactSet::new(system));
        let (n, middle) = (system.len(), vec![Vec3::zeros(); system.len()]);
        Ok(Self(stage, contacts, Constraints::free(n), middle))
    }
    fn step(&mut self, _: &(), system: &System, state: &mut State, h: f64, clock: &mut PhaseClock)
        -> Result<StepReport, StepError> {
        let Self(stage, contacts, constraints, middle) = self;
        let tight = StageSettings { residual: 1e-12, ..StageSettings::default() };
        let (from, mut report) = ((&state.x[..], &state.v[..]), StepReport::default());
        for i in 0..system.len() { middle[i] = state.x[i] + state.v[i] * (0.5 * h); }
        // M (w − v_n) = h/2 f(x_n + h/2 w, w)
        let lagged = drape::model::Level { t: state.t + 0.5 * h, x: middle, v: &state.v };
        let input = Stage { tau: (0.5 * h).into(), end: lagged.t, from, lagged, velocity: &state.v };
        stage.solve(system, input, &state.v, contacts, constraints, tight, clock, &mut report)?;
        let w = stage.velocity();
        for i in 0..system.len() {
            state.x[i] += w[i] * h; // x_{n+1} = x_n + h w
            if !system.pinned()[i] { state.v[i] = w[i] * 2.0 - state.v[i]; } // 2 w − v_n
        }
        state.t += h;
        Ok(report)
    }
    fn restart(&mut self) {}
    fn is_portable(_: &()) -> bool { false }
}

fn main() -> std::process::ExitCode {
    drape::Drape::new().with(Registration::new::<MyMidpoint>(&METHOD)).main()
}
