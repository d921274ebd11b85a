//! The set-up of a pane: a scene with the knobs turned, and a method. It also says how to repeat
//! the run.

use crate::files::{self, Dropped, Files};
use crate::limits;
use drape_harness::methods::{Choice, MethodError};
use drape_harness::{
    HarnessError, bundled, with_damping_scaled, with_particles_a_side, with_stiffness,
};
use drape_model::{
    AirSpec, Cloth, DragSpec, GravitySpec, KeyframeSpec, PinSpec, Scene, SceneError, State,
    SystemSpec, TimeSpan, Vec3, Violation, WindSpec,
};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Step and duration for a frozen system, which states neither.
const SYSTEM_TIME: TimeSpan = TimeSpan { step_s: 0.01, duration_s: 2.0 };
/// The drag of a cloth in the wind where the scene has no air: the drag of a plate.
const DRAG: DragSpec = DragSpec::Quadratic { coefficient: 1.0, density_kg_m3: 1.2 };

/// The set-up of a pane, as the page asks for it. A knob without a value keeps the value of the
/// scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setup {
    /// Name of a bundled scene, or `file:` and the name of a file that the page was given.
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
    /// Magnitude of gravity, m/s². Gravity keeps its direction; in a scene without gravity it acts
    /// along `−z`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<f64>,
    /// Mean velocity of the air, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wind: Option<[f64; 3]>,
}

/// The source of a pane: a scene, or a frozen system, whose springs have no common `k/m`.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A scene.
    Scene(Box<Scene>),
    /// A frozen system.
    System(Box<SystemSpec>),
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

/// A checked set-up, with all that a run needs.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The method.
    pub choice: Choice,
    /// The discretised scene.
    pub spec: SystemSpec,
    /// Step and duration.
    pub time: TimeSpan,
    /// The part of the run before its start, where a person moved the cloth by hand or turned a
    /// knob during the run.
    pub past: Past,
    source: Source,
    name: Name,
}

/// The past of a run before its present start. A touch starts the run anew from its present state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Past {
    /// Simulated time, s.
    pub time: f64,
    /// Completed steps.
    pub steps: u64,
    /// The particle that is led now.
    led: Option<Led>,
    /// The last movement of the hand.
    hand: Option<Hand>,
    /// Whether a knob was turned during the run.
    is_turned: bool,
}

/// The cause of a new start from the state of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touch {
    /// A hand that moved the cloth.
    Hand,
    /// A knob that was turned.
    Knob,
}

/// A particle that is led by hand.
#[derive(Clone, Debug, PartialEq)]
struct Led {
    particle: u32,
    /// Whether it was pinned before. Then it rests where it is let go.
    was_pinned: bool,
}

/// The movement of a hand, from its grip on.
#[derive(Clone, Debug, PartialEq)]
struct Hand {
    /// The system when the particle was gripped, without the pin of the hand.
    start: Arc<SystemSpec>,
    /// Time and number of steps at the grip.
    time: f64,
    particle: u32,
    /// The path of the hand from there.
    path: Vec<KeyframeSpec>,
    /// Time from the grip until the particle was let go; `None` while it is led.
    let_go: Option<f64>,
}

/// How a set-up is named on the command line.
#[derive(Clone, Debug, PartialEq)]
enum Name {
    /// A bundled scene as it stands.
    Bundled(String),
    /// A file, which the command reads.
    File {
        /// Its name.
        file: String,
        /// The mesh that it reads from beside it.
        mesh: Option<String>,
    },
}

/// How to repeat the run of a pane.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Repeat {
    /// The command in one line, for a shell.
    pub command: String,
    /// Arguments of `drape`, without the name of the program.
    pub arguments: Vec<String>,
    /// Name of the file that the command reads; `None` for a bundled scene.
    pub file: Option<String>,
    /// Name of the mesh that must stand beside that file.
    pub mesh: Option<String>,
    /// The scene as JSON.
    pub scene: String,
    /// The parts of the run that the command leaves out, in sentences; empty if it leaves out none.
    pub note: String,
    /// The last movement of the hand, if the cloth was moved by hand.
    pub way: Option<Way>,
}

/// The movement of a hand as a separate scene: a pin on a path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Way {
    /// The command that makes the move.
    pub command: String,
    /// Arguments of `drape`, without the name of the program.
    pub arguments: Vec<String>,
    /// Name of the file that the command reads.
    pub file: String,
    /// The frozen system with the path, as JSON.
    pub scene: String,
}

pub(crate) fn refuse(path: &str, value: impl ToString, expected: impl Into<String>) -> Violation {
    Violation { path: path.to_owned(), value: value.to_string(), expected: expected.into() }
}

/// Returns the value of a knob, or refuses one outside its range.
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

/// Magnitude of gravity, m/s²; 0 without gravity.
pub(crate) fn gravity_of(source: &Source) -> f64 {
    let spec = match source {
        Source::Scene(scene) => scene.effects.gravity,
        Source::System(spec) => spec.effects.gravity,
    };
    spec.map_or(0.0, |gravity| Vec3::from(gravity.m_s2).norm())
}

/// Mean velocity of the air, m/s; 0 where the air rests or the scene has none.
pub(crate) fn wind_of(source: &Source) -> [f64; 3] {
    let air = match source {
        Source::Scene(scene) => scene.effects.air,
        Source::System(spec) => spec.effects.air,
    };
    air.and_then(|air| air.wind).map_or([0.0; 3], |wind| wind.velocity_m_s)
}

impl Source {
    /// The discretised system.
    ///
    /// # Errors
    /// [`Violation`] for the first value that is refused.
    pub fn spec(&self) -> Result<SystemSpec, Violation> {
        match self {
            Self::Scene(scene) => scene.discretise(),
            Self::System(spec) => Ok((**spec).clone()),
        }
    }

    /// Its usual step and duration.
    pub(crate) fn time(&self) -> TimeSpan {
        match self {
            Self::Scene(scene) => scene.time,
            Self::System(_) => SYSTEM_TIME,
        }
    }

    pub(crate) fn scene(&self) -> Option<&Scene> {
        match self {
            Self::Scene(scene) => Some(scene),
            Self::System(_) => None,
        }
    }

    fn json(&self) -> Result<String, serde_json::Error> {
        let text = match self {
            Self::Scene(scene) => serde_json::to_string_pretty(scene)?,
            Self::System(spec) => serde_json::to_string(spec)?,
        };
        Ok(text + "\n")
    }
}

/// A word of a command, quoted for a shell where that is needed.
fn shell(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./:=,+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// A command line of these arguments.
fn command(arguments: &[String]) -> String {
    arguments.iter().fold("drape".to_owned(), |line, word| line + " " + &shell(word))
}

/// A text that can be part of the name of a file.
fn tame(name: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_".contains(c) { c } else { '-' };
    let name: String = name.chars().take(60).map(plain).collect();
    let name = name.trim_matches('-').to_owned();
    if name.is_empty() { "scene".to_owned() } else { name }
}

/// A frozen system as one line of JSON.
fn line(spec: &SystemSpec) -> Result<String, serde_json::Error> {
    Ok(serde_json::to_string(spec)? + "\n")
}

impl Setup {
    /// Checks a set-up of a bundled scene and discretises it.
    ///
    /// # Errors
    /// [`SetupError`] for the first value that is refused.
    pub fn stage(&self) -> Result<Stage, SetupError> {
        self.stage_with(&Files::default())
    }

    /// The scene by its name, with the name of its mesh and whether the file is the scene.
    fn find(&self, files: &Files) -> Result<Arc<Dropped>, SetupError> {
        if let Some(name) = self.scene.strip_prefix(files::PREFIX) {
            let expected = "a file that this page was given: drop it here again";
            let found = format!("`{name}`");
            return Ok(files.get(name).ok_or_else(|| refuse("scene", found, expected))?.clone());
        }
        if !drape_model::bundled::names().any(|name| name == self.scene) {
            let known: Vec<_> = drape_model::bundled::names().collect();
            let expected = format!("one of {}", known.join(", "));
            return Err(refuse("scene", format!("`{}`", self.scene), expected).into());
        }
        let source = Source::Scene(Box::new(bundled(&self.scene)?));
        Ok(Arc::new(Dropped { source, mesh: None, is_scene: true, notes: Vec::new() }))
    }

    /// As [`stage`](Self::stage), for a page that was given `files`.
    ///
    /// # Errors
    /// [`SetupError`] for the first value that is refused.
    pub fn stage_with(&self, files: &Files) -> Result<Stage, SetupError> {
        if self.method.trim_start().starts_with("program:") {
            let expected = "the id of a method: the lab starts no program";
            return Err(refuse("method", format!("`{}`", self.method), expected).into());
        }
        let dropped = self.find(files)?;
        let original = &dropped.source;
        let choice = Choice::parse(&self.method, &[])?;
        let mut source = match original {
            Source::Scene(scene) => {
                let scene = self.turn_stiffness((**scene).clone())?;
                Source::Scene(Box::new(self.turn_particles(self.turn_damping(scene)?)?))
            }
            Source::System(spec) => {
                self.refuse_turns()?;
                Source::System(spec.clone())
            }
        };
        self.turn_gravity(&mut source)?;
        self.turn_wind(&mut source)?;
        let name = self.name(&dropped, source == *original);
        let usual = source.time();
        let step_s = within("step", self.step, limits::STEP_S)?.unwrap_or(usual.step_s);
        let duration_s =
            within("duration", self.duration, limits::DURATION_S)?.unwrap_or(usual.duration_s);
        let time = TimeSpan { step_s, duration_s };
        time.check("step", "duration")?;
        let (whole, _) = time.steps();
        if whole > limits::STEPS {
            let expected = format!("at most {} steps: a longer step", limits::STEPS);
            return Err(refuse("duration", format!("{whole} steps"), expected).into());
        }
        let spec = source.spec()?;
        files::check_count(spec.particles.mass_kg.len() as u64)?;
        Ok(Stage { choice, spec, time, past: Past::default(), source, name })
    }

    /// The name of the scene in the command. A scene with turned knobs is a separate file.
    fn name(&self, dropped: &Dropped, is_original: bool) -> Name {
        match self.scene.strip_prefix(files::PREFIX) {
            None if is_original => Name::Bundled(self.scene.clone()),
            None => Name::File { file: format!("{}.json", self.scene), mesh: None },
            Some(name) => {
                let stem = tame(name.rsplit_once('.').map_or(name, |(stem, _)| stem));
                let file = match (is_original, dropped.is_scene) {
                    (true, true) => name.to_owned(),
                    (true, false) => format!("{stem}.json"),
                    (false, _) => format!("{stem}-lab.json"),
                };
                Name::File { file, mesh: dropped.mesh.clone() }
            }
        }
    }

    /// Refuses the knobs that a frozen system does not have.
    fn refuse_turns(&self) -> Result<(), Violation> {
        let knobs = [
            ("stiffness", self.stiffness),
            ("damping", self.damping),
            ("particles", self.particles.map(f64::from)),
        ];
        match knobs.into_iter().find_map(|(key, value)| Some((key, value?))) {
            Some((key, value)) => {
                Err(refuse(key, value, "no value: a frozen system has its springs one by one"))
            }
            None => Ok(()),
        }
    }

    fn turn_gravity(&self, source: &mut Source) -> Result<(), Violation> {
        let Some(size) = within("gravity", self.gravity, limits::GRAVITY_M_S2)? else {
            return Ok(());
        };
        let old = gravity_of(source);
        if old == size {
            return Ok(());
        }
        let gravity = match source {
            Source::Scene(scene) => &mut scene.effects.gravity,
            Source::System(spec) => &mut spec.effects.gravity,
        };
        let direction = gravity.filter(|_| old > 0.0).map(|g| g.m_s2.map(|g| g / old));
        let direction = direction.unwrap_or([0.0, 0.0, -1.0]);
        // Adding 0 turns `−0`, which would be written differently, into 0.
        *gravity = Some(GravitySpec { m_s2: direction.map(|d| d * size + 0.0) });
        Ok(())
    }

    fn turn_wind(&self, source: &mut Source) -> Result<(), Violation> {
        let Some(velocity_m_s) = self.wind else { return Ok(()) };
        for (axis, component) in ["x", "y", "z"].iter().zip(velocity_m_s) {
            within(&format!("wind.{axis}"), Some(component), limits::WIND_M_S)?;
        }
        if wind_of(source) == velocity_m_s {
            return Ok(());
        }
        let air = match source {
            Source::Scene(scene) => &mut scene.effects.air,
            Source::System(spec) => &mut spec.effects.air,
        };
        let old = air.unwrap_or(AirSpec { drag: DRAG, wind: None });
        let gust = old.wind.and_then(|wind| wind.gust);
        *air = Some(AirSpec { wind: Some(WindSpec { velocity_m_s, gust }), ..old });
        Ok(())
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
            // Scaling could round: the quotient of two numbers times the second need not be the
            // first.
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
    /// The first part of the names of the files of this stage, without an ending.
    fn stem(&self) -> String {
        let name = match &self.name {
            Name::Bundled(name) => name,
            Name::File { file, .. } => file.strip_suffix(".json").unwrap_or(file),
        };
        tame(name)
    }

    /// The arguments of `drape run` for a scene and a duration, s.
    fn arguments(&self, scene: String, duration_s: f64) -> Vec<String> {
        vec![
            "run".to_owned(),
            scene,
            "--method".to_owned(),
            self.choice.full_id(),
            "--dt".to_owned(),
            self.time.step_s.to_string(),
            "--duration".to_owned(),
            duration_s.to_string(),
        ]
    }

    /// How to repeat the run until the end of step `step` after its present start. With 0, or with
    /// the last step, the command repeats all of the run.
    ///
    /// # Errors
    /// [`serde_json::Error`] if the scene cannot be written as JSON.
    pub fn repeat(&self, step: u64) -> Result<Repeat, serde_json::Error> {
        let (whole, rest) = self.time.steps();
        let is_part = 0 < step && step < whole + u64::from(rest.is_some());
        let duration = if is_part { step as f64 * self.time.step_s } else { self.time.duration_s };
        let is_touched = self.is_touched();
        let (file, mesh, scene) = match &self.name {
            _ if is_touched => {
                let file = format!("{}-from-step-{}.json", self.stem(), self.past.steps);
                (Some(file), None, line(&self.spec)?)
            }
            Name::Bundled(_) => (None, None, self.source.json()?),
            Name::File { file, mesh } => (Some(file.clone()), mesh.clone(), self.source.json()?),
        };
        let named = match (&file, &self.name) {
            (Some(file), _) | (None, Name::File { file, .. }) => file.clone(),
            (None, Name::Bundled(name)) => name.clone(),
        };
        let arguments = self.arguments(named, duration);
        let note = self.touch().map_or_else(String::new, |touch| {
            let (what, when) = match touch {
                Touch::Hand => ("This cloth was moved by hand", "the hand last acted"),
                Touch::Knob => ("A knob was turned on the way", "it was last turned"),
            };
            format!(
                "{what}. The file holds the state at t = {:.4} s, where {when}, and the command \
                 repeats what came after, bit for bit. What came before is not in it.",
                self.past.time
            )
        });
        let way = self.past.hand.as_ref().map(|hand| self.way(hand)).transpose()?;
        let command = command(&arguments);
        Ok(Repeat { command, arguments, file, mesh, scene, note, way })
    }

    /// The movement of a hand as a scene with a pin on a path.
    fn way(&self, hand: &Hand) -> Result<Way, serde_json::Error> {
        let mut spec = (*hand.start).clone();
        let (particle, path) = (hand.particle, hand.path.clone());
        spec.pins.push(PinSpec { particle, path });
        let end = hand.path.last().map_or(self.time.step_s, |frame| frame.time_s);
        let file = format!("{}-by-hand.json", self.stem());
        let arguments = self.arguments(file.clone(), hand.let_go.unwrap_or(end));
        let command = command(&arguments);
        Ok(Way { command, arguments, file, scene: line(&spec)? })
    }

    /// The stage that begins where this one is after `steps` steps, in `state`, with a particle
    /// led to a place, m, within `leg` seconds.
    ///
    /// # Errors
    /// [`Violation`] where the particle or the place is refused, or where no time is left.
    pub fn led(
        &self,
        state: &State,
        steps: u64,
        particle: u32,
        to: [f64; 3],
        leg: f64,
    ) -> Result<Self, Violation> {
        let count = state.len();
        let Some(&from) = state.x.get(particle as usize) else {
            let expected = format!("a whole number from 0 to {}", count - 1);
            return Err(refuse("particle", particle, expected));
        };
        let mut stage = self.at_rest_of(state, steps)?;
        let was_led = self.past.led.as_ref().filter(|led| led.particle == particle);
        let was_pinned = match was_led {
            Some(led) => led.was_pinned,
            None => stage.spec.pins.iter().any(|pin| pin.particle == particle),
        };
        stage.spec.pins.retain(|pin| pin.particle != particle);
        let past = &mut stage.past;
        if was_led.is_none() {
            let (start, time) = (Arc::new(stage.spec.clone()), past.time);
            past.hand = Some(Hand { start, time, particle, path: Vec::new(), let_go: None });
        }
        past.led = Some(Led { particle, was_pinned });
        let offset = Vec3::from(to) - from;
        if let Some(hand) = &mut past.hand {
            let since = past.time - hand.time;
            let start = Vec3::from(hand.start.particles.position_m[particle as usize]);
            hand.pass(since, from - start);
            hand.path.push(KeyframeSpec {
                time_s: since + leg,
                offset_m: (Vec3::from(to) - start).into(),
            });
        }
        let path = vec![KeyframeSpec { time_s: leg, offset_m: offset.into() }];
        stage.spec.pins.push(PinSpec { particle, path });
        Ok(stage)
    }

    /// The stage that begins where this one is after `steps` steps, in `state`, and lets go of the
    /// led particle. A particle that was pinned before rests where it is.
    ///
    /// # Errors
    /// [`Violation`] if no time is left.
    pub fn let_go(&self, state: &State, steps: u64) -> Result<Self, Violation> {
        let mut stage = self.at_rest_of(state, steps)?;
        let past = &mut stage.past;
        let Some(led) = past.led.take() else { return Ok(stage) };
        stage.spec.pins.retain(|pin| pin.particle != led.particle);
        if led.was_pinned {
            stage.spec.pins.push(PinSpec::still(led.particle));
        }
        if let (Some(hand), Some(&place)) = (&mut past.hand, state.x.get(led.particle as usize)) {
            let since = past.time - hand.time;
            let start = Vec3::from(hand.start.particles.position_m[led.particle as usize]);
            hand.pass(since, place - start);
            hand.let_go = Some(since);
        }
        Ok(stage)
    }

    /// The touch that started this run from the state of another, if one did.
    pub fn touch(&self) -> Option<Touch> {
        match self.past {
            Past { hand: Some(_), .. } => Some(Touch::Hand),
            Past { is_turned: true, .. } => Some(Touch::Knob),
            Past { .. } => None,
        }
    }

    /// Whether a touch started this run from the state of another.
    pub fn is_touched(&self) -> bool {
        self.touch().is_some()
    }

    /// Whether a particle is led.
    pub fn is_led(&self) -> bool {
        self.past.led.is_some()
    }

    /// This stage for a cloth that goes on from the stage `before`, where it is in `state` after
    /// `steps` steps. A hand that leads a particle there lets go.
    ///
    /// # Errors
    /// [`Violation`] if the number of particles differs, or if no time is left.
    pub fn going_on(self, before: &Self, state: &State, steps: u64) -> Result<Self, Violation> {
        let count = self.spec.particles.mass_kg.len();
        if state.len() != count {
            return Err(refuse("particles", state.len(), format!("{count}: press Restart")));
        }
        let past = before.past_until("knob", state, steps)?;
        let left = self.time.duration_s - past.time;
        if left <= 0.0 {
            let expected = format!("more than {} s, which are over: press Restart", past.time);
            return Err(refuse("duration", self.time.duration_s, expected));
        }
        let past = Past { led: None, hand: None, is_turned: true, ..past };
        // Paths and gusts of this stage count from time 0.
        let now = State { t: past.time, ..state.clone() };
        let time = TimeSpan { duration_s: left, ..self.time };
        Ok(Self { spec: self.spec.with_state(&now), time, past, ..self })
    }

    /// The past of a run that goes on from this one after `steps` steps, in `state`.
    fn past_until(&self, by: &str, state: &State, steps: u64) -> Result<Past, Violation> {
        let (whole, rest) = self.time.steps();
        let is_over = steps >= whole + u64::from(rest.is_some());
        if is_over || !state.is_finite() {
            let expected = "a run that goes on: press Restart";
            return Err(refuse(by, "on a cloth whose run is over", expected));
        }
        Ok(Past {
            time: self.past.time + state.t,
            steps: self.past.steps + steps,
            ..self.past.clone()
        })
    }

    /// The rest of the run, frozen in `state` after `steps` steps.
    fn at_rest_of(&self, state: &State, steps: u64) -> Result<Self, Violation> {
        let past = self.past_until("hand", state, steps)?;
        let (whole, rest) = self.time.steps();
        let left = whole.saturating_sub(steps) as f64 * self.time.step_s + rest.unwrap_or(0.0);
        Ok(Self {
            choice: self.choice.clone(),
            spec: self.spec.clone().with_state(state),
            time: TimeSpan { duration_s: left, ..self.time },
            past,
            source: self.source.clone(),
            name: self.name.clone(),
        })
    }
}

impl Hand {
    /// Notes the offset of the particle `since` seconds after the grip. Drops any plan for later.
    fn pass(&mut self, since: f64, offset: Vec3) {
        self.path.retain(|frame| frame.time_s < since);
        if since > 0.0 {
            self.path.push(KeyframeSpec { time_s: since, offset_m: offset.into() });
        }
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
            ..Setup::default()
        };
        change(&mut setup);
        setup
    }

    #[test]
    fn knobs_turn_what_they_name_and_nothing_else() {
        let plain = setup(|_| ()).stage().unwrap();
        assert_eq!(plain.name, Name::Bundled("hanging-textile-1e6".to_owned()));
        let turned = setup(|s| {
            s.stiffness = Some(3e5);
            s.damping = Some(7.1);
            s.particles = Some(11);
            s.step = Some(0.02);
        });
        let turned = turned.stage().unwrap();
        assert!(matches!(turned.name, Name::File { .. }));
        let scene = turned.source.scene().unwrap();
        assert_eq!(stiffness_of(scene), Some(3e5));
        assert_eq!(damping_of(scene), Some(7.1));
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
