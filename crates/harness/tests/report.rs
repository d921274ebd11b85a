//! The report as a document: what a parser for HTML5 makes of it.

#![allow(clippy::unwrap_used)]

use crate::common;

use drape_harness::studies::draw;
use drape_harness::studies::uses::{Use, all_uses};
use scraper::{ElementRef, Html, Selector};
use std::collections::BTreeSet;
use std::path::Path;

fn report(results: &Path) -> String {
    draw(results).unwrap();
    std::fs::read_to_string(results.join("report.html")).unwrap()
}

fn all<'a>(document: &'a Html, css: &str) -> Vec<ElementRef<'a>> {
    document.select(&Selector::parse(css).unwrap()).collect()
}

fn text(element: ElementRef<'_>) -> String {
    element.text().collect::<String>().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What holds for every report, whatever stands in the records.
fn check(results: &Path) {
    let page = report(results);
    let document = Html::parse_document(&page);
    assert!(document.errors.is_empty(), "{:?}", document.errors);

    let mut ids = BTreeSet::new();
    for element in all(&document, "[id]") {
        let id = element.attr("id").unwrap();
        assert!(ids.insert(id), "id `{id}` is there twice");
        assert!(!id.is_empty() && !id.contains(char::is_whitespace), "`{id}`");
    }
    for link in all(&document, "[href]") {
        let target = link.attr("href").unwrap();
        let is_inside = target.strip_prefix('#').is_some_and(|id| ids.contains(id));
        let is_picture = target.starts_with("data:image/png;base64,");
        assert!(is_inside || is_picture || target == "data:,", "`{target}` leads nowhere");
    }
    for named in all(&document, "[aria-labelledby]") {
        let names = named.attr("aria-labelledby").unwrap();
        assert!(names.split(' ').all(|id| ids.contains(id)), "nothing is called `{names}`");
    }
    assert!(
        all(&document, "[src], [srcset], base, iframe, object, embed, link[rel=stylesheet]")
            .is_empty()
    );
    for address in ["http:", "https:", "url(", "@import", "//cdn"] {
        assert!(!page.contains(address), "the page names {address}");
    }

    let drawn = std::fs::read_dir(results.join("figures")).map_or(0, Iterator::count);
    let figures = all(&document, "main figure");
    assert_eq!(figures.len(), drawn, "every figure stands in the page once");
    for figure in figures {
        assert_eq!(figure.select(&Selector::parse("svg[role=img] > title").unwrap()).count(), 1);
        assert_eq!(figure.select(&Selector::parse("figcaption").unwrap()).count(), 1);
    }
    for table in all(&document, "table") {
        let columns = table.select(&Selector::parse("thead th").unwrap()).count();
        for row in table.select(&Selector::parse("tbody tr").unwrap()) {
            assert_eq!(
                row.select(&Selector::parse("td").unwrap()).count(),
                columns,
                "{}",
                text(row)
            );
        }
    }
    for cell in all(&document, "td, dd, li, p") {
        let text = text(cell);
        assert!(!text.contains("NaN") && !text.contains("**"), "{text}");
    }
}

#[test]
fn the_report_of_complete_records_holds_together() {
    check(common::complete().path());
}

#[test]
fn the_report_of_the_committed_records_holds_together() {
    check(common::copy_of_committed().path());
}

#[test]
fn the_report_of_one_record_holds_together() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("momentum.json");
    drape_report::file::write_json(&path, &common::momentum(true)).unwrap();
    check(folder.path());
}

#[test]
fn what_records_say_is_text_and_never_markup() {
    let folder = tempfile::tempdir().unwrap();
    let mut record = common::momentum(true);
    let nasty = "<script>alert(1)</script> & \"<b>\" 'x'";
    record.question = nasty.to_owned();
    record.method = format!("`{nasty}`");
    record.words.observations = vec![format!("**{nasty}**")];
    record.command = nasty.to_owned();
    record.provenance.cpu = nasty.to_owned();
    for row in &mut record.facts.rows {
        row.label = format!("{nasty} {}", row.label);
    }
    drape_report::file::write_json(&folder.path().join("momentum.json"), &record).unwrap();
    check(folder.path());
    let page = report(folder.path());
    let document = Html::parse_document(&page);
    assert_eq!(all(&document, "script").len(), 1);
    assert!(all(&document, "b").is_empty());
    assert_eq!(text(all(&document, ".observations li")[0]), nasty);
    assert!(text(all(&document, "article h3")[0]).ends_with(nasty));
}

/// The figure that a claim's verdict points at is one that is drawn.
#[test]
fn every_claim_points_at_a_figure_of_the_results() {
    let path = common::committed().join("claims.json");
    let record: drape_report::Record<drape_harness::studies::claims::facts::Facts> =
        drape_report::file::read_json(&path).unwrap();
    assert!(record.facts.claims.len() == drape_harness::claims::all().len() && !record.quick);
    for row in &record.facts.claims {
        let claim = drape_harness::claims::find(&row.id).unwrap();
        let figure = common::committed().join("figures").join(claim.see);
        assert!(figure.exists(), "{}: {}", claim.id, claim.see);
    }
}

#[test]
fn the_five_uses_stand_beside_the_answer_where_their_records_are_there() {
    let rows = |results: &Path| -> Vec<String> {
        let page = report(results);
        let document = Html::parse_document(&page);
        all(&document, "#answer tbody tr").into_iter().map(text).collect()
    };
    let shown = rows(common::copy_of_committed().path());
    let uses = all_uses(common::committed()).unwrap();
    assert_eq!(shown.len(), uses.len());
    // Cloth that buckles into one of several shapes ranks nothing.
    let laid = &uses[2];
    assert!(laid.why.contains("Not counted: round table, ponte, 8 squares"), "{laid:?}");
    assert!(laid.measured.contains("cloth of 137 particles on 2 round tables"), "{laid:?}");
    for (row, answer) in shown.iter().zip(uses) {
        let Use { what, take, measured, bundled, why } = answer;
        for said in [what, &take, &measured, &bundled, &why] {
            assert!(row.contains(&said.replace('`', "")), "{said}: {row}");
        }
    }
    assert!(rows(common::complete().path()).is_empty(), "no scene runs at the rate of a film");
}

#[test]
fn the_answer_stands_first_and_the_provenance_last() {
    let page = report(common::complete().path());
    let document = Html::parse_document(&page);
    let headings: Vec<_> = all(&document, "main h2").into_iter().map(text).collect();
    assert_eq!(
        headings,
        [
            "The answer first",
            "The paper’s tables beside ours",
            "Claims of the paper, and expectations",
            "A way through the methods",
            "The experiments",
            "Where the numbers come from",
        ]
    );
    let answer = text(all(&document, ".answer")[0]);
    assert!(answer.starts_with("The conclusion of animation. animation"), "{answer}");
    assert!(answer.contains("The conclusion of claims."), "{answer}");
    let leads = all(&document, "#answer figure").into_iter().map(|figure| figure.attr("id"));
    let leads: Vec<_> = leads.flatten().collect();
    assert_eq!(leads, ["figure-animation-frames", "figure-animation-map"]);
    let lessons: Vec<_> = all(&document, ".lesson h4").into_iter().map(text).collect();
    assert_eq!(lessons[1], "2 leapfrog <by name> & more");
    assert_eq!(all(&document, ".lesson figure").len(), 3);
    assert!(
        text(all(&document, ".lesson")[2]).contains("drape run soft --method provot --dt 0.01")
    );
    // Each lesson shows the method's equations and code as they stand in its crate.
    for (lesson, id) in
        all(&document, ".lesson").into_iter().zip(["explicit-euler", "leapfrog", "provot"])
    {
        let (_, known) = drape_harness::lessons::find(id).unwrap();
        let shown: Vec<_> = lesson
            .select(&Selector::parse("pre").unwrap())
            .map(|pre| pre.text().collect::<String>())
            .collect();
        let lines = |text: &str| {
            let filled = text.lines().filter(|line| !line.trim().is_empty());
            filled.map(str::to_owned).collect::<Vec<_>>()
        };
        let expected = [known.equation().unwrap(), known.code().unwrap()];
        assert_eq!(shown.len(), 2, "{id}");
        for (shown, expected) in shown.iter().zip(&expected) {
            assert_eq!(lines(shown), lines(expected), "{id}");
        }
        let cells = Selector::parse(".factors td.n").unwrap();
        let factors: Vec<_> = lesson.select(&cells).map(text).collect();
        assert_eq!(factors.len(), 11, "{id}");
        // Within its limit Provot's method, symplectic Euler, keeps the amplitude.
        let different: BTreeSet<_> = factors.iter().collect();
        assert_eq!(different.len() > 1, id != "provot", "{id}: {factors:?}");
        let redraw = format!("draws figures/course-{id}.svg");
        let said = text(lesson);
        assert!(said.contains("drape experiment course") && said.contains(&redraw), "{said}");
    }
    let known = all(&document, "td.v.bad").into_iter().map(text).collect::<BTreeSet<_>>();
    assert!(known.contains("diverged") && known.contains("unstable"), "{known:?}");
    let provenance = text(all(&document, "#provenance")[0]);
    for words in
        ["0123456789abcdef, with uncommitted changes", "A | processor", "timings/tables.json"]
    {
        assert!(provenance.contains(words), "{words}: {provenance}");
    }
}
