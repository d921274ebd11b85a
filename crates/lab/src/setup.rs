//! What a pane shows: a scene with the knobs turned, and a method. It also tells how to repeat it.

use crate::limits;
use drape_harness::methods::{Choice, MethodError};
use drape_harness::{
    HarnessError, bundled, with_damping_scaled, with_particles_a_side, with_stiffness,
};
use drape_model::{Cloth, Scene, SceneError, SystemSpec, TimeSpan, Violation};
use serde::{Deserialize, Serialize};

/// What a pane shows, as the page asks for it. A knob that is not given stands where the scene has
/// it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setup {
    /// Name of a bundled scene.
    pub scene: String,
    /// Id of a method, with settings after a colon.
    pub method: String,
    /// Stiffness of the tension springs over the mass of a particle, 1/s².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Damping of the tension springs over the mass of a particle, 1/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Time step, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
    /// Simulated time, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration: Option<f64>,
    /// Particles along each side of a square grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub particles: Option<u32>,
}

/// Why a set-up was refused. The message is for the person at the page.
#[derive(Debug, thiserror::Error)]
pub enum SetupError {
    /// A value was refused.
    #[error(transparent)]
    Violation(#[from] Violation),
    /// The scene was refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The method was refused.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// The run was refused.
    #[error(transparent)]
    Harness(#[from] HarnessError),
}

/// A checked set-up: all that a run needs.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The method.
    pub choice: Choice,
    /// The discretised scene.
    pub spec: SystemSpec,
    /// Step and duration.
    pub time: TimeSpan,
    scene: Scene,
    /// The bundled scene, if no knob that changes it was turned.
    name: Option<String>,
}

/// How to repeat what a pane shows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Repeat {
    /// The command in one line, for a shell.
    pub command: String,
    /// Arguments of `drape`, the name of the command left out.
    pub arguments: Vec<String>,
    /// Name of the file that the command reads; `None` for a bundled scene.
    pub file: Option<String>,
    /// The scene as JSON.
    pub scene: String,
}

fn refuse(path: &str, value: impl ToString, expected: impl Into<String>) -> Violation {
    Violation { path: path.to_owned(), value: value.to_string(), expected: expected.into() }
}

/// A value of a knob, if it is in its range.
fn within(
    path: &str,
    value: Option<f64>,
    (least, most): (f64, f64),
) -> Result<Option<f64>, Violation> {
    match value {
        Some(value) if !(least..=most).contains(&value) => {
            Err(refuse(path, value, format!("a number from {least:e} to {most:e}")))
        }
        value => Ok(value),
    }
}

/// Damping of the tension springs over the mass of a particle, 1/s.
pub(crate) fn damping_of(scene: &Scene) -> Option<f64> {
    scene.effects.tension.as_ref()?.damping_over_mass_per_s
}

/// Stiffness of the tension springs over the mass of a particle, 1/s².
pub(crate) fn stiffness_of(scene: &Scene) -> Option<f64> {
    scene.effects.tension.as_ref()?.stiffness_over_mass_per_s2
}

/// Particles along each side of a square grid.
pub(crate) fn side_of(scene: &Scene) -> Option<u32> {
    match scene.cloth {
        Cloth::Grid(grid) if grid.rows == grid.columns => Some(grid.rows),
        _ => None,
    }
}

impl Setup {
    /// Checks the set-up and discretises its scene.
    ///
    /// # Errors
    /// The first value that is refused.
    pub fn stage(&self) -> Result<Stage, SetupError> {
        if self.method.trim_start().starts_with("program:") {
            let expected = "the id of a method: the lab starts no program";
            return Err(refuse("method", format!("`{}`", self.method), expected).into());
        }
        if !drape_model::bundled::names().any(|name| name == self.scene) {
            let known: Vec<_> = drape_model::bundled::names().collect();
            let expected = format!("one of {}", known.join(", "));
            return Err(refuse("scene", format!("`{}`", self.scene), expected).into());
        }
        let choice = Choice::parse(&self.method, &[])?;
        let original = bundled(&self.scene)?;
        let mut scene = self.turn_stiffness(original.clone())?;
        scene = self.turn_damping(scene)?;
        scene = self.turn_particles(scene)?;
        let name = (scene == original).then(|| self.scene.clone());
        let step_s = within("step", self.step, limits::STEP_S)?.unwrap_or(scene.time.step_s);
        let duration_s =
            within("duration", self.duration, limits::DURATION_S)?.unwrap_or(scene.time.duration_s);
        let time = TimeSpan { step_s, duration_s };
        time.check("step", "duration")?;
        let (whole, _) = time.steps();
        if whole > limits::STEPS {
            let expected = format!("at most {} steps: a longer step", limits::STEPS);
            return Err(refuse("duration", format!("{whole} steps"), expected).into());
        }
        let spec = scene.discretise()?;
        let found = spec.particles.mass_kg.len();
        if found > limits::PARTICLES {
            let expected = format!("at most {} particles", limits::PARTICLES);
            return Err(refuse("scene", format!("{found} particles"), expected).into());
        }
        Ok(Stage { choice, spec, time, scene, name })
    }

    fn turn_stiffness(&self, scene: Scene) -> Result<Scene, Violation> {
        let Some(value) = within("stiffness", self.stiffness, limits::STIFFNESS_PER_S2)? else {
            return Ok(scene);
        };
        match stiffness_of(&scene) {
            Some(old) if old == value => Ok(scene),
            Some(_) => Ok(with_stiffness(scene, value)),
            None => Err(refuse("stiffness", value, "no value: this scene states no k/m")),
        }
    }

    fn turn_damping(&self, scene: Scene) -> Result<Scene, Violation> {
        let Some(value) = within("damping", self.damping, limits::DAMPING_PER_S)? else {
            return Ok(scene);
        };
        let mut scene = match damping_of(&scene) {
            Some(old) if old == value => return Ok(scene),
            Some(old) if old > 0.0 => with_damping_scaled(scene, value / old),
            _ => scene,
        };
        match &mut scene.effects.tension {
            // The quotient of two numbers, times the second, need not be the first.
            Some(tension) if tension.stiffness_over_mass_per_s2.is_some() => {
                tension.damping_over_mass_per_s = Some(value);
                Ok(scene)
            }
            _ => Err(refuse("damping", value, "no value: this scene states no k/m")),
        }
    }

    fn turn_particles(&self, scene: Scene) -> Result<Scene, Violation> {
        let Some(value) = self.particles else { return Ok(scene) };
        let (least, most) = limits::SIDE;
        if !(least..=most).contains(&value) {
            let expected = format!("a whole number from {least} to {most}");
            return Err(refuse("particles", value, expected));
        }
        match side_of(&scene) {
            Some(old) if old == value => Ok(scene),
            Some(_) => Ok(with_particles_a_side(scene, value)),
            None => Err(refuse("particles", value, "no value: this cloth is no square grid")),
        }
    }
}

impl Stage {
    /// How to repeat the run until the end of step `step`; of its last step, or 0, for all of it.
    ///
    /// # Errors
    /// If the scene cannot be written as JSON.
    pub fn repeat(&self, step: u64) -> Result<Repeat, serde_json::Error> {
        let (whole, rest) = self.time.steps();
        let is_part = 0 < step && step < whole + u64::from(rest.is_some());
        let duration = if is_part { step as f64 * self.time.step_s } else { self.time.duration_s };
        let file = self.name.is_none().then(|| format!("{}.json", self.scene.name));
        let named = file.as_ref().or(self.name.as_ref()).cloned().unwrap_or_default();
        let arguments = vec![
            "run".to_owned(),
            named,
            "--method".to_owned(),
            self.choice.full_id(),
            "--dt".to_owned(),
            self.time.step_s.to_string(),
            "--duration".to_owned(),
            duration.to_string(),
        ];
        let command = format!("drape {}", arguments.join(" "));
        let scene = serde_json::to_string_pretty(&self.scene)? + "\n";
        Ok(Repeat { command, arguments, file, scene })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    fn setup(change: impl FnOnce(&mut Setup)) -> Setup {
        let mut setup = Setup {
            scene: "hanging-textile-1e6".to_owned(),
            method: "imex-euler".to_owned(),
            stiffness: None,
            damping: None,
            step: None,
            duration: None,
            particles: None,
        };
        change(&mut setup);
        setup
    }

    #[test]
    fn knobs_turn_what_they_name_and_nothing_else() {
        let plain = setup(|_| ()).stage().unwrap();
        assert_eq!(plain.name.as_deref(), Some("hanging-textile-1e6"));
        let turned = setup(|s| {
            s.stiffness = Some(3e5);
            s.damping = Some(7.1);
            s.particles = Some(11);
            s.step = Some(0.02);
        });
        let turned = turned.stage().unwrap();
        assert_eq!(turned.name, None);
        assert_eq!(stiffness_of(&turned.scene), Some(3e5));
        assert_eq!(damping_of(&turned.scene), Some(7.1));
        assert_eq!(turned.spec.particles.mass_kg.len(), 121);
        assert_eq!(turned.spec.pins.iter().map(|pin| pin.particle).collect::<Vec<_>>(), [0, 10]);
        assert_eq!(turned.time, TimeSpan { step_s: 0.02, ..plain.time });
        let same =
            setup(|s| (s.stiffness, s.damping, s.particles) = (Some(1e6), Some(40.0), Some(20)));
        assert_eq!(same.stage().unwrap().name, plain.name);
    }

    #[test]
    fn what_is_refused_names_the_knob_and_what_is_allowed() {
        type Change = fn(&mut Setup);
        let cases: [(Change, &str); 10] = [
            (|s| s.scene = "/etc/passwd".to_owned(), "scene"),
            (|s| s.method = "program:touch x".to_owned(), "starts no program"),
            (|s| s.method = "magic".to_owned(), "expected one of"),
            (|s| s.stiffness = Some(-1.0), "stiffness"),
            (|s| s.damping = Some(f64::INFINITY), "damping"),
            (|s| s.step = Some(0.0), "step"),
            (|s| s.duration = Some(1e9), "duration"),
            (|s| (s.step, s.duration) = (Some(1e-6), Some(3600.0)), "steps"),
            (|s| s.particles = Some(101), "particles"),
            (|s| (s.scene, s.stiffness) = ("hanging-wool".to_owned(), Some(1.0)), "no k/m"),
        ];
        for (change, named) in cases {
            let error = setup(change).stage().unwrap_err().to_string();
            assert!(error.contains(named), "{named}: {error}");
        }
    }

    #[test]
    fn a_part_of_a_run_is_repeated_by_its_number_of_steps() {
        let stage = setup(|s| s.step = Some(0.01)).stage().unwrap();
        for step in 1..100 {
            let repeat = stage.repeat(step).unwrap();
            let duration_s: f64 = repeat.arguments.last().unwrap().parse().unwrap();
            let time = TimeSpan { step_s: 0.01, duration_s };
            assert_eq!(time.steps(), (step, None));
            assert_eq!(repeat.file, None);
        }
        assert_eq!(stage.repeat(0).unwrap().arguments.last().unwrap(), "1");
    }
}
