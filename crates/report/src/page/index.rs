//! The index page, in Markdown: what came out, where the figures are, how to repeat it.

use super::html::answer;
use super::inline::spans;
use super::{Outline, Section};
use crate::{ReportError, printable};
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
        environment.add_filter("plain", plain);
        environment.add_filter("code", code);
        environment.add_template(FILE, TEMPLATE)?;
        let answer = Value::from(Serde(answer(sections, outline)));
        let sections = Value::from(Serde(sections));
        environment.get_template(FILE)?.render(context! { answer, sections })
    };
    let page = fill().map_err(|source| ReportError::Page { file: FILE, source })?;
    Ok(format!("{}\n", page.trim_end()))
}

fn one_line(text: &str) -> String {
    printable(&text.split_whitespace().collect::<Vec<_>>().join(" ")).into_owned()
}

/// A sentence, with marks for `**strong**` and `` `code` ``, that stays inside one item of a list.
fn line(text: String) -> String {
    let text = one_line(&text);
    let (mut page, mut before) = (String::new(), None);
    for span in spans(&text) {
        page += &match span.kind {
            "code" => format!("`{}`", span.text),
            "strong" => format!("**{}**", escaped(&span.text, Some('*'))),
            _ => escaped(&span.text, before),
        };
        before = span.text.chars().last();
    }
    page
}

/// Text without marks.
fn plain(text: String) -> String {
    escaped(&one_line(&text), None)
}

/// Text as code.
fn code(text: String) -> String {
    let text = one_line(&text);
    let longest = text.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    let fence = "`".repeat(longest + 1);
    let space = if longest > 0 { " " } else { "" };
    format!("{fence}{space}{text}{space}{fence}")
}

/// Escapes what Markdown and HTML would take for a mark. `before` is the character in front of the
/// text, `None` at the start of a line.
fn escaped(text: &str, before: Option<char>) -> String {
    let mut page = String::new();
    let mut last = before;
    let mut characters = text.chars().peekable();
    // Numbers with a dot or a parenthesis begin a list.
    let mut is_number = before.is_none();
    while let Some(c) = characters.next() {
        let next = characters.peek().copied();
        let is_inside = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
        let is_mark = match c {
            '\\' | '`' | '*' | '[' | ']' | '~' => true,
            // The names of quantities, such as v_n, are no emphasis.
            '_' => !(is_inside(last) && is_inside(next)),
            '#' | '>' | '+' | '-' | '=' | '|' => last.is_none(),
            '.' | ')' => is_number && last.is_some() && !is_inside(next),
            _ => false,
        };
        is_number &= c.is_ascii_digit();
        match c {
            '<' => page += "&lt;",
            '&' => page += "&amp;",
            c if is_mark => page.extend(['\\', c]),
            c => page.push(c),
        }
        last = Some(c);
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_sentences_cannot_become_marks_of_the_page() {
        let cases = [
            ("<img src=x onerror=alert(1)>", "&lt;img src=x onerror=alert(1)>"),
            ("[x](javascript:y)", r"\[x\](javascript:y)"),
            ("a\n\n# b &amp; c", "a # b &amp;amp; c"),
            ("# b", r"\# b"),
            ("12. b 3. c", r"12\. b 3. c"),
            ("1.5 m of E_ref, _b_ and v_n", r"1.5 m of E_ref, \_b\_ and v_n"),
            ("2 * 3 `x", r"2 \* 3 \`x"),
            ("a \u{1b}[31m", r"a \\u{1b}\[31m"),
        ];
        for (text, expected) in cases {
            assert_eq!(plain(text.to_owned()), expected);
            assert_eq!(line(text.to_owned()), expected, "no span in it");
        }
        let text = "**Bold <b>** and `a<b>`, *x*.";
        assert_eq!(line(text.to_owned()), r"**Bold &lt;b>** and `a<b>`, \*x\*.");
        assert_eq!(code("drape `x``y`".to_owned()), "``` drape `x``y` ```");
        assert_eq!(code("drape\nrun".to_owned()), "`drape run`");
    }
}
