//! The index page, in Markdown: what came out, where the figures are, how to repeat it.

use super::html::answer;
use super::{Outline, Section};
use crate::ReportError;
use minijinja::value::{Serde, Value};
use minijinja::{Environment, UndefinedBehavior, context};

const FILE: &str = "README.md";
const TEMPLATE: &str = include_str!("../../templates/README.md.jinja");

/// The text of the index page.
pub(crate) fn index(sections: &[Section], outline: &Outline) -> Result<String, ReportError> {
    let fill = || {
        let mut environment = Environment::new();
        environment.set_undefined_behavior(UndefinedBehavior::Strict);
        environment.add_filter("line", line);
        environment.add_template(FILE, TEMPLATE)?;
        let answer: Vec<String> = answer(sections, outline)
            .into_iter()
            .map(|(_, sentence)| sentence.to_owned())
            .collect();
        let sections = Value::from(Serde(sections));
        environment.get_template(FILE)?.render(context! { answer, sections })
    };
    let page = fill().map_err(|source| ReportError::Page { file: FILE, source })?;
    Ok(format!("{}\n", page.trim_end()))
}

/// Text that stays inside one item of a list.
fn line(text: String) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
