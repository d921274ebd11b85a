//! The facts of committed records as one tidy table a study: one number a row.
//!
//! A record's `facts` are lists of cells, each a JSON object. A cell names itself by words (its
//! label, its series, …) and holds numbers. Each number becomes a row that repeats what a reader
//! filters by: scene, particles, stiffness, method, settings, step and verdict. Nested objects and
//! lists are walked through, so a metric may be called `runs.3.error` or `energy.17`. Units stand
//! in the keys of the records (`step_s`, `path_m`), or beside the number (`unit`, in the claims).
//!
//! Where a cell names a scene, and the record lists the scenes, the numbers of the scene that a
//! cell lacks come from there.

use drape_report::file::read_json;
use drape_report::{Record, RecordError};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The columns of a table with their meaning.
pub const COLUMNS: [(&str, &str, &str); 14] = [
    ("study", "", "name of the study, as `drape experiment` takes it"),
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
    ("commit", "", "commit of the program that wrote the record"),
    ("quick", "", "true where only the quick subset of the cells was computed"),
];

/// What the entries of a column are, for formats with types. An empty entry is a missing one.
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
        "stiffness_over_mass" | "step_s" | "value" => Kind::Number,
        "quick" => Kind::Truth,
        _ => Kind::Word,
    }
}

/// A row of a table, in the order of [`COLUMNS`].
pub type Row = [String; COLUMNS.len()];

/// Lists of coordinates for pictures, which are no measurements: `positions` of whole cloths.
const NO_METRIC: [&str; 1] = ["position_m"];

/// Reads the record of a study below `results` and returns its rows; `None` without a record.
///
/// # Errors
/// [`RecordError`] when the record cannot be read.
pub fn table(results: &Path, study: &str) -> Result<Option<Vec<Row>>, RecordError> {
    let file = results.join(format!("{study}.json"));
    if !file.is_file() {
        return Ok(None);
    }
    let record: Record<Value> = read_json(&file)?;
    Ok(Some(rows(&record)))
}

/// The rows of a record.
fn rows(record: &Record<Value>) -> Vec<Row> {
    let scenes = scenes(&record.facts);
    let frame = Frame {
        study: &record.experiment,
        commit: record.provenance.commit.as_deref().unwrap_or_default(),
        quick: record.quick,
        scenes: &scenes,
    };
    let mut rows = Vec::new();
    let Some(facts) = record.facts.as_object() else { return rows };
    let mut single = Map::new();
    for (list, value) in facts {
        match value {
            Value::Array(cells) => {
                for (place, cell) in cells.iter().enumerate() {
                    if let Value::Object(cell) = cell {
                        frame.cell(&format!("{list}[{place}]"), cell, &mut rows);
                    }
                }
            }
            Value::Object(cell) => frame.cell(list, cell, &mut rows),
            other => {
                single.insert(list.clone(), other.clone());
            }
        }
    }
    if !single.is_empty() {
        frame.cell("facts", &single, &mut rows);
    }
    rows
}

/// Every list of cells with an `id` or `name`, by that word.
fn scenes(facts: &Value) -> BTreeMap<&str, &Map<String, Value>> {
    let lists = ["scenes", "cases", "meshes"].into_iter().filter_map(|list| facts.get(list));
    let cells = lists.filter_map(Value::as_array).flatten().filter_map(Value::as_object);
    cells
        .filter_map(|cell| {
            let id = cell.get("id").or(cell.get("name"))?;
            Some((id.as_str()?, cell))
        })
        .collect()
}

/// What all cells of a record share.
struct Frame<'a> {
    study: &'a str,
    commit: &'a str,
    quick: bool,
    scenes: &'a BTreeMap<&'a str, &'a Map<String, Value>>,
}

/// Keys whose values stand in columns.
const SCENE: [&str; 3] = ["scene", "case", "mesh"];
const STIFFNESS: &str = "stiffness_over_mass_per_s2";

impl Frame<'_> {
    fn cell(&self, place: &str, cell: &Map<String, Value>, rows: &mut Vec<Row>) {
        let word = |key: &str| cell.get(key).and_then(Value::as_str);
        let scene = SCENE.into_iter().find_map(word).or(word("id")).unwrap_or_default();
        let about = self.scenes.get(scene).copied();
        let number = |key: &str| {
            let value = cell.get(key).or_else(|| about?.get(key)).filter(|value| value.is_number());
            value.map(Value::to_string).unwrap_or_default()
        };
        // Some studies keep the id in one key and the whole choice in `settings`.
        let whole = word("settings").or(word("method")).unwrap_or_default();
        let (id, settings) = whole.split_once(':').unwrap_or((whole, ""));
        let mut name = place.to_owned();
        for (key, value) in cell {
            if let Value::String(text) = value
                && !text.is_empty()
                && text.chars().count() <= MOST_LETTERS
                && !["method", "settings", "verdict", "scene"].contains(&key.as_str())
            {
                name += &format!("; {key}={text}");
            }
        }
        let head = Head {
            cell: name,
            scene: scene.to_owned(),
            particles: number("particles"),
            stiffness: number(STIFFNESS),
            method: id.to_owned(),
            settings: settings.to_owned(),
            step: number("step_s"),
            verdict: word("verdict").unwrap_or_default().to_owned(),
            unit: word("unit").map(str::to_owned),
        };
        self.walk(&head, "", cell, rows);
    }

    fn walk(&self, head: &Head, path: &str, object: &Map<String, Value>, rows: &mut Vec<Row>) {
        // A nested run has a verdict, a unit or a step of its own.
        let word = |key: &str| object.get(key).and_then(Value::as_str);
        let mut head = head.clone();
        if let Some(verdict) = word("verdict") {
            verdict.clone_into(&mut head.verdict);
        }
        if let Some(step) = object.get("step_s").filter(|step| step.is_number()) {
            head.step = step.to_string();
        }
        if let Some(unit) = word("unit") {
            head.unit = Some(unit.to_owned());
        }
        if let Some(what) = word("what") {
            head.cell += &format!("; {what}");
        }
        for (key, value) in object {
            if !NO_METRIC.contains(&key.as_str()) {
                let metric = join(path, key);
                self.value(&head, &metric, key, value, rows);
            }
        }
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
            _ => unit_of(key),
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
            self.commit.to_owned(),
            self.quick.to_string(),
        ]
    }
}

/// Longer texts are sentences, not names.
const MOST_LETTERS: usize = 80;

/// What the rows of a cell repeat.
#[derive(Clone)]
struct Head {
    cell: String,
    scene: String,
    particles: String,
    stiffness: String,
    method: String,
    settings: String,
    step: String,
    verdict: String,
    unit: Option<String>,
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// Endings of keys with the unit that they mean, longest first.
const UNITS: [(&str, &str); 26] = [
    ("_kg_m2_per_s", "kg m²/s"),
    ("_n_s_per_m3", "N s/m³"),
    ("_n_s_per_m", "N s/m"),
    ("_kg_m_per_s", "kg m/s"),
    ("_kg_per_m2", "kg/m²"),
    ("_m_per_s", "m/s"),
    ("_kg_m2", "kg/m²"),
    ("_n_per_m", "N/m"),
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
    ("_j", "J"),
    ("_n", "N"),
    ("_m", "m"),
    ("_s", "s"),
];

/// The unit that the ending of a key names; empty where it names none.
fn unit_of(key: &str) -> String {
    // `cg_per_step` counts by step, and a plain `bytes` has no prefix.
    let unit = UNITS.iter().find(|(ending, _)| key.ends_with(ending)).map(|(_, unit)| *unit);
    unit.or((key == "bytes").then_some("byte")).unwrap_or_default().to_owned()
}

/// Metrics of tables with their units and the studies that have them: columns `name`, `kind`,
/// `unit`, `meaning`.
pub fn dictionary(rows: &[Row]) -> Vec<[String; 4]> {
    let columns = COLUMNS.iter().map(|(name, unit, meaning)| {
        [(*name).to_owned(), "column".to_owned(), (*unit).to_owned(), (*meaning).to_owned()]
    });
    let mut metrics: BTreeMap<(String, &str), BTreeSet<&str>> = BTreeMap::new();
    for row in rows {
        metrics.entry((pattern(&row[8]), &row[10])).or_default().insert(&row[0]);
    }
    let metrics = metrics.into_iter().map(|((metric, unit), studies)| {
        let list = if metric.contains('#') { "; # is a place in a list, from 0" } else { "" };
        let studies: Vec<_> = studies.into_iter().collect();
        let meaning = format!(
            "key of the records of {}{list}; `drape experiment` and the study's page describe it",
            studies.join(", ")
        );
        [metric, "metric".to_owned(), unit.to_owned(), meaning]
    });
    columns.chain(metrics).collect()
}

/// A metric with `#` for each place in a list.
fn pattern(metric: &str) -> String {
    let part = |part: &str| {
        let is_place = !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
        if is_place { "#".to_owned() } else { part.to_owned() }
    };
    metric.split('.').map(part).collect::<Vec<_>>().join(".")
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::studies;
    use std::path::PathBuf;

    fn results() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../results")
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

    /// Every number that the comparison of facts reads stands in the table, as often as there.
    #[test]
    fn every_comparable_number_of_every_committed_record_has_a_row() {
        let mut compared = 0;
        for study in studies::all() {
            let rows = table(&results(), study.name()).unwrap().unwrap();
            let mut written: BTreeMap<&str, usize> = BTreeMap::new();
            for row in &rows {
                *written.entry(&row[9]).or_default() += 1;
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
        let record = serde_json::json!({
            "format": drape_report::RECORD_FORMAT, "experiment": "sample", "question": "",
            "method": "", "words": { "conclusion": "", "observations": [], "caveats": [] },
            "command": "", "quick": true, "figures": [],
            "facts": {
                "scenes": [{ "id": "soft", "particles": 9, "stiffness_over_mass_per_s2": 1e4 }],
                "runs": [{ "scene": "soft", "label": "x", "method": "imex-euler:start=last",
                    "step_s": 0.01, "verdict": "stable", "path_m": 0.25,
                    "tries": [{ "step_s": 0.02, "verdict": "marginal", "error": 3 }] }],
                "claims": [{ "numbers": [{ "what": "speed", "value": 2.0, "unit": "m/s" }] }]
            },
            "provenance": serde_json::to_value(crate::provenance(
                &crate::Source { commit: Some("abc".to_owned()), dirty: Some(false) },
                BTreeMap::new(),
            )).unwrap()
        });
        let rows = rows(&serde_json::from_value(record).unwrap());
        let row = |metric: &str| {
            let found: Vec<_> = rows.iter().filter(|row| row[8] == metric).collect();
            found.last().copied().cloned().unwrap()
        };
        let path = row("path_m");
        let cell = "runs[0]; label=x";
        let told = ["sample", cell, "soft", "9", "10000.0", "imex-euler", "start=last", "0.01"];
        assert_eq!(path[..8], told.map(str::to_owned));
        let rest = ["path_m", "0.25", "m", "stable", "abc", "true"];
        assert_eq!(path[8..], rest.map(str::to_owned));
        let tried = row("tries.0.error");
        assert_eq!(
            (tried[7].as_str(), tried[11].as_str(), tried[10].as_str()),
            ("0.02", "marginal", "1")
        );
        let speed = row("numbers.0.value");
        assert_eq!((speed[10].as_str(), speed[1].as_str()), ("m/s", "claims[0]; speed"));
        let dictionary = dictionary(&rows);
        assert!(dictionary.iter().any(|line| line[0] == "tries.#.error" && line[1] == "metric"));
        assert_eq!(dictionary.iter().filter(|line| line[1] == "column").count(), COLUMNS.len());
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
            ("iterations", ""),
            ("rises", ""),
        ] {
            assert_eq!(unit_of(key), unit, "{key}");
        }
    }
}
