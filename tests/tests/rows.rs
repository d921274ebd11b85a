//! Every method of the registry has a row in every study that compares all methods.

use drape_report::Record;
use drape_report::file::read_json;
use drape_tests::assert_covers;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// A method that a study leaves out, and why.
type Exception = (&'static str, &'static str);

/// The studies that compare all methods.
const STUDIES: [(&str, &[Exception]); 10] = [
    ("order", &[]),
    ("momentum", &[("rkc", "nothing is damped there, and it refuses springs without damping")]),
    ("stability", &[]),
    ("locking", &[]),
    ("energy", &[]),
    ("hard-cases", &[]),
    ("course", &[]),
    ("work-precision", &[]),
    ("effects", &[]),
    ("scaling", &[]),
];

/// The adaptive method of a library, beside which `work-precision` compares the methods.
const LIBRARY: &str = "dop853";

/// Ids, with settings, of all methods that stand in some facts.
fn methods<'a>(facts: &'a Value, found: &mut BTreeSet<&'a str>) {
    match facts {
        Value::Object(values) => {
            for (key, value) in values {
                match value {
                    Value::String(method) if key == "method" => _ = found.insert(method),
                    _ => methods(value, found),
                }
            }
        }
        Value::Array(values) => values.iter().for_each(|value| methods(value, found)),
        _ => {}
    }
}

#[test]
fn every_method_has_a_row_in_every_study_that_compares_all() {
    for (study, exceptions) in STUDIES {
        let path = format!("{}/../results/{study}.json", env!("CARGO_MANIFEST_DIR"));
        let record: Record<Value> = read_json(Path::new(&path)).expect("a committed record");
        let mut found = BTreeSet::new();
        methods(&record.facts, &mut found);
        // Where a record has labels for ids, the form follows in brackets.
        let ids = found.into_iter().filter_map(|method| method.split(' ').next());
        let ours = ids.filter(|method| *method != LIBRARY);
        assert_covers(study, ours, exceptions);
    }
}
