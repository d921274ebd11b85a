//! Broken input: mutations of files, settings and messages that are right, and what must hold for
//! each.
//!
//! Nothing that a user can pass in may panic, and what is refused gets a message of readable length.
//! What is accepted is built, and a method takes a step on it.

use drape_harness::Unfinished;
use drape_harness::methods::{self, Choice};
use drape_lab::messages::Request;
use drape_lab::{Out, Runs, Session};
use drape_model::{MeshCloth, SceneFile, bundled};
use drape_oracle::{Random, Run};
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// A kind of input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A scene, "drape-scene/1".
    Scene,
    /// A frozen system, "drape-system/1".
    System,
    /// A triangle mesh in a Wavefront OBJ file.
    Mesh,
    /// A method with its settings.
    Settings,
    /// A record of an experiment.
    Record,
    /// The journal of an interrupted experiment.
    Journal,
    /// A line that a program of the user writes, "drape-method/1".
    Line,
    /// A message to the lab.
    Message,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 8] = [
        Self::Scene,
        Self::System,
        Self::Mesh,
        Self::Settings,
        Self::Record,
        Self::Journal,
        Self::Line,
        Self::Message,
    ];

    /// Its share in a run, in parts of 1000: records and journals go through files, which is slow.
    fn weight(self) -> usize {
        match self {
            Self::Scene | Self::System => 200,
            Self::Mesh | Self::Settings => 149,
            Self::Record | Self::Journal => 1,
            Self::Line | Self::Message => 150,
        }
    }
}

/// A fault: the input, and what was wrong with the answer.
#[derive(Clone, Debug)]
pub struct Fault {
    /// The kind of input.
    pub kind: Kind,
    /// Number of the input, from which [`Fuzzer::input`] makes it again.
    pub number: u64,
    /// What went wrong.
    pub what: String,
}

/// How many inputs there were, and how many of them were accepted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Inputs that were tried.
    pub tried: u64,
    /// Inputs that were taken as right.
    pub accepted: u64,
    /// Scenes and systems that are too large to try.
    pub skipped: u64,
}

/// Values that have broken readers before.
const TOKENS: &[&str] = &[
    "0",
    "-0",
    "-1",
    "1",
    "1e308",
    "-1e308",
    "1e309",
    "1e-320",
    "1e-162",
    "0.1",
    "2147483648",
    "4294967295",
    "18446744073709551616",
    "null",
    "true",
    "[]",
    "{}",
    "\"\"",
    "[[[[[[[[",
    "NaN",
    "Infinity",
    "\\u0000",
    "\u{1b}[31m",
    "\n",
    "\u{202e}",
    "ÿ",
    "\"x\": 1,",
    ",",
    ":",
    "=",
    "f 1 1 1\n",
    "f 1 2 999999999\n",
    "f -1 -2 -3\n",
    "v 1e400 0 0\n",
    "v 0 0\n",
    "g \u{7}\n",
];

/// Lines of programs that keep to the protocol.
const LINES: &[&str] = &[
    r#"{"protocol":"drape-method/1","name":"implicit midpoint","order":2,
        "class":"symplectic","conserves":["momentum"],"implicit":true,
        "supports":["tension","gravity","pins","full damping"]}"#,
    r#"{"protocol":"drape-method/1","name":"mine","order":1,"class":"dissipative",
        "implicit":false,"supports":[],"source":"a book","theory":"none"}"#,
    r#"{"ok":true}"#,
    r#"{"error":"the step is too long"}"#,
    r#"{"bytes":432,"force_evaluations":3,"newton_iterations":2,"cg_iterations":40,
        "matvecs":41,"factorisations":1,"substeps":2,"converged":false}"#,
    r#"{"bytes":432}"#,
];
/// Bytes that a step of the protocol announces here.
const LINE_BYTES: usize = 432;

/// Messages that the page of the lab sends.
const MESSAGES: &[&str] = &[
    r#"{"do":"open","panes":[{"scene":"hanging-textile-1e4",
        "method":"imex-euler:forcing_term=0.05","stiffness":1000,"damping":2,"step":0.01,
        "duration":1,"particles":8}]}"#,
    r#"{"do":"open","panes":[{"scene":"flag","method":"backward-euler"},
        {"scene":"round-table","method":"xpbd"}]}"#,
    r#"{"do":"play"}"#,
    r#"{"do":"pause"}"#,
    r#"{"do":"step"}"#,
    r#"{"do":"restart"}"#,
    r#"{"do":"rate","rate":0.5}"#,
    r#"{"do":"wait","wait":false}"#,
    r#"{"do":"repeat","pane":0}"#,
    r#"{"do":"lessons"}"#,
    r#"{"do":"lesson","id":"backward-euler"}"#,
    r#"{"do":"answer","lesson":"explicit-euler","value":0.02}"#,
];

/// Most particles or faces that an input may ask for: larger ones are right, but slow to try.
const LARGEST: f64 = 3000.0;
/// Bytes of a message from which on nobody reads it.
const LONGEST: usize = 2000;
/// Particles up to which a method takes a step.
const STEPPED: usize = 450;

/// The state of a run.
#[derive(Debug)]
pub struct Fuzzer {
    seed: u64,
    corpus: Vec<(Kind, Vec<Vec<u8>>)>,
    folder: PathBuf,
}

fn systems() -> Vec<Vec<u8>> {
    let sheet = crate::Sheet::default();
    let mut specs = vec![sheet.spec(), drape_oracle::scenes::bundled("spinning-sheet")];
    specs.retain(|spec| spec.particles.mass_kg.len() <= STEPPED);
    specs.iter().filter_map(|spec| serde_json::to_vec(spec).ok()).collect()
}

/// Folder of results with an interrupted experiment.
const OUT: &str = "out";

/// The journal that this program writes for an experiment that ended.
fn journal(out: &Path) -> Result<Vec<u8>, String> {
    std::fs::create_dir_all(out).map_err(message)?;
    let record = out.join("order.txt");
    std::fs::write(&record, "a record").map_err(message)?;
    let unfinished = Unfinished::enter(out, true).map_err(message)?;
    let journal = unfinished.journal("order", true).map_err(message)?;
    journal.finish(&[record]).map_err(message)?;
    std::fs::read(out.join(".unfinished").join("order.journal")).map_err(message)
}

impl Fuzzer {
    /// A run with a seed; files go to `folder`, records are those below `results`.
    ///
    /// # Errors
    /// A message where a record cannot be read or a journal cannot be written.
    pub fn new(seed: u64, folder: PathBuf, results: &Path) -> Result<Self, String> {
        let bytes = |text: &str| text.as_bytes().to_vec();
        let scenes = bundled::names().filter_map(bundled::text).map(bytes).collect();
        let meshes = bundled::meshes().filter_map(bundled::mesh).map(bytes);
        let small = "g left\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5\nf 1 2 3\nf 2/1/1 4//2 3\n";
        let meshes = meshes.chain([bytes(small)]).filter(|mesh| mesh.len() < 100_000).collect();
        let settings = crate::METHODS.map(bytes).to_vec();
        let record = |name: &str| std::fs::read(results.join(name)).map_err(message);
        let records = vec![record("order.json")?, record("post-correction.json")?];
        let journal = journal(&folder.join(OUT))?;
        let corpus = vec![
            (Kind::Scene, scenes),
            (Kind::System, systems()),
            (Kind::Mesh, meshes),
            (Kind::Settings, settings),
            (Kind::Record, records),
            (Kind::Journal, vec![journal]),
            (Kind::Line, LINES.iter().map(|line| bytes(line)).collect()),
            (Kind::Message, MESSAGES.iter().map(|message| bytes(message)).collect()),
        ];
        Ok(Self { seed, corpus, folder })
    }

    /// The input of that number.
    pub fn input(&self, number: u64) -> (Kind, Vec<u8>) {
        let mut random = Random::new(self.seed.wrapping_mul(0x9e37_79b9).wrapping_add(number));
        let mut place = random.below(Kind::ALL.iter().map(|kind| kind.weight()).sum());
        let kind = Kind::ALL.into_iter().find(|kind| {
            let is_it = place < kind.weight();
            place = place.saturating_sub(kind.weight());
            is_it
        });
        let kind = kind.unwrap_or(Kind::Scene);
        let texts = self.corpus.iter().find(|(other, _)| *other == kind).map(|(_, texts)| texts);
        let texts = texts.map_or(&[][..], Vec::as_slice);
        let mut input = texts.get(random.below(texts.len())).cloned().unwrap_or_default();
        for _ in 0..=random.below(4) {
            mutate(&mut random, &mut input, texts);
        }
        (kind, input)
    }

    /// Tries the input of that number.
    ///
    /// # Errors
    /// The [`Fault`], if there is one.
    pub fn try_one(&self, number: u64, tally: &mut Tally) -> Result<(), Fault> {
        let (kind, input) = self.input(number);
        let fault = |what| Fault { kind, number, what };
        tally.tried += 1;
        if matches!(kind, Kind::Scene | Kind::System) && is_large(&input) {
            tally.skipped += 1;
            return Ok(());
        }
        let answer = catch_unwind(AssertUnwindSafe(|| self.answer(kind, &input, number)));
        match answer {
            Err(panic) => {
                let text = panic.downcast_ref::<String>().cloned();
                let text = text.or_else(|| panic.downcast_ref::<&str>().map(|&s| s.to_owned()));
                Err(fault(format!("panic: {}", text.unwrap_or_default())))
            }
            Ok(Ok(())) => {
                tally.accepted += 1;
                Ok(())
            }
            Ok(Err(message)) => {
                // The command escapes what would command a terminal.
                if (1..LONGEST).contains(&message.len()) {
                    Ok(())
                } else {
                    Err(fault(format!("message of {} bytes: {message:.100}", message.len())))
                }
            }
        }
    }

    /// What drape makes of an input: nothing to complain of, or a message.
    fn answer(&self, kind: Kind, input: &[u8], number: u64) -> Result<(), String> {
        let lossy = String::from_utf8_lossy(input);
        match kind {
            Kind::Scene | Kind::System => {
                let file = drape_model::parse("fuzz.json", &lossy).map_err(message)?;
                step(&file, number)
            }
            Kind::Mesh => {
                let text = r#"{ "file": "fuzz.obj", "areal_density_kg_m2": 0.1 }"#;
                let mut mesh: MeshCloth = serde_json::from_str(text).map_err(message)?;
                mesh.repair = number.is_multiple_of(2);
                mesh.read(input).map_err(message)
            }
            Kind::Settings => {
                let choice = Choice::parse(&lossy, &[]).map_err(message)?;
                choice.build().map(|_| ()).map_err(message)
            }
            Kind::Record => {
                let path = self.folder.join("order.json");
                std::fs::write(&path, input).map_err(message)?;
                let compared = drape_harness::compare_folders(&self.folder, &self.folder);
                let removed = std::fs::remove_file(path).map_err(message);
                compared.map_err(message)?;
                removed
            }
            Kind::Journal => {
                let out = self.folder.join(OUT);
                let unfinished = out.join(".unfinished");
                std::fs::create_dir_all(&unfinished).map_err(message)?;
                std::fs::write(unfinished.join("order.journal"), input).map_err(message)?;
                let unfinished = Unfinished::enter(&out, false).map_err(message)?;
                let journal = unfinished.journal("order", true).map_err(message)?;
                drop(journal);
                unfinished.leave(["order"]).map_err(message)
            }
            Kind::Line => {
                let bytes = [None, Some(0), Some(LINE_BYTES)][(number % 3) as usize];
                drape_program::try_line(input, bytes)
            }
            Kind::Message => receive(&lossy),
        }
    }
}

/// What the lab makes of a message. Panes are checked, not started: each would take a thread.
fn receive(text: &str) -> Result<(), String> {
    if let Ok(Request::Open { panes, .. }) = serde_json::from_str(text) {
        return panes.iter().try_for_each(|setup| setup.stage().map(|_| ()).map_err(message));
    }
    let mut session = Session::new(Runs::default());
    for out in session.receive(text) {
        match out {
            Out::Text(text) if text.contains(r#""tell":"refused""#) => return Err(text),
            Out::Text(_) | Out::Binary(_) => {}
        }
    }
    Ok(())
}

fn message(error: impl Display) -> String {
    error.to_string()
}

/// Builds what was accepted and takes a step with some method.
fn step(file: &SceneFile, number: u64) -> Result<(), String> {
    let spec = file.spec();
    let start = spec.build().map_err(message)?;
    if start.0.len() > STEPPED {
        return Ok(());
    }
    let ids: Vec<_> = methods::all().map(|method| method.id).collect();
    let id = ids[(number % ids.len() as u64) as usize];
    let choice = Choice::parse(id, &[]).map_err(message)?;
    let mut integrator = choice.build().map_err(message)?;
    let (system, state) = start;
    let h = 0.001;
    integrator.prepare(&system, drape_oracle::seconds(h)).map_err(message)?;
    let mut run = Run { integrator, system, state, h };
    run.try_step().map(|_| ()).map_err(message)
}

/// Whether a scene asks for more particles than are worth a try.
fn is_large(input: &[u8]) -> bool {
    let Ok(value) = serde_json::from_slice::<serde_json::Value>(input) else { return false };
    let grid = &value["cloth"]["grid"];
    let side = |key: &str| grid[key].as_f64().unwrap_or(1.0);
    // Meshes of the bundle are of fixed size.
    side("rows") * side("columns") > LARGEST
}

/// Changes an input at one place, or joins it with another.
fn mutate(random: &mut Random, input: &mut Vec<u8>, others: &[Vec<u8>]) {
    let at = random.below(input.len() + 1);
    match random.below(8) {
        0 if at < input.len() => input[at] ^= 1 << random.below(8),
        1 if at < input.len() => {
            let end = (at + 1 + random.below(20)).min(input.len());
            input.drain(at..end);
        }
        2 if at < input.len() => {
            let end = (at + 1 + random.below(40)).min(input.len());
            let part = input[at..end].to_vec();
            input.splice(at..at, part);
        }
        3 => input.truncate(at),
        4 => {
            let Some(other) = others.get(random.below(others.len())) else { return };
            let from = random.below(other.len() + 1);
            input.truncate(at);
            input.extend_from_slice(&other[from..]);
        }
        5 | 6 => replace_number(random, input),
        _ => {
            let token = TOKENS[random.below(TOKENS.len())];
            input.splice(at..at, token.bytes());
        }
    }
}

/// Puts a token in the place of a number.
fn replace_number(random: &mut Random, input: &mut Vec<u8>) {
    let is_part = |byte: &u8| byte.is_ascii_digit() || b"+-.eE".contains(byte);
    let at = random.below(input.len());
    let Some(start) = input.iter().skip(at).position(u8::is_ascii_digit).map(|n| n + at) else {
        return;
    };
    let end =
        input[start..].iter().position(|byte| !is_part(byte)).map_or(input.len(), |n| n + start);
    let token = TOKENS[random.below(TOKENS.len())];
    input.splice(start..end, token.bytes());
}
