//! The table of `--method auto` and its page follow from the record of the study.

use drape_harness::auto::judge;
use drape_tests::auto::{FILES, summary, written};
use drape_tests::equations::root;

#[test]
fn table_and_page_follow_from_the_record() {
    for (file, text) in FILES.into_iter().zip(written(&root()).expect("the record")) {
        let found = std::fs::read_to_string(root().join(file)).unwrap_or_default();
        assert!(found == text, "{file} is stale: cargo run -p drape-tests --bin auto");
    }
}

/// The aim, on the scenes of the study; and what is left of it on scenes that it does not know.
#[test]
fn the_choice_is_near_the_best_form_on_the_scenes_of_the_study() {
    let record = std::fs::read_to_string(root().join("results/work-precision.json"));
    let record = record.expect("the record");
    let known = summary(&judge(&record, false).expect("cases"));
    assert!(known.cases > 60 && known.median <= 1.2 && known.worst <= 3.0, "{}", known.worst);
    let held_out = summary(&judge(&record, true).expect("cases"));
    assert!(held_out.median <= 1.2, "{}", held_out.median);
    // A rule that knows a scene is not worse there than one that does not.
    assert!(known.nine_of_ten <= held_out.nine_of_ten);
}
