//! Every method of the registry has a row in every study that compares all methods.

use drape_report::Record;
use drape_report::file::read_json;
use drape_tests::{assert_covers, name};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A method that a study leaves out, and why.
type Exception = (&'static str, &'static str);

/// A study that compares all methods, and the list of its facts that has a row for each.
type Study = (&'static str, &'static str, &'static [Exception]);

const STUDIES: [Study; 13] = [
    ("order", "rows", &[]),
    ("momentum", "rows", &[("rkc", "nothing is damped there, and it refuses such springs")]),
    ("stability", "cells", &[]),
    ("stability", "limits", &[]),
    ("locking", "runs", &[]),
    ("energy", "rows", &[]),
    ("hard-cases", "cells", &[]),
    ("work-precision", "rows", &[]),
    ("trajectory", "rows", &[]),
    ("animation", "runs", &[("energy-momentum", OF_FABRICS)]),
    ("rest", "runs", &[]),
    ("effects", "cells", &[]),
    ("scaling", "cells", &[]),
];

/// A part of a scene's key, and the methods that refuse such scenes.
type Refusal = (&'static str, &'static [&'static str]);

const OF_FABRICS: &str = "it refuses the bending and the damping that every fabric has";

/// Studies each of whose scenes has a row of every method, and what refuses the scenes whose keys
/// hold a part.
const SCENES: [(&str, &str, &[Refusal]); 3] = [
    (
        "animation",
        "runs",
        &[
            ("", &["energy-momentum"]),
            ("flag", &["srkn4"]),
            ("led", &["exponential", "imex-rk", "rosenbrock", "srkn4"]),
            ("on a ball", &["exponential", "imex-cnlf", "imex-rk", "rosenbrock", "srkn4"]),
        ],
    ),
    ("rest", "runs", &[("round table", &["energy-momentum", "srkn4"])]),
    // A row without runs is no row there: what refuses a sheet is absent.
    ("trajectory", "rows", &[("d/m = 0", &["rkc"])]),
];

/// The adaptive method of the references, beside which `work-precision` compares the methods.
const DOP853: &str = "dop853";

/// The rows of a list of a committed record.
fn rows(study: &str, list: &str) -> Vec<Value> {
    let path = format!("{}/../results/{study}.json", env!("CARGO_MANIFEST_DIR"));
    let record: Record<Value> = read_json(Path::new(&path)).expect("a committed record");
    let rows = record.facts[list].as_array().cloned();
    rows.unwrap_or_else(|| panic!("{study}: no list {list}"))
}

/// The id of a row's method, and whether the method ran: a refusal is no run.
fn run(row: &Value) -> (&str, bool) {
    let method = row["method"].as_str().expect("a method");
    // Where a record has labels for ids, the form follows in brackets.
    let id = method.split(' ').next().unwrap_or(method);
    (name(id), !["refused", "not applicable"].iter().any(|verdict| row["verdict"] == *verdict))
}

#[test]
fn every_method_has_a_row_in_every_study_that_compares_all() {
    for (study, list, exceptions) in STUDIES {
        let rows = rows(study, list);
        let ran = rows.iter().map(run).filter(|(id, has_run)| *has_run && *id != DOP853);
        assert_covers(study, ran.map(|(id, _)| id), exceptions);
    }
}

/// The course runs a choice of methods, and tells of all what they support.
#[test]
fn the_course_tells_of_every_method_what_it_supports() {
    assert_covers("course", rows("course", "support").iter().map(|row| run(row).0), &[]);
}

#[test]
fn every_scene_has_every_method_but_those_that_refuse_it() {
    for (study, list, refusals) in SCENES {
        let rows = rows(study, list);
        let scene = |row: &Value| row["scene"].as_str().expect("a scene").to_owned();
        for place in rows.iter().map(scene).collect::<BTreeSet<_>>() {
            let own = rows.iter().filter(|row| scene(row) == place).map(run);
            let ran = own.filter(|(id, has_run)| *has_run && *id != DOP853).map(|(id, _)| id);
            let is_meant = |part: &str| match part.split_once(" = ") {
                // A number that begins another is not that number.
                Some(_) => place.ends_with(part),
                None => place.contains(part),
            };
            let meant = refusals.iter().filter(|(part, _)| is_meant(part));
            let refusing = meant.flat_map(|(_, ids)| ids.iter());
            let exceptions: Vec<Exception> = refusing.map(|id| (*id, "it refuses")).collect();
            assert_covers(&format!("{study}, {place}"), ran, &exceptions);
        }
    }
}

/// Most forms in which a comparison may run a method. Few methods use a fourth of them.
const MOST_FORMS: usize = 24;

#[test]
fn no_method_is_compared_in_more_forms_than_the_budget() {
    let mut most = 0;
    for (study, list) in [
        ("work-precision", "rows"),
        ("trajectory", "rows"),
        ("animation", "runs"),
        ("rest", "runs"),
    ] {
        let mut forms = BTreeMap::<String, BTreeSet<String>>::new();
        for row in rows(study, list) {
            let form = [&row["method"], &row["label"]].map(Value::to_string).join(" ");
            forms.entry(run(&row).0.to_owned()).or_default().insert(form);
        }
        for (method, forms) in forms {
            most = most.max(forms.len());
            assert!(forms.len() <= MOST_FORMS, "{study}: {method} has {} forms", forms.len());
        }
    }
    assert!(most > 3, "no forms were counted");
}
