//! Exports the numbers of committed records as tidy tables, one number a row.
//!
//! Each study has a table of its facts, and so has the record of `drape compare`. Records of times
//! on one machine, and of facts of solvers outside drape, have separate tables: see [`Part`].
//!
//! A record holds lists of cells, each a JSON object. A cell names itself by words (its label, its
//! series, …) and holds numbers. Each number becomes a row, which repeats the columns by which a
//! reader filters: scene, particles, stiffness, method, settings, step, verdict and cost. The
//! export walks through nested objects and lists, so a metric may be called `runs.3.error` or
//! `energy.17`. A nested run has its own words in these columns. Units stand in the keys of the
//! records (`step_s`, `path_m`), or beside the number (`unit`, in the claims).
//!
//! Where a cell names a scene that the facts list, numbers of the scene that the cell lacks come
//! from that list. Where a cell has only a label, its method comes from the facts with the same
//! label.

use crate::{compare, studies};
use drape_report::number::median;
use drape_report::{
    Provenance, Record, RecordError, ReportError, Timings, read_record, read_timings,
};
use schemars::schema_for;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::Path;

/// The columns of a table with their units and meanings.
pub const COLUMNS: [(&str, &str, &str); 17] = [
    (
        "study",
        "",
        "name of the study, as `drape experiment` takes it, or of what else was timed; `compare` for \
         the record of `drape compare`",
    ),
    (
        "cell",
        "",
        "list and place of the cell in the record, and the words by which it names itself",
    ),
    ("scene", "", "scene of the cell"),
    ("particles", "1", "number of particles"),
    ("stiffness_over_mass", "1/s²", "stiffness of the tension springs over the mass of a particle"),
    ("method", "", "id of the method"),
    ("settings", "", "its settings, separated by commas; empty where none are recorded"),
    ("step_s", "s", "time step"),
    (
        "metric",
        "",
        "what the value is: the key in the record; `a.3` is the fourth entry of the list `a`",
    ),
    ("value", "", "the number, with all digits"),
    ("unit", "", "unit of the value; 1 for counts, shares and other numbers without a unit"),
    ("verdict", "", "how the run ended, where the study judges it"),
    (
        "cost_s",
        "s",
        "time of the run that the row is about, as `cost_of` says: among facts modelled, which is \
         counted work at prices that are part of the source; among timings measured, the median \
         of the repetitions; in the table `compare` measured, the least of them; empty where none \
         is recorded",
    ),
    (
        "cost_of",
        "",
        "key from which `cost_s` is taken; only costs of one key in one table compare. \
         `modelled_s`, `samples_s`, `samples_ns` and `with_ns` are times of all that was run, \
         `frame_s` of a frame, `step_ns` and `median_us` of a step",
    ),
    (
        "machine",
        "",
        "processor of the machine that wrote the record, and how many threads computed facts",
    ),
    ("commit", "", "commit of the program that wrote the record"),
    (
        "quick",
        "",
        "true where only the quick subset of the cells was computed; empty for timings, which do \
         not say so",
    ),
];

/// Places of columns in a [`Row`].
const CELL: usize = 1;
const METRIC: usize = 8;
const UNIT: usize = 10;

/// The type of the entries of a column, for formats with types. An empty entry is a missing one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Text.
    Word,
    /// A number without a fraction.
    Count,
    /// A number.
    Number,
    /// `true` or `false`.
    Truth,
}

/// The kind of a column of [`COLUMNS`], or of the dictionary, by its name.
#[must_use]
pub fn kind(column: &str) -> Kind {
    match column {
        "particles" => Kind::Count,
        "stiffness_over_mass" | "step_s" | "value" | "cost_s" => Kind::Number,
        "quick" => Kind::Truth,
        _ => Kind::Word,
    }
}

/// A row of a table, in the order of [`COLUMNS`].
pub type Row = [String; COLUMNS.len()];

/// The records that a study may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Its facts.
    Facts,
    /// Times on one machine, in the folder `timings`.
    Timings,
    /// Facts of a physics engine's solvers, in the folder `engines`.
    Engines,
}

impl Part {
    /// Its folder below that of the facts; empty for the facts.
    fn folder(self) -> &'static str {
        match self {
            Self::Facts => "",
            Self::Timings => "timings",
            Self::Engines => "engines",
        }
    }
}

/// The numbers of a record.
#[derive(Clone, Debug)]
pub struct Table {
    /// Name of the study, or of another timed program.
    pub study: String,
    /// The record of the study.
    pub part: Part,
    /// One number a row.
    pub rows: Vec<Row>,
}

impl Table {
    /// The name of the table, which is unique among the tables of the same results: `STUDY`,
    /// `timings-STUDY` or `engines-STUDY`.
    #[must_use]
    pub fn name(&self) -> String {
        match self.part {
            Part::Facts => self.study.clone(),
            part => format!("{}-{}", part.folder(), self.study),
        }
    }
}

/// Keys of coordinates for pictures, which are no measurements.
const NO_METRIC: [&str; 1] = ["position_m"];

/// Reads the records below `results`: those of all studies, other records of timings and engines,
/// and the record of `drape compare`. With names in `only`, it reads only the records of these
/// names.
///
/// # Errors
/// [`ReportError`] when a record cannot be read, or when its content does not belong at its place.
pub fn tables(results: &Path, only: &[String]) -> Result<Vec<Table>, ReportError> {
    let mut tables = Vec::new();
    for name in names(results)? {
        if only.is_empty() || only.contains(&name) {
            tables.extend(of(results, &name)?);
        }
    }
    Ok(tables)
}

/// Names of the studies in their order, of a comparison, and of other records of timings and
/// engines.
fn names(results: &Path) -> Result<Vec<String>, RecordError> {
    let mut names: Vec<_> = studies::all().iter().map(|study| study.name().to_owned()).collect();
    names.push(compare::NAME.to_owned());
    for part in [Part::Timings, Part::Engines] {
        for name in files(&results.join(part.folder()))? {
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    Ok(names)
}

/// Names of the JSON files in a folder, without their ending; none where the folder is missing.
fn files(folder: &Path) -> Result<BTreeSet<String>, RecordError> {
    let refused = |source: std::io::Error| RecordError::Io {
        path: folder.to_owned(),
        action: "read",
        source,
    };
    let mut names = BTreeSet::new();
    if folder.is_dir() {
        for entry in folder.read_dir().map_err(refused)? {
            let file = entry.map_err(refused)?.path();
            if file.extension() == Some(OsStr::new("json"))
                && let Some(name) = file.file_stem().and_then(OsStr::to_str)
            {
                names.insert(name.to_owned());
            }
        }
    }
    Ok(names)
}

/// The tables of a study.
fn of(results: &Path, study: &str) -> Result<Vec<Table>, ReportError> {
    let engines = results.join(Part::Engines.folder());
    let mut facts: Option<Record<Value>> = read_record(results, study)?;
    if let Some(record) = facts.as_mut().filter(|_| study == compare::NAME) {
        name_runs(&mut record.facts);
    }
    let engines: Option<Record<Value>> = read_record(&engines, study)?;
    let timings: Option<Timings<Value>> = read_timings(results, study)?;
    let mut tables = Vec::new();
    tables.extend(facts.as_ref().map(|record| of_record(Part::Facts, record)));
    tables.extend(timings.map(|timings| of_timings(&timings, facts.as_ref())));
    tables.extend(engines.map(|record| of_record(Part::Engines, &record)));
    Ok(tables)
}

/// Writes scene, label and method into the runs of a comparison, each of which names its form by a
/// number alone.
fn name_runs(facts: &mut Value) {
    let scene = facts.pointer("/scene/name").cloned().unwrap_or_default();
    let forms = facts.get("forms").cloned().unwrap_or_default();
    let runs = facts.get_mut("runs").and_then(Value::as_array_mut).into_iter().flatten();
    for run in runs.filter_map(Value::as_object_mut) {
        let place = run.get("form").and_then(Value::as_u64);
        let form = place.and_then(|place| forms.get(usize::try_from(place).ok()?));
        for key in ["label", "method"] {
            if let Some(word) = form.and_then(|form| form.get(key)) {
                run.insert(key.to_owned(), word.clone());
            }
        }
        run.insert("scene".to_owned(), scene.clone());
    }
}

/// The table of a record of facts.
fn of_record(part: Part, record: &Record<Value>) -> Table {
    let frame = Frame {
        study: &record.experiment,
        commit: record.provenance.commit.as_deref().unwrap_or_default(),
        machine: machine(&record.provenance),
        quick: record.quick.to_string(),
        costs: &MODELLED,
        scenes: scenes(&record.facts),
        methods: methods(&record.facts),
    };
    Table { study: record.experiment.clone(), part, rows: frame.rows(&record.facts) }
}

/// The table of a record of timings. It takes scenes and methods that the record does not describe
/// from the facts.
fn of_timings(timings: &Timings<Value>, facts: Option<&Record<Value>>) -> Table {
    let none = Value::Null;
    let facts = facts.map_or(&none, |record| &record.facts);
    let frame = Frame {
        study: &timings.experiment,
        commit: timings.provenance.commit.as_deref().unwrap_or_default(),
        machine: machine(&timings.provenance),
        quick: String::new(),
        costs: &MEASURED,
        scenes: scenes(facts),
        methods: methods(facts),
    };
    let mut rows = Vec::new();
    frame.cells("rows", &timings.rows, &mut rows);
    Table { study: timings.experiment.clone(), part: Part::Timings, rows }
}

/// The processor and the number of threads, as a short text.
fn machine(provenance: &Provenance) -> String {
    let Provenance { cpu, threads, .. } = provenance;
    let plural = if *threads == 1 { "" } else { "s" };
    format!("{cpu}, {threads} thread{plural}")
}

/// A scene: its name, and the cell that describes it.
type Scene<'a> = (&'a str, &'a Map<String, Value>);

/// The scenes of the facts, by the `id` or `name` to which cells refer. It may name a scene, or a
/// row of the facts that has a scene.
fn scenes(facts: &Value) -> BTreeMap<&str, Scene<'_>> {
    let mut scenes = BTreeMap::new();
    for list in ["rows", "scenes", "cases", "meshes"] {
        let cells = facts.get(list).and_then(Value::as_array).into_iter().flatten();
        for cell in cells.filter_map(Value::as_object) {
            let word = |key: &str| cell.get(key).and_then(Value::as_str);
            let id = word("id").or(word("name"));
            let scene = if list == "rows" { word("scene") } else { id };
            if let Some((id, scene)) = id.zip(scene) {
                scenes.insert(id, (scene, cell));
            }
        }
    }
    // A comparison has one scene.
    let only = facts.get("scene").and_then(Value::as_object);
    let name = only.and_then(|scene| scene.get("name")).and_then(Value::as_str);
    scenes.extend(name.zip(only).map(|(name, scene)| (name, (name, scene))));
    scenes
}

/// Methods with their settings, by scene and label, and by label alone under an empty scene. Where
/// cells with one label differ in the settings, it gives only the id.
fn methods(facts: &Value) -> BTreeMap<(&str, &str), &str> {
    let mut methods = BTreeMap::new();
    let mut rest = vec![facts];
    while let Some(value) = rest.pop() {
        match value {
            Value::Array(list) => rest.extend(list),
            Value::Object(object) => {
                let word = |key: &str| object.get(key).and_then(Value::as_str);
                let whole = word("settings").or(word("method"));
                if let Some((label, whole)) = word("label").zip(whole) {
                    for scene in ["", word("scene").unwrap_or_default()] {
                        let known = methods.entry((scene, label)).or_insert(whole);
                        *known = common(known, whole);
                    }
                }
                rest.extend(object.values());
            }
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
        }
    }
    methods
}

/// The common part of two methods: all of the text, the id, or nothing.
fn common<'a>(one: &'a str, other: &'a str) -> &'a str {
    let id = split(one).0;
    if one == other {
        one
    } else if id == split(other).0 {
        id
    } else {
        ""
    }
}

/// Id and settings of a method.
fn split(whole: &str) -> (&str, &str) {
    whole.split_once(':').unwrap_or((whole, ""))
}

/// The context that all cells of a record share.
#[derive(Clone)]
struct Frame<'a> {
    study: &'a str,
    commit: &'a str,
    machine: String,
    quick: String,
    /// Keys of times, the preferred one first, with their units in seconds.
    costs: &'static [(&'static str, f64)],
    scenes: BTreeMap<&'a str, Scene<'a>>,
    methods: BTreeMap<(&'a str, &'a str), &'a str>,
}

/// Keys whose values have columns of their own.
const SCENE: [&str; 3] = ["scene", "case", "mesh"];
const STIFFNESS: &str = "stiffness_over_mass_per_s2";

/// Keys for the time of a run among facts. Other times there are simulated, or of the paper's
/// machine.
const MODELLED: [(&str, f64); 2] = [("modelled_s", 1.0), ("frame_s", 1.0)];

/// Keys for the time of a run among timings. A median beside its samples is the same time.
const MEASURED: [(&str, f64); 6] = [
    ("frame_s", 1.0),
    ("samples_s", 1.0),
    ("samples_ns", 1e-9),
    ("with_ns", 1e-9),
    ("step_ns", 1e-9),
    ("median_us", 1e-6),
];

impl Frame<'_> {
    fn rows(&self, facts: &Value) -> Vec<Row> {
        let mut rows = Vec::new();
        let Some(facts) = facts.as_object() else { return rows };
        let mut single = Map::new();
        for (list, value) in facts {
            match value {
                Value::Array(cells) => self.cells(list, cells, &mut rows),
                Value::Object(cell) => {
                    // This object describes the whole record, not a run, so `frame_s` is no cost.
                    Frame { costs: &[], ..self.clone() }.cell(list, cell, &mut rows);
                }
                other => {
                    single.insert(list.clone(), other.clone());
                }
            }
        }
        if !single.is_empty() {
            self.cell(SINGLE, &single, &mut rows);
        }
        rows
    }

    fn cells(&self, list: &str, cells: &[Value], rows: &mut Vec<Row>) {
        for (place, cell) in cells.iter().enumerate() {
            if let Value::Object(cell) = cell {
                self.cell(&format!("{list}[{place}]"), cell, rows);
            }
        }
    }

    fn cell(&self, place: &str, cell: &Map<String, Value>, rows: &mut Vec<Row>) {
        let mut name = place.to_owned();
        for (key, value) in cell {
            if let Value::String(text) = value
                && !text.is_empty()
                && is_name(text)
                && !["method", "settings", "verdict", "scene"].contains(&key.as_str())
            {
                name += &format!("; {key}={text}");
            }
        }
        self.walk(&Head { cell: name, ..Head::default() }, "", cell, rows);
    }

    fn walk(&self, outer: &Head, path: &str, object: &Map<String, Value>, rows: &mut Vec<Row>) {
        let head = self.head(outer, object);
        for (key, value) in object {
            if !NO_METRIC.contains(&key.as_str()) {
                self.value(&head, &join(path, key), key, value, rows);
            }
        }
    }

    /// The columns that the rows of an object repeat. They come from the object itself, or else
    /// from the objects around it.
    fn head(&self, outer: &Head, object: &Map<String, Value>) -> Head {
        let mut head = outer.clone();
        // The description of a run may stand in its own object.
        let case = object.get("case").and_then(Value::as_object);
        let get = |key: &str| object.get(key).or_else(|| case?.get(key));
        let word = |key: &str| get(key).and_then(Value::as_str);

        let is_known = |id: &&str| self.scenes.contains_key(*id);
        let id = ["id", "name"].into_iter().filter_map(word).find(is_known);
        let scene = id.or_else(|| SCENE.into_iter().filter_map(word).find(|word| is_name(word)));
        let known = scene.and_then(|scene| self.scenes.get(scene));
        if let Some(scene) = scene {
            head.scene = known.map_or(scene, |known| known.0).to_owned();
        }
        let number = |key: &str, held: &mut String| {
            let value = get(key).or_else(|| known?.1.get(key)).filter(|value| value.is_number());
            if let Some(value) = value {
                *held = value.to_string();
            }
        };
        number("particles", &mut head.particles);
        number(STIFFNESS, &mut head.stiffness);
        number("step_s", &mut head.step);

        // Some studies keep the id in one key and the whole choice in `settings`.
        let label = word("label");
        let whole = word("settings").or(word("method"));
        let whole = whole.or_else(|| self.method(&head.scene, label?));
        if whole.is_some() || label.is_some() {
            let (id, settings) = split(whole.unwrap_or_default());
            if (id, settings) != (head.method.as_str(), head.settings.as_str()) {
                let (id, settings) = (id.to_owned(), settings.to_owned());
                // The verdict and the cost belong to another method, so drop them.
                let (verdict, cost, cost_of) = (String::new(), String::new(), "");
                head = Head { method: id, settings, verdict, cost, cost_of, ..head };
            }
        }
        if let Some(verdict) = word("verdict") {
            verdict.clone_into(&mut head.verdict);
        }
        if let Some((cost, cost_of)) = self.cost(object) {
            head = Head { cost, cost_of, ..head };
        }
        if let Some(unit) = word("unit") {
            head.unit = Some(unit.to_owned());
        }
        if let Some(what) = word("what") {
            head.cell += &format!("; {what}");
        }
        head
    }

    /// The method with this label on that scene; where the scene has no such label, on all scenes.
    fn method(&self, scene: &str, label: &str) -> Option<&str> {
        let on = |scene| self.methods.get(&(scene, label)).copied();
        on(scene).or_else(|| on(""))
    }

    /// The time of a run in seconds, and its key.
    fn cost(&self, object: &Map<String, Value>) -> Option<(String, &'static str)> {
        self.costs.iter().find_map(|&(key, unit_s)| {
            let samples = match object.get(key)? {
                Value::Array(samples) => samples.as_slice(),
                sample => std::slice::from_ref(sample),
            };
            let middle = median(samples.iter().filter_map(Value::as_f64))?;
            Some(((unit_s * middle).to_string(), key))
        })
    }

    fn value(&self, head: &Head, metric: &str, key: &str, value: &Value, rows: &mut Vec<Row>) {
        match value {
            Value::Number(number) => rows.push(self.row(head, metric, key, &number.to_string())),
            Value::Object(object) => self.walk(head, metric, object, rows),
            Value::Array(list) => {
                for (place, value) in list.iter().enumerate() {
                    self.value(head, &join(metric, &place.to_string()), key, value, rows);
                }
            }
            Value::Null | Value::Bool(_) | Value::String(_) => {}
        }
    }

    fn row(&self, head: &Head, metric: &str, key: &str, value: &str) -> Row {
        let unit = match &head.unit {
            Some(unit) if ["value", "limit"].contains(&key) => unit.clone(),
            _ => unit_of(metric),
        };
        [
            self.study.to_owned(),
            head.cell.clone(),
            head.scene.clone(),
            head.particles.clone(),
            head.stiffness.clone(),
            head.method.clone(),
            head.settings.clone(),
            head.step.clone(),
            metric.to_owned(),
            value.to_owned(),
            if unit.is_empty() { "1".to_owned() } else { unit },
            head.verdict.clone(),
            head.cost.clone(),
            head.cost_of.to_owned(),
            self.machine.clone(),
            self.commit.to_owned(),
            self.quick.clone(),
        ]
    }
}

/// Name of the cell for facts outside of lists.
const SINGLE: &str = "facts";

/// Longer texts are sentences, not names.
const MOST_LETTERS: usize = 80;

fn is_name(text: &str) -> bool {
    text.chars().count() <= MOST_LETTERS
}

/// The columns that the rows of an object repeat.
#[derive(Clone, Default)]
struct Head {
    cell: String,
    scene: String,
    particles: String,
    stiffness: String,
    method: String,
    settings: String,
    step: String,
    verdict: String,
    cost: String,
    cost_of: &'static str,
    unit: Option<String>,
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// Endings of keys with the unit that they mean, longest first.
const UNITS: [(&str, &str); 30] = [
    ("ns_per_particle_step", "ns"),
    ("_kg_m2_per_s", "kg m²/s"),
    ("bytes_per_s", "byte/s"),
    ("_n_s_per_m3", "N s/m³"),
    ("_n_s_per_m", "N s/m"),
    ("_kg_m_per_s", "kg m/s"),
    ("_kg_per_m2", "kg/m²"),
    ("_m_per_s", "m/s"),
    ("_n_per_m", "N/m"),
    ("seconds", "s"),
    ("_kg_m2", "kg/m²"),
    ("_per_s2", "1/s²"),
    ("_per_m", "1/m"),
    ("_per_s", "1/s"),
    ("_rad_s", "rad/s"),
    ("_m_s2", "m/s²"),
    ("_m_s", "m/s"),
    ("_n_s", "N s"),
    ("_n_m", "N m"),
    ("_bytes", "byte"),
    ("_mib", "MiB"),
    ("_deg", "°"),
    ("_kg", "kg"),
    ("_m2", "m²"),
    ("_ns", "ns"),
    ("_us", "µs"),
    ("_j", "J"),
    ("_n", "N"),
    ("_m", "m"),
    ("_s", "s"),
];

/// The unit of a metric, from the last of its keys that names one: the parts of `phases_s` are
/// times.
fn unit_of(metric: &str) -> String {
    let of_key = |key: &str| {
        // A plain `bytes` has no prefix, so no ending matches it.
        let unit = UNITS.iter().find(|(ending, _)| key.ends_with(ending)).map(|(_, unit)| *unit);
        unit.or((key == "bytes").then_some("byte"))
    };
    metric.rsplit('.').find_map(of_key).unwrap_or_default().to_owned()
}

/// The data dictionary: a line for each column, and for each metric of each table. A line holds
/// `name`, `kind`, `unit`, `meaning` and `table`; `table` is empty for columns, which all tables
/// have.
#[must_use]
pub fn dictionary(tables: &[Table]) -> Vec<[String; 5]> {
    let columns = COLUMNS
        .iter()
        .map(|(name, unit, meaning)| [*name, "column", *unit, *meaning, ""].map(str::to_owned));
    columns.chain(tables.iter().flat_map(Table::metrics)).collect()
}

impl Table {
    /// Lines of the dictionary, one for each metric and unit.
    fn metrics(&self) -> Vec<[String; 5]> {
        let mut lists: BTreeMap<(String, &str), BTreeSet<&str>> = BTreeMap::new();
        for row in &self.rows {
            let list = row[CELL].split(['[', ';']).next().unwrap_or_default();
            lists.entry((pattern(&row[METRIC]), row[UNIT].as_str())).or_default().insert(list);
        }
        let schema = schema(&self.study);
        let lines = lists.into_iter().map(|((metric, unit), lists)| {
            let meaning = self.meaning(schema.as_ref(), &metric, &lists);
            [metric, "metric".to_owned(), unit.to_owned(), meaning, self.name()]
        });
        lines.collect()
    }

    /// The meaning of a metric. Where it differs between lists of the record, the text names each
    /// list with its meaning.
    fn meaning(&self, schema: Option<&Value>, metric: &str, lists: &BTreeSet<&str>) -> String {
        let mut said: Vec<(String, Vec<&str>)> = Vec::new();
        for &list in lists {
            let words = schema.and_then(|schema| described(schema, self.part, list, metric));
            let words = words.unwrap_or_else(|| undescribed(metric));
            match said.iter_mut().find(|(known, _)| *known == words) {
                Some((_, lists)) => lists.push(list),
                None => said.push((words, vec![list])),
            }
        }
        match said.as_slice() {
            [(words, _)] => words.clone(),
            _ => {
                let of =
                    |(words, lists): &(String, Vec<&str>)| format!("{}: {words}", lists.join(", "));
                said.iter().map(of).collect::<Vec<_>>().join("; ")
            }
        }
    }
}

/// A metric with `#` for each place in a list.
fn pattern(metric: &str) -> String {
    let part = |part: &str| {
        let is_place = !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
        if is_place { "#".to_owned() } else { part.to_owned() }
    };
    metric.split('.').map(part).collect::<Vec<_>>().join(".")
}

/// JSON Schema of the facts of a study and of a row of its timings, as a pair.
fn schema(study: &str) -> Option<Value> {
    if study == compare::NAME {
        return Some(schema_for!((compare::facts::Facts, ())).to_value());
    }
    studies::find(study).ok().map(|study| study.schema().to_value())
}

/// The description of a metric in a list of a record. The schema describes a pair: the facts, and a
/// row of the timings.
fn described(schema: &Value, part: Part, list: &str, metric: &str) -> Option<String> {
    let (of, places) = match part {
        Part::Timings => ("/prefixItems/1", vec![vec![]]),
        Part::Facts | Part::Engines if list == SINGLE => ("/prefixItems/0", vec![vec![]]),
        // A list of cells, or a single one.
        Part::Facts | Part::Engines => ("/prefixItems/0", vec![vec![list, "#"], vec![list]]),
    };
    let mut found = Vec::new();
    for before in places {
        let path: Vec<&str> = before.into_iter().chain(metric.split('.')).collect();
        follow(schema, schema.pointer(of)?, &path, "", &mut found);
    }
    let lines: Vec<_> = found.into_iter().map(|words| line(&resolved(schema, words))).collect();
    (!lines.is_empty()).then(|| lines.join("; or: "))
}

/// Adds the descriptions of the field at the end of a path, in each form of the schema. `said` is
/// the description of the field at which the path begins.
fn follow<'a>(
    root: &'a Value,
    schema: &'a Value,
    path: &[&str],
    said: &'a str,
    found: &mut Vec<&'a str>,
) {
    let Some((key, rest)) = path.split_first() else {
        if !said.is_empty() && !found.contains(&said) {
            found.push(said);
        }
        return;
    };
    let mut all = Vec::new();
    forms(root, schema, &mut all);
    for form in all {
        let field = form.get("properties").and_then(|fields| fields.get(key));
        // The description of a list or a map holds for its entries.
        let entry = if *key == "#" { "items" } else { "additionalProperties" };
        if let Some(field) = field {
            let said = field.get("description").and_then(Value::as_str).unwrap_or_default();
            follow(root, field, rest, said, found);
        } else if let Some(entries) = form.get(entry).filter(|entries| entries.is_object()) {
            follow(root, entries, rest, said, found);
        }
    }
}

/// Collects a schema, the schemas to which it refers, and its alternatives.
fn forms<'a>(root: &'a Value, schema: &'a Value, all: &mut Vec<&'a Value>) {
    all.push(schema);
    let reference = schema.get("$ref").and_then(Value::as_str);
    let target = reference.and_then(|reference| root.pointer(reference.strip_prefix('#')?));
    let alternatives = ["anyOf", "oneOf", "allOf"].into_iter().filter_map(|key| schema.get(key));
    let alternatives = alternatives.filter_map(Value::as_array).flatten();
    target.into_iter().chain(alternatives).for_each(|form| forms(root, form, all));
}

/// A description. Where it refers to another field of the record, the description of that field
/// takes the place of the reference.
fn resolved(schema: &Value, words: &str) -> String {
    let other = words.strip_prefix("As in [`").or(words.strip_prefix("As [`"));
    let parts = other.and_then(|other| {
        let (name, rest) = other.split_once("`]")?;
        let (of, field) = name.split_once("::")?;
        let place = format!("/$defs/{of}/properties/{field}/description");
        Some((schema.pointer(&place)?.as_str()?, rest))
    });
    match parts {
        Some((told, rest)) => format!("{}{rest}", told.trim_end_matches('.')),
        None => words.to_owned(),
    }
}

/// Most characters of a description. A longer one is cut after its first sentence.
const MOST_OF_MEANING: usize = 200;

/// A description as an entry of a table.
fn line(words: &str) -> String {
    let text = words.split_whitespace().collect::<Vec<_>>().join(" ");
    // A number that is `None` in the record has no row.
    let text = text.replace("[`", "`").replace("`]", "`").replace("`None`", "none");
    let is_long = text.chars().count() > MOST_OF_MEANING;
    let first = text.split_once(". ").map(|(first, _)| first).filter(|_| is_long);
    first.unwrap_or(&text).trim_end_matches('.').to_owned()
}

/// Metrics, with meanings, of the record that times programs outside drape: no study has its types.
const PEERS: [(&str, &str); 15] = [
    ("allowed_m", "Greatest difference that the tolerance of the solvers explains, m"),
    ("case.side", "Particles along each edge"),
    ("case.steps", "Number of steps from the start"),
    ("case.stiffness_over_mass_per_s2", "Stiffness over mass of the tension springs, 1/s²"),
    ("core", "The core of the processor that every program was pinned to"),
    (
        "difference_m",
        "Greater of the differences between two programs in the height of the middle and of the \
         lowest particle, m",
    ),
    ("iterations_per_step", "Iterations of the solver a step"),
    ("lowest_m", "Height of the lowest particle at the end, m"),
    ("mean_us.#", "Mean time of a step, µs; one entry a run"),
    ("median_us.#", "Median time of a step, µs; one entry a run"),
    ("middle_m", "Height of the middle particle at the end, m"),
    ("ratio.greatest", "Greatest of the ratios of times"),
    ("ratio.least", "Least of the ratios of times"),
    ("ratio.median", "Median of the ratios of times"),
    (
        "ratio.samples.#",
        "The other program's time of a step over drape's, of two runs of one round",
    ),
];

/// The meaning of a metric without a description.
const UNDESCRIBED: &str =
    "number of this name in the record, whose key `method` says how it was measured";

/// The meaning of a metric whose type has no schema.
fn undescribed(metric: &str) -> String {
    let known = PEERS.iter().find(|(name, _)| *name == metric);
    known.map_or(UNDESCRIBED, |(_, meaning)| *meaning).to_owned()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use drape_report::{RECORD_FORMAT, TIMINGS_FORMAT};
    use schemars::JsonSchema;
    use serde_json::json;
    use std::path::PathBuf;

    /// Places of further columns.
    const VALUE: usize = 9;
    const COST: usize = 12;
    const COST_OF: usize = 13;
    const MACHINE: usize = 14;

    fn results() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../results")
    }

    fn provenance() -> Provenance {
        let source = crate::Source { commit: Some("abc".to_owned()), dirty: Some(false) };
        let cpu = "AMD EPYC (family 25, model 1)".to_owned();
        Provenance { cpu, threads: 2, ..crate::provenance(&source, BTreeMap::new()) }
    }

    fn record(facts: Value) -> Record<Value> {
        Record {
            format: RECORD_FORMAT.to_owned(),
            experiment: "sample".to_owned(),
            question: String::new(),
            method: String::new(),
            words: drape_report::Words::default(),
            command: String::new(),
            quick: true,
            figures: Vec::new(),
            facts,
            provenance: provenance(),
        }
    }

    fn timings(rows: Vec<Value>) -> Timings<Value> {
        Timings {
            format: TIMINGS_FORMAT.to_owned(),
            experiment: "sample".to_owned(),
            method: String::new(),
            rows,
            provenance: provenance(),
        }
    }

    /// The last row of a metric.
    fn row(table: &Table, metric: &str) -> Row {
        let is_it = |row: &&Row| row[METRIC] == metric;
        table.rows.iter().rfind(is_it).cloned().unwrap_or_else(|| panic!("no row of {metric}"))
    }

    fn cost(table: &Table, metric: &str) -> (String, String) {
        let row = row(table, metric);
        (row[COST].clone(), row[COST_OF].clone())
    }

    fn numbers(value: &Value, found: &mut BTreeMap<String, usize>) {
        match value {
            Value::Number(number) => *found.entry(number.to_string()).or_default() += 1,
            Value::Array(list) => list.iter().for_each(|value| numbers(value, found)),
            Value::Object(object) => {
                let kept = object.iter().filter(|(key, _)| !NO_METRIC.contains(&key.as_str()));
                kept.for_each(|(_, value)| numbers(value, found));
            }
            _ => {}
        }
    }

    /// Every number that the comparison of facts reads stands in the table, equally often.
    #[test]
    fn every_comparable_number_of_every_committed_record_has_a_row() {
        let mut compared = 0;
        for study in studies::all() {
            let tables = of(&results(), study.name()).unwrap();
            let table = tables.iter().find(|table| table.part == Part::Facts).unwrap();
            let mut written: BTreeMap<&str, usize> = BTreeMap::new();
            for row in &table.rows {
                *written.entry(&row[VALUE]).or_default() += 1;
            }
            let mut expected = BTreeMap::new();
            for values in study.comparable(&results()).unwrap() {
                numbers(&values, &mut expected);
            }
            for (number, count) in &expected {
                let found = written.get(number.as_str()).copied().unwrap_or(0);
                assert!(found >= *count, "{}: {number} {found} of {count}", study.name());
            }
            compared += expected.len();
        }
        assert!(compared > 10_000, "{compared}");
    }

    #[test]
    fn a_row_repeats_what_its_cell_and_its_scene_say() {
        let facts = json!({
            "scenes": [{ "id": "soft", "particles": 9, "stiffness_over_mass_per_s2": 1e4 }],
            "runs": [{ "scene": "soft", "label": "x", "method": "imex-euler:start=last",
                "step_s": 0.01, "verdict": "stable", "path_m": 0.25,
                "tries": [{ "step_s": 0.02, "verdict": "marginal", "error": 3 }] }],
            "claims": [{ "numbers": [{ "what": "speed", "value": 2.0, "unit": "m/s" }] }]
        });
        let table = of_record(Part::Facts, &record(facts));
        let path = row(&table, "path_m");
        let cell = "runs[0]; label=x";
        let told = ["sample", cell, "soft", "9", "10000.0", "imex-euler", "start=last", "0.01"];
        assert_eq!(path[..8], told.map(str::to_owned));
        let machine = "AMD EPYC (family 25, model 1), 2 threads";
        let rest = ["path_m", "0.25", "m", "stable", "", "", machine, "abc", "true"];
        assert_eq!(path[8..], rest.map(str::to_owned));
        let tried = row(&table, "tries.0.error");
        assert_eq!(
            (tried[7].as_str(), tried[11].as_str(), tried[UNIT].as_str()),
            ("0.02", "marginal", "1")
        );
        let speed = row(&table, "numbers.0.value");
        assert_eq!((speed[UNIT].as_str(), speed[CELL].as_str()), ("m/s", "claims[0]; speed"));
        let dictionary = dictionary(&[table]);
        let is_tried = |line: &[String; 5]| line[0] == "tries.#.error" && line[4] == "sample";
        assert!(dictionary.iter().any(|line| is_tried(line) && line[1] == "metric"));
        assert_eq!(dictionary.iter().filter(|line| line[1] == "column").count(), COLUMNS.len());
    }

    #[test]
    fn a_nested_run_has_a_scene_and_a_method_of_its_own() {
        let facts = json!({
            "scenes": [
                { "id": "soft", "particles": 9, "step_s": 0.01 },
                { "id": "stiff", "particles": 16, "step_s": 0.02 }
            ],
            "lessons": [{ "id": "one", "method": "one", "runs": [
                { "scene": "stiff", "settings": "one:start=last", "verdict": "stable", "steps": 1 },
                { "scene": "soft", "label": "two", "steps": 2 }
            ] }],
            "runs": [{ "scene": "soft", "label": "two", "method": "two:sweeps=3",
                "verdict": "locked", "modelled_s": 0.5,
                "rival": { "label": "no method of this label", "ratio": 2.0 } }]
        });
        let table = of_record(Part::Facts, &record(facts));
        let told = |metric: &str| row(&table, metric)[2..8].join("|");
        assert_eq!(told("runs.0.steps"), "stiff|16||one|start=last|0.02");
        assert_eq!(told("runs.1.steps"), "soft|9||two|sweeps=3|0.01");
        let rival = row(&table, "rival.ratio");
        assert_eq!(rival[2..8].join("|"), "soft|9||||0.01");
        assert_eq!((rival[11].as_str(), cost(&table, "rival.ratio").0.as_str()), ("", ""));
    }

    #[test]
    fn a_cost_is_that_of_the_nearest_run_with_its_key() {
        let facts = json!({
            "runs": [{
                "method": "one", "modelled_s": 0.5, "steps": 1,
                "tries": [{ "modelled_s": 0.25, "error": 2 }, { "error": 3 }, { "modelled_s": null,
                    "frame_s": 0.125, "error": 4 }],
                "other": { "method": "two", "error": 5 }
            }],
            "paper": [{ "solver_s": 3.34 }]
        });
        let table = of_record(Part::Facts, &record(facts));
        for (metric, seconds, key) in [
            ("steps", "0.5", "modelled_s"),
            ("modelled_s", "0.5", "modelled_s"),
            ("tries.0.error", "0.25", "modelled_s"),
            ("tries.1.error", "0.5", "modelled_s"),
            ("tries.2.error", "0.125", "frame_s"),
            ("other.error", "", ""),
            ("solver_s", "", ""),
        ] {
            assert_eq!(cost(&table, metric), (seconds.to_owned(), key.to_owned()), "{metric}");
        }
    }

    #[test]
    fn the_machine_is_named_in_short() {
        assert_eq!(machine(&provenance()), "AMD EPYC (family 25, model 1), 2 threads");
        let one = Provenance { threads: 1, ..provenance() };
        assert_eq!(machine(&one), "AMD EPYC (family 25, model 1), 1 thread");
    }

    #[test]
    fn a_record_of_timings_is_a_table_too() {
        let facts = record(json!({
            "scenes": [{ "id": "soft", "particles": 9, "stiffness_over_mass_per_s2": 1e4 }],
            "runs": [
                { "scene": "soft", "label": "x", "method": "one:start=last" },
                { "scene": "stiff", "label": "y", "method": "two:sweeps=1" },
                { "scene": "soft", "label": "y", "method": "two:sweeps=2" }
            ]
        }));
        let rows = vec![
            json!({ "scene": "soft", "label": "x", "samples_ns": [4e9, 1e9, 2e9], "seconds": 2.0,
                "phases_s": { "solve": 0.5 } }),
            json!({ "label": "y", "samples_s": [6.0, 3.0], "frame_s": 0.75, "bytes_per_s": 1.0 }),
            json!({ "case": { "method": "three", "side": 20 }, "median_us": [8e6, 4e6] }),
        ];
        let timings = timings(rows);
        let table = of_timings(&timings, Some(&facts));
        assert_eq!((table.name().as_str(), table.study.as_str()), ("timings-sample", "sample"));
        let x = row(&table, "samples_ns.0");
        let told = ["sample", "rows[0]; label=x", "soft", "9", "10000.0", "one", "start=last", ""];
        assert_eq!(x[..8], told.map(str::to_owned));
        let machine = "AMD EPYC (family 25, model 1), 2 threads";
        let rest =
            ["samples_ns.0", "4000000000.0", "ns", "", "2", "samples_ns", machine, "abc", ""];
        assert_eq!(x[8..], rest.map(str::to_owned));
        assert_eq!(row(&table, "seconds")[UNIT], "s");
        assert_eq!(row(&table, "phases_s.solve")[UNIT], "s");
        let y = row(&table, "bytes_per_s");
        assert_eq!(y[UNIT], "byte/s");
        assert_eq!(y[2..8].join("|"), "|||two||", "settings differ between scenes");
        assert_eq!(cost(&table, "bytes_per_s"), ("0.75".to_owned(), "frame_s".to_owned()));
        assert_eq!(row(&table, "case.side")[5], "three");
        assert_eq!(cost(&table, "case.side"), ("6".to_owned(), "median_us".to_owned()));
        let alone = of_timings(&timings, None);
        assert_eq!(alone.rows.len(), table.rows.len());
        assert_eq!(row(&alone, "seconds")[2..8].join("|"), "soft|||||");
    }

    /// The median of the samples equals the median in the record.
    #[test]
    fn the_cost_of_every_committed_timing_is_its_median() {
        let mut seen = 0;
        for name in names(&results()).unwrap() {
            let tables = of(&results(), &name).unwrap();
            for table in tables.iter().filter(|table| table.part == Part::Timings) {
                let medians = ["frame_s", "median_s", "seconds", "solver_s"];
                let is_median = |row: &&Row| medians.contains(&row[METRIC].as_str());
                let costly = table.rows.iter().filter(|row| !row[COST].is_empty());
                for row in costly.filter(is_median) {
                    let [median, cost] = [VALUE, COST].map(|n| row[n].parse::<f64>().unwrap());
                    let difference = (median - cost).abs();
                    assert!(difference <= 1e-12 * median, "{name}: {row:?}");
                    seen += 1;
                }
            }
        }
        assert!(seen > 1000, "{seen}");
    }

    #[test]
    fn every_committed_record_has_a_table_of_its_own() {
        let mut seen = BTreeSet::from(["dictionary".to_owned()]);
        let mut rows = 0;
        for name in names(&results()).unwrap() {
            for table in of(&results(), &name).unwrap() {
                assert!(seen.insert(table.name()), "two tables `{}`", table.name());
                rows += table.rows.len();
                let is_told = |row: &Row| !row[MACHINE].is_empty();
                assert!(table.rows.iter().all(is_told), "{}", table.name());
                let is_paired = |row: &Row| row[COST].is_empty() == row[COST_OF].is_empty();
                assert!(table.rows.iter().all(is_paired), "{}", table.name());
            }
        }
        assert!(rows > 400_000, "{rows}");
        for part in [Part::Timings, Part::Engines] {
            for name in files(&results().join(part.folder())).unwrap() {
                assert!(seen.contains(&format!("{}-{name}", part.folder())), "{name}");
            }
        }
    }

    #[test]
    fn a_record_that_cannot_be_read_is_named() {
        let folder = tempfile::tempdir().unwrap();
        assert!(tables(folder.path(), &[]).unwrap().is_empty());
        let file = folder.path().join("timings").join("broken.json");
        std::fs::create_dir(file.parent().unwrap()).unwrap();
        std::fs::write(&file, "{}").unwrap();
        let error = tables(folder.path(), &[]).unwrap_err().to_string();
        assert!(error.contains(file.to_str().unwrap()), "{error}");
        assert!(tables(folder.path(), &["other".to_owned()]).unwrap().is_empty());
    }

    #[derive(JsonSchema)]
    #[allow(dead_code, reason = "only its schema is asked for")]
    struct Facts {
        /// The runs.
        runs: Vec<Run>,
        /// The rests.
        rests: Vec<Rest>,
        /// Simulated time, s.
        duration_s: f64,
    }

    #[derive(JsonSchema)]
    #[allow(dead_code, reason = "only its schema is asked for")]
    struct Run {
        /// Distance to the end, m; `None`
        /// if [`Run::gaps`] are missing.
        error_m: Option<f64>,
        /// Sum of the gaps.
        ledger: Option<Ledger>,
        /// Heights, m.
        heights_m: [f64; 3],
    }

    #[derive(JsonSchema)]
    #[allow(dead_code, reason = "only its schema is asked for")]
    struct Ledger {
        /// Gap of each effect.
        gaps: BTreeMap<String, f64>,
    }

    #[derive(JsonSchema)]
    #[allow(dead_code, reason = "only its schema is asked for")]
    struct Rest {
        /// As in [`Run::error_m`].
        error_m: f64,
        /// A long description of a number that nobody would read to its end, which is why it ends
        /// with its first sentence in the dictionary. What stands here is for those who read the
        /// source, or the page that is made of it.
        number: f64,
    }

    #[derive(JsonSchema)]
    #[serde(tag = "kind", rename_all = "snake_case")]
    #[allow(dead_code, reason = "only its schema is asked for")]
    enum Timed {
        /// A run.
        Run(TimedRun),
        /// A copy.
        Copy {
            /// Nanoseconds of a copy.
            samples_ns: Vec<u64>,
        },
    }

    #[derive(JsonSchema)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code, reason = "only its schema is asked for")]
    struct TimedRun {
        /// Nanoseconds of a run.
        samples_ns: Vec<u64>,
    }

    #[test]
    fn a_metric_means_what_its_type_says() {
        let schema = schema_for!((Facts, Timed)).to_value();
        let told = |part: Part, list: &str, metric: &str| described(&schema, part, list, metric);
        let error = "Distance to the end, m; none if `Run::gaps` are missing";
        for (list, metric, meaning) in [
            ("runs", "error_m", error),
            ("rests", "error_m", error),
            ("runs", "heights_m.#", "Heights, m"),
            ("runs", "ledger.gaps.anything", "Gap of each effect"),
            (SINGLE, "duration_s", "Simulated time, s"),
            (
                "rests",
                "number",
                "A long description of a number that nobody would read to its end, which is why it \
                 ends with its first sentence in the dictionary",
            ),
        ] {
            let found = told(Part::Facts, list, metric);
            assert_eq!(found.as_deref(), Some(meaning), "{list} {metric}");
            assert_eq!(told(Part::Engines, list, metric), found);
        }
        let samples = told(Part::Timings, "rows", "samples_ns.#");
        assert_eq!(samples.as_deref(), Some("Nanoseconds of a run; or: Nanoseconds of a copy"));
        assert_eq!(told(Part::Facts, "runs", "steps"), None);
    }

    #[test]
    fn a_metric_of_two_meanings_has_both() {
        let schema = schema_for!((Facts, Timed)).to_value();
        let table = of_record(Part::Facts, &record(json!({})));
        let meaning = |metric: &str, lists: [&str; 2]| {
            table.meaning(Some(&schema), metric, &BTreeSet::from(lists))
        };
        let error = "Distance to the end, m; none if `Run::gaps` are missing";
        assert_eq!(meaning("error_m", ["runs", "rests"]), error);
        let heights = format!("rests: {UNDESCRIBED}; runs: Heights, m");
        assert_eq!(meaning("heights_m.#", ["runs", "rests"]), heights);
    }

    /// No metric is explained by its name alone, or by a sentence that needs the one before it.
    #[test]
    fn every_metric_of_every_committed_record_is_described() {
        /// Metrics that may stay without a meaning, as `TABLE: METRIC`.
        const EXCEPTIONS: [&str; 0] = [];
        let mut vague = Vec::new();
        let mut seen = 0;
        for name in names(&results()).unwrap() {
            let tables = of(&results(), &name).unwrap();
            for [metric, kind, _, meaning, table] in dictionary(&tables) {
                let place = format!("{table}: {metric}");
                if kind != "metric" || EXCEPTIONS.contains(&place.as_str()) {
                    continue;
                }
                seen += 1;
                let is_empty = meaning.is_empty() || meaning.contains(UNDESCRIBED);
                let leans = ["key of the records", "The same", "As in", "Its ", "Their ", "That "];
                if is_empty || leans.iter().any(|beginning| meaning.starts_with(beginning)) {
                    vague.push(format!("{place}: {meaning}"));
                }
            }
        }
        assert!(vague.is_empty(), "{} metrics:\n{}", vague.len(), vague.join("\n"));
        assert!(seen > 500, "{seen}");
    }

    #[test]
    fn the_ending_of_a_key_names_its_unit() {
        for (key, unit) in [
            ("step_s", "s"),
            ("speed_m_s", "m/s"),
            ("gravity_m_s2", "m/s²"),
            ("stiffness_over_mass_per_s2", "1/s²"),
            ("stiffness_n_per_m", "N/m"),
            ("mass_kg", "kg"),
            ("energy_gain_j", "J"),
            ("kept_bytes", "byte"),
            ("median_us.3", "µs"),
            ("ns_per_particle_step", "ns"),
            ("phases_s.solve", "s"),
            ("iterations", ""),
            ("rises", ""),
        ] {
            assert_eq!(unit_of(key), unit, "{key}");
        }
    }
}
