//! The messages between the page and the server: JSON in both directions, binary frames with
//! positions to the page, and binary messages with files from it.

use crate::engine::{Numbers, Opinion, Phase, Scenery};
use crate::files::{Dropped, PREFIX};
use crate::lessons::{Listed, Told};
use crate::limits;
use crate::setup::{Repeat, Setup, Source, damping_of, gravity_of, side_of, stiffness_of, wind_of};
use drape_harness::{bundled, lessons, methods, presets};
use drape_integrator::Kind;
use serde::{Deserialize, Serialize};

/// A request of the page.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// Show these panes.
    Open {
        /// Their set-ups.
        panes: Vec<Setup>,
        /// Whether the panes go on from their present states, if all of them can. Otherwise they
        /// begin at time 0.
        #[serde(default)]
        keep: bool,
    },
    /// Let time pass.
    Play {},
    /// Stop time.
    Pause {},
    /// Let every pane take a step.
    Step {},
    /// Begin again at time 0.
    Restart {},
    /// Set how fast time passes.
    Rate {
        /// Simulated seconds per second.
        rate: f64,
    },
    /// Set whether fast panes wait for slow ones.
    Wait {
        /// Whether they wait.
        wait: bool,
    },
    /// Tell how to repeat a pane.
    Repeat {
        /// Number of the pane, from 0.
        pane: usize,
    },
    /// All lessons.
    Lessons {},
    /// A lesson.
    Lesson {
        /// Id of its method.
        id: String,
    },
    /// Mark an answer.
    Answer {
        /// Id of the method of the lesson.
        lesson: String,
        /// The answer, in the unit of the question.
        value: f64,
    },
    /// Lead a particle of all panes by hand.
    Lead {
        /// Its index.
        particle: u32,
        /// Its displacement since it was gripped, m.
        by: [f64; 3],
    },
    /// Let go of the particle.
    LetGo {},
    /// Set whether a reference solution is laid over the panes.
    Ghost {
        /// Whether it is laid over them.
        on: bool,
    },
}

/// A message of the server.
#[derive(Debug, Serialize)]
#[serde(tag = "tell", rename_all = "snake_case")]
pub enum Reply<'a> {
    /// The first message: the scenes, methods and ranges from which the page can choose.
    Hello {
        /// Version of drape.
        version: &'a str,
        /// Bundled scenes.
        scenes: Vec<SceneChoice>,
        /// All methods.
        methods: Vec<MethodChoice>,
        /// Ranges of the knobs.
        limits: Limits,
    },
    /// The scene to draw in a pane.
    Scenery {
        /// Number of the pane.
        pane: usize,
        /// Number of the run; each start of a pane has a new one.
        run: u32,
        /// Particles.
        particles: usize,
        /// Lowest and highest coordinates of the particles at the start, m.
        extent: [[f32; 3]; 2],
        /// Corners of triangles, three by three.
        triangles: Vec<u32>,
        /// Ends of lines, two by two.
        lines: Vec<u32>,
        /// Pinned particles.
        pins: Vec<u32>,
        /// Obstacles.
        solids: Vec<Solid>,
        /// Step, s.
        step: f64,
        /// Duration, s.
        duration: f64,
        /// The method with all settings.
        method: String,
    },
    /// The status of a pane.
    Status {
        /// Number of the pane.
        pane: usize,
        /// Number of the run.
        run: u32,
        /// Its progress.
        phase: &'a Phase,
        /// Its numbers.
        numbers: &'a Numbers,
        /// The verdict so far.
        verdict: Option<&'a Opinion>,
        /// Its delay behind the clock of the session, s.
        behind: f64,
        /// Root mean square distance of the particles from the reference solution, m.
        distance: Option<f64>,
        /// Why there is no reference solution, if one was asked for.
        ghost: Option<String>,
    },
    /// The clock of the session.
    Clock {
        /// Time, s.
        time: f64,
        /// Whether the clock runs.
        playing: bool,
        /// Simulated seconds in a second.
        rate: f64,
        /// Whether fast panes wait for slow ones.
        wait: bool,
    },
    /// How to repeat a pane.
    Repeat {
        /// Number of the pane.
        pane: usize,
        /// The command and its files.
        repeat: Box<Repeat>,
    },
    /// A file was taken.
    Dropped {
        /// Its scene; the name begins with `file:`.
        scene: SceneChoice,
        /// The repairs and assumptions, in sentences.
        notes: &'a [String],
    },
    /// All lessons.
    Lessons {
        /// In the order of the registry.
        lessons: Vec<Listed>,
    },
    /// A lesson.
    Lesson {
        /// The lesson.
        lesson: Box<Told>,
    },
    /// The mark for an answer.
    Marked {
        /// Id of the method of the lesson.
        lesson: &'static str,
        /// Whether the answer is right.
        right: bool,
        /// The sentence to show.
        sentence: String,
    },
    /// A request was refused.
    Refused {
        /// Why.
        sentence: String,
    },
}

/// An obstacle as a surface.
#[derive(Debug, Serialize)]
pub struct Solid {
    points: Vec<[f32; 3]>,
    triangles: Vec<u32>,
    is_endless: bool,
    is_moving: bool,
}

/// A scene with the values of its knobs.
#[derive(Debug, Serialize)]
pub struct SceneChoice {
    name: String,
    description: String,
    step: f64,
    duration: f64,
    stiffness: Option<f64>,
    damping: Option<f64>,
    particles: Option<u32>,
    gravity: f64,
    wind: [f64; 3],
}

/// A method with its settings.
#[derive(Debug, Serialize)]
pub struct MethodChoice {
    id: &'static str,
    name: &'static str,
    theory: &'static str,
    has_lesson: bool,
    presets: Vec<PresetChoice>,
    settings: Vec<SettingChoice>,
}

/// Named settings of a method.
#[derive(Debug, Serialize)]
pub struct PresetChoice {
    name: &'static str,
    settings: &'static [(&'static str, &'static str)],
}

/// A setting of a method.
#[derive(Debug, Serialize)]
pub struct SettingChoice {
    key: &'static str,
    default: &'static str,
    allowed: String,
    help: &'static str,
    values: Values,
}

/// The values that a setting takes.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Values {
    /// Numbers from the first to the second of `range`, and also 0 if `is_optional`.
    Number {
        /// The range.
        range: (f64, f64),
        /// Whether 0 switches the setting off.
        is_optional: bool,
        /// Whether they are whole.
        is_whole: bool,
    },
    /// Words.
    Word {
        /// All of them.
        words: &'static [&'static str],
    },
}

impl Values {
    fn of(kind: Kind) -> Self {
        let number = |range, is_optional, is_whole| Self::Number { range, is_optional, is_whole };
        match kind {
            Kind::Number { min, max } => number((min, max), false, false),
            Kind::OptionalNumber { min, max } => number((min, max), true, false),
            Kind::Integer { min, max } => number((min as f64, max as f64), false, true),
            Kind::Choice(words) => Self::Word { words },
        }
    }
}

/// Ranges of the knobs.
#[derive(Debug, Serialize)]
pub struct Limits {
    panes: usize,
    particles: (u32, u32),
    stiffness: (f64, f64),
    damping: (f64, f64),
    step: (f64, f64),
    duration: (f64, f64),
    rate: (f64, f64),
    gravity: (f64, f64),
    wind: (f64, f64),
    mesh_bytes: usize,
    file_bytes: usize,
}

impl SceneChoice {
    fn of(name: &str, source: &Source) -> Self {
        let scene = source.scene();
        let time = source.time();
        Self {
            name: name.to_owned(),
            step: time.step_s,
            duration: time.duration_s,
            stiffness: scene.and_then(stiffness_of),
            damping: scene.and_then(damping_of),
            particles: scene.and_then(side_of),
            gravity: gravity_of(source),
            wind: wind_of(source),
            description: scene.map_or_else(String::new, |scene| scene.description.clone()),
        }
    }
}

/// A file that was taken.
pub fn dropped<'a>(name: &str, dropped: &'a Dropped) -> Reply<'a> {
    let scene = SceneChoice::of(&format!("{PREFIX}{name}"), &dropped.source);
    Reply::Dropped { scene, notes: &dropped.notes }
}

/// The first message.
pub fn hello() -> Reply<'static> {
    let scene = |name: &'static str| {
        let scene = bundled(name).ok()?;
        Some(SceneChoice::of(name, &Source::Scene(Box::new(scene))))
    };
    let method = |method: &'static drape_integrator::Method| MethodChoice {
        id: method.id,
        name: method.name,
        theory: method.theory,
        has_lesson: lessons::find(method.id).is_ok(),
        presets: presets(method)
            .map(|preset| PresetChoice { name: preset.name, settings: preset.settings })
            .collect(),
        settings: method
            .settings
            .iter()
            .map(|setting| SettingChoice {
                key: setting.key,
                default: setting.default,
                allowed: setting.kind.to_string(),
                help: setting.help,
                values: Values::of(setting.kind),
            })
            .collect(),
    };
    Reply::Hello {
        version: env!("CARGO_PKG_VERSION"),
        scenes: drape_model::bundled::names().filter_map(scene).collect(),
        methods: methods::all().map(method).collect(),
        limits: Limits {
            panes: limits::PANES,
            particles: limits::SIDE,
            stiffness: limits::STIFFNESS_PER_S2,
            damping: limits::DAMPING_PER_S,
            step: limits::STEP_S,
            duration: limits::DURATION_S,
            rate: limits::RATE,
            gravity: limits::GRAVITY_M_S2,
            wind: limits::WIND_M_S,
            mesh_bytes: limits::MESH_BYTES,
            file_bytes: limits::FILE_BYTES,
        },
    }
}

/// The message with the scene to draw in a pane.
pub fn scenery(pane: usize, run: u32, scenery: &Scenery) -> Reply<'static> {
    let Scenery { stage, subject } = scenery;
    let solid = |solid: &drape_render::Solid| {
        let whole = (&solid.points, &solid.triangles);
        let (points, triangles) =
            solid.softened.as_ref().map_or(whole, |(points, triangles)| (points, triangles));
        Solid {
            points: points.iter().map(|x| [x.x as f32, x.y as f32, x.z as f32]).collect(),
            triangles: triangles.as_flattened().to_vec(),
            is_endless: solid.is_endless,
            is_moving: solid.path.is_some(),
        }
    };
    Reply::Scenery {
        pane,
        run,
        particles: stage.spec.particles.mass_kg.len(),
        extent: extent(&stage.spec.particles.position_m),
        triangles: subject.triangles.as_flattened().to_vec(),
        lines: subject.lines.as_flattened().to_vec(),
        pins: stage.spec.pins.iter().map(|pin| pin.particle).collect(),
        solids: subject.solids.iter().map(solid).collect(),
        step: stage.time.step_s,
        duration: stage.time.duration_s,
        method: stage.choice.full_id(),
    }
}

/// Lowest and highest coordinates of these positions.
fn extent(positions: &[[f64; 3]]) -> [[f32; 3]; 2] {
    let bound = |bound: fn(f64, f64) -> f64| {
        std::array::from_fn(|axis| {
            positions.iter().map(|x| x[axis]).reduce(bound).unwrap_or(0.0) as f32
        })
    };
    [bound(f64::min), bound(f64::max)]
}

/// The owner of the positions in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// The pane.
    Pane,
    /// The reference solution at the same time.
    Ghost,
}

/// The name and the content of a file, from a message of the page: the length of the name (u32,
/// little-endian), the name, the content. `None` if the bytes are no such message.
pub fn file(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
    let (name, content) = rest.split_at_checked(length)?;
    Some((std::str::from_utf8(name).ok()?, content))
}

/// Positions of a pane, little-endian: the numbers of the pane, of the run and of particles (u32),
/// 0 for the pane and 1 for its reference (u32), the time (f64, s), then x, y, z of each particle
/// (f32, m).
pub fn frame(of: Of, pane: usize, run: u32, time: f64, shown: &[[f32; 3]]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(24 + 12 * shown.len());
    for number in [pane as u32, run, shown.len() as u32, u32::from(of == Of::Ghost)] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(time.to_le_bytes());
    for coordinate in shown.as_flattened() {
        bytes.extend(coordinate.to_le_bytes());
    }
    bytes
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn a_frame_holds_its_numbers_where_the_page_reads_them() {
        let places = [[1.0, -2.0, 0.5], [0.0, 3.0, 4.0]];
        let bytes = frame(Of::Ghost, 2, 7, 0.25, &places);
        assert_eq!(bytes.len(), 24 + 24);
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!([word(0), word(4), word(8), word(12)], [2, 7, 2, 1]);
        assert_eq!(frame(Of::Pane, 2, 7, 0.25, &places)[12], 0);
        assert_eq!(f64::from_le_bytes(bytes[16..24].try_into().unwrap()), 0.25);
        assert_eq!(f32::from_bits(word(28)), -2.0);
        assert_eq!(f32::from_bits(word(44)), 4.0);
    }

    #[test]
    fn a_message_with_a_file_is_read_or_refused() {
        let whole = b"\x05\0\0\0a.objv 0 0 0";
        assert_eq!(file(whole), Some(("a.obj", &b"v 0 0 0"[..])));
        assert_eq!(file(b"\0\0\0\0"), Some(("", &b""[..])));
        for wrong in
            [&b""[..], b"\x05\0\0", b"\x05\0\0\0a.ob", b"\xff\xff\xff\xffa", b"\x01\0\0\0\xff"]
        {
            assert_eq!(file(wrong), None, "{wrong:?}");
        }
    }

    #[test]
    fn a_request_with_an_unknown_key_is_refused() {
        let read = |text: &str| serde_json::from_str::<Request>(text);
        assert_eq!(read(r#"{"do":"play"}"#).unwrap(), Request::Play {});
        for wrong in [r#"{"do":"play","now":1}"#, r#"{"do":"dance"}"#, "{}", "[]", "", "\"play\""] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn hello_knows_every_scene_and_method() {
        let Reply::Hello { scenes, methods, .. } = hello() else { panic!("another message") };
        assert_eq!(scenes.len(), drape_model::bundled::names().count());
        assert!(methods.iter().any(|method| method.id == "imex-updated"));
        let sheet = scenes.iter().find(|scene| scene.name == "hanging-textile-1e6").unwrap();
        assert_eq!((sheet.stiffness, sheet.particles), (Some(1e6), Some(20)));
    }
}
