//! Builds a running system from a frozen one and checks every value.

use crate::bounds::{MAX_COORDINATE, MAX_PARTICLES, index, mass, vector, within};
use crate::effects::{self, Checked};
use crate::error::Violation;
use crate::numbering::Strands;
use crate::path::Extent;
use crate::spec::{MAX_CONTACTS, MAX_OBSTACLES, SYSTEM_FORMAT};
use crate::{
    ContactSpec, MovingPin, Numbering, Obstacle, ParticlesSpec, Path, State, System, SystemSpec,
    Vec3,
};

impl ParticlesSpec {
    /// Checks all values; returns positions and velocities.
    fn check(&self) -> Result<(Vec<Vec3>, Vec<Vec3>), Violation> {
        let n = self.mass_kg.len();
        if n == 0 || n > MAX_PARTICLES {
            let expected = format!("1 to {MAX_PARTICLES} particles");
            return Err(Violation::new("particles.mass_kg", format!("of length {n}"), expected));
        }
        let vectors = |key: &str, list: &[[f64; 3]]| {
            if list.len() != n {
                let found = format!("of length {}", list.len());
                let expected = format!("length {n}, as `particles.mass_kg`");
                return Err(Violation::new(format!("particles.{key}"), found, expected));
            }
            let list = list.iter().enumerate();
            list.map(|(i, &value)| vector(format_args!("particles.{key}[{i}]"), value)).collect()
        };
        for (i, &value) in self.mass_kg.iter().enumerate() {
            mass(format_args!("particles.mass_kg[{i}]"), value)?;
        }
        let x = vectors("position_m", &self.position_m)?;
        let v = match self.velocity_m_s.as_slice() {
            [] => vec![Vec3::zeros(); n],
            list => vectors("velocity_m_s", list)?,
        };
        Ok((x, v))
    }

    /// Mean mass of a particle, kg.
    pub(crate) fn mean_mass(&self) -> f64 {
        self.mass_kg.iter().sum::<f64>() / self.mass_kg.len() as f64
    }
}

/// The parts of a system, checked.
struct Parts {
    mass: Vec<f64>,
    state: State,
    effects: Vec<Box<dyn Checked>>,
    pinned: Vec<bool>,
    moving_pins: Vec<MovingPin>,
    obstacles: Vec<Obstacle>,
    contact: ContactSpec,
}

impl Parts {
    fn renumber(&mut self, numbering: &Numbering) {
        self.mass = numbering.apply(&self.mass);
        self.pinned = numbering.apply(&self.pinned);
        self.state.x = numbering.apply(&self.state.x);
        self.state.v = numbering.apply(&self.state.v);
        for effect in &mut self.effects {
            effect.visit_particles(&mut |i| *i = numbering.internal(*i as usize) as u32);
        }
        for pin in &mut self.moving_pins {
            pin.particle = numbering.internal(pin.particle);
        }
    }
}

impl SystemSpec {
    /// Checks every value and builds the system with its start state at `t = 0`. The order of
    /// particles and springs is kept.
    ///
    /// # Errors
    /// The first [`Violation`]: the path of the key, its value, and the expected values.
    pub fn build(&self) -> Result<(System, State), Violation> {
        Ok(self.assemble(self.parts()?))
    }

    /// As [`build`](Self::build), but reorders particles and springs for the cache if the given
    /// order makes poor use of it. [`Numbering`] states the rule.
    ///
    /// Forces are then summed in another order, so results differ by round-off from those of
    /// [`build`](Self::build). They differ by more for a method that visits the springs one after
    /// another.
    ///
    /// # Errors
    /// As [`build`](Self::build), with the same paths.
    ///
    /// ```
    /// let input = drape_model::load("hanging-textile-1e4")?;
    /// let (_, state, numbering) = input.spec().build_ordered().expect("bundled scenes are valid");
    /// assert!(numbering.is_identity(), "a grid row by row stays as it is");
    /// assert_eq!(numbering.restore(&state).x, state.x);
    /// # Ok::<(), drape_model::SceneError>(())
    /// ```
    pub fn build_ordered(&self) -> Result<(System, State, Numbering), Violation> {
        let mut parts = self.parts()?;
        let strands = parts.effects.iter_mut().filter_map(|effect| effect.springs());
        let mut strands: Vec<Strands<'_>> = strands.collect();
        let numbering = Numbering::choose(parts.mass.len(), &mut strands);
        if !numbering.is_identity() {
            parts.renumber(&numbering);
        }
        let (system, state) = self.assemble(parts);
        Ok((system, state, numbering))
    }

    /// Checks every value.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub(crate) fn check(&self) -> Result<(), Violation> {
        self.parts().map(drop)
    }

    /// Checks particles and triangles; returns positions and velocities.
    pub(crate) fn check_cloth(&self) -> Result<(Vec<Vec3>, Vec<Vec3>), Violation> {
        let places = self.particles.check()?;
        for (position, triangle) in self.triangles.iter().enumerate() {
            for (corner, &particle) in triangle.iter().enumerate() {
                let path = format_args!("triangles[{position}][{corner}]");
                index(path, particle, places.0.len())?;
            }
        }
        Ok(places)
    }

    fn parts(&self) -> Result<Parts, Violation> {
        if self.format != SYSTEM_FORMAT {
            let found = format!("{:?}", self.format);
            return Err(Violation::new("format", found, format!("{SYSTEM_FORMAT:?}")));
        }
        let (x, v) = self.check_cloth()?;
        let effects = effects::check(self)?;
        let (pinned, moving_pins) = self.pinned(&x)?;
        self.check_contacts(x.len())?;
        let obstacles = self.obstacles.iter().enumerate().map(|(i, spec)| spec.check(i));
        let obstacles = obstacles.collect::<Result<Vec<_>, _>>()?;
        let contact = self.effects.contact.unwrap_or_default();
        let limit = contact.recovery_speed_limit_m_s;
        within("effects.contact.recovery_speed_limit_m_s", limit, 0.0, MAX_COORDINATE)?;
        let (mass, state) = (self.particles.mass_kg.clone(), State { t: 0.0, x, v });
        Ok(Parts { mass, state, effects, pinned, moving_pins, obstacles, contact })
    }

    /// Checks that contacts of all particles with all obstacles fit into memory.
    fn check_contacts(&self, particles: usize) -> Result<(), Violation> {
        let obstacles = self.obstacles.len();
        let most = MAX_OBSTACLES.min(MAX_CONTACTS / particles);
        if obstacles <= most {
            return Ok(());
        }
        let found = format!("of length {obstacles}, for {particles} particles");
        let expected = format!(
            "at most {most}: {MAX_OBSTACLES} obstacles, and {MAX_CONTACTS} pairs of a particle \
             and an obstacle"
        );
        Err(Violation::new("obstacles", found, expected))
    }

    /// Which of the particles at `x` are pinned, and the pins that follow paths.
    fn pinned(&self, x: &[Vec3]) -> Result<(Vec<bool>, Vec<MovingPin>), Violation> {
        let (mut pinned, mut moving) = (vec![false; x.len()], Vec::<MovingPin>::new());
        for (position, pin) in self.pins.iter().enumerate() {
            let at = format!("pins[{position}]");
            let particle = index(format_args!("{at}.particle"), pin.particle, x.len())?;
            let led = Extent::of([x[particle]]);
            let path = Path::check(&format!("{at}.path"), &pin.path, led)?;
            let was_pinned = std::mem::replace(&mut pinned[particle], true);
            let has_path = |other: &MovingPin| other.particle == particle;
            if was_pinned && (path.is_some() || moving.iter().any(has_path)) {
                let expected = "each particle once where a pin has a path";
                return Err(Violation::new(format!("{at}.particle"), pin.particle, expected));
            }
            moving.extend(path.map(|path| MovingPin { particle, start: x[particle], path }));
        }
        Ok((pinned, moving))
    }

    fn assemble(&self, parts: Parts) -> (System, State) {
        let effects = parts.effects.into_iter().map(Checked::assemble).collect();
        let pins = (parts.pinned, parts.moving_pins);
        let (obstacles, contact) = (parts.obstacles, parts.contact);
        let system = System::new(self.name.clone(), parts.mass, effects, pins, obstacles, contact);
        (system, parts.state)
    }
}
