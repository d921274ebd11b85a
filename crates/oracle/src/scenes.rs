//! Small scenes that tests, benches and studies share.

use drape_model::{
    AirSpec, AngularLaw, Cloth, DampingLaw, DragSpec, Effects, GravitySpec, Grid, GustSpec,
    ObstacleSpec, ParticlesSpec, PieceSpec, Pin, PinSpec, Scene, SpringEffect, SpringLaw,
    SpringSpec, State, System, SystemSpec, TimeSpan, Vec3, WindSpec,
};

/// The acceleration of gravity, m/s².
pub const GRAVITY: Vec3 = Vec3::new(0.0, 0.0, -9.81);

/// [`GRAVITY`] as an effect.
pub fn gravity() -> Option<GravitySpec> {
    Some(GravitySpec { m_s2: GRAVITY.into() })
}

/// A frozen system of free particles without any effect.
///
/// Masses are in kg, positions in m, velocities in m/s. An empty list of velocities means rest.
pub fn particles(mass: &[f64], position: &[Vec3], velocity: &[Vec3]) -> SystemSpec {
    let list = |vectors: &[Vec3]| vectors.iter().map(|&a| a.into()).collect();
    SystemSpec {
        name: "test".to_owned(),
        particles: ParticlesSpec {
            mass_kg: mass.to_vec(),
            position_m: list(position),
            velocity_m_s: list(velocity),
        },
        ..SystemSpec::default()
    }
}

/// A spring between two particles: rest length in m, stiffness in N/m, damping in N s/m.
pub fn spring(
    effect: SpringEffect,
    (i, j): (usize, usize),
    rest_length: f64,
    stiffness: f64,
    damping: f64,
) -> SpringSpec {
    SpringSpec {
        effect,
        i: i as u32,
        j: j as u32,
        rest_length_m: rest_length,
        stiffness_n_per_m: stiffness,
        damping_n_s_per_m: damping,
        ..SpringSpec::default()
    }
}

/// A [`spring`] of the effect `tension`.
pub fn tension(ends: (usize, usize), rest_length: f64, stiffness: f64, damping: f64) -> SpringSpec {
    spring(SpringEffect::Tension, ends, rest_length, stiffness, damping)
}

/// Pins a particle where it starts.
pub fn pin(particle: usize) -> PinSpec {
    PinSpec::still(particle as u32)
}

/// The smooth plane `z = 0`, solid below.
pub fn floor(restitution: f64) -> ObstacleSpec {
    ObstacleSpec::plane([0.0; 3], [0.0, 0.0, 1.0], restitution)
}

/// A particle on springs (effect, rest length, stiffness, damping) to a pinned particle at the
/// origin.
///
/// Both have the mass `mass`; the free particle has index 1.
pub fn anchored(
    mass: f64,
    springs: &[(SpringEffect, f64, f64, f64)],
    x: Vec3,
    v: Vec3,
) -> SystemSpec {
    let mut spec = particles(&[mass; 2], &[Vec3::zeros(), x], &[Vec3::zeros(), v]);
    spec.pins = vec![pin(0)];
    spec.springs = springs.iter().map(|&(e, rest, k, c)| spring(e, (0, 1), rest, k, c)).collect();
    spec
}

/// Builds a frozen system.
///
/// # Panics
/// If the system is not valid.
pub fn build(spec: &SystemSpec) -> (System, State) {
    spec.build().unwrap_or_else(|violation| panic!("{violation}"))
}

/// Builds the system that a JSON text describes.
///
/// # Panics
/// If the text is not valid.
pub fn parse(text: &str) -> (System, State) {
    build(drape_model::parse("test", text).unwrap_or_else(|error| panic!("{error}")).spec())
}

/// A bundled scene as a frozen system.
///
/// # Panics
/// If no bundled scene has this name.
pub fn bundled(name: &str) -> SystemSpec {
    drape_model::load(name).unwrap_or_else(|error| panic!("{error}")).spec().clone()
}

/// A horizontal sheet of 1 m × 1 m around the origin; each particle has 1 g.
#[derive(Clone, Copy, Debug)]
pub struct Sheet {
    /// Particles along each edge.
    pub side: u32,
    /// Stiffness over mass of the tension springs, 1/s².
    pub tension: f64,
    /// Stiffness over mass of the shear springs, 1/s²; 0 for none.
    pub shear: f64,
    /// Damping over mass of the tension springs, 1/s; the shear springs have a tenth.
    pub damping: f64,
    /// How the damping acts.
    pub law: DampingLaw,
    /// Acceleration of gravity, m/s²; 0 for none.
    pub gravity: Vec3,
    /// Whether two corners of the first row are pinned.
    pub pinned: bool,
}

impl Default for Sheet {
    /// 25 particles, whose steps take almost no time.
    fn default() -> Self {
        Self {
            side: 5,
            tension: 2e3,
            shear: 300.0,
            damping: 3.0,
            law: DampingLaw::Full,
            gravity: GRAVITY,
            pinned: true,
        }
    }
}

impl Sheet {
    /// The sheet as a scene.
    pub fn scene(self) -> Scene {
        let law = |stiffness, damping| {
            (stiffness > 0.0).then(|| SpringLaw {
                stiffness_over_mass_per_s2: Some(stiffness),
                damping_over_mass_per_s: Some(damping),
                ..SpringLaw::default()
            })
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
                mass_kg: Some(1e-3 * f64::from(self.side * self.side)),
                rotation: None,
                velocity_m_s: [0.0; 3],
            }),
            material: None,
            effects: Effects {
                tension: law(self.tension, self.damping),
                shear: law(self.shear, 0.1 * self.damping),
                gravity: (self.gravity != Vec3::zeros())
                    .then(|| GravitySpec { m_s2: self.gravity.into() }),
                ..Effects::default()
            },
            damping: self.law,
            pins: if self.pinned { vec![corner(0), corner(self.side - 1)] } else { Vec::new() },
            obstacles: Vec::new(),
            time: TimeSpan { step_s: 0.01, duration_s: 1.0 },
        }
    }

    /// A sheet of 25 particles, in whose motion nothing is stiff.
    pub fn smooth(law: DampingLaw) -> Self {
        Self { tension: 400.0, shear: 100.0, damping: 2.0, law, ..Self::default() }
    }

    /// A sheet of 25 particles on which no pin and no external force acts.
    pub fn free() -> Self {
        Self { pinned: false, gravity: Vec3::zeros(), ..Self::default() }
    }

    /// A sheet of 400 particles on two pins, with this stiffness of the tension springs and a tenth
    /// of it in the shear springs.
    pub fn hanging(tension: f64, damping: f64) -> Self {
        Self { side: 20, tension, shear: 0.1 * tension, damping, ..Self::default() }
    }

    /// The frozen system.
    ///
    /// # Panics
    /// If the values give no valid scene.
    pub fn spec(self) -> SystemSpec {
        self.scene().discretise().unwrap_or_else(|violation| panic!("{violation}"))
    }

    /// The system at its start.
    ///
    /// # Panics
    /// If the values give no valid scene.
    pub fn build(self) -> (System, State) {
        build(&self.spec())
    }
}

/// Gives the free particles random velocities, up to `speed` m/s along each axis, and moves them up
/// to `height` m out of the plane.
pub fn stir((system, mut state): (System, State), height: f64, speed: f64) -> (System, State) {
    for i in (0..state.len()).filter(|&i| !system.pinned()[i]) {
        let a = i as f64;
        state.x[i].z += height * a.sin();
        state.v[i] = Vec3::new(a.sin(), (2.0 * a).cos(), (3.0 * a).sin()) * speed;
    }
    (system, state)
}

/// Stretches a [`Sheet`], lays a wave over it and gives it smooth velocities: a motion in which
/// nothing is stiff as long as no spring is.
pub fn waving((system, mut state): (System, State)) -> (System, State) {
    let corner = Vec3::new(-0.5, -0.5, 0.0);
    for i in (0..state.len()).filter(|&i| !system.pinned()[i]) {
        let from_corner = state.x[i] - corner;
        let (x, y) = (from_corner.x, from_corner.y);
        let wave = 0.02 * libm::sin(3.0 * y + 1.0);
        state.x[i] = corner + Vec3::new(1.03 * x, 0.98 * y, wave);
        state.v[i] = Vec3::new(libm::sin(2.0 * y), x, libm::cos(3.0 * x)) * 0.3;
    }
    (system, state)
}

/// Two particles of 1 kg on a spring of rest length 1 m that rotate about each other at 2 rad/s.
/// The spring has the length at which its tension balances the rotation. `theta` is `h²·2k/m`.
pub fn rotor(theta: f64, h: f64) -> (System, State) {
    let kappa = theta / (h * h);
    let length = kappa / (kappa - 4.0);
    let (x, v) = (Vec3::x() * (0.5 * length), Vec3::y() * length);
    let mut spec = particles(&[1.0; 2], &[-x, x], &[-v, v]);
    spec.springs = vec![tension((0, 1), 1.0, 0.5 * kappa, 0.0)];
    build(&spec)
}

/// A chain of two links of 0.3 m that hangs at rest: 0.5 kg a particle, springs of 10 kN/m.
pub fn resting_chain() -> (System, State) {
    let (k, m) = (1e4, 0.5);
    let hang = |below: f64| 0.3 + below * m * -GRAVITY.z / k;
    let depth = [0.0, hang(2.0), hang(2.0) + hang(1.0)];
    let mut spec = particles(&[m; 3], &depth.map(|z| Vec3::z() * -z), &[]);
    spec.pins = vec![pin(0)];
    spec.effects.gravity = gravity();
    spec.springs = (0..2).map(|i| tension((i, i + 1), 0.3, k, 1.0)).collect();
    build(&spec)
}

/// A particle between two pinned ones, on springs with `θ = 2h²k/m` whose rest length is `rest`
/// times their length. It is 1 nm off the line, so that it moves across the springs.
pub fn across(theta: f64, rest: f64, mass: f64, h: f64) -> (System, State) {
    let middle = Vec3::new(0.0, 1e-9, -0.5e-9);
    let velocity = [Vec3::zeros(), Vec3::zeros(), -middle];
    let mut spec = particles(&[mass; 3], &[-Vec3::x(), Vec3::x(), middle], &velocity);
    spec.pins = vec![pin(0), pin(1)];
    let k = 0.5 * theta * mass / (h * h);
    spec.springs = (0..2).map(|end| tension((end, 2), rest, k, 0.0)).collect();
    build(&spec)
}

/// Makes a sheet resist shear and bending by angles.
pub fn angular(mut scene: Scene) -> Scene {
    let law = |stiffness_n_m| Some(AngularLaw { stiffness_n_m });
    scene.effects.shear_angle = law(2e-3);
    scene.effects.bending_angle = law(2e-4);
    scene.effects.bending_hinge = law(2e-4);
    scene
}

/// An [angular] sheet in a steady wind with quadratic drag.
pub fn in_the_wind() -> (System, State) {
    let sheet = Sheet { side: 4, tension: 400.0, shear: 0.0, damping: 2.0, ..Sheet::default() };
    let mut scene = angular(sheet.scene());
    scene.effects.air = Some(AirSpec {
        drag: DragSpec::Quadratic { coefficient: 1.0, density_kg_m3: 0.1 },
        wind: Some(WindSpec { velocity_m_s: [1.0, 0.0, 3.0], gust: None }),
    });
    let spec = scene.discretise().unwrap_or_else(|violation| panic!("{violation}"));
    stir(build(&spec), 0.02, 0.2)
}

/// A soft sheet of nine particles in a wind that changes faster than the sheet moves: forces at a
/// wrong time within a step leave order 1.
pub fn in_a_gust() -> (System, State) {
    let sheet = Sheet { side: 3, tension: 100.0, shear: 25.0, damping: 2.0, ..Sheet::default() };
    let mut scene = sheet.scene();
    let gust = GustSpec { amplitude_m_s: [0.0, 1.0, 4.0], period_s: 0.5, seed: 3, start_s: 0.0 };
    scene.effects.air = Some(AirSpec {
        drag: DragSpec::Linear { coefficient_n_s_per_m3: 0.02 },
        wind: Some(WindSpec { velocity_m_s: [0.0; 3], gust: Some(gust) }),
    });
    let spec = scene.discretise().unwrap_or_else(|violation| panic!("{violation}"));
    stir(build(&spec), 0.02, 0.2)
}

/// Gives the particles masses of 1, 2, 3, 4 g in turn.
pub fn uneven((mut system, state): (System, State)) -> (System, State) {
    let mass: Vec<_> = (0..system.len()).map(|i| 1e-3 * (1 + i % 4) as f64).collect();
    assert!(system.set_mass(&mass), "one mass a particle");
    (system, state)
}

/// The same system with tension springs that are `ratio` times as stiff beyond a strain of 1 %.
pub fn stiffening(mut spec: SystemSpec, ratio: f64) -> SystemSpec {
    for spring in spec.springs.iter_mut().filter(|s| s.effect == SpringEffect::Tension) {
        let stiffness_n_per_m = spring.stiffness_n_per_m;
        let soft = PieceSpec { up_to_strain: Some(0.01), stiffness_n_per_m };
        let steep = ratio * stiffness_n_per_m;
        spring.pieces = [soft, PieceSpec { up_to_strain: None, stiffness_n_per_m: steep }].into();
    }
    spec
}
