//! Scenes and runs that several of the tests across crates share.

pub mod drape;
pub mod equations;
pub mod splice;

use drape_harness::methods::Choice;
use drape_integrator::{Integrator, PhaseClock, StepReport, TimeStep};
use drape_model::{
    Cloth, DampingLaw, Effects, Grid, PieceSpec, Pin, Scene, SpringEffect, SpringLaw, State,
    System, SystemSpec, TimeSpan,
};
pub use drape_oracle::scenes::{GRAVITY, gravity, particles, pin, spring};

/// Every method, with settings that lead through different code.
pub const METHODS: [&str; 48] = [
    "explicit-euler",
    "symplectic-euler",
    "symplectic-euler:damping=implicit",
    "leapfrog",
    "leapfrog:solver=cholesky",
    "leapfrog:step=auto",
    "provot",
    "provot:limit=1e-3,sweeps=4,order=alternating,velocity=positions-only",
    "adams-bashforth2",
    "adams-bashforth2:steps=3",
    "backward-euler",
    "backward-euler:jacobian=saved",
    "backward-euler:solver=cg,forcing=eisenstat-walker",
    "backward-euler:solver=multigrid,forcing=eisenstat-walker",
    "backward-euler:tolerance=0.01",
    "bdf2",
    "bdf2:steps=1",
    "bdf2:jacobian=saved,solver=cg",
    "bdf2:tolerance=0.01",
    "bdf2:steps=3",
    "terzopoulos-fleischer",
    "terzopoulos-fleischer:clamp=true",
    "baraff-witkin",
    "baraff-witkin:hessian=raw,norm=euclid,preconditioner=none",
    "baraff-witkin:solver=cholesky,contact=position,implicit=tension",
    "desbrun",
    "desbrun:inverse=dense,torque=literal",
    "desbrun:torque=none,inverse_dynamics=true,limit=1e-3",
    "kang",
    "kang:sweeps=5",
    "imex-euler",
    "imex-euler:solver=cholesky,implicit=springs",
    "imex-euler:tolerance=0.01",
    "imex-euler:preconditioner=jacobi,norm=preconditioned,start=last",
    "imex-updated",
    "imex-updated:newton_above=0",
    "imex-updated:forcing=eisenstat-walker",
    "imex-updated:tolerance=0.01",
    "imex-updated:safeguard=paper",
    "imex-updated:solver=cholesky",
    "imex-sbdf2",
    "imex-sbdf2:solver=cholesky",
    "imex-sbdf2:tolerance=0.01",
    "imex-cnab2",
    "imex-mcnab2",
    "imex-mcnab2:tolerance=0.01,estimator=plain",
    "imex-mcnab2:implicit=tension,start=last",
    "imex-cnlf",
];

/// An integrator by its id and settings, as on the command line.
///
/// # Panics
/// When there is no such method or setting.
pub fn method(id: &str) -> Box<dyn Integrator> {
    let choice = Choice::parse(id, &[]).unwrap_or_else(|error| panic!("{error}"));
    choice.build().unwrap_or_else(|error| panic!("{error}"))
}

/// Whether the method of this id takes obstacles that rub.
///
/// # Panics
/// When there is no such method or setting.
pub fn takes_friction(id: &str) -> bool {
    let choice = Choice::parse(id, &[]).unwrap_or_else(|error| panic!("{error}"));
    choice.method().supports().any(|support| support.effect == "friction")
}

/// A checked step size.
///
/// # Panics
/// When it is not positive and finite.
pub fn seconds(h: f64) -> TimeStep {
    TimeStep::new(h).unwrap_or_else(|error| panic!("{error}"))
}

/// A prepared integrator with its system and state.
#[derive(Debug)]
pub struct Run {
    /// The integrator.
    pub integrator: Box<dyn Integrator>,
    /// The system.
    pub system: System,
    /// Where it is now.
    pub state: State,
    /// Step size.
    pub h: TimeStep,
}

impl Run {
    /// Prepares a method for a system.
    ///
    /// # Panics
    /// When the method refuses the system.
    pub fn new(id: &str, (system, state): (System, State), h: f64) -> Self {
        let (mut integrator, h) = (method(id), seconds(h));
        integrator.prepare(&system, h).unwrap_or_else(|error| panic!("{id}: {error}"));
        Self { integrator, system, state, h }
    }

    /// Takes one step.
    ///
    /// # Panics
    /// When the step is refused.
    pub fn step(&mut self) -> StepReport {
        self.integrator
            .step(&self.system, &mut self.state, self.h, &mut PhaseClock::off())
            .unwrap_or_else(|error| panic!("{error}"))
    }

    /// Total energy, J.
    pub fn energy(&self) -> f64 {
        self.system.total_energy(&self.state)
    }
}

/// Builds a frozen system.
///
/// # Panics
/// When it is not valid.
pub fn build(spec: &SystemSpec) -> (System, State) {
    spec.build().unwrap_or_else(|violation| panic!("{violation}"))
}

/// A horizontal sheet, 1 m × 1 m, 1 g a particle.
#[derive(Clone, Copy, Debug)]
pub struct Sheet {
    /// Particles along each edge.
    pub side: u32,
    /// Stiffness over mass of the tension springs, 1/s².
    pub tension: f64,
    /// Stiffness over mass of the shear springs, 1/s².
    pub shear: f64,
    /// Damping over mass of the tension springs, 1/s.
    pub damping: f64,
    /// How the damping acts.
    pub law: DampingLaw,
    /// Whether two corners of the first row are pinned.
    pub pinned: bool,
}

/// A sheet whose steps take no time to speak of.
pub const SMALL_SHEET: Sheet = Sheet {
    side: 5,
    tension: 2e3,
    shear: 300.0,
    damping: 3.0,
    law: DampingLaw::Full,
    pinned: true,
};

impl Sheet {
    /// The scene, with gravity; shear springs have a tenth of the damping.
    pub fn scene(self) -> Scene {
        let law = |stiffness, damping| SpringLaw {
            stiffness_over_mass_per_s2: Some(stiffness),
            damping_over_mass_per_s: Some(damping),
            ..SpringLaw::default()
        };
        let corner = |column| Pin { row: Some(0), column: Some(column), ..Pin::default() };
        Scene {
            format: "drape-scene/1".to_owned(),
            name: "sheet".to_owned(),
            description: String::new(),
            assumed: Vec::new(),
            cloth: Cloth::Grid(Grid {
                rows: self.side,
                columns: self.side,
                size_m: [1.0, 1.0],
                center_m: [0.0; 3],
                mass_kg: 1e-3 * f64::from(self.side * self.side),
                velocity_m_s: [0.0; 3],
            }),
            effects: Effects {
                tension: Some(law(self.tension, self.damping)),
                shear: Some(law(self.shear, 0.1 * self.damping)),
                gravity: gravity(),
                ..Effects::default()
            },
            damping: self.law,
            pins: if self.pinned { vec![corner(0), corner(self.side - 1)] } else { Vec::new() },
            obstacles: Vec::new(),
            time: TimeSpan { step_s: 0.01, duration_s: 1.0 },
        }
    }

    /// The system at its start.
    ///
    /// # Panics
    /// When the numbers make no valid scene.
    pub fn build(self) -> (System, State) {
        build(&self.scene().discretise().unwrap_or_else(|violation| panic!("{violation}")))
    }
}

/// The same system, its tension springs `ratio` times as stiff beyond 1 % of strain.
pub fn stiffening(mut spec: SystemSpec, ratio: f64) -> SystemSpec {
    for spring in spec.springs.iter_mut().filter(|s| s.effect == SpringEffect::Tension) {
        let stiffness_n_per_m = spring.stiffness_n_per_m;
        let soft = PieceSpec { up_to_strain: Some(0.01), stiffness_n_per_m };
        let steep = ratio * stiffness_n_per_m;
        spring.pieces = [soft, PieceSpec { up_to_strain: None, stiffness_n_per_m: steep }].into();
    }
    spec
}

/// A bundled scene at its start.
///
/// # Panics
/// When there is none such.
pub fn bundled(name: &str) -> (System, State) {
    build(drape_model::load(name).unwrap_or_else(|error| panic!("{error}")).spec())
}
