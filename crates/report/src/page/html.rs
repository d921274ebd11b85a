//! The report: one HTML file with all figures, tables and sentences, which needs no other file.

use super::inline::{inlined, picture, slug, spans_value, verdict};
use super::{Head, Outline, Part, Section, Table};
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

/// The head of the report of all studies.
pub(crate) const ALL: Head<'static> = Head {
    title: "Time integrators for cloth, compared",
    lead: "Mass-spring cloth is stiff: what holds it together breaks simple methods of moving it in \
           time. This report puts the methods that were proposed since 1987 on one and the same \
           cloth and measures what each keeps, what it loses and what it costs.",
};

/// A part with its sections.
#[derive(Serialize)]
struct Chapter<'a> {
    title: &'static str,
    id: String,
    sections: Vec<&'a Section>,
    table_first: bool,
}

fn chapters<'a>(sections: &'a [Section], outline: &Outline) -> Vec<Chapter<'a>> {
    let is_named = |section: &Section| {
        outline.parts.iter().any(|part| part.studies.contains(&section.name.as_str()))
    };
    let of_part = |part: &Part| {
        let belongs = |section: &&Section| match part.studies {
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
    outline.parts.iter().filter_map(of_part).collect()
}

/// Conclusions that answer the reader's question, with the sections that they come from.
pub(super) fn answer<'a>(sections: &'a [Section], outline: &Outline) -> Vec<(&'a str, &'a str)> {
    let find = |name: &&str| sections.iter().find(|section| section.name == *name);
    let mut chosen: Vec<_> = outline.answers.iter().filter_map(find).collect();
    if chosen.is_empty() {
        chosen.extend(sections);
    }
    let pair = |section: &'a Section| (section.name.as_str(), section.words.conclusion.as_str());
    let said = chosen.into_iter().map(pair).filter(|(_, conclusion)| !conclusion.is_empty());
    said.take(outline.longest_answer).collect()
}

/// The figures that stand beside the answer.
fn leads<'a>(sections: &'a [Section], outline: &Outline) -> Vec<&'a str> {
    let drawn = || sections.iter().flat_map(|section| &section.figures).map(|f| f.file.as_str());
    let of_group =
        |group: &&[&str]| -> Vec<&str> { drawn().filter(|file| group.contains(file)).collect() };
    let mut groups = outline.leads.iter().map(of_group);
    groups.find(|group| !group.is_empty()).unwrap_or_else(|| drawn().take(1).collect())
}

/// The text of a report below its head; `first` stands beside the answer, `files` holds the drawings.
pub(crate) fn report(
    sections: &[Section],
    outline: &Outline,
    (head, first): (Head<'_>, Option<&Table>),
    files: &Files,
) -> Result<String, ReportError> {
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
            head => Value::from(Serde(head)),
            sections => Value::from(Serde(sections)),
            chapters => Value::from(Serde(chapters(sections, outline))),
            answer => Value::from(Serde(answer(sections, outline))),
            leads => Value::from(Serde(leads(sections, outline))),
            first => Value::from(Serde(first)),
            drawings => Value::from(Serde(&drawings)),
        })
    };
    let page = fill().map_err(|source| ReportError::Page { file: FILE, source })?;
    // What the template's own lines leave behind.
    let lines = page.lines().filter(|line| !line.trim().is_empty());
    Ok(lines.flat_map(|line| [line, "\n"]).collect())
}
