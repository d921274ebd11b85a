//! The report: one HTML file with all figures, tables and sentences, which needs no other file.

use super::Section;
use super::inline::{inlined, picture, slug, spans_value, verdict};
use crate::{Content, Files, ReportError};
use minijinja::value::{Serde, Value};
use minijinja::{Environment, UndefinedBehavior, context};
use serde::Serialize;
use std::collections::BTreeMap;

const FILE: &str = "report.html";
/// The page and what it is put together from; all but the page itself stand inside it as they are.
const TEMPLATES: [(&str, &str); 4] = [
    (FILE, include_str!("../../templates/report.html")),
    ("section.html", include_str!("../../templates/section.html")),
    ("report.css", include_str!("../../templates/report.css")),
    ("report.js", include_str!("../../templates/report.js")),
];

/// A part of the report. The experiments that it names come in this order; one that names none takes all others.
struct Part {
    title: &'static str,
    experiments: &'static [&'static str],
    /// Whether the first table of a section stands before its findings.
    table_first: bool,
}

const PARTS: [Part; 5] = [
    Part { title: "What it looks like", experiments: &["pictures"], table_first: false },
    Part { title: "The paper’s tables beside ours", experiments: &["tables"], table_first: true },
    Part { title: "What the paper claims", experiments: &["claims"], table_first: true },
    Part { title: "A way through the methods", experiments: &["course"], table_first: false },
    Part { title: "The experiments", experiments: &[], table_first: false },
];

/// Experiments whose sentences are the answer, if they are there, and how many of them.
const ANSWERS: [(&str, usize); 6] = [
    ("work-precision", 2),
    ("locking", 1),
    ("claims", 1),
    ("course", 2),
    ("order", 1),
    ("hard-cases", 1),
];
/// Sentences of the answer at most.
const LONGEST_ANSWER: usize = 4;
/// The figure that stands beside it: the first of these that was drawn, or else the first of all.
const LEADS: [&str; 3] = ["work-precision.svg", "course-motion.svg", "motion-vs-stiffness.svg"];

/// A part with its sections.
#[derive(Serialize)]
struct Chapter<'a> {
    title: &'static str,
    id: String,
    sections: Vec<&'a Section>,
    table_first: bool,
}

fn chapters(sections: &[Section]) -> Vec<Chapter<'_>> {
    let is_named = |section: &Section| {
        PARTS.iter().any(|part| part.experiments.contains(&section.name.as_str()))
    };
    let of_part = |part: &Part| {
        let belongs = |section: &&Section| match part.experiments {
            [] => !is_named(section),
            named => named.contains(&section.name.as_str()),
        };
        let sections: Vec<_> = sections.iter().filter(belongs).collect();
        let id = format!("part-{}", slug(part.title));
        (!sections.is_empty()).then_some(Chapter {
            title: part.title,
            id,
            sections,
            table_first: part.table_first,
        })
    };
    PARTS.iter().filter_map(of_part).collect()
}

/// Sentences of the answer with the sections that they come from.
pub(super) fn answer(sections: &[Section]) -> Vec<(&str, &str)> {
    let named = ANSWERS.iter().filter_map(|(name, most)| {
        Some((sections.iter().find(|section| section.name == *name)?, *most))
    });
    let mut chosen: Vec<_> = named.collect();
    if chosen.is_empty() {
        chosen.extend(sections.iter().map(|section| (section, 1)));
    }
    let sentences = chosen.into_iter().flat_map(|(section, most)| {
        let own = if section.answer.is_empty() { &section.findings } else { &section.answer };
        own.iter().take(most).map(|sentence| (section.name.as_str(), sentence.as_str()))
    });
    sentences.take(LONGEST_ANSWER).collect()
}

/// The figure that stands beside the answer.
fn lead(sections: &[Section]) -> Option<&str> {
    let drawn = || sections.iter().flat_map(|section| &section.figures).map(|f| f.file.as_str());
    let favourite = LEADS.into_iter().find_map(|file| drawn().find(|drawn| *drawn == file));
    favourite.or_else(|| drawn().next())
}

/// The text of the report; `files` holds the drawings.
pub(crate) fn report(sections: &[Section], files: &Files) -> Result<String, ReportError> {
    let drawing = |file: &str, content: &Content| match content {
        Content::Text(svg) => inlined(svg, &slug(file)),
        Content::Png(png) => {
            let mut figures = sections.iter().flat_map(|section| &section.figures);
            let figure = figures.rfind(|figure| figure.file == file);
            let words =
                figure.map_or([""; 2], |figure| [figure.title.as_str(), figure.caption.as_str()]);
            inlined(&picture(png, words), &slug(file))
        }
    };
    let drawings: BTreeMap<&str, String> = files
        .iter()
        .filter_map(|(name, content)| Some((name.strip_prefix("figures/")?, content)))
        .map(|(file, content)| (file, drawing(file, content)))
        .collect();
    let fill = || {
        let mut environment = Environment::new();
        environment.set_undefined_behavior(UndefinedBehavior::Strict);
        environment.add_filter("spans", spans_value);
        environment.add_filter("slug", |name: String| slug(&name));
        environment.add_filter("verdict", verdict);
        for (name, text) in TEMPLATES {
            environment.add_template(name, text)?;
        }
        environment.get_template(FILE)?.render(context! {
            sections => Value::from(Serde(sections)),
            chapters => Value::from(Serde(chapters(sections))),
            answer => Value::from(Serde(answer(sections))),
            lead => lead(sections),
            drawings => Value::from(Serde(&drawings)),
        })
    };
    let page = fill().map_err(|source| ReportError::Page { file: FILE, source })?;
    // What the template's own lines leave behind.
    let lines = page.lines().filter(|line| !line.trim().is_empty());
    Ok(lines.flat_map(|line| [line, "\n"]).collect())
}
